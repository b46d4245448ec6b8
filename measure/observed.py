"""Recordings and what was observed on them: each is read once, whoever asks."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import cv2
import numpy as np

from benchtwin.bench.language import tr
from benchtwin.measure.batch import Progress, find_all
from benchtwin.measure.observe import observe
from benchtwin.vision.measurement import MeasurementError, Observation
from benchtwin.vision.pile.repose import PileOptions
from benchtwin.vision.recording import Recording
from benchtwin.vision.tell_rig import with_rig


class PackedPictures(Mapping[str, np.ndarray]):
    """Pictures by name, kept as PNG and unpacked when they are looked at."""

    def __init__(self, pictures: Mapping[str, np.ndarray]):
        self._png = {name: packed(picture) for name, picture in pictures.items()}

    def __getitem__(self, name: str) -> np.ndarray:
        coded = np.frombuffer(self._png[name], np.uint8)
        picture = np.asarray(cv2.imdecode(coded, cv2.IMREAD_UNCHANGED))
        return picture[:, :, ::-1] if picture.ndim == 3 else picture

    def __iter__(self) -> Iterator[str]:
        return iter(self._png)

    def __len__(self) -> int:
        return len(self._png)

    def png(self, name: str) -> bytes:
        """A picture as the content of a PNG file."""
        return self._png[name]


def packed(picture: np.ndarray) -> bytes:
    """A picture, (h, w) or (h, w, 3) RGB, as the content of a PNG file."""
    image = picture[:, :, ::-1] if picture.ndim == 3 else picture
    return cv2.imencode(".png", image, [cv2.IMWRITE_PNG_COMPRESSION, 1])[1].tobytes()


@dataclass(frozen=True, eq=False)
class Observed:
    """The recordings of a bench folder, and what was observed on those that somebody
    asked for; it stands wherever the folder's path may stand.

    folder: where they lie; entries: the recordings, and errors of those that cannot be
    read; options, trim: how they are measured, as `observe` takes them; told: what told
    a recording's rig, by name, where nobody states it (`with_rigs`)."""

    folder: Path
    entries: tuple[Recording | MeasurementError, ...]
    options: PileOptions | None = None
    trim: bool = False
    told: Mapping[str, str] = field(default_factory=dict)
    _found: dict[Recording, Observation | MeasurementError | OSError] = field(
        default_factory=dict, repr=False
    )

    @classmethod
    def under(cls, folder: "str | Path | Observed") -> "Observed":
        """The recordings under a folder, those of an `Observed` as they are.
        FileNotFoundError without a folder."""
        if isinstance(folder, Observed):
            return folder
        if not Path(folder).exists():
            raise FileNotFoundError(tr("{}: no such file or folder", folder))
        return cls(Path(folder), tuple(find_all([Path(folder)])))

    def __fspath__(self) -> str:
        return str(self.folder)

    def __str__(self) -> str:
        return str(self.folder)

    def with_rigs(self) -> "Observed":
        """The same with the rigs that evidence tells where nobody states them."""
        entries, told = list(self.entries), dict(self.told)
        for k, entry in enumerate(self.entries):
            if isinstance(entry, MeasurementError):
                continue
            try:
                entries[k], why = with_rig(entry)
            except (MeasurementError, OSError):
                continue  # its measuring says so
            if why:
                told[entry.id] = why
        return replace(self, entries=tuple(entries), told=told)

    def only(self, entries: Iterable[Recording | MeasurementError]) -> "Observed":
        """Some of these recordings, with what was observed on them."""
        return replace(self, entries=tuple(entries))

    def observe(
        self, recording: Recording, progress: Progress | None = None
    ) -> Observation:
        """What is measured on a recording: found at the first call, kept for others.
        Raises what `measure.observe.observe` raises, each time alike."""
        if recording not in self._found:
            self._found[recording] = self._look(recording, progress)
        found = self._found[recording]
        if isinstance(found, Exception):
            raise found
        return found

    def _look(
        self, recording: Recording, progress: Progress | None
    ) -> Observation | MeasurementError | OSError:
        try:
            seen = observe(recording, self.options, self.trim, progress)
        except (MeasurementError, OSError) as error:
            return error
        return replace(seen, pictures=PackedPictures(seen.pictures))
