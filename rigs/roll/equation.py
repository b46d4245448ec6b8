"""Run-outs that were read off → rolling friction, Eq. 3:
μ_r = S sin β / (S cos β + L)."""

import numpy as np

from benchtwin.bench.priors import stated_sd
from benchtwin.bench.run_out import rolling_friction
from benchtwin.vision.evidence.readings import Derived, Summary, mean_quantity
from benchtwin.vision.recording import Recording


def friction_of_run_out(recording: Recording, read: Summary, common: float) -> Derived:
    """common: sd of the mean run-out [mm] that repeats do not reduce."""
    length, beta = recording.roll.incline_length_mm, recording.roll.incline_deg
    if length is None or beta is None:
        missing = "[roll] incline_length_mm and incline_deg are needed for"
        note = f"{recording.toml}: {missing} rolling_friction (Eq. 3)"
        return Derived(notes=(note,))
    mu, by = rolling_friction(length, beta, read.mean)
    off = [stated_sd("way-on-incline"), stated_sd("incline"), common]
    shared = float(np.linalg.norm(by * off))
    own = -by[2] * read.sd_mean
    return Derived((mean_quantity("rolling_friction", mu, own, shared, "1"),))
