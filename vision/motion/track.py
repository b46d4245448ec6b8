"""A track: the places of one seed over time, with standard deviations; those that
somebody set by hand, frame by frame, where the tracker fails or errs."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from benchtwin.bench.constants import G_MM_S2
from benchtwin.bench.keys import Tracking
from benchtwin.bench.language import tr
from benchtwin.bench.priors import unstated_sd
from benchtwin.vision.evidence.tables import GATE_PLACE, read_gates
from benchtwin.vision.measurement import MeasurementError, require
from benchtwin.vision.motion.outliers import slips
from benchtwin.vision.recording import Camera, Recording

LEAST_PLACES = 4  # that make a track of their own: a parabola and one to check it
# sd of a click on the middle of a seed, each way; fits that scale their errors by what
# is left over find the true one
PLACE_SD_PX = 1.0
Places = Mapping[int, tuple[float, float]]  # frame → x, y [px]
_ALWAYS = ("frame", "t_s", "x", "y", "sd", "outlier")
_OPTIONAL = ("angle_deg", "angle_sd_deg", "tilt_deg", "late")


@dataclass(frozen=True)
class Track:
    """Arrays of one length n, in the order of time. x to the right, y up, in `unit`
    ("mm" or "px").

    frame: numbers as recorded (a lost frame is a missing row). t_s: all NaN without a
    frame rate. sd: of x and of y, each; NaN where not stated. angle_deg: unwrapped,
    anticlockwise; NaN where unknown; None where not measured. tilt_deg: the plate's
    angle at the same time. late: in which share of a rolling shutter's readout, after
    t_s, each row was read; None where that counts for nothing. outlier: rows that no
    fit uses."""

    frame: np.ndarray
    t_s: np.ndarray
    x: np.ndarray
    y: np.ndarray
    sd: np.ndarray
    unit: str
    outlier: np.ndarray
    angle_deg: np.ndarray | None = None
    angle_sd_deg: np.ndarray | None = None
    tilt_deg: np.ndarray | None = None
    tilt_sd_deg: float | None = None
    late: np.ndarray | None = None
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.frame)

    @property
    def timed(self) -> bool:
        return bool(np.isfinite(self.t_s).all())

    @property
    def physical(self) -> bool:
        """Whether lengths are in mm and times in s."""
        return self.unit == "mm" and self.timed

    def need_physical(self, recording: Recording) -> None:
        """MeasurementError, naming the missing key, unless lengths are in mm and times
        in s."""
        if not self.physical:
            key = "mm_per_px" if self.unit != "mm" else "fps"
            raise MeasurementError(
                tr(
                    "{}: [camera] {} is missing; an acceleration needs lengths and"
                    " times",
                    recording.toml,
                    key,
                )
            )

    def in_mm(self, mm_per_px: float | None) -> "Track":
        """In millimetres where the scale is known; else unchanged."""
        if self.unit == "mm" or not mm_per_px:
            return self
        x, y, sd = (values * mm_per_px for values in (self.x, self.y, self.sd))
        return replace(self, x=x, y=y, sd=sd, unit="mm")

    @property
    def time(self) -> np.ndarray:
        """Seconds, or frames where the frame rate is unknown."""
        return self.t_s if self.timed else self.frame.astype(float)

    @property
    def time_unit(self) -> str:
        return "s" if self.timed else "frame"

    @property
    def step(self) -> float:
        """Median time from one frame to the next."""
        return float(np.median(np.diff(self.time) / np.maximum(np.diff(self.frame), 1)))

    def upright(self, plumb_deg: float | None) -> tuple[np.ndarray, np.ndarray]:
        """Height and sideways place in axes along gravity; plumb_deg: clockwise from
        straight down, None: 0."""
        turn = np.radians(plumb_deg or 0.0)
        return (
            self.x * np.sin(turn) + self.y * np.cos(turn),
            self.x * np.cos(turn) - self.y * np.sin(turn),
        )

    def used(self) -> "Track":
        """Without the outliers."""
        return self if not self.outlier.any() else self.take(~self.outlier)

    def read_out(self, readout_s: float) -> "Track":
        """Each row at the time at which a rolling shutter read it."""
        if not readout_s or self.late is None:
            return self
        return replace(self, t_s=self.t_s + readout_s * self.late)

    def take(self, rows: np.ndarray | slice) -> "Track":
        """Some of the rows (a mask, indices or a slice)."""
        names = (*_ALWAYS, *_OPTIONAL)
        held: dict[str, Any] = {n: getattr(self, n) for n in names}
        return replace(self, **{n: c[rows] for n, c in held.items() if c is not None})

    def marked(self, outlier: np.ndarray) -> "Track":
        """The same track with more rows marked as outliers."""
        return replace(self, outlier=self.outlier | outlier)

    def to_table(self) -> pd.DataFrame:
        """The columns of track.csv, plus the frame number, the sds and the outlier
        mark; unknown columns are left out."""
        unit, names = self.unit, ("frame", "t_s", "x", "y", "sd", *_OPTIONAL)
        named = {f"{n}_{unit}" if n in ("x", "y", "sd") else n: n for n in names}
        columns = {column: getattr(self, name) for column, name in named.items()}
        table = pd.DataFrame({**columns, "outlier": self.outlier.astype(int)})
        return table.drop(columns=[c for c in named if table[c].isna().all()])


def make_track(
    t_s: ArrayLike | None,
    x: ArrayLike,
    y: ArrayLike,
    *,
    unit: str = "mm",
    frame: ArrayLike | None = None,
    sd: ArrayLike = np.nan,
    **more: Any,
) -> Track:
    """A track from plain arrays; frame numbers default to 0, 1, 2 and so on."""
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    n = len(x)
    numbers = np.arange(n) if frame is None else np.asarray(frame)
    times = np.full(n, np.nan) if t_s is None else np.asarray(t_s, dtype=float)
    more.setdefault("outlier", np.zeros(n, dtype=bool))
    return Track(
        numbers,
        times,
        x,
        y,
        np.broadcast_to(np.asarray(sd, dtype=float), (n,)).copy(),
        unit,
        **more,
    )


def track_from_table(
    rows: pd.DataFrame, camera: Camera, notes: tuple[str, ...] = ()
) -> Track:
    """A Track from the rows of track.csv; pixels become millimetres and frames seconds
    where `camera` knows how."""
    unit = "mm" if "x_mm" in rows else "px"
    column = {
        name: rows[name].to_numpy(float) if name in rows else None
        for name in (*_OPTIONAL, "t_s", "frame")
    }
    names = [f"x_{unit}", f"y_{unit}", f"sd_{unit}", "outlier"]
    x, y, sd, marked = rows.reindex(columns=names).to_numpy(float).T
    outlier = np.nan_to_num(marked) != 0
    time, frame = column["t_s"], column["frame"]
    if frame is None and time is not None:
        frame = _frame_numbers(time, camera.fps)
    elif frame is not None and time is None and camera.fps:
        time = (frame - frame[0]) / camera.fps
    if (slipped := slips(np.asarray(frame), x, y) & ~outlier).any():
        outlier = outlier | slipped
        which = tr("{} rows are leaps away and back", int(slipped.sum()))
        notes = (*notes, tr("{} (a tracker that slipped): marked as outliers", which))
    track = make_track(
        time,
        x,
        y,
        unit=unit,
        frame=np.asarray(frame).astype(int),
        sd=sd,
        outlier=outlier,
        notes=notes,
        **{name: column[name] for name in _OPTIONAL},
    )
    return track.in_mm(camera.mm_per_px)


def struck_out(track: Track, recording: Recording) -> Track:
    """The track with the frames marked as outliers that [track] left_out_frames
    names."""
    struck = recording.track.left_out_frames
    return track.marked(np.isin(track.frame, struck)) if struck else track


def track_from_gates(recording: Recording) -> Track:
    """gates.csv as a track: a row a gate, numbered as passed; of a drop x = 0, of the
    others y = 0. sd: |speed| sd_s and sd_mm together, NaN where sd_s is not stated; a
    gate without sd_mm has the prior "gate-place"."""
    rig = recording.need_rig()
    if rig not in GATE_PLACE:
        raise MeasurementError(
            tr(
                "{}: light gates belong to a {}, not to a {}",
                recording.files[0],
                ", a ".join(GATE_PLACE),
                rig,
            )
        )
    table = read_gates(recording.files[0], rig)
    rows = table.rows.assign(
        **{
            c: v
            for c, v in (("sd_s", np.nan), ("sd_mm", unstated_sd("gate-place")))
            if c not in table.rows
        }
    )
    time, place, sd_s, sd_mm = (
        rows[c].to_numpy(float) for c in ("t_s", GATE_PLACE[rig], "sd_s", "sd_mm")
    )
    sd = np.hypot(
        np.abs(_falling(time, place) if rig == "drop" else np.gradient(place, time))
        * sd_s,
        sd_mm,
    )
    zero = np.zeros(len(time))
    return make_track(
        time,
        zero if rig == "drop" else place,
        place if rig == "drop" else zero,
        sd=sd,
        notes=table.notes,
    )


def _falling(time: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Speed [mm/s] at each row of a drop, under gravity, from the neighbour on its own
    side of the impact."""
    turn, step = int(np.argmin(place)), np.diff(time)
    after = np.diff(place) / step + G_MM_S2 * step / 2
    before = np.diff(place) / step - G_MM_S2 * step / 2
    return np.array(
        [
            before[k - 1] if 0 < k <= turn or k == len(time) - 1 else after[k]
            for k in range(len(time))
        ]
    )


