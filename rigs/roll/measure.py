"""One roll → run-out, rolling friction and rolling resistance, or acceleration and
rolling resistance of a seed that stays on its incline: the fit of the rig's model to
that recording, with nothing missing.

    rolling_resistance   μ_r: torque over normal force times rolling radius
    rolling_friction     S sin β / (S cos β + L): Eq. 3 (bench/run_out.py)
    run_out              L, from the junction of the plates to the stop
    acceleration         g (sin β − μ_r cos β) / (1 + I/(m r²)), without air

Films, tracks, few rows and light gates are evidence of the same model. A quantity is
good where its 95 % interval would still hold if the next likeliest explanation, an
effect of `effects/`, were true."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from benchtwin.bench.distributions import t as student
from benchtwin.bench.language import tr
from benchtwin.bench.priors import stated_sd, unstated_sd
from benchtwin.bench.robust import difference_noise
from benchtwin.bench.run_out import rolling_friction
from benchtwin.infer.noise import frame_lag
from benchtwin.infer.problem import Fit, fit
from benchtwin.infer.rivals import INSIDE_SDS, Rival, unless
from benchtwin.rigs.one_recording import OneRecording
from benchtwin.rigs.roll.diagnose import baseline
from benchtwin.rigs.roll.inertia import inertia_of_recording
from benchtwin.rigs.roll.initial_path import LEAST_BEFORE
from benchtwin.rigs.roll.model import (
    OWN,
    as_read,
    beside_m,
    incline_of,
    junction_of,
    resistance_of,
    run_motion,
    way_of,
)
from benchtwin.rigs.roll.motion import travel
from benchtwin.rigs.roll.problem import (
    CUT,
    FREE_SCALE_SD,
)
from benchtwin.rigs.roll.read import SeenRoll, seen_roll
from benchtwin.rigs.roll.roll_path import ends_on_incline, stays_on_incline
from benchtwin.rigs.roll.run_noise import has_few_rows
from benchtwin.rigs.roll.session import (
    FEW_ROWS,
    Run,
    Seed,
    run_of,
    seed_of,
    weight_over_inertia,
)
from benchtwin.vision.measurement import (
    MeasurementError,
    Quantity,
    all_failed,
    failed,
    vague,
)
from benchtwin.vision.motion.least_squares import variance_factor
from benchtwin.vision.motion.track import Track
from benchtwin.vision.recording import Recording

LEAST_ROWS, LEAST_OF_FILM = 4, 8
LEAST_TRAVEL = {"mm": 1.0, "px": 4.0}
FRAME_S = 0.01  # of frames of unknown rate, for a first scale
USUAL_FRICTION = 0.03  # for a first scale
LATER_S = 20.0  # after the last row, when a seed has stopped
LEAST_REST = 5  # rows that show where a seed rests
NEAR_AHEAD, FAR_AHEAD = 0.02, 0.25  # of the way, by which a stop is extrapolated
UNEVEN = 0.01  # of the way: what a seed is off that does not slow down evenly
CONFLICT_SDS = 4.0  # of what is stated
MOST_TENSION = 22.0  # χ² with 3 degrees of freedom; as improbable as CONFLICT_SDS
CURVE_POINTS = 400
NO_CORNER = (
    "neither the release nor the end of the incline is in the track: begin it before"
    " the seed is let go, or state [roll] incline_length_mm"
)
STILL_MOVING = (
    "the seed is still moving in the last frame: it leaves the picture, or the"
    " recording ends too early"
)
OFF_JUNCTION = (
    "by the motion and incline_length_mm the incline ends {} {} {} the corner that the"
    " picture shows, which is not used: see the overlay"
)
LEVEL = (("run_out", "mm"), ("rolling_friction", "1"), ("rolling_resistance", "1"))
INCLINE = (("acceleration", "m/s²"), ("rolling_resistance", "1"))
REST = "rest_m"  # where a seed lies at rest, as read
SHARED = ("incline", "inertia", "corner", "air", "level")  # by all rolls of a session


@dataclass(frozen=True)
class RunOut:
    """Quantities; places along the path [track unit]; fitted: (time, x) for the plot;
    notes."""

    quantities: tuple[Quantity, ...]
    junction: float | None = None
    stop: float | None = None
    stop_time: float | None = None
    fitted: tuple[np.ndarray, np.ndarray] | None = None
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Evidence:
    """A recording as it is fitted. unit: of the track's lengths [m], where the scale is
    unknown a first guess, beside which it is fitted; sign: of the motion along x."""

    recording: Recording
    track: Track
    seen: SeenRoll
    run: Run
    seed: Seed
    unit: float
    sign: float


@dataclass(frozen=True, eq=False)
class Fitted:
    """Evidence and its fit. looser: factor on the sds of rows; rest: where the seed lay
    at rest, and its sd [m as read], or None."""

    told: Evidence
    fit: Fit
    looser: float
    rest: tuple[float, float] | None = None

    @cached_property
    def one(self) -> OneRecording:
        """The fit as quantities are read from it."""
        beside = None if self.rest is None else {REST: self.rest}
        return OneRecording(self.fit, OWN, self.quantities_at, self.looser, beside)

    @cached_property
    def at(self) -> dict[str, float]:
        """All parameters by name."""
        return self.one.by_name(self.one.values_of(self.fit))

    def motion(
        self, time: np.ndarray, at: Mapping[str, float]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Places as read [m] and speeds [m/s] (n,) at any times."""
        own, shared = own_of(at), dict(at)
        model = self.fit.problem.model
        way = way_of(model, 0, own, shared)
        x, v = travel(time, way, resistance_of(model, 0, own, shared))
        return as_read(model, 0, own, shared, x), v

    def ends(self, at: Mapping[str, float]) -> np.ndarray:
        """Where the run-out begins and, by the fit, ends [m as read]."""
        own, shared = own_of(at), dict(at)
        model = self.fit.problem.model
        junction = np.array([junction_of(model, 0, own, shared)])
        stop = self.motion(self.told.run.time_s[-1:] + LATER_S, at)[0]
        return np.append(as_read(model, 0, own, shared, junction), stop)

    def quantities_at(self, at: Mapping[str, float]) -> dict[str, float]:
        """The quantities for some parameters."""
        own, shared, told = own_of(at), dict(at), self.told
        model = self.fit.problem.model
        way = way_of(model, 0, own, shared)
        if told.run.stays:
            speeding = way.f * (way.sin - way.cos * way.mu)
            return {"acceleration": speeding, "rolling_resistance": way.mu}
        ends = self.ends(at)
        ends[1] = at.get(REST, ends[1])
        scale = 1 + at[f"scale.{told.run.session}"]
        beside = beside_m(model, 0, own, scale * ends)
        true = float(np.diff(scale * ends + beside)[0])
        length = float(model.length[0] + at["length_m"])
        beta = math.degrees(incline_of(model, 0, own, shared))
        falls = 0.0 if math.isnan(told.run.slope) else told.run.sign * told.run.slope
        return {
            "run_out": true / (1.0 if told.track.physical else scale) / told.unit,
            "rolling_friction": rolling_friction(length, beta, true, falls)[0],
            "rolling_resistance": way.mu,
        }

    @cached_property
    def quantities(self) -> dict[str, Quantity]:
        """With their sds; an unknown slope averages out over rolls in both directions,
        where these are stated."""
        told = self.told
        units = dict(INCLINE) if told.run.stays else dict(LEVEL)
        units |= {} if told.run.stays else {"run_out": told.track.unit}
        own = ("level",) if told.recording.roll.direction else ()
        shared = [
            name
            for name in self.fit.names
            if (name in SHARED and name not in own)
            or name.startswith(("scale.", "gate."))
        ]
        return self.one.quantities(units, shared)

    @cached_property
    def rivals(self) -> list[Rival]:
        """Each effect that this recording may show, fitted in full."""
        return self.one.rivals()


