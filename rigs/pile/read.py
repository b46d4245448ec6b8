"""Surfaces of piles, and how they came about, as plain arrays: what a diagnosis is made
from, read by the same code for bench and twin."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.twin.pair import Curve
from benchtwin.twin.seen import Observed, no_rows, sections_of, seen_of
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.motion.of_recording import PICTURES
from benchtwin.vision.pile.collapse import Collapse
from benchtwin.vision.pile.repose import Repose
from benchtwin.vision.recording import Recording

SECTIONS = ("seed", "camera", "pile")


@dataclass(frozen=True, eq=False)
class SeenPile:
    """One photo of a heap. x to the right, z up, as the picture has them (not turned
    upright), in `unit`: "mm" or, where no scale is stated, "px".

    x, z (n,): the surface, NaN where there is none; hidden (n,): where a layer of seeds
    hides it and the flank is led on, empty: nowhere; base_z: of the plate's line at x =
    0; base_deg, base_sd_deg: its inclination, clockwise from the picture's rows;
    base_source: how it was found (vision.pile.base_line.BASES; "toe": it was not seen);
    crest_x; toes_x: where the left and the right flank end, None where that side has
    none (a wall, the picture's edge); description: sections of recording.toml as plain
    values, `camera.plumb_sd_deg` with what holds where nothing is stated; trouble: why
    there is nothing, "" when there is; heap: the recording whose heap it is, alike for
    all photos of one recording (its recording.toml tells of one run), "" where each
    photo is taken for a heap of its own; collapse: by its film, None without one;
    clocked: whether the film's frame rate is stated."""

    recording: str
    session: str
    x: np.ndarray = field(default_factory=no_rows)
    z: np.ndarray = field(default_factory=no_rows)
    unit: str = "px"
    base_z: float = float("nan")
    base_deg: float = float("nan")
    base_sd_deg: float = float("nan")
    base_source: str = ""
    crest_x: float = float("nan")
    toes_x: tuple[float | None, float | None] = (None, None)
    description: dict = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    trouble: str = ""
    heap: str = ""
    hidden: np.ndarray = field(default_factory=no_rows)
    collapse: Collapse | None = None
    clocked: bool = False


def read_piles(folder: Path | Observed) -> list[SeenPile]:
    """Every photo or film of a pile under `folder`; one that cannot be used says why.
    FileNotFoundError without a folder."""
    return list(seen_of(folder, "pile", SeenPile, _seen, describe))


def _seen(entry: Recording, observed: Observed) -> list[SeenPile]:
    if entry.evidence not in ("photos", *PICTURES):
        raise MeasurementError(
            tr(
                "{}: {} holds no surface; a pile is diagnosed from photos or films",
                entry.path,
                entry.evidence,
            )
        )
    try:
        seen = observed.observe(entry)
    except OSError as error:
        reason = f"{error.filename or entry.path}: {error.strerror or error}"
        raise MeasurementError(reason) from error
    assert seen.heap is not None  # every pile that is measured shows one
    told = {"collapse": seen.collapse, "clocked": entry.camera.fps is not None}
    return [replace(pile_of(seen.heap, entry), **told)]


def pile_of(found: Repose, recording: Recording) -> SeenPile:
    """What was found in a photo, in millimetres where a scale is stated."""
    scale = recording.camera.mm_per_px or 1.0
    columns = np.arange(found.surface.size)
    doubts = tuple(dict.fromkeys(q.reason for q in found.quantities if q.reason))
    left, right = (None if toe is None else scale * toe for toe in found.toes)
    return SeenPile(
        recording.id,
        recording.session or "",
        scale * columns,
        -scale * found.surface,
        "mm" if recording.camera.mm_per_px else "px",
        -scale * found.base.intercept,
        float(np.degrees(np.arctan(found.base.slope))),
        float(np.degrees(found.base.slope_sd)),
        found.base.source,
        scale * (found.crest[0] - found.roi[0]),
        (left, right),
        describe(recording),
        (*found.notes, *doubts),
        hidden=found.hidden,
        heap=str(recording.path) if recording.toml.is_file() else "",
    )


def describe(recording: Recording) -> dict:
    """Sections of recording.toml as plain values; plumb_sd_deg is always there."""
    sections = sections_of(recording, *SECTIONS)
    sections["camera"] |= {"plumb_sd_deg": recording.camera.plumb_sd}
    return sections


def curve(pile: SeenPile, *, relative: bool, timed: bool) -> Curve:
    """Heights above the plate from the crest's side outwards; in units of the crest's
    height where it is `relative`, or the scale unknown."""
    height = pile.z - pile.base_z + np.tan(np.radians(pile.base_deg)) * pile.x
    there = np.isfinite(height) & (pile.x >= pile.crest_x)
    x, y = pile.x[there] - pile.crest_x, np.maximum(height[there], 0.0)
    if x.size < 2:
        raise MeasurementError(
            tr("{}: no flank to the right of the crest", pile.recording)
        )
    if not relative and pile.unit == "mm":
        return Curve("distance (mm)", "height (mm)", x, y)
    over, tall = "over the crest's height", float(y.max())
    return Curve(f"distance {over}", f"height {over}", x / tall, y / tall)
