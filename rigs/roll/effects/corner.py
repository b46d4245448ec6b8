"""The corner at the end of the incline: speed lost at once, or slip.

Only angular momentum about the new point of contact is kept: a ball at a sharp corner
of β loses (1 − cos β)/(1 + I/(m r²)), 0.024 at 15°; rolling friction μ adds μ sin β/(1
+ I/(m r²)); a rounded corner takes nothing. This range is part of the baseline;
`corner-loss` is the total loss.

From slip speed u a seed ends slower by u (1 − 1/c), c = 1 + I/(m r²), after u (1 −
1/c)/(μ g). On the incline a seed that slips in proportion to speed, u = s v,
accelerates by c/(1 + (c − 1)(1 − s)) of rolling, without rolling friction."""

import math

import numpy as np
from scipy.special import ndtr

from benchtwin.bench.constants import G_M_S2
from benchtwin.infer.effect import Effect

SURELY_M_S = 0.01  # slip speed beyond which a seed slips all the way down
GRIP = 0.15  # friction that ends the slip on the level
GRIP_SPREAD = 1.5  # of ln: friction of 0.03 to 0.7


def usual_loss(incline: float, inertia: float, rolling: float, rank: float) -> float:
    """Loss at a corner [rad], uniform from 0 to a sharp one's; rank: standard
    normal."""
    most = (1 - math.cos(incline)) / inertia + rolling * math.sin(incline) / inertia
    return most * float(ndtr(rank))


def lost_in_all(e) -> tuple[float, float]:
    """Total loss at the corner, mean over the runs, and its sd, in an explanation."""
    at, model, names = e.fit.by_name, e.fit.problem.model, ("corner-loss", "corner")
    own = [
        float(
            np.mean(
                [model.usual_loss(r, at["corner"] + d) for r in range(len(model.runs))]
            )
        )
        for d in (-0.01, 0.0, 0.01)
    ]
    slope = np.array([1.0, (own[2] - own[0]) / 0.02])
    rows = [e.fit.names.index(n) for n in names]
    return at["corner-loss"] + own[1], float(
        np.sqrt(e.power * (slope @ e.fit.covariance[np.ix_(rows, rows)] @ slope))
    )


def slipping(way: dict, value: float, context) -> dict:
    """The way with slip of `value` [m/s] where the incline ends."""
    speed, inertia, more = max(context.speed, 1e-3), context.seed.inertia, context.at
    slip = min(max(value / speed, -0.5), 1.0)
    full = (
        inertia
        / (1 + (inertia - 1) * (1 - slip))
        / (1 - context.resisted * (1 - math.exp(-max(value, 0.0) / SURELY_M_S)))
    )
    grip = GRIP * math.exp(
        GRIP_SPREAD * math.tanh(more.get("initial-slip.grip", 0.0) / GRIP_SPREAD)
    )
    return way | {
        "gain": 1 + (0.5 + more.get("initial-slip.incline", 0.0)) * (full - 1),
        "slip_loss": value * (1 - 1 / inertia),
        "slip_time": max(value, 0.0) * (1 - 1 / inertia) / (grip * G_M_S2),
    }


def passed(runs, seed) -> bool:
    """Whether any seed passes the corner."""
    return any(not run.stays for run in runs)


EFFECTS = (
    Effect(
        name="corner-loss",
        sector="onset",
        unit="1",
        meaning="lost fraction of speed",
        prior_sd=0.1,
        low=0.0,
        high=1.0,
        source=(
            "angular momentum about the new point of touch: (1 − cos β)/(1 + I/(m r²)),"
            " 0.024 for a ball at 15°"
        ),
        needs=passed,
        wording=("the corner takes speed", "of the speed"),
        not_simulated="nothing in the twin stands for it",
        summary=lost_in_all,
        separating=(
            "the same roll over a rounded corner, or on a gentler incline: the loss"
            " grows as the square of the angle"
        ),
        act=lambda way, value, context: way | {"keep": way["keep"] - value},
    ),
    Effect(
        name="initial-slip",
        sector="onset",
        unit="m/s",
        meaning="slip speed where the incline ends",
        prior_sd=0.07,
        low=0.0,
        high=3.0,
        source="Coulomb friction on a rolling ball; u = 5u0/7 at the end of slip",
        act=slipping,
        nonlinear=True,  # it bends the way down and the level, and grip ends it
        needs=passed,
        wording=("the seed slips where the incline ends", "m/s"),
        not_simulated="nothing in the twin stands for it",
        separating=(
            "the same roll filmed so that the seed's turning is seen: a seed that slips"
            " turns too slowly"
        ),
    ),
    Effect(
        name="initial-slip.grip",
        sector="onset",
        unit="1",
        meaning="ln of the friction that ends the slip over 0.15",
        prior_sd=0.7,
        low=-3.0,
        high=3.0,
        source="seeds slide on plates with friction of 0.04 to 0.6",
        group="initial-slip",
        scaled_prior=False,
    ),
    Effect(
        name="initial-slip.incline",
        sector="onset",
        unit="1",
        meaning="share of the slip from the incline, less 1/2",
        prior_sd=0.5,
        low=-1.0,
        high=1.0,
        source="a corner may make a seed slip too",
        group="initial-slip",
        scaled_prior=False,
    ),
)