def own_of(at: Mapping[str, float]) -> np.ndarray:
    """A run's own parameters (L,)."""
    return np.array([at[name] for name in OWN])


def measure_roll(
    track: Track, recording: Recording, *, junction: tuple[float, float] | None = None
) -> RunOut:
    """Measure a roll; junction: (place, sd) along the path where the picture shows
    it."""
    used = track.used()
    stays = stays_on_incline(used, recording)
    try:
        told = _evidence(used, recording, stays, junction)
        return _measured(told, seen=junction is not None)
    except ValueError as error:
        return RunOut(all_failed(INCLINE if stays else LEVEL, str(error)))


def _evidence(
    track: Track,
    recording: Recording,
    stays: bool,
    junction: tuple[float, float] | None,
) -> Evidence:
    few = recording.evidence == "gates.csv" or len(track) < FEW_ROWS
    if few or stays:
        track.need_physical(recording)
    _check(track, recording, LEAST_ROWS if few or stays else LEAST_OF_FILM)
    inertia_of_recording(recording)  # a gap that the ball falls through is told now
    unit = 1e-3 if track.physical else _first_unit(track, recording)
    seen = _in_mm(track, recording, unit, stays)
    seed = seed_of(seen.description)
    run, sign = run_of(seen, seed), 1.0 if track.x[-1] >= track.x[0] else -1.0
    if not track.timed:  # lengths are not those of the fit then, which has another g
        run = replace(run, length=math.nan)
    if junction is not None:
        run = replace(run, junction=(sign * junction[0] * unit, junction[1] * unit))
    elif has_few_rows(run) and not stays and not _waits(seen):
        at = (run.length, stated_sd("way-on-incline") / 1000)  # from the release
        run = replace(run, junction=at if math.isfinite(run.length) else None)
    return Evidence(recording, track, seen, run, seed, unit, sign)


