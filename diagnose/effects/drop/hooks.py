"""Arguments of the laws of drops (flights, view, impacts), and laws shared with nuisances."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Motion:
    """Seeds in flight at many moments.

    velocity (f, n, 2) [m/s]: x right, z up; aside_square (f, 1): of the speed along the line of
    sight, an estimate that may be < 0; rolled (f, 1) [rad/m]: spin over that speed; spin (f, 1)
    [rad/s], anticlockwise; reynolds, lift, room (f, 1): see air.Air; slope: see air.drag_shape.
    """

    velocity: np.ndarray
    aside_square: np.ndarray
    rolled: np.ndarray
    spin: np.ndarray
    reynolds: np.ndarray
    lift: np.ndarray
    room: np.ndarray
    g: float
    slope: float


@dataclass(frozen=True)
class View:
    """What the camera looks at.

    middle (2,) and reach [m], from there to the top of the view; angle (n,) of the seed [rad], 0
    unknown; phase (n, 2): place in pixels times 2π; pixel [m]; fall [m]: of the seeds beside the
    middle.
    """

    middle: np.ndarray
    reach: float
    angle: np.ndarray
    phase: np.ndarray
    pixel: float
    fall: float = 0.0


@dataclass(frozen=True, eq=False)
class Hits:
    """Impacts (n,).

    speed: closing speed of the point of contact [m/s]; count: number of the impact, from 1; lever:
    change of Δv_x/Δv_n by 1 rad of tilt; drift (2, n): speed across over closing speed, before and
    after.
    """

    speed: np.ndarray
    count: np.ndarray
    lever: np.ndarray
    drift: np.ndarray


def turned(places: np.ndarray, view: View, value: float) -> np.ndarray:
    """Places (n, 2) along the stated plumb line if the true one is `value` [deg] clockwise."""
    c, s = np.cos(np.radians(value)), np.sin(np.radians(value))
    x, z = (places - view.middle).T
    return view.middle + np.column_stack([x * c + z * s, z * c - x * s])


def scaled(places: np.ndarray, view: View, value: float) -> np.ndarray:
    """As read with the stated scale: true place over 1 + `value`, about the middle of the view."""
    return view.middle + (places - view.middle) / (1 + value)


def keystone(places: np.ndarray, view: View, value: float) -> np.ndarray:
    """True place over 1 + `value` (z − z_middle): mm per px grows by `value` [1/m]."""
    about = view.middle + np.array([view.fall, 0.0])
    return about + (places - about) / (1 + value * (places[:, 1:] - view.middle[1]))


def distorted(places: np.ndarray, view: View, value: float) -> np.ndarray:
    """r → r (1 + `value` (r/reach)²) about the middle of the view."""
    off = places - view.middle
    return view.middle + off * (1 + value * (off**2).sum(1, keepdims=True) / view.reach**2)


def wobbled(phase: int):
    """Adds `value` [mm] (cos 2θ, sin 2θ), θ the seed's angle in the picture; phase 1: (−sin 2θ, cos 2θ)."""

    def picture(places: np.ndarray, view: View, value: float) -> np.ndarray:
        c, s = np.cos(2 * view.angle), np.sin(2 * view.angle)
        return places + 1e-3 * value * np.column_stack([-s, c] if phase else [c, s])

    return picture


def tilted_kick(hits: Hits, tilt_deg) -> np.ndarray:
    """Δv_x/Δv_n = α lever, α = `tilt_deg` positive where the plate falls towards +x."""
    return np.radians(tilt_deg) * hits.lever


def tilted_restitution(hits: Hits, e: np.ndarray, tilt_deg) -> np.ndarray:
    """e − tan α (v_x' + e v_x)/v for a plate that falls by α towards +x."""
    return e - np.tan(np.radians(tilt_deg)) * (hits.drift[1] + e * hits.drift[0])
