"""Slides, from recordings to a finding: the alternatives of their baseline, and what is asked of them."""

from dataclasses import replace

import numpy as np

from diagnose.effects.effect import separating_recordings
from diagnose.effects.slide import EFFECTS
from diagnose.effects.slide.plate import SHAKEN, STEPPED
from diagnose.effects.slide.reading import RATE
from diagnose.engine.conditions import Condition, Contact, conditions_of, with_conditions
from diagnose.engine.posterior import LISTED_ODDS, Alternative, Explanation, of_p_value
from diagnose.engine.problem import Fit
from diagnose.finding import Curve, Finding, Question, answer
from diagnose.rigs.slide.model import Model, predict
from diagnose.rigs.slide.problem import Prepared, begin, begin_with_jump, effects_of, prepare, problem_of
from diagnose.rigs.slide.session import COARSE_DEG, RESOLUTIONS_DEG, Session, assemble
from diagnose.rigs.slide.unlisted import law_of, windows_of
from diagnose.rigs.slide.vibration import Vibration, vibration

TURNS, STANDS = 0.7, 0.3  # prior odds: the block goes with its plate; the weight turns about a plate that stands still
ODD_GRID = 0.01  # that somebody reads to a grid that is no usual resolution
STILL = "the block moves as on a plate that stands still under a weight that turns: so it is simulated now and then"
FRICTION = Contact("static_friction", "friction", 0.05, 1.0, "onset", "static friction")


def diagnose_slide(recordings, rng: np.random.Generator) -> Finding:
    """Finding of one pair's slides (twin.slides.SeenSlide); ValueError where none can be used."""
    prepared = prepare(assemble(recordings))
    session = prepared.session
    sessions = [*(r.session for r in session.runs), *(r.session for r in session.reads)]
    follows, said = conditions_of(list(session.stated), sessions)
    follows = (*follows, *_rates(session))
    heard = vibration(prepared)
    notes = (*session.notes, *said)
    notes += (f"the travel ripples at {heard.hertz:.3g} Hz in all runs",) if heard else ()
    asked = Question(
        "slide", alternatives(prepared, follows, heard), windows_of, curves_of,
        {FRICTION.name: static_friction}, law_of, lambda names: separating_recordings(EFFECTS, names) if names else RATE, notes,
    )  # fmt: skip
    return answer(asked, rng)


def alternatives(prepared: Prepared, follows: tuple[Condition, ...], heard: Vibration | None) -> tuple[Alternative, ...]:
    """The plate goes with the block or stands still (where no hinge is stated); it climbs evenly or in stairs; it shakes audibly."""
    session = prepared.session
    model = Model(session, 0.0, effects_of(session))
    known = not session.runs or any(run.from_hinge for run in session.runs)
    out = [Alternative(_problem(prepared, model, follows), 1.0 if known else TURNS)]
    if not known:
        out.append(Alternative(_problem(prepared, replace(model, turning=0.0), follows), STANDS, STILL))
    for height in stairs_of(session):
        stepped = _problem(prepared, replace(model, stair_deg=height), follows)
        size = {STEPPED.name: (STEPPED.unit, height, 0.005 * height)}
        out.append(Alternative(stepped, LISTED_ODDS, named=(STEPPED.name,), sector=STEPPED.sector, sizes=size))
    if heard:
        size = {SHAKEN.name: (SHAKEN.unit, heard.amplitude, heard.sd)}
        others = {n: e for n, e in model.effects.items() if SHAKEN.name not in (n, e.group)}
        shaken = _problem(prepared, replace(model, effects=others, shaking=(heard.amplitude, heard.hertz)), follows)
        out.append(Alternative(
            shaken, LISTED_ODDS, named=(SHAKEN.name,), sector=SHAKEN.sector, sizes=size, ln_likelihood=of_p_value(heard.p), p=heard.p
        ))  # fmt: skip
    odd = session.reads and max(r.grid_deg for r in session.reads) not in (*RESOLUTIONS_DEG, 0.01)
    return tuple(replace(a, odds=a.odds * (ODD_GRID if odd and STEPPED.name not in a.named else 1.0)) for a in out)


def stairs_of(session: Session) -> tuple[float, ...]:
    """Heights [deg] of stairs that the plate may climb in: the grids on which columns or readings lie."""
    found = [r.tilt.grid_deg for r in session.runs if r.tilt.grid_deg]
    seen = [float(np.median(found))] if 2 * len(found) > len(session.runs) else []
    read = {r.grid_deg for r in session.reads if r.grid_deg >= COARSE_DEG}
    return tuple([*seen, *(g for g in sorted(read) if not any(abs(g / s - 1) < 0.1 for s in seen))])


def _problem(prepared: Prepared, model: Model, follows: tuple[Condition, ...]):
    """With further points at which a block that loses friction at once may begin."""
    model, starts = begin(prepared, model)
    problem = problem_of(prepared, model, starts)
    if not model.stair_deg and prepared.session.runs:
        jumping, lost = begin_with_jump(prepared, model, starts)
        points = tuple((jumping, _at(problem, n, lost)) for n, e in model.effects.items() if e.rest and e.bent)
        problem = replace(problem, elsewhere=points)
    return with_conditions(problem, FRICTION, follows)


def _at(problem, name: str, value: float) -> np.ndarray:
    """Globals (G,) at nil but for this one; further parameters of its shape at their low ends, as good as a jump."""
    values = {n: problem.effects[n].low for n in problem.columns_of(name)} | {name: value}
    return np.array([values.get(n, 0.0) for n in problem.names])


def _rates(session: Session) -> tuple[Condition, ...]:
    """The tilt rate, which a friction that ages with time at rest follows: seen, but not why."""
    rates = np.array([*(r.tilt.rate_deg_s for r in session.runs), *(r.rate_deg_s for r in session.reads)])
    if not np.isfinite(rates).all() or np.ptp(np.log(rates)) < 0.1:
        return ()
    z = np.log(rates) - np.log(rates).mean()
    spread = float(z.std())
    return (Condition("ln_tilt_rate", z[:, None] / spread, spread, unlisted=True),)


def static_friction(e: Explanation) -> tuple[float, float]:
    """Of the pair, at rest."""
    at, model = e.fit.by_name, e.fit.problem.model
    more = sum(effect.rest(at[n]) for n, effect in model.effects.items() if effect.rest and n in e.names)
    return model.friction + at["friction"] + more, e.fit.sd("friction")


def curves_of(base: Fit, model: Fit) -> tuple[Curve, ...]:
    """Travel of each run over the time since its first row."""
    out = []
    for r, run in enumerate(base.problem.model.session.runs):
        left = [run.travel - predict(of.problem.model, r, of.starts[r], of.by_name)[:-1] for of in (base, model)]
        out.append(Curve(run.recording, "travel", "mm", "t_s", run.time - run.time[0], run.travel, *left))
    return tuple(out)