def _check(track: Track, recording: Recording, least: int) -> None:
    """MeasurementError for too few rows, a seed that rests, or one that never reaches
    the level on which it is stated to roll."""
    if len(track) < least:
        raise MeasurementError(
            tr("{} usable rows; a roll needs at least {}", len(track), least)
        )
    moved = float(np.ptp(track.x))
    if moved < LEAST_TRAVEL[track.unit]:
        raise MeasurementError(
            tr("the seed does not roll: it moves {:.3g} {} in all", moved, track.unit)
        )
    length = recording.roll.incline_length_mm
    is_level = recording.roll.level and length and track.physical
    if is_level and ends_on_incline(track.t_s, track.x, length):
        raise MeasurementError(
            tr(
                "the seed does not leave the incline ({:.4g} of {:g} mm): there is no"
                " run-out",
                moved,
                length,
            )
        )


def _waits(seen: SeenRoll) -> bool:
    """Whether a track begins before the release."""
    first = float(seen.x_mm[1] - seen.x_mm[0])
    return not seen.gates and abs(first) < 0.01 * float(np.ptp(seen.x_mm))


def _in_mm(track: Track, recording: Recording, unit: float, stays: bool) -> SeenRoll:
    """The track in millimetres and seconds, by a first guess where these are
    unknown."""
    seconds = track.t_s if track.timed else FRAME_S * track.frame
    mm = 1e3 * unit
    scaled = replace(track, x=mm * track.x, sd=mm * track.sd, t_s=seconds, unit="mm")
    return seen_roll(scaled, recording, stays)


def _first_unit(track: Track, recording: Recording) -> float:
    """Of the track's lengths [m], from the seed's acceleration."""
    seen = _in_mm(track, recording, 1e-3, stays=False)
    seed = seed_of(seen.description)
    way, f = run_of(seen, seed).way, weight_over_inertia(seed)
    if recording.roll.incline_deg is None:
        return 1e-3 * f * USUAL_FRICTION / way.slowing
    beta = math.radians(recording.roll.incline_deg)
    drive = math.sin(beta) - USUAL_FRICTION * math.cos(beta)
    return 1e-3 * f * drive / way.acceleration


