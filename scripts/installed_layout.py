"""Links under build/installed that show the packages as they are installed
(`benchtwin/vision`, …), for tools that read files by their place: mypy, mkdocstrings.

    python scripts/installed_layout.py
"""

import argparse
from contextlib import suppress
from pathlib import Path

from setuptools import find_packages

ROOT = Path(__file__).parents[1]


def lay_out(place: Path = ROOT / "build" / "installed") -> Path:
    """Lay the links that are missing, remove those that lead nowhere; returns the
    folder to look in. Links that are right stay as they are, since others may read them
    meanwhile."""
    package = place / "benchtwin"
    package.mkdir(parents=True, exist_ok=True)
    beside = ("tests*", "benchmarks*", "samples*", "scripts*", "benchtwin*", "build*")
    names = [n for n in find_packages(ROOT, exclude=beside) if "." not in n]
    aims = {name: ROOT / name for name in names} | {
        file.name: file
        for file in (ROOT / "benchtwin").iterdir()
        if file.suffix == ".py" or file.name == "py.typed"
    }
    for old in package.iterdir():
        if old.readlink() != aims.get(old.name):
            old.unlink(missing_ok=True)
    for name, aim in aims.items():
        with suppress(FileExistsError):
            (package / name).symlink_to(aim)
    return place


def on_startup(**_: object) -> None:
    """mkdocs calls it first of all (hooks in mkdocs.yml)."""
    lay_out()


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    print(lay_out())
