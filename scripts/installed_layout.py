"""Links under build/installed that show the packages as they are installed
(`benchtwin/vision`, …), for tools that read files by their place: mypy, mkdocstrings.

    python scripts/installed_layout.py
"""

import argparse
from pathlib import Path

from setuptools import find_packages

ROOT = Path(__file__).parents[1]


def lay_out(place: Path = ROOT / "build" / "installed") -> Path:
    """Lay the links anew; returns the folder to look in."""
    package = place / "benchtwin"
    package.mkdir(parents=True, exist_ok=True)
    for old in package.iterdir():
        old.unlink()
    for file in (ROOT / "benchtwin").iterdir():
        if file.suffix == ".py" or file.name == "py.typed":
            (package / file.name).symlink_to(file)
    beside = ("tests*", "benchmarks*", "samples*", "scripts*", "benchtwin*", "build*")
    for name in find_packages(ROOT, exclude=beside):
        if "." not in name:
            (package / name).symlink_to(ROOT / name)
    return place


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    print(lay_out())
