"""How far seeds rise from a bed → apparent restitution e' = √(h'/h), from the mean of
h': what is left of the energy."""

from benchtwin.bench.language import tr
from benchtwin.bench.priors import stated_sd
from benchtwin.vision.evidence.readings import Derived, Summary, root_of_heights
from benchtwin.vision.recording import Recording

LEAST_LAYERS = 3.0  # seeds: through a thinner bed the floor is felt


def apparent_restitution(recording: Recording, read: Summary, common: float) -> Derived:
    """common: sd of the mean rise [mm] that repeats do not reduce. 0 mm: it stayed."""
    height, doubt = recording.bed.height_mm, doubt_of(recording)
    if height is None:
        missing = tr("[bed] height_mm is missing; without it no apparent restitution")
        return Derived(notes=(f"{recording.toml}: {missing}",), doubts=(doubt,))
    if read.high > height:
        high = tr(
            "a rise of {:g} mm is higher than the release at {:g} mm", read.high, height
        )
        doubt = "; ".join(filter(None, (doubt, high)))
    if not read.mean > 0:
        return Derived(notes=(tr("every seed stayed on the bed"),), doubts=(doubt,))
    known = height, stated_sd("release-height")
    found = root_of_heights("apparent_restitution", read, common, *known)
    return Derived((found,), doubts=(doubt,))


def doubt_of(recording: Recording) -> str:
    """What speaks against a bed; ""."""
    depth, thick = recording.bed.depth_mm, recording.seed.thickness_mm
    if depth is None or thick is None or depth >= LEAST_LAYERS * thick:
        return ""
    return tr(
        "the bed is {:.1f} seeds deep: below {:g} the floor is felt",
        depth / thick,
        LEAST_LAYERS,
    )
