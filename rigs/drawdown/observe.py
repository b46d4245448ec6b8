"""A photo or a film of a draw-down → the slope above, the heap below, the time of the
flow; and what was weighed.

Both outlines are found and fitted as a pile's (`vision/pile/repose.py`), each in its
own part of the picture."""

from dataclasses import replace

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.rigs.drawdown.flow import flow_of
from benchtwin.sim.rigs.drawdown import TIMED
from benchtwin.vision.board.camera import with_board
from benchtwin.vision.evidence.frames import open_frames
from benchtwin.vision.evidence.photo import read_photo
from benchtwin.vision.measurement import (
    MeasurementError,
    Observation,
    Quantity,
    failed,
)
from benchtwin.vision.motion.of_recording import PICTURES, Progress
from benchtwin.vision.overlay.pile import draw_repose
from benchtwin.vision.pile.pitch import SLAB
from benchtwin.vision.pile.repose import MAIN, PileOptions, Repose, measure_repose
from benchtwin.vision.recording import Recording

# what weighings of one run may be off by together: a kitchen scale reads whole grams,
# and a seed or two jump off the bench
SCALE_SD_G = 0.5
TIMED_SD_S = 0.01  # a frame of a slow-motion film at either end
# seeds that a slot must be wide to run freely as a rule: narrower ones are bridged
# (Janda et al. 2008, EPL 84, 44002, for discs)
FREE_WIDTHS = 3.0
PANES = (
    "[drawdown] pane_friction is not stated: a calibration then averages over what is"
    " believed of panes, and tells less"
)


def observe_drawdown(
    recording: Recording,
    options: PileOptions | None = None,
    progress: Progress | None = None,
) -> Observation:
    """Measure the first photo, or the film's last picture: shear_angle, shear_centroid
    above, heap_angle, heap_centroid below [deg]; flow_time [s] of the film, else as
    stated; mass_flow [g/s] where masses are stated. MeasurementError where neither the
    slope nor the heap can be measured."""
    if recording.evidence not in ("photos", *PICTURES):
        raise MeasurementError(
            tr(
                "{}: a draw-down is measured on a film, or on a photo of what is at"
                " rest, not on {}",
                recording.path,
                recording.evidence,
            )
        )
    stated = recording.drawdown
    if stated.upper_px is None or stated.lower_px is None:
        raise MeasurementError(
            tr(
                "{}: [drawdown] upper_px and lower_px are missing: where in the photo"
                " the slope above and the heap below are (left, top, width, height)",
                recording.toml,
            )
        )
    if recording.evidence == "photos":
        image, time = read_photo(recording.files[0]), _stated_time(recording)
        notes = []
    else:
        source = open_frames(recording)
        flow = flow_of(source.iterate(), stated.upper_px, str(recording.path))
        image, time = flow.last, Quantity("flow_time", flow.time_s, flow.sd_s, "s")
        notes = list(source.notes)
    parts = {
        "shear": PileOptions(
            roi=stated.upper_px, baseline=stated.shelf_px, side="right", form=SLAB
        ),
        "heap": PileOptions(roi=stated.lower_px, baseline=stated.tray_px, form=SLAB),
    }
    seen = with_board(recording, image)
    notes += seen.notes
    found: dict[str, Repose | str] = {}
    for name, how in parts.items():
        try:
            found[name] = measure_repose(seen.picture, seen.recording.camera, how)
        except MeasurementError as error:
            found[name] = f"{recording.files[0]}: {error}"
    if all(isinstance(one, str) for one in found.values()):
        raise MeasurementError("; ".join(map(str, found.values())))
    doubts = (*doubts_of(recording), *([seen.doubt] if seen.doubt else []))
    angles = tuple(
        _angle(f"{part}_{what}", of, one).doubt(*doubts)
        for part, one in found.items()
        for what, of in (("angle", MAIN), ("centroid", "centroid_angle"))
    )
    notes += [n for one in found.values() if isinstance(one, Repose) for n in one.notes]
    notes += [tr(PANES)] if stated.pane_friction is None and not stated.slab else []
    pictures = {
        name: draw_repose(image, one)
        for name, one in found.items()
        if isinstance(one, Repose)
    }
    return Observation(
        recording.id,
        "drawdown",
        (*angles, *_flow(recording, time, doubts)),
        tuple(dict.fromkeys(notes)),
        pictures,
    )


def _angle(name: str, of: str, found: Repose | str) -> Quantity:
    """A quantity of an outline under the name that it has here."""
    if isinstance(found, str):
        return failed(name, "deg", found)
    return replace(next(q for q in found.quantities if q.name == of), name=name)


def _stated_time(recording: Recording) -> Quantity | None:
    time = recording.drawdown.flow_time_s
    return None if time is None else Quantity("flow_time", time, TIMED_SD_S, "s")


def _flow(
    recording: Recording, time: Quantity | None, doubts: tuple[str, ...]
) -> tuple[Quantity, ...]:
    """flow_time, and mass_flow = (9/10 − 1/10)(filled − retained)/flow_time."""
    if time is None:
        return ()
    stated, time = recording.drawdown, time.doubt(*doubts)
    if stated.filled_mass_g is None or stated.retained_mass_g is None:
        return (time,)
    timed = (TIMED[1] - TIMED[0]) * (stated.filled_mass_g - stated.retained_mass_g)
    flow, off = timed / time.value, np.sqrt(2) * SCALE_SD_G
    sd = float(np.hypot(flow * time.sd / time.value, off / time.value))
    return time, Quantity("mass_flow", flow, sd, "g/s").doubt(*doubts)


def doubts_of(recording: Recording) -> tuple[str, ...]:
    """What speaks against a run: grams that are missing, a slot that seeds bridge."""
    stated, seed = recording.drawdown, recording.seed
    told = []
    out = (stated.tray_mass_g, stated.spilt_mass_g)
    masses = (stated.filled_mass_g, stated.retained_mass_g, *out)
    if None not in masses:
        filled, *parts = masses
        lost = filled - sum(parts)
        if abs(lost) > 3 * np.sqrt(len(masses)) * SCALE_SD_G:
            word = tr("missing") if lost > 0 else tr("too many")
            told.append(
                tr(
                    "{:.1f} g are {}: {:g} g were filled in, {:g} g were found again",
                    abs(lost),
                    word,
                    filled,
                    sum(parts),
                )
            )
    if (
        stated.slot_mm
        and seed.width_mm
        and stated.slot_mm < FREE_WIDTHS * seed.width_mm
    ):
        told.append(
            tr(
                "the slot is {:.1f} seeds wide: such a slot jams; {:g} and more run",
                stated.slot_mm / seed.width_mm,
                FREE_WIDTHS,
            )
        )
    return tuple(told)
