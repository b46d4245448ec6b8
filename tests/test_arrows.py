"""Who may import whom: bench and prove nothing of ours; infer, vision and sim only
bench; measure vision; twin both measure and sim; rigs all these, and nobody them: they
are found by their records; a rig no other rig; report the results of calibrate and
diagnose; page what the commands call, in processes of their own."""

import ast
from pathlib import Path

import pytest
from packages import FOLDERS, ROOT, module_name

OURS = set(FOLDERS)
ALLOWED = {
    "bench": set(),
    "infer": {"bench"},
    "vision": {"bench"},
    "sim": {"bench"},
    "prove": set(),
    "measure": {"bench", "vision"},
    "twin": {"bench", "vision", "measure", "sim"},
    "rigs": {"bench", "infer", "vision", "sim", "twin", "diagnose"},
    "calibrate": {"bench", "twin"},
    "diagnose": {"bench", "infer", "twin"},
    "report": {"bench", "infer", "twin", "calibrate", "diagnose"},
    "page": {"bench", "vision", "measure", "twin", "calibrate", "diagnose", "report"},
}


def our_imports(file: Path) -> set[str]:
    """Folders of our own packages that `file` imports from."""
    names = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    inner = {name.split(".")[1] for name in names if name.startswith("benchtwin.")}
    return {name if name in OURS else "benchtwin" for name in inner}


def allowed(file: Path) -> set[str]:
    path = file.relative_to(ROOT)
    return {path.parts[0]} | ALLOWED[path.parts[0]]


@pytest.mark.parametrize("package", sorted(ALLOWED))
def test_imports_follow_the_arrows(package):
    files = sorted((ROOT / package).rglob("*.py"))
    assert files
    wrong = {
        str(f.relative_to(ROOT)): our_imports(f) - allowed(f)
        for f in files
        if our_imports(f) - allowed(f)
    }
    assert not wrong


def test_no_rig_knows_another():
    """Each says all of itself in its own folder."""
    wrong = {
        str(file.relative_to(ROOT))
        for rig in (ROOT / "rigs").iterdir()
        for file in rig.rglob("*.py")
        for other in (ROOT / "rigs").iterdir()
        if other.is_dir()
        and other != rig
        and f"benchtwin.rigs.{other.name}." in file.read_text(encoding="utf8")
    }
    assert wrong == set()


def test_the_check_sees_a_wrong_arrow(tmp_path):
    wrong = tmp_path / "wrong.py"
    wrong.write_text("import numpy\nfrom benchtwin.sim.engine import step\n")
    assert our_imports(wrong) == {"sim"}


def module_imports(names: set[str], file: Path) -> set[str]:
    """Our modules, out of `names`, that `file` imports, inside functions too."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            whole = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= whole & names or {node.module}
    return found & names


def circles(imports: dict[str, set[str]]) -> list[str]:
    """Modules that import themselves by way of others."""

    def reached(name: str) -> set[str]:
        seen: set[str] = set()
        ahead = list(imports[name])
        while ahead:
            if (other := ahead.pop()) not in seen:
                seen.add(other)
                ahead += imports[other]
        return seen

    return sorted(name for name in imports if name in reached(name))


def test_no_module_imports_itself_by_way_of_others():
    files = [file for package in OURS for file in (ROOT / package).rglob("*.py")]
    names = {module_name(f): f for f in files}
    assert (
        circles(
            {
                name: module_imports(set(names), file) - {name}
                for name, file in names.items()
            }
        )
        == []
    )
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}}) == [
        "a",
        "b",
        "c",
    ]  # the control


def test_an_incomplete_rig_says_what_is_missing():
    from dataclasses import replace

    from benchtwin.rigs.slide import RIG

    with pytest.raises(ImportError, match=r"no diagnose = .*nothing"):
        replace(RIG, diagnose=".diagnose:nothing")
    assert RIG.part("effects")
