"""Calibrated parameters as cards of other engines, each in that engine's own
conventions.

A card is a pure function `Calibrated` → text. `ENGINES` names the files that each
engine gets."""

from benchtwin.calibrate.export import edem, lammps, liggghts, mercury, yade
from benchtwin.calibrate.export.result import Calibrated, read_result

__all__ = ["ENGINES", "Calibrated", "cards", "read_result"]


def cards(calibrated: Calibrated, engine: str) -> dict[str, str]:
    """File names and texts for one engine; ValueError names the engines there are."""
    if engine not in ENGINES:
        raise ValueError(
            f"--to {engine}: no such engine; there are {', '.join(ENGINES)}"
        )
    return {name: card(calibrated) for name, card in ENGINES[engine].items()}


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
