"""Rolls of one bench for fitting: SI units, averaged rows, stated keys with their
sds."""

import math
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.ndimage import median_filter

from benchtwin.bench.air import Air, air_of, drag_shape, stated_sizes_mm
from benchtwin.bench.constants import G_M_S2
from benchtwin.bench.language import tr
from benchtwin.bench.priors import UNKNOWN_DISTANCE_M, stated_sd, unstated_sd
from benchtwin.bench.robust import robust_sd
from benchtwin.infer.noise import frame_lag
from benchtwin.rigs.roll.effects.resistance import REFERENCE_SPEED_M_S
from benchtwin.rigs.roll.inertia import inertia_told
from benchtwin.rigs.roll.initial_path import (
    Path,
    fit_path,
    path_of_few,
    path_on_incline,
)

MOST_ROWS = 280  # more rows add time, not information
LEAST_ROWS = 4
FEW_ROWS = 24  # below which outliers are not removed, and corner and stop are as stated
LEAST_LEVEL = 12  # rows behind the corner
REST_SHARE = 0.25  # of the duration: rest used at either end
SPIKE_SD = 8.0
NEIGHBOURS = 9
USUAL_RADIUS_M = 3.5e-3
OF_DRAG = (
    "length_mm",
    "width_mm",
    "thickness_mm",
    "mass_g",
    "density_kg_m3",
)  # keys that determine drag over weight


@dataclass(frozen=True, eq=False)
class Run:
    """One recording."""

    recording: str
    session: str
    time_s: np.ndarray  # this and x [m] (n,): means of some rows each
    x: np.ndarray
    spread_s: np.ndarray  # (n,): sd of their times
    lag: np.ndarray  # (n,): in averaged frames
    way: Path  # initial path
    sign: float  # +1 towards +x
    incline: float  # stated [rad], or NaN
    length: float  # stated [m], or NaN
    turning: tuple[float, float] | None  # slope [1/m] and start of orientation over x
    drag: float = 1.0  # of its seed over the session's
    away: float = math.inf  # distance of the camera [m]
    slope: float = math.nan  # of the level, stated, falling towards +x [deg], or NaN
    junction: tuple[float, float] | None = None  # place and sd [m], seen in a picture
    stays: bool = False  # on its incline
    gates: bool = False  # light gates
    sd_m: np.ndarray = field(
        default_factory=lambda: np.zeros(0)
    )  # (n,): stated, or NaN
    notes: tuple[str, ...] = field(default=())

    @cached_property
    def middle(self) -> float:
        """Of what was seen [m]."""
        return float(self.x.min() + self.x.max()) / 2

    @cached_property
    def around_s(self) -> np.ndarray:
        """(2 n,): one sd before and one after the time of every row."""
        pair = [self.time_s - self.spread_s, self.time_s + self.spread_s]
        return np.column_stack(pair).ravel()

    @cached_property
    def gate_of(self) -> tuple[str, ...]:
        """Name of the global for the misplacement of every row's light gate; none
        without gates."""
        places = 1000 * self.x if self.gates else ()
        return tuple(f"gate.{self.session}.{x:.6g}mm" for x in places)


@dataclass(frozen=True)
class Seed:
    """What is stated of the seed."""

    radius: float  # on which it rolls [m]
    inertia: float  # 1 + I/(m r²)
    inertia_sd: float  # relative
    rise_mm: float  # of its centre, NaN if the shape is not stated
    drag: float  # over weight at 0.5 m/s in stated air
    drag_sd: float
    reynolds_per_speed: float
    round: bool  # stated to be a ball


def assemble(rolls) -> tuple[tuple[Run, ...], Seed, tuple[str, ...]]:
    """Usable runs, the seed, notes. ValueError where no run can be used."""
    about = [r.description for r in rolls if len(r.x_mm)]
    told = next((d for d in about if d.get("seed")), about[0] if about else {})
    seed = seed_of(told)
    runs, notes = [], []
    past = [tuple(r.x_mm) for r in rolls if 0 < len(r.x_mm) < FEW_ROWS]
    for roll in rolls:
        if not len(roll.x_mm):
            continue
        try:
            made = run_of(roll, seed)
            _need_run_out(made)
            gates = (
                made.gates or past.count(tuple(roll.x_mm)) > 1
            )  # equal places in two recordings are light gates
            runs.append(
                replace(made, gates=gates, drag=relative_drag(roll.description, told))
            )
            notes += [f"{roll.recording}: {text}" for text in runs[-1].notes]
        except ValueError as error:
            notes.append(tr("{} is left out: {}", roll.recording, error))
    if not runs:
        raise ValueError("; ".join(notes) or tr("none of the recordings holds a track"))
    return tuple(runs), seed, tuple(notes)


