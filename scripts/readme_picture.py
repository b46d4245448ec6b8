"""The README's picture, from the reports that `make demo` leaves.

python scripts/readme_picture.py [DEMO [PICTURE]]      → docs/bench-twin.png
"""

import argparse
import base64
import io
import json
import re
from pathlib import Path

import cv2
import numpy as np
from PIL import Image

WIDE, GAP, BAND = 600, 14, 30  # px: of a column, between the two, of a title


def pictures(report: Path) -> list[tuple[str, np.ndarray]]:
    """What a report shows as (its alternative text, picture), in order."""
    found = re.findall(
        r'<img src="data:image/png;base64,([^"]+)" alt="([^"]*)"',
        report.read_text(encoding="utf8"),
    )
    return [
        (
            said,
            np.asarray(Image.open(io.BytesIO(base64.b64decode(png))).convert("RGB"))[
                ..., ::-1
            ],
        )
        for png, said in found
    ]


def titled(title: str, picture: np.ndarray) -> np.ndarray:
    """As wide as a column, below its title."""
    band = np.full((BAND, WIDE, 3), 255, np.uint8)
    plain = title.replace("°", " deg")  # OpenCV's letters have no degree sign
    cv2.putText(
        band,
        plain,
        (4, 21),
        cv2.FONT_HERSHEY_SIMPLEX,
        0.55,
        (30, 30, 30),
        1,
        cv2.LINE_AA,
    )
    high = round(WIDE * picture.shape[0] / picture.shape[1])
    return np.vstack(
        [band, cv2.resize(picture, (WIDE, high), interpolation=cv2.INTER_AREA)]
    )


def composed(demo: Path) -> np.ndarray:
    """Left a pile and its twin; right what was found missing in the rolls, and a drop.
    Raises FileNotFoundError, ValueError."""
    calibrated, diagnosed = (
        pictures(demo / "calibrated" / "report.html"),
        pictures(demo / "diagnosed" / "report.html"),
    )
    roll = json.loads(
        (demo / "diagnosed" / "diagnosis.json").read_text(encoding="utf8")
    )["rigs"]["roll"]
    at = {
        rig: [
            k
            for k, (said, _) in enumerate(calibrated)
            if said.startswith(f"recorded: {rig}")
        ]
        for rig in ("pile", "drop")
    }
    if not (at["pile"] and at["drop"] and diagnosed and roll.get("twin")):
        raise ValueError(
            f"{demo}: its reports show no pile, no drop or no roll that was run again"
        )
    pile, drop = at["pile"][0], at["drop"][0]
    columns = [
        [
            titled("recorded at the bench, measured", calibrated[pile][1]),
            titled(
                "the twin, calibrated on it, measured by the same code",
                calibrated[pile + 1][1],
            ),
        ],
        [
            titled(
                f"diagnosed on its rolls: {roll['twin']['change']}", diagnosed[0][1]
            ),
            titled("a drop at the same bench, measured", calibrated[drop][1]),
        ],
    ]
    stacked = [np.vstack(column) for column in columns]
    high = max(len(column) for column in stacked)
    left, right = (
        cv2.copyMakeBorder(
            c, 0, high - len(c), 0, 0, cv2.BORDER_CONSTANT, value=(255, 255, 255)
        )
        for c in stacked
    )
    return np.hstack([left, np.full((high, GAP, 3), 255, np.uint8), right])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("demo", type=Path, nargs="?", default=Path("demo-out"))
    parser.add_argument(
        "picture", type=Path, nargs="?", default=Path("docs/bench-twin.png")
    )
    asked = parser.parse_args()
    try:
        cv2.imwrite(str(asked.picture), composed(asked.demo))
    except (FileNotFoundError, ValueError) as error:
        parser.error(f"{error}; `make demo` makes it")
