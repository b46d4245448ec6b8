"""The twin's seeds from a lot that was measured on photos."""

import numpy as np
import pandas as pd
import pytest

from benchtwin.bench.keys import Air, Seed
from benchtwin.twin import lot as twin_lot
from benchtwin.twin.job import Job
from benchtwin.twin.lot import measured_lot, other_seeds, representative
from benchtwin.twin.parameters import Parameters, bench
from benchtwin.vision.evidence.read_keys import read_toml
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.shape.lot import OUTLINES, SEEDS, WHOLE

HOW = {
    "only": None,
    "thickness_mm": None,
    "thickness_sd_mm": 0.0,
    "mass_g": None,
    "density_kg_m3": 1200.0,
    "spheres": 6,
}


def write(folder, sizes, thickness=None):
    """A lot of ellipses, in files as `benchtwin shape` writes them: one harmonic says
    an ellipse."""
    folder.mkdir(exist_ok=True)
    rows, lines = [], []
    for k, (length, width) in enumerate(sizes, 1):
        thick = np.nan if thickness is None else thickness[k - 1]
        rows.append(
            {
                "photo": "a.jpg",
                "seed": k,
                "kind": WHOLE,
                "x_px": 1.0,
                "y_px": 1.0,
                "length_mm": length,
                "length_sd_mm": 0.01,
                "width_mm": width,
                "width_sd_mm": 0.01,
                "thickness_mm": thick,
                "thickness_sd_mm": np.nan,
                "area_mm2": np.pi / 4 * length * width,
                "reason": "",
            }
        )
        lines.append(("a.jpg", k, 1, length / 2, 0.0, 0.0, width / 2))
    pd.DataFrame(rows).to_csv(folder / SEEDS, index=False)
    pd.DataFrame(
        lines, columns=["photo", "seed", "harmonic", "ax", "bx", "ay", "by"]
    ).to_csv(folder / OUTLINES, index=False)
    return folder


@pytest.fixture
def few_shapes(monkeypatch):
    """Six clumps of a lot are fitted, not forty: a fit takes most of a second."""
    monkeypatch.setattr(twin_lot, "MOST_SHAPES", 6)


@pytest.fixture
def folder(tmp_path):
    rng = np.random.default_rng(4)
    lengths = rng.normal(8.5, 0.5, 90)
    sizes = np.column_stack([lengths, 0.5 * lengths + rng.normal(2.5, 0.2, 90)])
    return write(tmp_path / "lot", sizes, thickness=0.85 * sizes[:, 1])


def test_mass_and_inertia_are_those_of_the_measured_shapes(folder):
    """An ellipse with its thickness is an ellipsoid: closed forms, within 0.5 % of the
    outline's 96 corners."""
    seed = measured_lot(str(folder), **{**HOW, "only": "a.jpg:3"}).seeds[0]
    row = pd.read_csv(folder / SEEDS).iloc[2]
    length, width, thick = (
        1e-3 * row.length_mm,
        1e-3 * row.width_mm,
        1e-3 * row.thickness_mm,
    )
    mass = 1200 * np.pi / 6 * length * width * thick
    assert seed.mass_kg == pytest.approx(mass, rel=5e-3)
    a, b, c = length**2, width**2, thick**2
    assert seed.inertia_kg_m2 == pytest.approx(
        mass / 20 * np.array([b + c, a + c, a + b]), rel=1e-2
    )


def test_the_clumps_kept_have_the_lot_s_means_and_covariances(folder):
    table = pd.read_csv(folder / SEEDS)
    every = table[["length_mm", "width_mm", "thickness_mm"]].to_numpy()
    kept = every[representative(every, 40)]
    assert len(kept) == 40
    assert np.abs(kept.mean(0) - every.mean(0)).max() < 0.1 * every.std(0).min()
    assert np.cov(kept.T) == pytest.approx(np.cov(every.T), rel=0.25)
    first = every[:40]  # the control: the first forty are no better drawn

    def off(some):
        return (
            np.abs(some.mean(0) - every.mean(0)).max()
            + np.abs(np.cov(some.T) - np.cov(every.T)).max()
        )

    assert off(kept) < off(first)


def test_unseen_thickness_is_stated_or_asked_for(tmp_path):
    folder = write(tmp_path / "flat", [(8.0, 6.0), (9.0, 6.5), (8.5, 6.2)])
    with pytest.raises(MeasurementError, match="state \\[seed\\] thickness_mm"):
        measured_lot(str(folder), **HOW)
    lot = measured_lot(
        str(folder), **{**HOW, "thickness_mm": 5.0, "thickness_sd_mm": 0.2}
    )
    assert 1e3 * lot.dimensions_m[:, 2].mean() == pytest.approx(5.0, abs=0.5)


@pytest.mark.slow
def test_the_stated_mass_of_one_seed_gives_the_density(folder, few_shapes):
    lot = measured_lot(str(folder), **{**HOW, "mass_g": 0.2, "density_kg_m3": None})
    assert np.mean([seed.mass_kg for seed in lot.seeds]) == pytest.approx(
        2e-4, rel=1e-6
    )


def test_a_seed_that_is_not_in_the_lot_is_named(folder):
    with pytest.raises(MeasurementError, match=r"no such seed; there is a\.jpg:1"):
        measured_lot(str(folder), **{**HOW, "only": "b.jpg:1"})


def test_a_bench_file_s_lot_counts_from_its_own_folder_and_must_be_one(
    folder, tmp_path
):
    file = tmp_path / "bench.toml"
    file.write_text('[seed]\nlot = "lot"\n')
    assert read_toml(file)["seed"]["lot"] == str(folder)
    file.write_text('[seed]\nlot = "nowhere"\n')
    with pytest.raises(MeasurementError, match="no folder that benchtwin shape wrote"):
        read_toml(file)


def test_the_bench_draws_from_the_lot_and_its_job_knows_what_the_lot_holds(
    folder, few_shapes
):
    seed = Seed(lot=str(folder), density_kg_m3=1200.0)
    of = bench(Parameters(), "pile", seed, Air())
    assert len({id(s) for s in of.draw(np.random.default_rng(1), 100)}) == 6

    def key():
        return Job("drop", Parameters(), {"seed": {"lot": str(folder)}}, (1,)).key

    before = key()
    table = pd.read_csv(folder / SEEDS)
    table.loc[0, "length_mm"] += 0.5
    table.to_csv(folder / SEEDS, index=False)
    assert key() != before


def test_simpler_seeds_to_compare_with(folder):
    others = other_seeds({"lot": str(folder), "density_kg_m3": 1200.0})
    assert (
        others["typical seed"]["lot_seed"].startswith("a.jpg:")
        and "lot" not in others["ellipsoids"]
    )
    sizes = pd.read_csv(folder / SEEDS)
    assert others["ellipsoids"]["length_mm"] == pytest.approx(sizes.length_mm.mean())
