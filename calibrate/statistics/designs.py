"""Response-surface designs as tables: Box–Behnken and central composite, coded and natural, run order drawn.

Sources: Box & Behnken (1960), Technometrics 2, 455–475 (six and seven factors in incomplete blocks of three, not all pairs);
Box & Hunter (1957), Ann. Math. Stat. 28, 195–241 (rotatable); Myers, Montgomery & Anderson-Cook, Response Surface Methodology.
"""

from itertools import combinations, product

import numpy as np
import pandas as pd

from calibrate.statistics.box import Box

# Which factors vary together at ±1 while the others stand at 0 (counted from 0).
BEHNKEN_BLOCKS = {
    **{k: tuple(combinations(range(k), 2)) for k in (3, 4, 5)},
    6: ((0, 1, 3), (1, 2, 4), (2, 3, 5), (0, 3, 4), (1, 4, 5), (0, 2, 5)),
    7: ((3, 4, 5), (0, 5, 6), (1, 4, 6), (0, 1, 3), (2, 3, 6), (0, 2, 4), (1, 2, 5)),
}


def box_behnken(box: Box, *, centre_points: int, rng: np.random.Generator | None = None) -> pd.DataFrame:
    """Box–Behnken design for 3–7 factors: 12, 24, 40, 48, 56 runs, and the stated number of centre points.

    Table: run (1 … n, the order to run in), standard (order in the book), point (edge | centre), block (runs that may share a
    packing, here those that vary the same factors; −1 at the centre), `<name>_coded`, `<name>`.
    `rng` draws the run order; None keeps the standard one. Raises ValueError for another number of factors or centre points < 1.
    """
    k = len(box.names)
    if k not in BEHNKEN_BLOCKS:
        raise ValueError(f"a Box–Behnken design is published for 3 to 7 factors; here are {k}: {', '.join(box.names)}")
    _some_centre(centre_points)
    edges, blocks = [], []
    for number, block in enumerate(BEHNKEN_BLOCKS[k]):
        for signs in product((-1.0, 1.0), repeat=len(block)):
            point = np.zeros(k)
            point[list(block)] = signs
            edges.append(point)
            blocks.append(number)
    return _table(box, {"edge": np.array(edges), "centre": np.zeros((centre_points, k))}, blocks, rng)


def central_composite(
    box: Box, *, centre_points: int, alpha: str = "rotatable", half_fraction: bool = False, inscribed: bool = False,
    rng: np.random.Generator | None = None,
) -> pd.DataFrame:  # fmt: skip
    """Central composite design for 2–8 factors: F factorial points, 2k axial points at ±α, centre points.

    alpha: "rotatable" F^¼; "face" 1; "orthogonal" (F (√N − √F)²/4)^¼, N = all runs, which makes the centred squares orthogonal.
    half_fraction: 2^(k−1) factorial points, the last factor being the product of the others (5 or more factors, resolution V).
    inscribed: all points shrunk by α, so that none leaves the box (a friction below zero cannot be simulated).
    Table as in `box_behnken`, point: factorial | axial | centre; blocks: two halves of the factorial, by the product of its
    signs, and the axial points, main effects being clear of blocks. Raises ValueError for another alpha or too few factors.
    """
    k = len(box.names)
    if not 2 <= k <= 8:
        raise ValueError(f"a central composite design needs 2 to 8 factors; here are {k}")
    if half_fraction and k < 5:
        raise ValueError(f"half_fraction needs 5 factors or more, else interactions are confounded; here are {k}")
    _some_centre(centre_points)
    cube = np.array(list(product((-1.0, 1.0), repeat=k - half_fraction)))
    if half_fraction:
        cube = np.column_stack([cube, cube.prod(axis=1)])
    reach = _axial(alpha, len(cube), len(cube) + 2 * k + centre_points)
    axial = np.vstack([s * reach * row for row in np.eye(k) for s in (-1, 1)])
    shrink = max(reach, 1.0) if inscribed else 1.0
    halves = (cube.prod(axis=1) > 0).astype(int) if not half_fraction else np.zeros(len(cube), int)
    blocks = [*halves, *[halves.max() + 1] * len(axial)]
    return _table(box, {"factorial": cube / shrink, "axial": axial / shrink, "centre": np.zeros((centre_points, k))}, blocks, rng)


def _axial(alpha: str, factorial: int, runs: int) -> float:
    """Distance of the axial points from the centre, coded."""
    if alpha == "rotatable":
        return factorial**0.25
    if alpha == "face":
        return 1.0
    if alpha == "orthogonal":
        return (factorial * (np.sqrt(runs) - np.sqrt(factorial)) ** 2 / 4) ** 0.25
    raise ValueError(f"alpha: rotatable, face or orthogonal, not {alpha!r}")


def _some_centre(centre_points: int) -> None:
    if centre_points < 1:
        raise ValueError(f"centre_points: at least 1, and 3 or more to see the noise; here {centre_points}")


def _table(box: Box, points: dict[str, np.ndarray], blocks: list[int], rng: np.random.Generator | None) -> pd.DataFrame:
    coded = np.vstack(list(points.values()))
    n = len(coded)
    table = pd.DataFrame({"standard": np.arange(1, n + 1), "point": np.repeat(list(points), [len(p) for p in points.values()])})
    table["block"] = np.r_[blocks, np.full(n - len(blocks), -1)].astype(int)
    for j, name in enumerate(box.names):
        table[f"{name}_coded"] = coded[:, j]
    # natural values are rounded to 12 digits: 0.55 is written 0.55 and not 0.5499999999999999 in the inputs that are hashed
    for j, name in enumerate(box.names):
        table[name] = [float(f"{v:.12g}") for v in box.natural(coded)[:, j]]
    table.insert(0, "run", np.arange(1, n + 1) if rng is None else rng.permutation(n) + 1)
    return table.sort_values("run", ignore_index=True)
