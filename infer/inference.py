"""From what a rig hands over to its finding."""

import math
from dataclasses import dataclass, replace

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.infer.alarm import ALARM_P, left_over_p
from benchtwin.infer.conditions import effect_name
from benchtwin.infer.evidence import Kind
from benchtwin.infer.explanation import Explanation, Posterior
from benchtwin.infer.finding import Finding, Parameter, Sector
from benchtwin.infer.follow import ConditionTable
from benchtwin.infer.held_out import held_out, left_out_values
from benchtwin.infer.law_found import lawful
from benchtwin.infer.posterior import explain
from benchtwin.infer.power_law import Law, Term
from benchtwin.infer.problem import fit
from benchtwin.infer.task import DiagnosisTask
from benchtwin.infer.unlisted import strongest_window
from benchtwin.infer.verdict import (
    MATTERS_SDS,
    EffectEstimate,
    ParameterShift,
    Verdict,
    effect_estimate,
    least_of,
    mixture_interval,
    parameter_shift,
    sector_shares,
    verdict_of,
    weighed_with_noise,
)
from benchtwin.infer.with_conditions import (
    far_off,
    sets_with_followed,
    sized,
    with_conditions,
    with_followed,
)

LIKELY = 0.01  # probability from which an effect's size is stated


@dataclass(frozen=True, eq=False)
class Inferred:
    """All that a finding says is taken from this."""

    task: DiagnosisTask
    posterior: Posterior
    table: ConditionTable
    bare: Explanation  # nothing missing, no condition followed
    of_motions: Verdict  # on all but conditions
    chosen: Explanation  # that this verdict is about
    model: Explanation  # the same with a law for what is unlisted
    law: Law = ()

    @property
    def terms(self) -> tuple[Term, ...]:
        """Of that law."""
        return self.law or ()

    @property
    def tests(self) -> int:
        """Of the bench: of the motions, and of conditions where there are any."""
        return 1 if self.table.p is None else 2

    @property
    def p(self) -> float:
        """That noise alone makes as much of either test."""
        p = self.posterior.p_noise
        if self.table.p is None:
            return p
        return min(p, least_of(self.tests, self.table.p))

    @property
    def alarm(self) -> bool:
        return self.p < ALARM_P or bool(self.table.found)

    @property
    def verdict(self) -> Verdict:
        return with_followed(self.of_motions, self.table)


def finding_of(task: DiagnosisTask, rng: np.random.Generator) -> Finding:
    """The finding of one rig."""
    of = _inferred(task, rng)
    base, verdict, table = of.posterior.base, of.verdict, of.table
    window, best_axis = strongest_window(
        base.reduced,
        base.fit.baseline_sd,
        base.windows,
        base.columns,
        base.table.level_sd,
        rng,
    )
    effects, contact = _effects(of), _contact(of)
    over_nothing, over_others = _ln_bayes(of)
    followed = tuple(f.name for f in table.found)
    law = tr(" and ").join(t.in_words() for t in of.terms) or _differing(of)
    return Finding(
        task.rig,
        base.fit.problem.recordings,
        of.alarm,
        of.p,
        _sectors(of, rng),
        window,
        best_axis,
        verdict.verdict,
        verdict.names,
        ln_bayes_baseline=over_nothing,
        ln_bayes_runner_up=over_others,
        parameters=_parameters(verdict, effects),
        law=law,
        held_out=held_out(of.model, base, followed) if of.alarm else None,
        next_record=_next_record(task, verdict, table),
        p_verdict=verdict.probability,
        matters=of.alarm and _matters(contact, table),
        follows=table.found,
        explanations=tuple(sets_with_followed(of.posterior.by_set(), table)),
        effects=effects,
        contact=contact,
        curves=task.curves(of.bare.fit, of.model.fit),
        notes=tuple(note for note in _notes(of) if note != law),
        left_out=_left_out(of),
        laws={t.effect.name: t.effect for t in of.terms},
        unlisted=_unlisted(of),
        senseless=of.law is None,
    )


def _inferred(task: DiagnosisTask, rng: np.random.Generator) -> Inferred:
    """Fits, posterior and verdict."""
    fits = tuple(fit(a.problem) for a in task.alternatives)
    table, alternatives, bases = with_conditions(task, fits, rng)
    posterior = weighed_with_noise(
        explain(alternatives, task.windows, bases), rng, 1 if table.p is None else 2
    )
    table = sized(table, posterior)
    verdict, base = verdict_of(posterior), posterior.base
    bare = replace(base, fit=fits[base.alternative])
    chosen = _chosen(posterior, verdict)
    of = Inferred(task, posterior, table, bare, verdict, chosen, chosen)
    if verdict.verdict != "unknown":
        return of
    model, law, verdict = lawful(posterior, verdict, chosen, task)
    return replace(of, model=model, law=law, of_motions=verdict)


def _effects(of: Inferred) -> dict[str, EffectEstimate]:
    """Sizes of the effects that are likely, of what is followed and of a law found."""
    posterior = of.posterior
    listed = {n for e in posterior.explanations for n in e.listed}
    presence = posterior.presence().items()
    likely = [n for n, q in presence if n in listed and q > LIKELY]
    found = {n: effect_estimate(posterior, n) for n in likely}
    found |= {
        f.name: EffectEstimate(f.probability / len(f.names), f.unit, f.slope)
        for f in of.table.found
    }
    strange = of.of_motions.probability
    return found | {t.effect.name: _size(t, strange) for t in of.terms}


