"""Tracks of drops on disk come out as plain arrays with their flights told apart, or say why not."""

import numpy as np
import pandas as pd
import pytest

from calibrate.twin.tracks import read_drops

G_MM = 9806.65


def write(folder, more=""):
    """100 mm down, a rebound of 25 mm, at 1000 frames a second."""
    first, second = np.sqrt(200 / G_MM), np.sqrt(50 / G_MM)
    time = np.arange(0, first + 2 * second, 1e-3)
    up = np.where(time < first, 100 - G_MM * time**2 / 2, 25 - G_MM * (time - first - second) ** 2 / 2)
    folder.mkdir()
    pd.DataFrame({"t_s": time, "x_mm": 0.1 * time, "y_mm": up}).to_csv(folder / "track.csv", index=False)
    (folder / "recording.toml").write_text(f'rig = "drop"\n[drop]\nheight_mm = 100\n{more}', encoding="utf8")
    return first


def test_a_track_with_its_flights(tmp_path):
    contact = write(tmp_path / "a", "[camera]\nfps = 1000.0\nmm_per_px = 0.25\nmm_per_px_sd = 0.0005\n")
    (seen,) = read_drops(tmp_path)
    assert seen.recording == "a" and not seen.trouble
    assert set(seen.flight) == {-1, 0, 1}
    assert seen.contacts_s == pytest.approx([contact], abs=1e-5)
    assert seen.release_seen
    assert seen.description["camera"]["scale_sd"] == pytest.approx(0.002)
    assert seen.description["camera"]["plumb_sd_deg"] == 0.5  # nothing stated: not known better
    assert seen.description["air"]["density_kg_m3"] == 1.2
    assert (np.abs(seen.time_s[seen.flight >= 0] - contact) > 2e-3).all()


def test_a_track_that_cannot_be_used_says_why(tmp_path):
    write(tmp_path / "good")
    bad = tmp_path / "bad"
    bad.mkdir()
    (bad / "recording.toml").write_text('rig = "drop"\n', encoding="utf8")
    rows = pd.read_csv(tmp_path / "good" / "track.csv")
    pd.DataFrame({"frame": np.arange(len(rows)), "x_px": rows.x_mm, "y_px": rows.y_mm}).to_csv(bad / "track.csv", index=False)
    by_name = {t.recording: t for t in read_drops(tmp_path)}
    assert not by_name["good"].trouble
    assert "mm_per_px" in by_name["bad"].trouble
    with pytest.raises(FileNotFoundError):
        read_drops(tmp_path / "nowhere")
