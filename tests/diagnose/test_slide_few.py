"""Diagnosis of slides past light gates on a plate that tilts: none refused, clean ones
raise no alarm; a plate that stands is told."""

import numpy as np
import pytest
from test_slide_few_rows import way

from benchtwin.rigs.slide import problem
from benchtwin.rigs.slide.diagnose import diagnose_slide
from benchtwin.rigs.slide.read import read_slides
from benchtwin.rigs.slide.session import assemble

GATES = np.array([20.0, 80, 160, 260, 400])
RATE, START = 3.0, 10.0


def bench(
    folder, rng, rate: float, start: str = f"start_deg = {START}\n", loss: float = 0.0
) -> None:
    folder.mkdir()
    camera = "[camera]\nmm_per_px = 1.0\nmm_per_px_sd = 0.001\n"
    plate = f"[slide]\n{start}" + (f"tilt_rate_deg_s = {rate}\n" if rate else "")
    (folder / "bench.toml").write_text(
        f'rig = "slide"\n{camera}{plate}[air]\ndensity_kg_m3 = 0.0\n'
    )
    for k in range(10):
        angle = np.degrees(np.arctan(0.35 + 0.002 * rng.standard_normal()))
        onset = (angle - START) / RATE
        t, x = way(angle, RATE, float(np.tan(np.radians(angle))) - loss)
        time = (
            onset
            + np.interp(GATES / 1000, x, t)
            + 1e-4 * rng.standard_normal(len(GATES))
        )
        run = folder / f"s-{k}"
        run.mkdir()
        (run / "recording.toml").write_text("")
        (run / "gates.csv").write_text(
            "x_mm,t_s\n" + "".join(f"{g},{s:.6f}\n" for g, s in zip(GATES, time))
        )


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_slides_past_gates_are_diagnosed(tmp_path, seed):
    bench(tmp_path / "a", np.random.default_rng(seed), RATE)
    found = diagnose_slide(read_slides(tmp_path / "a"), np.random.default_rng(0))
    assert len(found.recordings) == 10 and not found.alarm


@pytest.mark.parametrize("degree", [3, 2])
def test_friction_lost_at_the_onset_is_seen_past_gates(tmp_path, monkeypatch, degree):
    """.01 of .35, which .1 ms at gates see well; as a control, with noise that is
    estimated about parabolas, as if the pull did not grow while the plate tilts."""
    monkeypatch.setattr(problem, "DEGREE_TILTING", degree)
    bench(tmp_path / "a", np.random.default_rng(1), RATE, loss=0.01)
    found = diagnose_slide(read_slides(tmp_path / "a"), np.random.default_rng(0))
    assert found.alarm == (degree == 3)
    if found.alarm:
        assert "kinetic-friction" in found.names


def test_a_plate_that_stands_is_told_from_one_of_unknown_angle(tmp_path):
    rng = np.random.default_rng(1)
    bench(tmp_path / "unknown", rng, 0.0, start="")
    unknown = read_slides(tmp_path / "unknown")
    assert all("[slide] start_deg" in seen.trouble for seen in unknown)
    bench(tmp_path / "stands", rng, 0.0)
    stands = assemble(read_slides(tmp_path / "stands"))
    assert all(run.in_motion for run in stands.runs)
    assert any("the plate is taken to stand at" in note for note in stands.notes)
