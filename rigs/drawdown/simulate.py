"""A draw-down in the simulation."""

from typing import Any

import numpy as np

from benchtwin.sim.motion import Motion
from benchtwin.sim.picture import Camera, project
from benchtwin.sim.rigs.drawdown import OF_A_FLOW, Drawdown, run_drawdown
from benchtwin.twin.setup import level_line, of_heaps

BESIDE_M, BELOW_M = 12e-3, 6e-3  # shown of what stands beside and below a heap


def told(rig: Drawdown, camera: Camera, motion: Motion) -> dict[str, Any]:
    """Where slope and heap are seen, and what was seen of the flow."""
    x, _, z = rig.box_m
    first, last = rig.tray_ends_m
    known: dict[str, Any] = {
        "upper_px": _region(camera, (-BESIDE_M, -BELOW_M), (x, z)),
        "lower_px": _region(
            camera,
            (first - BESIDE_M, -rig.fall_m - BELOW_M),
            (last + BESIDE_M, -BELOW_M),
        ),
        "shelf_px": level_line(camera, (0.0, rig.shelf_m), 0.0, 0.0),
        "tray_px": level_line(camera, (first, last), 0.0, -rig.fall_m),
        "jammed": bool(motion.truth["jammed"]),
        "tray_mass_g": round(motion.truth["tray_mass_g"], 2),
    }
    if np.isfinite(motion.truth["flow_time_s"]):
        known["flow_time_s"] = round(motion.truth["flow_time_s"], 3)
    return known


def _region(
    camera: Camera, low: tuple[float, float], high: tuple[float, float]
) -> tuple[int, int, int, int]:
    """Left, top, width and height [px] of a part (x, z) [m] of the middle plane, as far
    as it is in the picture."""
    corners = np.array([[low[0], 0.0, high[1]], [high[0], 0.0, low[1]]])
    size = np.array([camera.width_px, camera.height_px])
    (left, top), (right, bottom) = np.clip(
        np.round(project(camera, corners)), 0, size - 1
    ).astype(int)
    return int(left), int(top), int(right - left), int(bottom - top)


SETUP = of_heaps(
    Drawdown,
    run_drawdown,
    Camera(1900, 2000, 0.1, (0.085, 0.0, 0.005), 10.0),
    truth=OF_A_FLOW,
    told=told,
)
