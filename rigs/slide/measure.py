"""One slide → slide angle, static and kinetic friction: the fit of the rig's model to
that recording, with nothing missing.

How the block moves is told by the evidence of the fits. The angle is that of the plate
when the block lets go, static friction the pull over the press there; how much friction
it loses then is averaged over. What the recording tells little of (zero of the tilt
sensor, scale, stated angles, air) is fitted with its prior. A quantity is good where
its 95 % interval would still hold if the next likeliest explanation, an effect of
`effects/` or another way to move, were true."""

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from benchtwin.bench.distributions import t as student
from benchtwin.bench.priors import stated_sd, unstated_sd
from benchtwin.bench.resolution import reading_step
from benchtwin.bench.robust import difference_noise
from benchtwin.infer.noise import Noise
from benchtwin.infer.problem import Fit, ln_evidence
from benchtwin.infer.rivals import INSIDE_SDS, Rival, by_name, unless
from benchtwin.infer.series import noise_about
from benchtwin.rigs.one_recording import OneRecording
from benchtwin.rigs.slide.model import OWN, Model, laws_of, of_own, run_motion, tilt_of
from benchtwin.rigs.slide.motion import friction_at
from benchtwin.rigs.slide.problem import (
    FEW_SD_MM,
    LOSES,
    WHITE,
    Alone,
    alone,
    likeliest,
    wander_of,
)
from benchtwin.rigs.slide.session import (
    LEAST_OF_FEW,
    LEAST_REST,
    LEAST_SLIDING,
    LEAST_TRAVEL_MM,
    LETS_GO,
    MOVING,
    SET_OFF,
    WAVES,
    AirDrag,
    Run,
    Session,
    air_drag,
    first_in_motion,
    mass_of,
    slide_end,
)
from benchtwin.rigs.slide.starts import start_of
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

LEVELS = 3  # times the sd of few rows is estimated
FEW_ROWS = 16  # with fewer, the rows about the onset do not separate rest and slide
LEAST_TRAVEL_PX = 2.0
FRAME_S = 0.01
CERTAIN_SDS = 10.0  # of a loss of friction: e⁻⁵⁰ is left to none
LEAST_LOSS, MOST_LOSS, LOSSES = 1e-3, 0.5, 16  # of friction at the onset; so many tried
UNLIKELY = 12.0  # ln by which one is, below the likeliest
USUAL_WAY_MM = 100.0  # of a block whose unit of length is unknown, for a first scale
FREE_SCALE_SD = 3.0  # relative, there
WORDS = {
    LETS_GO: "the block rests at first",
    MOVING: "the block moves from the first row on",
    SET_OFF: "the block is set off within the recording",
}
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
    tilt, own, notes = _plate(track, time, recording, first, met)
    if few and len(x) - first < LEAST_OF_FEW:
        raise MeasurementError(
            f"{len(x) - first} rows of sliding; place, speed and friction need at least"
            f" {LEAST_OF_FEW}"
        )
    begin = first if few else max(0, first - max(80, met - first))
    rows = slice(begin, len(x))
    seen = _seen(track, time, x, rows, first - begin, tilt, recording, own)
    if few:
        return _of_few(seen, notes, sign)
    hows = [MOVING, SET_OFF] if tilt.stands else [MOVING, LETS_GO]
    ways = likeliest(seen.run, hows, met - begin, seen.sigma)
    return _of_track(seen, ways, begin, noise, notes, sign)


def _clock(track: Track) -> float:
    """Seconds in a unit of the track's time; of frames of unknown rate some: the scale
    that is fitted then is one of length over time squared."""
    return 1.0 if track.timed else FRAME_S


@dataclass(frozen=True, eq=False)
class Seen:
    """A track as it is fitted. unit: millimetres of the fit in a unit of its lengths;
    sigma (n,): relative sds of its rows; shared: names of parameters whose errors are
    the same in all slides of a session."""

    track: Track
    run: Run
    sigma: np.ndarray
    unit: float
    shared: tuple[str, ...]


