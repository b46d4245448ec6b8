"""A finding: all that one rig's recordings told, in the form of diagnosis.json, with the curves that its report draws."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from diagnose.engine.alarm import ALARM_P, p_global, p_of
from diagnose.engine.held_out import HeldOut, held_out, left_out_values
from diagnose.engine.locate import Window, Windows, strongest_window
from diagnose.engine.posterior import Alternative, Explanation, Posterior, explain
from diagnose.engine.problem import Fit
from diagnose.engine.verdict import MATTERS_SDS, Moved, Told, Verdict, moved_of, sector_shares, told_of, verdict_of

MOST_EXPLANATIONS = 20


@dataclass(frozen=True)
class Sector:
    """explained: share of what is missing (NaN where nothing is); p: that noise alone makes as great a mismatch there."""

    name: str
    explained: float
    p: float


@dataclass(frozen=True)
class Parameter:
    """Reported parameter of a named effect, in the unit of effects.json, with its 95 % interval."""

    unit: str
    value: float
    low95: float
    high95: float


@dataclass(frozen=True, eq=False)
class Curve:
    """What a report draws of one recording: what was seen (n,) along `axis` (n,), what the baseline and the verdict's model leave
    of it (n,), both in `unit`; `quantity` says what was seen."""

    recording: str
    quantity: str
    unit: str
    axis: str
    along: np.ndarray
    seen: np.ndarray
    left_by_baseline: np.ndarray
    left_by_model: np.ndarray


@dataclass(frozen=True, eq=False)
class Finding:
    """What one rig's recordings told; fields as in diagnosis.json, and what its report shows beside them.

    left_out: each effect of the model (a class: of its likeliest explanation) as the other recordings have it, one value a
    recording; beside it, as name.other, its further parameters.
    """

    rig: str
    recordings: tuple[str, ...]
    alarm: bool
    p_global: float
    sectors: tuple[Sector, ...]
    window: Window | None
    collapse: str
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
    effects: dict[str, Told] = field(default_factory=dict)
    contact: dict[str, Moved] = field(default_factory=dict)
    curves: tuple[Curve, ...] = ()
    notes: tuple[str, ...] = field(default=())
    left_out: dict[str, tuple[float, ...]] = field(default_factory=dict)

    @property
    def modelled(self) -> tuple[str, ...]:
        """The effects of the model: what was named, of a class the likeliest."""
        return tuple(n for n in self.left_out if "." not in n)

    def to_json(self) -> dict:
        """The rig's entry of diagnosis.json: plain values, null for what there is not (NaN included)."""
        window = self.window and {"axis": self.window.axis, "low": _plain(self.window.low), "high": _plain(self.window.high)}
        return {
            "alarm": self.alarm,
            "p_global": _plain(self.p_global),
            "sectors": [{"name": s.name, "explained": _plain(s.explained), "p": _plain(s.p)} for s in self.sectors],
            "window": window,
            "verdict": self.verdict,
            "names": list(self.names),
            "p_verdict": _plain(self.p_verdict),
            "matters": self.matters,
            "ln_bayes_baseline": _plain(self.ln_bayes_baseline),
            "ln_bayes_runner_up": _plain(self.ln_bayes_runner_up),
            "parameters": {
                name: {"unit": p.unit, "value": _plain(p.value), "low95": _plain(p.low95), "high95": _plain(p.high95)}
                for name, p in self.parameters.items()
            },
            "explanations": [{"effects": list(names), "probability": _plain(p)} for names, p in self.explanations],
            "effects": {
                name: {"probability": _plain(t.probability), "unit": t.unit, **_interval(t.size)}
                | ({"levels": {level: _interval(size) for level, size in t.levels.items()}} if t.levels else {})
                for name, t in self.effects.items()
            },
            "contact_parameters": {
                name: {
                    "unit": "1", "nothing_missing": _interval(m.nothing_missing), "explained": _interval(m.explained),
                    "shift_sds": _plain(m.shift_sds),
                }
                for name, m in self.contact.items()
            },
            "law": self.law,
            "held_out": {
                "rmse_ratio": _plain(self.held_out.rmse_ratio) if self.held_out else None,
                "removed_fraction": _plain(self.held_out.removed_fraction) if self.held_out else None,
            },
            "next_record": self.next_record,
            "recordings": list(self.recordings),
            "notes": list(self.notes),
        }  # fmt: skip


