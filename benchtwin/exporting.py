"""`benchtwin.export`: calibrated parameters as another DEM engine takes them."""

from dataclasses import dataclass, field
from pathlib import Path

from benchtwin.calibrate.export_command import cards_for, write_cards


@dataclass(frozen=True)
class Cards:
    """An engine's files. texts: by file name; folder: where they were written."""

    engine: str
    folder: Path
    texts: dict[str, str] = field(repr=False)


def export(
    result: str | Path,
    engine: str,
    *,
    out: str | Path | None = None,
    overwrite: bool = False,
) -> Cards:
    """Write calibrated parameters as an engine takes them, in its own conventions.

    result: the folder that a calibration wrote. engine: "lammps", "liggghts", "yade",
    "edem" or "mercury". out: where to, else RESULT/export/ENGINE; overwrite: replace
    cards that are there. Raises FileNotFoundError for a folder without result.json;
    FileExistsError where a card must not be replaced; ValueError for an unknown engine,
    or a result that lacks a number."""
    folder = Path(result) / "export" / engine if out is None else Path(out)
    texts = cards_for(Path(result), engine, folder, overwrite)
    write_cards(texts, folder)
    return Cards(engine, folder, texts)