def _seen(
    track: Track,
    time: np.ndarray,
    x: np.ndarray,
    rows: slice,
    rest: int,
    tilt: Tilt,
    recording: Recording,
    shared: tuple[str, ...],
) -> Seen:
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
        recording.scale_sd if track.physical else FREE_SCALE_SD,
        np.zeros((len(x[rows]), 2)),
        pictured=track.tilt_sd_deg is not None,
    )
    unit = 1.0 if track.physical else _first_unit(run)
    run = replace(run, travel=unit * run.travel)
    sd = track.sd[rows]
    sigma = sd if all_stated(sd) else np.ones(len(sd))
    if recording.evidence == "gates.csv" and not all_stated(sd):  # errors of the times
        speed = np.abs(np.gradient(run.travel, run.time))
        sigma = np.maximum(speed, 1e-3 * np.ptp(run.travel) / np.ptp(run.time))
    return Seen(track, run, sigma / np.median(sigma), unit, shared)


def _first_unit(run: Run) -> float:
    """Millimetres in a unit of the travel, from the pull of a plate that is raised."""
    if run.tilt.stands:
        return USUAL_WAY_MM / float(np.ptp(run.travel))
    alone = Model(Session((run,), (), (), ()), 0.0)
    stretch = start_of(alone, 0, np.ones(len(run.time)), jump=True, free=True).stretch
    return 1 / max(stretch, 1e-6 * float(np.ptp(run.travel)))


def _plate(
    track: Track, time: np.ndarray, recording: Recording, first: int, stop: int
) -> tuple[Tilt, tuple[str, ...], list[str]]:
    """The plate's angle, names of the run's parameters whose errors all slides of a
    session have, and notes; MeasurementError naming the missing key."""
    stated = recording.slide
    if track.tilt_deg is None:
        known = np.zeros(len(track), dtype=bool)
    else:
        known = np.isfinite(track.tilt_deg)
    if known[:stop].sum() >= LEAST_OF_FEW:
        column = np.asarray(track.tilt_deg)[:stop]
        ends = time[first], time[stop - 1]
        tilt = seen_tilt(time[:stop], column, *ends, steps=False)
        step = reading_step(column[known[:stop]])
        if np.ptp(column[known[:stop]]) == 0:  # of one number, its step is not known
            step = 0.0
        return replace(tilt, grid_deg=step, zero_sd_deg=track.tilt_sd_deg), (), []
    rate, start = stated.tilt_rate_deg_s, stated.start_deg
    if rate and not track.timed:
        raise MeasurementError(
            f"{recording.toml}: {ANGLE_MISSING} together with camera.fps"
        )
    if start is None:
        raise MeasurementError(
            f"{recording.toml}: {START_MISSING if rate else ANGLE_MISSING}"
        )
    own = ("level", "rate")
    if not rate:
        tilt, sd = standing_tilt(start, time[first]), stated_sd("level-plate")
        said = f"the plate is taken to stand at {start:g}°, ± {sd:g}°"
        if rate is None:
            said += ": no tilt_rate_deg_s is stated"
        return tilt, own, [said]
    # the clock of light gates starts with the tilting, a film somewhat before it
    gates = recording.evidence == "gates.csv"
    sd = stated_sd("level-plate" if gates else "start-angle")
    tilt = stated_tilt(rate, start, sd, time[first])
    said = (
        f"the plate's angle is as stated: {start:g}° at t = 0, ± {sd:g}°, and {rate:g}"
        f" °/s, ± {100 * stated_sd('tilt-rate'):g} %"
    )
    return tilt, own, [said]


def _of_few(seen: Seen, notes: list[str], sign: float) -> Slide:
    track, run = seen.track, replace(seen.run, how=MOVING)
    stated, freedom = all_stated(track.sd), len(run.time) - 3
    level = float(np.median(track.sd)) if stated else FEW_SD_MM
    near = None
    for _ in range(1 if stated else LEVELS):
        found = alone(run, WHITE, level * seen.sigma, near)
        near, misfit = found.fit, _misfit(found, level * seen.sigma)
        level *= math.sqrt(misfit / freedom)
    factor, doubt = variance_factor(misfit, freedom, stated)
    one = _one(found.fit, math.sqrt(factor))
    (kinetic,) = one.quantities(dict(QUANTITIES[2:]), _shared(seen, one.fit)).values()
    kinetic = kinetic.doubt(_negative(kinetic), vague(kinetic), doubt)
    onset = all_failed(QUANTITIES[:2], FEW)
    return Slide((*onset, kinetic), None, _curve(seen, found, sign), tuple(notes))


def _misfit(found: Alone, sigma: np.ndarray) -> float:
    """χ² about place, speed and friction alone: priors take no share in few rows'
    scatter."""
    of = found.fit
    assert of.problem.derivatives is not None
    columns = of.problem.derivatives(0, of.starts, of.values)[1][: len(sigma)]
    columns = columns / sigma[:, None]
    left = found.left / sigma + columns @ np.append(of.starts[0], of.values)
    free = columns[:, [OWN.index(n) for n in ("place", "speed", "own friction")]]
    left = left - free @ np.linalg.lstsq(free, left, rcond=None)[0]
    return max(float(left @ left), 1e-18)


