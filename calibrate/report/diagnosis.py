"""The page of a diagnosis."""

from pathlib import Path


def write_report(found, out: Path) -> Path:
    """report.html in the folder `out`; appears whole. OSError when it cannot be written."""
    from calibrate.diagnose.words import lines

    file, part = out / "report.html", out / ".report.html.part"
    part.write_text("<br>".join(lines(found)), encoding="utf8")
    part.replace(file)
    return file
