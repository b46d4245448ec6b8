"""Slides as runs: what slides when, at which tilt, and how well that is known."""

import math
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from benchtwin.bench.air import REFERENCE_SPEED_M_S, air_of
from benchtwin.bench.constants import G_M_S2
from benchtwin.bench.ellipsoid import ellipsoid_volume
from benchtwin.bench.language import tr
from benchtwin.bench.priors import stated_sd, unstated_sd
from benchtwin.bench.resolution import on_grid, reading_step
from benchtwin.bench.robust import difference_noise
from benchtwin.rigs.slide.tilt import Tilt, seen_tilt, standing_tilt, stated_tilt
from benchtwin.vision.motion.least_squares import all_stated
from benchtwin.vision.motion.outliers import rows_at_rest

# how a block moves: it rests until the plate is steep enough; it is in motion at the
# first row; it is let go or pushed within the recording
LETS_GO, MOVING, SET_OFF = "lets go", "moving", "set off"
LEAST_SLIDING, LEAST_REST = 12, 5  # rows
MOST_REST = 80  # of a slide that takes fewer rows
# rows of sliding in a short record: place, onset, friction, and one more
LEAST_OF_FEW = 4
LEAST_TRAVEL = {"mm": 0.5, "px": 2.0}
SEEN_SDS = 20.0  # of a row, that a block moves at least
EARLIER = 0.2  # of a slide, by which it may begin before it is seen to
FARTHER = 1.02  # than the stated way
ANGLE_MISSING = (
    "the plate's angle is unknown: give a tilt_deg column in track.csv, or [slide]"
    " start_deg, with tilt_rate_deg_s where it is raised"
)
FINEST_DEG, COARSE_DEG = 0.01, 0.15  # grid of an exact reading; grid that is reported
ON_GRID_DEG = 0.0055  # rounding of readings written to a hundredth
ABRAHAM = 9.06  # of √Re in C_d
POWERS = np.arange(2, 8)  # of the time since the onset: accelerations of degree 0 to 5
# of the slide's duration, after the onset as first guessed
EARLIEST = -0.1
LATEST = 0.25
# grid search for the onset, refined to 1e-3 of the duration
ONSETS = 9
MAX_ITERATIONS = 3
WAVES = 8  # of the friction along a slide: Legendre polynomials of degree 1 to 8
# pulses of friction before what was set in motion slides evenly: each rises from one
# of these times after the first row to the next, and falls to the one behind
SETTLES_S = (-0.01, 0.0, 0.01, 0.02, 0.035, 0.055, 0.08)
SLOWED = 0.75  # of its greatest speed, where it has met something
PUSHED = 0.1  # of its greatest speed, which something else than the plate gave it
SETTLING_S = 0.015  # in which they fall by e
ENOUGH = 200  # rows used for the onset


@dataclass(frozen=True)
class AirDrag:
    """Air on one seed in free flight: size (v + slow √v)² [m/s²]."""

    size: float = 0.0  # [1/m]
    slow: float = 0.0  # [√(m/s)]
    sd: float = 0.0  # relative, of drag beside a plate
    count: int = 1  # seeds in the block


@dataclass(frozen=True, eq=False)
class Run:
    """One track."""

    recording: str
    session: str
    time: np.ndarray  # (n,) [s]
    travel: np.ndarray  # (n,) [mm] downhill
    sign: float  # of downhill, along x
    frame: np.ndarray
    weight: np.ndarray  # (n,): sd of each row over the usual one
    gates: bool  # light gates
    rest: int  # rows before the first guess of the onset
    met: int  # row at which it may meet something
    tilt: Tilt
    mass_g: float  # of the block, NaN unknown
    from_hinge: float  # [m], 0 unknown
    air: AirDrag
    scale_sd: float  # relative
    lock: np.ndarray  # (n, 2) [mm]: see `lock`
    how: str = LETS_GO
    rests: bool = True  # whether friction may stop what was set in motion
    ended: int = 0  # rows at rest after the slide
    pictured: bool = False  # whether the angle, and its hinge, are from the picture
    # (n, K) [mm]: by one sd of each friction of its own that changes along the slide
    wander: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))

    @property
    def few(self) -> bool:
        """Whether each row errs by itself."""
        return has_few_rows(self.gates, len(self.time))

    @property
    def in_motion(self) -> bool:
        """Whether something else than the plate's tilt gives it a speed."""
        return self.how != LETS_GO

    @cached_property
    def turned(self) -> np.ndarray:
        """How far a plate in the picture has turned (n,) since the first row [rad]."""
        angle = self.tilt.at(self.time)
        return (angle - angle[0]) * self.pictured

    @property
    def moving(self) -> slice:
        """Rows from the onset to the stop."""
        return slice(self.rest, len(self.time) - self.ended)


