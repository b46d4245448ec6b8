"""Slides as runs: what slides when, at which tilt, and how well that is known."""

import math
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from benchtwin.bench.air import REFERENCE_SPEED_M_S, air_of
from benchtwin.bench.constants import G_M_S2
from benchtwin.bench.ellipsoid import ellipsoid_volume
from benchtwin.bench.priors import stated_sd, unstated_sd
from benchtwin.bench.resolution import on_grid, reading_step
from benchtwin.bench.robust import difference_noise
from benchtwin.rigs.slide.tilt import Tilt, seen_tilt, standing_tilt, stated_tilt

# how a block moves: it rests until the plate is steep enough; it is in motion at the
# first row; it is let go or pushed within the recording
LETS_GO, MOVING, SET_OFF = "lets go", "moving", "set off"
LEAST_SLIDING, LEAST_REST = 12, 5  # rows
LEAST_TRAVEL_MM = 0.5
# rows of sliding in a short record: place, onset, friction, and one more
LEAST_OF_FEW = 4
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
    """One track, cut to the slide and as long a rest before it."""

    recording: str
    session: str
    time: np.ndarray  # (n,) [s]
    travel: np.ndarray  # (n,) [mm] downhill from 0
    frame: np.ndarray
    rest: int  # rows before the first guess of the onset
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
            notes.append(f"{seen.recording}: left out: {seen.trouble}")
            continue
        told[seen.recording] = seen.description
        try:
            if len(seen.angles_deg):
                reads.append(_read(seen))
            else:
                runs.append(_run(seen))
                begun = float(runs[-1].time[0] - seen.time_s[0])
                if runs[-1].in_motion and begun > 0:
                    notes.append(
                        f"{seen.recording}: its first {begun:.2g} s, in which it rests"
                        " or is pushed, are left out"
                    )
        except ValueError as error:
            notes.append(f"{seen.recording}: left out: {error}")
    if not runs and not reads:
        raise ValueError(
            "no slide can be used: " + "; ".join(notes or ["there is none"])
        )
    stand = [r for r in runs if r.in_motion and not r.tilt.sensor]
    if any("tilt_rate_deg_s" not in told[r.recording].get("slide", {}) for r in stand):
        angle = math.degrees(stand[0].tilt.coefficients[0])
        notes.append(
            f"the plate is taken to stand at {angle:.3g}°: no tilt_rate_deg_s is stated"
        )
    grid = grid_of([r.angles for r in reads])
    reads = [replace(r, grid_deg=r.grid_deg or grid) for r in reads]
    if reads and grid >= COARSE_DEG:
        notes.append(
            f"angles are read to {grid:g}°, which is carried into the friction"
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
            "its readings hold no number; slide_angle_deg should hold an angle a row"
        )
    rate = seen.description.get("slide", {}).get("tilt_rate_deg_s")
    stated = seen.description.get("reading", {}).get("resolution_deg") or 0.0
    rate_deg_s = float(rate) if rate else float("nan")
    mass_g = mass_of(seen.description)
    return Read(seen.recording, seen.session, angles, rate_deg_s, mass_g, stated)


