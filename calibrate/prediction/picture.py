"""A prediction as an SVG that needs nothing beside it: a row a quantity, its runs,
intervals, and what was measured."""

from html import escape

import numpy as np

from benchtwin.calibrate.prediction.beside import Comparison, Measured
from benchtwin.calibrate.prediction.predict import DRAWN, QUANTITIES, Prediction, sign

# px: the picture, what names and ends need beside the axis, a quantity, the title
WIDTH, LEFT, RIGHT, ROW, TOP = 760, 150, 20, 110, 40
BLUE, LIGHT, GREY, RED = "#1f5fa8", "#c7d9f0", "#9ca3af", "#b3261e"
KEY = (
    "Grey: runs at drawn parameters. Light: 95 % of single packings; dark: of their"
    " mean."
)
RED_KEY = " Red: recordings, and their mean."
STYLE = "font-family:system-ui,sans-serif;font-size:13px;fill:#222"


def picture(
    found: Prediction,
    seen: Measured | None = None,
    compared: list[Comparison] | None = None,
) -> str:
    """Blue bar: 95 % of single packings; dark part: of the mean over packings; dots:
    runs; red: recordings and their mean."""
    said = [c.said for c in compared or []]
    height = TOP + ROW * len(found.of) + 22 * len(said) + 40
    size, title = f"0 0 {WIDTH} {height}", f"Predicted {escape(found.rig)}"
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{size}" style="{STYLE}">',
        f'<rect width="{WIDTH}" height="{height}" fill="white"/>',
        f'<text x="12" y="24" style="font-size:16px">{title}</text>',
    ]
    for k, quantity in enumerate(found.of):
        red = np.zeros(0) if seen is None else seen.values[quantity]
        parts += _row(found, quantity, TOP + ROW * k, red)
    below, key = TOP + ROW * len(found.of), KEY if seen is None else KEY + RED_KEY
    for k, line in enumerate([key, *said]):
        parts.append(f'<text x="12" y="{below + 20 + 22 * k}">{escape(line)}</text>')
    return "\n".join([*parts, "</svg>"]) + "\n"


def _row(found: Prediction, quantity: str, top: float, red: np.ndarray) -> list[str]:
    p = found.of[quantity]
    one, many = p.half_width(), p.half_width(np.inf)
    runs = found.runs.loc[found.runs["kind"] == DRAWN, quantity].dropna().to_numpy()
    shown = np.concatenate([runs, [p.mean - one, p.mean + one], red])
    step = _step(np.ptp(shown) / 8)
    low, high = np.floor(shown.min() / step) * step, np.ceil(shown.max() / step) * step

    def x(value: float) -> float:
        return round(LEFT + (WIDTH - LEFT - RIGHT) * (value - low) / (high - low), 1)

    def bar(half: float, colour: str) -> str:
        left, width = x(p.mean - half), x(p.mean + half) - x(p.mean - half)
        return (
            f'<rect x="{left}" y="{top + 40}" width="{width:.1f}" height="14"'
            f' fill="{colour}"/>'
        )

    def dot(value: float, y: float, look: str) -> str:
        return f'<circle cx="{x(value)}" cy="{y}" r="3.5" {look}/>'

    def upright(value: float, first: float, last: float, look: str) -> str:
        return (
            f'<line x1="{x(value)}" x2="{x(value)}" y1="{first}" y2="{last}"'
            f" stroke={look}/>"
        )

    name, axis = QUANTITIES[found.rig][quantity], top + 76
    parts = [f'<text x="12" y="{top + 52}">{name} ({sign(quantity).strip()})</text>']
    parts += [bar(one, LIGHT), bar(many, BLUE)]
    parts += [dot(v, top + 28, f'fill="{GREY}"') for v in runs]
    parts.append(upright(p.mean, top + 36, top + 58, '"#111" stroke-width="2"'))
    parts += [dot(v, top + 66, f'fill="none" stroke="{RED}"') for v in red]
    if red.size:
        look = f'"{RED}" stroke-width="2"'
        parts.append(upright(float(red.mean()), top + 36, top + 72, look))
    for value in np.arange(low, high + step / 2, step):
        parts.append(upright(value, axis, axis + 5, '"#222"'))
        parts.append(
            f'<text x="{x(value)}" y="{axis + 20}"'
            f' text-anchor="middle">{value:.4g}</text>'
        )
    ends = f'x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{axis}" y2="{axis}"'
    return [*parts, f'<line {ends} stroke="#222"/>']


def _step(least: float) -> float:
    """1, 2 or 5 times a power of ten, `least` or above."""
    power = 10.0 ** np.floor(np.log10(max(least, 1e-6)))
    return float(next(f * power for f in (1, 2, 5, 10) if f * power >= least))
