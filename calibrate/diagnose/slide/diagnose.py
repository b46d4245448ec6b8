"""Slides, from recordings to a finding."""

from dataclasses import dataclass, replace

import numpy as np

from calibrate.diagnose.decide import LN_BF_BASELINE, LN_BF_RIVAL, Verdict
from calibrate.diagnose.effects.slide.stribeck import SPEED
from calibrate.diagnose.finding import Finding, Parameter, finding_of
from calibrate.diagnose.locate import Location, Sector, locate
from calibrate.diagnose.name import name
from calibrate.diagnose.problem import Fit, fit
from calibrate.diagnose.scores import ln_evidence
from calibrate.diagnose.slide.law import law_of
from calibrate.diagnose.slide.model import RIVAL, Model, candidates
from calibrate.diagnose.slide.problem import Prepared, begin, begin_with_jump, prepare, problem_of
from calibrate.diagnose.slide.readings import SPACING_SD, grid_of
from calibrate.diagnose.slide.scan import vibration
from calibrate.diagnose.slide.session import assemble
from calibrate.diagnose.slide.twins import honest
from calibrate.diagnose.slide.windows import windows_of

STEP, SHAKEN = "stepped-tilt", "plate-vibration"
TURNING_ALIKE = "viscous-sliding"  # what a plate's turning looks like at one rate
GENTLE_M_S2 = 0.03  # a vibration of less than the runs' friction scatters by
CERTAIN_P = 1e-9  # of stairs that a column or a list of readings shows by itself
FADES = "friction that fades over the first few mm/s, by less, fits as well: a tenth of the tilt rate and more frames would tell"
STILL = "the block moves as on a plate that stands still under a weight that turns: so it is simulated now and then"
HINGE = "the way from the plate's hinge to the block (start_mm), and the same slide at three times the tilt rate"
UNHEARD = "no ripple is heard: the vibration is told from how early and fast the block lets go; raised by hand it should not"


def diagnose_slide(recordings, rng: np.random.Generator) -> Finding:
    """Finding of one pair's slides (calibrate.twin.slides.SeenSlide); ValueError where none can be used."""
    prepared = prepare(assemble(recordings))
    model = Model(prepared.session, 0.0, candidates(prepared.session))
    steps, shaken = stairs_of(prepared), vibration(prepared)
    alone = shaken if shaken and shaken.amplitude > GENTLE_M_S2 else None  # it upsets the onset: nothing else can be told
    told = _told(fitted(prepared, model, steps is not None), rng)
    if told.verdict.verdict != "none" and not alone:
        told = _or_still(prepared, told, steps is not None, rng)
    verdict = Verdict("none", (), alone.p, (), float("nan"), None) if alone else told.verdict
    law = law_of(_without_rival(told)) if verdict.verdict == "unknown" else None
    notes = prepared.session.notes + ((STILL,) if not told.base.problem.model.turning else ())
    notes += (UNHEARD,) if SHAKEN in verdict.names and not shaken else ()
    notes += (FADES,) if {"kinetic-friction", "stribeck"} <= set(verdict.names) else ()
    finding = finding_of(told.base, told.where, verdict, law=law, notes=notes)
    if steps:
        finding = with_seen(finding, STEP, steps, "measurement", CERTAIN_P)
    if shaken:
        half = 1.96 * shaken.sd
        size = Parameter("m/s^2", shaken.amplitude, shaken.amplitude - half, shaken.amplitude + half)
        heard = replace(finding, notes=(*finding.notes, f"the travel ripples at {shaken.hertz:.3g} Hz in all runs"))
        finding = with_seen(heard, SHAKEN, size, "sliding", shaken.p)
    return finding


@dataclass(frozen=True, eq=False)
class Told:
    """A baseline, where it misses, the verdict, and ln of the evidence of what that verdict takes for true."""

    base: Fit
    where: Location
    verdict: Verdict
    ln_evidence: float


def _told(base: Fit, rng: np.random.Generator) -> Told:
    where = locate(base, windows_of(base), rng)
    verdict = honest(base, name(base, where, rng))
    best = max((c.ln_bayes for c in verdict.candidates), default=0.0)
    return Told(base, where, verdict, ln_evidence(base.reduced, base.prior_sd) + max(best, 0.0))


