"""A finding: what one rig's recordings gave, as in diagnosis.json, with curves for the
report."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from benchtwin.infer.alarm import ALARM_P, left_over_p
from benchtwin.infer.condition_table import (
    ConditionTable,
    Follow,
    condition_table,
    numbers_of,
)
from benchtwin.infer.conditions import (
    Condition,
    Contact,
    effect_name,
    with_follows,
)
from benchtwin.infer.effect import Effect
from benchtwin.infer.evidence import Kind
from benchtwin.infer.explanation import (
    UNSHAPED,
    Alternative,
    Explanation,
    Posterior,
)
from benchtwin.infer.held_out import HeldOut, held_out, left_out_values
from benchtwin.infer.posterior import PRIOR, explain, explanation_of
from benchtwin.infer.power_law import NAMES, ROUNDS, Term, fitted
from benchtwin.infer.problem import Fit, fit, ln_evidence
from benchtwin.infer.unlisted import Window, Windows, strongest_window
from benchtwin.infer.verdict import (
    MATTERS_SDS,
    NAME_PROBABILITY,
    EffectEstimate,
    ParameterShift,
    Verdict,
    effect_estimate,
    estimate,
    least_of,
    mixture_interval,
    parameter_shift,
    sector_shares,
    verdict_of,
    weighed_with_noise,
)

MOST_EXPLANATIONS = 20
PLAIN_FIELDS = (  # of a finding, as they are in diagnosis.json
    "alarm",
    "p_global",
    "verdict",
    "names",
    "p_verdict",
    "matters",
    "ln_bayes_baseline",
    "ln_bayes_runner_up",
    "law",
    "next_record",
    "recordings",
    "notes",
)


@dataclass(frozen=True)
class Sector:
    """explained: share of what is missing, or NaN; p: that noise alone fits as badly
    there."""

    name: str
    explained: float
    p: float


@dataclass(frozen=True)
class Parameter:
    """Reported parameter of a named effect with its 95 % interval."""

    unit: str
    value: float
    low95: float
    high95: float


@dataclass(frozen=True, eq=False)
class Curve:
    """What a report draws of one recording: `seen` (n,) over `along` (n,), and
    residuals."""

    recording: str
    quantity: str  # of `seen`
    unit: str
    axis: str  # name of `along` with its unit
    along: np.ndarray
    seen: np.ndarray
    left_by_baseline: np.ndarray
    left_by_model: np.ndarray


@dataclass(frozen=True, eq=False)
class Finding:
    """What one rig's recordings gave; fields as in diagnosis.json."""

    rig: str
    recordings: tuple[str, ...]
    alarm: bool
    p_global: float
    sectors: tuple[Sector, ...]
    window: Window | None
    best_axis: str  # the quantity that unlisted physics follows best
    verdict: str
    names: tuple[str, ...]
    ln_bayes_baseline: float
    ln_bayes_runner_up: float
    parameters: dict[str, Parameter]
    law: str | None
    held_out: HeldOut | None
    next_record: str | None
    p_verdict: float = 1.0
    matters: bool = False
    explanations: tuple[tuple[tuple[str, ...], float], ...] = ()
    effects: dict[str, EffectEstimate] = field(default_factory=dict)
    contact: dict[str, ParameterShift] = field(default_factory=dict)
    curves: tuple[Curve, ...] = ()
    notes: tuple[str, ...] = field(default=())
    left_out: dict[str, tuple[float, ...]] = field(default_factory=dict)
    unlisted: frozenset[str] = frozenset({UNSHAPED})  # of the explanations' parts
    laws: dict[str, Effect] = field(default_factory=dict)  # found for what is unlisted
    follows: tuple[Follow, ...] = ()  # parameters that follow conditions

    @property
    def modelled(self) -> tuple[str, ...]:
        """The effects of the model: those named; of a class the likeliest
        explanation."""
        return tuple(n for n in self.left_out if "." not in n)

    @property
    def moves_mm(self) -> float:
        """By how much at most what is missing moves a tracked path beside the
        baseline's best fit; NaN where nothing is tracked in mm or nothing is missing.
        """
        if self.verdict == "none":
            return math.nan
        off = [c.left_by_baseline - c.left_by_model for c in self.curves]
        paths = [o for o, c in zip(off, self.curves, strict=True) if c.unit == "mm"]
        return max((float(np.nanmax(np.abs(o))) for o in paths), default=math.nan)

    def to_json(self) -> dict:
        """The rig's entry of diagnosis.json; null for what there is not."""
        held = self.held_out
        return _plain(
            {key: getattr(self, key) for key in PLAIN_FIELDS}
            | {
                "sectors": [vars(s) for s in self.sectors],
                "window": (
                    self.window
                    and {k: v for k, v in vars(self.window).items() if k != "p"}
                ),
                "parameters": {name: vars(p) for name, p in self.parameters.items()},
                "follows": [f.to_json() for f in self.follows],
                "moves_mm": self.moves_mm,
                "explanations": [
                    {"effects": names, "probability": p}
                    for names, p in self.explanations[:MOST_EXPLANATIONS]
                ],
                "effects": {
                    name: (
                        {"probability": e.probability, "unit": e.unit} | vars(e.size)
                    )
                    for name, e in self.effects.items()
                },
                "contact_parameters": {
                    name: {
                        "unit": "1",
                        "nothing_missing": vars(m.nothing_missing),
                        "explained": vars(m.explained),
                        "shift_sds": m.shift_sds,
                    }
                    for name, m in self.contact.items()
                },
                "held_out": (
                    vars(held)
                    if held
                    else {"rmse_ratio": None, "removed_fraction": None}
                ),
            }
        )


