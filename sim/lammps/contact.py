"""Contacts in LAMMPS's words: what is written as it is, what is converted and said,
what is refused by name.

`in_lammps_law` makes a bench whose law both engines have. `words` writes one contact of
`pair_style granular`: Hertz with E = 2 (1 − ν²) E*, damping from the restitution (it
may pull at the end of contact), Mindlin's tangential spring k_t = 8 G* with damping
scaled by 2 √(G*/E*), which makes it Tsuji's, and `rolling sds`, whose μ_r is in the R*
convention; `hooke` with a tangential spring of 4 (G*/E*) k where `spring_linear` is
chosen."""

import math
from dataclasses import replace

import numpy as np

from benchtwin.bench.constants import G_M_S2
from benchtwin.sim.engine.world import World, contact_between
from benchtwin.sim.laws import LAWS
from benchtwin.sim.material import Contact, effective_moduli
from benchtwin.sim.rigs.bench import Bench

# the rolling spring is as stiff as Mindlin's under so many seeds' weight
RESTING_WEIGHTS = 10.0
# of critical, as type C has it (Ai et al. 2011); below the cap only
ROLLING_DAMPING = 0.3
WRITTEN = ("rolling_sds", "spring_linear", "drag")


def in_lammps_law(bench: Bench) -> tuple[Bench, tuple[str, ...]]:
    """The bench with the law that LAMMPS has too, and sentences that say what was
    converted.

    ValueError names a law that LAMMPS has not.
    """
    for chosen in bench.laws:
        if chosen.law.name not in WRITTEN:
            raise ValueError(
                f"laws.{chosen.law.name}: --engine lammps has no such law; leave it out"
                " or use our own engine"
            )
    notes = []
    before = bench.seed_seed.rolling_convention
    if before != "sds":
        seed, wall = bench.seed_seed, bench.seed_wall
        on_seed = seed.rolling_friction_in("sds", on_wall=False)
        on_wall = wall.rolling_friction_in("sds", on_wall=True)
        notes.append(
            f"rolling friction: LAMMPS has no {before!r} model; spring-dashpot-slider"
            " (sds) in the R* convention was used, between seeds"
            f" {seed.rolling_friction:g} as {on_seed:g}, on walls"
            f" {wall.rolling_friction:g} as {on_wall:g}"
        )
        seed_seed = replace(seed, rolling_friction=on_seed, rolling_convention="sds")
        seed_wall = replace(wall, rolling_friction=on_wall, rolling_convention="sds")
        bench = replace(bench, seed_seed=seed_seed, seed_wall=seed_wall)
    if not any(c.law.name == "rolling_sds" for c in bench.laws):
        spring, dashpot = _rolling_spring(bench)
        notes.append(
            f"rolling spring: {spring:.4g} N/m, dashpot {dashpot:.4g} N s/m in every"
            " contact"
        )
        laws = (*bench.laws, LAWS["rolling_sds"].use(spring=spring, dashpot=dashpot))
        bench = replace(bench, laws=laws)
    if bench.share_damping:
        notes.append(
            "damping: every ball of a seed damps with the seed's whole mass, as LAMMPS"
            " and EDEM have it"
        )
    if not bench.cap_damped:
        notes.append(
            "caps of friction and rolling: of the whole normal force, damping included,"
            " as LAMMPS has it"
        )
    notes.append(
        "friction at its cap: LAMMPS leaves its spring the cap less the dashpot's part,"
        " ours the whole cap; not converted"
    )
    return replace(bench, share_damping=False, cap_damped=True), tuple(notes)


def _rolling_spring(bench: Bench) -> tuple[float, float]:
    """Stiffness [N/m] and damping [N s/m] of the rolling spring: of a mean seed under
    RESTING_WEIGHTS seeds' weight."""
    lot = bench.draw(np.random.default_rng(0), 100)
    mass = float(np.mean([seed.mass_kg for seed in lot]))
    radius = float(np.mean([seed.radii_m.mean() for seed in lot])) / 2  # R* of two
    modulus, shear = effective_moduli(bench.grain, bench.grain)
    overlap = (
        0.75 * RESTING_WEIGHTS * mass * G_M_S2 / (modulus * math.sqrt(radius))
    ) ** (2 / 3)
    spring = 8.0 * shear * math.sqrt(radius * overlap)
    return spring, ROLLING_DAMPING * 2.0 * math.sqrt(0.4 * mass * spring)


def refuse_others(world: World) -> None:
    """ValueError for a world that says what LAMMPS cannot be told; `in_lammps_law`
    makes benches that pass."""
    for chosen in world.active_laws:
        if chosen.law.name not in WRITTEN:
            raise ValueError(
                f"law {chosen.law.name!r}: the LAMMPS input has no such law; it has"
                f" {', '.join(WRITTEN)}"
            )
        if chosen.law.name == "rolling_sds" and chosen.between:
            raise ValueError(
                "law 'rolling_sds': one spring for all pairs of materials is written,"
                " leave `between` out"
            )
    if world.share_damping and any(
        len(s.radii_m) > 1 for group in world.seeds for s in group.shapes
    ):
        raise ValueError(
            "share_damping = True: in LAMMPS every ball of a seed damps with the seed's"
            " whole mass, say False"
        )
    if len(world.seeds) != 1:
        raise ValueError(
            f"seeds: {len(world.seeds)} groups; the LAMMPS input is written for one"
        )


def words(world: World, other: str) -> str:
    """The contact of the seeds' material with material `other`, as pair_coeff and fix
    wall/gran take it."""
    material = world.seeds[0].material
    contact: Contact = contact_between(world, material.name, other)
    modulus, shear = effective_moduli(material, world.materials[other])
    young = 2.0 * (1.0 - material.poisson_ratio**2) * modulus
    ratio = 2.0 * math.sqrt(shear / modulus) if contact.restitution < 1.0 else 1.0
    text = (
        f"hertz/material {young:.12g} {contact.restitution:.12g}"
        f" {material.poisson_ratio:.12g} tangential mindlin {8.0 * shear:.12g}"
    )
    for chosen in world.laws:
        if chosen.law.name == "spring_linear" and chosen.acts_between(
            material.name, other
        ):
            k = dict(chosen.given)["stiffness"]
            across = 4.0 * shear / modulus * k
            text = f"hooke {k:.12g} {contact.restitution:.12g}"
            text += f" tangential linear_history {across:.12g}"
    text += f" {ratio:.12g} {contact.static_friction:.12g} "
    for chosen in world.active_laws:
        if chosen.law.name == "rolling_sds" and contact.rolling_friction > 0:
            numbers = dict(chosen.given)
            text += (
                f"rolling sds {numbers['spring']:.12g} {numbers['dashpot']:.12g}"
                f" {contact.rolling_friction:.12g} "
            )
    return (
        text
        + "damping coeff_restitution"
        + ("" if world.pull_at_end else " limit_damping")
    )
