"""Where on a heap's slope its line is fitted, in pictures as in simulations."""

import numpy as np

LEAST_POINTS, MOST_ROUNDS = 16, 30  # of a slope; until line and points agree


def line_window(
    x: np.ndarray, height: np.ndarray, side: np.ndarray, low: float, high: float
) -> np.ndarray | None:
    """The points (n,) of one side over which their own least-squares line lies between
    the heights `low` and `high`; None where they are fewer than LEAST_POINTS.

    x, height (n,): the outline, in one unit; side (n,): which points are that side's.
    The line is fitted to them and they are chosen by it in turn until both agree.
    Points are not chosen by their own height: that would cut the bumps off at both ends
    and flatten the line. Nor by a curve's: it follows single seeds and the round crest,
    by which angles of heaps of few seeds are half a degree too low."""
    inside = side & (height > low) & (height < high)
    for _ in range(MOST_ROUNDS):
        if inside.sum() < LEAST_POINTS:
            return None
        line = np.polynomial.Polynomial.fit(x[inside], height[inside], 1)(x)
        before, inside = inside, side & (line > low) & (line < high)
        if (inside == before).all():
            break
    return inside if inside.sum() >= LEAST_POINTS else None