def _of_track(
    seen: Seen,
    ways: list[Alone],
    begin: int,
    row_noise: float,
    notes: list[str],
    sign: float,
) -> Slide:
    """ways: in which the block may move, likeliest first; begin: the first row."""
    track, best = seen.track, ways[0]
    best, noise = _about(seen, best)
    ones, best = _losses(best)
    quantities = _mixed(seen, best, ones)
    if best.run.how != LETS_GO:
        why = STANDS if best.run.tilt.stands else ALREADY_MOVING
        quantities = [*all_failed(QUANTITIES[:2], why), quantities[-1]]
    angle, static, kinetic = quantities
    if not track.physical:
        missing = "mm_per_px" if track.unit == "px" else "fps"
        why = f"pixels or frames only; camera.{missing} is needed"
        kinetic = failed("kinetic_friction", "1", f"the acceleration is known in {why}")
    doubts = _doubts(seen, best, row_noise, kinetic, static)
    free = (LOSES,) * bool(best.fit.by_name.get(LOSES))
    rivals = [*_one(best.fit).rivals(free), *_other_ways(ways)]
    found = tuple(
        q if q.quality == FAILED else q.doubt(vague(q), *doubts, *unless(rivals, q))
        for q in (angle, static, kinetic)
    )
    if (1 - noise.white) * noise.rho > 0.3:
        notes.append(
            f"successive frames err together (ρ = {noise.rho:.2f}); the standard"
            " deviations allow for it"
        )
    if len(best.run.time) < len(seen.run.time):
        met = float(track.time[begin + len(best.run.time) - 1])
        notes.append(
            f"the slide ends at {met:.4g} {track.time_unit}; what follows is not fitted"
        )
    onset = None
    if best.run.how != MOVING:
        since = of_own(best.fit.starts[0])["onset"]
        onset = (since + best.run.tilt.origin) / _clock(track)
    return Slide(found, onset, _curve(seen, best, sign), tuple(notes))


def _about(seen: Seen, best: Alone) -> tuple[Alone, Noise]:
    """The likeliest fit again, with the noise of the rows about it; of a block in
    motion, with a friction that changes along its way as usual."""
    run = best.run
    noise, factor = noise_about(best.fit)
    sd = factor[0] * best.prepared.sigma[0]
    if run.in_motion:
        wander = wander_of(run, float(np.ptp(run.time[run.moving])))
        usual = np.zeros(wander.shape[1])
        usual[1 : 1 + WAVES] = unstated_sd("friction-to-rest")
        run = replace(run, wander=(wander * usual)[:, 1:])
    return alone(run, noise, sd, best.fit), noise


def _losses(best: Alone) -> tuple[list[tuple[float, Fit]], Alone]:
    """Fits with their probabilities, for each loss of friction at the onset that is
    likely, and the likelier one of none and a free one. Seeds lose friction or not: the
    odds are even, and of a loss any order of magnitude is as likely."""
    loss, fit = best.fit.by_name.get(LOSES, 0.0), best.fit
    if best.run.how != LETS_GO or loss > CERTAIN_SDS * fit.sd(LOSES):
        return [(1.0, fit)], best
    none = best.losing(0.0, fit)

    def tried(losses: np.ndarray) -> list[tuple[float, Fit]]:
        width = math.log(losses[1] / losses[0]) / math.log(MOST_LOSS / LEAST_LOSS)
        found, near = [], none
        for one in losses:
            near = best.losing(float(one), near)
            found.append((ln_evidence(near) + math.log(width), near))
        return found

    coarse = np.geomspace(LEAST_LOSS, MOST_LOSS, LOSSES)
    ln = np.array([each for each, _ in tried(coarse)])
    near = np.flatnonzero(ln > ln.max() - UNLIKELY)
    low, high = coarse[max(near[0] - 1, 0)], coarse[min(near[-1] + 1, LOSSES - 1)]
    each = [(ln_evidence(none), none), *tried(np.geomspace(low, high, LOSSES))]
    share = np.exp([one - max(one for one, _ in each) for one, _ in each])
    share /= share.sum()
    kept = none if share[0] > 0.5 else fit
    found = [f for _, f in each]
    return list(zip(share.tolist(), found, strict=True)), replace(best, fit=kept)


