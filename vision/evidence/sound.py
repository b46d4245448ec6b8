"""Reads the sound of a recording, a video's track or a sound file, as mono samples on
the clock of the pictures."""

import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.vision.measurement import MeasurementError, require

SOUND_SUFFIXES = (".wav", ".m4a", ".mp3", ".ogg", ".flac", ".aac", ".opus")
LOSSLESS = ("flac", "alac", "wavpack", "ape", "tta")
LONGEST_S = 600.0  # 115 MB at 48 kHz
LEAST_S = 0.1
RATES_HZ = (8_000, 400_000)
GAP_S = 5e-3  # between the time stamps of two blocks: more means lost sound
SILENT = 1e-7  # of full scale: below the last bit of 16


@dataclass(frozen=True, eq=False)
class Sound:
    """Mono samples (n,) of full scale 1; the first at `start_s`, 0 being the time of
    the first picture. lossy: AAC, MP3, Opus, Vorbis."""

    path: Path
    samples: np.ndarray
    rate_hz: float
    start_s: float
    lossy: bool
    notes: tuple[str, ...] = ()

    @property
    def duration_s(self) -> float:
        return len(self.samples) / self.rate_hz


def has_sound(file: Path) -> bool:
    """Whether a film or sound file has a sound track; False where it cannot be
    opened."""
    return bool(_in_media(file, lambda container: bool(container.streams.audio)))


def film_fps(file: Path) -> float | None:
    """Frame rate by the file's clock, which is also that of its sound; None where it
    has no pictures or cannot be opened."""
    rate = _in_media(file, lambda c: getattr(_picture_stream(c), "average_rate", None))
    return float(rate) if rate else None


def only_sound(file: Path) -> bool:
    """Whether a file contains sound and no moving pictures (a cover is none); False
    where it cannot be opened."""
    return bool(
        _in_media(file, lambda c: _picture_stream(c) is None and bool(c.streams.audio))
    )


def _in_media(file: Path, look: Callable[[Any], Any]) -> Any:
    """`look(container)` of a file, whose streams are gone afterwards; None where it
    cannot be opened."""
    try:
        with open_media(file) as container:
            return look(container)
    except MeasurementError:
        return None


def read_sound(file: Path) -> Sound:
    """The sound of a film or a sound file; MeasurementError where there is none, only
    silence, or nothing that can be decoded. Several channels are averaged; where time
    stamps leave a gap it is filled with silence and noted."""
    require(file.stat().st_size != 0, tr("{}: the file is empty (0 bytes)", file))
    notes: list[str] = []
    with open_media(file) as container:
        require(container.streams.audio, tr("{}: holds no sound track", file))
        if container.streams.audio[0].codec_context is None:
            raise MeasurementError(
                tr(
                    "{}: its sound has a codec that cannot be decoded (no"
                    " decoder); save it as .wav",
                    file,
                )
            )
        film = _picture_stream(container)
        rate = float(container.streams.audio[0].rate or 0)
        if not RATES_HZ[0] <= rate <= RATES_HZ[1]:
            low, high = RATES_HZ
            raise MeasurementError(
                tr(
                    "{}: {:g} samples a second; sound should have {:,} to {:,}",
                    file,
                    rate,
                    low,
                    high,
                )
            )
        codec = container.streams.audio[0].codec_context.name
        blocks = _fill_gaps(_blocks(file, container, rate, notes), rate, notes)
        first = next(blocks, None)
        if first is None:
            raise MeasurementError(
                tr("{}: its sound track holds nothing that can be read", file)
            )
        samples = np.concatenate([first[1], *(block for _, block in blocks)])
    require(
        len(samples) >= LEAST_S * rate,
        tr(
            "{}: {:.2g} s of sound; a drop needs {:g} s at least",
            file,
            len(samples) / rate,
            LEAST_S,
        ),
    )
    require(
        np.abs(samples).max() > SILENT,
        tr("{}: its sound is silent from beginning to end", file),
    )
    start = first[0] - _first_picture(file) if film else 0.0
    lossy = not codec.startswith("pcm") and codec not in LOSSLESS
    return Sound(file, samples, rate, start, lossy, tuple(notes))


def _blocks(
    file: Path, container, rate: float, notes: list[str]
) -> Iterator[tuple[float | None, np.ndarray]]:
    """(time stamp [s], None where it has none; samples) of one block after the other,
    until the end or LONGEST_S."""
    import av

    resampler, count = av.AudioResampler("fltp"), 0  # to float32 of full scale 1
    try:
        for frame in container.decode(container.streams.audio[0]):
            parts = resampler.resample(frame) if frame.sample_rate == rate else []
            if not parts:
                notes.append(
                    tr(
                        "{}: the sound changes its rate after {:.3g} s and is left"
                        " out from there",
                        file.name,
                        count / rate,
                    )
                )
                return
            planes = np.concatenate([part.to_ndarray() for part in parts], axis=1)
            block = np.nan_to_num(planes.mean(axis=0)).clip(-8, 8)
            count += len(block)
            yield frame.time, block
            if count >= LONGEST_S * rate:
                notes.append(
                    tr(
                        "{}: only the first {:g} s of its sound are used",
                        file.name,
                        LONGEST_S,
                    )
                )
                return
    except (av.error.FFmpegError, ValueError) as error:
        notes.append(
            tr(
                "{}: the sound is damaged after {:.3g} s ({})",
                file.name,
                count / rate,
                getattr(error, "strerror", error),
            )
        )


def _fill_gaps(
    blocks: Iterator[tuple[float | None, np.ndarray]], rate: float, notes: list[str]
) -> Iterator[tuple[float, np.ndarray]]:
    """The blocks with their times; gaps between time stamps are filled with silence."""
    due = None
    for stamp, block in blocks:
        at = due or 0.0
        if stamp is not None and math.isfinite(stamp):
            missing = stamp - at
            if due is None:
                at = stamp
            elif GAP_S < missing < LONGEST_S:
                notes.append(
                    tr(
                        "{:.0f} ms of sound are missing at {:.3f} s",
                        missing * 1000,
                        due,
                    )
                )
                block = np.pad(block, (round(missing * rate), 0))
        due = at + len(block) / rate
        yield at, block


def _picture_stream(container):
    """The stream of moving pictures, None where there is none."""
    # an attached picture, such as a cover
    films = (s for s in container.streams.video if not int(s.disposition) & 0x400)
    return next(films, None)


def _first_picture(file: Path) -> float:
    """Time stamp [s] of the first picture, 0 where none can be read."""
    import av

    with open_media(file) as container, suppress(av.error.FFmpegError):
        for frame in container.decode(_picture_stream(container)):
            return float(frame.time or 0.0)
    return 0.0


def open_media(file: Path, kind: str = "a sound or film") -> Any:
    """Open a sound or film with PyAV; MeasurementError naming the file where it is not
    `kind` that can be read."""
    import av

    av.logging.set_level(None)
    try:
        return av.open(str(file), metadata_errors="replace")
    except (av.error.FFmpegError, OSError, ValueError) as error:
        raise MeasurementError(
            tr(
                "{}: not {} that can be read ({})",
                file,
                kind,
                getattr(error, "strerror", error),
            )
        ) from error