def _measured(told: Evidence, *, seen: bool) -> RunOut:
    """seen: whether the junction is where the picture shows it. Where the motion and
    the incline's stated length contradict that, they are used without it, and both
    told."""
    found, doubt, notes = _fitted(told)
    doubts, junction = [doubt], told.run.junction if seen else None
    stated = math.isfinite(told.run.length)
    if junction and stated and _tension(found, *junction) > MOST_TENSION:
        told = replace(told, run=replace(told.run, junction=None))
        found, doubt, notes = _fitted(told)
        off = (found.ends(found.at)[0] - junction[0]) / told.unit
        where = tr("behind") if off > 0 else tr("before")
        size = f"{abs(off):.2g}"
        doubts = [doubt, tr(OFF_JUNCTION, size, told.track.unit, where)]
    doubts += _conflicts(found)
    if told.run.stays:
        return _on_incline(found, doubts, notes)
    return _with_run_out(found, doubts, notes)


def _fitted(told: Evidence) -> tuple[Fitted, str, tuple[str, ...]]:
    """The fit, why stated sds cannot hold, or "", and notes."""
    run, camera = told.run, told.seen.description["camera"]
    scale_sd = float(camera["scale_sd"]) if told.track.physical else FREE_SCALE_SD
    scales, rng = {run.session: scale_sd}, np.random.default_rng(1)
    problem, base, notes = baseline((run,), told.seed, scales, rng)
    base = base if base.problem is problem else fit(problem)
    looser, doubt = _looser(base)
    return Fitted(told, base, looser), doubt, (*run.notes, *notes, *_said(told))


def _tension(found: Fitted, place: float, sd: float) -> float:
    """χ² with 3 degrees of freedom, about the fit, of the junction seen in the picture
    at `place` ± `sd` [m], the incline's stated length and how far before it the path
    turns."""
    at = found.at
    seen = (found.ends(at)[0] - place) / sd
    longer = 1e3 * at["length_m"] / stated_sd("way-on-incline")
    earlier = (at["cut"] - CUT) / CUT
    return float(seen**2 + longer**2 + earlier**2)


def _looser(base: Fit) -> tuple[float, str]:
    """Factor on the rows' sds so that ± 1.96 sd is a 95 % interval, and why stated sds
    cannot hold, or ""."""
    run, problem = base.problem.model.runs[0], base.problem
    shown = 0 if run.stays else 1 + math.isnan(run.incline) + math.isnan(run.length)
    freedom = problem.freedom - 1 - shown  # friction, and what the corner may do
    if has_few_rows(run):
        stated = bool(np.isfinite(run.sd_m).all())
        if stated or not run.stays:
            factor, doubt = variance_factor(base.chi2, max(freedom, 1), stated)
            return math.sqrt(factor), doubt
    of_level = 2 / max(problem.level_sd, 1e-3) ** 2
    wider = float(student.ppf(0.975, of_level)) / INSIDE_SDS
    return wider, ""


def _conflicts(found: Fitted) -> list[str]:
    """What is stated that the motion contradicts."""
    at, run, out = found.at, found.told.run, []
    longer, beside = 1e3 * at["length_m"], at["incline_deg"]
    told = math.isfinite(run.length) and not run.stays
    if told and abs(longer) > CONFLICT_SDS * stated_sd("way-on-incline"):
        out.append(
            tr(
                "by the motion the incline ends {:+.3g} mm from where it is stated to:"
                " check incline_length_mm and the scale",
                longer,
            )
        )
    steeper, known = beside + at["incline"], math.isfinite(run.incline)
    if known and abs(steeper) > CONFLICT_SDS * stated_sd("incline"):
        out.append(
            tr(
                "by the motion the incline is {:+.2g}° from the stated angle: check"
                " incline_deg, the scale and the times",
                steeper,
            )
        )
    name = f"scale.{run.session}"
    sd = found.fit.problem.known_sd[name]
    if abs(at[name]) > CONFLICT_SDS * sd and found.told.track.physical:
        out.append(
            tr(
                "by the motion the scale is off by {:+.2g} %: check mm_per_px and the"
                " times",
                100 * at[name],
            )
        )
    return out


