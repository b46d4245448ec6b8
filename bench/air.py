"""Drag of the stated seed in air at any speed, and how well it is known.

C_d(Re) = (24/Re)(1 + 0.15 Re^0.687) + 0.42/(1 + 42500 Re^−1.16), Re < 3·10⁵ (Clift &
Gauvin 1971), of a sphere of the seed's volume; a seed's own differs by about SHAPE_SD.
"""

import math
from dataclasses import dataclass

import numpy as np

from benchtwin.bench.constants import G_M_S2
from benchtwin.bench.ellipsoid import sphere_volume
from benchtwin.bench.priors import unstated_sd

SHAPE_SD = unstated_sd("drag-coefficient")  # relative, of C_d beside a sphere's
SEED_DRAG = unstated_sd("drag-of-one-seed")
UNKNOWN = unstated_sd("drag")  # over weight at 2 m/s
REFERENCE_SPEED_M_S = 2.0
SLOWEST_M_S = 0.01  # floor on speeds
UNKNOWN_DRAG_PER_M = UNKNOWN * G_M_S2 / REFERENCE_SPEED_M_S**2


@dataclass(frozen=True)
class Air:
    """What a recording states of air and seed."""

    share: float  # drag over weight at 2 m/s, 0 where air is left out
    sd: float  # of share
    room: float  # the share in the stated air or, where air is left out, in room air
    reynolds_per_speed: float  # Reynolds number at 1 m/s
    lift: float  # ρ A r/2m [-] of a = C (ρ A r/2m) ω × v
    buoyancy: float = 0.0  # density of the stated air over the seed's


def drag_coefficient(reynolds):
    """C_d of a sphere.

    >>> [round(float(drag_coefficient(re)), 3) for re in (1.0, 100.0, 1000.0, 1e5)]
    [27.6, 1.094, 0.466, 0.492]
    """
    re = np.maximum(reynolds, 1e-6)
    return 24 / re * (1 + 0.15 * re**0.687) + 0.42 / (1 + 42500 * re**-1.16)


def stated_sizes_mm(description: dict) -> list[float]:
    """Length, width and thickness of the seed [mm], as far as they are stated."""
    seed = description.get("seed", {})
    return [seed[k] for k in ("length_mm", "width_mm", "thickness_mm") if seed.get(k)]


def air_of(description: dict) -> Air:
    """From `seed` and `air` sections; absent keys get typical values and a wide sd."""
    seed, air = description.get("seed", {}), description.get("air", {})
    density = air.get("density_kg_m3", 1.2)
    viscosity = air.get("viscosity_pa_s", 1.81e-5) or 1.81e-5
    stated = density > 0
    density = density or 1.2
    sizes = stated_sizes_mm(description)
    diameter = float(np.prod(sizes)) ** (1 / len(sizes)) / 1000 if sizes else 7e-3
    if seed.get("mass_g"):
        mass = seed["mass_g"] / 1000
    else:
        mass = seed.get("density_kg_m3", 0.0) * sphere_volume(diameter)
    reynolds = density * diameter / viscosity
    known = bool(sizes) and mass > 0
    mass = mass or 1250 * sphere_volume(diameter)
    lift = density * math.pi * diameter**3 / 8 / 2 / mass
    speed = REFERENCE_SPEED_M_S
    force = (
        density
        * float(drag_coefficient(reynolds * speed))
        * math.pi
        / 8
        * diameter**2
        * speed**2
    )
    room = force / (mass * G_M_S2)
    if not stated:
        return Air(0.0, 0.0, room, reynolds, lift)
    buoyancy = density * sphere_volume(diameter) / mass
    known_sd = SHAPE_SD * room if known else UNKNOWN
    return Air(room if known else UNKNOWN, known_sd, room, reynolds, lift, buoyancy)


def speed_through_air(velocity: np.ndarray, aside_square: np.ndarray) -> np.ndarray:
    """Speed (f, n, 1) [m/s] of (f, n, 2) velocities and v_y² (f, 1), which may be <
    0."""
    square = (velocity**2).sum(axis=-1, keepdims=True) + aside_square[..., None]
    return np.sqrt(np.maximum(square, SLOWEST_M_S**2))


def drag_shape(speed, reynolds_per_speed: float | np.ndarray, slope: float = 0.0):
    """s in a = −(share g) s u, u the velocity through the air; s u is u/|u| at 2 m/s.

    slope: d ln C_d/d ln v beside a sphere's, clipped to ± 1: a force that falls with
    speed diverges."""
    slope = min(max(slope, -1.0), 1.0)
    reference = (
        drag_coefficient(reynolds_per_speed * REFERENCE_SPEED_M_S)
        * REFERENCE_SPEED_M_S**2
    )
    bent = np.maximum(speed / REFERENCE_SPEED_M_S, 1e-6) ** slope if slope else 1.0
    return drag_coefficient(reynolds_per_speed * speed) * speed / reference * bent


def drag_at(air: Air, speed: float) -> float:
    """k [1/m] of a = −k v |v| at one speed [m/s]."""
    shape = float(drag_shape(speed, air.reynolds_per_speed))
    return air.share * G_M_S2 * shape / speed


def drag_of_hops(
    air: Air, height_m: float | None, hop_s: float = math.nan
) -> tuple[float, float]:
    """k [1/m] of a = −k v |v| for a fall from a height and the hops after it, at three
    quarters of its last speed, and that speed [m/s], without air; where no height is
    known that of the first hop, which lasts `hop_s`."""
    fast = math.sqrt(2 * G_M_S2 * height_m) if height_m else G_M_S2 * hop_s / 2
    return drag_at(air, 0.75 * fast), fast


def through_air(
    gap: np.ndarray, height_m: float | None, drag: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(m,) each, of hops from a plate that last `gap` [s]: speed at which the flight
    before it came down, speed at which it left [m/s], its height [m]. The first speed
    is that of a fall from `height_m`, NaN without. drag: k [1/m] of a = −g − k v |v|,
    in closed form."""
    k, g = max(drag, 1e-9), G_M_S2
    up = g * gap / 2
    for _ in range(12):  # Newton's steps would be two; the duration is nearly 2 v / g
        rise = np.log1p(k * up**2 / g) / (2 * k)
        up = up * gap / hop_s(rise, drag)
    rise = np.log1p(k * up**2 / g) / (2 * k)
    falls = np.concatenate([[height_m or math.nan], rise[:-1]])
    return np.sqrt(g / k * -np.expm1(-2 * k * falls)), up, rise


def hop_s(rise_m: np.ndarray, drag: float) -> np.ndarray:
    """How long [s] a hop lasts that rises by `rise_m`; drag as in `through_air`."""
    k, g = max(drag, 1e-9), G_M_S2
    fast = np.sqrt(np.expm1(2 * k * rise_m))  # the first speed over √(g/k)
    return (np.arctan(fast) + np.arcsinh(fast)) / math.sqrt(g * k)


def drag_over_mass(motion, share) -> np.ndarray:
    """a = −share g s(|v|) v [m/s²] of a `Motion`; share: scalar or (f, 1, 1)."""
    speed = speed_through_air(motion.velocity, motion.aside_square)
    return (
        -share
        * motion.g
        * drag_shape(speed, motion.reynolds[..., None], motion.slope)
        * motion.velocity
    )
