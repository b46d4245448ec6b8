"""What softening the seeds and a longer step change: rebound, run-out and angle of
repose against shear modulus and time step.

python benchmarks/modulus.py [PACKINGS]

About a minute of processor time a packing and modulus.
"""

import argparse

import numpy as np
from rig_jobs import pile, truths

from benchtwin.twin import Parameters
from benchtwin.twin.job import Job

REAL = 3.23e8
MODULI = (1e6, 3e6, 1e7, 3e7, REAL)
PILE_MODULI = (1e6, 3e6, 1e7)
FRACTIONS = (0.05, 0.2)


def single(rig: str, modulus: float, fraction: float, repeat: int) -> Job:
    rolling = {"rolling_friction": 0.02} if rig == "roll" else {}
    return Job(
        rig,
        Parameters(shear_modulus_pa=modulus, rayleigh_fraction=fraction, **rolling),
        {},
        (5, repeat),
        rendered=False,
    )


def row(jobs: list[Job], quantity: str) -> str:
    values = np.array([t.get(quantity, np.nan) for t in truths(jobs)])
    return (
        f"{np.nanmean(values):9.2f} ±"
        f" {np.nanstd(values, ddof=1) / np.sqrt(np.isfinite(values).sum()):5.2f}"
    )


def main(packings: int) -> None:
    print(
        f"{'modulus Pa':>12} {'step/Rayleigh':>14} {'rebound mm':>17}"
        f" {'run-out mm':>17}"
    )
    for modulus in MODULI:
        for fraction in FRACTIONS:
            cells = [
                row([single(rig, modulus, fraction, k) for k in range(10)], name)
                for rig, name in (("drop", "rebound_height_mm"), ("roll", "run_out_mm"))
            ]
            print(f"{modulus:12.3g} {fraction:14.2f} {cells[0]:>17} {cells[1]:>17}")
    print(
        f"\n{'modulus Pa':>12} {'step/Rayleigh':>14} {'angle of repose °':>19}"
        f" {'sd °':>6} {'processor s':>12}"
    )
    for modulus in PILE_MODULI:
        known = truths(
            [pile({"shear_modulus_pa": modulus}, k) for k in range(packings)]
        )
        angles = np.array([t.get("repose_angle_deg", np.nan) for t in known])
        cost = np.mean([t["processor_s"] for t in known])
        spread = np.nanstd(angles, ddof=1)
        error = spread / np.sqrt(np.isfinite(angles).sum())
        print(
            f"{modulus:12.3g} {0.2:14.2f} {np.nanmean(angles):10.2f} ± {error:5.2f}"
            f" {spread:6.2f} {cost:12.0f}",
            flush=True,
        )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("packings", type=int, nargs="?", default=6)
    main(parser.parse_args().packings)
