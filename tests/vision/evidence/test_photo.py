"""Photos: every depth and colour read as it is, everything damaged refused with its
name."""

import cv2
import numpy as np
import pillow_heif
import pytest
from PIL import Image

from benchtwin.vision.evidence.photo import read_photo
from benchtwin.vision.measurement import MeasurementError


def noise(shape, dtype, seed=0):
    return (
        np.random.default_rng(seed)
        .integers(0, np.iinfo(dtype).max, shape)
        .astype(dtype)
    )


@pytest.mark.parametrize("suffix", ["png", "tif"])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("shape", [(40, 60), (40, 60, 3)])
def test_every_depth_comes_back_exactly(tmp_path, suffix, dtype, shape):
    pixels = noise(shape, dtype)
    file = tmp_path / f"a.{suffix}"
    cv2.imwrite(str(file), pixels if pixels.ndim == 2 else pixels[..., ::-1])
    read = read_photo(file)
    assert read.dtype == dtype
    np.testing.assert_array_equal(read, pixels)


def test_pictures_that_are_not_kept_to_the_last_bit(tmp_path):
    smooth = cv2.GaussianBlur(noise((64, 80, 3), np.uint8), (0, 0), 4)
    for suffix in ("jpg", "bmp", "webp", "heic", "heif"):
        Image.fromarray(smooth).save(tmp_path / f"a.{suffix}")
        assert (
            np.abs(read_photo(tmp_path / f"a.{suffix}").astype(int) - smooth).mean() < 3
        )


def test_a_phone_held_sideways_is_turned_upright(tmp_path):
    pixels = cv2.GaussianBlur(noise((40, 60, 3), np.uint8), (0, 0), 3)
    exif = Image.Exif()
    exif[0x0112] = 6  # the camera was turned by 90°
    Image.fromarray(pixels).save(tmp_path / "a.png", exif=exif)
    np.testing.assert_array_equal(read_photo(tmp_path / "a.png"), np.rot90(pixels, -1))


def test_transparency_lies_on_white(tmp_path):
    rgba = np.zeros((10, 10, 4), np.uint8)
    rgba[:5, :, 3] = 255
    Image.fromarray(rgba).save(tmp_path / "a.png")
    read = read_photo(tmp_path / "a.png")
    assert (read[:5] == 0).all()
    assert (read[5:] == 255).all()


def test_a_phone_photo_held_sideways_is_turned_upright_once(tmp_path):
    """HEIC keeps the turn in a property of its own; it must not be turned by the EXIF
    tag as well."""
    pixels = cv2.GaussianBlur(noise((64, 80, 3), np.uint8), (0, 0), 6)
    exif = Image.Exif()
    exif[0x0112] = 6
    phone = pillow_heif.from_bytes("RGB", (80, 64), pixels.tobytes())
    phone.info["exif"] = exif.tobytes()
    phone.save(tmp_path / "a.heic", quality=90)
    assert b"irot" in (tmp_path / "a.heic").read_bytes()
    assert (
        np.abs(
            read_photo(tmp_path / "a.heic").astype(int) - np.rot90(pixels, -1)
        ).mean()
        < 4
    )


@pytest.mark.parametrize("suffix", ["webp", "heic"])
@pytest.mark.parametrize(
    ("damage", "words"), [("header", "not a picture"), ("cut", "damaged or cut short")]
)
def test_a_damaged_phone_photo_is_one_sentence(tmp_path, suffix, damage, words):
    file = tmp_path / f"a.{suffix}"
    Image.fromarray(noise((80, 90, 3), np.uint8)).save(file)
    whole = file.read_bytes()
    file.write_bytes(
        b"\0" * 24 + whole[24:] if damage == "header" else whole[: len(whole) // 2]
    )
    with pytest.raises(MeasurementError, match=words) as error:
        read_photo(file)
    assert str(error.value).startswith(str(file))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("suffix", ["png", "jpg", "tif"])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_a_truncated_picture_is_refused(tmp_path, suffix, dtype):
    if suffix == "jpg" and dtype == np.uint16:
        pytest.skip("JPEG has 8 bits")
    file = tmp_path / f"a.{suffix}"
    cv2.imwrite(str(file), noise((80, 90, 3), dtype))
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    with pytest.raises(MeasurementError, match=f"a.{suffix}"):
        read_photo(file)


def test_empty_missing_and_other_files(tmp_path):
    (tmp_path / "empty.png").write_bytes(b"")
    (tmp_path / "text.png").write_text("hello")
    for name, words in (
        ("empty.png", "0 bytes"),
        ("text.png", "not a picture"),
        ("none.png", "no such file"),
    ):
        with pytest.raises(MeasurementError, match=words):
            read_photo(tmp_path / name)


def test_a_gigantic_picture_is_refused_before_it_is_decoded(tmp_path):
    Image.fromarray(np.zeros((1, 1), np.uint8)).resize((20000, 9000)).save(
        tmp_path / "a.png"
    )
    with pytest.raises(MeasurementError, match="than 120 megapixels"):
        read_photo(tmp_path / "a.png")
