"""Camera signs, noise as stated, and the SNR estimate beside answers known
otherwise."""

import numpy as np
import pytest

from benchtwin.prove.cases import drop
from benchtwin.prove.cases.bench import Request
from benchtwin.prove.cases.camera import Camera, project, stated_times, true_times
from benchtwin.prove.cases.drop_snr import visibility
from benchtwin.prove.cases.noise import Noise, kept, noisy, whitened
from benchtwin.prove.cases.snr import WHITE, Change, fitted

CAMERA = Camera((0.0, 100.0), 120.0)
NOTHING = np.zeros(2)


def seen(rows, columns, **shared) -> Change:
    """One channel, its nuisances free but for the shared ones."""
    own = dict.fromkeys(columns.keys() - shared.keys(), np.inf)
    return Change(rows[None], {k: c[None] for k, c in columns.items()}, own, shared)


def test_gravity_points_clockwise_by_the_roll():
    x, y = project(
        CAMERA._replace(roll_deg=2.0), np.zeros(2), np.array([100.0, 90.0]), NOTHING
    )
    down = np.array([x[1] - x[0], y[1] - y[0]]) / 10
    np.testing.assert_allclose(
        down, [-np.sin(np.radians(2)), -np.cos(np.radians(2))], atol=1e-12
    )


def test_a_scale_that_is_truly_larger_makes_lengths_read_small():
    _, y = project(
        CAMERA._replace(scale_error=0.01), np.zeros(2), np.array([100.0, 0.0]), NOTHING
    )
    assert y[0] - y[1] == pytest.approx(100 / 1.01)


def test_a_clock_that_runs_fast_stretches_time_and_both_ways_agree():
    for camera in (
        CAMERA._replace(clock_error=0.01),
        CAMERA._replace(clock_error=0.01, clock_drift=0.02),
    ):
        t = np.linspace(0, 1, 5)
        np.testing.assert_allclose(
            true_times(camera, stated_times(camera, t)), t, atol=1e-12
        )
    assert stated_times(CAMERA._replace(clock_error=0.01), np.ones(1))[
        0
    ] == pytest.approx(1.01)


@pytest.mark.parametrize("tail", [np.inf, 5.0])
@pytest.mark.parametrize("rho", [0.0, 0.9])
def test_noise_has_the_sd_and_the_memory_that_the_key_states(tail, rho):
    noise = Noise(0.05, rho, 0.3 if rho else 1.0, tail, 0.0, 0.2, 0.01)
    rng = np.random.default_rng(1)
    off = noisy(np.zeros(40_000), noise, rng)
    assert np.std(off) == pytest.approx(0.05, rel=0.05)
    lag = np.mean(off[1:] * off[:-1]) / np.mean(off**2)
    assert lag == pytest.approx(0.7 * rho, abs=0.03)
    assert 0.98 < kept(40_000, noise, rng).mean() < 1.0


def test_whitened_noise_is_white_and_of_unit_size():
    noise = Noise(0.05, 0.9, 0.2, np.inf, 0.0, 0.2, 0.0)
    off = noisy(np.zeros(30_000), noise, np.random.default_rng(2))
    white = whitened(off[:, None], noise.rho, noise.white, noise.sd)[:, 0]
    assert np.std(white) == pytest.approx(1.0, rel=0.02)
    assert abs(np.mean(white[1:] * white[:-1])) < 0.02


def test_snr_is_the_same_as_with_the_whole_covariance():
    n, noise = 300, Noise(0.05, 0.9, 0.2, np.inf, 0.0, 0.2, 0.0)
    t = np.linspace(0, 1, n)
    lag = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    c = noise.sd**2 * (0.8 * 0.9**lag + 0.2 * np.eye(n))
    change, own, shared = 0.2 * t**2, np.column_stack([np.ones(n), t]), t[:, None] ** 3
    columns = {"level": own[:, 0], "slope": own[:, 1], "cube": shared[:, 0]}
    got = fitted([seen(change, columns, cube=0.05)], noise).snr
    basis, inverse = np.column_stack([own, shared]), np.linalg.inv(c)
    normal = basis.T @ inverse @ basis + np.diag([0, 0, 1 / 0.05**2])
    right = basis.T @ inverse @ change
    assert got == pytest.approx(
        np.sqrt(change @ inverse @ change - right @ np.linalg.solve(normal, right)),
        rel=1e-6,
    )


def test_snr_grows_with_the_root_of_the_recordings_and_vanishes_for_a_free_nuisance():
    n, noise = 200, Noise(0.05, 0.0, 1.0, np.inf, 0.0, 0.2, 0.0)
    t = np.linspace(0, 1, n)
    line = {"level": np.ones(n), "slope": t}
    one = seen(0.1 * t**2, line)
    four = fitted([one] * 4, noise).snr
    assert four == pytest.approx(2 * fitted([one], noise).snr)
    assert fitted([seen(0.1 * t, line)], noise).snr < 1e-4
    assert fitted([seen(np.ones(9), {})], WHITE).snr == pytest.approx(3.0)


def test_snr_is_the_spread_of_the_best_estimate():
    """Amplitudes fitted to noise alone scatter by 1 / SNR."""
    n, noise = 400, Noise(0.05, 0.9, 0.0, np.inf, 0.0, 0.2, 0.0)
    t = np.linspace(0, 1, n)
    own = np.column_stack([np.ones(n), t])
    snr = fitted([seen(0.1 * t**2, {"level": own[:, 0], "slope": t})], noise).snr
    rng = np.random.default_rng(3)
    white = whitened(np.column_stack([0.1 * t**2, own]), 0.9, 0.0, 0.05)
    noises = whitened(
        np.column_stack([noisy(np.zeros(n), noise, rng) for _ in range(400)]),
        0.9,
        0.0,
        0.05,
    )
    amplitudes = np.linalg.lstsq(white, noises, rcond=None)[0][0]
    assert np.std(amplitudes) == pytest.approx(
        1 / snr, rel=0.12
    )  # 400 fits know a spread to 3.5 %


@pytest.mark.slow
def test_a_clock_error_is_no_more_visible_than_its_twin_of_scale_lets_it_be():
    """Without a stated height only the fall's curvature tells a clock, and twice its
    error is an error of scale."""
    scene = drop.draw(
        Request(("clock-error",), separated=False), np.random.default_rng(5)
    )
    most = 2 * 0.004 / np.hypot(scene.scale_sd, 5e-4)
    found = visibility(scene.changed(clock_error=0.004), "clock_error").snr
    assert 0.9 * most < found < 1.03 * most