def _mixed(seen: Seen, best: Alone, ones: list[tuple[float, Fit]]) -> list[Quantity]:
    """Means and sds of the quantities over some fits with their probabilities."""
    wanted = dict(QUANTITIES if best.run.how == LETS_GO else QUANTITIES[2:])
    noise = max(best.fit.problem.level_sd, 1e-3)
    looser = float(student.ppf(0.975, 2 / noise**2)) / INSIDE_SDS
    found = [
        (share, _one(one, looser).quantities(wanted, _shared(seen, one)))
        for share, one in ones
        if share > 1e-6
    ]
    out = []
    for name in wanted:
        each = [(share, q[name]) for share, q in found]
        value = sum(p * q.value for p, q in each)
        variance = sum(p * (q.sd**2 + (q.value - value) ** 2) for p, q in each)
        common = math.sqrt(sum(p * q.sd_common**2 for p, q in each))
        sd = math.sqrt(variance)
        out.append(replace(each[0][1], value=value, sd=sd, sd_common=common))
    return out


def _one(found: Fit, looser: float = 1.0) -> OneRecording:
    return OneRecording(found, OWN, partial(_values, found.problem.model), looser)


def _shared(seen: Seen, found: Fit) -> list[str]:
    """Parameters whose errors all slides of a session have in common."""
    known = {"scale", "air", "plate", *found.problem.effects}
    return [*seen.shared, *(n for n in found.problem.known_sd if n in known)]


def _values(model: Model, values: dict[str, float]) -> dict[str, float]:
    """The quantities from the parameters by name."""
    run, own = model.session.runs[0], np.array([values[name] for name in OWN])
    friction = run_motion(model, 0, own, values)[2]
    if run.how != LETS_GO:
        return {name: math.nan for name, _ in QUANTITIES[:2]} | {
            "kinetic_friction": friction
        }
    tilt = tilt_of(model, run, values, values)
    laws = laws_of(model, run, values["phase"], values)
    held = laws._replace(static_excess=0.0)
    angle = float(np.polynomial.polynomial.polyval(values["onset"], tilt))
    return {
        "slide_angle": math.degrees(angle),
        "static_friction": friction_at(values["onset"], tilt, held),
        "kinetic_friction": friction,
    }


def _other_ways(ways: list[Alone]) -> list[Rival]:
    """Other ways to move, with the odds of their evidence."""
    best, out = ways[0], []
    for other in ways[1:]:
        if other.run.how != best.run.how:
            kinetic = _one(other.fit).at["kinetic_friction"]
            shown = {name: math.nan for name, _ in QUANTITIES[:2]}
            odds = math.exp(min(other.ln_evidence - best.ln_evidence, 500.0))
            there = by_name(shown | {"kinetic_friction": kinetic})
            out.append(Rival(odds, WORDS[other.run.how], there))
    return out


def _curve(seen: Seen, found: Alone, sign: float) -> tuple[np.ndarray, np.ndarray]:
    """Times and places of the fit in the track's units."""
    place = (found.run.travel - found.left) / seen.unit
    return found.run.time / _clock(seen.track), sign * place


def _negative(kinetic: Quantity) -> str:
    if not kinetic.value < -2 * kinetic.sd:
        return ""
    return "negative kinetic friction: are angle, scale and times right?"


def _doubts(
    seen: Seen, best: Alone, row_noise: float, kinetic: Quantity, static: Quantity
) -> list[str]:
    """What a user can act on."""
    run, doubts = best.run, [_negative(kinetic)]
    onset = run.time[0] - run.tilt.origin
    if run.how != MOVING:
        onset = of_own(best.fit.starts[0])["onset"]
    before = int((run.time - run.tilt.origin < onset).sum())
    sliding = len(run.time) - before
    if run.how == LETS_GO and before < LEAST_REST - 1:
        doubts.append(ALREADY_MOVING)
    if sliding < LEAST_SLIDING // 2:
        doubts.append(f"only {sliding} frames of sliding")
    left = float(np.sqrt(np.mean(best.left**2)))
    if left > max(5 * seen.unit * row_noise, 0.02 * float(np.ptp(run.travel))):
        doubts.append(
            "the travel is not that of one block under constant friction (off by"
            f" {left / seen.unit:.2g} {seen.track.unit})"
        )
    if kinetic.value > static.value + 2 * math.hypot(kinetic.sd, static.sd):
        doubts.append("kinetic friction above static friction")
    return doubts
