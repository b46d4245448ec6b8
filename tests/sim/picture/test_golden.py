"""Masks against stored ones, made with the same renderer and version; elsewhere the
closed forms of test_outline must do.

python tests/sim/picture/test_golden.py

That makes the stored masks anew: look at them before you commit them.
"""

import json
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

ROOT = Path(__file__).parents[3]
GOLDEN = ROOT / "tests" / "golden"
sys.path[:0] = [str(ROOT), str(Path(__file__).parent)]

from picture_scenes import drop, heap, slide  # noqa: E402

from benchtwin.sim.picture import Camera, coverage, renderer_name  # noqa: E402

SCENES = {
    "heap": (
        lambda: heap(300, 28.0),
        Camera(640, 320, mm_per_px=0.3, target_m=(0.0, 0.0, 0.02), roll_deg=1.5),
    ),
    "drop": (
        drop,
        Camera(320, 200, mm_per_px=1.0, target_m=(0.0, 0.0, 0.09), distortion=-0.04),
    ),
    "slide": (slide, Camera(400, 240, mm_per_px=0.7, target_m=(0.12, 0.0, 0.05))),
}


def mask(name: str) -> np.ndarray:
    scene, camera = SCENES[name]
    return coverage(scene(), camera) > 0.5


def overlap(one: np.ndarray, other: np.ndarray) -> float:
    """Intersection over union."""
    return (one & other).sum() / max((one | other).sum(), 1)


@pytest.mark.usefixtures("egl")
@pytest.mark.parametrize("name", SCENES)
def test_masks_are_as_stored(name):
    made_with = json.loads((GOLDEN / "renderer.json").read_text(encoding="utf8"))[
        "renderer"
    ]
    if renderer_name() != made_with:
        pytest.skip(
            f"the stored masks were made with {made_with}, this is {renderer_name()}"
        )
    stored = cv2.imread(str(GOLDEN / f"{name}.png"), cv2.IMREAD_GRAYSCALE) > 127
    assert overlap(mask(name), stored) >= 0.995
    assert (
        overlap(np.roll(stored, 1, axis=0), stored) < 0.995
    )  # a shift of one pixel would be seen


if __name__ == "__main__":
    GOLDEN.mkdir(exist_ok=True)
    for scene in SCENES:
        cv2.imwrite(str(GOLDEN / f"{scene}.png"), mask(scene).astype(np.uint8) * 255)
    (GOLDEN / "renderer.json").write_text(
        json.dumps({"renderer": renderer_name()}, indent=1) + "\n", encoding="utf8"
    )
