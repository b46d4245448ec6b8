"""The rigs of the procedure, once: which parameter each is read for, how that reading
follows from it, and what is taken where nothing is known."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from benchtwin.bench.run_out import rolling_friction as eq_3


@dataclass(frozen=True, kw_only=True)
class Rig:
    """A rig with seed on steel, and the same parameter of seed on seed.

    response: column of its reading; degree: of the polynomial that the paper fits (its
    `equation`); limits: physical ends of the parameter; step: smallest half width that
    a range of it is simulated over; first: where a range begins when the readings say
    nothing; assumed: where the rig gives nothing, the paper's value; formula: the
    parameter by the paper's `formula_name` from a reading and the rig's own section of
    recording.toml, None where its lengths are not stated. seed: the parameter of seed
    on seed; seed_range: where it is looked for; seed_limits: what can be simulated;
    on_seed: what would measure it directly; both_ways: whether its runs go to either
    side by turns, as on a plate that is not quite level."""

    name: str
    parameter: str
    response: str
    unit: str
    degree: int
    equation: str
    limits: tuple[float, float]
    step: float
    first: float
    assumed: float
    formula_name: str
    formula: Callable[[float, dict], float | None]
    seed_range: tuple[float, float]
    seed_limits: tuple[float, float]
    on_seed: str
    both_ways: bool = False

    @property
    def sd(self) -> str:
        """Column with the standard deviation of single runs."""
        return f"sd_{self.unit}"

    @property
    def seed(self) -> str:
        """Name of the parameter of seed on seed."""
        return f"seed_{self.parameter}"

    def direct(self, reading: float, description: dict) -> float | None:
        """The parameter straight from a reading (mm or degrees), without simulation;
        None where the rig's own lengths are not stated."""
        return self.formula(reading, description.get(self.name, {}))


def restitution(height_mm: float, drop: dict) -> float | None:
    """Eq. 1: e = √(H₂/H₁), rebound over release height."""
    start = drop.get("height_mm")
    return float(np.sqrt(height_mm / start)) if start else None


def static_friction(angle_deg: float, slide: dict) -> float | None:
    """Eq. 2: μ = tan α at the onset of sliding."""
    return float(np.tan(np.radians(angle_deg)))


def rolling_friction(run_out_mm: float, roll: dict) -> float | None:
    """Eq. 3: μ_r = S sin β/(S cos β + L), way S on the incline β, L beyond it.

    >>> lengths = {"incline_deg": 15.0, "incline_length_mm": 10.0}
    >>> round(rolling_friction(214.0, lengths), 5)
    0.01157
    """
    if "incline_deg" not in roll or "incline_length_mm" not in roll:
        return None
    return eq_3(roll["incline_length_mm"], roll["incline_deg"], run_out_mm)[0]


# limits and steps span what seeds on steel can show, with room; seed ranges are the
# paper's steepest ascent (Table 7), seed limits what the simulation still follows
STEEL = {
    rig.name: rig
    for rig in (
        Rig(
            name="drop",
            parameter="restitution",
            response="rebound_height_mm",
            unit="mm",
            degree=2,
            equation="Eq. 5",
            limits=(0.05, 1.0),
            step=0.1,
            first=0.5,
            assumed=0.54,
            formula_name="Eq. 1",
            formula=restitution,
            seed_range=(0.45, 0.70),
            seed_limits=(0.05, 0.95),
            on_seed="drop of seed on a bed of seeds",
        ),
        Rig(
            name="slide",
            parameter="static_friction",
            response="slide_angle_deg",
            unit="deg",
            degree=1,
            equation="Eq. 6",
            limits=(0.02, 3.0),
            step=0.1,
            first=0.35,
            assumed=0.34,
            formula_name="Eq. 2",
            formula=static_friction,
            seed_range=(0.20, 0.70),
            seed_limits=(0.02, 1.5),
            on_seed="slide of seeds on a plate of seeds",
        ),
        Rig(
            name="roll",
            parameter="rolling_friction",
            response="run_out_mm",
            unit="mm",
            degree=2,
            equation="Eq. 7",
            limits=(0.0005, 1.0),
            step=0.004,
            first=0.02,
            assumed=0.01,
            formula_name="Eq. 3",
            formula=rolling_friction,
            seed_range=(0.01, 0.06),
            seed_limits=(0.0005, 0.5),
            on_seed="roll of a seed on a plate of seeds",
            both_ways=True,
        ),
    )
}
PILE_RESPONSE = "repose_angle_deg"
ASSUMED = {rig.parameter: rig.assumed for rig in STEEL.values()}
RANGES = {rig.seed: rig.seed_range for rig in STEEL.values()}
SEED_LIMITS = {rig.seed: rig.seed_limits for rig in STEEL.values()}
SEED_FACTORS = tuple(RANGES)
PARAMETERS = (*ASSUMED, *SEED_FACTORS)
