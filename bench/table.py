"""A function as values at even points, straight lines between them: what compiled code
can be handed in place of a function."""

from typing import NamedTuple

import numpy as np
from numba import njit


class Table(NamedTuple):
    """Values (m,) at low, low + step, …; constant beyond both ends."""

    low: float
    step: float
    values: np.ndarray


NOTHING = Table(0.0, 1.0, np.zeros(1))


def over(grid: np.ndarray, values: np.ndarray) -> Table:
    """Values (m,) over an even grid (m,)."""
    return Table(float(grid[0]), float(grid[1] - grid[0]), np.asarray(values, float))


def total(one: Table, other: Table) -> Table:
    """The sum of two, at the points of the first, or of the other where the first has
    only one."""
    if len(one.values) < 2:
        return other._replace(values=other.values + one.values[0])
    if len(other.values) < 2:
        return one._replace(values=one.values + other.values[0])
    grid, known = (t.low + t.step * np.arange(len(t.values)) for t in (one, other))
    return one._replace(values=one.values + np.interp(grid, known, other.values))


@njit(cache=True, error_model="numpy", boundscheck=False)
def look(at: float, table: Table) -> float:
    """The value at a point.

    >>> look(0.25, Table(0.0, 0.5, np.array([1.0, 3.0])))
    2.0
    """
    values = table.values
    last = len(values) - 1
    if last == 0:
        return values[0]
    u = (at - table.low) / table.step
    if u <= 0:
        return values[0]
    if u >= last:
        return values[last]
    i = int(u)
    return values[i] + (u - i) * (values[i + 1] - values[i])
