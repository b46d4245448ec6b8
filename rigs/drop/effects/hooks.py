"""Arguments of the laws of drops (flights, view, impacts), and laws shared with
nuisances."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from benchtwin.bench.air import REFERENCE_SPEED_M_S


@dataclass(frozen=True)
class Motion:
    """Seeds in flight at many moments (f, n)."""

    velocity: np.ndarray  # (f, n, 2) [m/s]: x right, z up
    aside_square: np.ndarray  # (f, 1): of the speed along the line of sight, may be < 0
    rolled: np.ndarray  # (f, 1) [rad/m]: spin over that speed
    spin: np.ndarray  # (f, 1) [rad/s], anticlockwise
    reynolds: np.ndarray  # this and the next (f, 1): see air.Air
    lift: np.ndarray
    room: np.ndarray
    g: float
    slope: float  # see air.drag_shape


@dataclass(frozen=True)
class View:
    """What the camera looks at."""

    middle: np.ndarray  # (2,) [m]
    reach: float  # from there to the top of the view [m]
    angle: np.ndarray  # (n,) of the seed [rad], 0 unknown
    phase: np.ndarray  # (n, 2): place in pixels times 2π, 0 without a scale
    pixel: float  # [m]
    fall: float = 0.0  # of the seeds beside the middle [m]

    @cached_property
    def waves(self) -> tuple[np.ndarray, np.ndarray]:
        """Sine and cosine (n, 2) of the phase."""
        return np.sin(self.phase), np.cos(self.phase)

    @cached_property
    def heading(self) -> np.ndarray:
        """cos θ + i sin θ (n,) of the angle."""
        return np.exp(1j * self.angle)


@dataclass(frozen=True, eq=False)
class Hits:
    """Impacts (n,)."""

    speed: np.ndarray  # closing speed of the point of contact [m/s]
    count: np.ndarray  # number of the impact, from 1
    lever: np.ndarray  # change of Δv_x/Δv_n by 1 rad of tilt (1: no friction)
    drift: np.ndarray  # (2, n): speed across over closing speed, before and after
    fell: np.ndarray  # stated height [m] that gave the speed before, else infinite
    timed: np.ndarray  # whether speeds are those of times between impacts


def turned(places: np.ndarray, view: View, value: float) -> np.ndarray:
    """Places (n, 2) along the stated plumb line if the true one is `value` [deg]
    clockwise."""
    c, s = np.cos(np.radians(value)), np.sin(np.radians(value))
    x, z = (places - view.middle).T
    return view.middle + np.column_stack([x * c + z * s, z * c - x * s])


def scaled(places: np.ndarray, view: View, value: float) -> np.ndarray:
    """As read with the stated scale: true place over 1 + `value`, about the middle of
    the view."""
    return view.middle + (places - view.middle) / (1 + value)


def keystone(places: np.ndarray, view: View, value: float) -> np.ndarray:
    """True place over 1 + `value` (z − z_middle): mm per px grows by `value` [1/m]."""
    about = view.middle + np.array([view.fall, 0.0])
    return about + (places - about) / (1 + value * (places[:, 1:] - view.middle[1]))


def distorted(places: np.ndarray, view: View, value: float) -> np.ndarray:
    """r → r (1 + `value` (r/reach)²) about the middle of the view."""
    off = places - view.middle
    return view.middle + off * (
        1 + value * (off**2).sum(1, keepdims=True) / view.reach**2
    )


def wobbled(phase: int, turns: int = 2):
    """Adds `value` [mm] (cos kθ, sin kθ), θ the seed's angle in the picture, k =
    `turns`: 2 for an outline, 1 for a point of the body; phase 1: (−sin kθ, cos kθ)."""

    def picture(places: np.ndarray, view: View, value: float) -> np.ndarray:
        pointed = 1e-3 * value * view.heading**turns * (1j if phase else 1)
        return places + np.column_stack([pointed.real, pointed.imag])

    return picture


def tilted_kick(hits: Hits, tilt_deg) -> np.ndarray:
    """Δv_x/Δv_n = α lever, α = `tilt_deg` positive where the plate falls towards +x."""
    return np.radians(tilt_deg) * hits.lever


def tilted_restitution(hits: Hits, e: np.ndarray, tilt_deg) -> np.ndarray:
    """e − tan α (v_x' + e v_x)/v for a plate that falls by α towards +x."""
    return e - np.tan(np.radians(tilt_deg)) * (hits.drift[1] + e * hits.drift[0])


def slowed(hits: Hits, e: np.ndarray, value) -> np.ndarray:
    """e as read from times between impacts where drag over weight at 2 m/s is `value`
    more than taken: k = `value` g/(2 m/s)² makes ln e read k v² (1 + e²)/(4 g) less, to
    first order in the times of hops and the speed after a fall through air."""
    share = hits.timed * value * (hits.speed / REFERENCE_SPEED_M_S) ** 2
    return e * (1 - share * (1 + e**2) / 4)


def lower(value: float) -> float:
    """[m] by which heights are stated too low, `value` [mm]."""
    return 1e-3 * value


def fallen_deeper(hits: Hits, e: np.ndarray, value: float) -> np.ndarray:
    """e as read where the speed before is that of a fall stated `value` [mm] too
    low."""
    return e * np.sqrt(np.maximum(1 + lower(value) / hits.fell, 0.0))