def _parameters(
    verdict: Verdict, effects: dict[str, EffectEstimate]
) -> dict[str, Parameter]:
    """Those of the named effects that have one."""
    named = verdict.names if verdict.verdict == "name" else ()
    sizes = {n: effects[n] for n in named if n in effects and effects[n].unit}
    return {n: Parameter(e.unit, *vars(e.size).values()) for n, e in sizes.items()}


def _contact(of: Inferred) -> dict[str, ParameterShift]:
    return {
        n: parameter_shift(of.posterior, of.bare, value)
        for n, value in of.task.contact.items()
    }


def _ln_bayes(of: Inferred) -> tuple[float, float]:
    """ln odds of what was chosen over nothing missing, and over the next set; NaN
    without an alarm."""
    if not of.alarm:
        return math.nan, math.nan
    posterior, chosen = of.posterior, of.chosen.names
    ours = posterior.probability(chosen)
    others = [q for names, q in posterior.by_set() if names and names != chosen]
    nothing = posterior.probability(())
    return _ln_odds(ours, nothing), _ln_odds(ours, max(others, default=0.0))


def _left_out(of: Inferred) -> dict[str, tuple[float, ...]]:
    """What the other recordings say of each effect, recording by recording."""
    found = left_out_values(of.model) if of.posterior.p_noise < ALARM_P else {}
    recordings = of.bare.fit.problem.recordings
    for f in of.table.found:
        found[f.name] = tuple(f.left_out.get(r, 0.0) for r in recordings)
    return found


def _unlisted(of: Inferred) -> frozenset[str]:
    """Of the explanations' parts those that are no listed effect, drifts among them."""
    drifts: set[str] = set()
    if of.task.follows:
        contact, conditions = of.task.follows
        drifts = {effect_name(contact, c.name) for c in conditions if c.unlisted}
    return frozenset(of.posterior.unlisted() | drifts)


def _next_record(
    task: DiagnosisTask, verdict: Verdict, table: ConditionTable
) -> str | None:
    """What would settle a verdict that is no name."""
    if verdict.verdict == "name":
        return None
    for f in table.found:
        if f.as_well:
            these = tr(" and ").join((f.condition, *f.as_well))
            return tr("recordings in which {} do not go together", these)
    followed = {n for f in table.found for n in f.names}
    return task.advice(tuple(n for n in verdict.names if n not in followed))


def _chosen(posterior: Posterior, verdict: Verdict) -> Explanation:
    """The explanation that the verdict is about; of a class the likeliest."""
    if verdict.verdict == "none":
        return posterior.base
    strange = verdict.verdict == "unknown"

    def share(e: Explanation) -> float:
        if strange:
            return e.probability if e.unlisted else e.and_more
        return e.probability if e.names and not e.unlisted else 0.0

    if verdict.verdict == "name":
        own = [e for e in posterior.explanations if set(e.names) == set(verdict.names)]
        return max(own, key=share)
    return max(posterior.explanations, key=share)


def _size(term: Term, probability: float) -> EffectEstimate:
    """Of something unlisted, of which the term says what it is like."""
    size = mixture_interval([(1.0, term.size, term.sd)])
    return EffectEstimate(probability, term.effect.unit, size)


def _ln_odds(p: float, q: float) -> float:
    return math.log(max(p, 1e-300)) - math.log(max(q, 1e-300))


def _matters(contact: dict[str, ParameterShift], table: ConditionTable) -> bool:
    """Whether a contact parameter shifts or follows a condition; true for rigs without
    any."""
    return (
        not contact
        or bool(table.found)
        or any(abs(m.shift_sds) >= MATTERS_SDS for m in contact.values())
    )


def _sectors(of: Inferred, rng: np.random.Generator) -> tuple[Sector, ...]:
    """Each sector; what has no shape that was tried acts where noise explains least. A
    condition that is followed acts where the parameter does."""
    posterior, table, follows = of.posterior, of.table, of.task.follows
    base, alarm = posterior.base, posterior.p_noise < ALARM_P
    names = dict.fromkeys(c.sector for c in base.table.components.values())
    p = {n: left_over_p(base, rng, sector=n) for n in names}
    shares = sector_shares(posterior)
    if alarm and names:
        least = min(p, key=lambda n: p[n])
        shapeless = sum(e.and_more for e in posterior.explanations if not e.names)
        rest = 1 - posterior.probability(()) - shapeless
        shares = {n: rest * share for n, share in shares.items()}
        shares[least] = shares.get(least, 0.0) + shapeless
    shares = shares if alarm else {}
    if table.found and follows is not None:
        where = follows[0].sector
        part = sum(f.probability for f in table.found)
        p[where] = min(p.get(where, 1.0), table.found[0].p)
        shares[where] = shares.get(where, 0.0) + part
    whole = sum(shares.values())
    out = [
        Sector(n, shares.get(n, 0.0) / whole if whole else math.nan, p[n]) for n in p
    ]
    return tuple(sorted(out, key=lambda s: (-np.nan_to_num(s.explained), s.p)))


def _differing(of: Inferred) -> str | None:
    """What is unlisted and differs from recording to recording, for the reader."""
    own = of.posterior.alternatives[of.model.alternative]
    differs = own.kind is Kind.UNLISTED and of.verdict.verdict == "unknown"
    return own.note if differs else None


def _notes(of: Inferred) -> tuple[str, ...]:
    """Of the rig, of what was fitted and of the likeliest alternative."""
    posterior = of.posterior
    note = posterior.alternatives[posterior.explanations[0].alternative].note
    said = *of.task.notes, *far_off(of.table, of.task), *of.task.remarks(of.model.fit)
    return (*said, note) if note else said
