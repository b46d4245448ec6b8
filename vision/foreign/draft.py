"""Drafts a bench folder from files of other tools, with guesses and questions as
comments."""

import re
import shutil
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pandas as pd
import tomlkit
from pydantic import BaseModel

from benchtwin.bench.conditions import NAME, UNITS
from benchtwin.bench.keys import Keys
from benchtwin.bench.outlets import one_line
from benchtwin.bench.rigs import RIGS, rigs_in_words
from benchtwin.vision.evidence.photo import PHOTO_SUFFIXES
from benchtwin.vision.evidence.sound import SOUND_SUFFIXES
from benchtwin.vision.foreign import read_foreign
from benchtwin.vision.foreign.as_evidence import (
    choose_track,
    falls_freely,
    impact_rows,
    track_rows,
)
from benchtwin.vision.foreign.contents import Contents
from benchtwin.vision.foreign.source import LENGTH
from benchtwin.vision.measurement import MeasurementError, require
from benchtwin.vision.recording import VIDEO_SUFFIXES, bare_recording
from benchtwin.vision.tell_rig import rig_of_motion, told_rig

BENCH_HEADING = "What holds for every recording here; a recording.toml wins over it."
_COPIED = (
    (VIDEO_SUFFIXES, "video"),
    (SOUND_SUFFIXES, "recording of sound"),
    (PHOTO_SUFFIXES, "photo"),
)
# how a drafted recording.toml begins, with the name of its file
DRAFTED = re.compile(r"# Drafted from (.*) \([^()]*\)\. GUESS")
WRITTEN = ("track.csv", "impacts.csv", "tilt.csv", "readings.csv")
# "drop_150mm_3", "h 15,5 cm"; a unit that goes on is another word
_LENGTH = re.compile(
    r"(?<![\d.,])(\d+(?:[.,]\d+)?)[ _]?((?i:mm|cm|dm|in|ft)|m)(?![^\W_])"
)
_CONDITION = re.compile(  # "moisture12pct", "plate_at_25degC"
    r"([^\W\d_]{2,})[ _-]?(\d+(?:[.,]\d+)?)[ _-]?"
    r"(%|pct|percent|‰|ppm|rpm|hz|h?pa|kpa|mpa|°c|degc|°|deg)(?![^\W_])",
    re.IGNORECASE,
)
_WORD = re.compile(r"[^\W\d_]{3,}")
NO_CONDITION = {
    *RIGS,
    *("run", "test", "trial", "file", "video", "film", "img", "dsc", "mov", "track"),
    *("raw", "data", "sound", "clap", "messung", "versuch", "export"),
}
BENCH_QUESTIONS = {  # by the keys that answer them
    "[seed] length_mm, width_mm, thickness_mm, mass_g": (
        "what was dropped, slid or rolled: its sizes and mass?"
    ),
    "[camera] distance_mm": "how far was the camera from the plane of the motion?",
}


@dataclass(frozen=True)
class Asked:
    """A question that keys of one section answer; section "": of the file's top."""

    section: str
    keys: tuple[str, ...]
    words: str

    def __str__(self) -> str:
        section = f"[{self.section}] " if self.section else ""
        return f"{section}{', '.join(self.keys)}: {self.words}"

    def beside(self, stated: dict[str, dict[str, Any]]) -> "Asked | None":
        """Of the keys that are not stated; None where all are."""
        rest = tuple(k for k in self.keys if k not in stated.get(self.section, {}))
        return replace(self, keys=rest) if rest else None


def asked_by(spec: str, words: str) -> Asked:
    """A question by the keys that answer it, as "[seed] length_mm, width_mm"."""
    section, _, keys = spec.removeprefix("[").partition("] ")
    return Asked(section, tuple(keys.split(", ")), words)


def asked_of(section: str, key: str) -> Asked:
    """A key and what its documentation says."""
    model = Keys.model_fields[section].annotation
    assert isinstance(model, type) and issubclass(model, BaseModel)
    words = " ".join((model.model_fields[key].description or "").split())
    return Asked(section, (key,), words)


