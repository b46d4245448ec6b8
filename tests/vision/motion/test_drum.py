"""The dynamic angle of repose on drawn films of a drum, whose truth the drawing
knows."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from benchtwin.rigs.drum.observe import observe_drum
from benchtwin.vision.measurement import DOUBTFUL, GOOD, MeasurementError
from benchtwin.vision.recording import read_recording

SIDE, RADIUS, GRAIN = 320, 140, 7.0  # px


def film(
    folder,
    angle_deg,
    *,
    frames=80,
    seed=1,
    drift_deg=0.0,
    still=False,
    grey=(40, 190),
    noise=3.0,
    toml="",
):
    """Discs at random places under a line through a circle, others in each frame: what
    a flow looks like from frame to frame."""
    rng = np.random.default_rng(seed)
    (folder / "frames").mkdir(parents=True)
    wobble = np.convolve(
        rng.normal(0, 1.0, frames + 9), np.ones(10) / np.sqrt(10), "valid"
    )  # of the surface, as avalanches make it
    places = rng.uniform(-RADIUS, RADIUS, (4000, 2))
    shades = rng.uniform(0.8, 1.2, 4000)
    for k in range(frames):
        if not still:
            places = rng.uniform(-RADIUS, RADIUS, (4000, 2))
        slope = np.tan(
            np.radians(
                angle_deg + drift_deg * k / frames + (0.0 if still else wobble[k])
            )
        )
        inside = (np.hypot(*places.T) < RADIUS - GRAIN) & (
            places[:, 1] > slope * places[:, 0] + 0.2 * RADIUS + GRAIN
        )
        image = np.full((SIDE, SIDE), float(grey[0]), np.float32)
        for (x, y), bright in zip(places[inside], shades[inside]):
            at = (int(16 * (SIDE / 2 + x)), int(16 * (SIDE / 2 + y)))
            cv2.circle(image, at, int(16 * GRAIN), grey[1] * bright, -1, cv2.LINE_AA, 4)
        cv2.circle(image, (SIDE // 2, SIDE // 2), RADIUS + 3, 90.0, 4, cv2.LINE_AA)
        image = np.clip(image + rng.normal(0, noise, image.shape), 0, 255).astype(
            np.uint8
        )
        cv2.imwrite(str(folder / "frames" / f"{k:04d}.png"), image)
    (folder / "recording.toml").write_text(f'rig = "drum"\n{toml}')
    return read_recording(folder)


LEVEL = "[camera]\nplumb_deg = 0.0\nplumb_sd_deg = 0.1\n"


@pytest.mark.parametrize("angle", [24.0, 33.0, 41.0])
@pytest.mark.parametrize(
    "grey", [(40, 190), (200, 70)], ids=["bright seeds", "dark seeds"]
)
def test_the_angle_of_a_drawn_flow_is_found(tmp_path, angle, grey):
    """Within 3.5 of its standard deviations, which is no wider than a degree."""
    (found,) = observe_drum(
        film(tmp_path / "drum", angle, grey=grey, toml=LEVEL)
    ).quantities
    assert found.name == "flowing_angle" and found.quality == GOOD
    assert abs(found.value - angle) < 3.5 * found.sd and found.sd < 1.0


@pytest.mark.slow
def test_the_interval_holds(tmp_path):
    """95 % intervals hold the mean of the drawn angles in at least 12 of 16 films:
    fewer has a chance of 0.1 %."""
    held = 0
    for seed in range(16):
        (found,) = observe_drum(
            film(tmp_path / str(seed), 30.0, seed=seed, frames=64, toml=LEVEL)
        ).quantities
        held += abs(found.value - 30.0) < 1.96 * found.sd
    assert held >= 12


def test_a_turned_camera_is_righted_by_the_plumb_line_and_widens_the_claim_without_one(
    tmp_path,
):
    stated = film(tmp_path / "drum", 30.0, toml=LEVEL)
    turned = replace(stated, camera=stated.camera.model_copy(update={"plumb_deg": 5.0}))
    nothing = {"plumb_deg": None, "plumb_sd_deg": None}
    silent = replace(stated, camera=stated.camera.model_copy(update=nothing))
    straight, other, loose = (
        observe_drum(recording) for recording in (stated, turned, silent)
    )
    assert other.quantities[0].value == pytest.approx(
        straight.quantities[0].value - 5.0
    )
    assert loose.quantities[0].sd_common == 1.0 and any(
        "plumb_deg is missing" in note for note in loose.notes
    )


def test_a_flow_that_still_changes_is_doubtful(tmp_path):
    (found,) = observe_drum(
        film(tmp_path / "drum", 25.0, drift_deg=12.0, toml=LEVEL)
    ).quantities
    assert found.quality == DOUBTFUL and "goes on changing" in found.reason


def test_what_cannot_be_measured_is_said(tmp_path):
    with pytest.raises(MeasurementError, match="nothing is seen to flow"):
        observe_drum(film(tmp_path / "still", 30.0, still=True, noise=1.0))
    with pytest.raises(MeasurementError, match="a drum needs 24 at least"):
        observe_drum(film(tmp_path / "short", 30.0, frames=12))
    with pytest.raises(MeasurementError, match="on frames or a video"):
        observe_drum(
            replace(film(tmp_path / "other", 30.0, frames=3), evidence="track.csv")
        )
