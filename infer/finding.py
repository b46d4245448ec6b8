"""A finding: what one rig's recordings gave, as in diagnosis.json, with curves for the
report."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from benchtwin.infer.alarm import ALARM_P, left_over_p
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
from benchtwin.infer.problem import Fit
from benchtwin.infer.unlisted import Window, Windows, strongest_window
from benchtwin.infer.verdict import (
    MATTERS_SDS,
    EffectEstimate,
    ParameterShift,
    Verdict,
    effect_estimate,
    estimate,
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

    @property
    def modelled(self) -> tuple[str, ...]:
        """The effects of the model: those named; of a class the likeliest
        explanation."""
        return tuple(n for n in self.left_out if "." not in n)

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
                "explanations": [
                    {"effects": names, "probability": p}
                    for names, p in self.explanations[:MOST_EXPLANATIONS]
                ],
                "effects": {
                    name: (
                        {"probability": e.probability, "unit": e.unit}
                        | vars(e.size)
                        | (
                            {
                                "levels": {
                                    level: vars(size)
                                    for level, size in e.levels.items()
                                }
                            }
                            if e.levels
                            else {}
                        )
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


def finding_of(task: DiagnosisTask, rng: np.random.Generator) -> Finding:
    """The finding of one rig."""
    posterior = weighed_with_noise(explain(task.alternatives, task.windows), rng)
    base, verdict = posterior.base, verdict_of(posterior)
    chosen = model = _chosen(posterior, verdict)
    terms: tuple[Term, ...] = ()
    if verdict.verdict == "unknown":
        model, terms, verdict = _lawful(posterior, verdict, chosen, task)
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
    contact = {
        n: parameter_shift(posterior, value) for n, value in task.contact.items()
    }
    estimates |= {t.effect.name: _size(t, verdict.probability) for t in terms}
    alarm = posterior.p_noise < ALARM_P
    nothing, ranked = posterior.probability(()), posterior.by_set()
    some = [q for names, q in ranked if names and names != chosen.names]
    ours = posterior.probability(chosen.names)
    named = verdict.names if verdict.verdict == "name" else ()
    sizes = {n: estimates[n] for n in named if n in estimates and estimates[n].unit}
    return Finding(
        task.rig,
        base.fit.problem.recordings,
        alarm,
        posterior.p_noise,
        _sectors(posterior, alarm, rng),
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
        held_out=held_out(model, base) if alarm else None,
        next_record=task.advice(verdict.names) if verdict.verdict != "name" else None,
        p_verdict=verdict.probability,
        matters=alarm and _matters(contact, verdict.names),
        explanations=tuple(ranked),
        effects=estimates,
        contact=contact,
        curves=task.curves(base.fit, model.fit),
        notes=(*task.notes, *task.remarks(model.fit), *_notes(posterior)),
        left_out=left_out_values(model) if alarm else {},
        laws={t.effect.name: t.effect for t in terms},
        unlisted=frozenset(posterior.unlisted()),
    )


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
    model, terms = _with_law(chosen, task)
    if not chosen.listed:
        return model, terms, verdict
    alone, own = _with_law(posterior.base, task)
    if _ln_weight(alone) < _ln_weight(model):
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


def _with_law(
    chosen: Explanation, task: DiagnosisTask
) -> tuple[Explanation, tuple[Term, ...]]:
    """The explanation with a law in the place of what is unlisted, and its terms with
    the sizes that it gives; what a model cannot follow stays as it was found."""
    k, found = chosen.alternative, chosen.fit
    free = tuple(n for n in chosen.listed if n in found.problem.effects)
    terms = able = ()
    for _ in range(ROUNDS):
        before = [t.effect.counterpart.what for t in able]
        terms = task.law(found)
        able = tuple(t for t in terms if t.effect.counterpart)
        if not terms or terms[0] not in able:
            return chosen, terms
        if before == [t.effect.counterpart.what for t in able]:
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


def _matters(contact: dict[str, ParameterShift], names: tuple[str, ...]) -> bool:
    """Whether a contact parameter shifts or follows a condition; true for rigs without
    any."""
    return (
        not contact
        or any("-follows-" in n for n in names)
        or any(abs(m.shift_sds) >= MATTERS_SDS for m in contact.values())
    )


def _sectors(
    posterior: Posterior, alarm: bool, rng: np.random.Generator
) -> tuple[Sector, ...]:
    """Each sector; what has no shape that was tried acts where noise explains least."""
    base = posterior.base
    names = dict.fromkeys(c.sector for c in base.table.components.values())
    p = {n: left_over_p(base, rng, sector=n) for n in names}
    shares = sector_shares(posterior)
    if alarm and names:
        least = min(p, key=lambda n: p[n])
        shapeless = sum(e.and_more for e in posterior.explanations if not e.names)
        rest = 1 - posterior.probability(()) - shapeless
        shares = {n: rest * share for n, share in shares.items()}
        shares[least] = shares.get(least, 0.0) + shapeless
    whole = sum(shares.values())
    out = [
        Sector(n, shares.get(n, 0.0) / whole if alarm and whole else math.nan, p[n])
        for n in names
    ]
    return tuple(sorted(out, key=lambda s: (-np.nan_to_num(s.explained), s.p)))


def _notes(posterior: Posterior) -> tuple[str, ...]:
    """Of the likeliest alternative."""
    note = posterior.alternatives[posterior.explanations[0].alternative].note
    return (note,) if note else ()
