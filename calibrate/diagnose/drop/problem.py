"""The drop as a problem: its nuisances, its noise, its parabolas to begin with."""

from functools import partial

import numpy as np

from calibrate.diagnose.air import G_M_S2
from calibrate.diagnose.drop.model import LAWS, STARTS, Model
from calibrate.diagnose.drop.noise_of_track import TRACKER_PX, TrackNoise, estimate_noise
from calibrate.diagnose.drop.nuisances import LENS, LOCK, OFF_CENTRE
from calibrate.diagnose.drop.reduction import reduce
from calibrate.diagnose.drop.session import Session
from calibrate.diagnose.effects.drop import EFFECTS
from calibrate.diagnose.problem import Problem

GRAVITY_SD = 5e-4  # of g at an unknown place on earth, beside 9.80665: a twin of the scale, so part of what is known of it
PERSPECTIVE_SD = 1e-3
WOBBLE = "silhouette-wobble"
TURNS = 25  # where a scale is far off and a wind strong, or drag trades with its slope, a few end half way


def problem_of(model: Model, noise: TrackNoise | None = None) -> Problem:
    """What this session leaves open, its noise estimated from itself unless given."""
    s = model.session
    noise = noise or estimate_noise(s)
    rows = 2 * len(s.tau) + int(np.isfinite(s.release).sum()) + len(s.joint)
    return Problem(
        "drop", s.names, EFFECTS, model.names, baseline_sd(s), _parabolas(model), partial(reduce, model, noise),
        rows - 4 * len(s.middle), noise.level_sd, model, TURNS,
    )  # fmt: skip


def baseline_sd(session: Session) -> dict[str, float]:
    """What a good bench leaves open: sd of every global about 0 in the baseline; what is not named is fixed at nil."""
    known = {
        "scale-error": float(np.hypot(session.scale_sd, GRAVITY_SD)), "camera-roll": session.plumb_sd_deg,
        "perspective": PERSPECTIVE_SD, "drag": float(np.median([a.sd for a in session.air])),
    }  # fmt: skip
    turning = 1e3 * float(np.hypot(TRACKER_PX * session.view.pixel, session.uneven_m))  # of an outline that turns
    known |= {n: turning for n, law in LAWS.items() if law.name == WOBBLE or law.group == WOBBLE}
    known |= {n: law.prior_sd for n, law in LAWS.items() if n.startswith((LOCK, "lens", "drag-slope"))}
    # a camera looks at the fall, at the middle of what was seen, or between: evenly spread
    aside = abs(session.view.fall) / session.view.reach / np.sqrt(3)
    return known | {"lens.x": LENS * float(np.hypot(OFF_CENTRE, aside))}


def _parabolas(model: Model) -> np.ndarray:
    """Starts (F, 7) of a straight line across and a parabola of g upwards."""
    session = model.session
    out = np.zeros((len(session.middle), STARTS))
    for f in range(len(out)):
        rows = slice(session.first[f], session.stop[f])
        tau = session.tau[rows]
        up = session.places[rows, 1] + G_M_S2 * tau**2 / 2
        slope, level = np.polynomial.polynomial.polyfit(tau, np.column_stack([session.places[rows, 0], up]), 1)[::-1]
        out[f, :5] = [*level, *slope, model.aside_square[f]]
    return out