def _on_incline(found: Fitted, doubts: list[str], notes: tuple[str, ...]) -> RunOut:
    told, roll = found.told, found.told.recording.roll
    acceleration, friction = found.quantities.values()
    acceleration = acceleration.doubt(*doubts, *unless(found.rivals, acceleration))
    if roll.incline_deg is None:
        why = tr("without it an acceleration gives no rolling friction")
        message = tr("{}: [roll] incline_deg is missing; {}", told.recording.toml, why)
        friction = failed("rolling_resistance", "1", message)
    else:
        fast = tr("negative: the seed rolls faster than without resistance; check")
        fast += tr(" incline_deg, scale and inertia_factor")
        fast = fast if friction.value < -2 * friction.sd else ""
        friction = friction.doubt(*doubts, fast, *unless(found.rivals, friction))
    return RunOut((acceleration, friction), fitted=_curve(found), notes=notes)


def _with_run_out(found: Fitted, doubts: list[str], notes: tuple[str, ...]) -> RunOut:
    told, unit = found.told, found.told.unit
    junction = float(found.ends(found.at)[0])
    cornerless = _cornerless(found)
    stop = _stop(found)
    if stop.place <= junction:
        raise MeasurementError(
            tr("the seed stops before the junction: it never reaches the level plate")
        )
    found = replace(found, rest=stop.rest)
    run_out, eq_3, resistance = found.quantities.values()
    run = told.run
    own, shared = found.fit.starts[0], found.fit.by_name
    left = run.x - run_motion(found.fit.problem.model, 0, own, shared)[0]
    off = float(np.sqrt(np.mean(left**2)))
    if off > UNEVEN * (stop.place - junction) and not has_few_rows(run):
        doubts.append(
            tr(
                "the travel is not that of one seed that slows down evenly: it is off"
                " by {:.2g} {}",
                off / unit,
                told.track.unit,
            )
        )
    run_out = run_out.doubt(*doubts, stop.doubt, *unless(found.rivals, run_out))
    eq_3 = eq_3.doubt(*doubts, stop.doubt, *unless(found.rivals, eq_3))
    unsure = vague(resistance)
    resistance = resistance.doubt(*doubts, unsure, *unless(found.rivals, resistance))
    unseen = tr(NO_CORNER) if vague(run_out) else ""
    lacking = _lacking(told)
    if none := cornerless or stop.none or unseen:
        run_out = failed("run_out", told.track.unit, none)
        lacking = (none, lacking[1])
    eq_3 = failed("rolling_friction", "1", lacking[0]) if lacking[0] else eq_3
    if lacking[1]:
        resistance = failed("rolling_resistance", "1", lacking[1])
    above = eq_3.value - resistance.value
    if above > 3 * math.hypot(eq_3.sd, resistance.sd) and resistance.value > 0:
        share = tr("{:.2g} % above rolling_resistance", 100 * above / resistance.value)
        losses = tr("it counts losses to the air and at the corner as friction")
        notes = (*notes, tr("rolling_friction (Eq. 3) is {}: {}", share, losses))
    return RunOut(
        (run_out, eq_3, resistance),
        told.sign * junction / unit,
        None if none else told.sign * stop.place / unit,
        None if none else stop.time / _clock(told),
        _curve(found),
        notes,
    )


def _cornerless(found: Fitted) -> str:
    """Why rows that show no corner give no run-out, or ""; MeasurementError where they
    show no slowing down either."""
    own, shared, run = found.fit.starts[0], found.fit.by_name, found.told.run
    way = way_of(found.fit.problem.model, 0, own, shared)
    if way.mu <= 0:
        raise MeasurementError(
            tr(
                "the seed does not slow down on the level: its rows give neither"
                " run-out nor friction"
            )
        )
    unstated = math.isnan(run.length) and run.junction is None
    return (
        tr(NO_CORNER) if unstated and (run.x < way.corner).sum() < LEAST_BEFORE else ""
    )


@dataclass(frozen=True)
class Stop:
    """place [m as read] and time [s] of a seed's stop; rest: that place and its sd
    where it was seen at rest; doubt, and why there is no stop, or ""."""

    place: float
    time: float
    rest: tuple[float, float] | None = None
    doubt: str = ""
    none: str = ""


