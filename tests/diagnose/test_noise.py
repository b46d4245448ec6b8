"""The noise of a track is found again; judged by it clean tracks raise no alarm, judged
as white noise nearly all do."""

import math

import numpy as np
import pytest

from benchtwin.infer.noise import (
    Stretch,
    estimate,
    frame_lag,
    maximum_draws,
    outliers,
    refined_level_sd,
    whiten,
)

G, FPS, SD = 9.80665, 5200.0, 5e-5
FALLS = (0.310, 0.100, 0.035, 0.012)  # a fall and three rebounds [m]


def drawn(n, rho, white, rng):
    """White + OU noise of unit variance."""
    shocks, out = rng.normal(size=n), np.empty(n)
    out[0] = shocks[0]
    for i in range(1, n):
        out[i] = rho * out[i - 1] + np.sqrt(1 - rho**2) * shocks[i]
    return np.sqrt(1 - white) * out + np.sqrt(white) * rng.normal(size=n)


def bouncing():
    """A drop: per flight τ [s] and the seven bends that candidates give it, in m per
    unit of each."""
    flights = []
    for i, fall in enumerate(FALLS):
        time = np.sqrt(2 * fall / G)
        tau = np.arange(0 if i == 0 else -time, time, 1 / FPS)
        height = fall - G * tau**2 / 2
        flights.append((tau, height))
    return flights


def candidates(tau, height):
    """(n, 2, 7): drag, side force ∝ v, draught, scale, roll, perspective up and across;
    x then z."""
    nil = np.zeros_like(tau)
    columns = [
        (nil, np.sign(tau) * tau**4),
        (tau**3, nil),
        (np.abs(tau) ** 3, nil),
        (nil, tau**2),
        (tau**2, nil),
        (nil, height**2),
        (nil, tau**3),
    ]
    return np.stack([np.column_stack(pair) for pair in columns], axis=-1)


def test_whitened_noise_is_white_despite_gaps():
    rng = np.random.default_rng(5)
    series = drawn(20_000, 0.9, 0.3, rng)
    kept = np.flatnonzero(rng.random(20_000) > 0.1)
    clean = whiten(series[kept][:, None, None], frame_lag(kept)[:, None], 0.9, 0.3)[0][
        :, 0, 0
    ]
    assert clean.std() == pytest.approx(1, abs=4 / np.sqrt(2 * len(kept)))
    lags = [np.mean(clean[k:] * clean[:-k]) for k in (1, 2, 5, 20)]
    assert np.abs(lags).max() < 4 / np.sqrt(len(kept))


@pytest.mark.parametrize(
    ("rho", "white"), [(0.0, 0.0), (0.5, 0.0), (0.9, 0.3), (0.97, 0.0)]
)
def test_noise_is_found_beside_a_flexible_curve(rho, white):
    rng = np.random.default_rng(3)
    stretches = []
    for _ in range(4):
        u = np.linspace(-1, 1, 1300)
        stretches.append(
            Stretch(
                np.polynomial.legendre.legvander(u, 6),
                drawn(1300, rho, white, rng),
                frame_lag(np.arange(1300)),
            )
        )
    found = estimate(stretches)
    truth = white + (1 - white) * (1 + rho) / (1 - rho)
    # what scores depend on: the power at low frequency; 4 sd as the estimate itself
    # states them, and 10 % for the white share
    assert abs(np.log(found.low_frequency / truth)) < 4 * found.log_level_sd + 0.1


def test_uncertainty_of_noise_power_is_right_for_many_rows():
    """20,000 rows, of which the likelihood is narrow; each estimate's own sd beside how
    far it is off."""
    rng, off = np.random.default_rng(6), []
    u = np.linspace(-1, 1, 5000)
    for _ in range(5):
        parts = [
            Stretch(
                np.polynomial.legendre.legvander(u, 4),
                drawn(5000, 0.3, 0.12, rng),
                frame_lag(np.arange(5000)),
            )
            for _ in range(4)
        ]
        found = estimate(parts)
        whitened = [
            whiten(
                np.column_stack([s.design, s.data])[:, None],
                s.lag[:, None],
                found.rho,
                found.white,
            )[0][:, 0]
            for s in parts
        ]
        left = [
            w[:, -1] - w[:, :-1] @ np.linalg.lstsq(w[:, :-1], w[:, -1], rcond=None)[0]
            for w in whitened
        ]
        power = (
            np.mean([(x**2).sum() / (len(x) - 5) for x in left]) * found.low_frequency
        )
        assert found.log_level_sd < 0.05  # the scatter of such estimates is .025
        off.append(np.log(power / (0.12 + 0.88 * 1.3 / 0.7)) / found.log_level_sd)
    assert (
        np.sqrt(np.mean(np.square(off))) < 2.0
    )  # 5 numbers of unit variance: by chance 1e-3


