"""Photos, thumbnails and single frames as JPEG for the browser; the originals stay
untouched."""

import io
from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from threading import Lock
from typing import Any

import av
import numpy as np
from PIL import Image

from benchtwin.bench.language import tr
from benchtwin.vision.evidence.frames import FrameFolder, FrameSource, open_frames
from benchtwin.vision.evidence.photo import photo_size, read_photo, read_small
from benchtwin.vision.evidence.sound import open_media
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.recording import Recording

THUMB_PX, SHOWN_PX, FRAME_PX = 320, 2600, 1600  # largest side
KEPT_THUMBNAILS = 1000  # of 10 kB
KEPT_PHOTOS = 3  # decoded at once: one of 12 megapixels takes 36 MB


@lru_cache(maxsize=KEPT_PHOTOS)
def photo(file: Path, changed_ns: int) -> np.ndarray:
    """The decoded photo; changed_ns: the file's time, so that a new file of the same
    name is read anew."""
    return read_photo(file)


def as_jpeg(pixels: np.ndarray, largest: int = SHOWN_PX) -> tuple[bytes, float]:
    """JPEG of at most `largest` px a side, and its scale against the original."""
    if pixels.dtype == np.uint16:
        pixels = (pixels >> 8).astype(np.uint8)
    picture = Image.fromarray(pixels)
    factor = min(1.0, largest / max(picture.size))
    if factor < 1:
        size = (
            max(1, round(picture.width * factor)),
            max(1, round(picture.height * factor)),
        )
        picture = picture.resize(size, Image.Resampling.BOX, reducing_gap=2.0)
    return _encoded(picture), factor


def thumbnail(recording: Recording) -> bytes | None:
    """A small picture of what a recording holds, None where that is no picture;
    MeasurementError where it cannot be read."""
    if recording.evidence not in ("photos", "frames", "video"):
        return None
    file = recording.files[0]
    return _thumbnail(file, file.stat().st_mtime_ns, recording.evidence == "video")


@lru_cache(maxsize=KEPT_THUMBNAILS)
def _thumbnail(file: Path, _changed_ns: int, filmed: bool) -> bytes:
    if not filmed:
        return _encoded(read_small(file, THUMB_PX), 80)
    return as_jpeg(_Decoder(file).first(), THUMB_PX)[0]


def _encoded(picture: Image.Image, quality: int = 88) -> bytes:
    data = io.BytesIO()
    picture.convert("RGB").save(data, "JPEG", quality=quality)
    return data.getvalue()


class Film:
    """Single frames of a recording by their numbers as recorded, in any order. size: of
    a frame as recorded [px]; numbers: of the frames, as far as the file tells."""

    KEPT = 24  # frames: so many are decoded at once when somebody steps backwards

    def __init__(self, recording: Recording):
        self.source: FrameSource = open_frames(recording)
        self.numbers = self.source.numbers
        self.kept: dict[int, bytes] = {}
        self.files: dict[int, Path] = {}
        self.one_at_a_time = Lock()
        if isinstance(self.source, FrameFolder):
            self.files = self.source.by_number
            self.size = _first_size([*self.files.values()])
        else:
            self.decoder = _Decoder(recording.files[0])
            first = self.decoder.first()
            self.size = (first.shape[1], first.shape[0])
            self.kept[0] = as_jpeg(first, FRAME_PX)[0]
            self.numbers = self.numbers or self.decoder.numbers()
        self.last = self.numbers[0]  # the frame that was asked for last

    def frame(self, number: int) -> bytes:
        """JPEG of the frame of this number; of the one before, where that was lost.
        MeasurementError where it cannot be decoded."""
        with self.one_at_a_time:
            at = max(0, bisect_right(self.numbers, number) - 1)
            number = self.numbers[at]
            if number not in self.kept:
                self._decode(number)
            self.last = number
            return self.kept[number]

    def _decode(self, number: int) -> None:
        if self.files:
            picture = read_small(self.files[number], FRAME_PX)
            found = {number: _encoded(picture)}
        else:
            back = 0 < self.last - number <= self.KEPT
            first = max(0, number - self.KEPT + 1) if back else number
            found = {
                i: as_jpeg(pixels, FRAME_PX)[0]
                for i, pixels in self.decoder.frames(first, number)
            }
            if not found:
                raise MeasurementError(tr("frame {} cannot be decoded", number))
            found[number] = found[max(found)]
        self.kept = dict([*self.kept.items()][-self.KEPT :]) | found


def _first_size(files: list[Path]) -> tuple[int, int]:
    """Of the first picture that can be read."""
    for file in files:
        with suppress(MeasurementError):
            return photo_size(file)
    return photo_size(files[0])  # says why


class _Decoder:
    """A video that stays open: the frames that follow are decoded one by one, for all
    others it goes back to the key frame before them."""

    AHEAD = 48  # frames that are rather decoded than sought

    def __init__(self, file: Path):
        self.file = file
        self.container: Any = None
        self.times: list[int] = []  # of the frames, in the file's own clock
        self.coming: Iterator[tuple[int, Any]] = iter(())
        self.next = 0  # the frame that comes next

    def first(self) -> np.ndarray:
        """The first frame; MeasurementError where there is none."""
        for _, pixels in self.frames(0, 0):
            return pixels
        raise MeasurementError(tr("{}: holds no frame that can be read", self.file))

    def numbers(self) -> list[int]:
        """Of all frames, counted where the file's header does not say them."""
        self._seek(1)
        return [*range(max(1, len(self.times)))]

    def frames(self, first: int, last: int) -> Iterator[tuple[int, np.ndarray]]:
        """The upright frames from `first` to `last`; the last of the file where it ends
        before. MeasurementError where it cannot be decoded."""
        follows = self.next <= first < self.next + self.AHEAD
        if sought := self.container is None or not follows:
            first = self._seek(first)
        none = True
        try:
            for index, frame in self.coming:
                self.next = index + 1
                if index >= first:
                    none = False
                    pixels = frame.to_ndarray(format="rgb24")
                    turned = np.rot90(pixels, round(frame.rotation / 90) % 4)
                    yield index, np.ascontiguousarray(turned)
                if index >= last:
                    return
        except av.error.FFmpegError as error:
            self.container = None
            why = tr("{}: the video is damaged ({})", self.file, error.strerror)
            raise MeasurementError(why) from error
        self.container = None  # it has come to its end
        if none and not sought:
            yield from self.frames(first, last)

    def _seek(self, first: int) -> int:
        """Go to the key frame before `first`; returns `first`, or the file's last."""
        self.container = open_media(self.file, tr("a video"))
        if not self.container.streams.video:
            raise MeasurementError(tr("{}: holds no picture stream", self.file))
        stream = self.container.streams.video[0]
        stream.thread_type = "AUTO"
        if first > 0 and not self.times:
            self.times = sorted(
                p.pts for p in self.container.demux(stream) if p.pts is not None
            )
            self.container.seek(0)
        if first > 0 and self.times:
            first = min(first, len(self.times) - 1)
            self.container.seek(self.times[first], stream=stream, backward=True)
            self.coming = (
                (bisect_left(self.times, frame.pts or 0), frame)
                for frame in self.container.decode(stream)
            )
        else:
            self.coming = enumerate(self.container.decode(stream))
        return first
