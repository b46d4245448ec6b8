"""Tracks of drops on disk come out as plain arrays with their flights told apart, or
say why not."""

import numpy as np
import pandas as pd
import pytest

from benchtwin.rigs.drop.read import read_drops
from benchtwin.twin.seen import listed

G_MM = 9806.65


def write(folder, more=""):
    """100 mm down, a rebound of 25 mm, at 1000 frames a second."""
    first, second = np.sqrt(200 / G_MM), np.sqrt(50 / G_MM)
    time = np.arange(0, first + 2 * second, 1e-3)
    up = np.where(
        time < first,
        100 - G_MM * time**2 / 2,
        25 - G_MM * (time - first - second) ** 2 / 2,
    )
    folder.mkdir()
    pd.DataFrame({"t_s": time, "x_mm": 0.1 * time, "y_mm": up}).to_csv(
        folder / "track.csv", index=False
    )
    (folder / "recording.toml").write_text(
        f'rig = "drop"\n[drop]\nheight_mm = 100\n{more}', encoding="utf8"
    )
    return first


def test_a_track_with_its_flights(tmp_path):
    contact = write(
        tmp_path / "a",
        "[camera]\nfps = 1000.0\nmm_per_px = 0.25\nmm_per_px_sd = 0.0005\n",
    )
    (seen,) = read_drops(tmp_path)
    assert seen.recording == "a" and not seen.trouble
    assert set(seen.flight) == {-1, 0, 1}
    assert seen.contacts_s == pytest.approx([contact], abs=1e-5)
    assert seen.release_seen
    assert seen.description["camera"]["scale_sd"] == pytest.approx(0.002)
    assert (
        seen.description["camera"]["plumb_sd_deg"] == 1.0
    )  # nothing stated: not known better
    assert seen.description["air"]["density_kg_m3"] == 1.2
    assert (np.abs(seen.time_s[seen.flight >= 0] - contact) > 2e-3).all()


def in_pixels(source, folder, more=""):
    """The same track in pixels of 0.25 mm, without a clock of its own."""
    folder.mkdir()
    (folder / "recording.toml").write_text(f'rig = "drop"\n{more}', encoding="utf8")
    rows = pd.read_csv(source / "track.csv")
    pixels = {
        "frame": np.arange(len(rows)),
        "x_px": 4 * rows.x_mm,
        "y_px": 4 * rows.y_mm,
    }
    pd.DataFrame(pixels).to_csv(folder / "track.csv", index=False)


def test_a_track_that_cannot_be_used_says_why(tmp_path):
    write(tmp_path / "good")
    in_pixels(tmp_path / "good", tmp_path / "bad")
    by_name = {t.recording: t for t in read_drops(tmp_path)}
    assert not by_name["good"].trouble
    assert "fps is missing" in by_name["bad"].trouble
    with pytest.raises(FileNotFoundError):
        read_drops(tmp_path / "nowhere")


def test_a_track_in_pixels_has_its_scale_from_gravity(tmp_path):
    write(tmp_path / "a")
    in_pixels(
        tmp_path / "a",
        tmp_path / "b",
        "[camera]\nfps = 1000.0\n[air]\ndensity_kg_m3 = 0.0\n",
    )
    whole, pixels = read_drops(tmp_path)
    assert pixels.description["camera"]["mm_per_px"] == pytest.approx(0.25, rel=1e-3)
    assert pixels.description["camera"]["scale_sd"] == 0.1
    assert pixels.y_mm == pytest.approx(whole.y_mm, rel=1e-3)


def test_a_folder_is_listed_without_reading_it(tmp_path):
    write(tmp_path / "a")
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "track.csv").write_text("t_s,x_mm,y_mm\n0,0,0\n", encoding="utf8")
    first, second = listed(tmp_path)
    assert (first.rig, first.evidence, first.trouble) == ("drop", "track.csv", "")
    assert "rig is missing" in second.trouble


def test_a_frame_that_somebody_struck_out_is_in_no_flight(tmp_path):
    write(tmp_path / "a")
    write(tmp_path / "b", "[track]\nleft_out_frames = [30, 31]\n")
    whole, struck = read_drops(tmp_path)
    assert (whole.flight[[30, 31]] == 0).all()
    assert (struck.flight[[30, 31]] == -1).all()
    assert (struck.flight[[29, 32]] == 0).all()