@dataclass(frozen=True)
class Draft:
    """One recording to be written; evidence: a file name; table: its rows, None where
    the file itself is copied."""

    name: str
    file: Path
    tool: str
    rig: str
    evidence: str
    table: pd.DataFrame | None
    keys: dict[str, dict[str, Any]] = field(default_factory=dict)
    guesses: tuple[str, ...] = ()
    questions: tuple[str, ...] = ()

    def with_name(self) -> "Draft":
        """The draft with what the file's name says: conditions, and a drop's height
        where it holds one length, as guesses; of several lengths it is asked."""
        name, keys, guesses = self.file.stem, dict(self.keys), list(self.guesses)
        if told := conditions_in(name):
            keys["conditions"] = told
            guesses += [
                f"{k} = {v:g}: as the file's name says" for k, v in told.items()
            ]
        said = lengths_mm(name) if self.rig == "drop" else []
        questions = self.questions
        if len(said) > 1:
            which = " or ".join(f"{mm:g}" for mm in said)
            asked = f"which length in the file's name is [drop] height_mm: {which} mm?"
            questions = (*questions, asked)
        elif said and "height_mm" not in keys.get("drop", {}):
            keys["drop"] = {**keys.get("drop", {}), "height_mm": said[0]}
            guesses.append(
                f"height_mm = {said[0]:g}: the length in the file's name; is it from"
                " the seed's lowest point to the plate?"
            )
        return replace(self, keys=keys, guesses=tuple(guesses), questions=questions)

    @property
    def asked(self) -> tuple[Asked, ...]:
        """The keys of the rig, and of pictures that are not in millimetres and seconds,
        that nobody states."""
        which = Asked("", ("rig",), f"which rig is it: {rigs_in_words()}?")
        of_rig = RIGS[self.rig].asked if self.rig else ()
        out = [] if self.rig else [which]
        out += [asked_by(*asked) for asked in of_rig]
        seen = () if self.table is None else self.table.columns
        filmed = Path(self.evidence).suffix.lower() in VIDEO_SUFFIXES
        out += [
            asked_of("camera", key)
            for key, column in (("mm_per_px", "x_px"), ("fps", "frame"))
            if filmed or (column in seen and not (key == "fps" and "t_s" in seen))
        ]
        stated = self.keys | {
            self.rig: {**self.keys.get(self.rig, {}), **dict.fromkeys(seen)}
        }  # what rows state, too
        return tuple(filter(None, (one.beside(stated) for one in out)))


def drafts_of(path: Path, rig: str, track: int | None) -> Iterator[Draft]:
    """The recordings in one file, by its content; rig: "" where it is not
    stated; track: number of the one to use, None for the likeliest."""
    kind = next((k for suffixes, k in _COPIED if path.suffix.lower() in suffixes), "")
    if kind:
        told = None if rig else _told(path)
        rig, guess = _guessed(rig, told)
        yield Draft(path.stem, path, kind, rig, path.name, None, guesses=guess)
        return
    found = read_foreign(path)
    read_off = "heights of rebounds were read off"
    for own, evidence, table, why in (
        ("slide", "tilt.csv", found.tilt, "a plate tilts"),
        ("drop", "readings.csv", found.readings, read_off),
    ):
        if table is not None:
            _, guess = _guessed(_only(path, rig, own, why), (own, why))
            yield _draft(path, path.stem, found, own, evidence, table, guess)
            return
    if found.waveform is not None:
        _, guess = _guessed(rig, ("drop", "impacts were heard"))
        yield Draft(path.stem, path, found.tool, "drop", path.name, None, guesses=guess)
    elif found.runs:
        require(
            track is None or 1 <= track <= len(found.runs),
            f"{path}: --track {track}: it holds {len(found.runs)} runs of impact times",
        )
        heard = "impacts were heard"
        _, guess = _guessed(_only(path, rig, "drop", heard), ("drop", heard))
        for number, (name, times) in enumerate(found.runs, 1):
            if track in (None, number):
                stem = path.stem if len(found.runs) == 1 else f"{path.stem}-{number}"
                which = (f"run {number} of {len(found.runs)}: {name}",) if name else ()
                rows, reasons = impact_rows(path, name, times), (*which, *guess)
                yield _draft(path, stem, found, "drop", "impacts.csv", rows, reasons)
    else:
        several = range(1, len(found.tracks) + 1)
        for one in several if found.repeats and track is None else (track,):
            yield _track_draft(path, found, rig, one)


def _track_draft(path: Path, found: Contents, rig: str, number: int | None) -> Draft:
    """One track of a file, of which every track may be a repeat."""
    one, reasons = choose_track(path, found, number)
    told = None if found.doubt else rig_of_motion(one.time, one.x, one.y)
    if falls_freely(found, one):
        told = "drop", "it falls freely"
    elif found.aside:
        told = "drop", "it falls freely, along x"
    elif told is not None and told[0] == "drop":
        told = None  # not with the acceleration of gravity
    rig, guess = _guessed(rig, told)
    rows, name = track_rows(found, one), path.stem
    if found.repeats:
        name = f"{path.stem}-{number}"
        reasons = (f"repeat {number} of {len(found.tracks)}: {one.name}".rstrip(": "),)
    return _draft(path, name, found, rig, "track.csv", rows, (*reasons, *guess))


def _guessed(rig: str, told: tuple[str, str] | None) -> tuple[str, tuple[str, ...]]:
    """The rig as stated, or as it is told, and what was guessed then."""
    if rig or told is None:
        return rig, ()
    return told[0], (f'rig = "{told[0]}": {told[1]}',)


def _only(path: Path, rig: str, own: str, why: str) -> str:
    """The rig as stated; MeasurementError where what the file holds belongs to another,
    its `own`."""
    require(rig in ("", own), f"{path}: {why}: it is of a {own}, not of a {rig}")
    return rig


def _told(path: Path) -> tuple[str, str] | None:
    """(rig, why) by what the file shows; None also where it cannot be read, which
    measuring says."""
    try:
        return told_rig(bare_recording(path))
    except MeasurementError:
        return None


