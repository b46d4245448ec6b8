"""What a contact parameter follows, beside all else that may be missing."""

import math
from dataclasses import replace

import numpy as np
from scipy import stats

from benchtwin.bench.language import tr
from benchtwin.infer.condition_table import condition_table, numbers_of
from benchtwin.infer.conditions import Contact, with_follows
from benchtwin.infer.explanation import Alternative, Explanation, Posterior
from benchtwin.infer.follow import ConditionTable, Follow
from benchtwin.infer.problem import Fit, fit, ln_evidence, refined
from benchtwin.infer.task import DiagnosisTask
from benchtwin.infer.verdict import (
    ENDS,
    NAME_PROBABILITY,
    Interval,
    Verdict,
    averaged,
)


def with_conditions(
    task: DiagnosisTask, fits: tuple[Fit, ...], rng: np.random.Generator
) -> tuple[ConditionTable, tuple[Alternative, ...], tuple[Fit, ...]]:
    """What the contact parameter follows, in the likeliest baseline; all alternatives
    with it, and their fits with nothing missing."""
    if task.follows is None:
        return ConditionTable(), task.alternatives, fits
    contact, conditions = task.follows
    plain = [k for k, a in enumerate(task.alternatives) if not a.effects]
    likeliest = max(
        plain, key=lambda k: ln_evidence(fits[k]) + math.log(task.alternatives[k].odds)
    )
    seen, table = fits[likeliest], ConditionTable()
    for _ in range(2):  # the fit without what was found is bent by it
        free = tuple(n for n, e in seen.problem.effects.items() if not e.group)
        numbers = numbers_of(refined(seen, free), contact.column)
        table = condition_table(numbers, contact, conditions, rng)
        if not table.found:
            return table, task.alternatives, fits
        seen = _following(fits[likeliest], contact, table)
    bases = tuple(_following(one, contact, table) for one in fits)
    pairs = zip(task.alternatives, bases, strict=True)
    return table, tuple(replace(a, problem=f.problem) for a, f in pairs), bases


def _following(of: Fit, contact: Contact, table: ConditionTable) -> Fit:
    """A fit again, with globals by which the parameter follows what was found."""
    names = of.problem.recordings
    shifts = {
        f.name: np.array([f.shift.get(r, 0.0) for r in names]) for f in table.found
    }
    problem = with_follows(of.problem, contact, shifts)
    values = np.append(of.values, np.ones(len(shifts)))
    return fit(problem, start=replace(of, problem=problem, values=values, cache={}))


def sized(table: ConditionTable, posterior: Posterior) -> ConditionTable:
    """The table with its sizes averaged over the explanations: in each, what is
    followed is there as many times as its fit has it."""
    return replace(table, found=tuple(_sized(f, posterior) for f in table.found))


def _sized(f: Follow, posterior: Posterior) -> Follow:
    def times(size: Interval) -> Interval:
        sd = (size.high95 - size.low95) / 2 / stats.norm.ppf(ENDS[1])

        def there(e: Explanation) -> tuple[float, float]:
            many = e.fit.by_name[f.name]
            return many * size.value, abs(many) * sd

        return averaged(list(posterior.explanations), there)

    mean = times(Interval(1.0, 1.0, 1.0)).value
    return replace(
        f,
        slope=f.slope if f.levels else times(f.slope),
        curve=tuple(replace(p, size=times(p.size)) for p in f.curve),
        seen={r: (mean * value, mean * sd) for r, (value, sd) in f.seen.items()},
        left_out={r: mean * value for r, value in f.left_out.items()},
    )


def with_followed(of_motions: Verdict, table: ConditionTable) -> Verdict:
    """The verdict on all but conditions, with what a parameter was found to follow:
    named where it is as probable as a name must be, and by one condition; with a drift
    that has no stated cause something unlisted is missing."""
    probability = of_motions.probability * (1 - table.next[1] if table.next else 1.0)
    if not table.found:
        return replace(of_motions, probability=probability)
    listed = [f for f in table.found if not f.unlisted]
    sure = all(f.probability >= NAME_PROBABILITY and not f.as_well for f in listed)
    names = tuple(n for f in listed for n in f.names)
    kind = of_motions.verdict
    known = of_motions.names
    if len(listed) < len(table.found):
        kind, known = "unknown", known if kind in ("name", "unknown") else ()
    elif kind in ("none", "name"):
        kind = "name" if sure else "class"
    for f in table.found:
        probability *= f.probability
    return Verdict(kind, (*known, *names), probability)


def sets_with_followed(
    sets: list[tuple[tuple[str, ...], float]], table: ConditionTable
) -> list[tuple[tuple[str, ...], float]]:
    """Sets of what is missing, each with and without what may be followed."""
    shares = [(f.names, f.probability) for f in table.found]
    shares += [((table.next[0],), table.next[1])] if table.next else []
    for names, probability in shares:
        more = [
            ((*own, n), p * probability / len(names)) for own, p in sets for n in names
        ]
        sets = more + [(own, p * (1 - probability)) for own, p in sets]
    return sorted(sets, key=lambda one: -one[1])


def far_off(table: ConditionTable, task: DiagnosisTask) -> tuple[str, ...]:
    """Of a recording that was left out of the table."""
    if table.far is None or task.follows is None:
        return ()
    what = task.follows[0].name.replace("_", " ")
    name, off = table.far
    return (
        (
            tr(
                "{}: its {} lies {:.2g} off the others'; it is left out where"
                " conditions are tested",
                name,
                what,
                off,
            )
        ),
    )