def _plain(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _interval(size) -> dict:
    return {"value": _plain(size.value), "low95": _plain(size.low95), "high95": _plain(size.high95)}


@dataclass(frozen=True, eq=False)
class Question:
    """What a rig hands over: alternatives of its baseline; windows(fit): together they are what nobody listed; curves(base,
    model) for the report; contact: value(explanation) → mean and sd of each contact parameter; law(fit) → in words, of what is
    unlisted; advice(names) → what to record next, of a class; reach(base, model): greatest change of what is seen, over what
    is tolerated."""

    rig: str
    alternatives: tuple[Alternative, ...]
    windows: Callable[[Fit], Windows]
    curves: Callable[[Fit, Fit], tuple[Curve, ...]]
    contact: Mapping[str, Callable[[Explanation], tuple[float, float]]] = field(default_factory=dict)
    law: Callable[[Fit], str | None] = lambda fit: None
    advice: Callable[[tuple[str, ...]], str | None] = lambda names: None
    notes: tuple[str, ...] = ()


def answer(asked: Question, rng: np.random.Generator) -> Finding:
    """The finding of one rig."""
    posterior = explain(asked.alternatives, asked.windows)
    base, p = posterior.base, p_global(posterior, rng)
    verdict = verdict_of(posterior, p)
    chosen = _chosen(posterior, verdict)
    window, collapse = strongest_window(
        base.reduced, base.fit.baseline_sd, base.windows, base.columns, base.table.level_sd, rng
    )
    presence = {n: q for n, q in posterior.presence().items() if _listed(posterior, n)}
    told = {n: told_of(posterior, n) for n, q in presence.items() if q > 0.01}
    contact = {n: moved_of(posterior, value) for n, value in asked.contact.items()}
    found = verdict.verdict != "none"
    nothing, ranked = posterior.probability(()), posterior.by_set()
    best = next((q for names, q in ranked if names), 0.0)
    runner_up = next((q for names, q in ranked if names and set(names) != set(chosen.names)), 0.0)
    parameters = {n: Parameter(told[n].unit, *vars(told[n].size).values()) for n in verdict.names if n in told and told[n].unit}
    return Finding(
        asked.rig, base.fit.problem.recordings, found, p, _sectors(posterior, found, rng), window, collapse, verdict.verdict,
        verdict.names, _ln_odds(best, nothing) if found else math.nan, _ln_odds(posterior.probability(chosen.names), runner_up)
        if found else math.nan, parameters if verdict.verdict == "name" else {},
        asked.law(chosen.fit) if verdict.verdict == "unknown" else None,
        held_out(chosen, base) if found else None,
        asked.advice(verdict.names) if verdict.verdict != "name" else None, verdict.probability,
        found and _matters(contact, verdict.names), tuple(ranked[:MOST_EXPLANATIONS]), told, contact,
        asked.curves(base.fit, chosen.fit), (*asked.notes, *_notes(posterior, verdict, p, nothing)),
        left_out_values(chosen) if found else {},
    )  # fmt: skip


def _listed(posterior: Posterior, name: str) -> bool:
    return any(name in e.listed for e in posterior.explanations)


def _chosen(posterior: Posterior, verdict: Verdict) -> Explanation:
    """The explanation that the verdict is about: of a class the likeliest of it; of nothing the baseline."""
    if verdict.verdict == "none":
        return posterior.base
    if verdict.verdict == "name":
        same = [e for e in posterior.explanations if set(e.names) == set(verdict.names)]
        if same:
            return same[0]
    strange = verdict.verdict == "unknown"
    return next(e for e in posterior.explanations if e.names and bool(e.unlisted) == strange)


def _ln_odds(p: float, q: float) -> float:
    return math.log(max(p, 1e-300)) - math.log(max(q, 1e-300))


def _matters(contact: dict[str, Moved], names: tuple[str, ...]) -> bool:
    """Whether a contact parameter moves by half its sd, or follows a condition; true where the rig has none to look at."""
    return not contact or any("-follows-" in n for n in names) or any(abs(m.shift_sds) >= MATTERS_SDS for m in contact.values())


def _sectors(posterior: Posterior, found: bool, rng: np.random.Generator) -> tuple[Sector, ...]:
    base, shares = posterior.base, sector_shares(posterior)
    names = dict.fromkeys(c.sector for c in base.table.components.values())
    out = [Sector(n, shares.get(n, 0.0) if found else math.nan, p_of(base, rng, n)) for n in names]
    return tuple(sorted(out, key=lambda s: (-np.nan_to_num(s.explained), s.p)))


def _notes(posterior: Posterior, verdict: Verdict, p: float, nothing: float) -> tuple[str, ...]:
    """Of the likeliest alternative; and where alarm and posterior disagree."""
    notes = [posterior.alternatives[posterior.best.alternative].note] if posterior.alternatives[posterior.best.alternative].note else []
    if verdict.verdict == "none" and p < ALARM_P:
        notes.append(f"noise alone makes as great a mismatch with p = {p:.1g}, but nothing listed or unlisted explains it well")
    if verdict.verdict == "none" and p >= ALARM_P and nothing < 0.5:
        likely = " and ".join(next(names for names, _ in posterior.by_set() if names))
        notes.append(f"{likely} is more likely than not ({1 - nothing:.0%}), but noise alone makes as much with p = {p:.2g}")
    return tuple(notes)