def _frame_numbers(time: np.ndarray, fps: float | None) -> np.ndarray:
    """Frame numbers from times: whole steps of the median interval, so that lost rows
    leave gaps."""
    step = float(np.median(np.diff(time)))
    if fps and 0.9 < fps * step < 1.1:
        step = 1 / fps
    number = np.round((time - time[0]) / step).astype(int)
    # unevenly timed (a phone): count the rows
    return number if (np.diff(number) > 0).all() else np.arange(len(time))


def places_of(stated: Tracking) -> Places:
    """The places that a recording states [y down]; MeasurementError for two of one
    frame."""
    places = {int(frame): (x, y) for frame, x, y in stated.places_px or ()}
    require(
        len(places) >= len(stated.places_px or ()),
        tr("[track] places_px: two places of one frame; keep one"),
    )
    return places


def with_places(track: Track, places: Places, times: Mapping[int, float]) -> Track:
    """The track with the places instead of what was found in their frames;
    without orientation there. times: of every frame of the film. y counts up from the
    bottom row in both."""
    kept = track.take(~np.isin(track.frame, [*places]))
    hand = track_of_places(places, times)
    blank = np.full(len(hand), np.nan)
    order = np.argsort(np.concatenate([kept.frame, hand.frame]), kind="stable")
    columns = ("frame", "t_s", "x", "y", "sd", "outlier")
    joined: dict[str, Any] = {
        c: np.concatenate([getattr(kept, c), getattr(hand, c)])[order] for c in columns
    }
    joined |= {
        c: np.concatenate([values, blank])[order]
        for c in ("angle_deg", "angle_sd_deg")
        if (values := getattr(kept, c)) is not None
    }
    return replace(track, notes=(*track.notes, *hand.notes), **joined)


def upside_down(places: Places, height: int) -> Places:
    """The same with y counted from the other end of a picture `height` px high."""
    return {frame: (x, height - 1 - y) for frame, (x, y) in places.items()}


def track_of_places(places: Places, times: Mapping[int, float]) -> Track:
    """The places alone as a track [px, y up]. MeasurementError for a frame that the
    film has not."""
    if missing := sorted(places.keys() - times.keys()):
        raise MeasurementError(
            tr(
                "[track] places_px: the film has no frame {}; it has {} to {}",
                missing[0],
                min(times, default=0),
                max(times, default=0),
            )
        )
    frames = sorted(places)
    x, y = np.array([places[f] for f in frames]).T
    n = len(frames)
    return make_track(
        [times[f] for f in frames],
        x,
        y,
        unit="px",
        frame=np.array(frames),
        sd=PLACE_SD_PX,
        notes=(tr("{} place{} set by hand", n, "" if n == 1 else "s"),),
    )
