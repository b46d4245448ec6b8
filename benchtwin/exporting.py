"""`benchtwin.export`: calibrated parameters as another DEM engine takes them."""

from dataclasses import dataclass, field
from html import escape
from pathlib import Path

from benchtwin.calibrate.export_command import cards_for, write_cards
from benchtwin.calibrating import CalibrationSummary, folder_of


@dataclass(frozen=True)
class Cards:
    """An engine's files. texts: by file name; folder: where they were written."""

    engine: str
    folder: Path
    texts: dict[str, str] = field(repr=False)

    def _repr_html_(self) -> str:
        files = "".join(
            f"<p>{escape(name)}</p><pre>{escape(text)}</pre>"
            for name, text in self.texts.items()
        )
        return f"<p><b>{escape(self.engine)}</b></p>{files}"


def export(
    result: str | Path | CalibrationSummary,
    engine: str,
    *,
    out: str | Path | None = None,
    overwrite: bool = False,
) -> Cards:
    """Write calibrated parameters as an engine takes them, in its own conventions.

    result: what `calibrate` found, or the folder that it wrote. engine: "lammps",
    "liggghts", "yade", "edem" or "mercury". out: where to, else RESULT/export/ENGINE;
    overwrite: replace cards that are there.

    Raises FileNotFoundError for a folder without result.json; FileExistsError where a
    card must not be replaced; ValueError for an unknown engine, or a result that lacks
    a number."""
    calibrated = folder_of(result)
    folder = calibrated / "export" / engine if out is None else Path(out)
    texts = cards_for(calibrated, engine, folder, overwrite)
    write_cards(texts, folder)
    return Cards(engine, folder, texts)