def _draft(
    path: Path,
    name: str,
    found: Contents,
    rig: str,
    evidence: str,
    table: pd.DataFrame,
    reasons: tuple[str, ...],
) -> Draft:
    questions = (*((found.doubt,) if found.doubt else ()), *found.questions)
    guesses = (*reasons, *found.guesses)
    return Draft(
        name, path, found.tool, rig, evidence, table, found.keys, guesses, questions
    )


def write_bench(folder: Path, drafts: list[Draft], trouble: list[str]) -> list[str]:
    """Write bench.toml and a folder for each draft into `folder`, which is empty;
    returns all questions. trouble: files not read."""
    whose: dict[str, list[str]] = {}
    for draft in drafts:
        inside = folder / draft.name
        inside.mkdir()
        (inside / "recording.toml").write_text(_recording_toml(draft), encoding="utf8")
        evidence = inside / draft.evidence
        if draft.table is None:
            shutil.copyfile(draft.file, evidence)
        else:
            draft.table.to_csv(evidence, index=False, float_format="%.9g")
        for question in (*draft.questions, *map(str, draft.asked)):
            whose.setdefault(question, []).append(draft.name)
    alike = [q for q, names in whose.items() if 1 < len(names) == len(drafts)]
    questions = [f"{', '.join(whose[q])}: {q}" for q in whose if q not in alike]
    asked = [asked_by(spec, words) for spec, words in BENCH_QUESTIONS.items()]
    for_all = alike
    if words := words_that_differ([draft.file.stem for draft in drafts]):
        for_all.append(
            f"[conditions]: the names differ by {', '.join(words)}: is that a"
            f' condition, such as plate = "{words[0]}" beside those recordings?'
        )
    document = tomlkit.document()
    document.add(_comment(BENCH_HEADING))
    document["provenance"] = "measured"
    for heading, lines in (
        ("QUESTIONS for all", for_all),
        ("QUESTIONS by recording, answered in its own recording.toml", questions),
        ("NOT READ", trouble),
    ):
        for line in lines:
            document.add(_comment(f"{heading}: {line}"))
    _ask(document, asked)
    (folder / "bench.toml").write_text(tomlkit.dumps(document), encoding="utf8")
    return [*(f"all: {q}" for q in (*asked, *for_all)), *questions]


def _ask(document: tomlkit.TOMLDocument, asked: Iterable[Asked]) -> None:
    """Write each question into the section whose keys answer it, with those keys."""
    for one in asked:
        if one.section and one.section not in document:
            document[one.section] = tomlkit.table()
        into: Any = document[one.section] if one.section else document
        into.add(_comment(f"QUESTION: {one.words}"))
        for key in one.keys:
            into.add(_comment(f"{key} ="))


def _recording_toml(draft: Draft) -> str:
    document = tomlkit.document()
    document.add(
        _comment(
            f"Drafted from {draft.file.name} ({draft.tool}). GUESS: assumed, correct it"
            " where it is wrong."
        )
    )
    if draft.rig:
        document["rig"] = draft.rig
    for guess in draft.guesses:
        document.add(_comment(f"GUESS: {guess}"))
    for question in draft.questions:
        document.add(_comment(f"QUESTION: {question}"))
    _ask(document, [one for one in draft.asked if not one.section])
    for section, held in draft.keys.items():
        table = tomlkit.table()
        for key, value in held.items():
            table[key] = value
            table[key].comment(f"GUESS: as {one_line(draft.file.name)} says")
        document[section] = table
    _ask(document, [one for one in draft.asked if one.section])
    return tomlkit.dumps(document)


def _comment(text: str):
    return tomlkit.comment(one_line(text))


def lengths_mm(name: str) -> list[float]:
    """The lengths in a name [mm].

    >>> lengths_mm("drop_150mm_3"), lengths_mm("Fall aus 15,5 cm"), lengths_mm("1-18-M")
    ([150.0], [155.0], [])
    """
    return [
        round(float(number.replace(",", ".")) * LENGTH[unit.lower()], 3)
        for number, unit in _LENGTH.findall(name)
    ]


def conditions_in(name: str) -> dict[str, float]:
    """Keys of [conditions] that a name states: a word, a number and a unit.

    >>> conditions_in("drop_moisture_12pct_3")
    {'moisture_pct': 12.0}
    """
    return {
        f"{word.lower()}_{UNITS[unit.lower()]}": float(number.replace(",", "."))
        for word, number, unit in _CONDITION.findall(name)
        if NAME.fullmatch(word)
    }


def words_that_differ(names: Sequence[str]) -> list[str]:
    """Words by which names form groups, each of more than one file on average.

    >>> words_that_differ(["steel-1", "steel-2", "glass-1", "glass-2"])
    ['glass', 'steel']
    """
    held = [{w.lower() for w in _WORD.findall(n)} - NO_CONDITION for n in names]
    groups = {frozenset(words) for words in held}
    if not 1 < len(groups) <= len(names) / 2:
        return []
    return sorted(set().union(*groups) - set.intersection(*map(set, groups)))