def _or_still(prepared: Prepared, told: Told, steps: bool, rng: np.random.Generator) -> Told:
    """Where no hinge is stated: the same on a plate that stands still, if that misses nothing, fits clearly better, or knows a
    name for what else is unknown.

    At one rate the plate's turning does what friction that grows with speed does, and costs no parameter: where a plate that
    stands still has more evidence for that alone, or spares a name that friction, what either names is a class.
    """
    runs, base = prepared.session.runs, told.base
    if not runs or any(run.from_hinge for run in runs):
        return told
    other = fitted(prepared, replace(base.problem.model, turning=0.0), steps)
    better = ln_evidence(other.reduced, other.prior_sd) > ln_evidence(base.reduced, base.prior_sd)
    if not better and told.verdict.verdict != "unknown":
        return _unless_spared(told, other)
    still = _told(other, rng)
    more = still.ln_evidence - told.ln_evidence
    if still.verdict.verdict == "none" or (more > LN_BF_BASELINE and _best(still).chi2 < _best(told).chi2 - 2 * LN_BF_RIVAL):
        return still
    if told.verdict.verdict == "unknown" != still.verdict.verdict and more > -LN_BF_RIVAL:
        return still
    if told.verdict.verdict != "name" or more < -LN_BF_RIVAL or set(told.verdict.names) == set(still.verdict.names):
        return told
    names = tuple(dict.fromkeys((*told.verdict.names, *still.verdict.names)))
    return replace(told, verdict=replace(told.verdict, verdict="class", names=names, next_record=HINGE))


def _unless_spared(told: Told, other: Fit) -> Told:
    """A class where the rest of a name needs no friction that grows with speed on a plate that stands still, `other`."""
    names = told.verdict.names
    if told.verdict.verdict != "name" or TURNING_ALIKE not in names:
        return told
    rest = fit(other.problem, free=tuple(n for n in names if n != TURNING_ALIKE), start=other)
    if ln_evidence(rest.reduced, rest.prior_sd) < told.ln_evidence - LN_BF_RIVAL:
        return told
    return replace(told, verdict=replace(told.verdict, verdict="class", next_record=HINGE))


def _most_evident(told: Told) -> tuple[str, ...]:
    """Of all that was fitted."""
    return max(told.verdict.candidates, key=lambda c: c.ln_bayes).names


def _best(told: Told) -> Fit:
    return fit(told.base.problem, free=_most_evident(told), start=told.base)


def _without_rival(told: Told) -> Fit:
    """What a law without a name stands beside: the baseline with the effects that the rival outside the library needs too."""
    names = _most_evident(told)
    known = tuple(n for n in names if n != RIVAL.name)
    return fit(told.base.problem, free=known, start=told.base) if known and known != names else told.base


def fitted(prepared: Prepared, model: Model, steps: bool = False) -> Fit:
    """The baseline, fitted; with `steps` that of a plate that climbs in its column's stairs where that does better."""
    base = _fitted(prepared, replace(model, stairs=False))
    if not steps or not any(run.tilt.stair_deg for run in prepared.session.runs):
        return base
    return min(base, _fitted(prepared, replace(model, stairs=True)), key=lambda f: f.chi2)


def _fitted(prepared: Prepared, model: Model) -> Fit:
    """Candidates that do not find their way from the baseline begin elsewhere too."""
    model, starts = begin(prepared, model)
    base = fit(problem_of(prepared, model, starts))
    if model.stairs or not prepared.session.runs:
        return base
    jumping, lost = begin_with_jump(prepared, model, starts)
    fading = {"stribeck": lost, SPEED.name: SPEED.low}  # as good as a jump; other speeds are downhill from it
    points = tuple((jumping, _at(base, values)) for values in ({"kinetic-friction": lost}, fading))
    return replace(base, problem=replace(base.problem, elsewhere=points))


def _at(base: Fit, values: dict[str, float]) -> np.ndarray:
    """Globals (G,) at nil but for these."""
    return np.array([values.get(n, 0.0) for n in base.names])


def stairs_of(prepared: Prepared) -> Parameter | None:
    """Height [deg] of stairs that columns climb in, or on which readings lie; None unless most of them do."""
    runs, reads = prepared.session.runs, prepared.session.reads
    seen = [r.tilt.stair_deg for r in runs if r.tilt.stair_deg]
    if not seen or 2 * len(seen) <= len(runs):
        grid = grid_of([r.angles for r in reads])
        return Parameter("deg", *grid) if grid else None
    height = float(np.median(seen))
    spread = float(np.std(seen)) / np.sqrt(len(seen)) if len(seen) > 1 else 0.0
    half = 1.96 * max(spread, SPACING_SD * height)
    return Parameter("deg", height, height - half, height + half)


def with_seen(finding: Finding, effect: str, size: Parameter, sector: str, p: float) -> Finding:
    """The finding with an effect that is seen, not inferred; what else was found stays beside it if it has a name."""
    others = tuple(n for n in finding.names if n != effect) if finding.verdict == "name" else ()
    notes = finding.notes
    if finding.verdict in ("class", "unknown"):
        notes = (*notes, f"beside {effect} something else is open: {' or '.join(finding.names) or 'without a name'}")
    sectors = (Sector(sector, 1.0, p), *(s for s in finding.sectors if s.name != sector))
    return replace(
        finding, alarm=True, p_global=min(finding.p_global, p), verdict="name", names=(effect, *others), notes=notes, law=None,
        sectors=finding.sectors if others else sectors, parameters=(finding.parameters if others else {}) | {effect: size},
        next_record=None, held_out=finding.held_out if others else None,
    )  # fmt: skip
