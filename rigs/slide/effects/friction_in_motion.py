"""Friction that differs in motion: less than at rest, falling or growing with speed.

μ(v) = μ_k + Δ exp(−(v/v_s)ⁿ) + k v in motion. Sources: Armstrong-Hélouvry, Dupont,
Canudas de Wit (1994), Automatica 30, 1083; Bo & Pavelescu (1982), Wear 82, 277 (n = 1).
"""

import math
from collections.abc import Mapping

import numpy as np

from benchtwin.infer.effect import Counterpart, Effect
from benchtwin.rigs.slide.session import lets_go

SPEED_M_S = 0.05  # typical of v_s; a block slides at 0 to 0.5 m/s
SETTLE_M_S = 1e-3  # over which the twin's friction falls from that at rest


def _tracked(session) -> bool:
    return bool(session.runs)


def scale_m_s(ln_scale: float) -> float:
    """v_s from ln of it over SPEED_M_S, clipped to e^∓6."""
    return SPEED_M_S * math.exp(min(max(ln_scale, -6.0), 6.0))


def _falling(speed, value: float, run, more: Mapping[str, float]):
    """Δ exp(−(v/v_s)ⁿ)."""
    power = math.exp(min(max(more.get("stribeck.shape", 0.0), -3.0), 3.0))
    scale = scale_m_s(more.get("stribeck.ln-speed", 0.0))
    return value * np.exp(-((speed / scale) ** power))


EFFECTS = (
    Effect(
        name="kinetic-friction",
        sector="onset",
        unit="1",
        meaning="mu_static - mu_kinetic",
        prior_sd=0.08,
        low=0.0,
        high=0.5,
        source=(
            "Coulomb (1785); seeds on steel lose 5 to 30 % of their friction once they"
            " slide: Mohsenin (1986)"
        ),
        wording=("friction falls once it slides", "= μ static − μ kinetic"),
        nonlinear=True,
        needs=lets_go,
        separating=(
            "the same slide at a tenth of the tilt rate and at a higher frame rate: the"
            " first millimetre"
        ),
        act=lambda laws, run, value: laws._replace(
            static_excess=laws.static_excess + value
        ),
        rest=float,
        counterpart=Counterpart(
            "friction falls by {value} once it slides",
            lambda v: {
                "laws": {
                    "friction_kinetic": {
                        "drop": v["kinetic-friction"],
                        "settle_speed": SETTLE_M_S,
                    }
                }
            },
        ),
    ),
    Effect(
        name="stribeck",
        sector="sliding",
        unit="1",
        meaning="mu at rest - mu at high speed",
        prior_sd=0.08,
        low=0.0,
        high=0.5,
        source="Armstrong-Hélouvry et al. (1994)",
        nonlinear=True,
        needs=_tracked,
        wording=(
            "friction falls smoothly with sliding speed",
            "= μ at rest − μ at high speed",
        ),
        separating=(
            "the same slide at a tenth of the tilt rate: speeds between rest and a few"
            " cm/s"
        ),
        resist=_falling,
        rest=float,
        counterpart=Counterpart(
            "friction falls by {value} with sliding speed",
            lambda v: {
                "laws": {
                    "friction_stribeck": {
                        "drop": v["stribeck"],
                        "stribeck_speed": scale_m_s(v.get("stribeck.ln-speed", 0.0)),
                    }
                }
            },
        ),
    ),
    Effect(
        name="stribeck.ln-speed",
        sector="sliding",
        unit="1",
        meaning="ln of the speed scale over 0.05 m/s",
        prior_sd=0.8,
        low=-3.0,
        high=3.0,
        source="scales of 0.01 to 0.25 m/s show within a slide",
        group="stribeck",
        scaled_prior=False,
    ),
    Effect(
        name="stribeck.shape",
        sector="sliding",
        unit="1",
        meaning="ln of the exponent",
        prior_sd=0.4,
        low=-1.0,
        high=1.0,
        source="exponents of 0.5 to 2",
        group="stribeck",
        scaled_prior=False,
    ),
    Effect(
        name="viscous-sliding",
        sector="sliding",
        unit="s/m",
        meaning="slope of mu on speed",
        prior_sd=0.15,
        low=0.0,
        high=3.0,
        source="wet or waxy seed coats; Armstrong-Hélouvry et al. (1994)",
        needs=_tracked,
        wording=("friction grows with sliding speed", "s/m"),
        separating=(
            "the same slide at three times the tilt rate: higher speeds at the same"
            " places"
        ),
        resist=lambda speed, value, run, more: value * speed,
        counterpart=Counterpart(
            "friction grows by {value} per m/s",
            lambda v: {"laws": {"friction_viscous": {"slope": v["viscous-sliding"]}}},
        ),
    ),
)
