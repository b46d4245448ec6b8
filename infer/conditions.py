"""Contact parameters that follow stated conditions, the order of recordings, or the
session.

A parameter p of recording r is p + β z_r, z the condition with mean 0 and sd 1 over the
recordings that state it (0 in the others); for words one β a level. The column of β is
z_r times that of p."""

from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np
from benchtwin.infer.effect import Effect
from benchtwin.infer.least_squares import FastChi2
from benchtwin.infer.linear import Reduced
from benchtwin.infer.problem import Problem

CONFOUNDED_CORRELATION = 0.98  # from which two conditions cannot be told apart
MOST_LEVELS = 6


@dataclass(frozen=True)
class Contact:
    """A contact parameter."""

    name: str  # as reported
    column: str  # its global
    prior_sd: float  # of its change by one sd of a condition, in the global's unit
    scale: float  # from the global's unit to the reported one
    sector: str


@dataclass(frozen=True, eq=False)
class Condition:
    """What differs between recordings."""

    name: str
    z: np.ndarray  # (R, k): standardised numbers (k = 1), or contrasts of levels
    spread: float  # sd of the numbers, NaN for words
    levels: tuple[str, ...] = ()  # of words
    unlisted: bool = False  # it says when, not why


def conditions_of(
    descriptions: list[dict], sessions: list[str]
) -> tuple[tuple[Condition, ...], tuple[str, ...]]:
    """What differs between recordings, and notes on what cannot be used or told
    apart."""
    stated = [d.get("conditions", {}) for d in descriptions]
    found, notes = [], []
    for key in dict.fromkeys(k for s in stated for k in s):
        values = [s.get(key) for s in stated]
        if any(isinstance(v, str) for v in values):
            made = _of_words(key, values)
        else:
            made = _of_numbers(key, values)
        if made is None:
            said = "is the same in all recordings that state it: nothing can follow it"
            notes.append(f"[conditions] {key} {said}")
        else:
            found.append(made)
            if missing := sum(v is None for v in values):
                said = f"is not stated in {missing} of {len(values)} recordings"
                notes.append(f"[conditions] {key} {said}; it is used where it is")
    if len(descriptions) > 3:
        order = _of_numbers("order", list(range(len(descriptions))))
    else:
        order = None
    kept = []
    for extra in filter(None, (order, _of_words("session", list(sessions)))):
        same = next((c for c in found if _confounded(c, extra)), None)
        if same is None:
            kept.append(replace(extra, unlisted=True))
        else:
            said = (
                f"goes with the {extra.name} of the recordings: the two cannot be told"
                " apart"
            )
            notes.append(f"[conditions] {same.name} {said}")
    for one, other in combinations(found, 2):
        if _confounded(one, other):
            said = "go together: the two cannot be told apart"
            notes.append(f"[conditions] {one.name} and {other.name} {said}")
    return (*found, *kept), tuple(notes)


def _of_numbers(name: str, values: list) -> Condition | None:
    numbers = np.array([np.nan if v is None else float(v) for v in values])
    seen = np.isfinite(numbers)
    if seen.sum() < 3 or np.ptp(numbers[seen]) <= 0:
        return None
    spread = float(numbers[seen].std())
    z = np.where(seen, (numbers - numbers[seen].mean()) / spread, 0.0)
    return Condition(name, z[:, None], spread)


def _of_words(name: str, values: list) -> Condition | None:
    words = [None if v is None else str(v) for v in values]
    levels = tuple(dict.fromkeys(w for w in words if w is not None))
    if not 2 <= len(levels) <= MOST_LEVELS:
        return None
    member = np.array([[w == level for level in levels] for w in words], dtype=float)
    seen = member.sum(1) > 0
    mean = np.where(seen[:, None], member[seen].mean(0), 0.0)
    return Condition(name, member - mean, float("nan"), levels)


def _confounded(one: Condition, other: Condition) -> bool:
    """Whether one condition is nearly a linear function of the other."""
    basis = np.linalg.qr(np.hstack([np.ones((len(one.z), 1)), other.z]))[0]
    about = one.z - one.z.mean(0)
    left = about - basis @ (basis.T @ about)
    return float((left**2).sum()) < (1 - CONFOUNDED_CORRELATION**2) * float(
        (about**2).sum()
    )


def effect_name(contact: Contact, condition: Condition) -> str:
    """Name of the effect that a contact parameter follows a condition."""
    return f"{contact.name}-follows-{condition.name}"


def with_conditions(
    problem: Problem, contact: Contact, conditions: tuple[Condition, ...]
) -> Problem:
    """The problem with one effect a condition, linear: β is 0 where a prediction is
    made."""
    if not conditions or contact.column not in problem.names:
        return problem
    new = {effect.name: effect for c in conditions for effect in _effects(contact, c)}
    z, base = np.hstack([c.z for c in conditions]), len(problem.names)
    column = problem.names.index(contact.column)

    def widened(made: tuple[Reduced, ...], there: bool) -> tuple[Reduced, ...]:
        out = []
        for r, one in enumerate(made):
            a = np.hstack([one.a[:, :base], one.a[:, [column]] * z[r], one.a[:, base:]])
            # χ² there is without β
            out.append(replace(one, a=a, chi2=None if there else one.chi2))
        return tuple(out)

    def reduce(starts: np.ndarray, values: np.ndarray, extra=None):
        made, change = problem.reduce(starts, values[:base], extra)

        def changed(moved: np.ndarray) -> np.ndarray:
            shift = np.tile(moved[:base], (len(made), 1))
            shift[:, column] += z @ (values + moved)[base:]
            return change(shift)

        return widened(made, bool(values[base:].any())), changed

    inner: Any = problem.fast_chi2  # for fits in which nothing follows a condition

    def reduce_free(starts, values, wanted):
        made, change = inner.reduce_free(starts, values[:base], wanted[:base])
        return widened(made, False), lambda moved: change(moved[:base])

    fast = inner and FastChi2(
        lambda starts, at: inner.chi2(starts, at[:base]), reduce_free
    )
    further = tuple(
        (s, np.append(v, np.zeros(z.shape[1]))) for s, v in problem.further_starts
    )
    further_effect: Any = problem.with_effect

    def with_effect(effect: Effect) -> Problem:
        return with_conditions(further_effect(effect), contact, conditions)

    return replace(
        problem,
        effects=problem.effects | new,
        names=(*problem.names, *new),
        with_effect=with_effect,
        reduce=reduce,
        fast_chi2=fast,
        further_starts=further,
    )


def _effects(contact: Contact, c: Condition) -> list[Effect]:
    name = effect_name(contact, c)
    unit = f"1/{c.name.rsplit('_', 1)[-1]}" if "_" in c.name else f"1/{c.name}"

    def shown(value: float) -> float:
        return value * contact.scale / c.spread

    about: dict[str, Any] = {
        "sector": contact.sector,
        "prior_sd": contact.prior_sd,
        "low": -np.inf,
        "high": np.inf,
        "follows": c.name,
        "unlisted": c.unlisted,
        "source": "by rule: whatever the recordings state may matter",
    }
    if not c.levels:
        return [
            Effect(
                name, unit=unit, meaning=f"slope on {c.name}", reported=shown, **about
            )
        ]
    return [
        Effect(
            f"{name}.{level}" if k else name,
            unit="1",
            meaning=f"at {level}, beside the mean",
            group=name if k else "",
            reported=lambda value: value * contact.scale,
            level=level,
            **about,
        )
        for k, level in enumerate(c.levels)
    ]
