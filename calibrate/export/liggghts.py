"""LIGGGHTS: property tables per material pair, the pair style, the seed as a
multisphere template.

Read: LIGGGHTS-PUBLIC manual, gran model hertz, tangential history, rolling_friction cdt
and epsd2, fix property/global, fix particletemplate/multisphere."""

from benchtwin.calibrate.export.header import (
    SHARED_DAMPING,
    digits,
    header,
    length_note,
)
from benchtwin.calibrate.export.result import Calibrated

VERSION = "LIGGGHTS-PUBLIC 3.8.0"
# beyond these LIGGGHTS refuses a Young's modulus unless told `soft_particles`,
# `hard_particles`
SOFTEST_PA, HARDEST_PA = 5e6, 1e9


def contact(calibrated: Calibrated) -> str:
    """The fragment: seeds are atom type 1, walls type 2."""
    c = calibrated
    model = {"edem": "cdt", "type_a": "cdt", "type_c": "epsd2"}[c.rolling]
    style = f"model hertz tangential history rolling_friction {model}"
    mu_seed, mu_wall = (
        c.rolling_friction("effective", on_wall=wall) for wall in (False, True)
    )
    how = {
        "restitution": (
            "unchanged; model hertz damps as Tsuji does and lets the force pull at the"
            " end (limitForce off)"
        ),
        "rolling friction": (
            f"{model} takes mu F_n R* against relative rolling: {c.rolling_with_r_star}"
        ),
        "elasticity": (
            "Young's modulus E = 2 G (1 + nu) a material; LIGGGHTS forms E* and G* of a"
            " pair itself"
        ),
    }
    e, mu = (
        (getattr(c.on_seed, kind).value, getattr(c.on_wall, kind).value)
        for kind in ("restitution", "static_friction")
    )
    rows = [
        ("restitution", "coefficientRestitution", *e),
        ("friction", "coefficientFriction", *mu),
        ("rolling", "coefficientRollingFriction", mu_seed, mu_wall),
    ]
    young, poisson = (
        " ".join(digits(getattr(s, key)) for s in (c.seed, c.wall))
        for key in ("young_modulus_pa", "poisson_ratio")
    )
    body = [
        f"fix young all property/global youngsModulus peratomtype {young}",
        f"fix poisson all property/global poissonsRatio peratomtype {poisson}",
        *(
            f"fix {ID} all property/global {name} peratomtypepair 2"
            f" {_table(seed, wall)}"
            for ID, name, seed, wall in rows
        ),
        f"pair_style gran {style}",
        "pair_coeff * *",
        f"# walls: fix floor all wall/gran {style} primitive type 2 zplane 0.0",
        (
            "# seeds: needs `fix ms all multisphere`; a seed of these balls has a mass"
            f" of {digits(c.shape.mass_kg)} kg"
        ),
        (
            "fix seed all particletemplate/multisphere 32452843 atom_type 1 density"
            f" constant {digits(c.seed.density_kg_m3)} nspheres {len(c.shape.balls_m)}"
            " ntry 1000000 spheres file seed.multisphere scale 1.0 type 1"
        ),
    ]
    return header(c, "#", VERSION, how, _notes(c)) + "\n" + "\n".join(body) + "\n"


def spheres(calibrated: Calibrated) -> str:
    """The seed's balls, a line each: x y z r [m]. No comment: LIGGGHTS reads numbers
    only."""
    rows = (" ".join(map(digits, ball)) for ball in calibrated.shape.balls_m)
    return "".join(f"{row}\n" for row in rows)


def _table(seed: float, wall: float) -> str:
    """Rows of the symmetric table 11 12 21 22; walls never touch walls, so 22 is given
    what 12 is."""
    return f"{digits(seed)} {digits(wall)} {digits(wall)} {digits(wall)}"


def _notes(c: Calibrated) -> list[str]:
    notes = [
        "needs `units si`, `atom_style granular`, `newton off`, `communicate single vel"
        " yes`, `create_box 2 ...`."
    ]
    moduli = [s.young_modulus_pa for s in (c.seed, c.wall)]
    if min(moduli) < SOFTEST_PA:
        notes.append(
            "a Young's modulus is below 5e6 Pa: LIGGGHTS wants `soft_particles yes`"
            " before the box is created."
        )
    if max(moduli) > HARDEST_PA:
        notes.append(
            "a Young's modulus is above 1e9 Pa: LIGGGHTS wants `hard_particles yes`"
            " before the box is created."
        )
    if min(c.on_seed.restitution.value, c.on_wall.restitution.value) <= 0.05:
        notes.append(
            "LIGGGHTS refuses a coefficient of restitution of 0.05 or less, which one"
            " of these is."
        )
    notes += [
        (
            "`cdt` is a torque of constant size (a pile creeps, the faster the longer"
            " the step), `epsd2` an elastic-plastic one with the same cap and a spring"
            " k_t R*^2, under which seeds rest as they do in benchtwin: one table"
            " serves both; exchange the word in pair_style and fix wall/gran."
        ),
        length_note(c, "R*"),
        SHARED_DAMPING,
    ]
    return notes
