"""Slides of few rows on a plate of stated angle: kinetic friction holds its interval,
drawn by integrating the motion."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from benchtwin.bench.keys import Air, Camera
from benchtwin.bench.priors import stated_sd
from benchtwin.rigs.slide.keys import Slide
from benchtwin.rigs.slide.measure import measure_slide
from benchtwin.vision.motion.track import make_track
from benchtwin.vision.recording import Recording

G = 9.80665


def way(
    start_deg: float, rate_deg_s: float, mu: float
) -> tuple[np.ndarray, np.ndarray]:
    """Times and places [s, m] of a block let go at t = 0, until it has slid 0.5 m."""

    def go(t, y):
        theta, rate = np.radians(start_deg + rate_deg_s * t), np.radians(rate_deg_s)
        return [y[1], G * np.sin(theta) - mu * (G * np.cos(theta) - 2 * rate * y[1])]

    def end(t, y):
        return y[0] - 0.5

    end.terminal = True
    exact = {"rtol": 1e-10, "atol": 1e-12, "dense_output": True}
    found = solve_ivp(go, (0, 10), [0.0, 0.0], events=end, **exact)
    t = np.linspace(0, found.t[-1], 2000)
    return t, found.sol(t)[0]


def recording(tmp_path, evidence: str, **slide) -> Recording:
    camera = Camera(mm_per_px=0.5, mm_per_px_sd=0.001)
    return Recording(
        "s",
        tmp_path,
        "slide",
        evidence,
        (tmp_path / evidence,),
        slide=Slide(**slide),
        camera=camera,
        air=Air(density_kg_m3=0.0),  # the slides are drawn without air
    )


@pytest.mark.slow
@pytest.mark.parametrize("gates", [True, False])
@pytest.mark.parametrize("rate", [0.0, 2.0])
def test_intervals_of_few_rows_hold(tmp_path, gates, rate):
    rng, good = np.random.default_rng(11), []
    for _ in range(150):
        start = rng.uniform(18, 35)
        mu = np.tan(np.radians(start)) - rng.uniform(0.03, 0.2)
        t, x = way(start, rate, mu)
        if gates:
            seen = 1000 * np.sort(rng.uniform(0.03, 0.48, rng.integers(4, 7)))
            time = np.interp(seen / 1000, x, t) + 1e-4 * rng.standard_normal(len(seen))
        else:
            time = np.linspace(0, t[-1], rng.integers(5, 11))
            scale = 1 + 0.002 * rng.standard_normal()
            seen = (
                1000 * np.interp(time, t, x) + 0.5 * rng.standard_normal(len(time))
            ) * scale
        off = stated_sd("level-plate") * rng.standard_normal()
        stated = {"start_deg": start + off} | (
            {"tilt_rate_deg_s": rate} if rate else {}
        )
        about = recording(tmp_path, "gates.csv" if gates else "track.csv", **stated)
        found = {
            q.name: q
            for q in measure_slide(make_track(time, seen, 0 * seen), about).quantities
        }
        assert (
            found["static_friction"].quality == "failed"
            and "do not show when" in found["static_friction"].reason
        )
        good.append(
            abs(found["kinetic_friction"].value - mu)
            <= 1.96 * found["kinetic_friction"].sd
        )
    print(f"gates {gates}, {rate} °/s: {np.mean(good):.3f}")
    assert np.mean(good) >= 0.92


def test_an_angle_that_nobody_stated_is_asked_for(tmp_path):
    time = np.linspace(0, 0.5, 5)
    found = measure_slide(
        make_track(time, 500 * time**2, 0 * time), recording(tmp_path, "gates.csv")
    )
    assert "[slide] start_deg" in found.quantities[2].reason
    short = measure_slide(
        make_track(time[:3], 500 * time[:3] ** 2, 0 * time[:3]),
        recording(tmp_path, "gates.csv", start_deg=20),
    )
    assert "3 rows of sliding" in short.quantities[2].reason
