"""What a candidate is: a law with one reported parameter, its physical prior, where it acts and what it is taken for."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Motion:
    """Seeds in flight at many moments: velocity (f, n, 2) [m/s] along x (right) and z (up); aside_square (f, 1) [m²/s²]: of the
    speed along the line of sight, which no picture shows (an estimate may be below nil); rolled (f, 1) [rad/m]: spin over speed
    that way, as across; spin (f, 1) [rad/s] anticlockwise in the picture; reynolds, lift, room (f, 1): see air.Air; g
    [m/s²]; slope: see air.drag_shape."""

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
    """What the camera looks at: middle (2,) of the view and reach [m] (from there to its top); angle (n,) of the seed [rad], 0
    where unknown; phase (n, 2): place in pixels times 2π, on a smooth curve, 0 where the scale is not stated; pixel [m]; ruler:
    how high above the middle the scale is as stated, in reaches; fall [m]: how far beside the middle seeds fall, where upright is
    as stated."""

    middle: np.ndarray
    reach: float
    angle: np.ndarray
    phase: np.ndarray
    pixel: float
    ruler: float = 0.0
    fall: float = 0.0


@dataclass(frozen=True, eq=False)
class Hits:
    """Impacts (n,): closing speed of the point of contact along the plate's normal [m/s], how many impacts this seed has had with
    this one (1: the first); by how much a tilt of 1 rad turns Δv_x over Δv_n (1: no friction), and takes from e of the upright
    speeds, before and after over the closing one (2, n)."""

    speed: np.ndarray
    count: np.ndarray
    lever: np.ndarray
    drift: np.ndarray


@dataclass(frozen=True)
class Effect:
    """One candidate, or one nuisance that is always there.

    name, unit, meaning: as in effects.json; sector: flight | measurement | impact; prior_sd: of the physical prior about 0, in
    the unit; low, high: physical range; twins: names it is taken for; separating: the recording that
    would tell them apart; source of law and range.
    One law, or the last two: acceleration(Motion, value) → (f, n, 2) [m/s²] added in flight; picture(places (n, 2) [m], View,
    value) → places as the camera shows them; clock(value) → true over stated frame rate; restitution(Hits, e (n,), value) → e of
    a central impact in place of `e`; kick(Hits, value) → added to Δv_x/Δv_n. reported: from the fitted value to the reported one
    (rising), where they differ; low, high, prior_sd are the fitted one's.
    needs: what must have been seen ("spin"), "" for nothing.
    """

    name: str
    sector: str
    unit: str
    meaning: str
    prior_sd: float
    low: float
    high: float
    source: str
    twins: tuple[str, ...] = ()
    separating: str = ""
    needs: str = ""
    acceleration: Callable[[Motion, float], np.ndarray] | None = None
    picture: Callable[[np.ndarray, View, float], np.ndarray] | None = None
    clock: Callable[[float], float] | None = None
    restitution: Callable | None = None
    kick: Callable | None = None
    reported: Callable[[float], float] | None = None
    group: str = ""  # the effect that this is a further parameter of
