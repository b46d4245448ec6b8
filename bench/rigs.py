"""All rigs there are: every folder of `rigs/` whose package holds a record `RIG`."""

from collections.abc import Iterator, Mapping
from importlib import import_module
from pkgutil import iter_modules

from benchtwin.bench.rig import PACKAGE, Rig


def _records() -> Iterator[Rig]:
    for module in iter_modules(import_module(PACKAGE).__path__):
        if module.ispkg:
            package = import_module(f"{PACKAGE}.{module.name}")
            if not hasattr(package, "RIG"):
                raise ImportError(f"rigs/{module.name}/__init__.py holds no RIG")
            yield package.RIG


RIGS: dict[str, Rig] = {
    rig.name: rig for rig in sorted(_records(), key=lambda rig: (rig.order, rig.name))
}
READING_COLUMNS = {  # column → (rig, quantity, unit)
    column: (rig.name, *quantity)
    for rig in RIGS.values()
    for column, quantity in rig.readings.items()
}
VARIANTS = {name: rig for rig in RIGS.values() for name in rig.variants}


def variant_of(rig: str, description: Mapping[str, Mapping]) -> str:
    """The name under which `simulate` knows a rig with the keys that are described."""
    for name, keys in RIGS[rig].variants.items():
        if all(set(keys[s]) <= set(description.get(s, {})) for s in keys):
            return name
    return rig


def rigs_in_words(last: str = " or ") -> str:
    """ "drop, slide, roll, pile or drum"."""
    *others, one = RIGS
    return last.join(filter(None, (", ".join(others), one)))
