"""Slides, from recordings to a finding: alternatives of the baseline."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.bench.resolution import STEPS
from benchtwin.infer.conditions import (
    Contact,
    condition,
    conditions_of,
)
from benchtwin.infer.effect import Effect, separating_recordings
from benchtwin.infer.evidence import SCATTER_SIZES
from benchtwin.infer.explanation import (
    Alternative,
    Explanation,
    ln_bayes_bound,
)
from benchtwin.infer.finding import Curve, Finding
from benchtwin.infer.inference import finding_of
from benchtwin.infer.posterior import LISTED_ODDS
from benchtwin.infer.problem import Fit, Problem, fit, ln_evidence
from benchtwin.infer.task import DiagnosisTask
from benchtwin.rigs.slide.effects import EFFECTS
from benchtwin.rigs.slide.effects.load_and_plate import SHAKEN, STEPPED
from benchtwin.rigs.slide.effects.tilt_reading import RATE
from benchtwin.rigs.slide.model import Model, predict
from benchtwin.rigs.slide.problem import (
    RUN_SD,
    Prepared,
    effects_of,
    prepare,
    with_scatter,
    with_starts,
)
from benchtwin.rigs.slide.session import (
    COARSE_DEG,
    FINEST_DEG,
    Read,
    Run,
    Session,
    assemble,
    lets_go,
)
from benchtwin.rigs.slide.unlisted import law_of, windows_of
from benchtwin.rigs.slide.vibration import Vibration, vibration

# Prior odds: the plate turns with the block, or a fixed plate under a rotating gravity
# vector.
ROTATING_PLATE_ODDS, FIXED_PLATE_ODDS = 0.7, 0.3
UNUSUAL_GRID_ODDS = 0.01  # that somebody reads angles to a grid of unusual resolution
FIXED_PLATE_NOTE = (
    "the block moves as on a fixed plate under a rotating gravity vector, as some"
    " simulations do"
)
FRICTION = Contact("static_friction", "friction", 1.0, "onset")
SLIDING = Contact("kinetic_friction", "friction", 1.0, "sliding")


def diagnose_slide(recordings, rng: np.random.Generator) -> Finding:
    """Finding of one pair's slides (read.SeenSlide); ValueError where none can
    be used."""
    prepared = prepare(assemble(recordings))
    session = prepared.session
    parts: list[Run | Read] = [*session.runs, *session.reads]
    names = tuple(one.recording for one in parts)
    conditions, said = conditions_of(
        names, list(session.stated), [one.session for one in parts]
    )
    rates = [r.tilt.rate_deg_s for r in session.runs] + [
        r.rate_deg_s for r in session.reads
    ]
    # friction may age at rest
    raised = np.isfinite(rates).all() and min(rates) > 0
    if raised and np.ptp(np.log(rates)) >= 0.1:
        raising = condition("ln_tilt_rate", names, np.log(rates).tolist())
        conditions += (replace(raising, unlisted=True),) if raising else ()
    heard = vibration(prepared)
    notes = (*session.notes, *said)
    notes += (
        (tr("the travel ripples at {:.3g} Hz in all runs", heard.hertz),)
        if heard
        else ()
    )
    asked = DiagnosisTask(
        "slide",
        alternatives(prepared, heard),
        windows_of,
        curves_of,
        {contact_of(session).name: friction_of},
        law_of,
        lambda names: separating_recordings(EFFECTS, names) if names else RATE,
        notes,
        follows=(contact_of(session), conditions),
    )
    return finding_of(asked, rng)


def alternatives(
    prepared: Prepared, heard: Vibration | None
) -> tuple[Alternative, ...]:
    """Rotating or fixed plate (no hinge stated), even or stepped tilt, vibration."""
    session = prepared.session
    model = Model(session, 0.0, effects_of(session))
    known = not lets_go(session) or any(run.from_hinge for run in session.runs)
    found: list[tuple[Model, dict[str, Any]]] = [
        (model, {"odds": 1.0 if known else ROTATING_PLATE_ODDS})
    ]
    if not known:
        about: dict[str, Any] = {"odds": FIXED_PLATE_ODDS, "note": tr(FIXED_PLATE_NOTE)}
        found.append((replace(model, turning=0.0), about))
    for height in stairs_of(session):
        size = {STEPPED.name: (STEPPED.unit, height, 0.005 * height)}
        found.append((replace(model, stair_deg=height), _named(STEPPED, size)))
    if heard:
        size = {SHAKEN.name: (SHAKEN.unit, heard.amplitude, heard.sd)}
        others = {
            n: e for n, e in model.effects.items() if SHAKEN.name not in (n, e.group)
        }
        shaken = replace(model, effects=others, shaking=(heard.amplitude, heard.hertz))
        told = {"ln_likelihood": ln_bayes_bound(heard.p), "p": heard.p}
        found.append((shaken, _named(SHAKEN, size) | told))
    odd = session.reads and max(r.grid_deg for r in session.reads) not in (
        *STEPS,
        FINEST_DEG,
    )
    out = []
    for own, about in found:
        problems = _scattering(prepared, own)
        usual = not odd or own.stair_deg
        odds = about["odds"] * (1.0 if usual else UNUSUAL_GRID_ODDS) / len(problems)
        out += [Alternative(p, **about | {"odds": odds}) for p in problems]
    return tuple(out)


def _named(effect: Effect, sizes: dict) -> dict[str, Any]:
    """Of a baseline that stands for an effect."""
    about = {"effects": (effect.name,), "sector": effect.sector, "sizes": sizes}
    return {"odds": LISTED_ODDS} | about


def stairs_of(session: Session) -> tuple[float, ...]:
    """Possible step heights [deg]: grids on which the tilt column or readings lie."""
    found = [r.tilt.grid_deg for r in session.runs if r.tilt.grid_deg]
    seen = [float(np.median(found))] if 2 * len(found) > len(session.runs) else []
    read = {r.grid_deg for r in session.reads if r.grid_deg >= COARSE_DEG}
    return tuple(
        [
            *seen,
            *(g for g in sorted(read) if not any(abs(g / s - 1) < 0.1 for s in seen)),
        ]
    )


def _scattering(prepared: Prepared, model: Model) -> tuple[Problem, ...]:
    """Without scatter of friction along each slide, and before it with that which the
    model leaves, where that is likelier: beside the scatter that another leaves, what
    it gets right would be nothing, and an effect that is missing may be all of it."""
    problem = with_starts(prepared, model)
    scattered = with_scatter(prepared, problem) if prepared.session.runs else prepared
    if scattered is prepared:
        return (problem,)
    other = with_starts(scattered, model)
    if not lets_go(prepared.session):  # what slides to rest always differs along it
        return (other,)
    likelier = ln_evidence(fit(other)) > ln_evidence(fit(problem))
    return (other, problem) if likelier else (problem,)


def contact_of(session: Session) -> Contact:
    """The friction that the slides tell."""
    return FRICTION if lets_go(session) or session.reads else SLIDING


def friction_of(e: Explanation) -> tuple[float, float]:
    """Of the pair, at rest where slides tell that; its sd by what the slides show of
    their scatter."""
    at, model = e.fit.by_name, e.fit.problem.model
    more = sum(
        effect.rest(at[n])
        for n, effect in model.effects.items()
        if effect.rest and n in e.names and lets_go(model.session)
    )
    ln_weight = e.table.by_scatter(e.names)[0]
    weight = np.exp(ln_weight - ln_weight.max())
    beyond = 0.0
    if len(weight) == len(SCATTER_SIZES):
        beyond = max(float(weight @ np.square(SCATTER_SIZES) / weight.sum()) - 1, 0.0)
    runs = max(len(model.session.runs), 1)
    sd = math.hypot(e.fit.sd("friction"), RUN_SD * math.sqrt(beyond / runs))
    return model.friction + at["friction"] + more, sd


def curves_of(base: Fit, model: Fit) -> tuple[Curve, ...]:
    """Travel of each run over the time since its first row."""
    out = []
    for r, run in enumerate(base.problem.model.session.runs):
        left = [
            run.travel - predict(of.problem.model, r, of.starts[r], of.by_name)[:-1]
            for of in (base, model)
        ]
        out.append(
            Curve(
                run.recording,
                "travel",
                "mm",
                "t_s",
                run.time - run.time[0],
                run.travel,
                *left,
            )
        )
    return tuple(out)