def stays(description: dict) -> bool:
    """Whether a seed never leaves its incline, as stated or as its rows show."""
    told = description.get("roll", {})
    return not told.get("level", not told.get("ends_on_incline"))


def run_of(roll, seed: Seed) -> Run:
    """One recording (read.SeenRoll); ValueError says what it lacks."""
    if len(roll.x_mm) < LEAST_ROWS:
        raise ValueError(
            tr("{} usable rows; at least {} are needed", len(roll.x_mm), LEAST_ROWS)
        )
    few = roll.gates or len(roll.x_mm) < FEW_ROWS
    keep = np.arange(len(roll.x_mm)) if few else _no_spikes(roll.x_mm)
    time, x, frame = roll.time_s[keep], roll.x_mm[keep] / 1000, roll.frame[keep]
    told, notes = roll.description.get("roll", {}), list(roll.notes)
    if len(keep) < len(roll.x_mm):
        notes.append(
            tr(
                "{} rows far off their neighbours are left out",
                len(roll.x_mm) - len(keep),
            )
        )
    incline = math.radians(told["incline_deg"]) if told.get("incline_deg") else math.nan
    length = (
        told["incline_length_mm"] / 1000 if told.get("incline_length_mm") else math.nan
    )
    spread = np.zeros(len(x))
    if stays(roll.description):
        if not roll.gates and (end := _stopped(time, x)):
            notes.append(
                tr(
                    "the seed is stopped at {:.4g} s; what follows is not fitted",
                    time[end - 1],
                )
            )
            keep, time, x, frame = (rows[:end] for rows in (keep, time, x, frame))
        spread = np.zeros(len(x))
        way = path_on_incline(time, x)
        used = time >= way.release - REST_SHARE * (time[-1] - way.release)
        if not few:
            time, x, frame, spread = _averaged(time[used], x[used], frame[used])
    elif few:
        way = path_of_few(time, x, weight_over_inertia(seed), incline, length)
        if not (time > way.corner).any():
            raise ValueError(
                tr(
                    "no row lies behind the incline; [roll] level = false says that the"
                    " seed stays on it"
                )
            )
        speed = np.diff(x) / np.diff(time)
        if x[-2] > length and speed[-1] == speed.max() and len(speed) > 1:
            raise ValueError(tr("the seed does not slow down on the level"))
    else:
        way = fit_path(time, x)
        moving = max(way.stop - way.release, 1e-3)
        used = (time >= way.release - REST_SHARE * moving) & (
            time <= way.stop + REST_SHARE * moving
        )
        time, x, frame, spread = _averaged(time[used], x[used], frame[used])
    direction = told.get("direction") or told.get("seen_direction", "+x")
    angle = None if roll.angle_deg is None or few else roll.angle_deg[keep]
    return Run(
        roll.recording,
        roll.session,
        time,
        x,
        spread,
        np.full(len(x), np.inf) if few else frame_lag(frame),
        way,
        -1.0 if direction == "-x" else 1.0,
        incline,
        length,
        _turning(roll.time_s[keep], roll.x_mm[keep] / 1000, angle, way),
        notes=tuple(notes),
        away=math.inf if roll.gates else _distance_m(roll.description),
        slope=stated_slope_deg(told),
        stays=stays(roll.description),
        gates=roll.gates,
        sd_m=(
            roll.sd_mm[keep] / 1000
            if few and len(roll.sd_mm) == len(roll.x_mm)
            else np.full(len(x), np.nan)
        ),
    )


def stated_slope_deg(told: dict) -> float:
    """Stated slope of the level plate, falling towards +x [deg]; NaN where it is not
    stated, or the direction of the roll is neither stated nor seen."""
    slope = told.get("slope_deg")
    direction = told.get("direction") or told.get("seen_direction")
    return math.nan if slope is None or not direction else slope


