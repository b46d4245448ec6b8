"""One session's flights as a problem: nuisances with their sds, noise, initial parabolas."""

from functools import partial

import numpy as np

from diagnose.air import G_M_S2
from diagnose.engine.problem import Problem
from diagnose.rigs.drop.flight_model import IN_FLIGHT, STARTS, Model
from diagnose.rigs.drop.nuisances import LOCK, NUISANCES, OFF_CENTRE, PRIORS
from diagnose.rigs.drop.reduction import reduce
from diagnose.rigs.drop.session import Session
from diagnose.rigs.drop.track_noise import TRACKER_PX, TrackNoise, estimate_noise

MAX_ITERATIONS = 25  # large scale errors and strong winds converge slowly


def problem_of(model: Model, noise: TrackNoise | None = None) -> Problem:
    """The problem of a session, its noise estimated unless given."""
    s = model.session
    noise = noise or estimate_noise(s)
    rows = 2 * len(s.tau) + int(np.isfinite(s.release).sum()) + len(s.joint)
    effects = {n: IN_FLIGHT[n] for n in model.names if n in IN_FLIGHT}
    return Problem(
        "drop", s.names, effects, model.names, known_sd(s), _parabolas(model), partial(reduce, model, noise),
        rows - 4 * len(s.middle), noise.level_sd, model, MAX_ITERATIONS,
    )  # fmt: skip


def known_sd(session: Session) -> dict[str, float]:
    """Prior sd of every nuisance: as stated, else from PRIORS."""
    known = {n: law.prior_sd if n.startswith(LOCK) else PRIORS[n][0] for n, law in NUISANCES.items()}
    known["scale"] = float(np.hypot(session.scale_sd, known["scale"]))
    known["plumb"] = session.plumb_sd_deg
    known["air"] = float(np.median([a.sd / a.share if a.share else 0.0 for a in session.air]))
    turning = 1e3 * float(np.hypot(TRACKER_PX * session.view.pixel, session.uneven_m))  # [mm] of an outline that turns
    known |= {"wobble": turning, "wobble.other": turning}
    # the optical axis lies between the fall and the middle of the view, uniformly
    aside = abs(session.view.fall) / session.view.reach / np.sqrt(3)
    return known | {"lens.x": PRIORS["lens"][0] * float(np.hypot(OFF_CENTRE, aside))}


def _parabolas(model: Model) -> np.ndarray:
    """Starts (F, 7): a straight line across and a parabola of g upwards."""
    session = model.session
    out = np.zeros((len(session.middle), STARTS))
    for f in range(len(out)):
        rows = slice(session.first[f], session.stop[f])
        tau = session.tau[rows]
        up = session.places[rows, 1] + G_M_S2 * tau**2 / 2
        slope, level = np.polynomial.polynomial.polyfit(tau, np.column_stack([session.places[rows, 0], up]), 1)[::-1]
        out[f, :5] = [*level, *slope, model.aside_square[f]]
    return out
