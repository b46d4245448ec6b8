"""What slides tell a calibration: on a smooth plate the static friction of seed on
steel, on a plate of seeds that of seed on seed."""

import numpy as np

from benchtwin.bench.seed_plate import told_on_seeds
from benchtwin.bench.tells import ByCurve
from benchtwin.rigs.slide import ON_SEEDS, RIG
from benchtwin.sim.rigs.seed_slide import SeedSlide

# how far below the expected onset a simulated plate begins: nothing happens before
BELOW_DEG = 1.5


def static_friction(angle_deg: float, slide: dict) -> float | None:
    """Eq. 2 of the soybean paper: μ = tan α at the onset of sliding."""
    return float(np.tan(np.radians(angle_deg)))


def begun(slide: dict, friction: float) -> dict:
    """Beginning a little below the onset that this friction gives, unless the start is
    stated."""
    if slide.get("plate"):
        return slide
    start = float(np.floor(np.degrees(np.arctan(friction)) - BELOW_DEG))
    return {"start_deg": start} | slide if start > 0 else slide


# limits and steps span what seeds on steel can show, with room; the seed's range spans
# what is published of seeds on seeds, 0.18 to 0.55 (docs/seeds.md), with room, its
# limits what the simulation still follows
ON_STEEL = ByCurve(
    rig=RIG,
    parameter="static_friction",
    degree=1,
    equation="Eq. 6",
    limits=(0.02, 3.0),
    step=0.1,
    first=0.35,
    assumed=0.34,
    formula_name="Eq. 2",
    formula=static_friction,
    begun=begun,
    seed_range=(0.15, 0.80),
    seed_limits=(0.02, 1.5),
)

ON_A_PLATE_OF_SEEDS = told_on_seeds(
    RIG,
    ON_SEEDS,
    ON_STEEL.seed,
    per_run=SeedSlide().slides,
    minutes=2.0,  # two slides
)
TELLS = ON_STEEL, ON_A_PLATE_OF_SEEDS
