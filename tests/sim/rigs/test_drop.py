"""The drop rig against closed forms: fall, rebound, orientation, ends."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import NO_AIR

from benchtwin.bench.constants import G_M_S2
from benchtwin.sim.material import SOYBEAN_Q235
from benchtwin.sim.rigs.bench import Bench, reach
from benchtwin.sim.rigs.drop import Drop, run_drop

SLICK = replace(SOYBEAN_Q235, static_friction=0.0, rolling_friction=0.0)
SMOOTH = Bench(seed_wall=SLICK, air_density_kg_m3=0.0, laws=NO_AIR)
LEVEL = (1.0, 0.0, 0.0, 0.0)


def rng():
    return np.random.default_rng(3)


def test_a_level_seed_without_air_rises_by_the_square_of_its_restitution():
    truth = run_drop(Drop(orientation=LEVEL), SMOOTH, rng()).truth
    # the engine returns e within 0.5 % at a fifth of the Rayleigh step, so e² within 1
    # %
    assert truth["rebound_height_mm"] == pytest.approx(0.54**2 * 310, rel=0.01)
    assert truth["impact_speed_m_s"] == pytest.approx(
        np.sqrt(2 * G_M_S2 * 0.310), rel=1e-3
    )
    assert truth["restitution"] == pytest.approx(0.54, rel=0.005)


def test_the_height_is_that_of_the_lowest_point():
    motion = run_drop(Drop(orientation="any"), SMOOTH, rng())
    low = motion.positions_m[0, 0, 2] - reach(
        motion.shapes[0], motion.orientations[0, 0], (0, 0, -1)
    )
    assert low == pytest.approx(0.310, abs=1e-6)


def test_air_takes_from_the_rebound_what_drag_takes_twice():
    """Work of drag on the way down and up, with the law itself, summed along the
    flights: within a tenth of it."""
    from benchtwin.sim.laws.drag import drag

    fine = replace(
        SMOOTH, rayleigh_fraction=0.02
    )  # e as entered within 0.1 %: half a per cent would hide the air
    still = run_drop(Drop(orientation=LEVEL), fine, rng())
    windy = run_drop(
        Drop(orientation=LEVEL), replace(fine, air_density_kg_m3=1.2, laws=()), rng()
    )
    seed = still.shapes[0]
    d, e2 = (6 * seed.volume_m3 / np.pi) ** (1 / 3), 0.54**2

    def lost(speed_at_bottom):  # metres of height that drag costs along one leg
        z = np.linspace(0, speed_at_bottom**2 / 2 / G_M_S2, 400)
        v = np.sqrt(speed_at_bottom**2 - 2 * G_M_S2 * z)
        force = [drag(0, 0, -s, 0, 0, 0, d, 1.2, 1.81e-5, 1, 0, 0, 0)[2] for s in v]
        return np.trapezoid(force, z) / seed.mass_kg / G_M_S2

    v = np.sqrt(2 * G_M_S2 * 0.310)
    expected = 1e3 * (e2 * lost(v) + lost(0.54 * v))
    assert still.truth["rebound_height_mm"] - windy.truth[
        "rebound_height_mm"
    ] == pytest.approx(expected, rel=0.1)


def test_frames_stand_at_whole_multiples_of_the_frame_time():
    motion = run_drop(Drop(orientation=LEVEL), SMOOTH, rng(), fps=500.0)
    assert np.allclose(motion.t_s, np.arange(motion.frames) / 500.0, atol=1e-12)
    falling = (motion.t_s > 0.02) & (motion.t_s < 0.2)
    t = motion.t_s[falling] - 0.01
    assert np.allclose(
        motion.positions_m[falling, 0, 2],
        motion.positions_m[0, 0, 2] - G_M_S2 * t**2 / 2,
        atol=1e-7,
    )


@pytest.mark.slow
def test_the_answer_does_not_depend_on_the_frame_rate():
    slow, fast = (
        run_drop(Drop(orientation=LEVEL), SMOOTH, rng(), fps=fps).truth
        for fps in (500.0, 20_000.0)
    )
    for name, value in slow.items():
        assert fast[name] == pytest.approx(value, rel=1e-3), name


def test_the_asked_for_bounces_are_in_it():
    motion = run_drop(Drop(orientation=LEVEL, bounces=3), SMOOTH, rng())
    v = motion.velocities_m_s[:, 0, 2]
    assert np.sum((v[1:] > 0) & (v[:-1] < 0)) >= 4  # turned upwards by an impact


def test_a_seed_that_lands_tipped_turns_and_rises_less():
    tipped = (np.cos(np.pi / 8), 0.0, np.sin(np.pi / 8), 0.0)
    motion = run_drop(Drop(orientation=tipped), SMOOTH, rng())
    assert motion.truth["rebound_height_mm"] < 0.5 * 0.54**2 * 310
    assert np.abs(motion.spins_rad_s[-1]).max() > 50


def test_the_same_generator_gives_the_same_drop_and_another_another():
    heights = [
        run_drop(Drop(orientation="any"), SMOOTH, np.random.default_rng(k)).truth[
            "rebound_height_mm"
        ]
        for k in (1, 1, 2)
    ]
    assert heights[0] == heights[1] != heights[2]


def test_a_seed_beside_the_plate_ends_the_run():
    motion = run_drop(
        Drop(plate_m=(0.01, 0.01), orientation="any", spin_sd_rad_s=20.0), SMOOTH, rng()
    )
    assert motion.t_s[-1] < 1.0


@pytest.mark.parametrize(
    "wrong",
    [
        {"height_m": 0.0},
        {"bounces": 0},
        {"orientation": "upright"},
        {"height_m": np.nan},
    ],
)
def test_descriptions_that_make_no_sense_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong)).split("_")[0]):
        Drop(**wrong)


def test_a_plate_that_falls_to_the_right_kicks_to_the_right():
    """Without friction the speed along the plate stays and that across it is reversed
    by e: Δv_x = (1 + e) v cos α sin α."""
    tilt = np.radians(2.0)
    ball = replace(SMOOTH, sizes=(0.007, 0.007, 0.007), spheres=1)
    motion = run_drop(Drop(orientation=LEVEL, tilt_deg=2.0), ball, rng())
    v, falls = motion.velocities_m_s[:, 0], motion.velocities_m_s[:, 0, 2] < 0
    after = int(np.flatnonzero(falls[:-1] & ~falls[1:])[0]) + 2
    speed = np.sqrt(2 * G_M_S2 * 0.310)
    assert v[after, 0] == pytest.approx(
        1.54 * speed * np.cos(tilt) * np.sin(tilt), rel=0.01
    )
    assert motion.positions_m[0, 0, 2] == pytest.approx(
        0.310 + 0.0035 / np.cos(tilt), abs=1e-6
    )
    with pytest.raises(ValueError, match="tilt_deg"):
        Drop(tilt_deg=20.0)
