"""Response-surface designs as tables, coded and natural, in the order of the books.

Sources: Box & Behnken (1960), Technometrics 2, 455–475; Myers, Montgomery &
Anderson-Cook, Response Surface Methodology (4th ed.), chapter 8 (face-centred: axial
points at ±1, so that none leaves the box)."""

from itertools import combinations, product

import numpy as np
import pandas as pd

from benchtwin.calibrate.statistics.box import Box

SIGNS = (-1.0, 1.0)


def box_behnken(box: Box, *, centre_points: int) -> pd.DataFrame:
    """Box–Behnken design for 3 to 5 factors: 12, 24, 40 runs, and the stated number of
    centre points.

    Table: standard (1 … n), point ("edge", "centre"), block (runs that may share a
    packing, here those that vary the same two factors; −1 at the centre),
    `<name>_coded`, `<name>`. Raises ValueError for another number of factors, or no
    centre point."""
    k = len(box.names)
    if not 3 <= k <= 5:
        raise ValueError(
            f"a Box–Behnken design of pairs has 3 to 5 factors; here are {k}"
        )
    edges, blocks = [], []
    for number, pair in enumerate(combinations(range(k), 2)):
        for signs in product(SIGNS, repeat=2):
            point = np.zeros(k)
            point[list(pair)] = signs
            edges.append(point)
            blocks.append(number)
    return _table(box, {"edge": np.array(edges)}, blocks, centre_points)


def central_composite(box: Box, *, centre_points: int) -> pd.DataFrame:
    """Face-centred central composite design: 2^k factorial, 2k axial and the stated
    centre points.

    Table as in `box_behnken`, point: "factorial", "axial", "centre"; blocks: two halves
    of the factorial, by the product of its signs, and the axial points: main effects
    are clear of blocks. Raises ValueError without a centre point."""
    k = len(box.names)
    cube = np.array(list(product(SIGNS, repeat=k)))
    axial = np.vstack([sign * row for row in np.eye(k) for sign in SIGNS])
    blocks = [*(cube.prod(axis=1) > 0).astype(int), *[2] * len(axial)]
    return _table(box, {"factorial": cube, "axial": axial}, blocks, centre_points)


def _table(
    box: Box, points: dict[str, np.ndarray], blocks: list[int], centre: int
) -> pd.DataFrame:
    if centre < 1:
        raise ValueError(
            f"centre_points: at least 1, and 3 or more to see the noise; here {centre}"
        )
    points = points | {"centre": np.zeros((centre, len(box.names)))}
    coded = np.vstack(list(points.values()))
    kinds = np.repeat(list(points), [len(p) for p in points.values()])
    table = pd.DataFrame({"standard": np.arange(1, len(coded) + 1), "point": kinds})
    table["block"] = np.r_[blocks, np.full(centre, -1)].astype(int)
    coded_names = [f"{name}_coded" for name in box.names]
    # natural values are rounded to 12 digits: 0.55 is written 0.55 and not
    # 0.5499999999999999 in the inputs that are hashed
    natural = np.vectorize(lambda v: float(f"{v:.12g}"))(box.natural(coded))
    return table.assign(
        **dict(zip(coded_names, coded.T)), **dict(zip(box.names, natural.T))
    )
