"""Designs as tables in natural units: space-filling, and Box and Behnken's in coded
units beside them, in the order of the books.

Sources: Box & Behnken (1960), Technometrics 2, 455–475; scipy.stats.qmc."""

from itertools import combinations, product

import numpy as np
import pandas as pd
from scipy.stats import qmc

from benchtwin.bench.language import tr
from benchtwin.calibrate.statistics.box import Box

SIGNS = (-1.0, 1.0)
STANDARD = 1  # seed of the space-filling design: the same runs for every bench


def space_filling(box: Box, runs: int, *, two_level: int = 0) -> pd.DataFrame:
    """Latin hypercube of low discrepancy over the box, a column a factor.

    The last `two_level` factors stand low or high, half of the runs each: what is
    linear in them is told by the ends."""
    drawn = qmc.LatinHypercube(
        len(box.names), optimization="random-cd", rng=np.random.default_rng(STANDARD)
    ).random(runs)
    coded = 2 * drawn - 1
    if two_level:
        coded[:, -two_level:] = np.sign(coded[:, -two_level:])
    return pd.DataFrame(_digits(box.natural(coded), 6), columns=list(box.names))


def box_behnken(box: Box, *, centre_points: int) -> pd.DataFrame:
    """Box–Behnken design for 3 to 5 factors: 12, 24, 40 runs, and the stated number of
    centre points.

    Table: standard (1 … n), point ("edge", "centre"), `<name>_coded`, `<name>`. Raises
    ValueError for another number of factors, or no centre point."""
    k = len(box.names)
    if not 3 <= k <= 5:
        raise ValueError(
            tr("a Box–Behnken design of pairs has 3 to 5 factors; here are {}", k)
        )
    if centre_points < 1:
        raise ValueError(
            tr(
                "centre_points: at least 1, and 3 or more to see the noise; here {}",
                centre_points,
            )
        )
    coded = np.zeros((2 * k * (k - 1) + centre_points, k))
    edges = product(combinations(range(k), 2), product(SIGNS, repeat=2))
    for row, (pair, signs) in zip(coded, edges):
        row[list(pair)] = signs
    table = pd.DataFrame({"standard": np.arange(1, len(coded) + 1)})
    table["point"] = np.where(coded.any(axis=1), "edge", "centre")
    # natural values are rounded: 0.55 is written 0.55 and not 0.5499999999999999 in the
    # inputs that are hashed
    natural = _digits(box.natural(coded), 12)
    names = [f"{name}_coded" for name in box.names]
    return table.assign(**dict(zip(names, coded.T)), **dict(zip(box.names, natural.T)))


def _digits(values: np.ndarray, digits: int) -> np.ndarray:
    return np.vectorize(lambda v: float(f"{v:.{digits}g}"))(values)
