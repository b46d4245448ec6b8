"""A seed that falls onto a bed of seeds: what is read off, what a track tells."""

import numpy as np
import pandas as pd
import pytest

from benchtwin.measure.observe import observe
from benchtwin.sim.rigs.rise import Rise
from benchtwin.vision.measurement import Observation
from benchtwin.vision.recording import Recording, read_recording

G = 9806.65  # mm/s²


def recorded(folder, table: pd.DataFrame, name: str, more: str = "") -> Recording:
    """A recording of this table, let go 150 mm above the bed."""
    folder.mkdir()
    toml = f'rig = "bed"\n[bed]\nheight_mm = 150\n{more}'
    (folder / "recording.toml").write_text(toml)
    table.to_csv(folder / name, index=False)
    return read_recording(folder)


def by_name(found: Observation) -> dict:
    return {q.name: q for q in found.quantities}


def test_readings_give_what_is_left_of_the_energy(tmp_path):
    rises = pd.DataFrame({"bed_rebound_mm": [6.0, 9.0, 0.0, 12.0, 3.0]})
    found = by_name(observe(recorded(tmp_path / "a", rises, "readings.csv")))
    assert found["bed_rebound"].value == 6.0
    assert found["apparent_restitution"].value == pytest.approx(np.sqrt(6 / 150))


def test_seeds_that_all_stay_are_a_reading(tmp_path):
    rises = pd.DataFrame({"bed_rebound_mm": [0.0, 0.0, 0.0]})
    seen = observe(recorded(tmp_path / "a", rises, "readings.csv"))
    assert by_name(seen)["bed_rebound"].value == 0.0
    assert "every seed stayed on the bed" in seen.notes


@pytest.mark.parametrize(("depth", "doubted"), [(25.0, False), (6.0, True)])
def test_a_bed_one_layer_deep_is_doubted(tmp_path, depth, doubted):
    rises = pd.DataFrame({"bed_rebound_mm": [6.0, 9.0, 8.0]})
    more = f"depth_mm = {depth}\n[seed]\nlength_mm = 8.7\nwidth_mm = 6.8\n"
    more += "thickness_mm = 6.0\n"
    q = by_name(observe(recorded(tmp_path / "a", rises, "readings.csv", more)))
    assert ("below 3 the floor is felt" in q["bed_rebound"].reason) == doubted


@pytest.mark.parametrize("rise", [3.0, 12.0, 40.0])
@pytest.mark.parametrize("seed", [1, 2])
def test_a_track_tells_how_far_it_rises(tmp_path, rise, seed):
    """Held, let go from 150 mm, up by `rise` and down again, 500 rows a second."""
    rng = np.random.default_rng(seed)
    fall, up = np.sqrt(2 * 150 / G), np.sqrt(2 * rise / G)
    t = np.arange(0.0, 0.03 + fall + 2 * up, 0.002)
    since, after = np.clip(t - 0.03, 0, None), t - 0.03 - fall
    y = 150 - G * since**2 / 2
    y = np.where(after > 0, np.sqrt(2 * G * rise) * after - G * after**2 / 2, y)
    noisy = {
        "x_mm": rng.normal(0, 0.05, t.size),
        "y_mm": y + rng.normal(0, 0.05, t.size),
    }
    track = pd.DataFrame({"t_s": t, **noisy})
    q = by_name(observe(recorded(tmp_path / "a", track, "track.csv")))["bed_rebound"]
    assert abs(q.value - rise) < max(3 * q.sd, 0.02), q
    assert q.sd < 0.2


class Seen:
    """A state in which one seed, the second, is at a height with a speed."""

    def __init__(self, t: float, height: float, speed: float):
        self.time_s = t
        self.positions = np.array([[0, 0, 9.0], [0, 0, height]])
        self.velocities = np.array([[0, 0, 0.0], [0, 0, speed]])


@pytest.mark.parametrize("back", [0.0, 0.3, 0.9])
def test_the_simulation_sees_how_far_it_rises(back):
    """From 0.15 m onto a floor at 0, back with a share of its speed: h' = e² h; it is
    followed until it has come to its highest place, not longer."""
    g, fall, ended = G / 1000, Rise(1), None
    struck = np.sqrt(2 * 0.15 / g)
    speed = back * g * struck
    for t in np.arange(0, 1.0, 2e-4):
        tau = t - struck
        if tau < 0:
            seen = Seen(t, 0.15 - g * t**2 / 2, -g * t)
        else:
            up = min(tau, speed / g)  # then it is held at its highest place
            seen = Seen(t, speed * up - g * up**2 / 2, speed - g * up)
        if fall(None, seen):
            ended = tau
            break
    assert fall.rise_m == pytest.approx(back**2 * 0.15, abs=2e-4 * 2)
    assert ended == pytest.approx(max(speed / g, 0.02), abs=1e-3)