def _run(seen) -> Run:
    told = seen.description.get("slide", {})
    good = np.isfinite(seen.time_s) & np.isfinite(seen.x_mm)
    time, x, frame = seen.time_s[good], seen.x_mm[good], seen.frame[good]
    few = len(time) < LEAST_SLIDING + LEAST_REST
    if len(time) < LEAST_OF_FEW:
        raise ValueError(
            f"{len(time)} usable rows; a slide needs at least {LEAST_OF_FEW}"
        )
    edge = max(3, len(x) // 20)
    way = float(np.median(x[-edge:]) - np.median(x[:edge]))
    sign = math.copysign(1.0, way)
    travel = sign * x
    noise = difference_noise(travel, 2)
    stands = _stands(seen, good)
    if stands is not None:
        return _in_motion(seen, time, sign * x, sign, frame, stands, noise)
    first, stop = _few_sliding(travel) if few else _sliding(time, travel, noise, told)
    travel = travel - (travel[0] if few else np.median(travel[: max(first, 3)]))
    tilt_column = (
        None if seen.tilt_deg is None else np.asarray(seen.tilt_deg, float)[good]
    )
    if tilt_column is not None and np.isfinite(tilt_column[:stop]).sum() >= 8:
        tilt = seen_tilt(time[:stop], tilt_column[:stop], time[first], time[stop - 1])
        if not tilt.rate_deg_s > 0:
            raise ValueError("the plate is lowered while the block slides")
    elif told.get("tilt_rate_deg_s"):
        start = told.get("start_deg")
        sd = (unstated_sd if start is None else stated_sd)("start-angle")
        tilt = stated_tilt(told["tilt_rate_deg_s"], start or 0.0, sd, time[first])
    else:
        raise ValueError(
            "the plate's angle is unknown: a tilt_deg column or [slide] start_deg, with"
            " tilt_rate_deg_s where it is raised, is needed"
        )
    begin = max(0, first - max(80, stop - first))
    cut = slice(begin, stop)
    camera = seen.description["camera"]
    return Run(
        seen.recording,
        seen.session,
        time[cut],
        travel[cut],
        frame[cut],
        first - begin,
        tilt,
        mass_of(seen.description),
        1e-3 * float(told.get("start_mm", 0.0)),
        air_drag(seen.description),
        float(camera["scale_sd"]),
        sign * lock(time[cut], x[cut], first - begin, camera.get("mm_per_px") or 0.0),
    )


def _stands(seen, good: np.ndarray) -> Tilt | None:
    """The angle of a plate that stands; None of one that is raised."""
    time = seen.time_s[good]
    if seen.tilt_deg is not None:
        column = np.asarray(seen.tilt_deg, float)[good]
        tilt = seen_tilt(time, column, time[0], time[-1], steps=False)
        return None if tilt.rate_deg_s else tilt
    told = seen.description.get("slide", {})
    if told.get("tilt_rate_deg_s") or told.get("start_deg") is None:
        return None
    return standing_tilt(told["start_deg"], time[0])


def _in_motion(
    seen,
    time: np.ndarray,
    travel: np.ndarray,
    sign: float,
    frame: np.ndarray,
    tilt: Tilt,
    noise: float,
) -> Run:
    """A run on a plate that stands: from where the block is seen to move on."""
    first = first_in_motion(travel, noise)
    first = first if first >= LEAST_REST else 0
    first = max(first, pushed_until(time, travel, noise))
    least = LEAST_OF_FEW if len(time) - first < LEAST_SLIDING else LEAST_SLIDING
    if float(np.ptp(travel)) < max(20 * noise, LEAST_TRAVEL_MM):
        size = float(np.ptp(travel))
        raise ValueError(f"the block does not slide: it moves {size:.2g} mm in all")
    if len(time) - first < least:
        raise ValueError(
            f"{len(time) - first} rows of sliding; at least {least} are needed"
        )
    time, travel, frame = time[first:], travel[first:], frame[first:]
    camera = seen.description["camera"]
    mm_per_px = camera.get("mm_per_px") or 0.0
    return Run(
        seen.recording,
        seen.session,
        time,
        travel - travel[0],
        frame,
        0,
        replace(tilt, origin=float(time[0])),
        mass_of(seen.description),
        0.0,
        air_drag(seen.description),
        float(camera["scale_sd"]),
        sign * lock(time, sign * travel, 0, mm_per_px),
        how=MOVING,
    )


def _few_sliding(travel: np.ndarray) -> tuple[int, int]:
    """First row of the slide and row after the last, of few rows."""
    size = float(np.ptp(travel))
    if size < LEAST_TRAVEL_MM:
        raise ValueError(f"the block does not slide: it moves {size:.2g} mm in all")
    first = int(np.argmax(travel - travel[0] > 0.01 * size))
    first = 0 if first < 2 else first
    if len(travel) - first < LEAST_OF_FEW:
        raise ValueError(
            f"{len(travel) - first} rows of sliding; at least {LEAST_OF_FEW} are needed"
        )
    return first, len(travel)


def _sliding(
    time: np.ndarray, travel: np.ndarray, noise: float, told: dict
) -> tuple[int, int]:
    """First row of the slide and row after the last; ValueError where nothing
    slides."""
    rest, size = rest_and_size(travel)
    if size < max(20 * noise, LEAST_TRAVEL_MM):
        raise ValueError(f"the block does not slide: it moves {size:.2g} mm in all")
    stop = slide_end(time, travel, noise)
    if told.get("travel_mm"):
        beyond = np.flatnonzero(travel - rest > 1.02 * told["travel_mm"])
        stop = min(stop, int(beyond[0])) if len(beyond) else stop
    first = first_in_motion(travel[:stop], noise)  # later than the onset by t ~ x^⅓
    before = time[first - 1] - 0.2 * (time[stop - 1] - time[first - 1])
    first = max(int(np.searchsorted(time, before)), 0)
    if first < LEAST_REST:
        raise ValueError(
            "the block moves from the first rows on: the onset is not in the recording"
        )
    if stop - first < LEAST_SLIDING:
        raise ValueError(
            f"{stop - first} rows of sliding; at least {LEAST_SLIDING} are needed: a"
            " higher frame rate"
        )
    return first, stop


def rest_and_size(travel: np.ndarray) -> tuple[float, float]:
    """Place at rest, from the first rows, and how far the block comes from there."""
    rest = float(np.median(travel[: max(3, len(travel) // 20)]))
    return rest, float(travel.max() - rest)


def slide_end(time: np.ndarray, travel: np.ndarray, noise: float) -> int:
    """Row at which the block meets something: its speed has fallen well below the
    greatest."""
    speed, error = _speeds(time, travel, noise)
    if not len(speed):
        return len(travel)
    peak = int(np.argmax(speed))
    slower = np.flatnonzero(speed[peak:] < 0.75 * speed[peak] - error)
    return peak + 1 if len(slower) else len(travel)


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
    rest, size = rest_and_size(travel)
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
