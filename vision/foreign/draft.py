"""Drafts a bench folder from files of other tools, with guesses and questions as
comments."""

import re
import shutil
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pandas as pd
import tomlkit

from benchtwin.bench.conditions import NAME, UNITS
from benchtwin.bench.keys import Camera
from benchtwin.bench.outlets import one_line
from benchtwin.bench.rigs import RIGS, rigs_in_words
from benchtwin.vision.evidence.photo import PHOTO_SUFFIXES
from benchtwin.vision.evidence.sound import SOUND_SUFFIXES
from benchtwin.vision.foreign.as_evidence import Evidence, evidence_in
from benchtwin.vision.foreign.contents import Asked, Contents
from benchtwin.vision.foreign.source import LENGTH
from benchtwin.vision.measurement import MeasurementError, require
from benchtwin.vision.recording import VIDEO_SUFFIXES, bare_recording
from benchtwin.vision.tell_rig import rig_of_rows, told_rig

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
BENCH_QUESTIONS = (
    Asked(
        "what was dropped, slid or rolled: its sizes and mass?",
        "[seed] length_mm, width_mm, thickness_mm, mass_g",
    ),
    Asked(
        "how far was the camera from the plane of the motion?", "[camera] distance_mm"
    ),
)


ASKED_OF_FILM = ("mm_per_px", "fps")


@dataclass(frozen=True)
class Draft:
    """One recording to be written; evidence: a file name; table: its rows, none where
    the file itself is copied."""

    name: str
    file: Path
    rig: str
    evidence: str
    table: pd.DataFrame
    found: Contents

    def with_name(self) -> "Draft":
        """The draft with what the file's name says: conditions, and a drop's height
        where it holds one length, as guesses; of several lengths it is asked."""
        name, found = self.file.stem, self.found
        keys, guesses, questions = {**found.keys}, [*found.guesses], [*found.questions]
        if stated := conditions_in(name):
            keys["conditions"] = stated
            guesses += [
                f"{k} = {v:g}: as the file's name says" for k, v in stated.items()
            ]
        said = lengths_mm(name) if self.rig == "drop" else []
        if len(said) > 1:
            which = " or ".join(f"{mm:g}" for mm in said)
            asked = f"which length in the file's name is [drop] height_mm: {which} mm?"
            questions.append(Asked(asked))
        elif said and "height_mm" not in keys.get("drop", {}):
            keys["drop"] = {**keys.get("drop", {}), "height_mm": said[0]}
            guesses.append(
                f"height_mm = {said[0]:g}: the length in the file's name; is it from"
                " the seed's lowest point to the plate?"
            )
        told = replace(
            found, keys=keys, guesses=tuple(guesses), questions=tuple(questions)
        )
        return replace(self, found=told)

    @property
    def asked(self) -> tuple[Asked, ...]:
        """What the file leaves open, and keys of the rig and of a film that nobody
        states."""
        out = [*self.found.questions]
        if self.rig:
            out += [Asked(words, keys) for keys, words in RIGS[self.rig].asked]
        else:
            out.append(Asked(f"which rig is it: {rigs_in_words()}?", "rig"))
        if Path(self.evidence).suffix.lower() in VIDEO_SUFFIXES:
            known = ((k, Camera.model_fields[k].description) for k in ASKED_OF_FILM)
            out += [
                Asked(" ".join((said or "").split()), f"[camera] {k}")
                for k, said in known
            ]
        stated = self.found.keys | {
            self.rig: {**self.found.keys.get(self.rig, {}), **dict.fromkeys(self.table)}
        }  # what rows state, too
        return tuple(filter(None, (one.beside(stated) for one in out)))


def drafts_of(path: Path, rig: str, track: int | None) -> Iterator[Draft]:
    """The recordings in one file, by its content; rig: "" where it is not
    stated; track: number of the one to use, None for the likeliest."""
    copied = next((k for suffixes, k in _COPIED if path.suffix.lower() in suffixes), "")
    film = [Evidence(Contents(copied), path.name)]
    for one in film if copied else evidence_in(path, track):
        found, measured = one.found, one.kind == "track.csv" or copied
        require(
            measured or rig in ("", one.rig),
            f"{path}: {one.why}: it is of a {one.rig}, not of a {rig}",
        )
        own, why = rig, ""
        if not rig and (told := _told(path, one)):
            own, why = told
        guesses = (*one.notes, *([f'rig = "{own}": {why}'] if why else ()))
        questions = (*map(Asked, filter(None, [found.doubt])), *found.questions)
        yield Draft(
            f"{path.stem}-{one.number}" if one.number else path.stem,
            path,
            own,
            path.name if one.rows.empty else one.kind,
            one.rows,
            replace(found, guesses=(*guesses, *found.guesses), questions=questions),
        )


def _told(path: Path, one: Evidence) -> tuple[str, str] | None:
    """(rig, why) by what the file shows; None also where it cannot be read, which
    measuring says."""
    if one.rig:
        return one.rig, one.why
    if one.rows.empty:
        with suppress(MeasurementError):
            return told_rig(bare_recording(path))
        return None
    told = None if one.found.doubt else rig_of_rows(one.rows)
    # a fall that is not told is not one with the acceleration of gravity
    return None if told and told[0] == "drop" else told


def write_bench(folder: Path, drafts: list[Draft], trouble: list[str]) -> list[str]:
    """Write bench.toml and a folder for each draft into `folder`, which is empty;
    returns all questions. trouble: files not read."""
    whose: dict[str, list[str]] = {}
    for draft in drafts:
        inside = folder / draft.name
        inside.mkdir()
        (inside / "recording.toml").write_text(_recording_toml(draft), encoding="utf8")
        evidence = inside / draft.evidence
        if draft.table.empty:
            shutil.copyfile(draft.file, evidence)
        else:
            draft.table.to_csv(evidence, index=False, float_format="%.9g")
        for question in map(str, draft.asked):
            whose.setdefault(question, []).append(draft.name)
    alike = [q for q, names in whose.items() if 1 < len(names) == len(drafts)]
    questions = [f"{', '.join(whose[q])}: {q}" for q in whose if q not in alike]
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
    _ask(document, BENCH_QUESTIONS)
    (folder / "bench.toml").write_text(tomlkit.dumps(document), encoding="utf8")
    return [*(f"all: {q}" for q in (*BENCH_QUESTIONS, *for_all)), *questions]


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
            f"Drafted from {draft.file.name} ({draft.found.tool}). GUESS: assumed,"
            " correct it where it is wrong."
        )
    )
    if draft.rig:
        document["rig"] = draft.rig
    for guess in draft.found.guesses:
        document.add(_comment(f"GUESS: {guess}"))
    _ask(document, [one for one in draft.asked if not one.section])
    for section, held in draft.found.keys.items():
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
