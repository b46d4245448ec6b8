"""Simulated collapses of plain and of changed seeds: is the change seen, and is it in
what the diagnosis names?

    python benchmarks/collapses.py [BENCHES]       default 30

Each bench: four heaps of plain seeds and four with a hidden change (none, cohesion,
more friction, longer seeds, rougher walls), of one drawn rig, each with its own
packing. One core, a minute a bench."""

import argparse
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pandas as pd
from pile_emulator import drawn

from benchtwin.bench.constants import G_M_S2
from benchtwin.bench.ellipsoid import ellipsoid_volume
from benchtwin.rigs.pile.diagnose import diagnose_pile
from benchtwin.rigs.pile.read import SeenPile
from benchtwin.rigs.pile.simulated_heaps import heap_of
from benchtwin.sim.engine.step import Stopped
from benchtwin.twin.job import Job

HEAPS, FIRST = 4, 1000  # of a bench; number of its first rig, none of the table's


def sticking(job: Job) -> Job:
    """Seeds pull each other with six tenths of a seed's weight."""
    seed = job.description["seed"]
    sizes = (seed[f"{axis}_mm"] for axis in ("length", "width", "thickness"))
    weight = 1e-9 * ellipsoid_volume(*sizes) * seed["density_kg_m3"] * G_M_S2
    film = {"pull": 0.6 * weight, "rupture": 1e-5 * seed["width_mm"]}
    laws = {"film_adhesion": film}
    return replace(job, parameters=replace(job.parameters, laws=laws))


def rubbing(job: Job) -> Job:
    """Friction between seeds is half as large again, rolling friction three times."""
    p = job.parameters
    more = replace(
        p,
        seed_static_friction=1.5 * p.seed_static_friction,
        seed_rolling_friction=3 * p.seed_rolling_friction,
    )
    return replace(job, parameters=more)


def longer(job: Job) -> Job:
    """Seeds are longer by two fifths at the same volume."""
    seed = dict(job.description["seed"])
    for axis, factor in (
        ("length", 1.4),
        ("width", 1.4**-0.5),
        ("thickness", 1.4**-0.5),
    ):
        seed[f"{axis}_mm"] *= factor
    return replace(job, description=job.description | {"seed": seed})


def walled(job: Job) -> Job:
    """Friction on floor and walls is twice as large."""
    p = job.parameters
    return replace(job, parameters=replace(p, static_friction=2 * p.static_friction))


CHANGES: dict[str, Callable[[Job], Job]] = {
    "none": lambda job: job,
    "cohesion": sticking,
    "seed-friction": rubbing,
    "particle-shape": longer,
    "wall-friction": walled,
}


def heap(job: Job, packing: int, plain: bool) -> SeenPile:
    """One heap as a photo shows it."""
    seen = heap_of(replace(job, rng=(*job.rng, packing)))
    told = seen.description["pile"] | {"plain": plain}
    description = seen.description | {"pile": told, "conditions": {}}
    return replace(seen, recording=f"heap-{packing}", description=description)


def found(number: int) -> dict:
    """One bench and what is said of it."""
    names = list(CHANGES)
    change, job = names[number % len(names)], drawn(FIRST + 2 * number)
    plain = [heap(job, k, True) for k in range(HEAPS)]
    changed = [heap(CHANGES[change](job), HEAPS + k, False) for k in range(HEAPS)]
    finding = diagnose_pile([*plain, *changed], np.random.default_rng(number))
    return {
        "hidden": change,
        "alarm": finding.alarm,
        "p": float(f"{finding.p_global:.1g}"),
        "verdict": finding.verdict,
        "names": ", ".join(finding.names),
        "in it": change in finding.names,
    }


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("benches", type=int, nargs="?", default=30)
    rows = []
    for number in range(parser.parse_args().benches):
        try:
            rows.append(found(number))
        except (ValueError, Stopped) as error:  # too flat for a flank, or too soft
            rows.append({"hidden": "refused", "names": str(error).split("\n")[0]})
        print(rows[-1], flush=True)
    table = pd.DataFrame(rows)
    print(table.groupby("hidden")[["alarm", "in it"]].agg(["sum", "count"]).to_string())
