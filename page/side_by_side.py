"""Pairs of a recording and its twin: which ones the results hold, and what the browser
draws of one."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.page.folder import CALIBRATED, Folder
from benchtwin.page.results import json_content, read
from benchtwin.report.draw import listed
from benchtwin.twin.pair import Pair, pair
from benchtwin.vision.find_recordings import find_recordings
from benchtwin.vision.recording import Recording, read_recording

MOST_STEPS = 800  # of the slider
FILMED = ("frames", "video")


@dataclass(frozen=True)
class BenchTwinPair:
    """A recording of the bench and a run of the twin; alike: whether both have the same
    scale."""

    title: str
    recording: Path
    twin: Path
    alike: bool = True


def pairs_of(bench: Path, folder: Folder) -> list[BenchTwinPair]:
    """What a calibration chose to show, and what a diagnosis filmed; pairs of which a
    half is gone are left out. Refused where the calibration cannot be read."""
    results = folder.results(bench)
    recordings = {
        r.id: r.path for r in find_recordings(bench) if isinstance(r, Recording)
    }
    with read(results / CALIBRATED / "result.json") as file:
        found = [
            BenchTwinPair(
                tr("Calibration: {}", p["recording"]),
                recordings[p["recording"]],
                file.parent / p["twin"],
                bool(p["alike"]),
            )
            for p in json_content(file).get("pairs", [])
            if p["recording"] in recordings
        ]
    for name, path in recordings.items():
        for which in ("old", "new"):
            twin = results / "diagnosed" / "twin" / f"{name.replace('/', '-')}-{which}"
            found.append(
                BenchTwinPair(tr("Diagnosis: {}, {} twin", name, tr(which)), path, twin)
            )
    return [
        b
        for b in found
        if b.twin.resolve().is_relative_to(results.resolve())
        and (b.twin / "recording.toml").is_file()
        and not folder.links_out(b.twin)
        and not folder.links_out(b.recording)
    ]


def read_pair(chosen: BenchTwinPair) -> Pair:
    """Both read by the same code and laid over each other. MeasurementError where one
    cannot be read."""
    bench, twin = (read_recording(p) for p in (chosen.recording, chosen.twin))
    timed = any(r.evidence in FILMED for r in (bench, twin))
    return pair(bench, twin, alike=chosen.alike, timed=timed)


def browser_data(chosen: BenchTwinPair, both: Pair, folder: Folder) -> dict:
    """What the browser draws: places of both over x, thinned to MOST_STEPS, and where
    their pictures are."""
    most = min(len(both.x), MOST_STEPS)
    rows = np.unique(np.linspace(0, len(both.x) - 1, most).round().astype(int))
    recordings = [read_recording(p) for p in (chosen.recording, chosen.twin)]
    return {
        "rig": both.rig,
        "xname": tr(both.x_name),
        "yname": tr(both.y_name),
        "x": listed(both.x[rows]),
        "bench": listed(both.bench[rows]),
        "twin": listed(both.twin[rows]),
        "names": [folder.name_of(r.path) for r in recordings],
        "photos": [r.evidence == "photos" for r in recordings],
        "frames": [
            [round(float(v)) for v in f[rows]]
            if f is not None and r.evidence in FILMED
            else None
            for f, r in zip(both.frames, recordings, strict=True)
        ],
        "seed": _seed(recordings[0]),
    }


def _seed(recording: Recording) -> list[float] | None:
    """Length and thickness [mm] of the seed as it is drawn; None where nobody states
    them."""
    seed = recording.seed
    long, flat = seed.length_mm, seed.thickness_mm or seed.width_mm
    return [long, flat or long] if long else None
