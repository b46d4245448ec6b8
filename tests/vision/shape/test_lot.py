"""Lots of seeds: outlines as Fourier terms against closed forms, drawn spreads
measured, written, and read again."""

import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from drawn_seed_photos import Scene, caliper, draw
from PIL import Image
from scipy.spatial import cKDTree
from typer.testing import CliRunner

from benchtwin.command_line import app
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.shape.lot import (
    OUTLINES,
    SEEDS,
    TOUCHING,
    WHOLE,
    read_lot,
)
from benchtwin.vision.shape.lot_photos import View, measure_lot_photos, with_thickness
from benchtwin.vision.shape.outline import (
    aligned_outline,
    centroid,
    feret,
    fourier_terms,
    from_fourier_terms,
)

T = np.linspace(0, 2 * np.pi, 720, endpoint=False)
FLAT = View(0.1, 2e-5, math.inf)


def bean(a: float, b: float) -> np.ndarray:
    """An egg that is bent: no symmetry is left."""
    x, y = a * np.cos(T), b * np.sin(T) * (1 + 0.2 * np.cos(T))
    return np.column_stack([x, y + 0.1 * x**2 / a])


def test_a_circle_s_terms_are_its_radius_and_nothing_else():
    found = fourier_terms(3.0 * np.column_stack([np.cos(T), np.sin(T)]))
    assert found[0] == pytest.approx([3.0, 0.0, 0.0, 3.0], abs=1e-4)
    assert np.abs(found[1:]).max() < 1e-3


def test_an_outline_comes_back_from_its_terms():
    """A bean within 1 % of its half width, its area within 0.1 %: what twelve harmonics
    leave."""
    points = aligned_outline(bean(4.0, 3.0) * [1, -1], 3000)
    back = from_fourier_terms(fourier_terms(points), 720)
    assert cKDTree(points).query(back)[0].max() < 0.03
    assert centroid(back)[1] == pytest.approx(centroid(points)[1], rel=1e-3)


@pytest.mark.parametrize("turn", [0.0, 1.0, 2.5, 4.0])
@pytest.mark.parametrize("mirror", [1.0, -1.0])
def test_however_a_seed_lies_its_outline_is_laid_the_same_way(turn, mirror):
    spin = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    lying = (bean(4.0, 3.0) * [1, mirror]) @ spin.T + [30.0, 70.0]
    laid, straight = aligned_outline(lying), aligned_outline(bean(4.0, 3.0))
    assert cKDTree(straight).query(laid)[0].max() < 0.05
    assert fourier_terms(laid) == pytest.approx(fourier_terms(straight), abs=0.03)
    assert np.ptp(laid[:, 0]) == pytest.approx(feret(lying)[0], rel=1e-3)


@pytest.fixture(scope="module")
def photos(tmp_path_factory):
    """A spread of superellipses with soft shadows, and what is true of each."""
    folder = tmp_path_factory.mktemp("photos")

    def drawn(name, rng=1, family="superellipse", **scene):
        image, seeds = draw(Scene(family, **scene), np.random.default_rng(rng))
        Image.fromarray(image).save(folder / name)
        return folder / name, seeds

    return drawn


def errors(seeds, rows):
    """Relative errors of length and width, and the same in the claimed sds, seed by
    seed."""
    tree = cKDTree(rows[["x_px", "y_px"]].to_numpy() * 0.1)
    found = [rows.iloc[tree.query(seed.centre_mm)[1]] for seed in seeds]
    off = np.array(
        [
            (row.length_mm - seed.sizes_mm[0], row.width_mm - seed.sizes_mm[1])
            for row, seed in zip(found, seeds)
        ]
    )
    sds = np.array([(row.length_sd_mm, row.width_sd_mm) for row in found])
    return off / [seed.sizes_mm for seed in seeds], off / sds


@pytest.mark.slow
def test_a_drawn_spread_is_measured_without_bias_and_its_intervals_hold(photos):
    """60 seeds: mean error ≤ 0.3 %, at least 52 of 60 within 1.96 sd (fewer: chance 1
    %)."""
    photo, seeds = photos("spread.png", shadow=0.3)
    rows = measure_lot_photos([photo], FLAT, lambda name: None).seeds
    assert len(rows) == 60 and (rows["kind"] == WHOLE).all()
    share, sds = errors(seeds, rows)
    assert np.abs(share.mean(axis=0)).max() < 0.003
    assert ((np.abs(sds) < 1.96).sum(axis=0) >= 52).all()


def test_touching_seeds_are_split_and_told_apart_from_those_that_lie_alone(photos):
    photo, seeds = photos("pairs.png", groups=(2,) * 10 + (1,) * 10)
    rows = measure_lot_photos([photo], FLAT, lambda name: None).seeds
    assert len(rows) == len(seeds) == 30
    assert (rows["kind"] == TOUCHING).sum() == 20 and (
        rows["kind"] == WHOLE
    ).sum() == 10