@dataclass(frozen=True, eq=False)
class Read:
    """Angles (m,) [deg] read by eye, one a slide; NaN if unknown; grid_deg: reading
    grid."""

    recording: str
    session: str
    angles: np.ndarray
    rate_deg_s: float
    mass_g: float
    grid_deg: float


@dataclass(frozen=True, eq=False)
class Session:
    """Tracks and readings of one pair; stated: their descriptions, tracks first."""

    runs: tuple[Run, ...]
    reads: tuple[Read, ...]
    stated: tuple[dict, ...]
    notes: tuple[str, ...]

    @property
    def masses(self) -> np.ndarray:
        """Masses [g] of all blocks, NaN where unknown."""
        return np.array(
            [*(r.mass_g for r in self.runs), *(r.mass_g for r in self.reads)]
        )


def lets_go(session: Session) -> bool:
    """Whether a block is seen to let go of a plate that is raised."""
    return any(not run.in_motion for run in session.runs)


def assemble(recordings) -> Session:
    """Usable runs and readings; ValueError with each one's reason where there are
    none."""
    runs, reads, notes = [], [], []
    told: dict[str, dict] = {}
    for seen in recordings:
        notes += [f"{seen.recording}: {note}" for note in seen.notes]
        if seen.trouble:
            notes.append(tr("{}: left out: {}", seen.recording, seen.trouble))
            continue
        told[seen.recording] = seen.description
        try:
            if len(seen.angles_deg):
                reads.append(_read(seen))
            else:
                runs.append(_beside_others(run_of(seen), seen.description))
                begun = float(runs[-1].time[0] - seen.time_s[0])
                if runs[-1].in_motion and begun > 0:
                    notes.append(
                        tr(
                            "{}: its first {:.2g} s, in which it rests or is pushed,"
                            " are left out",
                            seen.recording,
                            begun,
                        )
                    )
        except ValueError as error:
            notes.append(tr("{}: left out: {}", seen.recording, error))
    if not runs and not reads:
        raise ValueError(
            tr("no slide can be used: ") + "; ".join(notes or [tr("there is none")])
        )
    stand = [r for r in runs if r.in_motion and not r.tilt.sensor]
    if any("tilt_rate_deg_s" not in told[r.recording].get("slide", {}) for r in stand):
        angle = math.degrees(stand[0].tilt.coefficients[0])
        notes.append(
            tr(
                "the plate is taken to stand at {:.3g}°: no tilt_rate_deg_s is stated",
                angle,
            )
        )
    grid = grid_of([r.angles for r in reads])
    reads = [replace(r, grid_deg=r.grid_deg or grid) for r in reads]
    if reads and grid >= COARSE_DEG:
        notes.append(
            tr("angles are read to {:g}°, which is carried into the friction", grid)
        )
    names = [*(r.recording for r in runs), *(r.recording for r in reads)]
    return Session(
        tuple(runs), tuple(reads), tuple(told[n] for n in names), tuple(notes)
    )


def grid_of(readings: list[np.ndarray]) -> float:
    """The coarsest usual resolution, else any spacing, on which all lie; else
    FINEST_DEG.

    >>> grid_of([np.array([21.5, 22.0, 22.0, 22.5, 21.5, 22.0, 21.5, 22.0])])
    0.5
    >>> grid_of([np.array([21.75, 23.31, 21.75, 21.75, 23.31, 20.19])])
    1.56
    """
    values = np.unique(np.round(np.concatenate(readings or [np.zeros(0)]), 3))
    usual = reading_step(values, ON_GRID_DEG) or FINEST_DEG
    if len(values) < 3 or usual >= 0.2:
        return usual
    spacing = float(np.diff(values).min())
    stairs = np.round((values - values[0]) / spacing)
    spacing = float(np.polyfit(stairs, values, 1)[0])
    odd = (
        spacing > 2 * usual
        and spacing >= COARSE_DEG
        and on_grid(values - values[0], spacing, ON_GRID_DEG)
    )
    return round(spacing, 3) if odd else usual


