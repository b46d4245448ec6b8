"""What the tests of drops share: a recording as a bench states it, and its quantities
by name."""

from pathlib import Path

from benchtwin.rigs.drop.keys import Drop
from benchtwin.vision.recording import Air, Camera, Recording, Seed

CAMERA = {"fps": 5200, "mm_per_px": 0.25, "mm_per_px_sd": 0.0002}


def drop(height=310.0, seed=None, density=0.0, **camera) -> Recording:
    return Recording(
        "d",
        Path("d"),
        "drop",
        "track.csv",
        (),
        camera=Camera(**(camera or CAMERA)),
        air=Air(density_kg_m3=density),
        drop=Drop(height_mm=height),
        seed=seed or Seed(),
    )


def named(result):
    return {q.name: q for q in result.quantities}
