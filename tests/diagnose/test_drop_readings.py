"""Drops of which somebody read how high they rebounded: diagnosed like impacts that
were timed."""

import numpy as np
import pytest

from benchtwin.bench.air import hop_s, through_air
from benchtwin.diagnose.bench import diagnose_bench
from benchtwin.rigs.drop.read import read_drops

HEIGHTS_MM = (100, 200, 300, 400)


def bench(folder, restitution, each=6):
    """Rebounds from several heights, e ± 1 %; restitution(height in mm) → e."""
    rng = np.random.default_rng(2)
    for height in HEIGHTS_MM:
        own = folder / f"from-{height}"
        own.mkdir(parents=True)
        e = restitution(height) * (1 + 0.01 * rng.standard_normal(each))
        read = [f"{value:.1f}" for value in height * e**2]
        (own / "readings.csv").write_text("\n".join(["rebound_height_mm", *read]))
        about = (
            f'rig = "drop"\n[drop]\nheight_mm = {height}\n[air]\ndensity_kg_m3 = 0\n'
        )
        (own / "recording.toml").write_text(about)
    return folder


def test_a_hop_lasts_as_long_as_one_that_rises_so_high():
    rise = np.array([0.01, 0.1, 0.4])
    for drag in (0.0, 0.05):
        assert through_air(hop_s(rise, drag), None, drag)[2] == pytest.approx(rise)


def test_restitution_that_falls_with_height_is_found_in_readings(tmp_path):
    def falls(height):
        return 0.6 - 0.08 * np.log(height / 200)

    found = diagnose_bench(bench(tmp_path, falls)).findings["drop"]
    assert found.alarm and "restitution" in found.explanations[0][0][0]
    steady = diagnose_bench(bench(tmp_path / "steady", lambda height: 0.6))
    assert not steady.findings["drop"].alarm


def test_rebounds_without_a_height_are_refused_in_a_sentence(tmp_path):
    bench(tmp_path, lambda height: 0.6)
    for file in tmp_path.glob("*/recording.toml"):
        file.write_text('rig = "drop"\n')
    said = {seen.trouble for seen in read_drops(tmp_path)}
    assert all("height_mm is missing" in one for one in said)
