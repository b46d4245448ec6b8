"""Sound of drops → times of their impacts. A recording may hold several drops."""

import itertools
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.vision.evidence.sound import Sound, film_fps, has_sound
from benchtwin.vision.foreign.as_evidence import read_heard
from benchtwin.vision.measurement import (
    MeasurementError,
    require,
)
from benchtwin.vision.motion.impact_chain import correct_impacts, find_chain
from benchtwin.vision.motion.onsets import Onsets, find_onsets
from benchtwin.vision.recording import Recording

LEAST_LOG_ODDS = 5.5  # of a chain of impacts that is not doubtful
MOST_RATE_DIFFERENCE = (
    0.03  # of a stated frame rate and the file's: a phone's is not even
)
MOST_LISTED = 6  # rejected sounds in one note


@dataclass(frozen=True, eq=False)
class HeardDrop:
    """The impacts of one drop. times, sd [s] (m,): successive impacts without a gap, on
    the clock of the pictures; first: whether the first of them is the first after the
    release; doubt: "" where there is none."""

    times: np.ndarray
    sd: np.ndarray
    first: bool
    doubt: str


@dataclass(frozen=True, eq=False)
class SoundImpacts:
    """The impacts in a sound, of one drop or several."""

    sound: Sound
    onsets: Onsets
    drops: tuple[HeardDrop, ...]
    notes: tuple[str, ...]


def sound_of(recording: Recording) -> Path | None:
    """The file whose sound belongs to a recording; None where there is none."""
    if recording.sound is not None:
        return recording.sound
    if recording.evidence == "sound":
        return recording.files[0]
    return (
        recording.files[0]
        if recording.evidence == "video" and has_sound(recording.files[0])
        else None
    )


def impacts_in_sound(file: Path, recording: Recording) -> SoundImpacts:
    """Detect the impacts in a sound and apply the recording's corrections.
    MeasurementError for fewer than two impacts."""
    return find_impacts(*read_onsets(file, recording), recording)


def read_onsets(file: Path, recording: Recording) -> tuple[Sound, Onsets]:
    """Read a sound and find its onsets. MeasurementError where there is no sound, or
    the rig is no drop."""
    require(
        recording.rig == "drop",
        tr(
            "{}: sound shows the impacts of a drop; a {} needs pictures, a track or"
            " light gates",
            file,
            recording.rig,
        ),
    )
    film = recording.evidence == "video" and recording.sound is None
    stated, file_fps = recording.camera.fps, film_fps(file) if film else None
    if stated and file_fps and abs(stated / file_fps - 1) > MOST_RATE_DIFFERENCE:
        raise MeasurementError(
            tr(
                "{}: [camera] fps = {:g}, but the file plays {:g} a second, and its"
                " sound with it: slow motion",
                file,
                stated,
                file_fps,
            )
        )
    sound = read_heard(file)
    return sound, find_onsets(sound)


def find_impacts(sound: Sound, onsets: Onsets, recording: Recording) -> SoundImpacts:
    """Select the onsets that are impacts and apply the recording's corrections.
    MeasurementError for fewer than two impacts."""
    found, log_odds = find_chain(onsets, sound.duration_s, recording.drop.height_mm)
    onsets, corrections = correct_impacts(
        sound, found, recording.drop, str(recording.toml)
    )
    impacts = onsets[onsets.drop >= 0]
    counts = np.bincount(impacts.drop)
    require(
        (counts >= 2).any(),
        f"{sound.path}: {'; '.join(corrections) or _too_few(onsets)}",
    )
    drops, said = [], []
    for number in np.flatnonzero(counts >= 2):
        sure = bool(corrections) or log_odds[number] > LEAST_LOG_ODDS
        one, notes = _heard_drop(
            impacts[impacts.drop == number], recording, sure, bool(corrections)
        )
        drops.append(one)
        said += [
            note if len(counts) == 1 else f"drop {len(drops)}: {note}" for note in notes
        ]
    alone = [
        tr("the impact at {:.3f} s is alone and is not used", time)
        for time in impacts.time_s[counts[impacts.drop] == 1]
    ]
    count = [tr("{} drops heard", len(drops))] if len(drops) > 1 else []
    first, *others = said
    rejected = _rejection_notes(onsets)
    notes = [*sound.notes, *count, first, *corrections, *others, *alone, *rejected]
    return SoundImpacts(sound, onsets, tuple(drops), tuple(notes))


def _heard_drop(
    impacts: Onsets, recording: Recording, sure: bool, corrected: bool
) -> tuple[HeardDrop, list[str]]:
    """One drop by its impacts, and notes; corrected: by hand."""
    run, first, notes = _longest_complete_run(impacts)
    doubt = (
        "" if sure else tr("few impacts, and other sounds nearly as likely to be them")
    )
    if (
        len(run) == 2
        and len(impacts) == 2
        and not recording.drop.height_mm
        and not corrected
    ):
        doubt = tr("two impacts, one interval: another impact may lie between them")
    times, sd = run.time_s, run.sd_s
    listed = tr(
        "{} impacts heard, the first at {:.4f} s, to ± {:.2g} ms each",
        len(run),
        times[0],
        1000 * np.median(sd),
    )
    return HeardDrop(times, sd, first, doubt), [listed, *notes]


def _too_few(onsets: Onsets) -> str:
    message = tr(
        "{} sudden sounds, but none whose intervals shrink as those of a bouncing"
        " body's impacts",
        len(onsets),
    )
    advice = tr(
        "lay the phone beside the plate, let nothing else sound, and record until all"
        " is still"
    )
    return f"{message if len(onsets) else 'no impact is heard'}; {advice}"


def _longest_complete_run(
    impacts: Onsets,
) -> tuple[Onsets, bool, list[str]]:
    """The longest run of impacts with none missing, whether it begins with the first of
    all, notes."""
    edges = [0, *np.flatnonzero(impacts.missed), len(impacts)]
    a, b = max(
        itertools.pairwise(edges), key=lambda part: (part[1] - part[0], -part[0])
    )
    notes = [
        tr(
            "an impact between {:.3f} and {:.3f} s was not heard",
            impacts.time_s[k - 1],
            impacts.time_s[k],
        )
        for k in np.flatnonzero(impacts.missed)
    ]
    if notes:
        notes.append(
            tr("the {} impacts that follow one another without a gap are used", b - a)
        )
    return impacts[a:b], a == 0, notes


def _rejection_notes(onsets: Onsets) -> list[str]:
    """One note for each reason of rejection, with the times of the sounds."""
    by_reason: dict[str, list[str]] = {}
    for no_impact in onsets[onsets.why != ""]:
        by_reason.setdefault(no_impact.why, []).append(f"{no_impact.time_s:.3f}")
    more = {
        reason: tr(" and {} more", len(at) - MOST_LISTED)
        if len(at) > MOST_LISTED
        else ""
        for reason, at in by_reason.items()
    }
    return [
        tr(
            "no impact: the sound at {} s{}: {}",
            ", ".join(at[:MOST_LISTED]),
            more[reason],
            reason,
        )
        for reason, at in by_reason.items()
    ]
