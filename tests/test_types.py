"""Public functions say what they take and give; mypy holds it (`make lint`). What numba
compiles has its types from the call."""

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
NOT_YET = ("diagnose/",)  # as in pyproject.toml
# laws and templates, bound to each other and compiled by sim/engine/kernels.py
COMPILED = {
    *(
        f"sim/engine/{name}.py"
        for name in (
            "bodies",
            "contacts",
            "gathering",
            "kernels",
            "neighbours",
            "quadrature",
            "step",
            "surfaces",
            "tiles",
            "turning",
        )
    ),
    *(str(file.relative_to(ROOT)) for file in (ROOT / "sim" / "laws").glob("*.py")),
}


def compiled(function: ast.FunctionDef) -> bool:
    return any(
        word in ast.unparse(d)
        for d in function.decorator_list
        for word in ("njit", "intrinsic")
    )


def public(node: ast.AST) -> Iterator[ast.FunctionDef]:
    """Functions and methods without an underscore, those within functions left out."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.ClassDef) and not child.name.startswith("_"):
            yield from public(child)
        elif (
            isinstance(child, ast.FunctionDef)
            and not child.name.startswith("_")
            and not compiled(child)
        ):
            yield child


def untyped(source: str) -> list[str]:
    """Names of public functions that leave an argument or their result without a
    type."""
    out = []
    for function in public(ast.parse(source)):
        a = function.args
        given = [
            *a.posonlyargs,
            *a.args,
            *a.kwonlyargs,
            *(x for x in (a.vararg, a.kwarg) if x),
        ]
        if function.returns is None or any(
            x.annotation is None for x in given if x.arg not in ("self", "cls")
        ):
            out.append(function.name)
    return out


@pytest.mark.parametrize(
    "package",
    ["vision", "measure", "sim", "twin", "calibrate", "diagnose", "report", "prove"],
)
def test_public_functions_are_typed(package):
    files = {
        str(file.relative_to(ROOT)): file
        for file in sorted((ROOT / package).rglob("*.py"))
    }
    found = {
        name: untyped(file.read_text(encoding="utf8"))
        for name, file in files.items()
        if name not in COMPILED and not name.startswith(NOT_YET)
    }
    assert {name: functions for name, functions in found.items() if functions} == {}


def test_the_check_sees_what_is_missing():
    assert untyped(
        "def a(x: int): ...\ndef b(x) -> int: ...\ndef _c(x): ...\ndef d(*, y: int = 1)"
        " -> None: ..."
    ) == ["a", "b"]
    assert untyped(
        "@njit(cache=True)\ndef a(x): ...\nclass B:\n    def b(self, x): ..."
    ) == ["b"]


def test_the_python_interface_is_typed_strictly():
    """As pyproject.toml says for benchtwin.*; what it imports is followed for its
    types, and not judged."""
    modules = [
        f"benchtwin.{file.stem}".removesuffix(".__init__")
        for file in (ROOT / "benchtwin").glob("*.py")
    ]
    checked = [
        sys.executable,
        "-m",
        "mypy",
        "--follow-imports=silent",
        f"--config-file={ROOT / 'pyproject.toml'}",
        f"--cache-dir={ROOT / '.mypy_cache' / 'interface'}",
        *(f"--module={m}" for m in modules),
    ]
    done = subprocess.run(checked, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
