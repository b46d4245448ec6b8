"""Brings bench/LANGUAGE.po up to what the code says: sentences that are new stand there
without a translation, those that nothing says any more are gone.

python scripts/catalogue.py zh
"""

import argparse
import ast
import re
from collections.abc import Iterable, Iterator, Mapping
from importlib import import_module
from pathlib import Path

from polib import POEntry, POFile, pofile

from benchtwin.bench.rigs import RIGS
from benchtwin.page.form import form

ROOT = Path(__file__).parent.parent
PACKAGES = sorted(p.name for p in (ROOT / "benchtwin").iterdir() if p.is_symlink())
# what is said by a name that is not its own: kinds, and headings of tables
SAID = {
    "page.runs": ("WAITING", "RUNNING", "DONE", "FAILED", "STOPPED", "BROKEN"),
    "page.upload": ("PHOTO", "VIDEO", "SOUND", "TABLE", "KEYS"),
    "page.views.bench": ("TABS",),
    "page.views.results": ("REPORTS", "COLUMNS"),
    "page.views.runs": ("ASKS",),
    "calibrate.procedure.calibration": ("CALIBRATED", "BOUNDED", "UNRESOLVED"),
    "calibrate.result_file": ("CONVENTIONS",),
    "report.numbers": ("HEADINGS",),
    "rigs.drop.unlisted": ("SPEED", "COUNT"),
    "vision.measurement": ("GOOD", "DOUBTFUL", "FAILED"),
    "vision.pile.heap": ("WALL", "STATED_WALL"),
    "vision.results": ("METHODS",),
    "vision.shape.grains": (
        *("AT_BORDER", "AT_SHEET", "TOO_SMALL", "TOO_LARGE", "HIDDEN"),
    ),
}
SHOWN = {  # the same of what stands in the middle of functions
    "page/results.py": (
        *("Not calibrated yet", "To narrow the parameters", "To record again"),
        "To tell explanations apart",
    ),
    "page/side_by_side.py": ("old", "new"),
    "page/views/bench.py": ("Bench",),
    "page/views/frame.py": ("photos", "frames", "video", "sound"),
    "page/views/recording.py": ("automatic", "corrected", "measured"),
    "page/views/results.py": ("Bench and twin", "What to record next", "Results"),
    "vision/pile/repose.py": ("left", "right"),
    "page/views/runs.py": ("Measure", "Calibrate", "Calibrate, quick", "Diagnose"),
}
LETTER = re.compile(r"(?<!-)\b[^\W\d_]")  # that is none of an option
IN_TEMPLATE = re.compile(r"""\btr\(\s*("([^"]*)"|'([^']*)')""")


def sentences() -> dict[str, list[str]]:
    """All that is said by `tr`, and the files that say it: what stands in the call, in
    a table that it is taken from, and in the records of effects and rigs."""
    found: dict[str, list[str]] = {}
    for package in PACKAGES:
        for file in sorted((ROOT / package).rglob("*")):
            if file.suffix == ".py":
                told = {*_of_module(file)}
            elif file.suffix in (".j2", ".js"):
                text = file.read_text(encoding="utf8")
                told = {m[2] or m[3] for m in IN_TEMPLATE.finditer(text)}
            else:
                continue
            for one in told:
                found.setdefault(one, []).append(str(file.relative_to(ROOT)))
    for module, names in SAID.items():
        loaded = import_module(f"benchtwin.{module}")
        for one in _texts(tuple(getattr(loaded, name) for name in names)):
            found.setdefault(one, []).append(f"{module.replace('.', '/')}.py")
    for place, told in SHOWN.items():
        for one in told:
            found.setdefault(one, []).append(place)
    for rig, one in _of_records():
        found.setdefault(one, []).append(f"rigs/{rig}")
    said = (one for one in sorted(found) if LETTER.search(one))
    return {one: found[one] for one in said}


def _of_module(file: Path) -> Iterator[str]:
    for call in ast.walk(ast.parse(file.read_text(encoding="utf8"))):
        if not (isinstance(call, ast.Call) and getattr(call.func, "id", "") == "tr"):
            continue
        said = [*_parts(call.args[0])]
        yield from (p.value for p in said if isinstance(p, ast.Constant))
        names = [p.id for p in said if isinstance(p, ast.Name) and p.id.isupper()]
        if names:
            place = ".".join(file.relative_to(ROOT).with_suffix("").parts)
            module = import_module(f"benchtwin.{place}".removesuffix(".__init__"))
            for name in names:
                yield from _texts(getattr(module, name))


def _parts(node: ast.expr) -> Iterator[ast.expr]:
    """Where the sentence of a call comes from: itself, either side of a choice, the
    table that it is looked up in."""
    match node:
        case ast.IfExp(body=one, orelse=other):
            yield from (*_parts(one), *_parts(other))
        case ast.BoolOp(values=several):
            for one in several:
                yield from _parts(one)
        case ast.Subscript(value=table):
            yield from _parts(table)
        case ast.Call(func=ast.Attribute(attr="get", value=table), args=[_, *absent]):
            yield table
            for one in absent:
                yield from _parts(one)
        case ast.Constant(value=str()) | ast.Name():
            yield node


def _texts(of: object) -> Iterator[str]:
    if isinstance(of, str):
        yield of
    elif isinstance(of, Mapping):
        yield from _texts(tuple(of.values()))
    elif isinstance(of, Iterable):
        for one in of:
            yield from _texts(one)


def _of_records() -> Iterator[tuple[str, str]]:
    for rig in RIGS.values():
        yield rig.name, rig.what
        for section in form(rig.name, {"no such key": 1}, {}):
            yield rig.name, section.title
            yield from ((rig.name, one.help) for one in (section, *section.fields))
        effects = rig.part("effects").values() if rig.effects else ()
        for effect in effects:
            told = [*effect.wording, effect.separating]
            told += [effect.counterpart.what] if effect.counterpart else []
            yield from ((rig.name, one) for one in told)


def main() -> None:
    """Update the catalogues of the named languages."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("languages", nargs="+")
    for language in parser.parse_args().languages:
        file = ROOT / "bench" / f"{language}.po"
        old = pofile(file.read_text(encoding="utf8")) if file.exists() else POFile()
        known = {entry.msgid: entry.msgstr for entry in old}
        new = POFile(wrapwidth=88)
        new.metadata = {
            "Language": language,
            "Content-Type": "text/plain; charset=utf-8",
        }
        for one, where in sentences().items():
            said = known.get(one, "")
            places = [(file, "") for file in where]
            new.append(POEntry(msgid=one, msgstr=said, occurrences=places))
        new.save(str(file))
        missing = len(new.untranslated_entries())
        print(f"{file.name}: {len(new)} sentences, {missing} not translated")


if __name__ == "__main__":
    main()
