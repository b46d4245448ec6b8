"""Share of a plate that seeds cover, on drawn plates of which every pixel is known."""

import cv2
import numpy as np
import pytest

from benchtwin.measure.observe import observe
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.recording import read_recording
from benchtwin.vision.shape.plate_coverage import measure_coverage

BOARD, SEED = (120, 125, 130), (200, 175, 120)


def plate(
    rng: np.random.Generator, *, pitch: float, seed=SEED, board=BOARD, noise: float = 4
) -> tuple[np.ndarray, float]:
    """Seeds of 40 × 36 px about the places of a hexagonal grid, turned any way, each
    of another brightness and darker at its rim; and what they cover."""
    image, covered = np.full((800, 800, 3), board, float), np.zeros((800, 800), bool)
    around = np.mgrid[-25:26, -25:26]
    for row in range(int(750 / pitch / 0.866)):
        for column in range(int(740 / pitch)):
            at = 30 + pitch * np.array([0.866 * row, column + row % 2 / 2])
            middle = at + rng.normal(0, 0.04 * pitch, 2)
            corner = np.floor(middle).astype(int)
            y, x = around - (middle - corner)[:, None, None]
            turn, bright = rng.uniform(0, np.pi), rng.uniform(0.8, 1.1)
            along = x * np.cos(turn) + y * np.sin(turn)
            across = y * np.cos(turn) - x * np.sin(turn)
            deep = 1 - (along / 20) ** 2 - (across / 18) ** 2
            lit = (0.7 + 0.3 * np.sqrt(np.clip(deep, 0, 1)))[..., None]
            here = tuple(slice(c - 25, c + 26) for c in np.clip(corner, 25, 774))
            image[here] = np.where(
                deep[..., None] > 0, bright * lit * seed, image[here]
            )
            covered[here] |= deep > 0
    image, covered = image[50:650, 50:650], covered[50:650, 50:650]
    image = cv2.GaussianBlur(image, (0, 0), 1.0) + rng.normal(0, noise, image.shape)
    return np.clip(image, 0, 255).astype(np.uint8), float(covered.mean())


@pytest.mark.parametrize("pitch", [38.0, 44.0, 55.0])
@pytest.mark.parametrize(
    ("seed", "board"), [(SEED, BOARD), ((60, 45, 30), (200, 200, 195))]
)
def test_what_seeds_cover_is_found(pitch, seed, board):
    """From .43 to .88, pale seeds on grey and dark ones on white: whichever covers more
    of the picture."""
    image, true = plate(np.random.default_rng(1), pitch=pitch, seed=seed, board=board)
    found = measure_coverage(image)
    assert abs(found.share - true) < 2 * found.sd
    assert found.sd < 0.04


def test_seeds_that_do_not_stand_out_are_not_guessed():
    rng = np.random.default_rng(1)
    grain = cv2.GaussianBlur(rng.normal(0, 60, (600, 600, 3)), (0, 0), 8.0)
    image = np.clip(BOARD + grain, 0, 255).astype(np.uint8)
    with pytest.raises(MeasurementError, match="do not stand out"):
        measure_coverage(image)


def recording(folder, keys: str):
    folder.mkdir()
    image, _ = plate(np.random.default_rng(2), pitch=42.0)
    cv2.imwrite(str(folder / "plate.png"), image[..., ::-1])
    toml = 'rig = "drop"\n[drop]\nheight_mm = 310\nplate = "seeds"\n' + keys
    (folder / "recording.toml").write_text(toml)
    (folder / "readings.csv").write_text("rebound_height_mm\n40\n55\n47\n")
    return read_recording(folder)


def test_a_recording_takes_it_from_its_photo(tmp_path):
    """With its sd, and a picture of what was found; a stated one that contradicts the
    photo is told."""
    _, true = plate(np.random.default_rng(2), pitch=42.0)
    told = recording(tmp_path / "a", 'plate_photo = "plate.png"\n')
    assert abs(told.drop.coverage - true) < 2 * told.drop.coverage_sd
    assert "plate_photo" not in told.as_built
    assert observe(told).pictures["plate"].ndim == 3
    with pytest.raises(MeasurementError, match=r"coverage = 0\.4 is stated"):
        recording(tmp_path / "b", 'plate_photo = "plate.png"\ncoverage = 0.4\n')
    with pytest.raises(MeasurementError, match="there is no file"):
        recording(tmp_path / "c", 'plate_photo = "other.png"\n')