def _plain(value):
    """For JSON: lists for tuples, null for NaN and infinity."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    return value


@dataclass(frozen=True, eq=False)
class DiagnosisTask:
    """What a rig hands to the inference."""

    rig: str
    alternatives: tuple[Alternative, ...]  # of its baseline
    windows: Callable[[Fit], Windows]  # of unlisted physics
    curves: Callable[[Fit, Fit], tuple[Curve, ...]]  # (base, model): for the report
    contact: Mapping[str, Callable[[Explanation], tuple[float, float]]] = field(
        default_factory=dict
    )
    law: Callable[[Fit], tuple[Term, ...]] = lambda fit: ()  # of unlisted physics
    # what to record next
    advice: Callable[[tuple[str, ...]], str | None] = lambda names: None
    notes: tuple[str, ...] = ()
    remarks: Callable[[Fit], tuple[str, ...]] = lambda fit: ()  # notes on what was fit
    # what may follow which conditions
    follows: tuple[Contact, tuple[Condition, ...]] | None = None


def finding_of(task: DiagnosisTask, rng: np.random.Generator) -> Finding:
    """The finding of one rig."""
    fits = tuple(fit(a.problem) for a in task.alternatives)
    table, alternatives, bases = _with_conditions(task, fits, rng)
    tests = 1 if table.p is None else 2
    posterior = weighed_with_noise(
        explain(alternatives, task.windows, bases), rng, tests
    )
    base, of_motions = posterior.base, verdict_of(posterior)
    chosen = model = _chosen(posterior, of_motions)
    terms: tuple[Term, ...] = ()
    if of_motions.verdict == "unknown":
        model, terms, of_motions = _lawful(posterior, of_motions, chosen, task)
    verdict = with_followed(of_motions, table)
    window, best_axis = strongest_window(
        base.reduced,
        base.fit.baseline_sd,
        base.windows,
        base.columns,
        base.table.level_sd,
        rng,
    )
    listed = {n for e in posterior.explanations for n in e.listed}
    likely = [n for n, q in posterior.presence().items() if n in listed and q > 0.01]
    estimates = {n: effect_estimate(posterior, n) for n in likely}
    estimates |= {
        f.name: EffectEstimate(f.probability / len(f.names), f.unit, f.slope)
        for f in table.found
    }
    estimates |= {t.effect.name: _size(t, of_motions.probability) for t in terms}
    bare = replace(base, fit=fits[base.alternative])
    contact = {
        n: parameter_shift(posterior, bare, value) for n, value in task.contact.items()
    }
    p = posterior.p_noise
    if table.p is not None:
        p = min(p, least_of(tests, table.p))
    alarm = p < ALARM_P or bool(table.found)
    ranked = _with_followed_sets(posterior.by_set(), table)
    nothing = posterior.probability(())
    some = [q for names, q in posterior.by_set() if names and names != chosen.names]
    ours = posterior.probability(chosen.names)
    named = verdict.names if verdict.verdict == "name" else ()
    sizes = {n: estimates[n] for n in named if n in estimates and estimates[n].unit}
    followed = tuple(f.name for f in table.found)
    left_out = left_out_values(model) if posterior.p_noise < ALARM_P else {}
    recordings = base.fit.problem.recordings
    for f in table.found:
        left_out[f.name] = tuple(f.left_out.get(r, 0.0) for r in recordings)
    drifts: set[str] = set()
    if task.follows:
        contact_of, conditions = task.follows
        drifts = {effect_name(contact_of, c.name) for c in conditions if c.unlisted}
    return Finding(
        task.rig,
        recordings,
        alarm,
        p,
        _sectors(posterior, table, task, rng),
        window,
        best_axis,
        verdict.verdict,
        verdict.names,
        ln_bayes_baseline=_ln_odds(ours, nothing) if alarm else math.nan,
        ln_bayes_runner_up=_ln_odds(ours, max(some, default=0.0))
        if alarm
        else math.nan,
        parameters={
            n: Parameter(e.unit, *vars(e.size).values()) for n, e in sizes.items()
        },
        law=" and ".join(t.in_words() for t in terms) or None,
        held_out=held_out(model, base, followed) if alarm else None,
        next_record=_next_record(task, verdict, table),
        p_verdict=verdict.probability,
        matters=alarm and _matters(contact, table),
        follows=table.found,
        explanations=tuple(ranked),
        effects=estimates,
        contact=contact,
        curves=task.curves(bare.fit, model.fit),
        notes=(
            *task.notes,
            *_far_off(table, task),
            *task.remarks(model.fit),
            *_notes(posterior),
        ),
        left_out=left_out,
        laws={t.effect.name: t.effect for t in terms},
        unlisted=frozenset(posterior.unlisted() | drifts),
    )


def _with_conditions(
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
        numbers = numbers_of(fit(seen.problem, free=free, start=seen), contact.column)
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


def _with_followed_sets(
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


def _far_off(table: ConditionTable, task: DiagnosisTask) -> tuple[str, ...]:
    """Of a recording that was left out of the table."""
    if table.far is None or task.follows is None:
        return ()
    what = task.follows[0].name.replace("_", " ")
    name, off = table.far
    return (
        (
            f"{name}: its {what} lies {off:.2g} off the others'; it is left out where"
            " conditions are tested"
        ),
    )


def _next_record(
    task: DiagnosisTask, verdict: Verdict, table: ConditionTable
) -> str | None:
    """What would settle a verdict that is no name."""
    if verdict.verdict == "name":
        return None
    for f in table.found:
        if f.as_well:
            these = " and ".join((f.condition, *f.as_well))
            return f"recordings in which {these} do not go together"
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


def _lawful(
    posterior: Posterior, verdict: Verdict, chosen: Explanation, task: DiagnosisTask
) -> tuple[Explanation, tuple[Term, ...], Verdict]:
    """What is unlisted as a law, its terms, and the verdict: of listed effects beside
    it those are left that are needed beside the law as well."""
    if not chosen.listed:
        return *with_law(chosen, task), verdict
    alone, own = with_law(posterior.base, task)
    if not own or _ln_weight(alone) < _ln_weight(chosen):
        model, terms = with_law(chosen, task)
        if not own or _ln_weight(alone) < _ln_weight(model):
            return model, terms, verdict
    strange = posterior.unlisted()
    unlisted = sum(p for names, p in posterior.by_set() if strange & set(names))
    return alone, own, Verdict("unknown", (), unlisted)


def _ln_weight(e: Explanation) -> float:
    """ln of evidence and prior odds of something unlisted beside these effects."""
    beside = sum(n not in NAMES for n in e.names if n in e.listed)
    candidates = sum(c.kind is not Kind.UNLISTED for c in e.table.components.values())
    odds = PRIOR[min(beside, 2), 1] / math.comb(candidates, min(beside, 2))
    return e.table.ln_evidence(e.names)[0] + math.log(odds)


def with_law(
    chosen: Explanation, task: DiagnosisTask
) -> tuple[Explanation, tuple[Term, ...]]:
    """The explanation with a law in the place of what is unlisted, and its terms with
    the sizes that it gives; what a model cannot follow stays as it was found."""
    k, found = chosen.alternative, chosen.fit
    free = tuple(n for n in chosen.listed if n in found.problem.effects)
    terms: tuple[Term, ...] = ()
    able: tuple[Term, ...] = ()
    for _ in range(ROUNDS):
        before = [t.in_the_twin for t in able]
        terms = task.law(found)
        able = tuple(t for t in terms if t.in_the_twin)
        if not terms or terms[0] not in able:
            return chosen, terms
        if before == [t.in_the_twin for t in able]:
            break
        found = fitted(chosen.fit, free, able)
    names = tuple(t.effect.name for t in able)
    noise = chosen.power, chosen.table.level_sd
    windows = task.windows(found)
    own = task.alternatives[k]
    model = explanation_of(found, (*chosen.listed, *names), k, own, windows, noise)
    sizes = {n: estimate(model, n) for n in names}
    found_sizes = ((t, sizes.get(t.effect.name, (t.size, t.sd))) for t in terms)
    return model, tuple(replace(t, size=a, sd=sd) for t, (a, sd) in found_sizes)


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


def _sectors(
    posterior: Posterior,
    table: ConditionTable,
    task: DiagnosisTask,
    rng: np.random.Generator,
) -> tuple[Sector, ...]:
    """Each sector; what has no shape that was tried acts where noise explains least. A
    condition that is followed acts where the parameter does."""
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
    if table.found and task.follows is not None:
        where = task.follows[0].sector
        part = sum(f.probability for f in table.found)
        p[where] = min(p.get(where, 1.0), table.found[0].p)
        shares[where] = shares.get(where, 0.0) + part
    whole = sum(shares.values())
    out = [
        Sector(n, shares.get(n, 0.0) / whole if whole else math.nan, p[n]) for n in p
    ]
    return tuple(sorted(out, key=lambda s: (-np.nan_to_num(s.explained), s.p)))


def _notes(posterior: Posterior) -> tuple[str, ...]:
    """Of the likeliest alternative."""
    note = posterior.alternatives[posterior.explanations[0].alternative].note
    return (note,) if note else ()
