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
from benchtwin.bench.language import tr
from benchtwin.bench.priors import stated_sd, unstated_sd
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
from benchtwin.rigs.slide.read import FRAME_S, seen_slide, without_strays
from benchtwin.rigs.slide.session import (
    ANGLE_MISSING,
    LEAST_REST,
    LEAST_SLIDING,
    LETS_GO,
    MOVING,
    SET_OFF,
    WAVES,
    AirDrag,
    Run,
    Session,
    has_few_rows,
    rows_of,
    run_of,
    with_rest,
)
from benchtwin.rigs.slide.starts import start_of
from benchtwin.vision.measurement import (
    FAILED,
    MeasurementError,
    Quantity,
    all_failed,
    failed,
    vague,
)
from benchtwin.vision.motion.least_squares import all_stated, variance_factor
from benchtwin.vision.motion.track import Track
from benchtwin.vision.recording import Recording

LEVELS = 3  # times the sd of few rows is estimated
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
    used = without_strays(track)
    few = has_few_rows(recording.evidence == "gates.csv", len(used))
    try:
        return _measured(_evidence(used, recording, few))
    except ValueError as error:
        onset = all_failed(QUANTITIES[:2], tr(FEW) if few else str(error))
        return Slide((*onset, failed(*QUANTITIES[2], str(error))), None, None)


@dataclass(frozen=True, eq=False)
class Evidence:
    """A track as it is fitted. unit: millimetres of the fit in a unit of its lengths;
    notes: on what is stated."""

    track: Track
    run: Run
    unit: float
    notes: list[str]

    @property
    def clock(self) -> float:
        """Seconds in a unit of the track's time."""
        return 1.0 if self.track.timed else FRAME_S

    @property
    def shared(self) -> tuple[str, ...]:
        """Names of the run's parameters whose errors are the same in all slides of a
        session."""
        return () if self.run.tilt.sensor else ("level", "rate")


def _evidence(track: Track, recording: Recording, few: bool) -> Evidence:
    if few:
        track.need_physical(recording)
    run, unit = with_rest(run_of(seen_slide(track, recording))), 1.0
    rate, start = recording.slide.tilt_rate_deg_s, recording.slide.start_deg
    if rate and not run.tilt.sensor:
        if not track.timed:
            raise MeasurementError(
                tr("{}: {} together with camera.fps", recording.toml, tr(ANGLE_MISSING))
            )
        if start is None:
            raise MeasurementError(f"{recording.toml}: {tr(START_MISSING)}")
    if not track.physical:
        unit = _first_unit(run)
        run = replace(run, air=AirDrag(), scale_sd=FREE_SCALE_SD)
        run = replace(run, travel=unit * run.travel)
    return Evidence(track, run, unit, _said(run, rate, start))


def _said(run: Run, rate: float | None, start: float | None) -> list[str]:
    """The plate's angle, where it is as stated."""
    if run.tilt.sensor:
        return []
    if not rate:
        said = tr("the plate is taken to stand at {:g}°", start)
        said += f", ± {stated_sd('level-plate'):g}°"
        return [said + tr(": no tilt_rate_deg_s is stated") * (rate is None)]
    sd = stated_sd("level-plate" if run.gates else "start-angle")
    return [
        tr(
            "the plate's angle is as stated: {:g}° at t = 0, ± {:g}°, and {:g} °/s, ±"
            " {:g} %",
            start,
            sd,
            rate,
            100 * stated_sd("tilt-rate"),
        )
    ]


def _first_unit(run: Run) -> float:
    """Millimetres in a unit of the travel, from the pull of a plate that is raised."""
    if run.tilt.stands:
        return USUAL_WAY_MM / float(np.ptp(run.travel))
    alone = Model(Session((run,), (), (), ()), 0.0)
    stretch = start_of(alone, 0, np.ones(len(run.time)), jump=True, free=True).stretch
    return 1 / max(stretch, 1e-6 * float(np.ptp(run.travel)))


def _measured(seen: Evidence) -> Slide:
    if seen.run.few:
        return _of_few(seen)
    hows = [MOVING, SET_OFF if seen.run.tilt.stands else LETS_GO]
    return _of_track(seen, likeliest(seen.run, hows))


