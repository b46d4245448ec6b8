"""From impacts to a finding: e constant and the plate level, or not; with windows along speed and count."""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from calibrate.diagnose.decide import ALPHA, LN_BF_RIVAL, Verdict
from calibrate.diagnose.drop.bounce import bounces_of
from calibrate.diagnose.drop.impact_problem import elongation_of, predict, problem_of
from calibrate.diagnose.drop.impacts import Impacts
from calibrate.diagnose.drop.shape import Shape, shape_of
from calibrate.diagnose.drop.unnamed import law_of_impacts
from calibrate.diagnose.effects.drop import impact_damage, shape_conversion
from calibrate.diagnose.effects.drop.impact import FALLING, IMPACT_EFFECTS
from calibrate.diagnose.finding import Curve, Finding, finding_of, parameters_of
from calibrate.diagnose.law import Law
from calibrate.diagnose.locate import Location, Sector, Windows, locate
from calibrate.diagnose.name import name
from calibrate.diagnose.problem import Fit, fit

CLEARLY_WORSE = 10.0  # ln Bayes factor below which a law of e(v) is out: bounces scatter by no normal law
MORE_HEIGHTS = "the same seed from 30, 100 and 300 mm: each law of e differs in how it goes with the speed"
BINS = 4
SHAPE = 1 / 3  # of the chance of a false alarm; the rest is the laws', which many are asked for


def diagnose_impacts(impacts: Impacts, rng: np.random.Generator, *, alpha: float = ALPHA) -> tuple[Finding, Location] | None:
    """None where the impacts are too few to tell an effect from their scatter. Two questions, law and shape, share `alpha`
    (weighted Bonferroni: Genovese, Roeder, Wasserman 2006, Biometrika 93, 509)."""
    elongation = elongation_of(impacts) if len(impacts) else 0.0
    problem = problem_of(impacts, elongation)
    if problem is None:
        return None
    shape = shape_of(impacts, bounces_of(impacts, elongation), elongation)
    long = shape.p < SHAPE * alpha
    if long:  # as the contacts show it, not as stated
        problem = problem_of(impacts, shape.elongation) or problem
    base = fit(problem)
    where = locate(base, windows_of(base), rng)
    found = by_count(settled(name(base, where, rng, alpha=(1 - SHAPE) * alpha)))
    finding = finding_of(base, where, found, draw=curves_of)
    if set(found.names) & set(FALLING) and found.verdict == "class":
        finding = replace(finding, parameters=_falling_parameter(base, found))
    if found.verdict == "unknown":
        finding = with_law(finding, law_of_impacts(base))
    p = min(1.0, found.p_global / (1 - SHAPE), shape.p / SHAPE)
    finding = replace(finding, p_global=p, alarm=found.p_global < (1 - SHAPE) * alpha or long)
    return (_with_shape(finding, shape), _with_excess(where, shape)) if long else (finding, where)


def settled(found: Verdict) -> Verdict:
    """Laws of e that fall with speed stand as their class, its name first, with every member that is not clearly worse."""
    ours = set(found.names) & set(FALLING)
    if found.verdict not in ("name", "class") or not ours:
        return found
    alone = {c.names[0]: c.ln_bayes for c in found.candidates if len(c.names) == 1}
    top = max(alone.get(n, -np.inf) for n in FALLING)
    members = [n for n in FALLING if n in ours or n == FALLING[0] or alone.get(n, -np.inf) > top - CLEARLY_WORSE]
    others = tuple(n for n in found.names if n not in FALLING)
    verdict = "name" if found.verdict == "name" and (others or len(members) == 1) else "class"
    names = (*others, FALLING[0]) if others and verdict == "name" else (*members, *others)
    return replace(found, verdict=verdict, names=names, next_record=IMPACT_EFFECTS[FALLING[0]].separating)


