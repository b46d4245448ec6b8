"""Slides, from recordings to a finding."""

from dataclasses import replace

import numpy as np

from calibrate.diagnose.effects.slide import EFFECTS
from calibrate.diagnose.finding import Finding, Parameter, finding_of
from calibrate.diagnose.locate import Sector, locate
from calibrate.diagnose.name import name
from calibrate.diagnose.problem import Fit, fit
from calibrate.diagnose.slide.law import law_of
from calibrate.diagnose.slide.model import Model, candidates
from calibrate.diagnose.slide.problem import Prepared, begin, prepare, problem_of
from calibrate.diagnose.slide.readings import grid_of
from calibrate.diagnose.slide.scan import vibration
from calibrate.diagnose.slide.session import assemble
from calibrate.diagnose.slide.twins import honest
from calibrate.diagnose.slide.windows import windows_of

STEP = "stepped-tilt"
CERTAIN_P = 1e-9  # of stairs that a column or a list of readings shows by itself
STEP_SD = 0.005  # relative, of a stair's height


def diagnose_slide(recordings, rng: np.random.Generator) -> Finding:
    """Finding of one pair's slides (calibrate.twin.slides.SeenSlide); ValueError where none can be used."""
    prepared = prepare(assemble(recordings))
    model = Model(prepared.session, 0.0, candidates(prepared.session))
    found = vibration(prepared)
    if found:
        effects = model.effects | {"plate-vibration": EFFECTS["plate-vibration"]}
        model = replace(model, effects=effects, omega=found.omega, phases=found.phases)
    steps = stairs_of(prepared)
    base = fitted(prepared, model)
    if steps and any(r.tilt.stair_deg for r in prepared.session.runs):
        climbing = fitted(prepared, replace(model, stairs=True))
        base = min(base, climbing, key=lambda f: f.chi2)
    where = locate(base, windows_of(base), rng)
    verdict = honest(base, name(base, where, rng))
    law = law_of(base) if verdict.verdict == "unknown" else None
    finding = finding_of(base, where, verdict, law=law, notes=prepared.session.notes)
    return with_steps(finding, steps) if steps else finding


def fitted(prepared: Prepared, model: Model) -> Fit:
    """The baseline, fitted."""
    model, starts = begin(prepared, model)
    return fit(problem_of(prepared, model, starts))


def stairs_of(prepared: Prepared) -> list[float]:
    """Stair heights [deg] that columns climb in, or on which readings lie; empty unless most of them do."""
    runs, reads = prepared.session.runs, prepared.session.reads
    seen = [r.tilt.stair_deg for r in runs if r.tilt.stair_deg]
    if seen and 2 * len(seen) > len(runs):
        return seen
    grid = grid_of([r.angles for r in reads])
    return [grid] if grid else []


def with_steps(finding: Finding, steps: list[float]) -> Finding:
    """The finding with the stairs named: they are seen, not inferred; what else was found stays beside them if it has a name."""
    height = float(np.median(steps))
    spread = float(np.std(steps)) / np.sqrt(len(steps)) if len(steps) > 1 else 0.0
    half = 1.96 * max(spread, STEP_SD * height)
    step = Parameter("deg", height, height - half, height + half)
    others = finding.names if finding.verdict == "name" else ()
    notes = finding.notes
    if finding.verdict in ("class", "unknown"):
        what = " or ".join(finding.names) or "without a name"
        notes = (*notes, f"beside the steps of the tilt something else is open: {what}")
    sectors = (Sector("measurement", 1.0, CERTAIN_P), *(s for s in finding.sectors if s.name != "measurement"))
    return replace(
        finding, alarm=True, p_global=min(finding.p_global, CERTAIN_P), verdict="name", names=(STEP, *others), notes=notes,
        sectors=sectors if not others else finding.sectors, parameters={STEP: step} | (finding.parameters if others else {}),
        next_record=EFFECTS[STEP].separating if not others else finding.next_record,
    )  # fmt: skip
