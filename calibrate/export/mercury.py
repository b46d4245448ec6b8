"""MercuryDPM: a header with the species of seed and wall and what happens between them.

Read: MercuryDPM kernel, HertzianViscoelasticNormalSpecies, MindlinSpecies,
MindlinRollingTorsionInteraction, release notes."""

from benchtwin.calibrate.export.conventions import damping_factor, effective_moduli
from benchtwin.calibrate.export.header import digits, header, length_note
from benchtwin.calibrate.export.result import Calibrated, Pair, Solid

VERSION = "MercuryDPM 1.0.0.Alpha"
SPECIES = "HertzianViscoelasticMindlinRollingTorsionSpecies"


def contact(calibrated: Calibrated) -> str:
    """The header: `auto [seed, wall] = addSeedAndWall(dpm);` and the balls of a
    seed."""
    c = calibrated
    mu_seed, mu_wall = (
        c.rolling_friction("effective", on_wall=wall) for wall in (False, True)
    )
    how = {
        "restitution": (
            "the normal dissipation that"
            " setEffectiveElasticModulusAndRestitutionCoefficient computes from e,"
            " sqrt(5) |ln e| / sqrt(ln^2 e + pi^2), is Tsuji's; the force may pull at"
            " the end of contact"
        ),
        "elasticity": (
            "Mercury takes the contact's E* and G*, not a material's: 1/E* = sum"
            " (1-nu^2)/E, 1/G* = sum (2-nu)/G"
        ),
        "rolling friction": (
            f"cap mu F_n R* against relative rolling: {c.rolling_with_r_star}"
        ),
        "tangential dissipation": (
            "2 sqrt(5/6) |ln e| / sqrt(ln^2 e + pi^2), times Mercury's sqrt(m* 8 G*"
            " sqrt(R* delta))"
        ),
    }
    notes = [
        (
            "releases before 1.0.0.Alpha roll with 2 R* where this one has R*: halve"
            " both rolling frictions there."
        ),
        (
            "Mercury's tangential spring is 2/3 of 8 G* sqrt(R* delta) (Di Renzo and Di"
            " Maio 2005), benchtwin's the whole."
        ),
        length_note(c, "R*"),
    ]
    setters = "\n".join(
        [
            f"    {SPECIES} seedSpecies;",
            *_setters("seedSpecies.", c, c.on_seed, c.seed, mu_seed),
            "    auto* seed = dpm.speciesHandler.copyAndAddObject(seedSpecies);",
            (
                f"    {SPECIES} wallSpecies(seedSpecies);  // walls never touch walls:"
                " only its density is its own"
            ),
            f"    wallSpecies.setDensity({digits(c.wall.density_kg_m3)});",
            "    auto* wall = dpm.speciesHandler.copyAndAddObject(wallSpecies);",
            "    auto* between = dpm.speciesHandler.getMixedObject(seed, wall);",
            *_setters("between->", c, c.on_wall, c.wall, mu_wall),
            "    return std::make_pair(seed, wall);",
        ]
    )
    return (
        header(c, "//", VERSION, how, notes)
        + "\n#pragma once\n#include <array>\n#include <utility>\n#include <vector>\n"
        + f"#include <DPMBase.h>\n#include <Species/{SPECIES}.h>\n\n"
        + f"inline std::pair<{SPECIES}*, {SPECIES}*> addSeedAndWall(DPMBase&"
        f" dpm)\n{{\n{setters}\n}}\n\n{_balls(c)}"
    )


def _setters(
    of: str, c: Calibrated, pair: Pair, other: Solid, mu_r: float
) -> list[str]:
    modulus, shear = effective_moduli(c.seed, other)
    calls = [
        (
            f"setEffectiveElasticModulusAndRestitutionCoefficient({digits(modulus)},"
            f" {digits(pair.restitution.value)})"
        ),
        f"setEffectiveShearModulus({digits(shear)})",
        f"setSlidingDissipation({digits(damping_factor(pair.restitution.value))})",
        f"setSlidingFrictionCoefficient({digits(pair.static_friction.value)})",
        f"setRollingFrictionCoefficient({digits(mu_r)})",
    ]
    if of == "seedSpecies.":
        calls.insert(0, f"setDensity({digits(c.seed.density_kg_m3)})")
    return [f"    {of}{call};" for call in calls]


def _balls(c: Calibrated) -> str:
    """The seed's balls as data: a clump's class is still changing between Mercury's
    versions."""
    rows = ",\n".join(
        "    {" + ", ".join(digits(v) for v in ball) + "}" for ball in c.shape.balls_m
    )
    moments = ", ".join(digits(v) for v in c.shape.inertia_kg_m2)
    return (
        "// The seed's balls x, y, z, r [m] about its centre of mass along its"
        " principal axes (ClumpParticle::addPebble),\n// mass and principal moments of"
        " their union (setClumpMass, setInitInertia).\nconst"
        f" std::vector<std::array<double, 4>> seedBalls = {{\n{rows}}};\nconst double"
        f" seedMass = {digits(c.shape.mass_kg)};\nconst std::array<double, 3>"
        f" seedInertia = {{{moments}}};\n"
    )
