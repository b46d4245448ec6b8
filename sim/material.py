"""What seeds and walls are made of, and what happens between two materials; each value
with its source.

Softening is an explicit choice: `Material.softened` gives a material with a smaller
shear modulus. Contact time and overlap then grow as E*^-0.4, the Rayleigh step as
G^-0.5; the restitution stays as entered."""

import math
from dataclasses import dataclass, replace

# For each convention the torque it means; F_n normal force, R_i centre-to-contact
# distance, R* effective radius.
ROLLING_CONVENTIONS = {
    "edem": "τ_i = μ_r F_n R_i against each body's own spin (EDEM standard)",
    "type_a": "τ = μ_r F_n R* against relative rolling (Ai et al. 2011, type A)",
    "type_c": "at most τ = μ_r F_n R*, elastic–plastic (Ai et al. 2011, type C)",
    "sds": "at most τ = μ_r F_n R*, spring–dashpot–slider (LAMMPS, rolling sds)",
}


@dataclass(frozen=True)
class Material:
    """A homogeneous elastic solid.

    density_kg_m3 [kg/m3] 1 to 30,000; shear_modulus_pa G [Pa] 1e3 to 1e12;
    poisson_ratio ν [-] 0 to 0.5. Hertz's law takes the solid as linear and isotropic.
    Raises ValueError naming the parameter and its range."""

    name: str
    density_kg_m3: float
    shear_modulus_pa: float
    poisson_ratio: float
    source: str = ""

    def __post_init__(self) -> None:
        if not self.name:
            raise ValueError("name: a material needs one, contacts are stated by it")
        who = f"material {self.name!r}: "
        within(who + "density_kg_m3", self.density_kg_m3, 0.01, 30_000.0, "kg/m3")
        within(who + "shear_modulus_pa", self.shear_modulus_pa, 1e3, 1e12, "Pa")
        within(who + "poisson_ratio", self.poisson_ratio, 0.0, 0.5, "-")

    @property
    def young_modulus_pa(self) -> float:
        """E = 2 G (1 + ν) [Pa]."""
        return 2.0 * self.shear_modulus_pa * (1.0 + self.poisson_ratio)

    def softened(self, shear_modulus_pa: float) -> "Material":
        """This material with a smaller shear modulus [Pa], said so in its source;
        ValueError if it is not smaller."""
        if not 0.0 < shear_modulus_pa < self.shear_modulus_pa:
            raise ValueError(
                f"material {self.name!r}: shear_modulus_pa = {shear_modulus_pa:g} Pa:"
                f" must be below the real {self.shear_modulus_pa:g} Pa"
            )
        source = (
            f"{self.source}; shear modulus softened from {self.shear_modulus_pa:g} Pa"
        )
        return replace(self, shear_modulus_pa=shear_modulus_pa, source=source)

    def rayleigh_step_s(self, radius_m: float) -> float:
        """Rayleigh time of a ball, π R √(ρ/G) / (0.1631 ν + 0.8766) [s]; steps of 10 to
        20 % of the smallest ball's are usual.

        radius_m [m] > 0. Source: Ning & Ghadiri (2006), Chem. Eng. Sci. 61, 5991–6001.

        >>> round(1e6 * SOYBEAN.rayleigh_step_s(3.2e-3), 2)
        21.0
        """
        _positive("radius_m", radius_m)
        speed_factor = 0.1631 * self.poisson_ratio + 0.8766
        return (
            math.pi
            * radius_m
            * math.sqrt(self.density_kg_m3 / self.shear_modulus_pa)
            / speed_factor
        )


