"""Slides, from recordings to a finding."""

from dataclasses import replace

import numpy as np

from calibrate.diagnose.finding import Finding, Parameter, finding_of
from calibrate.diagnose.locate import Sector, locate
from calibrate.diagnose.name import Verdict, name
from calibrate.diagnose.problem import Fit, fit
from calibrate.diagnose.slide.law import law_of
from calibrate.diagnose.slide.model import Model, candidates
from calibrate.diagnose.slide.problem import Prepared, begin, prepare, problem_of
from calibrate.diagnose.slide.readings import grid_of
from calibrate.diagnose.slide.scan import vibration
from calibrate.diagnose.slide.session import assemble
from calibrate.diagnose.slide.twins import honest
from calibrate.diagnose.slide.windows import windows_of

STEP, SHAKEN = "stepped-tilt", "plate-vibration"
GENTLE_M_S2 = 0.03  # a vibration of less than the runs' friction scatters by
CERTAIN_P = 1e-9  # of stairs that a column or a list of readings shows by itself
STEP_SD = 0.005  # relative, of a stair's height


def diagnose_slide(recordings, rng: np.random.Generator) -> Finding:
    """Finding of one pair's slides (calibrate.twin.slides.SeenSlide); ValueError where none can be used."""
    prepared = prepare(assemble(recordings))
    model = Model(prepared.session, 0.0, candidates(prepared.session))
    steps = stairs_of(prepared)
    base = fitted(prepared, model)
    if steps and any(r.tilt.stair_deg for r in prepared.session.runs):
        climbing = fitted(prepared, replace(model, stairs=True))
        base = min(base, climbing, key=lambda f: f.chi2)
    where = locate(base, windows_of(base), rng)
    shaken = vibration(prepared)
    alone = shaken is not None and shaken.amplitude > GENTLE_M_S2  # it upsets the onset: nothing else can be told beside it
    verdict = Verdict("none", (), shaken.p, (), float("nan"), None) if alone else honest(base, name(base, where, rng))
    law = law_of(base) if verdict.verdict == "unknown" else None
    finding = finding_of(base, where, verdict, law=law, notes=prepared.session.notes)
    if steps:
        finding = with_seen(finding, STEP, _height(steps), "measurement", CERTAIN_P)
    if shaken:
        half = 1.96 * shaken.sd
        size = Parameter("m/s^2", shaken.amplitude, shaken.amplitude - half, shaken.amplitude + half)
        heard = replace(finding, notes=(*finding.notes, f"the travel ripples at {shaken.hertz:.3g} Hz in all runs"))
        finding = with_seen(heard, SHAKEN, size, "sliding", shaken.p)
    return finding


def fitted(prepared: Prepared, model: Model) -> Fit:
    """The baseline, fitted; candidates that do not find their way from there begin at onsets free of it."""
    model, starts = begin(prepared, model)
    base = fit(problem_of(prepared, model, starts))
    if model.stairs or not prepared.session.runs:
        return base
    return replace(base, problem=replace(base.problem, starts=begin(prepared, model, jump=True)[1], restart=True))


def stairs_of(prepared: Prepared) -> list[float]:
    """Stair heights [deg] that columns climb in, or on which readings lie; empty unless most of them do."""
    runs, reads = prepared.session.runs, prepared.session.reads
    seen = [r.tilt.stair_deg for r in runs if r.tilt.stair_deg]
    if seen and 2 * len(seen) > len(runs):
        return seen
    grid = grid_of([r.angles for r in reads])
    return [grid] if grid else []


def _height(steps: list[float]) -> Parameter:
    height = float(np.median(steps))
    spread = float(np.std(steps)) / np.sqrt(len(steps)) if len(steps) > 1 else 0.0
    half = 1.96 * max(spread, STEP_SD * height)
    return Parameter("deg", height, height - half, height + half)


def with_seen(finding: Finding, effect: str, size: Parameter, sector: str, p: float) -> Finding:
    """The finding with an effect that is seen, not inferred; what else was found stays beside it if it has a name."""
    others = finding.names if finding.verdict == "name" else ()
    notes = finding.notes
    if finding.verdict in ("class", "unknown"):
        notes = (*notes, f"beside {effect} something else is open: {' or '.join(finding.names) or 'without a name'}")
    sectors = (Sector(sector, 1.0, p), *(s for s in finding.sectors if s.name != sector))
    return replace(
        finding, alarm=True, p_global=min(finding.p_global, p), verdict="name", names=(effect, *others), notes=notes, law=None,
        sectors=finding.sectors if others else sectors, parameters={effect: size} | (finding.parameters if others else {}),
        next_record=None, held_out=finding.held_out if others else None,
    )  # fmt: skip