def _of_few(seen: Evidence) -> Slide:
    track, run = seen.track, replace(seen.run, how=MOVING)
    run = rows_of(run, np.arange(len(run.time)) >= run.rest)
    stated, freedom = all_stated(track.sd), len(run.time) - 3
    level = float(np.median(track.sd)) if stated else FEW_SD_MM
    near = None
    for _ in range(1 if stated else LEVELS):
        found = alone(run, WHITE, level * run.weight, near)
        near, misfit = found.fit, _misfit(found, level * run.weight)
        level *= math.sqrt(misfit / freedom)
    factor, doubt = variance_factor(misfit, freedom, stated)
    one = _one(found.fit, math.sqrt(factor))
    (kinetic,) = one.quantities(dict(QUANTITIES[2:]), _shared(seen, one.fit)).values()
    kinetic = kinetic.doubt(_negative(kinetic), vague(kinetic), doubt)
    onset = all_failed(QUANTITIES[:2], tr(FEW))
    return Slide((*onset, kinetic), None, _curve(seen, found), tuple(seen.notes))


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


def _of_track(seen: Evidence, ways: list[Alone]) -> Slide:
    """ways: in which the block may move, likeliest first."""
    track, notes = seen.track, [*seen.notes]
    best, noise = _about(ways[0])
    ones, best = _losses(best)
    quantities = _mixed(seen, best, ones)
    if best.run.how != LETS_GO:
        why = tr(STANDS) if best.run.tilt.stands else tr(ALREADY_MOVING)
        quantities = [*all_failed(QUANTITIES[:2], why), quantities[-1]]
    angle, static, kinetic = quantities
    if not track.physical:
        missing = "mm_per_px" if track.unit == "px" else "fps"
        why = tr("pixels or frames only; camera.{} is needed", missing)
        kinetic = failed(
            "kinetic_friction", "1", tr("the acceleration is known in {}", why)
        )
    doubts = _doubts(seen, best, kinetic, static)
    free = (LOSES,) * bool(best.fit.by_name.get(LOSES))
    rivals = [*_one(best.fit).rivals(free), *_other_ways(ways)]
    found = tuple(
        q if q.quality == FAILED else q.doubt(vague(q), *doubts, *unless(rivals, q))
        for q in (angle, static, kinetic)
    )
    if (1 - noise.white) * noise.rho > 0.3:
        notes.append(
            tr(
                "successive frames err together (ρ = {:.2f}); the standard deviations"
                " allow for it",
                noise.rho,
            )
        )
    if len(best.run.time) < len(seen.run.time):
        met = float(best.run.time[-1]) / seen.clock
        notes.append(
            tr(
                "the slide ends at {:.4g} {}; what follows is not fitted",
                met,
                track.time_unit,
            )
        )
    onset = None
    if best.run.how != MOVING:
        since = of_own(best.fit.starts[0])["onset"]
        onset = (since + best.run.tilt.origin) / seen.clock
    return Slide(found, onset, _curve(seen, best), tuple(notes))


def _about(best: Alone) -> tuple[Alone, Noise]:
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


def _mixed(
    seen: Evidence, best: Alone, ones: list[tuple[float, Fit]]
) -> list[Quantity]:
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


def _shared(seen: Evidence, found: Fit) -> list[str]:
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
            out.append(Rival(odds, tr(WORDS[other.run.how]), there))
    return out


def _curve(seen: Evidence, found: Alone) -> tuple[np.ndarray, np.ndarray]:
    """Times and places of the fit in the track's units."""
    place = (found.run.travel - found.left) / seen.unit
    return found.run.time / seen.clock, found.run.sign * place


def _negative(kinetic: Quantity) -> str:
    if not kinetic.value < -2 * kinetic.sd:
        return ""
    return tr("negative kinetic friction: are angle, scale and times right?")


def _doubts(
    seen: Evidence, best: Alone, kinetic: Quantity, static: Quantity
) -> list[str]:
    """What a user can act on."""
    run, doubts = best.run, [_negative(kinetic)]
    onset = run.time[0] - run.tilt.origin
    if run.how != MOVING:
        onset = of_own(best.fit.starts[0])["onset"]
    before = int((run.time - run.tilt.origin < onset).sum())
    sliding = len(run.time) - before
    if run.how == LETS_GO and before < LEAST_REST - 1:
        doubts.append(tr(ALREADY_MOVING))
    if sliding < LEAST_SLIDING // 2:
        doubts.append(tr("only {} frames of sliding", sliding))
    left, noise = float(np.sqrt(np.mean(best.left**2))), difference_noise(run.travel, 2)
    if left > max(5 * noise, 0.02 * float(np.ptp(run.travel))):
        doubts.append(
            tr(
                "the travel is not that of one block under constant friction (off by"
                " {:.2g} {})",
                left / seen.unit,
                seen.track.unit,
            )
        )
    if kinetic.value > static.value + 2 * math.hypot(kinetic.sd, static.sd):
        doubts.append(tr("kinetic friction above static friction"))
    return doubts
