"""Reads recording.toml and bench.toml, merges them, and explains what is wrong in
them."""

import difflib
import re
import reprlib
import tomllib
from pathlib import Path

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from benchtwin.bench.keys import COMPLETE, Keys, Section
from benchtwin.vision.measurement import MeasurementError, require

MOST_BYTES = 30_000  # all keys with comments fill 5,000
RECORDING = "recording.toml"  # stands in a folder of its own within the bench's
LOT_TABLE = "seeds.csv"  # a folder with it is a lot of seeds
LARGEST = 1e15  # larger numbers are not taken for values in another unit
_OTHER_UNITS = {  # end of a key → what its number is in another unit, and its own
    "_mm": (1e-3, "m", "millimetres"),
    "_g": (1e-3, "kg", "grams"),
    "readout_s": (1e3, "ms", "seconds"),
}


def read_toml(path: Path) -> dict:
    """The keys in a recording.toml or bench.toml. MeasurementError, naming the file and
    the field, for anything else."""
    if (size := path.stat().st_size) > MOST_BYTES:
        raise MeasurementError(
            f"{path}: {size:,} bytes; a file of keys has {MOST_BYTES:,} at most"
        )
    try:
        text = path.read_text(encoding="utf-8-sig")
        content = tomllib.loads(text)
    except RecursionError as error:
        raise MeasurementError(
            f"{path}: not valid TOML: brackets within brackets, too deep"
        ) from error
    except tomllib.TOMLDecodeError as error:
        raise MeasurementError(_invalid(path, text, error)) from error
    except UnicodeDecodeError as error:
        raise MeasurementError(
            f"{path}: not UTF-8 text (byte {error.start})"
        ) from error
    except ValueError as error:  # a number of thousands of digits is one, too
        raise MeasurementError(f"{path}: not valid TOML: {error}") from error
    validate(content, path)  # here, so that the error names this file
    found = {
        name: (path.parent / file).resolve()
        for name, file in content.get("seed", {}).items()
        if name in ("lot", "shape")
    }
    if "lot" in found and not (found["lot"] / LOT_TABLE).is_file():
        raise MeasurementError(
            f"{path}: [seed] lot: {found['lot']} is no folder that benchtwin shape"
            " wrote"
        )
    bench = path.parent.parent if path.name == RECORDING else path.parent
    if "shape" in found and not found["shape"].is_relative_to(bench.resolve()):
        raise MeasurementError(
            f"{path}: [seed] shape = {content['seed']['shape']!r}: lies outside the"
            f" bench's folder {bench}; copy the mesh into it"
        )
    if "shape" in found and not found["shape"].is_file():
        raise MeasurementError(
            f"{path}: [seed] shape: there is no file {found['shape']}"
        )
    require(len(found) != 2, f"{path}: [seed] lot and shape: give one of them")
    if found:
        content = content | {
            "seed": content["seed"] | {name: str(file) for name, file in found.items()}
        }
    return _with_photos(content, path)


def _with_photos(content: dict, path: Path) -> dict:
    """The content of a file of keys with where each `plate_photo` lies."""
    found = {}
    for name, section in content.items():
        if isinstance(section, dict) and "plate_photo" in section:
            file = (path.parent / section["plate_photo"]).resolve()
            require(
                file.is_file(), f"{path}: [{name}] plate_photo: there is no file {file}"
            )
            found[name] = section | {"plate_photo": str(file)}
    return content | found


def _invalid(path: Path, text: str, error: tomllib.TOMLDecodeError) -> str:
    """Why a file is no TOML: the line, and what a line should be like."""
    place = re.search(r"\(at line (\d+)", str(error))
    line = text.splitlines()[int(place[1]) - 1 if place else -1].strip()
    said = f"{path}: not valid TOML: {error}"
    if line.startswith("["):
        return f"{said}: {reprlib.repr(line)}; each section stands once in a file"
    if re.fullmatch(r"[\w-]+ *=\s*(#.*)?", line):
        key = line.partition("=")[0].strip()
        return f"{said}: {key} has no value; a # before a line leaves it out"
    return (
        f"{said}: {reprlib.repr(line)}; a number has a point and no unit, a word stands"
        " in quotation marks"
    )


def merge(base: dict, over: dict) -> dict:
    """Both merged key by key; `over` takes precedence."""
    merged = dict(base)
    for key, value in over.items():
        both = isinstance(value, dict) and isinstance(base.get(key), dict)
        merged[key] = {**base[key], **value} if both else value
    return merged


def validate(content: dict, path: Path) -> Keys:
    """The keys of a file's content; MeasurementError naming `path` and every wrong
    field."""
    try:
        return Keys.model_validate(content)
    except ValidationError as error:
        raise MeasurementError(
            "\n".join(_explain(e, path) for e in error.errors()[:10])
        ) from error


def _sections_with(key: str) -> list[str]:
    """The places where a key is known, in words."""
    if key in Keys.model_fields:
        return ["at the top of the file, above the sections"]
    sections = ((n, f.annotation) for n, f in Keys.model_fields.items())
    return [
        f"under [{name}]"
        for name, of in sections
        if isinstance(of, type) and issubclass(of, Section) and key in of.model_fields
    ]


def _explain(error: ErrorDetails, path: Path) -> str:
    """One pydantic error in plain words: file, field, what it should hold."""
    if error["type"] == COMPLETE:
        return "\n".join(f"{path}: {line}" for line in error["msg"].splitlines())
    # pydantic adds the type after the key
    *section, key = [part for part in error["loc"] if isinstance(part, str)][:2] or [""]
    place = f"[{section[0]}] {key}" if section else key
    if error["type"] == "extra_forbidden":
        owner = Keys.model_fields[section[0]].annotation if section else Keys
        if isinstance(owner, type) and issubclass(owner, Section):
            known = list(owner.model_fields)
            near = difflib.get_close_matches(key, known, n=1, cutoff=0.5)
            if owners := _sections_with(key):
                hint = f"it belongs {' or '.join(owners)}"
            elif near:
                hint = f"did you mean {near[0]}?"
            else:
                hint = f"known are {', '.join(known)}"
            return f"{path}: unknown key {place}; {hint}"
    given = error.get("input")
    unit = next((u for end, u in _OTHER_UNITS.items() if key.endswith(end)), None)
    if (
        unit
        and isinstance(given, float | int)
        and not isinstance(given, bool)
        and abs(given) < LARGEST
    ):
        times, other, meant = unit
        return (
            f"{path}: {place} = {given} means {times * given:g} {other}:"
            f" {error['msg'].lower()}; is it in {meant}?"
        )
    message = (
        error["msg"]
        .replace("tuple", "list")
        .replace("dictionary", "section")
        .split(" or instance of ")[0]
    )
    return f"{path}: {place} = {reprlib.repr(given)}: {message[0].lower()}{message[1:]}"
