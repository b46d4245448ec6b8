"""A camera of our own: from true places [mm] and times [s] to what a recording states.

Signs, with x to the right and y up in the picture: scale_error: true / stated mm per
pixel − 1. clock_error: true / stated frame rate − 1; clock_drift [1/s]: its growth.
roll_deg: true less stated plumb, clockwise: gravity points along (−sin, −cos).
perspective [1/m]: the picture's magnification grows by so much per metre of height.
distortion: radial, relative, at the picture's edge. wobble_mm: the tracked centre is
off by (cos 2φ, sin 2φ), φ the seed's angle in the picture. distance_mm: to the plane of
the motion; what is nearer looks larger."""

from typing import Any, NamedTuple

import numpy as np


class Camera(NamedTuple):
    """centre_mm: the point of the rig in the picture's middle; half_mm: from there to
    the edge."""

    centre_mm: tuple[float, float]
    half_mm: float
    plumb_deg: float = 0.0
    scale_error: float = 0.0
    clock_error: float = 0.0
    clock_drift: float = 0.0
    roll_deg: float = 0.0
    perspective: float = 0.0
    distortion: float = 0.0
    wobble_mm: float = 0.0
    distance_mm: float = np.inf

    def turn(self) -> float:
        """By how much the picture is turned clockwise [rad]."""
        return np.radians(self.roll_deg + self.plumb_deg)


def magnification(distance_mm: float, depth_mm: Any) -> Any:
    """By how much larger than in the plane of the motion something `depth_mm` behind it
    looks [1]: d / (d + depth)."""
    return 1 / (1 + depth_mm / distance_mm)


def project(
    camera: Camera,
    x_mm: np.ndarray,
    y_mm: np.ndarray,
    angle_rad: np.ndarray,
    depth_mm: np.ndarray | float = 0.0,
) -> np.ndarray:
    """Places (2, n) in the picture, in stated millimetres, from its middle."""
    x = x_mm + camera.wobble_mm * np.cos(2 * angle_rad) - camera.centre_mm[0]
    y = y_mm + camera.wobble_mm * np.sin(2 * angle_rad) - camera.centre_mm[1]
    larger = magnification(camera.distance_mm, depth_mm)
    place = np.array([x, y]) * (1 + camera.perspective * y * 1e-3) * larger
    place *= 1 + camera.distortion * (place**2).sum(axis=0) / camera.half_mm**2
    cos, sin = np.cos(camera.turn()), np.sin(camera.turn())
    return np.array([[cos, sin], [-sin, cos]]) @ place / (1 + camera.scale_error)


def stated_times(camera: Camera, t_s: np.ndarray) -> np.ndarray:
    """What the camera's clock says at the true times."""
    return t_s * (1 + camera.clock_error) + camera.clock_drift * t_s**2


def true_times(camera: Camera, stated_s: np.ndarray) -> np.ndarray:
    """True times of frames that the clock puts at `stated_s`."""
    rate = 1 + camera.clock_error
    return 2 * stated_s / (rate + np.sqrt(rate**2 + 4 * camera.clock_drift * stated_s))
