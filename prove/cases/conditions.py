"""What recordings state as [conditions]: numbers and words that do nothing, and the one
that a contact parameter follows."""

from dataclasses import dataclass, replace

import numpy as np

NUMBERS = {  # name with its unit → least, most, digits
    "moisture_pct": (8.0, 20.0, 1),
    "pressure_mbar": (980.0, 1030.0, 0),
    "humidity_pct": (30.0, 70.0, 0),
    "temperature_c": (16.0, 30.0, 1),
    "age_d": (1.0, 60.0, 0),
    "stored_h": (1.0, 48.0, 0),
}
WORDS = {
    "plate": ("A", "B", "C"),
    "operator": ("JM", "TK", "RB"),
    "lot": ("north", "south", "mixed"),
}
# of benches that state one, a second; of idle ones
SHARE = 0.45
SECOND = 0.3
CONSTANT = 0.15
IN_ORDER = 0.1
PARTLY = 0.15
TRIES = 40


@dataclass(frozen=True)
class Condition:
    """What recordings state as one of their conditions."""

    name: str
    values: tuple[float | str | None, ...]  # of each recording, None where not stated
    follows: tuple[float, ...]  # (n,): scaled to −1 … 1
    per: float | None  # how much of its unit is 1 on that scale, None for words

    @property
    def unit(self) -> str | None:
        return None if self.per is None else f"1/{self.name.rsplit('_', 1)[1]}"


def draw_conditions(
    design: np.ndarray, matters: bool, clean: bool, rng: np.random.Generator
) -> tuple[Condition, ...]:
    """What a bench states beside its design (n, k); what matters stands first."""
    names = [str(name) for name in rng.permutation([*NUMBERS, *WORDS])][
        : 1 + (rng.random() < SECOND)
    ]
    if not matters and rng.random() > SHARE:
        return ()
    out: list[Condition] = []
    for name in names:
        beside = np.column_stack([design, *(c.follows for c in out)])
        drawn = [_drawn(name, len(design), rng) for _ in range(1 if clean else TRIES)]
        best = min(drawn, key=lambda one: _likeness(one.follows, beside))
        out.append(best if matters and not out else _idle(best, clean, rng))
    return tuple(out)


def _drawn(name: str, count: int, rng: np.random.Generator) -> Condition:
    """A condition that is set anew for each recording, or alternates between two or
    three levels."""
    kinds = int(rng.integers(2, 4)) if name in WORDS or rng.random() < 0.6 else count
    level = rng.permutation(np.arange(count) % kinds)
    place = np.sort(np.r_[-1.0, 1.0, rng.uniform(-0.9, 0.9, kinds - 2)])
    if name in WORDS:
        place = rng.permutation(place)
        return Condition(
            name,
            tuple(WORDS[name][k] for k in level),
            tuple(place[level].tolist()),
            None,
        )
    low, high, digits = NUMBERS[name]
    half = rng.uniform(0.2, 0.5) * (high - low)
    middle = rng.uniform(low + half, high - half)
    values = np.round(middle + half * place[level], digits)
    follows = tuple(((values - middle) / half).tolist())
    return Condition(name, tuple(values.tolist()), follows, float(half))


def _idle(one: Condition, clean: bool, rng: np.random.Generator) -> Condition:
    """As benches state what does nothing: the same all along, in order, or in some
    recordings only."""
    values, kind = one.values, rng.random()
    if kind < CONSTANT:
        values = (values[0],) * len(values)
    elif kind < CONSTANT + IN_ORDER and clean:
        values = tuple(np.sort(np.array(values)).tolist())
    elif kind < CONSTANT + IN_ORDER + PARTLY:
        values = tuple(None if rng.random() < 0.4 else value for value in values)
    return replace(one, values=values)


def _likeness(follows: tuple[float, ...], beside: np.ndarray) -> float:
    """The largest correlation with a column."""
    a, b = np.asarray(follows) - np.mean(follows), beside - beside.mean(axis=0)
    size = np.linalg.norm(a) * np.linalg.norm(b, axis=0)
    return float(np.max(np.abs(a @ b) / np.where(size > 0, size, np.inf), initial=0.0))
