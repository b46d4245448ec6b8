"""Simulated heaps of a recorded rig, with an effect; of a wide box a slice."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchtwin.bench.ellipsoid import ellipsoid_volume
from benchtwin.bench.language import tr
from benchtwin.rigs.pile.effects import EFFECTS
from benchtwin.rigs.pile.flanks import photo_of
from benchtwin.rigs.pile.heap_outline import collapsed, outlined
from benchtwin.rigs.pile.read import SeenPile
from benchtwin.twin.job import Job
from benchtwin.twin.parameters import Parameters
from benchtwin.twin.run import run

SOYBEAN_MM, DENSITY = (8.72, 6.84, 5.98), 1250.0  # where a recording states neither
# slice in seed lengths; number of seeds simulated in half a minute; packing
SLICE = 3.5
MOST_SEEDS = 3000
PACKED = 0.62
FILL_MM, PX_MM = 60.0, 0.1
FPS = 40.0  # of their films
GATE = "gate_speed_mm_s"
AT = np.arange(0.05, 1.3, 0.025)  # of the flank's way, where surfaces are compared
# what a heap hangs on and nobody states, and between what it lies: Parameters, and a
# gate's speed, which may be stated
UNKNOWNS = {
    "seed_static_friction": (0.1, 0.9),
    "seed_rolling_friction": (0.005, 0.12),
    "static_friction": (0.1, 0.6),
    GATE: (30.0, 2000.0),
}


@dataclass(frozen=True)
class HeapSettings:
    """Values of UNKNOWNS, and an effect at a strength of `Law.twin`, 0: as stated."""

    unknown: dict[str, float]
    effect: str
    strength: float


@dataclass(frozen=True, eq=False)
class Shape:
    """surface (n,) at AT in shares of the height, NaN unseen; angle_deg: mean of
    flanks."""

    surface: np.ndarray
    angle_deg: float


def heap_job(
    description: dict,
    settings: HeapSettings,
    seed_mm: float,
    packing: int,
    *,
    rendered: bool = False,
) -> Job:
    """A heap of a recorded rig; ValueError where it cannot be run. Equal `packing`,
    equal seeds; seed_mm: mean length of all recordings' seeds."""
    stated = description.get("pile", {})
    told = description.get("seed", {})
    sizes = [told.get(f"{n}_mm") for n in ("length", "width", "thickness")]
    if None in sizes:
        sizes = [(sizes[0] or SOYBEAN_MM[0]) / SOYBEAN_MM[0] * v for v in SOYBEAN_MM]
    seed = dict(zip(("length_mm", "width_mm", "thickness_mm"), sizes))
    seed["density_kg_m3"] = told.get("density_kg_m3", DENSITY)
    twin = EFFECTS[settings.effect].law.twin
    assert twin is not None  # effects with a counterpart have one
    unknown = {name: float(f"{v:.4g}") for name, v in settings.unknown.items()}
    speed = {GATE: unknown.pop(GATE)}
    seed, pile, laws = twin(
        seed | {"mean_mm": seed_mm},
        speed | _rig(stated, seed),
        stated,
        settings.strength,
    )
    del seed["mean_mm"]
    box = pile.get("box_mm")
    base = box[0] * box[1] if box else np.pi / 4 * pile["cylinder_mm"][0] ** 2
    count = PACKED * base * pile["fill_height_mm"] / _volume_mm3(seed)
    if count > MOST_SEEDS:
        said = tr("a heap of about {:.0f} seeds takes too long", count)
        raise ValueError(tr("{}; up to {} are run again", said, MOST_SEEDS))
    wide = pile["plate_mm"][0]
    camera = {
        "fps": FPS,
        "mm_per_px": PX_MM,
        "width_px": int((wide + 40) / PX_MM),
        "height_px": int(1.2 * pile["fill_height_mm"] / PX_MM) + 200,
        "target_mm": [
            0.0 if "cylinder_mm" in pile else wide / 2,
            0.0,
            0.5 * pile["fill_height_mm"],
        ],
    }
    told = {
        "seed": seed,
        "pile": pile,
        "camera": camera,
        "air": description.get("air", {}),
    }
    parameters = Parameters(laws=laws, **unknown)
    return Job("pile", parameters, told, (5, packing), rendered=rendered)


