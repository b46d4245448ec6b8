"""Streams the frames of a recording from a folder of pictures or from a video."""

import contextlib
import itertools
import math
import re
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.vision.evidence.photo import MAX_PIXELS, read_photo
from benchtwin.vision.evidence.sound import open_media
from benchtwin.vision.measurement import MeasurementError, require
from benchtwin.vision.recording import Recording

SAMPLE_BYTES = 90_000_000  # of a sample's pictures in memory at once
HELD_BYTES = 600_000_000  # of a film that is read once and then held
USUAL_STEP = 0.25  # quantile of the steps between time stamps, some of which are gaps
SPREAD = 9  # frames that show what a film is of


@dataclass(frozen=True)
class Frame:
    """One picture: `index` is its number as recorded, `t_s` its time (NaN without a
    frame rate), pixels grey or RGB."""

    index: int
    t_s: float
    pixels: np.ndarray


@dataclass
class FrameSource(ABC):
    """The frames of one recording; count: frames expected; notes: what was skipped,
    with frame numbers."""

    path: Path
    count: int
    fps: float | None
    notes: list[str] = field(default_factory=list)
    _held: list[Frame] = field(default_factory=list, init=False, repr=False)

    @abstractmethod
    def iterate(self) -> Iterator[Frame]:
        """The frames in order, one at a time."""

    def _holding(self, frames: Iterator[Frame]) -> Iterator[Frame]:
        """The frames, which are held once all have been read, where there is room."""
        if self._held:
            yield from self._held
            return
        read, room = [], HELD_BYTES
        for frame in frames:
            room -= frame.pixels.nbytes
            if room > 0:
                read.append(frame)
            else:
                read.clear()
            yield frame
        self._held = read

    @property
    def numbers(self) -> list[int]:
        """The frames' numbers as recorded, without opening any."""
        return list(range(self.count))

    def picked(self, n: int, between: tuple[int, int] | None = None) -> list[Frame]:
        """About n evenly spaced frames of all, or of those numbered from `between`[0]
        to `between`[1]."""
        first, last = between or (0, math.inf)
        inside = (frame for frame in self.iterate() if first <= frame.index <= last)
        expected = self.count if between is None else between[1] - between[0] + 1
        return list(itertools.islice(inside, 0, None, max(1, -(-expected // n))))

    def sample(self, n: int) -> list[np.ndarray]:
        """About n evenly spaced pictures of one size, for the background; fewer where
        they are large."""
        first = next(self.iterate(), None)
        n = n if first is None else limit_to_memory(n, first.pixels)
        frames = [frame.pixels for frame in self.picked(n)]
        shapes = [p.shape for p in frames]
        return [p for p in frames if p.shape == max(set(shapes), key=shapes.count)]

    def spread(self) -> list[Frame]:
        """About SPREAD frames of the whole film."""
        return self.picked(SPREAD)

    def note(self, message: str) -> None:
        if message not in self.notes:
            self.notes.append(message)


def limit_to_memory(n: int, pixels: np.ndarray) -> int:
    """How many of n pictures like this one fit into SAMPLE_BYTES, at least 7."""
    return max(7, min(n, SAMPLE_BYTES // pixels.nbytes))


def open_frames(recording: Recording) -> FrameSource:
    """The frames of `recording` (evidence "frames" or "video")."""
    if recording.evidence == "frames":
        return FrameFolder(recording.files, recording.camera.fps)
    if recording.evidence == "video":
        return Video(recording.files[0], recording.camera.fps)
    raise MeasurementError(
        tr("{}: holds {}, not frames", recording.path, recording.evidence)
    )


class FrameFolder(FrameSource):
    """A folder of numbered pictures; the number in the file name is the frame number,
    gaps are lost frames."""

    def __init__(self, files: tuple[Path, ...], fps: float | None):
        numbered = []
        for file in files:
            digits = re.findall(r"\d+", file.stem)
            require(
                digits,
                tr("{}: a frame's file name must end in its number (000123.png)", file),
            )
            numbered.append((int(digits[-1]), file))
        numbered.sort()
        super().__init__(path=files[0].parent, count=len(numbered), fps=fps)
        self._files = numbered
        numbers = np.array([n for n, _ in numbered])
        if (repeated := numbers[1:][np.diff(numbers) == 0]).size:
            raise MeasurementError(
                tr("{}: two frames numbered {}; keep one", self.path, repeated[0])
            )
        if (gaps := np.flatnonzero(np.diff(numbers) > 1)).size:
            lost = int((np.diff(numbers)[gaps] - 1).sum())
            self.note(
                tr(
                    "{} frame number{} missing, first after {}",
                    lost,
                    "s" if lost > 1 else "",
                    numbers[gaps[0]],
                )
            )

    @property
    def numbers(self) -> list[int]:
        return [number for number, _ in self._files]

    @property
    def by_number(self) -> dict[int, Path]:
        """The frames' files."""
        return dict(self._files)

    def iterate(self) -> Iterator[Frame]:
        return self._holding(self._read())

    def _read(self) -> Iterator[Frame]:
        shape = None
        for number, file in self._files:
            try:
                pixels = read_photo(file)
            except MeasurementError as error:
                self.note(
                    tr(
                        "frame {} skipped: {}",
                        number,
                        str(error).removeprefix(f"{file}: "),
                    )
                )
                continue
            shape = shape or pixels.shape
            if pixels.shape != shape:
                colour = " (colour)" if pixels.ndim == 3 else ""
                size = f"{pixels.shape[1]} × {pixels.shape[0]}{colour}"
                self.note(
                    tr(
                        "frame {} skipped: its size {} is not that of the others",
                        number,
                        size,
                    )
                )
                continue
            yield Frame(number, self._time(number), pixels)

    def picked(self, n: int, between: tuple[int, int] | None = None) -> list[Frame]:
        frames = []
        first, last = between or (self._files[0][0], self._files[-1][0])
        inside = [entry for entry in self._files if first <= entry[0] <= last]
        wanted = np.linspace(0, len(inside) - 1, min(n, len(inside))).astype(int)
        for number, file in (inside[i] for i in np.unique(wanted)):
            with contextlib.suppress(MeasurementError):  # iterate() notes it
                frames.append(Frame(number, self._time(number), read_photo(file)))
        require(frames, tr("{}: none of the frames can be read", self.path))
        return frames

    def _time(self, number: int) -> float:
        return (number - self._files[0][0]) / self.fps if self.fps else np.nan


class Video(FrameSource):
    """A video file. Times are number / fps with a stated frame rate (of a high-speed
    camera), else the file's time stamps; frames that these say are missing are
    numbered, too."""

    def __init__(self, file: Path, fps: float | None):
        require(file.stat().st_size != 0, tr("{}: the file is empty (0 bytes)", file))
        with _opened(file) as container:
            stream = container.streams.video[0]
            if stream.width * stream.height > MAX_PIXELS:
                size = tr("{} × {} pixels a frame", stream.width, stream.height)
                raise MeasurementError(
                    tr(
                        "{}: {} is more than {:.0f} megapixels; scale it down",
                        file,
                        size,
                        MAX_PIXELS / 1e6,
                    )
                )
            duration = float((stream.duration or 0) * (stream.time_base or 0))
            self._file_fps = float(stream.average_rate or 0) or None
            expected = stream.frames or round(duration * (self._file_fps or 0))
            self._large = 3 * stream.width * stream.height * expected > HELD_BYTES
        super().__init__(path=file, count=expected, fps=fps or self._file_fps)
        self._stated_fps = fps
        self._grey: bool | None = None  # whether it is grey, by the first decoded frame

    @cached_property
    def _recorded(self) -> np.ndarray:
        """The number of each frame as recorded, by the file's time stamps."""
        with _opened(self.path) as container:
            packets = container.demux(container.streams.video[0])
            stamps = np.sort([p.pts for p in packets if p.pts is not None])
        steps = np.diff(stamps)
        if not len(steps) or (usual := np.quantile(steps, USUAL_STEP)) <= 0:
            return np.arange(len(stamps))
        apart = np.maximum(np.round(steps / usual), 1).astype(int)
        if lost := int((apart - 1).sum()):
            first = int(np.argmax(apart > 1))
            self.note(
                tr(
                    "by its time stamps the film lacks {} frames, the first"
                    " after frame {}: the others are taken to be as far apart"
                    " as these say",
                    lost,
                    first,
                )
            )
        return np.concatenate([[0], np.cumsum(apart)])

    def _time(self, index: int) -> float:
        """By the stated rate."""
        numbers = self._recorded
        beyond = max(index - len(numbers) + 1, 0)
        last = int(numbers[index - beyond]) if len(numbers) else 0
        return (last + beyond) / float(self._stated_fps or np.nan)

    def iterate(self) -> Iterator[Frame]:
        return self._holding(self._decode())

    def picked(self, n: int, between: tuple[int, int] | None = None) -> list[Frame]:
        """As for any source; of a film that is too large to be held only these become
        pictures, though all up to the last are decoded."""
        if self._held or not self._large:
            return super().picked(n, between)
        first, last = between or (0, self.count - 1)
        every = max(1, -(-(last - first + 1) // n))
        # the count in a file's header may be wrong
        stop = None if between is None else last + 1
        return list(itertools.islice(self._decode(every, first, stop), 2 * n))

    def _decode(
        self, every: int = 1, first: int = 0, stop: int | None = None
    ) -> Iterator[Frame]:
        import av

        index, start, last, size = 0, None, -np.inf, None
        with _opened(self.path) as container:
            stream = container.streams.video[0]
            stream.thread_type = "AUTO"
            try:
                for frame in container.decode(stream):
                    clock = index / (self._file_fps or np.nan)
                    stamp = clock if frame.time is None else frame.time
                    start = stamp if start is None else start
                    time = self._time(index) if self._stated_fps else stamp - start
                    if time <= last:
                        self.note(
                            tr(
                                "frame {} skipped: its time stamp {:.4f} s does"
                                " not increase",
                                index,
                                stamp,
                            )
                        )
                    elif (frame.width, frame.height) != (
                        size := size or (frame.width, frame.height)
                    ):
                        self.note(
                            tr(
                                "frame {} skipped: its size {} × {} is not that of"
                                " the others",
                                index,
                                frame.width,
                                frame.height,
                            )
                        )
                    elif index >= first and (index - first) % every == 0:
                        self._grey = (
                            _is_grey(frame) if self._grey is None else self._grey
                        )
                        upright = np.rot90(
                            _pixels(frame, self._grey), round(frame.rotation / 90) % 4
                        )
                        yield Frame(index, time, np.ascontiguousarray(upright))
                    last = max(last, time)
                    index += 1
                    if index == stop:
                        return
            except av.error.FFmpegError as error:
                self.note(
                    tr(
                        "the video is damaged after frame {} ({})",
                        index - 1,
                        error.strerror,
                    )
                )
        require(
            index != 0, tr("{}: the video holds no frame that can be read", self.path)
        )
        if self.count and index < self.count:
            self.note(tr("the video stops early: {} of {} frames", index, self.count))


def _opened(file: Path):
    container = open_media(file, "a video")
    if not container.streams.video:
        container.close()
        raise MeasurementError(tr("{}: holds no picture stream", file))
    return container


def _pixels(frame, grey: bool) -> np.ndarray:
    """Grey pictures (8 or 16 bits), also where the file stores them as colour (`grey`);
    else RGB."""
    name = frame.format.name
    if name == "gray" or grey:
        return frame.to_ndarray(format="gray")
    if name.startswith("gray"):
        return frame.to_ndarray(format="gray16le")
    return frame.to_ndarray(format="rgb24")


def _is_grey(frame) -> bool:
    """Whether an 8-bit colour video contains grey pictures, which are read as one
    channel."""
    if not frame.format.name.startswith("yuv") or frame.format.components[0].bits != 8:
        return False
    rgb = frame.to_ndarray(format="rgb24")[::4, ::4].astype(int)
    return bool(np.abs(np.diff(rgb, axis=2)).max() <= 4)
