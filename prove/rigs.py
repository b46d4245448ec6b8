"""The rigs that cases are drawn of: every record `CASES` in `prove/cases/`, and in
`cases.py` of a rig's own folder."""

from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules

from benchtwin.prove.cases.record import Cases


def _records() -> Iterator[Cases]:
    ours = import_module("benchtwin.prove.cases")
    modules = [f"{ours.__name__}.{m.name}" for m in iter_modules(ours.__path__)]
    for place in import_module("benchtwin.rigs").__path__:
        for file in sorted(Path(place).glob("*/cases.py")):
            modules.append(f"benchtwin.rigs.{file.parent.name}.cases")
    for module in map(import_module, modules):
        if hasattr(module, "CASES"):
            yield module.CASES


RIGS = {c.rig: c for c in sorted(_records(), key=lambda c: -c.share)}
