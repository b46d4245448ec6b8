"""One seed of a recording in the simulation: its bench, and what the air does to it."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from benchtwin.bench.constants import G_M_S2
from benchtwin.bench.rigs import RIGS
from benchtwin.sim.laws import LAWS
from benchtwin.sim.rigs.bench import Bench
from benchtwin.sim.seed import Seed
from benchtwin.twin.parameters import Parameters, bench
from benchtwin.vision.evidence.read_keys import validate


def bench_of(
    rig: str, description: dict, laws: dict[str, dict], parameters: Parameters
) -> tuple[Bench, Seed]:
    """The bench of a recording's sections with `laws`, {name: numbers}, in the place of
    the air; its seed, of the mean size.

    A seed of which one size is stated is a ball; of none, the paper's soybean.
    """
    told = dict(description.get("seed", {}))
    sizes = [told[k] for k in ("length_mm", "width_mm", "thickness_mm") if k in told]
    if 0 < len(sizes) < 3:
        told |= {
            "length_mm": max(sizes),
            "width_mm": min(sizes),
            "thickness_mm": min(sizes),
        }
    known = validate(
        {
            "seed": {k: v for k, v in told.items() if k != "count"},
            "air": description.get("air", {}),
        },
        Path("bench.toml"),
    )
    chosen = tuple(LAWS[name].use(**numbers) for name, numbers in laws.items())
    if sizes and max(sizes) < 1.03 * min(sizes):
        parameters = replace(
            parameters, spheres=1
        )  # a row of balls is longer than that
    made = replace(bench(parameters, rig, known.seed, known.air), laws=chosen)
    return made, made.mean_seed()


def drag_factor(
    description: dict, share: float, speed_m_s: float = 2.0
) -> dict[str, float]:
    """Numbers of the law "drag" with which drag over weight at this speed is `share`
    (0: no drag) for this seed in this air."""
    # whichever rig: its seed is the same
    _, seed = bench_of(next(iter(RIGS)), description, {}, Parameters())
    air = description.get("air", {})
    numbers = {
        "air_density": air.get("density_kg_m3") or 1.2,
        "viscosity": air.get("viscosity_pa_s") or 1.81e-5,
    }
    diameter = (6 * seed.volume_m3 / np.pi) ** (1 / 3)
    still, blown = (0.0,) * 5, (1.0, 0.0, 0.0, 0.0)
    told = (speed_m_s, *still, diameter, *numbers.values(), *blown)
    force = LAWS["drag"].function(*told)[0]
    return numbers | {
        "factor": float(np.clip(share * seed.mass_kg * G_M_S2 / abs(force), 0.0, 20.0))
    }
