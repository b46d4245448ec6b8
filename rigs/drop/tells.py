"""What drops tell a calibration: on a smooth plate the restitution of seed on steel, on
a plate of seeds that of seed on seed."""

import numpy as np

from benchtwin.bench.seed_plate import lost_in_glue, told_on_seeds
from benchtwin.bench.tells import ByCurve
from benchtwin.rigs.drop import ON_SEEDS, RIG
from benchtwin.sim.rigs.seed_drop import SeedDrop


def restitution(height_mm: float, drop: dict) -> float | None:
    """Eq. 1 of the soybean paper: e = √(H₂/H₁), rebound over release height."""
    start = drop.get("height_mm")
    return float(np.sqrt(height_mm / start)) if start else None


# limits and steps span what seeds on steel can show, with room; the seed's range spans
# what is published of seeds on seeds, 0.17 to 0.65 (docs/seeds.md), with room, its
# limits what the simulation still follows
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
    seed_range=(0.15, 0.80),
    seed_limits=(0.05, 0.95),
)

ON_A_PLATE_OF_SEEDS = told_on_seeds(
    RIG,
    ON_SEEDS,
    ON_STEEL.seed,
    per_run=SeedDrop().drops,
    minutes=5.0,  # ten drops
    left_out=lost_in_glue,
)
TELLS = ON_STEEL, ON_A_PLATE_OF_SEEDS
