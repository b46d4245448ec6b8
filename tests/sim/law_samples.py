"""Arguments for every force law, spread over its range with the ends included; used by
the tests of laws."""

import inspect
import math

import numpy as np

from benchtwin.sim.laws import LAWS, contract, hertz_mindlin
from benchtwin.sim.laws.contract import EITHER_SPEED, FORCE, MODULUS, RADIUS

FIXED = {kind: [*ranges.values()] for kind, ranges in contract.FIXED.items()}

# The core of every contact: not laws to choose, but held to the same rules.
CORE = {
    hertz_mindlin.damping_factor: [(0.0, 1.0)],
    hertz_mindlin.normal_stiffness: [(0.0, 1e-3), RADIUS, MODULUS],
    hertz_mindlin.elastic_force: [(0.0, 1e9), (0.0, 1e-3)],
    hertz_mindlin.damping_force: [
        (0.0, 1e9),
        EITHER_SPEED,
        (1e-9, 10.0),
        (0.0, 1.83),
    ],
    hertz_mindlin.tangential_force: [
        *[(-1e-4, 1e-4)] * 3,
        *[(0.57735, 0.57736)] * 3,
        *[EITHER_SPEED] * 3,
        (1e-7, 1e-4),
        (0.0, 1e9),
        (1e-9, 10.0),
        (0.0, 1.83),
        FORCE,
    ],
}


def functions() -> list[tuple[str, object, list[tuple[float, float]]]]:
    """Every scalar function that a kernel may call: (name, function, a range for each
    argument)."""
    rows = [(f.__name__, f, ranges) for f, ranges in CORE.items()]
    for law in LAWS.values():
        own = [(p.low, p.high) for p in law.parameters]
        kept = [(p.low, p.high) for p in law.memory]
        rows.append((law.name, law.function, FIXED[law.kind] + kept + own))
        if law.reach is not None:
            rows.append((f"{law.name}.reach", law.reach, [RADIUS, MODULUS, *own]))
    return rows


def samples(
    ranges: list[tuple[float, float]], n: int, rng: np.random.Generator
) -> np.ndarray:
    """Rows of arguments (n, len(ranges)): all lows, all highs, the rest at random, a
    tenth of the values at an end."""
    table = np.empty((n, len(ranges)))
    for column, (low, high) in enumerate(ranges):
        if low >= 0.0 and high > 1e3 * max(low, 1e-12):
            floor = max(low, high * 1e-9)
            values = np.exp(rng.uniform(math.log(floor), math.log(high), n))
        else:
            values = rng.uniform(low, high, n)
        ends = rng.random(n)
        table[:, column] = np.where(
            ends < 0.05, low, np.where(ends > 0.95, high, np.clip(values, low, high))
        )
    table[0], table[1] = [low for low, _ in ranges], [high for _, high in ranges]
    return table


def arity(function) -> int:
    return len(inspect.signature(function).parameters)
