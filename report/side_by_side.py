"""Recording | twin | difference: pictures of both sides as the measuring code sees
them, and their curves over each other."""

import base64

from benchtwin.report import draw
from benchtwin.report.residuals import binned
from benchtwin.twin.pair import Pair


def panels(pairs: list[Pair]) -> list[dict]:
    """What the page shows of each: rig, recording, titles and pictures as data,
    figure's key."""
    return [
        {
            "rig": p.rig,
            "recording": p.recording,
            "key": f"pair-{p.rig}",
            "pictures": [
                (title, base64.b64encode(png).decode())
                for title, png in zip(
                    (f"recorded: {p.recording}", "the twin"), p.pictures, strict=True
                )
                if png
            ],
        }
        for p in pairs
    ]


def figure(p: Pair) -> dict:
    """Both curves above, twin minus recording below. Plain Plotly JSON."""
    x, bench = binned(p.x, p.bench)
    _, twin = binned(p.x, p.twin)
    _, off = binned(p.x, p.twin - p.bench)
    data = [
        draw.line(x, bench, "#1b1f24", "recorded"),
        draw.line(x, twin, draw.ORANGE, "twin", dash="dash"),
        draw.line(x, off, draw.BLUE, "") | {"yaxis": "y2"},
    ]
    layout = draw.layout(p.x_name, p.y_name) | {"height": 460}
    layout["yaxis"] |= {"domain": [0.42, 1.0]}
    layout["yaxis2"] = {"title": {"text": "difference"}, "domain": [0.0, 0.3]}
    layout["xaxis"] |= {"anchor": "y2"}
    return {"data": data, "layout": layout}