def by_count(found: Verdict) -> Verdict:
    """Damage is named for certain where e follows the count rather than the speed, in whichever direction: a ball from one
    height has one speed for every count, and a law without a name that rises with speed does as well there."""
    damage = impact_damage.EFFECT
    if found.verdict != "name" or damage.name not in found.names:
        return found
    alone = {c.names[0]: c.ln_bayes for c in found.candidates if len(c.names) == 1}
    best = max((alone[n] for n in FALLING if n in alone), default=-np.inf)
    if best < alone.get(damage.name, np.inf) - LN_BF_RIVAL:
        return found
    return replace(found, verdict="class", next_record=f"{damage.separating}; drops from other heights")


def with_law(finding: Finding, law: Law | None) -> Finding:
    """An unknown with what can be said of it."""
    return finding if law is None else replace(finding, law=law.words, held_out=finding.held_out or law.held_out)


def _falling_parameter(base: Fit, found: Verdict):
    """e(0.5) − e(2 m/s) is the same question to every member: the class's own law answers for all."""
    others = tuple(n for n in found.names if n not in FALLING)
    model = fit(base.problem, free=(FALLING[0],), start=base)
    return parameters_of(model, (FALLING[0],)) if not others else {}


def _with_shape(finding: Finding, shape: Shape) -> Finding:
    """Shape conversion beside what else was found."""
    known = finding.verdict in ("none", "name")
    names = (*finding.names, *shape.names)
    return replace(
        finding, verdict="name" if known and shape.ln_bayes > 5 else "class" if known else finding.verdict,
        names=names if finding.verdict != "unknown" else finding.names,
        ln_bayes_baseline=float(np.nansum([finding.ln_bayes_baseline, shape.ln_bayes])),
        next_record=finding.next_record or (None if shape.ln_bayes > 5 else shape_conversion.EFFECT.separating),
        notes=(*finding.notes, f"contacts lie as far beside the centre as those of a seed of elongation {shape.elongation:.2g}"),
    )  # fmt: skip


def _with_excess(where: Location, shape: Shape) -> Location:
    """Scatter is what shape explains: it belongs to the impacts' sector as well."""
    excess = where.excess + 2 * shape.ln_bayes
    return replace(where, excess=excess, p=min(where.p, shape.p), sectors=(Sector("impact", 1.0, min(where.p, shape.p)),))


def windows_of(base: Fit) -> Windows:
    """What e, and what the kick, would have more in every bin of speed and for every count."""
    model = base.problem.model
    speed, count, columns, where = model.bounces.speed, model.impacts.number, [], []
    edges = np.unique(np.quantile(speed, np.linspace(0, 1, BINS + 1)))
    axes = {"v_m_s": (speed, list(pairwise(edges))), "n_bounce": (count, [(k - 0.5, k + 0.5) for k in np.unique(count)])}
    for axis, (values, bins) in axes.items():
        for low, high in bins:
            inside = ((values >= low) & (values <= high)).astype(float)
            if inside.all():
                continue
            for e, kick in ((inside, 0 * inside), (0 * inside, inside)):
                columns.append(np.concatenate([e[model.e_rows], kick[model.kick_rows]]))
                where.append((axis, float(low), float(high)))
    return Windows(np.array(columns).reshape(-1, len(model.y)), tuple(where))


def curves_of(before: Fit, after: Fit) -> tuple[Curve, ...]:
    """Restitution over the speed of impact, one curve of each recording that has any."""
    model = before.problem.model
    left = [model.y - predict(of.problem.model, of.by_name) for of in (before, after)]
    out = []
    for r, recording in enumerate(model.impacts.names):
        for rows, first, quantity in ((model.e_rows, 0, "restitution"), (model.kick_rows, len(model.e_rows), "sideways kick")):
            own = np.flatnonzero(model.impacts.recording[rows] == r)
            if len(own):
                own = own[np.argsort(model.bounces.speed[rows[own]])]
                parts = [values[first + own] for values in (model.y, *left)]
                out.append(Curve(recording, quantity, "1", "v_m_s", model.bounces.speed[rows[own]], *parts))
    return tuple(out)
