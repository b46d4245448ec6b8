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
from benchtwin.bench.language import tr
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
            tr(
                "{}: {:,} bytes; a file of keys has {:,} at most",
                path,
                size,
                MOST_BYTES,
            )
        )
    try:
        text = path.read_text(encoding="utf-8-sig")
        content = tomllib.loads(text)
    except RecursionError as error:
        raise MeasurementError(
            tr("{}: not valid TOML: brackets within brackets, too deep", path)
        ) from error
    except tomllib.TOMLDecodeError as error:
        raise MeasurementError(_invalid(path, text, error)) from error
    except UnicodeDecodeError as error:
        raise MeasurementError(
            tr("{}: not UTF-8 text (byte {})", path, error.start)
        ) from error
    except ValueError as error:  # a number of thousands of digits is one, too
        raise MeasurementError(tr("{}: not valid TOML: {}", path, error)) from error
    validate(content, path)  # here, so that the error names this file
    found = {
        name: (path.parent / file).resolve()
        for name, file in content.get("seed", {}).items()
        if name in ("lot", "shape")
    }
    if "lot" in found and not (found["lot"] / LOT_TABLE).is_file():
        raise MeasurementError(
            tr(
                "{}: [seed] lot: {} is no folder that benchtwin shape wrote",
                path,
                found["lot"],
            )
        )
    bench = path.parent.parent if path.name == RECORDING else path.parent
    if "shape" in found and not found["shape"].is_relative_to(bench.resolve()):
        raise MeasurementError(
            tr(
                "{}: [seed] shape = {!r}: lies outside the bench's folder {};"
                " copy the mesh into it",
                path,
                content["seed"]["shape"],
                bench,
            )
        )
    if "shape" in found and not found["shape"].is_file():
        raise MeasurementError(
            tr("{}: [seed] shape: there is no file {}", path, found["shape"])
        )
    require(len(found) != 2, tr("{}: [seed] lot and shape: give one of them", path))
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
                file.is_file(),
                tr("{}: [{}] plate_photo: there is no file {}", path, name, file),
            )
            found[name] = section | {"plate_photo": str(file)}
    return content | found


def _invalid(path: Path, text: str, error: tomllib.TOMLDecodeError) -> str:
    """Why a file is no TOML: the line, and what a line should be like."""
    place = re.search(r"\(at line (\d+)", str(error))
    line = text.splitlines()[int(place[1]) - 1 if place else -1].strip()
    said = tr("{}: not valid TOML: {}", path, error)
    if line.startswith("["):
        return tr(
            "{}: {}; each section stands once in a file", said, reprlib.repr(line)
        )
    if re.fullmatch(r"[\w-]+ *=\s*(#.*)?", line):
        key = line.partition("=")[0].strip()
        return tr("{}: {} has no value; a # before a line leaves it out", said, key)
    return tr(
        "{}: {}; a number has a point and no unit, a word stands in quotation marks",
        said,
        reprlib.repr(line),
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
        return [tr("at the top of the file, above the sections")]
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
                hint = tr("it belongs {}", tr(" or ").join(owners))
            elif near:
                hint = tr("did you mean {}?", near[0])
            else:
                hint = tr("known are {}", ", ".join(known))
            return tr("{}: unknown key {}; {}", path, place, hint)
    given = error.get("input")
    unit = next((u for end, u in _OTHER_UNITS.items() if key.endswith(end)), None)
    if (
        unit
        and isinstance(given, float | int)
        and not isinstance(given, bool)
        and abs(given) < LARGEST
    ):
        times, other, meant = unit
        return tr(
            "{}: {} = {} means {:g} {}: {}; is it in {}?",
            path,
            place,
            given,
            times * given,
            other,
            error["msg"].lower(),
            meant,
        )
    message = (
        error["msg"]
        .replace("tuple", "list")
        .replace("dictionary", "section")
        .split(" or instance of ")[0]
    )
    return f"{path}: {place} = {reprlib.repr(given)}: {message[0].lower()}{message[1:]}"
