"""Conversions between the conventions of DEM engines: pure formulas, each with its
source.

Rolling friction is a torque over normal force and a length, and engines take different
lengths. With one radius R for both spheres, or a sphere of radius R on a wall, the
length is R times `ARM`. Between unequal spheres no factor converts one into the other:
R_1 and R_2 act on one sphere each, R* = R_1 R_2 / (R_1 + R_2) on both alike."""

import math
from dataclasses import dataclass

from benchtwin.bench.constants import G_M_S2

# a result's convention → its length
GIVEN = {"edem": "own", "type_a": "effective", "type_c": "effective"}
# own: R_i, each body's own centre-to-contact distance (EDEM standard); effective: R*,
# which a wall leaves at R (Ai et al. 2011; LAMMPS, LIGGGHTS, MercuryDPM, EDEM RVD and
# type C); mean: (R_1 + R_2)/2 (YADE), at a wall whatever radius that is given
ARM = {
    ("own", False): 1.0,
    ("own", True): 1.0,
    ("effective", False): 0.5,
    ("effective", True): 1.0,
    ("mean", False): 1.0,
}


@dataclass(frozen=True)
class Solid:
    """A material as calibrated: density [kg/m3], shear modulus G [Pa], Poisson's ratio
    ν [-]."""

    name: str
    density_kg_m3: float
    shear_modulus_pa: float
    poisson_ratio: float

    @property
    def young_modulus_pa(self) -> float:
        """E = 2 G (1 + ν) [Pa].

        >>> round(Solid("soybean", 1250.0, 3.23e8, 0.4).young_modulus_pa / 1e8, 3)
        9.044
        """
        return 2.0 * self.shear_modulus_pa * (1.0 + self.poisson_ratio)


def rolling_friction(
    mu_r: float, convention: str, length: str, *, on_wall: bool
) -> float:
    """μ_r' = μ_r ARM/ARM' [-], which brakes equal spheres, or a sphere on a wall, with
    the same torque in another convention.

    mu_r [-] in a result's convention (`GIVEN`); length: what the engine multiplies by
    ("own", "effective", "mean"). Source: EDEM user guide, Standard Rolling Friction;
    Ai, Chen, Rotter, Ooi (2011), Powder Technol. 206, 269–282, eq. (6).

    >>> rolling_friction(0.04, "edem", "effective", on_wall=False)
    0.08
    >>> rolling_friction(0.01, "edem", "effective", on_wall=True)
    0.01
    """
    return mu_r * ARM[GIVEN[convention], on_wall] / ARM[length, on_wall]


def effective_moduli(one: Solid, other: Solid) -> tuple[float, float]:
    """E* and G* [Pa] of a contact: 1/E* = Σ (1 − ν²)/E, 1/G* = Σ (2 − ν)/G; one, other:
    `Solid`.

    Source: Johnson (1985), Contact Mechanics, sections 4.2 and 7.2.
    """
    young = sum((1.0 - s.poisson_ratio**2) / s.young_modulus_pa for s in (one, other))
    shear = sum((2.0 - s.poisson_ratio) / s.shear_modulus_pa for s in (one, other))
    return 1.0 / young, 1.0 / shear


def like_pair_young(effective_pa: float, poisson_ratio: float) -> float:
    """E = 2 (1 − ν²) E* [Pa]: two bodies of this E and ν meet with the effective
    modulus E*.

    >>> round(like_pair_young(1e9 / (2 * (1 - 0.3**2)), 0.3))
    1000000000
    """
    return 2.0 * (1.0 - poisson_ratio**2) * effective_pa


def damping_factor(e: float) -> float:
    """γ = −2 √(5/6) ln e / √(ln² e + π²) [-]: the force γ √(S m*) v lets a Hertzian
    pair rebound with e in (0, 1].

    It must be allowed to pull at the end of contact. Source: Tsuji, Tanaka, Ishida
    (1992), Powder Technol. 71, 239–250.

    >>> round(damping_factor(0.5), 6)
    0.393363
    """
    log = math.log(e)
    share = -2.0 * math.sqrt(5.0 / 6.0) * log / math.hypot(log, math.pi)
    return share + 0.0  # not −0 for e = 1


def resting_force(mass_kg: float) -> float:
    """Ten seeds' weight [N], as in a heap: the load at which a spring that grows with
    the load is given as one number."""
    return 10.0 * mass_kg * G_M_S2


def overlap(modulus_pa: float, radius_m: float, force_n: float) -> float:
    """δ = (3 F / (4 E* √R*))^(2/3) [m] of Hertz's contact; E* [Pa], R* [m], F [N]."""
    return (0.75 * force_n / (modulus_pa * math.sqrt(radius_m))) ** (2.0 / 3.0)


def tangential_spring(
    modulus_pa: float, shear_pa: float, radius_m: float, force_n: float
) -> float:
    """S_t = 8 G* √(R* δ) [N/m] under a normal force [N] (Mindlin 1949); E*, G* [Pa], R*
    [m].

    >>> round(tangential_spring(1e7, 4e6, 1e-3, 1e-2))
    2907
    """
    return 8.0 * shear_pa * math.sqrt(radius_m * overlap(modulus_pa, radius_m, force_n))


def rolling_spring(
    mu_star: float, modulus_pa: float, radius_m: float, force_n: float
) -> float:
    """k = 2.25 k_n μ_r² [N/m], the stiffness against rolling displacement of model C,
    with k_n = 2 E* √(R* δ) under a force.

    mu_star [-] in the R* convention, modulus_pa E* [Pa], radius_m R* [m], force_n [N] >
    0 gives δ = (3 F / (4 E* √R*))^(2/3). It says within what angle a seed rocks before
    it rolls, F / (2.25 k_n μ_r R*), not how a rolling one brakes. Source: Ai et al.
    (2011), model C.

    >>> round(rolling_spring(0.1, 1e7, 1e-3, 1e-2), 1)
    40.9
    """
    depth = overlap(modulus_pa, radius_m, force_n)
    normal = 2.0 * modulus_pa * math.sqrt(radius_m * depth)
    return 2.25 * normal * mu_star**2