def _read(seen) -> Read:
    angles = np.asarray(seen.angles_deg, float)
    angles = angles[np.isfinite(angles)]
    if not len(angles):
        raise ValueError(
            tr(
                "its readings hold no number; slide_angle_deg should hold an angle a"
                " row"
            )
        )
    rate = seen.description.get("slide", {}).get("tilt_rate_deg_s")
    stated = seen.description.get("reading", {}).get("resolution_deg") or 0.0
    rate_deg_s = float(rate) if rate else float("nan")
    mass_g = mass_of(seen.description)
    return Read(seen.recording, seen.session, angles, rate_deg_s, mass_g, stated)


def has_few_rows(gates: bool, count: int) -> bool:
    """Whether each row of a track errs by itself: light gates, or few rows."""
    return gates or count < LEAST_SLIDING + LEAST_REST


def need_sliding(rows: int, least: int = LEAST_OF_FEW) -> None:
    """ValueError for too few rows."""
    if rows < least:
        raise ValueError(tr("{} rows of sliding; at least {} are needed", rows, least))


def run_of(seen) -> Run:
    """A recording (read.SeenSlide) in full; ValueError says what it lacks."""
    seen = _with_numbers(seen)
    need_sliding(len(seen.x_mm))
    few = has_few_rows(seen.gates, len(seen.x_mm))
    noise = 0.0 if few else difference_noise(seen.x_mm, 2)
    moved = float(np.ptp(seen.x_mm))
    if moved < max(SEEN_SDS * noise, LEAST_TRAVEL[seen.unit]):
        raise ValueError(
            tr("the block does not slide: it moves {:.3g} {} in all", moved, seen.unit)
        )
    ends = 1 if few else max(3, len(seen.x_mm) // 20)
    way = np.median(seen.x_mm[-ends:]) - np.median(seen.x_mm[:ends])
    sign = math.copysign(1.0, way)
    travel = sign * seen.x_mm
    first, met = _first_and_met(seen, travel, few)
    need_sliding(len(travel) - first)
    tilt = _plate(seen, first, met)
    told = seen.description
    return Run(
        seen.recording,
        seen.session,
        seen.time_s,
        travel,
        sign,
        seen.frame,
        _weights(seen),
        seen.gates,
        first,
        met,
        tilt,
        mass_of(told),
        1e-3 * (told["slide"].get("start_mm") or 0.0),
        air_drag(told),
        float(told["camera"]["scale_sd"]),
        np.zeros((len(travel), 2)),
        pictured=seen.tilt_sd_deg is not None,
    )


def _with_numbers(seen):
    """The rows that hold a time and a place."""
    rows = np.isfinite(seen.time_s) & np.isfinite(seen.x_mm)
    columns = {n: getattr(seen, n) for n in ("frame", "time_s", "x_mm", "sd_mm")}
    columns |= {} if seen.tilt_deg is None else {"tilt_deg": seen.tilt_deg}
    return replace(seen, **{n: column[rows] for n, column in columns.items()})


def _first_and_met(seen, travel: np.ndarray, few: bool) -> tuple[int, int]:
    """The first row in motion, and that at which the block may meet something."""
    n = len(travel)
    if few:
        sd = float(np.median(seen.sd_mm)) if all_stated(seen.sd_mm) else 0.0
        return min(rows_at_rest(travel, sd), n - 1), n
    first = min(first_in_motion(travel, difference_noise(travel, 2)), n - 1)
    return first, _met(seen.time_s, travel, first)


def _met(time: np.ndarray, travel: np.ndarray, first: int) -> int:
    """Row at which a block in motion from row `first` on may meet something: its speed
    has fallen well below the greatest."""
    speed, error = _speeds(time, travel, difference_noise(travel, 2))
    peak = int(np.argmax(speed)) if len(speed) else 0
    falls = (speed[peak:] < SLOWED * speed[peak : peak + 1] - error).any()
    enough = peak + 1 >= first + LEAST_SLIDING // 2
    return peak + 1 if falls and enough else len(travel)


def _weights(seen) -> np.ndarray:
    """(n,) As stated; light gates read times, so the errors of theirs grow with
    speed."""
    weights = np.ones(len(seen.x_mm))
    if all_stated(seen.sd_mm):
        weights = seen.sd_mm
    elif seen.gates:
        least = 1e-3 * np.ptp(seen.x_mm) / np.ptp(seen.time_s)
        weights = np.maximum(np.abs(np.gradient(seen.x_mm, seen.time_s)), least)
    return weights / np.median(weights)


def _plate(seen, first: int, met: int) -> Tilt:
    """The plate's angle over a slide between two rows."""
    time, column, told = seen.time_s, seen.tilt_deg, seen.description["slide"]
    known = np.zeros(0) if column is None else column[:met][np.isfinite(column[:met])]
    if len(known) >= LEAST_OF_FEW:
        tilt = seen_tilt(time[:met], column[:met], time[first], time[met - 1])
        step = reading_step(known) if np.ptp(known) else 0.0  # one number tells none
        return replace(tilt, read_to_deg=step, zero_sd_deg=seen.tilt_sd_deg)
    rate, start = told.get("tilt_rate_deg_s"), told.get("start_deg")
    if rate:
        # the clock of light gates starts with the tilting, a film somewhat before it
        sd = stated_sd("level-plate" if seen.gates else "start-angle")
        sd = unstated_sd("start-angle") if start is None else sd
        return stated_tilt(rate, start or 0.0, sd, time[first])
    if start is None:
        raise ValueError(tr(ANGLE_MISSING))
    return standing_tilt(start, time[first])


def rows_of(run: Run, rows: np.ndarray) -> Run:
    """Some rows (n,) of a run."""
    rest, ended = run.moving.start, run.moving.stop
    return replace(
        run,
        time=run.time[rows],
        travel=run.travel[rows],
        frame=run.frame[rows],
        weight=run.weight[rows],
        lock=run.lock[rows],
        rest=int(rows[:rest].sum()),
        met=int(rows[: run.met].sum()),
        ended=int(rows[ended:].sum()),
    )


def with_rest(run: Run) -> Run:
    """A run with as long a rest as its slide takes."""
    begin = run.rest - max(MOST_REST, run.met - run.rest)
    return rows_of(run, np.arange(len(run.time)) >= begin)


def _beside_others(run: Run, description: dict) -> Run:
    """A run cut to what a session's slides tell together: on a raised plate until the
    block meets something, on one that stands from where it is left alone; ValueError
    says what it lacks."""
    row = np.arange(len(run.time))
    if run.tilt.stands:
        first = run.rest if run.few or run.rest >= LEAST_REST else 0
        noise = difference_noise(run.travel, 2)
        first = max(first, pushed_until(run.time, run.travel, noise))
        run, least = replace(run, how=MOVING, rest=0), LEAST_OF_FEW
        run = rows_of(run, row >= first)
        run = replace(run, met=_met(run.time, run.travel, 0))
    else:
        if not run.tilt.rate_deg_s > 0:
            raise ValueError(tr("the plate is lowered while the block slides"))
        if run.rest and not run.few:  # seen later than the onset, by t ~ x^⅓
            slid = run.time[run.met - 1] - run.time[run.rest - 1]
            early = run.time[run.rest - 1] - EARLIER * slid
            run = replace(run, rest=int(np.searchsorted(run.time, early)))
        if not run.few and run.rest < LEAST_REST:
            raise ValueError(
                tr(
                    "the block moves from the first rows on: the onset is not in the"
                    " recording"
                )
            )
        far = FARTHER * (description["slide"].get("travel_mm") or math.inf)
        beyond = run.travel - np.median(run.travel[: max(run.rest, 1)]) > far
        least = LEAST_OF_FEW if run.few else LEAST_SLIDING
        kept = (row < run.met) & ~np.logical_or.accumulate(beyond)
        run = with_rest(rows_of(run, kept))
    need_sliding(len(run.time) - run.rest, least)
    pixel_mm = description["camera"].get("mm_per_px") or 0.0
    return replace(run, lock=lock(run.time, run.travel, run.rest, pixel_mm))


def pushed_until(time: np.ndarray, travel: np.ndarray, noise: float) -> int:
    """Row until which something pushes a block on a plate that stands, 0 for none: left
    alone it gains speed all the way or loses it all the way."""
    speed, error = _speeds(time, travel, noise)
    if not len(speed):
        return 0
    peak = int(np.argmax(speed))
    much = (1 - PUSHED) * speed[peak] - error
    slower = np.flatnonzero(speed[peak:] < much)  # at once where it meets something
    gained, loses = speed[: peak + 1].min() < much, len(slower) > LEAST_SLIDING // 2
    return peak + 1 if gained and loses and slower[0] > 2 else 0


def _speeds(
    time: np.ndarray, travel: np.ndarray, noise: float
) -> tuple[np.ndarray, float]:
    """Speeds (m,) [mm/s] over some rows, none of few rows, and three sds of one."""
    width = max(3, len(travel) // 100)
    if len(travel) < 3 * width + 4:
        return np.zeros(0), 0.0
    speed = (travel[width:] - travel[:-width]) / (time[width:] - time[:-width])
    return speed, 3 * noise / max(float(np.median(np.diff(time))) * width, 1e-12)


def first_in_motion(travel: np.ndarray, noise: float) -> int:
    """The first row from which on the block is seen off its place at rest."""
    rest = float(np.median(travel[: max(3, len(travel) // 20)]))
    size = float(travel.max() - rest)
    still = np.flatnonzero(travel - rest < max(8 * noise, 2e-3 * size))
    return int(still[-1]) + 1 if len(still) else 0


def mass_of(description: dict) -> float:
    """Of the block [g], from mass_g or ellipsoid and density, times count; NaN if not
    stated."""
    seed = description.get("seed", {})
    one = seed.get("mass_g")
    sizes = [seed.get(f"{side}_mm") for side in ("length", "width", "thickness")]
    if one is None and all(sizes) and seed.get("density_kg_m3"):
        one = 1e-6 * ellipsoid_volume(*sizes) * seed["density_kg_m3"]
    return float("nan") if one is None else float(one) * seed.get("count", 1)


def air_drag(description: dict) -> AirDrag:
    """Of a lone seed as stated, and how well it is known."""
    air = air_of(description)
    slow = (
        ABRAHAM / math.sqrt(air.reynolds_per_speed) if air.reynolds_per_speed else 0.0
    )
    at_2 = (REFERENCE_SPEED_M_S + slow * math.sqrt(REFERENCE_SPEED_M_S)) ** 2
    known = (stated_sd if air.sd < air.share else unstated_sd)("drag-beside-plate")
    count = int(description.get("seed", {}).get("count") or 1)
    return AirDrag(air.share * G_M_S2 / at_2, slow, known if air.share else 0.0, count)


def lock(time: np.ndarray, x_mm: np.ndarray, rest: int, pixel_mm: float) -> np.ndarray:
    """Error of x (n, 2) [mm] for A = 1 px and B = 1 px; rest: rows before the onset."""
    if not pixel_mm:
        return np.zeros((len(time), 2))
    phase = 2 * np.pi * smooth(time, x_mm, rest) / pixel_mm
    return pixel_mm * np.column_stack([np.sin(phase), np.cos(phase)])


def smooth(time: np.ndarray, x: np.ndarray, rest: int) -> np.ndarray:
    """Place (n,) by a curve of few terms: a row's own reading would explain its own
    noise."""
    few = slice(None, None, max(1, len(x) // ENOUGH))
    grid = time[rest] + (time[-1] - time[rest]) * np.linspace(EARLIEST, LATEST, ONSETS)
    for _ in range(MAX_ITERATIONS):
        left = [
            ((x[few] - _from(onset, time[few], x[few])) ** 2).sum() for onset in grid
        ]
        best = int(np.argmin(left))
        onset = grid[best]
        grid = np.linspace(
            grid[max(best - 1, 0)], grid[min(best + 1, ONSETS - 1)], ONSETS
        )
    return _from(onset, time, x)


def _from(onset: float, time: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Least-squares fit of rest and, from `onset` on, a polynomial acceleration."""
    since = np.clip((time - onset) / (time[-1] - onset), 0.0, None)
    design = np.column_stack([np.ones(len(time)), since[:, None] ** POWERS])
    return design @ np.linalg.lstsq(design, x, rcond=None)[0]
