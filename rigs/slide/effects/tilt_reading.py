"""Reading of the tilt: sensor offset, clock offset, a late reader.

Recorded tilt = true tilt + offset; stamped at true time + offset; read after a travel
x: overshoot Ω t with x = g Ω cos θ (1 + tan² θ) t³/6 at constant friction."""

import math

import numpy as np

from benchtwin.bench.air import G_M_S2
from benchtwin.infer.effect import Effect
from benchtwin.rigs.slide.tilt import Tilt

MOST_LN_RATE = math.log(100)  # minutes for seconds are 60

RATE = (
    "the same slide at three times the tilt rate: a clock's error in angle grows with"
    " the rate, a sensor's does not"
)


def _off(c: np.ndarray, tilt: Tilt, offset_deg: float) -> np.ndarray:
    """Coefficients of the true angle, where a sensor shows it too steep."""
    return c - np.array([math.radians(offset_deg) * tilt.sensor, 0.0, 0.0, 0.0])


def _shifted(c: np.ndarray, tilt: Tilt, late: float) -> np.ndarray:
    """Coefficients of a cubic about another moment: θ(t) = recorded(t + late)."""
    late *= tilt.sensor
    return np.array(
        [
            c[0] + late * (c[1] + late * (c[2] + late * c[3])),
            c[1] + late * (2 * c[2] + late * 3 * c[3]),
            c[2] + 3 * late * c[3],
            c[3],
        ]
    )


def _faster(c: np.ndarray, tilt: Tilt, ln_ratio: float) -> np.ndarray:
    """Coefficients of a plate raised at another rate than stated, from the same angle
    at t = 0."""
    more = math.expm1(min(max(ln_ratio, -MOST_LN_RATE), MOST_LN_RATE))
    more *= c[1] * (not tilt.sensor)
    return c + np.array([more * tilt.origin, more, 0.0, 0.0])


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
        tilt=_off,
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
        name="tilt-rate",
        sector="measurement",
        unit="times",
        meaning="rate at which the plate is raised over the stated one",
        prior_sd=1.0,
        low=-MOST_LN_RATE,
        high=MOST_LN_RATE,
        source="a sliding block's pull grows by g cos θ dθ/dt",
        nonlinear=True,
        reported=math.exp,
        separating=RATE,
        needs=lambda session: any(
            not (r.tilt.sensor or r.tilt.stands) for r in session.runs
        ),
        wording=("the plate is raised at another rate than stated", "times the stated"),
        not_simulated="the twin's plate turns as stated",
        tilt=_faster,
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
