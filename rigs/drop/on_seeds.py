"""A drop on a plate of seeds: how far the seed rises again. It flies off any way, out
of the picture's plane too, which its height does not depend on; and what is left of the
energy is no restitution, which a calibration finds by simulating such drops."""

import math

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.vision.measurement import MeasurementError, Observation, Quantity
from benchtwin.vision.motion.of_recording import Progress, need_track, seed_of
from benchtwin.vision.motion.rise import Rise, rise_of
from benchtwin.vision.overlay.plot import plot
from benchtwin.vision.recording import Recording

HEARD = ("impacts.csv", "sound")
# of a seed's thickness: how deep one sinks into the hollow between three that touch
# (1 − √(2/3)), and a little more where they do not; and sds beyond which it fell deeper
IN_A_HOLLOW, SURE = 0.3, 2.0


def height_unknown(recording: Recording) -> str:
    """Why a rise from a plate of seeds tells nothing; "" where it does."""
    if not recording.drop.plate or recording.drop.height_mm is not None:
        return ""
    return tr(
        "[drop] height_mm is missing: a seed rises from a plate of seeds by a share of"
        " its fall"
    )


def observe_on_seeds(
    recording: Recording, progress: Progress | None = None
) -> Observation:
    """Measure rebound_height [mm] and apparent_restitution; MeasurementError with the
    reason."""
    if recording.evidence in HEARD:
        raise MeasurementError(
            tr(
                "{}: impacts that were heard do not tell how far a seed rose from a"
                " plate of seeds: film it, or read the height",
                recording.path,
            )
        )
    need_track(recording)
    seen = seed_of(recording, progress, falling=True)
    risen = rise_of(seen.track, seen.recording)
    if why := fell_through(risen, recording):
        raise MeasurementError(f"{recording.path}: {why}")
    rise, sd = risen.rise_mm, risen.sd_mm
    found = [Quantity("rebound_height", rise, sd, "mm")]
    if (height := recording.drop.height_mm) is not None and rise > 0:
        e = math.sqrt(rise / height)
        found.append(Quantity("apparent_restitution", e, e / 2 * sd / rise, "1"))
    labels = ("t [s]", f"height [{seen.track.unit}]")
    said = "; ".join(q.in_words for q in found)
    picture = plot(
        seen.track.time, seen.track.y, seen.track.outlier, labels=labels, caption=said
    )
    return seen.doubted(seen.observation(found, (), {"rise": picture}))


def fell_through(risen: Rise, recording: Recording) -> str:
    """Why a fall that is longer than it is to the tops of the glued seeds ended on the
    board between them; "" where it did not, or nobody knows the seeds' size."""
    sizes, drop = recording.seed.sizes_mm, recording.drop
    if not sizes or drop.height_mm is None or not np.isfinite(risen.fall_mm):
        return ""
    deeper = risen.fall_mm - drop.height_mm
    known = float(np.hypot(drop.height_sd, risen.sd_mm))
    if deeper < IN_A_HOLLOW * min(sizes) + SURE * known:
        return ""
    return tr(
        "the seed fell {:.1f} mm deeper than the tops of the plate of seeds: it struck"
        " the board in a gap between them",
        deeper,
    )