def _stop(found: Fitted) -> Stop:
    """Where the seed is at rest in the last rows, else where the fit says that it will
    be."""
    seen, unit = found.told.seen, found.told.unit
    time, x, few = seen.time_s, seen.x_mm / 1000, has_few_rows(found.told.run)
    moving = np.flatnonzero(found.motion(time, found.at)[1])
    last = int(moving[-1]) if len(moving) else len(time) - 1
    if len(time) - 1 - last >= LEAST_REST and not few:
        rest, doubt = _rest(x[last + 1 :], seen.frame[last + 1 :], found)
        return Stop(rest[0], float(time[last]), rest, doubt)
    junction, end = found.ends(found.at)
    ahead, way = end - x[-1], end - junction if few else float(np.ptp(x))
    said = tr("by {:.3g} {} beyond the last row", ahead / unit, found.told.track.unit)
    doubt = tr("the stop is extrapolated {}", said)
    if ahead <= (FAR_AHEAD if few else NEAR_AHEAD) * way:
        doubt = ""
    none = tr(STILL_MOVING) if ahead > FAR_AHEAD * way and not few else ""
    return Stop(float(end), float(time[last]), None, doubt, none)


def _rest(
    x: np.ndarray, frame: np.ndarray, found: Fitted
) -> tuple[tuple[float, float], str]:
    """Where a seed rests, and its sd [m] by the noise of the fit, by the last two
    thirds, when what rocks has lost most of its swing; and a doubt."""
    late, told, series = (
        slice(len(x) // 3, None),
        found.told,
        found.fit.problem.series[0],
    )
    rows = np.column_stack([np.ones(len(x)), x])[late]
    one, white = series.noise.whiten(rows, frame_lag(frame[late])).T
    place = float(one @ white / (one @ one))
    sd = found.looser * float(np.mean(series.sigma)) / math.sqrt(one @ one)
    swing = float(np.ptp(x[late])) / 2
    if swing <= 6 * difference_noise(x, 2) + 0.5 * told.unit:
        return (place, sd), ""
    said = tr("the seed still rocks by ± {:.2g} {}", swing / told.unit, told.track.unit)
    return (place, math.hypot(sd, swing / 2)), tr(
        "{} at the end of the recording", said
    )


def _lacking(told: Evidence) -> tuple[str, str]:
    """Why there is no rolling friction by Eq. 3, and no rolling resistance; "" where
    there is."""
    why = ["", ""]
    try:
        told.track.need_physical(told.recording)
    except MeasurementError as error:
        why = [str(error), str(error)]
    try:
        for key in ("roll.incline_length_mm", "roll.incline_deg"):
            told.recording.need(key, tr("for rolling_friction (Eq. 3)"))
    except MeasurementError as error:
        why[0] = str(error)
    return why[0], why[1]


def _curve(found: Fitted) -> tuple[np.ndarray, np.ndarray]:
    """Times and places of the fitted curve in the track's units, for the plot."""
    told = found.told
    time = np.linspace(told.seen.time_s[0], told.seen.time_s[-1], CURVE_POINTS)
    x = told.sign * found.motion(time, found.at)[0] / told.unit
    return time / _clock(told), x


def _clock(told: Evidence) -> float:
    """Seconds in a unit of the track's time."""
    return 1.0 if told.track.timed else FRAME_S


def _said(told: Evidence) -> list[str]:
    """What the numbers are based on."""
    roll, inertia = told.recording.roll, inertia_of_recording(told.recording)
    on = (
        tr("on rails {:g} mm apart", roll.rail_gap_mm)
        if roll.rail_gap_mm
        else tr("on a plate")
    )
    sd = inertia.factor * inertia.sd
    notes = [tr("1 + I/(m r²) is taken as {:.4g} ± {:.2g}, {}", inertia.factor, sd, on)]
    if told.seed.drag and told.seed.drag_sd >= told.seed.drag:
        missing = tr("[seed] sizes and mass_g or density_kg_m3 are unknown")
        notes.append(tr("air drag is a usual seed's, ± 100 %: {}", missing))
    if roll.slope_deg is None and not told.run.stays:
        both = (
            tr("rolled both ways it averages out")
            if roll.direction
            else tr("state [roll] direction and roll in both")
        )
        level = unstated_sd("level-plate")
        notes.append(
            tr(
                "the plate is taken to be level to ± {:g}°, as [roll] slope_deg is not"
                " stated; {}",
                level,
                both,
            )
        )
    return notes