@dataclass(frozen=True)
class Contact:
    """What happens between two materials.

    between: their names, in any order. restitution e [-] above 0 up to 1: the ratio of
    normal speeds after and before, which a contact gives back at any speed.
    static_friction μ_s [-] 0 to 5. rolling_friction μ_r [-] 0 to 2, a number that means
    a torque only together with its convention: see `ROLLING_CONVENTIONS`. Between two
    equal balls "edem" μ_r brakes as "type_a", "type_c" and "sds" with 2 μ_r; on a wall
    all agree. Raises ValueError naming the parameter and its range."""

    between: tuple[str, str]
    restitution: float
    static_friction: float
    rolling_friction: float
    rolling_convention: str = "edem"
    source: str = ""

    def __post_init__(self) -> None:
        if len(self.between) != 2 or not all(self.between):
            raise ValueError(
                f"between = {self.between!r}: must be two materials' names"
            )
        who = f"contact {self.between[0]}–{self.between[1]}: "
        within(who + "restitution", self.restitution, 1e-3, 1.0, "-")
        within(who + "static_friction", self.static_friction, 0.0, 5.0, "-")
        within(who + "rolling_friction", self.rolling_friction, 0.0, 2.0, "-")
        if self.rolling_convention not in ROLLING_CONVENTIONS:
            raise ValueError(
                f"{who}rolling_convention = {self.rolling_convention!r}: one of"
                f" {', '.join(ROLLING_CONVENTIONS)}"
            )

    def rolling_friction_in(self, convention: str, *, on_wall: bool) -> float:
        """μ_r [-] that brakes equally in another convention: on a wall, or between two
        equal balls (of unequal ones none does).

        >>> SOYBEAN_SOYBEAN.rolling_friction_in("type_c", on_wall=False)
        0.08
        >>> SOYBEAN_Q235.rolling_friction_in("type_c", on_wall=True)
        0.01
        """
        if convention not in ROLLING_CONVENTIONS:
            raise ValueError(
                f"convention = {convention!r}: one of {', '.join(ROLLING_CONVENTIONS)}"
            )
        to_effective = 1.0 if on_wall else 2.0
        here, there = (
            1.0 if c == "edem" else to_effective
            for c in (self.rolling_convention, convention)
        )
        return self.rolling_friction * there / here


def effective_moduli(one: Material, other: Material) -> tuple[float, float]:
    """E* and G* [Pa] of a contact: 1/E* = Σ (1 - ν²)/E, 1/G* = Σ (2 - ν)/G.

    Source: Johnson (1985), Contact Mechanics, sections 4.2 and 7.2.
    """
    young = sum((1.0 - m.poisson_ratio**2) / m.young_modulus_pa for m in (one, other))
    shear = sum((2.0 - m.poisson_ratio) / m.shear_modulus_pa for m in (one, other))
    return 1.0 / young, 1.0 / shear


def within(name: str, value: float, low: float, high: float, unit: str) -> None:
    """ValueError that names a value and its range, for one outside it and for NaN."""
    if not low <= value <= high:
        given = f"{name} = {value:g} {unit}".rstrip()
        raise ValueError(f"{given}: must be {low:g} to {high:g} {unit}".rstrip())


def _positive(name: str, value: float) -> None:
    if not 0.0 < value < math.inf:
        raise ValueError(f"{name} = {value:g}: must be positive and finite")


_PAPER = (
    "Research on contact parameters calibration of soybean seeds based on discrete"
    " element simulation"
)

SOYBEAN = Material(
    "soybean",
    1250.0,
    3.23e8,
    0.40,
    f"{_PAPER}, Test materials (12.5 % moisture; Ding et al. 2023)",
)
Q235 = Material(
    "Q235",
    7850.0,
    8.20e10,
    0.28,
    f"{_PAPER}, Selection of materials (Weston et al. 2025)",
)

# What the paper calibrated, with EDEM's standard rolling friction.
SOYBEAN_Q235 = Contact(
    ("soybean", "Q235"),
    0.54,
    0.34,
    0.01,
    source=f"{_PAPER}, Eqs. (5)–(7), Tables 2, 4, 6",
)
SOYBEAN_SOYBEAN = Contact(
    ("soybean", "soybean"), 0.65, 0.55, 0.04, source=f"{_PAPER}, Eq. (11)"
)
