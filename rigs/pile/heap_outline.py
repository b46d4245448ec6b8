"""Heaps of the twin without a picture: their outline, seen as a photo shows it."""

from dataclasses import replace

import numpy as np

from benchtwin.rigs.pile.read import SeenPile, describe
from benchtwin.sim.motion import Motion
from benchtwin.sim.rigs.profile import outline
from benchtwin.vision.pile.heap import TOE
from benchtwin.vision.recording import Recording

STEP_MM = 0.1


def outlined(motion: Motion, recording: Recording) -> SeenPile:
    """The outline as a photo at the plate's height has it: plate level, plumb line
    known."""
    two = recording.pile.cylinder_mm is not None
    places = 1e3 * motion.positions_m[-1, :, 0]
    x = np.arange(
        np.nanmin(places) - 12 if two else 0.0, np.nanmax(places) + 12, STEP_MM
    )
    z = 1e3 * outline(motion, 1e-3 * x)
    low, crest = np.flatnonzero(z < TOE * z.max()), int(z.argmax())
    right = float(x[min(low[low > crest], default=len(x) - 1)])
    left = float(x[max(low[low < crest], default=0)]) if two else None
    seen = SeenPile(
        "twin",
        "",
        x,
        z,
        "mm",
        0.0,
        0.0,
        0.02,
        "plate",
        float(x[crest]),
        (left, right),
        describe(recording),
    )
    level = seen.description | {"camera": {"plumb_deg": 0.0, "plumb_sd_deg": 0.05}}
    return replace(seen, description=level)
