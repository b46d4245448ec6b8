"""What the rest of the house knows of a rig: one record, in the rig's own folder.

    RIG = Rig(name="slide", measure="…slide.measure:measure_slide", …)

Its parts are named as "module:function" and loaded when they are called, since the
compiler that the models need loads for seconds; that each is there is checked at once.
"""

from dataclasses import dataclass, fields
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Rig:
    """A rig's parts.

    measure(track, recording) → its quantities. read(folder) → its recordings as plain
    arrays, for diagnose(recordings, rng) → Finding. effects: what may be missing, by
    name. resimulate: the twin run again with what was named."""

    name: str
    measure: str
    read: str
    diagnose: str
    effects: str
    resimulate: str

    def __post_init__(self) -> None:
        missing = [
            f"{part.name} = {getattr(self, part.name)!r}"
            for part in fields(self)
            if part.name != "name" and not _is_there(getattr(self, part.name))
        ]
        if missing:
            said = f"there is no {', no '.join(missing)}"
            raise ImportError(f"the rig {self.name!r} is incomplete: {said}")

    def part(self, name: str) -> Any:
        """One of its parts, loaded."""
        module, function = getattr(self, name).split(":")
        return getattr(import_module(module), function)


def _is_there(place: str) -> bool:
    """Whether "module:function" names something that the module's text defines."""
    module, _, function = place.partition(":")
    try:
        found = find_spec(module)
    except ModuleNotFoundError:
        return False
    if found is None or not found.origin or not function:
        return False
    text = Path(found.origin).read_text(encoding="utf8")
    return any(
        line.startswith((f"def {function}(", f"{function}:", f"{function} ="))
        for line in text.splitlines()
    )


def rig_of(name: str) -> Rig | None:
    """The record of a rig, None where its folder has none."""
    if not name or find_spec(f"{__package__}.{name}") is None:
        return None
    return getattr(import_module(f"{__package__}.{name}"), "RIG", None)