def false_alarms(rho, rng, *, tracks):
    """Fractions of clean tracks in which any of 7 candidates lowers the BIC: residuals
    taken for white, and whitened."""
    naive = clean = 0
    for _ in range(tracks):
        white_rows, clean_rows, stretches, parts = [], [], [], []
        for tau, height in bouncing():
            data = SD * np.column_stack(
                [drawn(len(tau), rho, 0.0, rng), drawn(len(tau), rho, 0.0, rng)]
            )
            bends = candidates(tau, height)
            nuisance = np.column_stack([np.ones_like(tau), tau])
            parts.append((bends, nuisance, data))
            basis = np.polynomial.legendre.legvander(tau / np.abs(tau).max(), 6)
            stretches += [
                Stretch(
                    np.linalg.qr(basis)[0],
                    data[:, axis],
                    frame_lag(np.arange(len(tau))),
                )
                for axis in (0, 1)
            ]
        found = estimate(stretches)
        for bends, nuisance, data in parts:
            for axis in (0, 1):
                block = np.column_stack([nuisance, bends[:, axis], data[:, axis]])
                lag = frame_lag(np.arange(len(block)))[:, None]
                white = whiten(block[:, None, :], lag, found.rho, found.white)[0][:, 0]
                white_rows.append(
                    block[:, 2:]
                    - nuisance @ np.linalg.lstsq(nuisance, block[:, 2:], rcond=None)[0]
                )
                own = white[:, :2]
                clean_rows.append(
                    white[:, 2:]
                    - own @ np.linalg.lstsq(own, white[:, 2:], rcond=None)[0]
                )
        naive += bic_alarm(np.vstack(white_rows))
        clean += bic_alarm(np.vstack(clean_rows))
    return naive / tracks, clean / tracks


def bic_alarm(rows) -> bool:
    """Whether any one column earns its ln n."""
    columns, data = rows[:, :-1], rows[:, -1]
    gain = (columns.T @ data) ** 2 / (columns**2).sum(0)
    n, left = len(data), data @ data
    return bool((n * np.log(left / (left - gain)) > np.log(n)).any())


def test_assuming_white_noise_gives_false_alarms_and_whitening_does_not():
    """missing-physics.md §1.1: 3/35/98/100 % at ρ 0/.5/.9/.97 against 2.5/2.5/5/7.5 %;
    here fewer tracks, same pattern."""
    rng = np.random.default_rng(11)
    naive, clean = false_alarms(0.9, rng, tracks=4)
    assert naive >= 0.75  # 3 of 4; at 98 % fewer has a chance of 0.2 %
    assert clean <= 0.5  # 2 of 4; at 5 % more has a chance of 0.05 %
    control, same = false_alarms(0.0, rng, tracks=3)
    assert (
        control <= 0.34 and same <= 0.34
    )  # the control: on white noise the white-noise judge is right too


def test_long_correlation_is_found_beside_many_short_stretches():
    """ρ = 0.97 in flights of 250 frames, beside four times as many of 45, of which 8
    correlation lengths would allow 0.82."""
    rng = np.random.default_rng(5)
    sizes = [250] * 8 + [45] * 32
    parts = [
        Stretch(
            np.vander(np.linspace(-1, 1, n), 3),
            drawn(n, 0.97, 0.06, rng),
            frame_lag(np.arange(n)),
        )
        for n in sizes
    ]
    found = estimate(parts)
    true = 0.06 + 0.94 * 1.97 / 0.03  # power at low frequency over the variance
    assert found.rho > 0.94 and 0.4 * true < found.low_frequency < 2 * true


def test_outliers_are_seen():
    rng = np.random.default_rng(2)
    series = rng.normal(size=5000)
    series[100] = 9.0
    assert list(np.flatnonzero(outliers(series))) == [100]


def test_threshold_of_the_maximum_score():
    rng = np.random.default_rng(4)

    def threshold(covariance, **more):
        return float(
            np.quantile(maximum_draws(covariance, rng, draws=100_000, **more), 0.95)
        )

    many = threshold(np.eye(7))
    assert many == pytest.approx(2.69, abs=0.02)  # Φ⁻¹ of (1 − .05)^(1/7), two-sided
    assert threshold(np.ones((7, 7))) == pytest.approx(1.96, abs=0.02)
    assert threshold(np.eye(7), level_sd=0.2) > many


def test_smooth_columns_refine_the_noise_power():
    """To a half and by 32 directions, of which each tells ln of it to √2: √(2/(8 +
    32))."""
    assert refined_level_sd(0.5, 32) == pytest.approx(
        math.sqrt(2 / 40)
    ) and refined_level_sd(0.5, 0) == pytest.approx(0.5)
