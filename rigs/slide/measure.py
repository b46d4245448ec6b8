"""One slide → slide angle, static and kinetic friction: the fit of the rig's model to
that recording, with nothing missing.

The mode that the recording shows is told by the evidence of the fits. The angle is that
of the plate when the block lets go, static friction the pull over the press there;
whether friction falls then is averaged over. What the recording tells little of (zero
of the tilt sensor, scale, stated angles, air) is fitted with its prior. A quantity is
good where its 95 % interval would still hold if the next likeliest explanation, an
effect of `effects/` or another mode, were true."""

import math
from dataclasses import dataclass
from functools import partial

import numpy as np

from benchtwin.bench.distributions import t as student
from benchtwin.bench.priors import stated_sd, unstated_sd
from benchtwin.bench.resolution import reading_step
from benchtwin.bench.robust import difference_noise
from benchtwin.infer.noise import frame_lag
from benchtwin.infer.rivals import INSIDE_SDS, unless
from benchtwin.rigs.slide.errors import (
    Errors,
    Value,
    errors_of,
    mixed,
    noise_of,
    rival_effects,
    rival_modes,
    rival_rate,
    share_of_loss,
)
from benchtwin.rigs.slide.model import Model
from benchtwin.rigs.slide.modes import (
    KEEPS,
    LETS_GO,
    MOVING,
    OWN,
    SET_OFF,
    Found,
    Motion,
    Nuisance,
    keeps,
    likeliest,
    onset_sd,
    refined,
)
from benchtwin.rigs.slide.motion import friction_at
from benchtwin.rigs.slide.problem import effects_of
from benchtwin.rigs.slide.session import (
    LEAST_OF_FEW,
    LEAST_REST,
    LEAST_SLIDING,
    LEAST_TRAVEL_MM,
    AirDrag,
    Run,
    Session,
    air_drag,
    first_in_motion,
    mass_of,
    slide_end,
)
from benchtwin.rigs.slide.tilt import Tilt, seen_tilt, standing_tilt, stated_tilt
from benchtwin.vision.measurement import (
    FAILED,
    MeasurementError,
    Quantity,
    all_failed,
    failed,
    vague,
)
from benchtwin.vision.motion.least_squares import all_stated, variance_factor
from benchtwin.vision.motion.outliers import rows_at_rest, single_spikes
from benchtwin.vision.motion.track import Track
from benchtwin.vision.recording import Recording

FEW_ROWS = 16  # with fewer, the rows about the onset do not separate rest and slide
LEAST_TRAVEL_PX = 2.0
FRAME_S = 0.01
CERTAIN_SDS = 10.0  # of a loss of friction: e⁻⁵⁰ is left to none
QUANTITIES = (
    ("slide_angle", "deg"),
    ("static_friction", "1"),
    ("kinetic_friction", "1"),
)
ANGLE_MISSING = (
    "the plate's angle is unknown: give a tilt_deg column in track.csv, or [slide]"
    " start_deg and tilt_rate_deg_s"
)
START_MISSING = (
    "[slide] start_deg is missing: the plate's angle [deg] at t = 0, 0 where it began"
    " level; the rate alone does not tell at which angle the block let go (a tilt_deg"
    " column in track.csv does as well)"
)
FEW = (
    "light gates and tracks of few rows do not show when the block lets go; a reading"
    " of the angle, a film or a longer track does"
)
ALREADY_MOVING = (
    "the block moves from the first frames on: the onset is not in the recording"
)
STANDS = (
    "the plate stands: a block that is let go or pushed there shows no static friction;"
    " a plate that is raised until the block lets go does"
)


@dataclass(frozen=True)
class Slide:
    """Quantities; onset [time unit], None where the block is in motion from the first
    row on; fitted: (time, x) for the plot; notes."""

    quantities: tuple[Quantity, ...]
    onset: float | None
    fitted: tuple[np.ndarray, np.ndarray] | None
    notes: tuple[str, ...] = ()


