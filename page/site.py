"""What a view is given of the page that it stands on."""

import asyncio
import threading
from dataclasses import dataclass, field
from pathlib import Path

from benchtwin.bench.language import tr
from benchtwin.measure.observe import Progress
from benchtwin.page import pictures
from benchtwin.page.folder import Folder, Refused
from benchtwin.page.measuring import CardNumber, measure_recording, version
from benchtwin.page.toml_file import History
from benchtwin.page.upload import ReceivedFile
from benchtwin.vision.evidence.sound import Sound
from benchtwin.vision.find_recordings import find_recordings
from benchtwin.vision.measurement import MeasurementError, Observation
from benchtwin.vision.motion.drop_sound import read_onsets, sound_of
from benchtwin.vision.motion.onsets import Onsets
from benchtwin.vision.recording import Recording, read_recording

KEPT_OBSERVATIONS = 40


@dataclass
class Site:
    """What all pages share: the folder, and what was measured or decoded since the
    start."""

    folder: Folder
    observations: dict[tuple, Observation] = field(default_factory=dict)
    measured: dict[tuple, threading.Lock] = field(default_factory=dict)
    films: dict[tuple, pictures.Film] = field(default_factory=dict)
    opening: threading.Lock = field(default_factory=threading.Lock)  # of a film
    sounds: dict[tuple, tuple[Sound, Onsets]] = field(default_factory=dict)
    batches: dict[str, list[ReceivedFile]] = field(default_factory=dict)
    cards: dict[tuple, CardNumber] = field(default_factory=dict)
    measuring: asyncio.Lock = field(default_factory=asyncio.Lock)  # for the cards
    history: History = field(default_factory=History)

    def recording(self, name: str) -> Recording:
        """The recording of this name; Refused, in words, where it cannot be read or is
        gone."""
        path = self.folder.inside(name)
        if not path.exists():
            raise Refused(tr("{}: no longer there. Was the folder moved?", name))
        self.folder.refuse_links(path)
        for stated in ("recording.toml", "bench.toml"):
            self.folder.refuse_links(path.parent / stated)
        try:
            return read_recording(path)
        except MeasurementError as error:
            raise Refused(str(error)) from error

    def recordings(self, bench: Path) -> list[Recording | MeasurementError]:
        """The bench's recordings; in the place of what links lead out to there is why
        it is not read."""
        out = self.folder.links_out(bench)
        if bench / "bench.toml" in out:
            raise Refused(self.folder.refused_link(bench / "bench.toml"))
        return [
            *(MeasurementError(self.folder.refused_link(p), p.name) for p in out),
            *(e for e in find_recordings(bench) if not _reads_any(e, out)),
        ]

    def observation(
        self, recording: Recording, progress: Progress | None = None
    ) -> Observation:
        """What measuring finds, remembered until the recording changes; progress:
        called with the fraction done."""
        key = version(recording)
        with self.measured.setdefault(key, threading.Lock()):  # once, not for each tab
            if key not in self.observations:
                if len(self.observations) >= KEPT_OBSERVATIONS:
                    self.observations.pop(next(iter(self.observations)))
                self.observations[key] = measure_recording(recording, progress)
        return self.observations[key]

    def film(self, name: str) -> pictures.Film:
        """The open film of the recording of this name; opened anew where something in
        its folders has changed."""
        path = self.folder.inside(name)
        folders = (path, path / "frames")
        key = (path, *(p.stat().st_mtime_ns for p in folders if p.exists()))
        with self.opening:
            if key not in self.films:
                film = pictures.Film(self.recording(name))
                kept = [*self.films.items()][-1:]  # two: a recording and its twin
                self.films = dict(kept) | {key: film}
            return self.films[key]

    def sound(self, recording: Recording) -> tuple[Sound, Onsets]:
        """A drop's sound and all that is sudden in it; MeasurementError where it has
        none."""
        file = sound_of(recording)
        if file is None:
            raise MeasurementError(tr("{} has no sound", recording.id))
        key = (file, file.stat().st_mtime_ns, recording.camera.fps, recording.rig)
        if key not in self.sounds:
            self.sounds = {key: read_onsets(file, recording)}  # one at a time
        return self.sounds[key]


def _reads_any(found: Recording | MeasurementError, links: list[Path]) -> bool:
    """Whether a recording lies at one of these links, or below, or holds one."""
    if not isinstance(found, Recording):
        return False
    return any(
        p.is_relative_to(found.path) or found.path.is_relative_to(p) for p in links
    )
