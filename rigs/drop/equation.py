"""Heights of rebound that were read off → restitution, Eq. 1: e = √(H₂/H₁)."""

from benchtwin.bench.language import tr
from benchtwin.vision.evidence.readings import Derived, Summary, root_of_heights
from benchtwin.vision.recording import Recording

LEAST_REBOUND = 2e-3  # of the height; e below 0.045 was hardly read in millimetres


def restitution(recording: Recording, read: Summary, common: float) -> Derived:
    """common: sd of the mean rebound [mm] that repeats do not reduce. On a plate of
    seeds the apparent restitution e' = √(h'/h): what is left of the energy."""
    drop = recording.drop
    height, on_seeds = drop.height_mm, drop.plate is not None
    if height is None:
        missing = tr("[drop] height_mm is missing; without it no restitution (Eq. 1)")
        notes = () if on_seeds else (f"{recording.toml}: {missing}",)
        return Derived(notes=notes)
    doubt = ""
    if read.high > height:
        what = tr("rise") if on_seeds else tr("rebound")
        doubt = tr(
            "a {} of {:g} mm is higher than the release at {:g} mm",
            what,
            read.high,
            height,
        )
    elif read.mean < LEAST_REBOUND * height and not on_seeds:
        doubt = tr(
            "a rebound of {:g} mm from {:g} mm: is it in millimetres?",
            read.mean,
            height,
        )
    if not read.mean:
        return Derived(doubts=(doubt,))
    name = "apparent_restitution" if on_seeds else "restitution"
    found = root_of_heights(name, read, common, height, drop.height_sd)
    return Derived((found,), doubts=(doubt,))
