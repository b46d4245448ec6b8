"""A rig as the rest of the program knows it: one record, in the rig's own folder."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from benchtwin.bench.section import Section

Quantity = tuple[str, str]  # name and unit, "1" where it has none
KeyPlace = tuple[str, str]  # section and key of recording.toml
PACKAGE = "benchtwin.rigs"


@dataclass(frozen=True)
class Rig:
    """A rig: what is known of it without loading what it is computed with.

    name: of its folder, and the value of `rig` in recording.toml; what: happens in it,
    in words; plural: its recordings in words; keys: its section of recording.toml;
    order: its place in lists and reports. main: the quantity that fails where a
    recording cannot be measured; printed: quantities in groups, of each of which the
    first measured one is printed. readings: columns of readings.csv → quantity, the
    column that a calibration answers first; zeros: those that may be 0; by_row: keys of
    its section that a row of readings.csv may state for itself; in_turn: a column that
    numbers readings of which each states a key for the next, and that key. told_by:
    evidence that only this rig leaves → why. gate_place: column of gates.csv that says
    where a gate stands. wanted: keys without which a number is missing or in doubt;
    asked: keys that no other tool's file states → the question. corrected_in: further
    sections of keys in which its measuring is corrected. variants: names by which
    `simulate` knows it with other keys; not_diagnosed: those that a diagnosis does not
    judge, and why; by_turns: keys that its runs have by turns
    where none is stated; per_recording: keys of a recording, not of how the rig is
    built; weighed: such keys that say what was weighed.
    own_parameters: whether each recording can have a parameter of its own.

    The parts are named "module:function", modules from the rig's folder on where they
    begin with a point; they are loaded when they are used. "": there is no such part.
    observe(recording, options, progress) → Observation, of pictures and tables;
    heard(impacts in a sound, recording) → Observation, where a sound tells of it;
    moves(time, x, y) → why a motion, y up, is no other rig's, "" where it may be;
    refuse(recording) → why its keys say that there is nothing to measure, "";
    derive(recording, summary, common sd) → what follows from the mean of its readings;
    together(recordings with observations) → observations of several together; setup:
    how it is simulated; read(folder) → its recordings as plain arrays; curve(read,
    relative, timed) → what one shows, to be laid over its twin; diagnose(recordings,
    rng) → Finding; effects: what may be missing, by name; resimulate: the simulation
    run again with what was named; tells: what a calibration learns from it
    (`bench/tells.py`)."""

    name: str
    what: str
    keys: type[Section]
    main: Quantity
    plural: str = ""
    order: int = 100
    printed: tuple[tuple[str, ...], ...] = ()
    readings: Mapping[str, Quantity] = field(default_factory=dict, hash=False)
    zeros: tuple[str, ...] = ()
    by_row: tuple[str, ...] = ()
    in_turn: tuple[str, ...] = ()
    told_by: Mapping[str, str] = field(default_factory=dict, hash=False)
    gate_place: str = ""
    wanted: tuple[KeyPlace, ...] = ()
    asked: tuple[tuple[str, str], ...] = ()
    corrected_in: tuple[str, ...] = ("track",)
    variants: Mapping[str, dict] = field(default_factory=dict, hash=False)
    not_diagnosed: Mapping[str, str] = field(default_factory=dict, hash=False)
    by_turns: tuple[Mapping[str, object], ...] = field(default=({},), hash=False)
    per_recording: tuple[str, ...] = ()
    weighed: tuple[str, ...] = ()
    own_parameters: bool = False
    observe: str = ""
    heard: str = ""
    moves: str = ""
    refuse: str = ""
    derive: str = ""
    together: str = ""
    setup: str = ""
    curve: str = ""
    read: str = ""
    diagnose: str = ""
    effects: str = ""
    resimulate: str = ""
    tells: str = ""

    def __post_init__(self) -> None:
        own = {part: place for part, place in self._parts() if place.startswith(".")}
        missing = [
            f"{part} = {place!r}" for part, place in own.items() if not self._has(place)
        ]
        if missing:
            said = f"there is no {', no '.join(missing)}"
            raise ImportError(f"the rig {self.name!r} is incomplete: {said}")

    @property
    def in_plural(self) -> str:
        """ "drops"."""
        return self.plural or f"{self.name}s"

    def as_built(self, section: dict) -> dict:
        """Its section of recording.toml without what is a single recording's."""
        apart = (*self.per_recording, *self.weighed)
        return {k: v for k, v in section.items() if k not in apart}

    def turn(self, k: int, section: dict) -> dict:
        """Its section of recording.toml for the k-th of several runs."""
        return {**self.by_turns[k % len(self.by_turns)], **section}

    def part(self, name: str) -> Any:
        """One of its parts, loaded; ValueError where it has none."""
        place = getattr(self, name)
        if not place:
            raise ValueError(f"the rig {self.name!r} has no part {name!r}")
        module, _, function = place.partition(":")
        package = f"{PACKAGE}.{self.name}"
        return getattr(import_module(module, package), function)

    def _parts(self) -> list[tuple[str, str]]:
        names = [f.name for f in fields(self)]
        return [(n, getattr(self, n)) for n in names[names.index("observe") :]]

    def _has(self, place: str) -> bool:
        """Whether ".module:function" names what a module of its folder defines."""
        module, _, function = place[1:].partition(":")
        folder = _folder(self.name).joinpath(*module.split("."))
        files = folder.with_suffix(".py"), folder / "__init__.py"
        text = next((f.read_text(encoding="utf8") for f in files if f.is_file()), "")
        begins = (f"def {function}(", f"{function}:", f"{function} =")
        return bool(function) and any(
            line.startswith(begins) for line in text.splitlines()
        )


def _folder(name: str) -> Path:
    spec = find_spec(f"{PACKAGE}.{name}")
    assert spec is not None and spec.origin is not None
    return Path(spec.origin).parent
