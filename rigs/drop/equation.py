"""Heights of rebound that were read off → restitution, Eq. 1: e = √(H₂/H₁)."""

import math

from benchtwin.rigs.drop.on_seeds import apparent_restitution
from benchtwin.vision.evidence.readings import Derived, Summary, mean_quantity
from benchtwin.vision.recording import Recording

LEAST_REBOUND = 2e-3  # of the height; e below 0.045 was hardly read in millimetres


def restitution(recording: Recording, read: Summary, common: float) -> Derived:
    """common: sd of the mean rebound [mm] that repeats do not reduce."""
    if recording.drop.plate:
        return apparent_restitution(recording, read, common)
    height = recording.drop.height_mm
    if height is None:
        missing = "[drop] height_mm is missing; without it no restitution (Eq. 1)"
        return Derived(notes=(f"{recording.toml}: {missing}",))
    doubt = ""
    if read.high > height:
        doubt = f"a rebound of {read.high:g} mm is higher than the release at"
        doubt = f"{doubt} {height:g} mm"
    elif read.mean < LEAST_REBOUND * height:
        doubt = f"a rebound of {read.mean:g} mm from {height:g} mm: is it in"
        doubt = f"{doubt} millimetres?"
    if not read.mean:
        return Derived(doubts=(doubt,))
    e = math.sqrt(read.mean / height)
    own = e / 2 * read.sd_mean / read.mean
    shared = math.hypot(common / read.mean, recording.drop.height_sd / height)
    found = mean_quantity("restitution", e, own, e / 2 * shared, "1")
    return Derived((found,), doubts=(doubt,))
