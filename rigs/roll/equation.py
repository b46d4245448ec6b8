"""Run-outs that were read off → rolling friction, Eq. 3 (bench/run_out.py), on a plate
that is level, or sloped as stated."""

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.bench.priors import stated_sd, unstated_sd
from benchtwin.bench.run_out import rolling_friction
from benchtwin.vision.evidence.readings import Derived, Summary, mean_quantity
from benchtwin.vision.recording import Recording

NO_DIRECTION = (
    "[roll] slope_deg is stated and [roll] direction is not: whether the seed rolls"
    " down the slope or up is unknown"
)


def friction_of_run_out(recording: Recording, read: Summary, common: float) -> Derived:
    """common: sd of the mean run-out [mm] that repeats do not reduce."""
    length, beta = recording.roll.incline_length_mm, recording.roll.incline_deg
    if length is None or beta is None:
        missing = tr("[roll] incline_length_mm and incline_deg are needed for")
        note = tr("{}: {} rolling_friction (Eq. 3)", recording.toml, missing)
        return Derived(notes=(note,))
    slope, direction = recording.roll.slope_deg, recording.roll.direction
    known = slope is not None and direction is not None
    falls = 0.0 if not known else -slope if direction == "-x" else slope
    mu, by = rolling_friction(length, beta, read.mean, falls)
    level = stated_sd("level-plate") if known else unstated_sd("level-plate")
    off = [stated_sd("way-on-incline"), stated_sd("incline"), common, level]
    shared = float(np.linalg.norm(by * off))
    own = abs(by[2]) * read.sd_mean
    found = mean_quantity("rolling_friction", mu, own, shared, "1")
    return Derived((found.doubt("" if known or slope is None else tr(NO_DIRECTION)),))
