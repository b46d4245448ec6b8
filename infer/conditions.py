"""What differs between recordings: stated conditions, their order, the session; and a
problem in which a contact parameter follows some of it."""

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.infer.effect import Effect
from benchtwin.infer.linear import Reduced
from benchtwin.infer.problem import Problem

CONFOUNDED_CORRELATION = 0.98  # from which two conditions cannot be told apart
MOST_LEVELS = 6
TIMES_SD = 10.0  # prior of how many times a shift that was found is there: near 1


@dataclass(frozen=True)
class Contact:
    """A contact parameter."""

    name: str  # as reported
    column: str  # its global
    scale: float  # from the global's unit to the reported one
    sector: str


@dataclass(frozen=True)
class Condition:
    """What differs between recordings."""

    name: str
    values: dict[str, float]  # number, or place in `levels`, of those that state it
    levels: tuple[str, ...] = ()  # of words
    unlisted: bool = False  # it says when, not why

    def of(self, recordings: tuple[str, ...]) -> np.ndarray:
        """(R,): of these recordings, NaN where not stated."""
        return np.array([self.values.get(r, np.nan) for r in recordings])

    def columns(self, recordings: tuple[str, ...]) -> np.ndarray:
        """(R, k): numbers (k = 1) or membership of levels, standardised or of mean 0; 0
        where not stated."""
        values = self.of(recordings)
        seen = np.isfinite(values)
        out = values[:, None]
        if self.levels:
            out = (out == np.arange(len(self.levels))) * 1.0
        out = np.where(seen[:, None], out - out[seen].mean(0), 0.0)
        return out if self.levels else out / max(float(out[seen].std()), 1e-300)


def conditions_of(
    recordings: tuple[str, ...], descriptions: list[dict], sessions: list[str]
) -> tuple[tuple[Condition, ...], tuple[str, ...]]:
    """What differs between recordings, and notes on what cannot be used or told
    apart."""
    stated = [d.get("conditions", {}) for d in descriptions]
    found, notes = [], []
    for key in dict.fromkeys(k for s in stated for k in s):
        values = [s.get(key) for s in stated]
        made = condition(key, recordings, values)
        if made is None:
            said = tr(
                "is the same in all recordings that state it: nothing can follow it"
            )
            notes.append(f"[conditions] {key} {said}")
        else:
            found.append(made)
            if missing := sum(v is None for v in values):
                said = tr("is not stated in {} of {} recordings", missing, len(values))
                notes.append(
                    tr("[conditions] {} {}; it is used where it is", key, said)
                )
    order = condition("order", recordings, list(range(len(recordings))))
    kept = []
    for extra in filter(None, (order, condition("session", recordings, sessions))):
        same = next((c for c in found if _confounded(c, extra, recordings)), None)
        if same is None:
            kept.append(replace(extra, unlisted=True))
        else:
            said = tr(
                "goes with the {} of the recordings: the two cannot be told apart",
                extra.name,
            )
            notes.append(f"[conditions] {same.name} {said}")
    for one, other in combinations(found, 2):
        if _confounded(one, other, recordings):
            said = tr("go together: the two cannot be told apart")
            notes.append(tr("[conditions] {} and {} {}", one.name, other.name, said))
    return (*found, *kept), tuple(notes)


def condition(name: str, recordings: tuple[str, ...], values: list) -> Condition | None:
    """From each recording's number or word, None where not stated; None where nothing
    can follow it."""
    pairs = [p for p in zip(recordings, values, strict=True) if p[1] is not None]
    if any(isinstance(v, str) for _, v in pairs):
        levels = tuple(dict.fromkeys(str(v) for _, v in pairs))
        if not 2 <= len(levels) <= MOST_LEVELS:
            return None
        return Condition(name, {r: levels.index(str(v)) for r, v in pairs}, levels)
    numbers = {r: float(v) for r, v in pairs}
    if len(numbers) < 3 or len(set(numbers.values())) < 2:
        return None
    return Condition(name, numbers)


def _confounded(one: Condition, other: Condition, recordings: tuple[str, ...]) -> bool:
    """Whether one condition is nearly a linear function of the other."""
    both = np.isfinite(one.of(recordings)) & np.isfinite(other.of(recordings))
    if both.sum() < 3:
        return False
    z, other_z = one.columns(recordings)[both], other.columns(recordings)[both]
    basis = np.linalg.qr(np.hstack([np.ones((len(z), 1)), other_z]))[0]
    about = z - z.mean(0)
    left = about - basis @ (basis.T @ about)
    return float((left**2).sum()) < (1 - CONFOUNDED_CORRELATION**2) * float(
        (about**2).sum()
    )


def effect_name(contact: Contact, name: str) -> str:
    """Name of the effect that a contact parameter follows a condition."""
    return f"{contact.name}-follows-{name}"


def with_follows(
    problem: Problem, contact: Contact, shifts: dict[str, np.ndarray]
) -> Problem:
    """The problem with one global β more for each of `shifts`, (R,) by name: recording
    r's contact parameter is shifted by β shift_r. β is 0 where a prediction is made:
    recordings' own parameters take it up."""
    if not shifts:
        return problem
    z, base = np.column_stack(list(shifts.values())), len(problem.names)
    column = problem.names.index(contact.column)

    def reduce(starts: np.ndarray, values: np.ndarray, extra=None, **how):
        made, change = problem.reduce(starts, values[:base], extra, **how)
        there = bool(values[base:].any())  # χ² there is without β
        widened = tuple(_widened(m, z[r], there) for r, m in enumerate(made))
        return widened, lambda moved: change(moved[..., :base])

    def _widened(one: Reduced, own: np.ndarray, there: bool) -> Reduced:
        a = np.hstack([one.a[:, :base], one.a[:, [column]] * own, one.a[:, base:]])
        return replace(one, a=a, chi2=None if there else one.chi2)

    further = tuple(
        (s, np.append(v, np.zeros(len(shifts)))) for s, v in problem.further_starts
    )
    one_more = problem.with_effect

    def with_effect(effect: Effect) -> Problem:
        assert one_more is not None
        return with_follows(one_more(effect), contact, shifts)

    return replace(
        problem,
        names=(*problem.names, *shifts),
        known_sd=problem.known_sd | dict.fromkeys(shifts, TIMES_SD),
        with_effect=with_effect,
        reduce=reduce,
        fast_chi2=None,
        followed=tuple(shifts),
        further_starts=further,
    )
