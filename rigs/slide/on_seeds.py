"""A card of seeds on a plate of seeds: the plate's angle when the card has slid off. It
is no angle of friction, for the seeds stand in each other's hollows; a calibration
finds friction by simulating such slides."""

import math

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.bench.priors import unstated_sd
from benchtwin.bench.seed_plate import LAID_BY_HAND
from benchtwin.vision.evidence.frames import open_frames
from benchtwin.vision.evidence.readings import Derived, Summary, mean_quantity
from benchtwin.vision.measurement import MeasurementError, Observation, Quantity
from benchtwin.vision.motion.of_recording import (
    TABLES,
    Followed,
    Progress,
    Tabled,
    followed,
    need_track,
    table_track,
)
from benchtwin.vision.motion.tilting_plate import track_slide
from benchtwin.vision.motion.track import Track
from benchtwin.vision.overlay.plot import plot
from benchtwin.vision.recording import Recording

LEAST_SEEDS = 3  # on a card: it stands on so many
TRAVEL_MM = 20.0  # it has slid off when it has gone so far, where nothing is stated


def observe_on_seeds(
    recording: Recording, progress: Progress | None = None
) -> Observation:
    """Measure slide_angle [deg] and apparent_friction; MeasurementError with the
    reason."""
    need_track(recording)
    seen: Tabled | Followed
    if recording.evidence in TABLES:
        seen = Tabled(recording, table_track(recording))
    else:
        source = open_frames(recording)
        tracked, _ = track_slide(source, recording, progress)
        seen = followed(recording, source, tracked)
    angle = angle_when_gone(seen.track, seen.recording)
    sd = unstated_sd("tilt-sensor-zero")
    found = [Quantity("slide_angle", angle, sd, "deg"), _apparent(angle, sd, 0.0)]
    said = "; ".join(q.in_words for q in found)
    labels = ("t [s]", f"travel [{seen.track.unit}]")
    picture = plot(
        seen.track.time, seen.track.x, seen.track.outlier, labels=labels, caption=said
    )
    return seen.observation(found, (), {"slide": picture})


def angle_when_gone(track: Track, recording: Recording) -> float:
    """The plate's angle [deg] when the card has gone `travel_mm`, either way;
    MeasurementError where it does not, or the angle is unknown."""
    track.need_physical(recording)
    used, stated = track.used(), recording.slide
    travel = np.abs(used.x - np.median(used.x[:5]))
    far = stated.travel_mm or TRAVEL_MM
    gone = np.flatnonzero(travel >= far)
    if not gone.size or not gone[0]:
        raise MeasurementError(
            tr(
                "{}: the card goes {:.0f} mm, and counts as slid off after {:g}:"
                " [slide] travel_mm states another way",
                recording.path,
                travel.max(),
                far,
            )
        )
    tilt = used.tilt_deg
    if tilt is None or not np.isfinite(tilt).all():
        rate, start = stated.tilt_rate_deg_s, stated.start_deg
        if rate is None or start is None:
            raise MeasurementError(
                tr(
                    "{}: the plate's angle is unknown: give a tilt_deg column in"
                    " track.csv, or [slide] start_deg and tilt_rate_deg_s",
                    recording.toml,
                )
            )
        tilt = start + rate * (used.t_s - used.t_s[0])
    rows = slice(gone[0] - 1, gone[0] + 1)
    return float(np.interp(far, travel[rows], tilt[rows]))


def apparent_friction(recording: Recording, read: Summary, common: float) -> Derived:
    """common: sd of the mean angle [deg] that repeats do not reduce."""
    found = _apparent(read.mean, read.sd_mean, common)
    return Derived((found,))


def card_unknown(recording: Recording) -> str:
    """Why an angle on a plate of seeds tells nothing; "" where it does."""
    slide, seed = recording.slide, recording.seed
    if not slide.plate:
        return ""
    if slide.card_mm is None:
        return tr(
            "[slide] card_mm is missing: a larger card slides on a plate of seeds at a"
            " smaller angle"
        )
    if seed.length_mm is None or seed.width_mm is None:
        return ""
    covered = (slide.coverage or LAID_BY_HAND) * math.prod(slide.card_mm)
    seeds = covered / (math.pi / 4 * seed.length_mm * seed.width_mm)
    if round(seeds) >= LEAST_SEEDS:
        return ""
    return tr(
        "[slide] card_mm: about {:.0f} seeds have room on it, and a card rocks or rolls"
        " on fewer than {}: glue more to a larger one",
        seeds,
        LEAST_SEEDS,
    )


def _apparent(angle_deg: float, own_deg: float, common_deg: float) -> Quantity:
    """tan α, as on a smooth plate."""
    angle = math.radians(angle_deg)
    steep = math.radians(1.0) / math.cos(angle) ** 2
    sds = steep * own_deg, steep * common_deg
    return mean_quantity("apparent_friction", math.tan(angle), *sds, "1")
