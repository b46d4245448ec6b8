"""Heaps of the twin without a picture: their outline, seen as a photo shows it."""

from dataclasses import replace

import numpy as np

from benchtwin.rigs.pile.read import SeenPile, describe
from benchtwin.sim.motion import Motion
from benchtwin.sim.rigs.profile import balls, outline, upper_edge
from benchtwin.vision.pile.collapse import (
    HEIGHTS,
    LAYER,
    LEAST_CHANGED,
    STRIP,
    Collapse,
    collapse,
)
from benchtwin.vision.pile.heap import TOE
from benchtwin.vision.recording import Recording

STEP_MM = 0.1
COARSE_M = 1e-3  # outlines of a film


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


def collapsed(motion: Motion, gate_m: float, high_m: float) -> Collapse:
    """How a simulated column of that height, behind a gate at x = gate_m, collapsed, as
    a film of it shows."""
    beyond = motion.positions_m[:, :, :1] > gate_m - STRIP * high_m
    out = replace(motion, positions_m=np.where(beyond, motion.positions_m, np.nan))
    far = float(np.nanmax(motion.positions_m[-1, :, 0]))
    x = np.arange(gate_m, far + STRIP * high_m, COARSE_M)
    height = np.array([upper_edge(*balls(out, k), x, 0.0) for k in range(out.frames)])
    end = np.where(height[-1] > LAYER * high_m, height[-1], 0.0)
    filled = np.minimum(height, end).sum(axis=1) / end.sum()
    strip = height[:, x < gate_m + STRIP * high_m]
    above = strip[:, None] > HEIGHTS[:, None] * high_m
    ends = above[-1].sum(axis=1)
    passed = (above & above[-1]).sum(axis=2) / np.maximum(ends, 1)
    there = ends >= LEAST_CHANGED * strip.shape[1]
    return collapse(motion.t_s, filled, np.where(there, passed, np.nan))
