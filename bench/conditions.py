"""[conditions] of recording.toml and bench.toml: what differs between recordings,
numbers with the unit in the name, or words."""

import datetime
import re
import reprlib
from collections.abc import Iterator

from benchtwin.bench.language import tr

MOST_CONDITIONS = 20
LONGEST_NAME, LONGEST_WORD = 40, 100  # characters
LARGEST = 1e10  # of any number
NAME = re.compile(r"[A-Za-z0-9_]+")
UNITS = {  # as written in a value → as written at the end of a key
    "%": "pct",
    "percent": "pct",
    "pct": "pct",
    "‰": "permille",
    "ppm": "ppm",
    "°": "deg",
    "deg": "deg",
    "°c": "c",
    "degc": "c",
    "c": "c",
    "k": "k",
    "nm": "nm",
    "µm": "um",
    "μm": "um",
    "um": "um",
    "mm": "mm",
    "cm": "cm",
    "m": "m",
    "mg": "mg",
    "g": "g",
    "kg": "kg",
    "ms": "ms",
    "s": "s",
    "sec": "s",
    "min": "min",
    "h": "h",
    "hours": "h",
    "days": "days",
    "pa": "pa",
    "hpa": "hpa",
    "kpa": "kpa",
    "mpa": "mpa",
    "gpa": "gpa",
    "mbar": "mbar",
    "bar": "bar",
    "mm/s": "mm_s",
    "cm/s": "cm_s",
    "m/s": "m_s",
    "hz": "hz",
    "rpm": "rpm",
    "n": "n",
    "mn": "mn",
    "v": "v",
    "ml": "ml",
    "kg/m3": "kg_m3",
    "kg/m³": "kg_m3",
    "g/cm3": "g_cm3",
    "g/cm³": "g_cm3",
}
UNKNOWN = ("", "?", "-", "n/a", "nan", "inf", "+inf", "-inf", "unknown")
RESERVED = {
    "session": 'it has a key of its own above all sections: session = "…"',
    "order": (
        "the order of the recordings is called that; choose another name, such as"
        " run_number"
    ),
}
# columns of measurements.csv, in which a condition is one more
MEASURED = (
    *("recording", "rig", "quantity", "value", "sd", "sd_common"),
    *("unit", "quality", "reason", "overlay"),
)
TAKEN = "a column of measurements.csv is called that; choose another name, such as {}"
RESERVED |= {name: TAKEN.format(f"my_{name}") for name in MEASURED}
_NUMBER = r"[+-]?\d+(?:[.,]\d+)?(?:[eE][+-]?\d+)?"
_IN_WORDS = re.compile(
    rf"(?:about|approx\.?|ca\.?|[~≈<>])?\s*({_NUMBER})(?:\s*(?:±|\+/?-)\s*{_NUMBER})?(\s*)(\D.*?)?"
)


def condition_errors(conditions: dict) -> Iterator[str]:
    """What is wrong with a table of conditions, each with what should be written
    instead."""
    if len(conditions) > MOST_CONDITIONS:
        yield (
            tr(
                "[conditions]: {} of them; a recording states {} at most",
                len(conditions),
                MOST_CONDITIONS,
            )
        )
    for key, value in conditions.items():
        if message := _name_error(key) or _value_error(key, value):
            yield f"[conditions] {message}"


def _name_error(key: str) -> str:
    if len(key) > LONGEST_NAME:
        return tr(
            "{}: a name of {} characters; it should have {} at most",
            reprlib.repr(key),
            len(key),
            LONGEST_NAME,
        )
    if not NAME.fullmatch(key):
        better = re.sub(r"[^A-Za-z0-9]+", "_", key).strip("_")
        hint = tr(", such as {}", better) if better else ""
        return tr(
            "{!r}: a name is made of letters, digits and underscores{}", key, hint
        )
    return f"{key}: {tr(RESERVED[key])}" if key in RESERVED else ""


def _value_error(key: str, value: object) -> str:
    place = f"{key} = {reprlib.repr(value)}"
    match value:
        case bool():
            return tr(
                '{} = {}: yes or no is written as a word: {} = "{}"',
                key,
                str(value).lower(),
                key,
                tr("yes") if value else tr("no"),
            )
        case int() | float():
            if not -LARGEST <= value <= LARGEST:  # NaN neither
                return tr(
                    "{}: should be a finite number below {:g}; leave the key out where"
                    " it is unknown",
                    place,
                    LARGEST,
                )
            return ""
        case str():
            return _word_error(key, value)
        case datetime.date() | datetime.time():
            return tr(
                '{}: a date or time is written as a word: {} = "{}"', place, key, value
            )
        case list():
            return tr(
                "{} is a list; a condition is one number or one word, in the"
                " recording.toml of each recording",
                key,
            )
        case dict():
            return tr(
                "{} is a section of its own; a condition is one number or one word: {}"
                " = 1.5",
                key,
                key,
            )
    return tr("{}: should be a number or a word", place)


def _word_error(key: str, word: str) -> str:
    bare = word.strip()
    if bare.lower() in UNKNOWN:
        return tr("{} = {!r}: leave the key out where it is unknown", key, word)
    if len(word) > LONGEST_WORD:
        return tr(
            "{} = {}: {} characters; a word for a condition has {} at most",
            key,
            reprlib.repr(word),
            len(word),
            LONGEST_WORD,
        )
    number = _number_in(bare)
    if number is None:
        return ""
    value, unit = number
    name = key if not unit or key.lower().endswith(f"_{unit}") else f"{key}_{unit}"
    if value.isdigit() and not unit:
        label = tr('; a name such as plate {} is a word: "no {}"', value, value)
    else:
        label = ""
    return tr(
        "{} = {!r}: a number stands without quotes, with a point, its unit in the name:"
        " {} = {}{}",
        key,
        word,
        name,
        value,
        label,
    )


def _number_in(word: str) -> tuple[str, str] | None:
    """The number and the unit's name in a word that is a number, None for a word such
    as "B", "2B" or "3 old plates"."""
    found = _IN_WORDS.fullmatch(word)
    if found is None:
        return None
    number, gap, rest = found[1].replace(",", "."), found[2], (found[3] or "").strip()
    unit = UNITS.get(rest.lower(), "")
    # "2C" is a plate's name, "20 C" a temperature
    if rest and (not unit or (not gap and len(rest) == 1 and rest.isupper())):
        return None
    return number.removeprefix("+"), unit
