"""YADE: a script to be run inside YADE, with materials, the interaction loop and a
function that adds a seed.

Read: YADE sources and class reference, Ip2_FrictMat_FrictMat_MindlinPhys,
Law2_ScGeom_MindlinPhys_Mindlin, Ig2_Facet_Sphere_ScGeom, MatchMaker,
BodyContainer.appendClumped."""

import math

from benchtwin.calibrate.export.conventions import (
    effective_moduli,
    resting_force,
    rolling_spring,
)
from benchtwin.calibrate.export.header import digits, header, length_note
from benchtwin.calibrate.export.result import Calibrated, Pair, Solid

VERSION = (
    "YADE trunk of 2023 or later (Hertz-Mindlin damping of merge request 919; a"
    " MindlinPhys that cites Thornton2013)"
)


def contact(calibrated: Calibrated) -> str:
    """The script. `exec(open("seed_contact.py").read())`, then add walls of material
    WALL and `add_seed(…)`."""
    c = calibrated
    eta = c.rolling_friction("mean", on_wall=False)
    # Only R_i and R* are known on a wall: there the cap is set by hand, as mu F_n R.
    at_wall = c.rolling_friction("own", on_wall=True)
    given = c.on_seed.rolling_friction.value
    how = {
        "restitution": (
            "unchanged, en = es; YADE cuts attraction off, with a damping that gives e"
            " all the same (Thornton 2013)"
        ),
        "static friction": (
            "YADE takes angles: atan(mu), a pair of materials each, in frictAngle"
        ),
        "rolling friction": (
            "YADE caps the bending moment at eta F_n (R1 + R2)/2: seed on seed"
            f" {given:.6g} -> eta {eta:.6g} (the mean radius is R_i between equal"
            f" spheres); on wall {at_wall:.6g}, set contact by contact by wall_rolling"
        ),
        "krot": (
            "type C's stiffness 2.25 k_n (mu R*)^2 under ten seeds' weight: how far a"
            " seed rocks, not how it brakes"
        ),
        "elasticity": (
            "Young's modulus E = 2 G (1 + nu); YADE forms E* and G* of a pair itself"
        ),
    }
    return header(c, "#", VERSION, how, _notes(c)) + "\n" + _body(c, eta, at_wall)


def _notes(c: Calibrated) -> list[str]:
    return [
        (
            "not etaRoll (etaR), which belongs to YADE's CohFrictMat and its laws: the"
            " coefficient here is eta."
        ),
        (
            "eta and krot are one number for all pairs of an Ip2, and a hertzian facet"
            " counts with 1e8 times the ball's radius: so wall_rolling sets both for"
            " contacts with walls, each step, in Python: what it costs grows with the"
            " contacts."
        ),
        (
            "walls must be facets: with hertzian=True R* = R; otherwise they count as"
            " balls and are too soft."
        ),
        "NewtonIntegrator(damping=0): YADE's own 0.2 would brake everything besides.",
        (
            "of a clump YADE damps each ball with that ball's own mass: e is exact for"
            " single balls only."
        ),
        length_note(c, "(R1 + R2)/2"),
    ]


def _body(c: Calibrated, eta: float, at_wall: float) -> str:
    en, friction = (_matches(c, kind) for kind in ("restitution", "static_friction"))
    balls = "\n".join(
        "    (" + ", ".join(digits(v) for v in ball) + ")," for ball in c.shape.balls_m
    )
    moments = ", ".join(digits(v) for v in c.shape.inertia_kg_m2)
    return f'''SEED = O.materials.append({_material(c.seed, c.on_seed, "seed")})
WALL = O.materials.append({_material(c.wall, c.on_wall, "wall")})

interaction_loop = InteractionLoop(
    [Ig2_Sphere_Sphere_ScGeom(), Ig2_Facet_Sphere_ScGeom(hertzian=True)],
    [
        Ip2_FrictMat_FrictMat_MindlinPhys(
            en=MatchMaker(matches={en}),
            es=MatchMaker(matches={en}),
            frictAngle=MatchMaker(matches={friction}),
            eta={digits(eta)},
            krot={digits(_spring(c, on_wall=False))},
            ktwist=0.0,
        )
    ],
    [Law2_ScGeom_MindlinPhys_Mindlin(includeMoment=True)],
)


def wall_rolling():
    """Cap of the bending moment at walls: mu F_n R of the ball."""
    for i in O.interactions:
        one, other = O.bodies[i.id1], O.bodies[i.id2]
        if WALL in (one.material.id, other.material.id):
            ball = other if one.material.id == WALL else one
            i.phys.maxBendPl = {digits(at_wall)} * ball.shape.radius
            i.phys.kr = {digits(_spring(c, on_wall=True))}


O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Facet_Aabb()]),
    interaction_loop,
    PyRunner(command="wall_rolling()", iterPeriod=1),
    NewtonIntegrator(damping=0.0, gravity=(0.0, 0.0, -9.81)),
]

# The seed's balls x, y, z, r about its centre of mass, along its principal axes.
BALLS = (
{balls}
)
MASS, INERTIA = {digits(c.shape.mass_kg)}, ({moments})  \
# of the balls' union; compare with the clump's state


def add_seed(position=(0.0, 0.0, 0.0), orientation=Quaternion.Identity):
    """Append a seed; returns (clump's id, balls' ids). \
Mass and inertia of the union, counted on a grid by YADE."""
    at = Vector3(position)
    parts = [utils.sphere(at + orientation * Vector3(x, y, z), r, material=SEED) \
for x, y, z, r in BALLS]
    return O.bodies.appendClumped(parts, discretization=30)
'''


def _spring(c: Calibrated, *, on_wall: bool) -> float:
    """Rolling stiffness [N m/rad]: 2.25 k_n (μ_r R*)²."""
    other = c.wall if on_wall else c.seed
    radius = c.shape.mean_radius_m * (1.0 if on_wall else 0.5)
    mu_star = c.rolling_friction("effective", on_wall=on_wall)
    modulus, _ = effective_moduli(c.seed, other)
    resting = resting_force(c.shape.mass_kg)
    return rolling_spring(mu_star, modulus, radius, resting) * radius**2


def _material(solid: Solid, pair: Pair, label: str) -> str:
    angle = math.atan(pair.static_friction.value)
    return (
        f"FrictMat(young={digits(solid.young_modulus_pa)},"
        f" poisson={digits(solid.poisson_ratio)}, "
        f"density={digits(solid.density_kg_m3)}, frictionAngle={digits(angle)},"
        f' label="{label}")'
    )


def _matches(c: Calibrated, kind: str) -> str:
    """MatchMaker's triples; friction as an angle."""
    values = [getattr(pair, kind).value for pair in (c.on_seed, c.on_wall)]
    if kind == "static_friction":
        values = [math.atan(v) for v in values]
    seed, wall = map(digits, values)
    return f"((SEED, SEED, {seed}), (SEED, WALL, {wall}))"
