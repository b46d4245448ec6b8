"""Angles of sliding that were read off → static friction, Eq. 2: μ = tan α."""

import math

from benchtwin.rigs.slide.on_seeds import apparent_friction
from benchtwin.vision.evidence.readings import Derived, Summary, mean_quantity
from benchtwin.vision.recording import Recording


def static_friction(recording: Recording, read: Summary, common: float) -> Derived:
    """common: sd of the mean angle [deg] that repeats do not reduce."""
    if recording.slide.plate:
        return apparent_friction(recording, read, common)
    angle = math.radians(read.mean)
    steep = math.radians(1.0) / math.cos(angle) ** 2  # dμ/dα
    sds = steep * read.sd_mean, steep * common
    found = mean_quantity("static_friction", math.tan(angle), *sds, "1")
    return Derived((found,))