def assumed(description: dict) -> list[str]:
    """What a simulated heap takes in the place of what a recording does not state."""
    seed, pile = description.get("seed", {}), description.get("pile", {})
    sizes = " × ".join(f"{size:g}" for size in SOYBEAN_MM)
    taken = {
        f"[pile] fill_height_mm {FILL_MM:g}": "fill_height_mm" in pile,
        f"[seed] length_mm, a soybean's ({sizes})": "length_mm" in seed,
        f"[seed] density_kg_m3 {DENSITY:g}": "density_kg_m3" in seed,
    }
    return [what for what, stated in taken.items() if not stated]


def _rig(stated: dict, seed: dict) -> dict:
    """[pile] of the simulation: a cylinder and a channel as they are, a slice of a box
    and of a channel of too many seeds."""
    kept = {k: stated[k] for k in (GATE, "photo_s") if k in stated}
    fill = stated.get("fill_height_mm", FILL_MM)
    if "cylinder_mm" in stated:
        cylinder = stated["cylinder_mm"]
        wide = max(stated.get("plate_mm", [0.0])[0], 5 * cylinder[0])
        return kept | {
            "cylinder_mm": list(cylinder),
            "plate_mm": [wide, wide],
            "fill_height_mm": fill,
        }
    if "box_mm" not in stated:
        raise ValueError(
            tr(
                "the recordings state neither [pile] box_mm nor cylinder_mm: there is"
                " no rig to run again"
            )
        )
    x, width, z = stated["box_mm"]
    whole = PACKED * x * width * min(fill, z)
    if "channel_mm" in stated and whole <= MOST_SEEDS * _volume_mm3(seed):
        box = {n: stated[n] for n in ("box_mm", "gate_mm", "channel_mm") if n in stated}
        floor = {"plate_mm": stated["channel_mm"], "gate_mm": [width, z]}
        return kept | floor | box | {"fill_height_mm": min(fill, z)}
    slab = min(width, SLICE * seed["length_mm"])
    plate = stated.get("channel_mm", stated.get("plate_mm", [2 * x]))[0]
    box = {
        "box_mm": [x, slab, z],
        "gate_mm": [slab, z],
        "plate_mm": [plate, slab],
        "slab": True,
    }
    return kept | box | {"fill_height_mm": min(fill, z)}


def _volume_mm3(seed: dict) -> float:
    axes_mm = (seed[f"{axis}_mm"] for axis in ("length", "width", "thickness"))
    return ellipsoid_volume(*axes_mm)


def heap_of(job: Job) -> SeenPile:
    """The simulated heap with its outline as in a photo and, out of a box, how it came
    about as in a film."""
    recording = job.recording(Path("heap"))
    pile = recording.pile
    box = pile.box_mm if pile.cylinder_mm is None else None
    if box:
        recording = replace(recording, evidence="video")
    rng = np.random.default_rng(list(job.rng))
    motion, _ = run(recording, job.parameters, rng=rng, threads=1)
    seen = outlined(motion, recording)
    if not box:
        return seen
    sizes_m = 1e-3 * box[0], 1e-3 * (pile.fill_height_mm or FILL_MM)
    return replace(seen, collapse=collapsed(motion, *sizes_m), clocked=True)


def shape_of(heaps: list[SeenPile]) -> Shape:
    """Mean over heaps and flanks. ValueError where no heap has a flank."""
    flanks = [f for seen in heaps for f in photo_of(seen).flanks]
    if not flanks:
        raise ValueError(tr("no flank from crest to toe on the twin's heap"))
    rows = np.array(
        [np.interp(AT, f.u, f.v, left=np.nan, right=np.nan) for f in flanks]
    )
    count = np.isfinite(rows).sum(0)
    mean = np.where(count > 0, np.nansum(rows, 0) / np.maximum(count, 1), np.nan)
    return Shape(mean, float(np.mean([f.angle_deg for f in flanks])))
