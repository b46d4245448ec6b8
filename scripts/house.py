"""Prints how large the house is and how much of it is decided by numbers, as a table.

    python scripts/house.py

Lines count as `ruff format` lays them out at 88 columns.
"""

import argparse
import ast
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
BESIDE = {"tests", "benchmarks", "samples", "scripts", "docs", "build", "demo-out"}
DECIDING = ("vision", "diagnose", "infer", "rigs", "bench", "measure")
ORDER = (
    *["bench", "infer", "vision", "sim", "measure", "twin"],
    *["calibrate", "diagnose", "rigs", "report", "page"],
)
RIGS = ("drop", "slide", "roll", "pile", "drum")


def packages() -> list[str]:
    """The folders at the top that are installed."""
    return sorted(f.parent.name for f in ROOT.glob("*/__init__.py"))


def parsed(names: Iterable[str]) -> Iterator[tuple[Path, str, ast.Module]]:
    """File, text and syntax tree of every Python file of these packages."""
    for name in names:
        for file in sorted((ROOT / name).rglob("*.py")):
            text = file.read_text(encoding="utf8")
            yield file.relative_to(ROOT), text, ast.parse(text)


def numbers(node: ast.AST) -> bool:
    """Whether an expression is a number, or a tuple, list or dict that holds some."""
    if isinstance(node, ast.UnaryOp):
        return numbers(node.operand)
    if isinstance(node, ast.BinOp):
        return numbers(node.left) and numbers(node.right)
    if isinstance(node, ast.Tuple | ast.List):
        return any(numbers(e) for e in node.elts)
    if isinstance(node, ast.Dict):
        return any(numbers(e) for e in node.values)
    return isinstance(node, ast.Constant) and type(node.value) in (int, float)


def constants(tree: ast.Module) -> int:
    """Names of a module that stand for numbers."""
    count = 0
    for node in tree.body:
        if not isinstance(node, ast.Assign | ast.AnnAssign) or node.value is None:
            continue
        target = node.targets[0] if isinstance(node, ast.Assign) else node.target
        if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
            count += sum(numbers(e) for e in node.value.elts)
        else:
            count += numbers(node.value)
    return count


def compared_numbers(tree: ast.Module) -> int:
    """Numbers without a name, other than −1, 0, 1 and 2, that something is compared
    with."""
    found = 0
    for node in ast.walk(tree):
        if isinstance(node, ast.Compare):
            for side in (node.left, *node.comparators):
                for part in ast.walk(side):
                    if isinstance(part, ast.Constant) and type(part.value) in (
                        int,
                        float,
                    ):
                        found += part.value not in (0, 1, 2)
    return found


def functions(tree: ast.Module) -> Iterator[ast.FunctionDef]:
    """Functions and methods, those within functions left out."""
    for node in tree.body:
        inner = node.body if isinstance(node, ast.ClassDef) else [node]
        yield from (f for f in inner if isinstance(f, ast.FunctionDef))


def docstring_lines(tree: ast.Module) -> int:
    """Lines that docstrings take."""
    total = 0
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            first = node.body[0] if node.body else None
            if isinstance(first, ast.Expr) and ast.get_docstring(node) is not None:
                total += (first.end_lineno or first.lineno) - first.lineno + 1
    return total


def knows_a_rig(text: str) -> bool:
    """Whether a file names a rig as a word in quotes, or imports from one's folder."""
    return bool(
        re.search(rf"\"({'|'.join(RIGS)})\"|benchtwin\.rigs\.({'|'.join(RIGS)})", text)
    )


def climbing(names: Iterable[str]) -> int:
    """Imports of a package from one that stands above it, those inside functions
    counted."""
    found = 0
    for file, _, tree in parsed(names):
        here = ORDER.index(file.parts[0])
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and node.module:
                parts = node.module.split(".")
                if parts[0] == "benchtwin" and len(parts) > 1 and parts[1] in ORDER:
                    found += ORDER.index(parts[1]) > here
    return found


def rows() -> Iterator[tuple[str, str]]:
    """What is counted, and how much there is."""
    everything = packages()
    total = 0
    for name in everything:
        lines = sum(len(text.splitlines()) for _, text, _ in parsed([name]))
        total += lines
        yield f"lines of {name}", f"{lines:,}"
    yield "lines of all packages", f"{total:,}"
    deciding = list(parsed([n for n in DECIDING if n in everything]))
    yield (
        "numeric constants at module level where recordings are judged",
        str(sum(constants(tree) for _, _, tree in deciding)),
    )
    yield (
        "numbers without a name in their comparisons",
        str(sum(compared_numbers(tree) for _, _, tree in deciding)),
    )
    documented = sum(docstring_lines(tree) for _, _, tree in parsed(everything))
    yield "docstrings, share of lines", f"{100 * documented / total:.1f} %"
    for name in everything:
        found = [f.name for _, _, tree in parsed([name]) for f in functions(tree)]
        private = sum(n.startswith("_") and not n.startswith("__") for n in found)
        yield f"private functions of {name}", f"{100 * private / len(found):.0f} %"
    knowing = [
        str(file)
        for file, text, _ in parsed(everything)
        if file.parts[0] not in ("rigs", "prove") and knows_a_rig(text)
    ]
    yield "files that name a rig outside its folder", str(len(knowing))
    yield (
        "imports that climb",
        str(climbing([n for n in ORDER if n in everything])),
    )


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    for what, value in rows():
        print(f"{what:64}{value:>10}")
