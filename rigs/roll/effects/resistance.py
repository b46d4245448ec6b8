"""Resistance that grows with speed: of rolling, and of air where none is stated."""

import numpy as np

from benchtwin.bench.air import drag_shape
from benchtwin.infer.effect import Counterpart, Effect

REFERENCE_SPEED_M_S = 0.5


def drag_over_weight(
    speed: np.ndarray, value: float, reynolds_per_speed: float, exponent: float = 0.0
) -> np.ndarray:
    """`value` at 0.5 m/s, elsewhere as C_d(Re) v² of a ball times (v/0.5
    m/s)^exponent."""
    over = speed / REFERENCE_SPEED_M_S
    at_half = drag_shape(REFERENCE_SPEED_M_S, reynolds_per_speed)
    return (
        value
        * drag_shape(speed, reynolds_per_speed)
        * over
        / at_half
        * np.maximum(over, 1e-6) ** exponent
    )


EFFECTS = (
    Effect(
        name="viscous-rolling",
        sector="run-out",
        unit="s/m",
        meaning="slope of mu_r on speed",
        prior_sd=0.02,
        low=0.0,
        high=2.0,
        source=(
            "Brilliantov, Pöschel (1998), Europhys. Lett. 42, 511 (viscoelastic balls:"
            " mu_r grows as v)"
        ),
        wording=("rolling friction grows with speed", "s/m"),
        resist=lambda speed, value, seed, more: value * speed,
        separating=(
            "the same roll in still air, and from a longer incline: drag grows as the"
            " square of speed, and a heavier ball of the same size hardly feels it"
        ),
        counterpart=Counterpart(
            "rolling friction grows by {value} per m/s",
            lambda v: {
                "laws": {"rolling_viscous": {"slope": max(v["viscous-rolling"], 0.0)}}
            },
        ),
    ),
    Effect(
        name="drag",
        sector="run-out",
        unit="1",
        meaning="drag force over weight at 0.5 m/s",
        prior_sd=0.015,
        low=0.0,
        high=0.5,
        source=(
            "Clift, Gauvin (1971); a soybean has 0.002, a wheat grain 0.004 at 0.5 m/s"
        ),
        wording=("air drag is missing", "of the weight at 0.5 m/s"),
        needs=lambda runs, seed: not seed.drag,
        separating=(
            "the same roll from a longer incline: drag grows as the square of speed,"
            " viscous rolling as speed"
        ),
        resist=lambda speed, value, seed, more: drag_over_weight(
            speed, value, seed.reynolds_per_speed, more.get("drag.exponent", 0.0)
        ),
        counterpart=Counterpart(
            "the air's drag law is on, with drag over weight at 0.5 m/s {value} more"
            " than stated"
        ),
    ),
    Effect(
        name="drag.exponent",
        sector="run-out",
        unit="1",
        meaning="power of speed beside that of a ball's drag",
        prior_sd=0.25,
        low=-1.0,
        high=1.0,
        source="a ball's C_d(Re) v² grows as v^1.5 at Re 100, as v^2 from 1000 on",
        group="drag",
        scaled_prior=False,
    ),
)