def measure_slide(track: Track, recording: Recording) -> Slide:
    """Quantities slide_angle, static_friction, kinetic_friction; those that the
    recording does not show are failed, with the reason."""
    used = track.used()
    used = used.marked(single_spikes(used.x)).used()
    few = recording.evidence == "gates.csv" or len(used) < FEW_ROWS
    try:
        return _measure(used, recording, few)
    except MeasurementError as error:
        onset = all_failed(QUANTITIES[:2], FEW if few else str(error))
        return Slide((*onset, failed(*QUANTITIES[2], str(error))), None, None)


def _measure(track: Track, recording: Recording, few: bool) -> Slide:
    if few:
        track.need_physical(recording)
    edge = 1 if few else max(3, len(track) // 20)
    way = np.median(track.x[-edge:]) - np.median(track.x[:edge])
    sign = 1.0 if way >= 0 else -1.0
    x, time = sign * track.x, _clock(track) * track.time
    noise = 0.0 if few else difference_noise(x, 2) + 1e-9
    least = LEAST_TRAVEL_MM if track.unit == "mm" else LEAST_TRAVEL_PX
    if not few and np.ptp(x) < max(20 * noise, least):
        raise MeasurementError(
            f"the block does not slide: it moves {np.ptp(x):.3g} {track.unit} in all"
        )
    sd = float(np.median(track.sd)) if all_stated(track.sd) else 0.0
    first = rows_at_rest(x, sd) if few else first_in_motion(x, noise)
    met = len(x) if few else slide_end(time, x, noise)
    met = met if met >= first + LEAST_SLIDING // 2 else len(x)
    first = min(first, len(x) - 1)
    tilt, nuisances, notes = _plate(track, time, recording, first, met)
    if few and len(x) - first < LEAST_OF_FEW:
        raise MeasurementError(
            f"{len(x) - first} rows of sliding; place, speed and friction need at least"
            f" {LEAST_OF_FEW}"
        )
    begin = first if few else max(0, first - max(80, met - first))
    rows = slice(begin, len(x))
    motion = _motion(track, time, x, rows, first - begin, tilt, recording)
    raised = bool(tilt.coefficients[1])
    modes = [MOVING] if few else [MOVING, LETS_GO] if raised else [MOVING, SET_OFF]
    best, others, end = likeliest(motion, modes, met - begin)
    if few:
        return _of_few(best, nuisances, notes, sign, track)
    ended = None if begin + end == len(x) else float(track.time[begin + end - 1])
    return _of_track(best, others, ended, noise, nuisances, notes, sign, track)


def _clock(track: Track) -> float:
    """Seconds in a unit of the track's time; of frames of unknown rate some: the scale
    that is fitted then is one of length over time squared."""
    return 1.0 if track.timed else FRAME_S


def _motion(
    track: Track,
    time: np.ndarray,
    x: np.ndarray,
    rows: slice,
    rest: int,
    tilt: Tilt,
    recording: Recording,
) -> Motion:
    told = {
        "seed": recording.seed.model_dump(exclude_none=True),
        "air": recording.air.model_dump(exclude_none=True),
    }
    run = Run(
        recording.id,
        recording.session or "",
        time[rows],
        x[rows],
        track.frame[rows],
        rest,
        tilt,
        mass_of(told),
        1e-3 * (recording.slide.start_mm or 0.0),
        air_drag(told) if track.physical else AirDrag(),
        recording.scale_sd,
        np.zeros((len(x[rows]), 2)),
    )
    session = Session((run,), (), (told,), ())
    sd = track.sd[rows]
    sigma = sd if all_stated(sd) else np.ones(len(sd))
    if recording.evidence == "gates.csv" and not all_stated(sd):  # errors of the times
        speed = np.abs(np.gradient(run.travel, run.time))
        sigma = np.maximum(speed, 1e-3 * np.ptp(run.travel) / np.ptp(run.time))
    return Motion(
        Model(session, 0.0, effects_of(session)),
        sigma,
        frame_lag(run.frame),
        free_scale=not track.physical,
        pictured=track.tilt_sd_deg is not None,
    )


def _plate(
    track: Track, time: np.ndarray, recording: Recording, first: int, stop: int
) -> tuple[Tilt, list[Nuisance], list[str]]:
    """The plate's angle, what is not known of it, and notes; MeasurementError naming
    the missing key."""
    stated = recording.slide
    if track.tilt_deg is None:
        known = np.zeros(len(track), dtype=bool)
    else:
        known = np.isfinite(track.tilt_deg)
    others = [
        Nuisance("scale", recording.scale_sd if track.physical else 0.0, True),
        Nuisance("air", 1.0, True),
    ]
    if known[:stop].sum() >= LEAST_OF_FEW:
        column = np.asarray(track.tilt_deg)[:stop]
        ends = time[first], time[stop - 1]
        tilt = seen_tilt(time[:stop], column, *ends, steps=False)
        step = unstated_sd("column-step") * reading_step(column[known[:stop]])
        if np.ptp(column[known[:stop]]) == 0:  # of one number, its step is not known
            step = 0.0
        sd = track.tilt_sd_deg or math.hypot(unstated_sd("tilt-sensor-zero"), step)
        own = [Nuisance(n, 1.0, False) for n in ("level", "rate")]
        return tilt, [Nuisance("zero", sd, True), *own, *others], []
    rate, start = stated.tilt_rate_deg_s, stated.start_deg
    if rate and not track.timed:
        raise MeasurementError(
            f"{recording.toml}: {ANGLE_MISSING} together with camera.fps"
        )
    if start is None:
        raise MeasurementError(
            f"{recording.toml}: {START_MISSING if rate else ANGLE_MISSING}"
        )
    own = [Nuisance(n, 1.0, True) for n in ("level", "rate")]
    if not rate:
        tilt, sd = standing_tilt(start, time[first]), stated_sd("level-plate")
        said = f"the plate is taken to stand at {start:g}°, ± {sd:g}°"
        if rate is None:
            said += ": no tilt_rate_deg_s is stated"
        return tilt, [*own, *others], [said]
    # the clock of light gates starts with the tilting, a film somewhat before it
    gates = recording.evidence == "gates.csv"
    sd = stated_sd("level-plate" if gates else "start-angle")
    tilt = stated_tilt(rate, start, sd, time[first])
    said = (
        f"the plate's angle is as stated: {start:g}° at t = 0, ± {sd:g}°, and {rate:g}"
        f" °/s, ± {100 * stated_sd('tilt-rate'):g} %"
    )
    return tilt, [*own, *others], [said]


def _of_few(
    best: Found,
    nuisances: list[Nuisance],
    notes: list[str],
    sign: float,
    track: Track,
) -> Slide:
    freedom = len(best.motion.lag) - len(best.names)
    factor, doubt = variance_factor(
        max(best.misfit, 1e-18), freedom, all_stated(track.sd)
    )
    best = refined(best, best.motion.noise, tuple(nuisances))
    errors = errors_of(best, factor / best.motion.level**2)
    kinetic = errors.quantity(*QUANTITIES[2], partial(_kinetic, best.motion))
    kinetic = kinetic.doubt(_negative(kinetic), vague(kinetic), doubt)
    onset = all_failed(QUANTITIES[:2], FEW)
    curve = best.motion.run.time, sign * best.motion.seen(best.mode, best.own)
    return Slide((*onset, kinetic), None, curve, tuple(notes))


def _of_track(
    best: Found,
    others: list[tuple[Found, float]],
    met: float | None,
    row_noise: float,
    nuisances: list[Nuisance],
    notes: list[str],
    sign: float,
    track: Track,
) -> Slide:
    """met: when the slide ended in something else than friction."""
    best = refined(best, noise_of(best, nuisances), tuple(nuisances))
    noise = best.motion.noise
    best, errors, (angle, static, kinetic) = _quantities(best)
    motion = best.motion
    if not track.physical:
        missing = "mm_per_px" if track.unit == "px" else "fps"
        why = f"pixels or frames only; camera.{missing} is needed"
        kinetic = failed("kinetic_friction", "1", f"the acceleration is known in {why}")
    doubts = _doubts(best, row_noise, kinetic, static, track.unit)
    rivals = [
        *rival_effects(errors, _values(motion)),
        *rival_modes(best, others),
        *rival_rate(errors, _values),
    ]
    found = tuple(
        q if q.quality == FAILED else q.doubt(vague(q), *doubts, *unless(rivals, q))
        for q in (angle, static, kinetic)
    )
    if (1 - noise.white) * noise.rho > 0.3:
        notes.append(
            f"successive frames err together (ρ = {noise.rho:.2f}); the standard"
            " deviations allow for it"
        )
    if met is not None:
        notes.append(
            f"the slide ends at {met:.4g} {track.time_unit}; what follows is not fitted"
        )
    onset = None
    if best.mode != MOVING:
        onset = (best.own["onset"] + motion.run.tilt.origin) / _clock(track)
    curve = motion.run.time / _clock(track), sign * motion.seen(best.mode, best.own)
    return Slide(found, onset, curve, tuple(notes))


def _quantities(best: Found) -> tuple[Found, Errors, list[Quantity]]:
    """The likelier fit, its errors, and the three quantities; averaged over whether the
    block loses friction when it lets go."""
    found = _errors(best)
    if best.mode != LETS_GO:
        raised = bool(best.motion.run.tilt.coefficients[1])
        why = ALREADY_MOVING if raised else STANDS
        kinetic = found.quantity(*QUANTITIES[2], _values(best.motion)[QUANTITIES[2][0]])
        return best, found, [*all_failed(QUANTITIES[:2], why), kinetic]
    values = _values(best.motion)
    loss = found.quantity(
        "loss", "1", lambda own: _static(best.motion, own) - own["friction"]
    )
    if loss.value > CERTAIN_SDS * loss.sd:
        return best, found, [found.quantity(*q, values[q[0]]) for q in QUANTITIES]
    held = keeps(best)
    share = share_of_loss(best, held, loss.sd)
    stays = _errors(held)
    each = [
        mixed(stays.quantity(*q, values[q[0]]), found.quantity(*q, values[q[0]]), share)
        for q in QUANTITIES
    ]
    return (best, found, each) if share > 0.5 else (held, stays, each)


def _errors(best: Found) -> Errors:
    freedom = max(len(best.motion.lag) - len(OWN[best.mode]), 1)
    widen = (student.ppf(0.975, freedom) / INSIDE_SDS) ** 2
    stay = onset_sd(best) if best.mode == LETS_GO else 0.0
    return errors_of(best, widen, stay * math.sqrt(widen))


def _values(motion: Motion) -> dict[str, Value]:
    return {
        "slide_angle": partial(_angle_deg, motion),
        "static_friction": partial(_static, motion),
        "kinetic_friction": partial(_kinetic, motion),
    }


def _kinetic(motion: Motion, own: dict[str, float]) -> float:
    return motion.laws(own)[1].friction


def _angle_deg(motion: Motion, own: dict[str, float]) -> float:
    tilt, _ = motion.laws(own)
    return math.degrees(np.polynomial.polynomial.polyval(own["onset"], tilt))


def _static(motion: Motion, own: dict[str, float]) -> float:
    tilt, laws = motion.laws(own)
    return friction_at(own["onset"], tilt, laws)


def _negative(kinetic: Quantity) -> str:
    if not kinetic.value < -2 * kinetic.sd:
        return ""
    return "negative kinetic friction: are angle, scale and times right?"


def _doubts(
    best: Found, row_noise: float, kinetic: Quantity, static: Quantity, unit: str
) -> list[str]:
    """What a user can act on."""
    run, doubts = best.motion.run, [_negative(kinetic)]
    onset = best.own.get("onset", best.motion.since[0])
    before = int((best.motion.since < onset).sum())
    sliding = len(run.time) - before
    if best.mode in (LETS_GO, KEEPS) and before < LEAST_REST - 1:
        doubts.append(ALREADY_MOVING)
    if sliding < LEAST_SLIDING // 2:
        doubts.append(f"only {sliding} frames of sliding")
    left = float(np.sqrt(np.mean(best.residual**2)))
    if left > max(5 * row_noise, 0.02 * float(np.ptp(run.travel))):
        doubts.append(
            "the travel is not that of one block under constant friction (off by"
            f" {left:.2g} {unit})"
        )
    if kinetic.value > static.value + 2 * math.hypot(kinetic.sd, static.sd):
        doubts.append("kinetic friction above static friction")
    return doubts
