"""The twin's heap of a recorded one: the same rig, of a wide box a slice between smooth sides, with what was named at a strength.

A shape of a heap has no number of the DEM: how strong its cause must be is found as friction is, from heaps at a few strengths.
"""

from dataclasses import dataclass

import numpy as np

from diagnose.effects.pile import EFFECTS
from diagnose.rigs.pile.flanks import photo_of
from twin.heap_outline import outlined
from twin.parameters import Parameters
from twin.paths import like
from twin.piles import SeenPile
from twin.run import run

SOYBEAN_MM, DENSITY = (8.72, 6.84, 5.98), 1250.0  # where a recording states neither
SLICE, MOST_SEEDS, PACKED = 3.5, 1200, 0.62  # thickness of a slice in seed lengths; seeds that take half a minute
FILL_MM, PX_MM = 60.0, 0.1
AT = np.arange(0.05, 1.3, 0.025)  # of the flank's way, where surfaces are compared


@dataclass(frozen=True)
class Knobs:
    """What a heap is run with: static friction between seeds; effect at a strength (Law.strengths), 0: as stated."""

    friction: float
    effect: str
    strength: float


@dataclass(frozen=True, eq=False)
class Shape:
    """surface (n,) at AT in shares of the height, NaN where not seen; angle_deg: mean over flanks and heaps."""

    surface: np.ndarray
    angle_deg: float


def setting(description: dict, knobs: Knobs, mean_mm: float):
    """(recording to be like, parameters) of a heap like this; mean_mm: mean length of all recordings' seeds. ValueError where the
    rig is not stated, or too many seeds would be needed."""
    stated = description.get("pile", {})
    seed = _seed(description.get("seed", {}))
    twin = EFFECTS[knobs.effect].law.twin
    assert twin is not None  # what has a counterpart has one
    seed, pile, laws = twin(seed | {"mean_mm": mean_mm}, _rig(stated, seed), stated, knobs.strength)
    del seed["mean_mm"]
    _affordable(pile, seed)
    wide = pile["plate_mm"][0]
    camera = {
        "mm_per_px": PX_MM, "width_px": int((wide + 40) / PX_MM), "height_px": int(1.2 * pile["fill_height_mm"] / PX_MM) + 200,
        "target_mm": [0.0 if "cylinder_mm" in pile else wide / 2, 0.0, 0.5 * pile["fill_height_mm"]],
    }  # fmt: skip
    made = like("pile", {"seed": seed, "pile": pile, "camera": camera, "air": description.get("air", {})})
    return made, Parameters(seed_static_friction=float(f"{knobs.friction:.4g}"), laws=laws)


def _seed(stated: dict) -> dict:
    whole = [stated.get(f"{n}_mm") for n in ("length", "width", "thickness")]
    if None in whole:
        scale = (whole[0] or SOYBEAN_MM[0]) / SOYBEAN_MM[0]
        whole = [scale * v for v in SOYBEAN_MM]
    return dict(zip(("length_mm", "width_mm", "thickness_mm"), whole)) | {"density_kg_m3": stated.get("density_kg_m3", DENSITY)}


def _rig(stated: dict, seed: dict) -> dict:
    """[pile] of the twin: a cylinder as it is, of a box a slice."""
    kept = {k: stated[k] for k in ("gate_speed_mm_s", "photo_s") if k in stated}
    fill = stated.get("fill_height_mm", FILL_MM)
    if "cylinder_mm" in stated:
        cylinder = stated["cylinder_mm"]
        wide = max(stated.get("plate_mm", [0.0])[0], 5 * cylinder[0])
        return kept | {"cylinder_mm": list(cylinder), "plate_mm": [wide, wide], "fill_height_mm": fill}
    if "box_mm" not in stated:
        raise ValueError("the recordings state neither [pile] box_mm nor cylinder_mm: there is no rig to run again")
    x, width, z = stated["box_mm"]
    slab = min(width, SLICE * seed["length_mm"])
    plate = stated.get("plate_mm", [2 * x])[0]
    box = {"box_mm": [x, slab, z], "gate_mm": [slab, z], "plate_mm": [plate, slab], "slab": True}
    return kept | box | {"fill_height_mm": min(fill, z)}


def _affordable(pile: dict, seed: dict) -> None:
    box = pile.get("box_mm")
    base = box[0] * box[1] if box else np.pi / 4 * pile["cylinder_mm"][0] ** 2
    volume_mm3 = np.pi / 6 * seed["length_mm"] * seed["width_mm"] * seed["thickness_mm"]
    count = PACKED * base * pile["fill_height_mm"] / volume_mm3
    if count > MOST_SEEDS:
        raise ValueError(f"a heap of about {count:.0f} seeds takes too long; up to {MOST_SEEDS} are run again")


def heap(description: dict, knobs: Knobs, seed_mm: float, packing: int) -> SeenPile:
    """One heap of the DEM, its outline seen as a photo shows it; the same packing, the same seeds rained in."""
    recording, parameters = setting(description, knobs, seed_mm)
    motion, _ = run(recording, parameters, rng=np.random.default_rng([5, packing]), threads=1)
    return outlined(motion, recording)


def shape_of(heaps: list[SeenPile]) -> Shape:
    """Mean over heaps and flanks. ValueError where no heap has a flank."""
    flanks = [f for seen in heaps for f in photo_of(seen).flanks]
    if not flanks:
        raise ValueError("no flank from crest to toe on the twin's heap")
    rows = np.array([np.interp(AT, f.u, f.v, left=np.nan, right=np.nan) for f in flanks])
    count = np.isfinite(rows).sum(0)
    mean = np.where(count > 0, np.nansum(rows, 0) / np.maximum(count, 1), np.nan)
    return Shape(mean, float(np.mean([f.angle_deg for f in flanks])))
