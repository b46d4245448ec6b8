"""Photos, thumbnails and single frames as JPEG for the browser; the originals stay
untouched."""

import io
from bisect import bisect_left
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

import numpy as np
from benchtwin.vision.evidence.frames import FrameSource, open_frames
from benchtwin.vision.evidence.photo import read_photo
from benchtwin.vision.recording import Recording
from PIL import Image

THUMB_PX, SHOWN_PX, FRAME_PX = 320, 2600, 1600  # largest side
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
        picture = picture.resize(
            (round(picture.width * factor), round(picture.height * factor)),
            Image.Resampling.BOX,
            reducing_gap=2.0,
        )
    data = io.BytesIO()
    picture.convert("RGB").save(data, "JPEG", quality=88)
    return data.getvalue(), factor


def thumbnail(recording: Recording) -> bytes | None:
    """A small picture of what a recording holds, None where that is no picture."""
    if recording.evidence == "photos":
        with Image.open(recording.files[0]) as picture:
            picture.draft("RGB", (THUMB_PX, THUMB_PX))
            picture.thumbnail((THUMB_PX, THUMB_PX))
            data = io.BytesIO()
            picture.convert("RGB").save(data, "JPEG", quality=80)
            return data.getvalue()
    if recording.evidence in ("frames", "video"):
        return as_jpeg(next(open_frames(recording).iterate()).pixels, THUMB_PX)[0]
    return None


class Film:
    """Single frames of a recording by their index, in any order; what was decoded on
    the way is kept for the next steps."""

    KEPT = 24  # frames; stepping backwards one by one costs one decoding in so many

    def __init__(self, recording: Recording):
        self.source: FrameSource = open_frames(recording)
        self.video = recording.files[0] if recording.evidence == "video" else None
        self.kept: dict[int, bytes] = {}
        self.times: list[int] = []  # of a video's frames, in its own clock
        height, width = next(self.source.iterate()).pixels.shape[:2]
        self.size = (width, height)

    @property
    def count(self) -> int:
        return self.source.count

    def frame(self, index: int) -> bytes:
        """JPEG of frame `index` (its number at the bench); IndexError where there is
        none."""
        if index not in self.kept:
            first = max(0, index - self.KEPT // 2)
            if self.video:
                self.kept = dict(self._decoded(self.video, first, first + self.KEPT))
            else:
                frames = self.source.picked(self.KEPT, (first, first + self.KEPT - 1))
                self.kept = {f.index: as_jpeg(f.pixels, FRAME_PX)[0] for f in frames}
        if index not in self.kept:
            raise IndexError(index)
        return self.kept[index]

    def _decoded(
        self, file: Path, first: int, stop: int
    ) -> Iterator[tuple[int, bytes]]:
        """Frames from `first` up to `stop`, decoded from the key frame before them."""
        import av

        with av.open(str(file)) as container:
            stream = container.streams.video[0]
            if not self.times:
                self.times = sorted(
                    p.pts for p in container.demux(stream) if p.pts is not None
                )
            if first >= len(self.times):
                return
            container.seek(self.times[first], stream=stream, backward=True)
            for frame in container.decode(stream):
                index = bisect_left(self.times, frame.pts or 0)
                if index >= stop:
                    return
                if index >= first:
                    turned = np.rot90(
                        frame.to_ndarray(format="rgb24"), round(frame.rotation / 90) % 4
                    )
                    yield index, as_jpeg(np.ascontiguousarray(turned), FRAME_PX)[0]
