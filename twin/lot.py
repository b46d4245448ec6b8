"""A lot measured from photos (`benchtwin shape`) as the seeds that the simulation draws
from."""

import hashlib
from functools import lru_cache
from pathlib import Path

import numpy as np

from benchtwin.sim.seed import SOYBEAN_DENSITY, Seed
from benchtwin.sim.seed.lot import Lot
from benchtwin.sim.seed.mesh_file import read_mesh
from benchtwin.sim.seed.shape import Shape
from benchtwin.sim.seed.sizes import RANGE_OVER_SD_OF_100, SOYBEAN
from benchtwin.vision.evidence.read_keys import LOT_TABLE
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.shape.lot import MeasuredSeed, read_lot

# different clumps in a heap; each takes a fit, and is meshed once for the picture
MOST_SHAPES = 40
OUTLINE_POINTS = 96
# drawn at random, of which the one whose moments are nearest to the lot's is kept
SUBSETS = 1000
FILES = (LOT_TABLE, "outlines.csv")


def lot_digest(folder: Path) -> str:
    """SHA-256 of what a lot's seeds are made from, wherever the folder lies."""
    digest = hashlib.sha256()
    for name in FILES:
        digest.update((Path(folder) / name).read_bytes())
    return digest.hexdigest()


def file_digest(file: Path) -> str:
    """SHA-256 of a file's content, wherever it lies."""
    return hashlib.sha256(Path(file).read_bytes()).hexdigest()


@lru_cache(maxsize=8)
def seed_of_mesh(
    file: str,
    digest: str,
    unit: str | None,
    *,
    mass_g: float | None,
    density_kg_m3: float | None,
    spheres: int,
) -> Lot:
    """One seed of the true shape in a mesh file, as a clump of `spheres` balls; digest:
    of its content, for the cache.

    mass_g of the seed, or density_kg_m3; neither: soybean's density. MeasurementError
    for a mesh that cannot be used."""
    try:
        shape = read_mesh(Path(file), unit)
    except ValueError as error:
        raise MeasurementError(
            str(error).replace("--unit", "[seed] shape_unit")
        ) from error
    return Lot(
        (Seed.from_shape(shape, spheres, _density([shape], mass_g, density_kg_m3)),)
    )


def _density(
    shapes: list[Shape], mass_g: float | None, density_kg_m3: float | None
) -> float:
    """As stated, or from the seeds' mean mass over their mean volume; else soybean's
    [kg/m³]."""
    if density_kg_m3 is not None:
        return density_kg_m3
    if mass_g is None:
        return SOYBEAN_DENSITY
    return 1e-3 * mass_g / float(np.mean([shape.volume_m3 for shape in shapes]))


def measured_lot(
    folder: str,
    *,
    only: str | None,
    thickness_mm: float | None,
    thickness_sd_mm: float,
    mass_g: float | None,
    density_kg_m3: float | None,
    spheres: int,
) -> Lot:
    """The lot in `folder` as clumps of `spheres` balls with the mass and inertia of the
    measured shapes.

    only: "photo:seed" of the one seed that was recorded. thickness_mm, thickness_sd_mm:
    of the lot, for seeds whose thickness the photos do not show. mass_g of one seed on
    average, or density_kg_m3; neither: soybean's density. Raises MeasurementError for a
    seed or a thickness that is not there."""
    options = (only, thickness_mm, thickness_sd_mm, mass_g, density_kg_m3, spheres)
    return _made(str(folder), lot_digest(Path(folder)), *options)


@lru_cache(maxsize=8)
def _made(
    folder, digest, only, thickness_mm, thickness_sd_mm, mass_g, density_kg_m3, spheres
) -> Lot:
    seeds = read_lot(Path(folder)).seeds
    thick = _thicknesses(folder, seeds, thickness_mm, thickness_sd_mm)
    if only is not None:
        kept = [
            k for k, seed in enumerate(seeds) if f"{seed.photo}:{seed.seed}" == only
        ]
        if not kept:
            first = f"{seeds[0].photo}:{seeds[0].seed}" if seeds else "none"
            raise MeasurementError(
                f"{folder}: [seed] lot_seed = {only!r}: no such seed; there is {first},"
                " for example"
            )
    else:
        sizes = np.column_stack(
            [[s.length_mm for s in seeds], [s.width_mm for s in seeds], thick]
        )
        kept = representative(sizes, MOST_SHAPES)
    shapes = [
        Shape.from_outline(1e-3 * seeds[k].outline_mm(OUTLINE_POINTS), 1e-3 * thick[k])
        for k in kept
    ]
    density = _density(shapes, mass_g, density_kg_m3)
    return Lot(
        tuple(
            Seed.from_shape(shape, spheres, density_kg_m3=density) for shape in shapes
        )
    )


