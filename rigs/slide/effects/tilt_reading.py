"""Reading of the tilt: sensor offset, clock offset, a late reader.

Recorded tilt = true tilt + offset; stamped at true time + offset; read after a travel
x: overshoot Ω t with x = g Ω cos θ (1 + tan² θ) t³/6 at constant friction."""

import math

import numpy as np

from benchtwin.bench.air import G_M_S2
from benchtwin.infer.effect import Effect

RATE = (
    "the same slide at three times the tilt rate: a clock's error in angle grows with"
    " the rate, a sensor's does not"
)


def _shifted(c: np.ndarray, late: float) -> np.ndarray:
    """Coefficients of a cubic about another moment: θ(t) = recorded(t + late)."""
    return np.array(
        [
            c[0] + late * (c[1] + late * (c[2] + late * c[3])),
            c[1] + late * (2 * c[2] + late * 3 * c[3]),
            c[2] + 3 * late * c[3],
            c[3],
        ]
    )


def overshoot_deg(root: float, rate_deg_s: float, onset_deg: float) -> float:
    """Angle at a travel x = `root`³ [mm] less that at the onset: Ω t, t³ = 6 x cos θ/(g
    Ω)."""
    cube = (
        6e-3
        * math.cos(math.radians(onset_deg))
        * math.radians(rate_deg_s) ** 2
        / G_M_S2
    )
    return root * math.degrees(cube ** (1 / 3))


def _sensor(session) -> bool:
    """Whether an angle was recorded, or read where there are no tracks."""
    return any(r.tilt.sensor for r in session.runs) or not session.runs


EFFECTS = (
    Effect(
        name="angle-offset",
        sector="measurement",
        unit="deg",
        meaning="recorded - true tilt",
        prior_sd=2.0,
        low=-15.0,
        high=15.0,
        source=(
            "after the onset a = g sin(θ − θ₀)/cos θ₀: only cos θ₀ remembers the angle"
            " itself"
        ),
        needs=_sensor,
        wording=("the tilt angle is off", "°"),
        not_simulated="the twin reads its angles without error",
        separating=(
            "a reading of the tilt sensor on the plate levelled with a spirit level,"
            " and a second tilt rate"
        ),
        tilt=lambda c, value: c - np.array([math.radians(value), 0.0, 0.0, 0.0]),
        read=lambda angle, read, value: angle + value,
    ),
    Effect(
        name="clock-offset",
        sector="measurement",
        unit="s",
        meaning="tilt stamp minus picture stamp",
        prior_sd=0.7,
        low=-20.0,
        high=20.0,
        source="offset of the angle ∝ tilt rate",
        separating=RATE,
        needs=_sensor,
        wording=("tilt and picture clocks disagree", "s"),
        not_simulated="the twin has one clock",
        tilt=_shifted,
        read=lambda angle, read, value: (
            angle - read.rate_deg_s * value if math.isfinite(read.rate_deg_s) else angle
        ),
    ),
    Effect(
        name="reading-delay",
        sector="measurement",
        unit="mm",
        meaning="travel at which the angle is read",
        prior_sd=1.3,
        low=0.0,
        high=4.0,
        source="third-power onset where μ_k = μ_s; an eye sees 0.1 to 10 mm",
        reported=lambda root: root**3,
        wording=("the angle was read too late", "mm after the onset"),
        not_simulated="the twin reads its angles without delay",
        separating=(
            "readings at a tenth and at ten times the tilt rate: overshoot grows as the"
            " rate to the 2/3; a clock's: 1"
        ),
        needs=lambda session: bool(
            np.isfinite([r.rate_deg_s for r in session.reads]).any()
        ),
        read=lambda angle, read, value: (
            angle + overshoot_deg(value, read.rate_deg_s, angle)
            if math.isfinite(read.rate_deg_s)
            else angle
        ),
    ),
)
