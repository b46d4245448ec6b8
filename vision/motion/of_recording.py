"""The track of a recording: from its table, its light gates or its pictures."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pandas as pd

from benchtwin.bench.language import tr
from benchtwin.bench.rigs import RIGS
from benchtwin.vision.board.camera import with_board
from benchtwin.vision.evidence.frames import FrameSource, open_frames
from benchtwin.vision.foreign.as_evidence import read_track
from benchtwin.vision.measurement import (
    DOUBTFUL,
    MeasurementError,
    Observation,
    Quantity,
)
from benchtwin.vision.motion.film_doubts import camera_moved, size_doubt, stated_area_px
from benchtwin.vision.motion.template import by_template
from benchtwin.vision.motion.track import (
    Track,
    places_of,
    struck_out,
    track_from_gates,
    track_from_table,
)
from benchtwin.vision.motion.track_seed import TrackedSeed, track_seed
from benchtwin.vision.recording import Recording

Progress = Callable[[float], None]
TABLES, PICTURES = ("track.csv", "gates.csv"), ("frames", "video")


def table_track(recording: Recording) -> Track:
    """The track that a table holds, without the rows that are struck out."""
    if recording.evidence == "gates.csv":
        return track_from_gates(recording)
    table = read_track(recording.files[0])
    track = track_from_table(table.rows, recording.camera, table.notes)
    return struck_out(track, recording)


def need_track(recording: Recording) -> None:
    """MeasurementError where the evidence is of another kind than tables and
    pictures of a motion."""
    if recording.evidence in (*TABLES, *PICTURES):
        return
    of_others = [rig.told_by.get(recording.evidence) for rig in RIGS.values()]
    why = "".join(f": {told}" for told in of_others if told)
    raise MeasurementError(
        tr(
            "{}: {} of a {} cannot be followed{}; frames, a video or track.csv can",
            recording.path,
            recording.evidence,
            recording.rig,
            why,
        )
    )


@dataclass(frozen=True)
class Tabled:
    """The track that a recording's table holds; it answers as `Followed` does."""

    recording: Recording
    track: Track

    def observation(
        self,
        quantities: Iterable[Quantity],
        notes: Iterable[str],
        pictures: dict[str, np.ndarray],
    ) -> Observation:
        """What was measured."""
        notes = (*self.track.notes, *notes)
        return observation(self.recording, quantities, notes, pictures, self.track)

    def doubted(self, found: Observation) -> Observation:
        """The observation: a table shows nothing of a film."""
        return found


@dataclass(frozen=True)
class Followed:
    """What was followed in the pictures of a recording. recording: with what a printed
    board in the picture tells of the camera where it is not stated; doubt: where board
    and statements disagree; tracked: with places in px, frames struck out."""

    recording: Recording
    source: FrameSource
    tracked: TrackedSeed
    notes: tuple[str, ...]
    falling: bool = False
    doubt: str = ""

    @property
    def height_px(self) -> int:
        """Of the picture; places of the track count up from its last row."""
        return self.tracked.scene.shape[0]

    @cached_property
    def track(self) -> Track:
        """In mm where the scale is known."""
        return self.tracked.track.in_mm(self.recording.camera.mm_per_px)

    def observation(
        self,
        quantities: Iterable[Quantity],
        notes: Iterable[str],
        pictures: dict[str, np.ndarray],
        track: Track | None = None,
        places: tuple[np.ndarray, np.ndarray] | None = None,
    ) -> Observation:
        """What was measured, with the places (columns, rows) in the pictures. track:
        what was measured on, where it is another than what was followed."""
        track = track or self.track
        notes = (*track.notes, *self.notes, *notes)
        found = observation(self.recording, quantities, notes, pictures, track)
        return self.with_places(found, places)

    def with_places(
        self, found: Observation, places: tuple[np.ndarray, np.ndarray] | None = None
    ) -> Observation:
        """The observation with the places (columns, rows) in the pictures."""
        track = self.tracked.track
        x, y = places or (track.x, self.height_px - 1 - track.y)
        columns = {"frame": track.frame, "x_px": x, "y_px": y}
        table = pd.DataFrame(columns | {"left_out": track.outlier})
        return replace(found, places=table)

    def doubted(self, found: Observation) -> Observation:
        """The observation with the doubts about the film."""
        found = doubted(found, size_doubt(self.tracked, self.recording, self.falling))
        return doubted(doubted(found, self.doubt), camera_moved(self.source))


def seed_of(
    recording: Recording, progress: Progress | None, falling: bool = False
) -> Tabled | Followed:
    """The seed that moves, in a table or from picture to picture; MeasurementError
    where the evidence is of another kind."""
    need_track(recording)
    if recording.evidence in TABLES:
        return Tabled(recording, table_track(recording))
    return follow_seed(recording, progress, falling)


def follow_seed(
    recording: Recording, progress: Progress | None, falling: bool = False
) -> Followed:
    """The seed that moves, from picture to picture."""
    source = open_frames(recording)
    places = places_of(recording.track)
    tracked = track_seed(
        source,
        falling=falling,
        progress=progress,
        at=recording.track.follow_px,
        area_px=stated_area_px(recording),
        places=places,
        only_places=bool(recording.track.only_places),
    )
    if not places:
        tracked = by_template(tracked, source, outside=not falling)
    return replace(followed(recording, source, tracked), falling=falling)


def followed(
    recording: Recording, source: FrameSource, tracked: TrackedSeed
) -> Followed:
    """The same with frames struck out, and with the scale in the picture."""
    tracked = replace(tracked, track=struck_out(tracked.track, recording))
    # a printed board behind the motion tells of the camera
    behind = tracked.scene.grey_background
    picture = np.clip(behind * (255 / max(float(behind.max()), 1.0)), 0, 255)
    seen = with_board(recording, picture.astype(np.uint8))
    notes = (*source.notes, *seen.notes)
    if seen.recording.camera.mm_per_px is None and not seen.notes:
        notes += (tr("no scale: [camera] mm_per_px is missing, and no board is seen"),)
    return Followed(seen.recording, source, tracked, notes, doubt=seen.doubt)


def observation(
    recording: Recording,
    quantities: Iterable[Quantity],
    notes: Iterable[str],
    pictures: dict[str, np.ndarray],
    track: Track,
    bounces: pd.DataFrame | None = None,
) -> Observation:
    """What was measured on a track, each note once."""
    return Observation(
        recording.id,
        recording.need_rig(),
        tuple(quantities),
        tuple(dict.fromkeys(notes)),
        pictures,
        track.to_table(),
        bounces,
    )


def doubted(found: Observation, doubt: str) -> Observation:
    """The observation with one doubt added to every quantity and bounce; unchanged
    where the doubt is empty."""
    if not doubt:
        return found
    bounces = found.bounces
    if bounces is not None:
        bounces = bounces.assign(quality=DOUBTFUL)
    quantities = tuple(q.doubt(doubt) for q in found.quantities)
    return replace(found, quantities=quantities, bounces=bounces)
