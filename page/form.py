"""The keys of recording.toml as a form: each with its unit, range, help, present value
and where that comes from."""

import re
from dataclasses import dataclass
from typing import Any

from benchtwin.bench.keys import Keys
from benchtwin.bench.language import tr
from benchtwin.bench.rigs import RIGS
from benchtwin.page.folder import Refused
from benchtwin.vision.recording import Recording

UNITS = {
    "mm": "mm",
    "g": "g",
    "s": "s",
    "deg": "°",
    "kg_m3": "kg/m³",
    "pa_s": "Pa s",
    "px": "px",
    "mm_per_px": "mm/px",
    "fps": "1/s",
    "deg_s": "°/s",
    "mm_s": "mm/s",
    "rad_s": "rad/s",
    "pct": "%",
}
SCHEMA = Keys.model_json_schema()
TOP = SCHEMA["properties"]
SECTIONS = {  # the tables of keys, each with its own JSON schema
    name: SCHEMA["$defs"][told["$ref"].rpartition("/")[2]]
    for name, told in TOP.items()
    if "$ref" in told
}
COMMON_SECTIONS = ("seed", "camera")  # sections that every rig has
UNKNOWN, TAKE_AWAY = "?", "empty the field to take it away"
NAMED = re.compile(r"\[(\w+)\] (\w+)", re.ASCII)  # a key, in any language


@dataclass(frozen=True)
class Field:
    """One key. value: what the file says, None: nothing; inherited: what bench.toml
    says; kind: number, list, choice, yes, text, rows (of numbers,
    set on a picture), UNKNOWN where no key has that name; help: in English; rare: only
    simulating needs it."""

    section: str
    key: str
    kind: str
    unit: str
    bounds: str
    help: str
    choices: tuple[str, ...]
    value: Any
    inherited: Any
    rare: bool = False

    def read(self, text: Any) -> Any:
        """The value that somebody typed; None for nothing. Refused, in words, for what
        cannot be one."""
        if text is None or (isinstance(text, str) and not text.strip()):
            return None
        if self.kind == UNKNOWN:
            raise Refused(tr("{} is not known: {}", self.key, tr(TAKE_AWAY)))
        if self.kind in ("yes", "choice"):
            return text
        if self.kind == "text":
            return str(text).strip()
        if self.kind == "list":
            parts = re.split(r"[;\s]+|,(?!\d)|,\s+", str(text).strip())
        else:
            parts = [str(text)]
        numbers = [_number(part, self) for part in parts if part]
        return numbers if self.kind == "list" else numbers[0]


@dataclass(frozen=True)
class Section:
    """A table of keys, "" those above all tables."""

    name: str
    title: str
    help: str
    fields: tuple[Field, ...]


def form(rig: str | None, content: dict, defaults: dict) -> list[Section]:
    """The sections that a recording of `rig` has; content: its recording.toml;
    defaults: the bench.toml."""
    rig = rig if isinstance(rig, str) and rig in RIGS else None  # as a file may say
    more = RIGS[rig].corrected_in if rig else ("track",)
    wanted = [*COMMON_SECTIONS, *([rig] if rig else []), *more, "air"]
    top = tuple(
        _field("", key, told, content, defaults)
        for key, told in TOP.items()
        if key not in SECTIONS
    )
    sections = [Section("", "Recording", "", top)]
    for name in wanted:
        model = SECTIONS[name]
        inside, above = table(content, name), table(defaults, name)
        fields = tuple(
            _field(name, key, told, inside, above)
            for key, told in model["properties"].items()
        )
        sections.append(Section(name, name.capitalize(), _help(model), fields))
    if wrong := _unknown(content):
        sections.insert(0, Section(UNKNOWN, "Not known", TAKE_AWAY, wrong))
    return sections


def table(content: dict, name: str) -> dict:
    """The table of this name; an empty one where something else stands there."""
    found = content.get(name)
    return found if isinstance(found, dict) else {}


def _unknown(content: dict) -> tuple[Field, ...]:
    """What no key is called, and what is no table where one should stand."""
    tabular = {*SECTIONS, "conditions"}
    places = [
        ("", key, value)
        for key, value in content.items()
        if key not in TOP or (key in tabular and not isinstance(value, dict))
    ]
    for name, model in SECTIONS.items():
        inside = table(content, name).items()
        places += [(name, k, v) for k, v in inside if k not in model["properties"]]
    return tuple(
        Field(section, key, UNKNOWN, "", "", TAKE_AWAY, (), repr(value), None)
        for section, key, value in places
    )


def needed(reasons: list[str], recording: Recording) -> set[tuple[str, str]]:
    """Keys (section, key) that the reasons of a measurement name, and its rig: those
    that the recording does not state."""
    named = {place for reason in reasons for place in NAMED.findall(reason)}
    return {
        (section, key)
        for section, key in named | {("", "rig")}
        if getattr(getattr(recording, section, recording), key, UNKNOWN) is None
    }


def _help(told: dict) -> str:
    """What a JSON schema says of what it describes, in one line."""
    return " ".join(told.get("description", "").split())


def _field(section: str, key: str, told: dict, content: dict, defaults: dict) -> Field:
    kind, choices, bounds = _kind(told)
    plain = key.removesuffix("_sd")
    longest_first = sorted(UNITS, key=len, reverse=True)
    ends = (e for e in longest_first if plain == e or plain.endswith(f"_{e}"))
    unit = next((UNITS[end] for end in ends), "")
    stated, words = (content.get(key), defaults.get(key)), _help(told)
    rare = "simulated" in told
    return Field(section, key, kind, unit, bounds, words, choices, *stated, rare)


def _kind(told: dict) -> tuple[str, tuple[str, ...], str]:
    """(kind, choices, bounds in words) of a key's JSON schema."""
    parts = [p for p in told.get("anyOf", [told]) if p["type"] != "null"]
    one = parts[0]
    choices = [c for p in parts for c in p.get("enum", [p.get("const")])]
    if choices := [str(c) for c in choices if c is not None]:
        return "choice", tuple(choices), ""
    if one["type"] == "array":
        if one.get("items", {}).get("type") == "array":
            return "rows", (), ""
        count = len(one.get("prefixItems", ()))
        return "list", (), tr("{} numbers", count) if count else ""
    plain = {"object": "conditions", "boolean": "yes", "string": "text"}
    if one["type"] in plain:
        return plain[one["type"]], (), ""
    return "number", (), _range(one)


def _range(told: dict) -> str:
    """Least and greatest value in words, and which of them may not stand there."""
    low = told.get("exclusiveMinimum", told.get("minimum"))
    high = told.get("exclusiveMaximum", told.get("maximum"))
    above, below = "exclusiveMinimum" in told, "exclusiveMaximum" in told
    if low is not None and high is not None and not (above or below):
        return tr("{:g} to {:g}", low, high)
    least = (
        ""
        if low is None
        else tr("above {:g}", low)
        if above
        else tr("{:g} or more", low)
    )
    most = (
        ""
        if high is None
        else tr("below {:g}", high)
        if below
        else tr("up to {:g}", high)
    )
    return ", ".join(filter(None, (least, most)))


def _number(text: str, field: Field) -> float | int:
    """A decimal comma is a point: nobody groups thousands in a form."""
    plain = text.strip().replace(",", ".").removesuffix(field.unit).strip()
    try:
        value = float(plain)
    except ValueError:
        raise Refused(tr("{}: {!r} is not a number", field.key, text)) from None
    if value == int(value) and re.fullmatch(r"[+-]?\d+", plain):
        return int(value)
    return value
