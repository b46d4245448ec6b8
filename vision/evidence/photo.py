"""Reads one picture from a file: complete, upright, 8 or 16 bits, grey or RGB; or
raises a clear error."""

import contextlib
import os
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import NoReturn

import numpy as np
import pillow_heif
from PIL import Image, ImageOps, UnidentifiedImageError
from PIL.ImageFile import ImageFile
from PIL.PngImagePlugin import PngImageFile
from PIL.TiffImagePlugin import TiffImageFile

from benchtwin.bench.language import tr
from benchtwin.vision.measurement import MeasurementError, require

PHOTO_SUFFIXES = (
    *(".png", ".jpg", ".jpeg", ".tif", ".tiff"),
    *(".bmp", ".webp", ".heic", ".heif"),
)
MAX_PIXELS = 120_000_000  # a decoded 120-megapixel colour photo takes 360 MB
# read when OpenCV is first imported
os.environ.setdefault("OPENCV_IO_MAX_IMAGE_PIXELS", str(MAX_PIXELS))
ORIENTATION = 0x0112  # EXIF tag
_DIRECT = {"L", "RGB", "I;16"}
pillow_heif.register_heif_opener()


def read_photo(path: Path) -> np.ndarray:
    """Read a picture as an array (height, width) or (height, width, 3), uint8 or
    uint16, RGB, upright by its EXIF tag. Transparent pictures get a white background.
    16-bit colour is read with 16 bits (HEIC with 8); floating-point TIFF is refused.
    Raises MeasurementError, naming the file, when it is missing, empty, not a picture,
    truncated or above MAX_PIXELS."""
    path = Path(path)
    with _errors_in_words(path):
        try:
            return _decode(path)
        except UnidentifiedImageError:
            return _decode_deep(path) if _is_tiff(path) else _not_a_picture(path)


def photo_size(path: Path) -> tuple[int, int]:
    """Width and height of the upright picture [px], by its header alone.
    MeasurementError as of `read_photo`."""
    try:
        with _errors_in_words(path), Image.open(path) as file:
            _check_size(path, file)
            turned = file.getexif().get(ORIENTATION, 1) >= 5
            return (file.height, file.width) if turned else file.size
    except UnidentifiedImageError:
        height, width = read_photo(path).shape[:2]  # 16-bit TIFF that OpenCV knows
        return width, height


def read_small(path: Path, largest: int) -> Image.Image:
    """The upright picture in RGB, of at most `largest` px a side, decoded at a reduced
    size where its format can. MeasurementError as of `read_photo`."""
    with (
        contextlib.suppress(UnidentifiedImageError),
        _errors_in_words(path),
        Image.open(path) as file,
    ):
        _check_size(path, file)
        if file.mode in ("1", "L", "P", "RGB", "CMYK", "YCbCr"):
            file.draft("RGB", (largest, largest))
            file.thumbnail((largest, largest), reducing_gap=2.0)
            return ImageOps.exif_transpose(file).convert("RGB")
    pixels = read_photo(path)  # 16 bits, or transparent
    if pixels.dtype == np.uint16:
        pixels = (pixels >> 8).astype(np.uint8)
    picture = Image.fromarray(pixels)
    picture.thumbnail((largest, largest), reducing_gap=2.0)
    return picture.convert("RGB")


@contextlib.contextmanager
def _errors_in_words(path: Path) -> Iterator[None]:
    """Whatever a decoder raises becomes a MeasurementError that names the file."""
    require(path.is_file(), tr("{}: no such file", path))
    require(path.stat().st_size != 0, tr("{}: the file is empty (0 bytes)", path))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # what matters is raised
            yield
    except Image.DecompressionBombError as error:
        raise MeasurementError(
            tr(
                "{}: the picture is larger than {:.0f} megapixels; scale it down",
                path,
                MAX_PIXELS / 1e6,
            )
        ) from error
    except (
        MeasurementError,
        MemoryError,
        PermissionError,
        UnidentifiedImageError,  # another decoder may know it
    ):
        raise
    except Exception as error:  # decoders raise many kinds of errors for damaged files
        # some say it over several lines
        why = " ".join(str(error).split()).replace(" )", ")")
        raise MeasurementError(
            tr("{}: the picture is damaged or cut short ({})", path, why)
        ) from error


def _check_size(path: Path, file: Image.Image) -> None:
    require(
        file.width * file.height <= MAX_PIXELS,
        tr(
            "{}: {} × {} pixels is more than {:.0f} megapixels; scale it down",
            path,
            file.width,
            file.height,
            MAX_PIXELS / 1e6,
        ),
    )


def _decode(path: Path) -> np.ndarray:
    with Image.open(path) as file:
        _check_size(path, file)
        if file.mode == "RGB" and _bits_per_channel(file) == 16:
            return _decode_deep(path)
        file.load()
        image: Image.Image = file
        if image.getexif().get(ORIENTATION, 1) != 1:
            image = ImageOps.exif_transpose(image)
        if image.mode == "I" or image.mode.startswith("I;16"):
            return np.asarray(image).astype(np.uint16)
        require(
            image.mode != "F",
            tr(
                "{}: floating-point pixels; save the picture with 8 or 16 bits"
                " a channel",
                path,
            ),
        )
        if image.mode in ("RGBA", "LA", "PA") or "transparency" in image.info:
            image = _on_white(image)
        if image.mode not in _DIRECT:
            image = image.convert("L" if image.mode == "1" else "RGB")
        return np.asarray(image)


def _bits_per_channel(image: ImageFile) -> int:
    """Bits of each channel by the file's header; Pillow converts 16-bit colour to 8
    bits."""
    if isinstance(image, TiffImageFile):
        bits = image.tag_v2.get(258, (8,))
        return int(bits[0] if isinstance(bits, tuple) else bits)
    return (
        16
        if isinstance(image, PngImageFile)
        and image.tile
        and "16" in str(image.tile[0][-1])
        else 8
    )


def _on_white(image: Image.Image) -> Image.Image:
    rgba = image.convert("RGBA")
    white = Image.new("RGB", rgba.size, "white")
    white.paste(rgba, mask=rgba.getchannel("A"))
    return white


def _decode_deep(path: Path) -> np.ndarray:
    """Decode with OpenCV what Pillow cannot give with all bits (OpenCV does not report
    truncated files, hence second)."""
    import cv2  # after its limit is set

    data = np.fromfile(path, dtype=np.uint8)
    log = cv2.utils.logging  # what it writes to the terminal is in our error
    level = log.setLogLevel(log.LOG_LEVEL_SILENT)
    try:
        image = cv2.imdecode(data, cv2.IMREAD_UNCHANGED)
    finally:
        log.setLogLevel(level)
    if image is None:
        _not_a_picture(path)
    if image.ndim == 3:
        image = cv2.cvtColor(image[..., :3], cv2.COLOR_BGR2RGB)
    require(
        image.dtype in (np.uint8, np.uint16),
        tr(
            "{}: {} pixels; save the picture with 8 or 16 bits a channel",
            path,
            image.dtype,
        ),
    )
    return image


def _is_tiff(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(4) in (b"II*\0", b"MM\0*")


def _not_a_picture(path: Path) -> NoReturn:
    known = ", ".join(s[1:] for s in PHOTO_SUFFIXES)
    raise MeasurementError(
        tr(
            "{}: not a picture that can be read; its header is damaged or of"
            " another kind than {}",
            path,
            known,
        )
    )
