"""A track: the places of one seed over time, with standard deviations."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from benchtwin.bench.constants import G_MM_S2
from benchtwin.bench.priors import unstated_sd
from benchtwin.vision.evidence.tables import GATE_PLACE, read_gates
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.motion.least_squares import fit, frame_lag
from benchtwin.vision.motion.outliers import slips
from benchtwin.vision.recording import Camera, Recording

_ALWAYS = ("frame", "t_s", "x", "y", "sd", "outlier")
_OPTIONAL = ("angle_deg", "angle_sd_deg", "tilt_deg")


@dataclass(frozen=True)
class Track:
    """Arrays of one length n, in the order of time. x to the right, y up, in `unit`
    ("mm" or "px").

    frame: numbers as recorded (a lost frame is a missing row). t_s: all NaN without a
    frame rate. sd: of x and of y, each; NaN where not stated. angle_deg: unwrapped,
    anticlockwise; NaN where unknown; None where not measured. tilt_deg: the plate's
    angle at the same time. outlier: rows that no fit uses."""

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
            message = (
                f"[camera] {key} is missing; an acceleration needs lengths and times"
            )
            raise MeasurementError(f"{recording.toml}: {message}")

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

    def take(self, rows: np.ndarray | slice) -> "Track":
        """Some of the rows (a mask, indices or a slice)."""
        columns: dict[str, Any] = {
            name: getattr(self, name) for name in (*_ALWAYS, *_OPTIONAL)
        }
        some: dict[str, Any] = {
            k: None if c is None else c[rows] for k, c in columns.items()
        }
        return replace(self, **some)

    def marked(self, outlier: np.ndarray) -> "Track":
        """The same track with more rows marked as outliers."""
        return replace(self, outlier=self.outlier | outlier)

    def spin(self, rows: np.ndarray) -> tuple[float, float]:
        """Spin [rad per time unit, anticlockwise] over some rows and its sd; NaN with
        an orientation in fewer than 5 of them."""
        if self.angle_deg is None:
            return np.nan, np.nan
        rows = rows[np.isfinite(self.angle_deg[rows])]
        if len(rows) < 5:
            return np.nan, np.nan
        weight = None
        sd = None if self.angle_sd_deg is None else self.angle_sd_deg[rows]
        if sd is not None and np.isfinite(sd).all():
            weight = np.median(sd) / np.maximum(sd, 1e-3)
        design = np.column_stack(
            [np.ones(len(rows)), self.time[rows] - self.time[rows].mean()]
        )
        found = fit(
            design,
            np.radians(self.angle_deg[rows]),
            frame_lag(self.frame[rows]),
            weight=weight,
        )
        return float(found.params[1]), float(np.sqrt(found.cov[1, 1]))

    def to_table(self) -> pd.DataFrame:
        """The columns of track.csv, plus the frame number, the sds and the outlier
        mark; unknown columns are left out."""
        places = {
            f"x_{self.unit}": self.x,
            f"y_{self.unit}": self.y,
            f"sd_{self.unit}": self.sd,
        }
        more = {
            name: getattr(self, name)
            for name in _OPTIONAL
            if getattr(self, name) is not None
        }
        columns = {"frame": self.frame, "t_s": self.t_s, **places, **more}
        table = pd.DataFrame({**columns, "outlier": self.outlier.astype(int)})
        return table.drop(
            columns=[c for c in ("t_s", f"sd_{self.unit}") if table[c].isna().all()]
        )


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
    x, y = rows[f"x_{unit}"].to_numpy(float), rows[f"y_{unit}"].to_numpy(float)
    if f"sd_{unit}" in rows:
        sd = rows[f"sd_{unit}"].to_numpy(float)
    else:
        sd = np.full(len(rows), np.nan)
    if unit == "px" and camera.mm_per_px:
        x = x * camera.mm_per_px
        y = y * camera.mm_per_px
        sd = sd * camera.mm_per_px
        unit = "mm"
    time, frame = column["t_s"], column["frame"]
    if frame is None and time is not None:
        frame = _frame_numbers(time, camera.fps)
    elif frame is not None and time is None and camera.fps:
        time = (frame - frame[0]) / camera.fps
    if "outlier" in rows:
        outlier = rows["outlier"].fillna(0).to_numpy(float) != 0
    else:
        outlier = np.zeros(len(rows), dtype=bool)
    if (slipped := slips(np.asarray(frame), x, y) & ~outlier).any():
        outlier = outlier | slipped
        notes = (
            *notes,
            (
                f"{int(slipped.sum())} rows are leaps away and back (a tracker that"
                " slipped): marked as outliers"
            ),
        )
    return make_track(
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
            f"{recording.files[0]}: light gates belong to a {', a '.join(GATE_PLACE)},"
            f" not to a {rig}"
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