@pytest.mark.slow
def test_a_stated_distance_undoes_what_height_adds_an_unknown_one_is_in_the_interval(
    photos,
):
    """Ellipsoids 6 mm thick seen from 300 mm: each looks 1.5 % larger."""
    photo, truth = photos(
        "near.png", family="ellipse", distance_mm=300.0, groups=(1,) * 30
    )
    near, unknown, flat = (
        measure_lot_photos([photo], replace(FLAT, distance_mm=d), lambda name: None)
        for d in (300.0, None, math.inf)
    )
    for k, name in enumerate(("length", "width")):
        mean = np.mean([seed.sizes_mm[k] for seed in truth])
        stated, silent, scanned = (
            s.seeds[f"{name}_mm"].mean() / mean - 1 for s in (near, unknown, flat)
        )
        assert abs(stated) < 1.96 * near.common < 0.005
        assert silent == scanned > 0.01  # the control: nothing is taken back
        assert silent < 3 * unknown.common
    assert (
        any("distance is not stated" in note for note in unknown.notes)
        and flat.common < 1e-3
    )


@pytest.mark.slow
def test_thickness_is_read_from_the_same_seeds_on_their_side_one_by_one_or_for_the_lot(
    photos,
):
    top, _ = photos("top.png", groups=(1,) * 20)
    other, _ = photos("other.png", rng=7, groups=(1,) * 24, width_mm=(5.9, 0.2))
    spread, elsewhere = (
        measure_lot_photos([photo], FLAT, lambda name: None) for photo in (top, other)
    )
    again, lot = with_thickness(
        spread, spread
    )  # seen from the side it looks the same: bodies of revolution
    assert lot is None and again.seeds["thickness_mm"].equals(again.seeds["width_mm"])
    kept, lot = with_thickness(spread, elsewhere)
    assert (
        kept.seeds["thickness_mm"].isna().all()
        and lot[2] == 24
        and lot[0] == pytest.approx(5.9, abs=0.15)
    )


@pytest.fixture(scope="module")
def lot(photos, tmp_path_factory):
    photo, _ = photos("lot.png", groups=(1,) * 25)
    out = tmp_path_factory.mktemp("lots") / "lot"
    said = CliRunner().invoke(
        app,
        [
            "shape",
            str(photo),
            "--out",
            str(out),
            "--mm-per-px",
            "0.1",
            "--mm-per-px-sd",
            "0.00002",
            "--scanner",
        ],
    )
    assert said.exit_code == 0, said.output
    return out, said.output


def test_the_command_leaves_a_lot_that_can_be_read_and_looked_at(lot):
    out, said = lot
    read = read_lot(out)
    assert len(read.seeds) == 25 and "25 whole" in said and "length" in said
    for seed in read.seeds:
        assert caliper(seed.outline_mm(720)) == pytest.approx(
            (seed.length_mm, seed.width_mm), rel=0.01
        )
        assert np.isnan(seed.thickness_mm)
    assert (out / "outlines.png").stat().st_size > 5000 and (
        out / "sizes.png"
    ).stat().st_size > 5000
    assert (out / "overlays" / "lot.png").stat().st_size > 50_000


def test_what_stands_in_the_way_is_said_in_one_sentence(lot, photos, tmp_path):
    out, _ = lot

    def said(*arguments):
        result = CliRunner().invoke(app, ["shape", *map(str, arguments)])
        assert result.exit_code != 0 and "Traceback" not in result.output
        return result.output

    photo, _ = photos("lot.png", groups=(1,) * 25)
    assert "state --mm-per-px" in said(photo, "--out", tmp_path / "new")
    assert "--overwrite" in said(photo, "--out", out)
    assert "no such file" in said(tmp_path / "none.png", "--out", tmp_path / "new")
    assert "a scanner has no distance" in said(
        photo, "--out", tmp_path / "new", "--scanner", "--distance-mm", "300"
    )
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "thesis.doc").write_text("mine")
    assert (
        "thesis.doc" in said(photo, "--out", tmp_path / "full", "--overwrite")
        and (tmp_path / "full" / "thesis.doc").exists()
    )
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize(
    ("file", "spoil", "says"),
    [
        (SEEDS, lambda t: t.assign(length_mm="long"), "is not a number"),
        (SEEDS, lambda t: t.drop(columns="kind"), "column kind is missing"),
        (SEEDS, lambda t: t.assign(kind="husk"), "no whole seed"),
        (SEEDS, lambda t: t.assign(width_mm=0.0), "width_mm must be"),
        (OUTLINES, lambda t: t[t.seed > 1], "no outline of seed"),
        (OUTLINES, lambda t: t[t.harmonic != 2], "without a gap"),
    ],
)
def test_a_spoilt_lot_is_refused_with_file_and_place(lot, tmp_path, file, spoil, says):
    out, _ = lot
    for name in (SEEDS, OUTLINES):
        table = pd.read_csv(out / name)
        (spoil(table) if name == file else table).to_csv(tmp_path / name, index=False)
    with pytest.raises(MeasurementError, match=says) as trouble:
        read_lot(tmp_path)
    assert file in str(trouble.value) or says == "no outline of seed"


def test_a_lot_s_files_must_be_there(tmp_path):
    with pytest.raises(MeasurementError, match="benchtwin shape writes it"):
        read_lot(tmp_path)
