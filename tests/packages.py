"""Our packages: the folders at the top, and the names that they are imported by."""

from pathlib import Path

ROOT = Path(__file__).parent.parent
FOLDERS = (
    *("bench", "infer", "rigs", "vision", "measure", "sim", "twin", "calibrate"),
    *("diagnose", "report", "page", "prove", "benchtwin"),
)


def module_name(file: Path) -> str:
    """As it is imported: vision/pile/line.py is benchtwin.vision.pile.line."""
    parts = file.relative_to(ROOT).with_suffix("").parts
    inner = parts[1:] if parts[0] == "benchtwin" else parts
    return ".".join(("benchtwin", *inner)).removesuffix(".__init__")