def _distance_m(description: dict) -> float:
    """Of the camera."""
    stated = description["camera"].get("distance_mm")
    return stated / 1000 if stated else UNKNOWN_DISTANCE_M


def _stopped(time: np.ndarray, x: np.ndarray) -> int:
    """Row from which a seed at the end of its incline is slow at once, 0 for none."""
    speed = np.diff(x) / np.diff(time)
    top = int(np.argmax(speed))
    slow = np.flatnonzero(speed[top:] < 0.5 * speed[top])
    return max(top + int(slow[0]), LEAST_ROWS) if len(slow) else 0


def _need_run_out(run: Run) -> None:
    """ValueError where a long track ends too soon for a diagnosis."""
    level = int((run.time_s > run.way.corner).sum())
    short = run.x[-1] - run.way.place < 1.2 * run.way.way_down
    if not run.stays and len(run.x) >= FEW_ROWS and (level < LEAST_LEVEL or short):
        raise ValueError(
            tr(
                "the track ends too soon behind the incline ({} rows); a diagnosis"
                " needs the run-out",
                level,
            )
        )


def _no_spikes(x: np.ndarray) -> np.ndarray:
    """Rows (indices) near the median of their neighbours."""
    half = NEIGHBOURS // 2
    off = np.abs(x - median_filter(x, NEIGHBOURS, mode="nearest"))
    step = np.median(np.abs(np.diff(x)))
    usual = robust_sd(off) + 1e-9
    return np.flatnonzero(off <= SPIKE_SD * usual + half * 3 * step)


def _averaged(time, x, frame):
    """Means over blocks of frames: time, place, block number, and the sd of times in
    each."""
    block = max(1, math.ceil((frame[-1] - frame[0] + 1) / MOST_ROWS))
    number = ((frame - frame[0]) // block).astype(int)
    kept, inverse, count = np.unique(number, return_inverse=True, return_counts=True)
    mean = [
        np.bincount(inverse, weights=values - values[0]) / count + values[0]
        for values in (time, x)
    ]
    spread = np.sqrt(
        np.bincount(inverse, weights=(time - mean[0][inverse]) ** 2) / count
    )
    return mean[0], mean[1], kept, spread


def _turning(time, x, angle_deg, way: Path) -> tuple[float, float] | None:
    """Slope and level of the orientation over travel; None where the seed does not roll
    with it."""
    if angle_deg is None:
        return None
    rows = np.flatnonzero(
        np.isfinite(angle_deg) & (time > way.release) & (time < way.stop)
    )
    if len(rows) < 20 or np.ptp(x[rows]) < 0.01:
        return None
    slope, level = np.polyfit(x[rows], np.radians(angle_deg[rows]), 1)
    left = np.radians(angle_deg[rows]) - level - slope * x[rows]
    return (
        (float(slope), float(level))
        if 100 < abs(slope) < 5000 and left.std() < 0.5
        else None
    )


def relative_drag(description: dict, told: dict) -> float:
    """Drag over weight of a recording's seed over the session's; 1 if not
    comparable."""
    own, other = (
        {n for n in OF_DRAG if d.get("seed", {}).get(n)} for d in (description, told)
    )
    return air_of(description).room / air_of(told).room if own == other else 1.0


def seed_of(told: dict) -> Seed:
    """The session's seed from one description."""
    sizes = sorted((size / 1000 for size in stated_sizes_mm(told)), reverse=True)
    air: Air = air_of(told)
    at_half = REFERENCE_SPEED_M_S * float(
        drag_shape(REFERENCE_SPEED_M_S, air.reynolds_per_speed)
    )
    beside = (stated_sd if air.sd < air.share else unstated_sd)("drag-beside-plate")
    inertia = inertia_told(told)
    radius = inertia.radius_mm / 1000 if sizes else USUAL_RADIUS_M
    rise = 500 * (sizes[1] - sizes[-1]) if len(sizes) > 1 else math.nan
    return Seed(
        radius,
        inertia.factor,
        inertia.sd,
        rise,
        air.share * at_half,
        beside * air.share * at_half,
        air.reynolds_per_speed,
        inertia.ball,
    )


def weight_over_inertia(seed: Seed) -> float:
    """F = g / (1 + I/(m r²)) [m/s²]."""
    return G_M_S2 / seed.inertia
