"""The path of steepest ascent and the choice of a centre from it (the paper's Eq. 4,
Table 7)."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from benchtwin.bench.language import tr
from benchtwin.calibrate.statistics.box import Box


def equal_steps(box: Box, steps: int) -> pd.DataFrame:
    """The paper's path: every factor from its low to its high in `steps` equal steps at
    once. Columns group (1 …) and the factors.

    Raises ValueError for fewer than 3 steps: the centre needs a neighbour on either
    side."""
    if steps < 3:
        raise ValueError(tr("steps: at least 3, not {}", steps))
    path = np.linspace(box.low, box.high, steps)
    table = pd.DataFrame(path, columns=list(box.names))
    table = table.map(lambda v: float(f"{v:.12g}"))
    table.insert(0, "group", np.arange(1, steps + 1))
    return table


def relative_error(simulated: ArrayLike, bench: float) -> np.ndarray:
    """τ = |θ₂ − θ₁|/θ₁ (Eq. 4), a fraction; simulated θ₂, bench θ₁. Raises ValueError
    where the bench's value is zero."""
    if bench == 0:
        raise ValueError(tr("bench: a relative error needs a value other than zero"))
    return np.abs(np.asarray(simulated, dtype=float) - bench) / abs(bench)


@dataclass(frozen=True, eq=False)
class Centre:
    """The path's group nearest to the bench, and the levels around it.

    group: of the smallest relative error; levels: columns coded (−1, 0, 1), group and
    the factors; errors: the path with relative_error; notes: a centre at the end of the
    path, a bench value the path does not bracket, a tie within the noise; crossing: the
    factors where the path meets the bench (`crossing`), None where it does not."""

    group: int
    levels: pd.DataFrame
    errors: pd.DataFrame
    notes: tuple[str, ...]
    crossing: dict[str, float] | None = None


def choose_centre(
    path: pd.DataFrame,
    response: str,
    bench: float,
    factors: tuple[str, ...],
    *,
    noise_sd: float = 0.0,
) -> Centre:
    """Centre of the next design: the group with the smallest relative error, its
    neighbours as −1 and +1.

    At an end of the path the three last groups are taken and the note says to lengthen
    the path. noise_sd: scatter of one run; groups whose errors differ by less than two
    of it are named as tied. Raises ValueError: columns missing, fewer than 3 groups.
    """
    values = path[[response, *factors]].to_numpy(float)
    if len(path) < 3:
        raise ValueError(tr("path: at least 3 groups, not {}", len(path)))
    error = relative_error(values[:, 0], bench)
    errors = path.assign(relative_error=error)
    group = _groups(path)
    best = int(np.argmin(error))
    notes = []
    if best in (0, len(path) - 1):
        notes.append(
            tr(
                "group {} is an end of the path: lengthen it beyond {}",
                group[best],
                tr("its start") if best == 0 else tr("its end"),
            )
        )
    least, most = values[:, 0].min(), values[:, 0].max()
    if not least <= bench <= most:
        notes.append(
            tr(
                "the path does not bracket the bench's {:g}: it spans {:g} to {:g}",
                bench,
                least,
                most,
            )
        )
    rival = [
        str(g)
        for g, e in zip(group, error)
        if g != group[best] and abs(e - error[best]) * abs(bench) < 2 * noise_sd
    ]
    if rival:
        notes.append(
            tr(
                "within the noise group {} is as near as group {}",
                ", ".join(rival),
                group[best],
            )
        )
    middle = int(np.clip(best, 1, len(path) - 2))
    rows = slice(middle - 1, middle + 2)
    levels = {f: path[f].to_numpy()[rows] for f in factors}
    levels = {"coded": [-1, 0, 1], "group": group[rows], **levels}
    meets = crossing(path, response, bench, factors)
    return Centre(int(group[best]), pd.DataFrame(levels), errors, tuple(notes), meets)


def _groups(path: pd.DataFrame) -> np.ndarray:
    """The groups' numbers, 1 … where the path does not state them."""
    numbered = "group" in path
    return path["group"].to_numpy() if numbered else np.arange(1, len(path) + 1)


def crossing(
    path: pd.DataFrame, response: str, bench: float, factors: tuple[str, ...]
) -> dict[str, float] | None:
    """Where the path meets the bench, by a straight line through the response of all
    groups; None where that is outside the path.

    A first answer, before any design. Packing noise moves the line less than any one
    group. Valid for a path of equal steps over which the response bends little."""
    steps = np.arange(len(path), dtype=float)
    slope, start = np.polyfit(steps, path[response].to_numpy(float), 1)
    at = (bench - start) / slope if slope else np.nan
    if not 0 <= at <= steps[-1]:
        return None
    return {f: float(np.interp(at, steps, path[f])) for f in factors}
