"""Calibrated parameters as cards of other engines, each in that engine's own
conventions.

A card is a pure function `Calibrated` → text. `ENGINES` names the files that each
engine gets."""

from pathlib import Path

from benchtwin.calibrate.export import edem, lammps, liggghts, mercury, yade
from benchtwin.calibrate.export.result import Calibrated, read_result

__all__ = ["ENGINES", "Calibrated", "cards", "read_result", "write_cards"]


def cards(calibrated: Calibrated, engine: str) -> dict[str, str]:
    """File names and texts for one engine; ValueError names the engines there are."""
    if engine not in ENGINES:
        raise ValueError(
            f"--to {engine}: no such engine; there are {', '.join(ENGINES)}"
        )
    return {name: card(calibrated) for name, card in ENGINES[engine].items()}


def write_cards(texts: dict[str, str], out: Path, *, overwrite: bool = False) -> None:
    """Write cards into the folder `out`; FileExistsError where it holds one of them
    that must not be replaced, OSError where it cannot be written."""
    there = [name for name in texts if (out / name).exists()]
    if there and not overwrite:
        raise FileExistsError(
            f"{out / there[0]} exists already: name another --out, or say --overwrite"
        )
    try:
        out.mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            (out / name).write_text(text, encoding="utf8")
    except OSError as error:
        why = error.strerror or error
        raise OSError(f"cannot write to {out}: {why}") from error


ENGINES = {
    "lammps": {"seed.contact.lammps": lammps.contact, "seed.molecule": lammps.molecule},
    "liggghts": {
        "seed.contact.liggghts": liggghts.contact,
        "seed.multisphere": liggghts.spheres,
    },
    "yade": {"seed_contact.py": yade.contact},
    "edem": {"seed.edem.txt": edem.card, "seed.spheres.tsv": edem.spheres},
    "mercury": {"SeedContact.h": mercury.contact},
}