def _thicknesses(
    folder: str, seeds: tuple[MeasuredSeed, ...], mean_mm: float | None, sd_mm: float
) -> np.ndarray:
    """Each seed's thickness [mm]: as seen, else drawn with the lot's mean and scatter,
    correlated with its width as assumed for soybeans (thick seeds are wide); the same
    seeds always get the same."""
    seen = np.array([seed.thickness_mm for seed in seeds])
    unseen = np.isnan(seen)
    if not unseen.any():
        return seen
    if mean_mm is None and unseen.all():
        why = "photograph the seeds from the side too, or state [seed] thickness_mm"
        raise MeasurementError(f"{folder}: no seed's thickness is known; {why}")
    if mean_mm is None:
        mean_mm, sd_mm = float(np.nanmean(seen)), float(np.nanstd(seen))
    width = np.array([seed.width_mm for seed in seeds])
    wide = (width - width.mean()) / max(float(width.std()), 1e-12)
    own = np.random.default_rng(0).standard_normal(len(seeds))
    share = SOYBEAN.correlation
    score = np.clip(share * wide + np.sqrt(1.0 - share**2) * own, -2.5, 2.5)
    drawn = np.maximum(mean_mm + sd_mm * score, 0.2 * mean_mm)
    return np.where(unseen, drawn, seen)


def representative(sizes: np.ndarray, most: int) -> list[int]:
    """Rows of `sizes` (n, 3), `most` of them at most, whose means and covariances of
    the logarithms are nearest to all rows'."""
    if len(sizes) <= most:
        return list(range(len(sizes)))
    score = np.log(sizes)
    score = (score - score.mean(axis=0)) / np.maximum(score.std(axis=0), 1e-9)
    whole = score.T @ score / len(score)
    rng = np.random.default_rng(0)

    def off(rows: np.ndarray) -> float:
        part = score[rows]
        centred = part - part.mean(axis=0)
        covariance = centred.T @ centred / len(part)
        return float((part.mean(axis=0) ** 2).sum() + ((covariance - whole) ** 2).sum())

    subsets = [rng.choice(len(sizes), most, replace=False) for _ in range(SUBSETS)]
    return sorted(int(k) for k in min(subsets, key=off))


def other_seeds(section: dict) -> dict[str, dict]:
    """[seed] sections that say less than the lot in `section`: its typical seed alone,
    and ellipsoids of its sizes."""
    lot = read_lot(Path(section["lot"]))
    mean, sd = section.get("thickness_mm"), 0.0
    if "thickness_range_mm" in section:
        low, high = section["thickness_range_mm"]
        sd = (high - low) / RANGE_OVER_SD_OF_100
    sizes = {
        "length": np.array([s.length_mm for s in lot.seeds]),
        "width": np.array([s.width_mm for s in lot.seeds]),
        "thickness": _thicknesses(section["lot"], lot.seeds, mean, sd),
    }
    every = np.column_stack(list(sizes.values()))
    off = (np.log(every / every.mean(axis=0)) ** 2).sum(axis=1)
    typical = lot.seeds[int(off.argmin())]
    plain = {
        key: value for key, value in section.items() if key not in ("lot", "lot_seed")
    }
    for name, values in sizes.items():
        if len(values) > 1:
            half = 0.5 * RANGE_OVER_SD_OF_100 * float(values.std(ddof=1))
        else:
            half = 0.0
        plain[f"{name}_mm"] = float(values.mean())
        if half > 0:
            plain[f"{name}_range_mm"] = [
                float(values.mean()) - half,
                float(values.mean()) + half,
            ]
    return {
        "typical seed": section | {"lot_seed": f"{typical.photo}:{typical.seed}"},
        "ellipsoids": plain,
    }
