"""What drops tell a calibration: on a smooth plate the restitution of seed on steel, on
a plate of seeds that of seed on seed."""

import numpy as np

from benchtwin.bench.seed_plate import LAID_BY_HAND, PAGE, open_coverage
from benchtwin.bench.tells import Believed, ByCurve, BySurface
from benchtwin.rigs.drop import ON_SEEDS, RIG
from benchtwin.sim.rigs.seed_drop import SeedDrop

NOTE = (
    "each simulated plate of seeds is read by the mean of its drops, so that its"
    " scatter is not that of single drops at the bench"
)


def restitution(height_mm: float, drop: dict) -> float | None:
    """Eq. 1 of the soybean paper: e = √(H₂/H₁), rebound over release height."""
    start = drop.get("height_mm")
    return float(np.sqrt(height_mm / start)) if start else None


# limits and steps span what seeds on steel can show, with room; the seed's range is the
# paper's steepest ascent (Table 7), its limits what the simulation still follows
ON_STEEL = ByCurve(
    rig=RIG,
    parameter="restitution",
    equation="Eq. 5",
    limits=(0.05, 1.0),
    step=0.1,
    first=0.5,
    assumed=0.54,
    formula_name="Eq. 1",
    formula=restitution,
    seed_range=(0.45, 0.70),
    seed_limits=(0.05, 0.95),
)


def as_described(
    stated: dict, width_mm: float | None, fill_mm: float
) -> tuple[dict, tuple[str, ...]]:
    """[drop] of the simulations: as the bench states it. A bench reads single drops, so
    that it is never quite the same."""
    return {**stated, "drops": SeedDrop().drops}, (NOTE,)


def left_open(section: dict) -> dict[str, Believed]:
    """How densely seeds lie on the plate."""
    return open_coverage(RIG.name, section)


TELLS = (
    ON_STEEL,
    BySurface(
        rig=RIG,
        variant=ON_SEEDS,
        plural="drops on a plate of seeds",
        simulated=as_described,
        shown=lambda stated: {},
        not_seen=("true_sd_mm",),
        minutes=5.0,  # ten drops
        left_open=left_open,
        usual={"coverage": LAID_BY_HAND},
        per_run=SeedDrop().drops,
        within="true_sd_mm",
        page=PAGE,
    ),
)
