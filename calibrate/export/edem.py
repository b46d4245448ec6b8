"""EDEM: a card to type in from, in the order of its Creator, and the table of spheres
to paste.

Read: Altair EDEM help, Creator Tree – Bulk Material, Hertz–Mindlin (no slip), Standard,
RVD and Type C rolling friction, Add Multi-Sphere Particles."""

from benchtwin.calibrate.export.header import MEANING, SHARED_DAMPING, digits, header
from benchtwin.calibrate.export.result import Calibrated, Pair, Solid

VERSION = "Altair EDEM 2022 to 2025"
CREEP = (
    "benchtwin holds a seed at rest by rolling friction. Where a code applies the"
    " torque with its full size in every step, piles creep, the faster the longer the"
    " step: compare a pile's angle at two steps, 20 % and 5 % of the Rayleigh time."
)
UNITS = "set the units of EDEM's fields to those named here (Tools > Options > Units)."
SPHERES = (
    "the spheres stand in seed.spheres.tsv about the centre of mass along the principal"
    " axes, as EDEM wants them; let it calculate the properties and compare mass and"
    " moments with those below."
)
MODELS = {
    "edem": "Standard Rolling Friction",
    "type_a": "RVD Rolling Friction",
    "type_c": "Type C Rolling Friction",
}


def card(calibrated: Calibrated) -> str:
    """The card: a line a field, `name | value | unit`."""
    c = calibrated
    model = MODELS[c.rolling]
    how = {
        "restitution, static friction": "unchanged",
        "rolling friction": (
            f"unchanged: {model} means the same torque ({MEANING[c.rolling]})"
        ),
        "elasticity": "EDEM asks for the shear modulus (or Young's: both stand below)",
    }
    creep = [CREEP] if c.rolling == "edem" else []
    notes = [SHARED_DAMPING, *creep, UNITS, SPHERES]
    physics = f"Hertz-Mindlin (no slip) + {model}"
    lines = [
        *_material("Bulk Material", c.seed),
        *_interaction(c.seed, c.seed, c.on_seed),
        *_interaction(c.seed, c.wall, c.on_wall),
        *_material("Equipment Material", c.wall),
        "[Physics]",
        f"Particle to Particle | {physics} | -",
        f"Particle to Geometry | {physics} | -",
        f"[Particle: {c.seed.name}, multi-sphere]",
        f"Number of spheres | {len(c.shape.balls_m)} | -",
        f"Mass | {digits(c.shape.mass_kg)} | kg",
    ]
    lines += [
        f"Moment of inertia {axis} | {digits(moment)} | kg m2"
        for axis, moment in zip("XYZ", c.shape.inertia_kg_m2)
    ]
    return "\n".join([header(c, "#", VERSION, how, notes), *lines]) + "\n"


def spheres(calibrated: Calibrated) -> str:
    """The seed's balls for the sphere table: radius and position [m], tabs between."""
    heading = "\t".join(("Radius", "Position X", "Position Y", "Position Z"))
    balls = ((r, x, y, z) for x, y, z, r in calibrated.shape.balls_m)
    rows = ["\t".join(map(digits, ball)) for ball in balls]
    return "\n".join([heading, *rows]) + "\n"


def _material(kind: str, solid: Solid) -> list[str]:
    return [
        f"[{kind}: {solid.name}]",
        f"Poisson's Ratio | {digits(solid.poisson_ratio)} | -",
        f"Solids Density | {digits(solid.density_kg_m3)} | kg/m3",
        f"Shear Modulus | {digits(solid.shear_modulus_pa)} | Pa",
        f"Young's Modulus | {digits(solid.young_modulus_pa)} | Pa",
    ]


def _interaction(one: Solid, other: Solid, pair: Pair) -> list[str]:
    return [
        f"[Interaction: {one.name} : {other.name}]",
        f"Coefficient of Restitution | {digits(pair.restitution.value)} | -",
        f"Coefficient of Static Friction | {digits(pair.static_friction.value)} | -",
        f"Coefficient of Rolling Friction | {digits(pair.rolling_friction.value)} | -",
    ]
