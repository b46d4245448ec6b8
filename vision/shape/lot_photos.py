"""Photos of a spread lot → kind, sizes and outline of every seed."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
import pandas as pd
from scipy.ndimage import find_objects

from benchtwin.bench.language import tr
from benchtwin.bench.section import PLAUSIBLE_MM, SIZE_LIMITS_MM
from benchtwin.vision.board.view import BoardView, read_board
from benchtwin.vision.evidence.photo import read_photo
from benchtwin.vision.measurement import FAILED, MeasurementError, require
from benchtwin.vision.overlay.seeds import draw_grains
from benchtwin.vision.shape.grains import (
    AT_BORDER,
    TOO_SMALL,
    Grains,
    doubted,
    measure_seeds,
)
from benchtwin.vision.shape.lot import (
    BROKEN,
    CUT,
    HUSK,
    OTHER,
    OUTLINE_COLUMNS,
    SEED_COLUMNS,
    TOUCHING,
    WHOLE,
)
from benchtwin.vision.shape.outline import aligned_outline, fourier_terms, solidity

BROKEN_SHARE = 0.6  # of the median area: smaller things are parts of seeds
DENTED = 0.94  # solidity below which a seed has lost a piece
HUSK_SHARE = 0.55  # of the median contrast to the background: husks are translucent
# share of the edge that a neighbour covers, above which the seed's own shape is not
# seen
HIDDEN = 0.03
SAME_PLACE = 0.75  # of a length: within it, a seed turned on its side is the same seed
SAME_SHARE = 0.8  # of the seeds that must be in the same place
NEAREST_M, FARTHEST_M = 0.25, 1.5  # distance of the camera where it is not stated
DISTANCE_SD = 0.05  # relative, of a stated distance
# thickness over width of seeds on their broad side; its relative sd
THICKNESS_SHARE = 0.8
THICKNESS_SD = 0.25


@dataclass(frozen=True)
class View:
    """How the photos were taken. mm_per_px: None where a printed board tells it;
    distance_mm: of the lens from the paper, None: unknown, math.inf: a scanner."""

    mm_per_px: float | None
    mm_per_px_sd: float | None
    distance_mm: float | None


@dataclass(frozen=True, eq=False)
class LotPhotos:
    """seeds, outlines: rows of seeds.csv and outlines.csv; pictures, mm_per_px: by
    photo; scale: its source; common: shared relative sd of each size."""

    seeds: pd.DataFrame
    outlines: pd.DataFrame
    pictures: dict[str, np.ndarray]
    mm_per_px: dict[str, float]
    scale: str
    common: float
    notes: tuple[str, ...]


def measure_lot_photos(
    photos: list[Path], view: View, report: Callable[[str], None]
) -> LotPhotos:
    """Measure the seeds of all photos; say(name) is called for each. MeasurementError
    for a photo without seeds or scale."""
    tables: list[pd.DataFrame] = []
    lines: list[tuple] = []
    pictures: dict[str, np.ndarray] = {}
    sizes: dict[str, float] = {}
    scales: list[str] = []
    common: list[float] = []
    notes: list[str] = []
    for photo in photos:
        report(photo.name)
        grains, picture = observe_seeds(photo, view.mm_per_px, view.mm_per_px_sd)
        if grains.scale is None:
            hint = tr(
                "lay a printed board beside the seeds (benchtwin board), or state"
                " --mm-per-px"
            )
            raise MeasurementError(tr("{}: its scale is unknown: {}", photo, hint))
        if isinstance(grains.scale, BoardView) and grains.scale.doubts:
            raise MeasurementError(
                tr(
                    "{}: the scale of its board is in doubt ({}); state --mm-per-px",
                    photo,
                    "; ".join(grains.scale.doubts),
                )
            )
        table, outlines = _seeds(photo.name, read_photo(photo), grains, view)
        tables.append(table)
        lines += outlines
        pictures[photo.name] = picture
        scales.append(
            tr("a printed board in the picture")
            if isinstance(grains.scale, BoardView)
            else tr("stated: {:g} mm per px", grains.scale)
        )
        common.append(grains.common_sd())
        seen = grains.seen
        sizes[photo.name] = float(np.nanmedian(seen.length_mm / seen.length_px))
        notes += [
            f"{photo.name}: {note}" for note in grains.notes if "thickness" not in note
        ]
    seeds = pd.concat(tables, ignore_index=True)
    higher = _magnification_sd(seeds, view)
    shared = float(np.hypot(np.mean(common), higher))
    if view.distance_mm is None:
        hint = tr("sizes may be up to {:.1f} % too large", 100 * 2 * higher)
        notes.append(
            tr(
                "the camera's distance is not stated: seeds are above the paper, so"
                " that {}; state --distance-mm",
                hint,
            )
        )
    terms = pd.DataFrame(lines, columns=list(OUTLINE_COLUMNS))
    scale = "; ".join(dict.fromkeys(scales))
    return LotPhotos(seeds, terms, pictures, sizes, scale, shared, tuple(notes))


def with_thickness(
    spread: LotPhotos, side: LotPhotos
) -> tuple[LotPhotos, tuple[float, float, int] | None]:
    """Add the thickness, the width of seeds turned on their side; of seeds in other
    places its mean, sd and number are returned."""
    seeds, whole = spread.seeds.copy(), side.seeds[side.seeds["kind"] == WHOLE]
    require(
        len(whole) >= 2,
        tr("the photos of the seeds on their side show fewer than two whole seeds"),
    )
    found = _same_places(seeds[seeds["kind"] == WHOLE], whole, spread.mm_per_px)
    if found:
        for index, other in found.items():
            thin = min(side.seeds.loc[other, "width_mm"], seeds.loc[index, "width_mm"])
            seeds.loc[index, ["thickness_mm", "thickness_sd_mm"]] = (
                thin,
                side.seeds.loc[other, "width_sd_mm"],
            )
        return replace(spread, seeds=seeds), None
    values = whole["width_mm"].to_numpy(float)
    return spread, (float(values.mean()), float(values.std(ddof=1)), len(values))


def _same_places(
    here: pd.DataFrame, turned: pd.DataFrame, mm_per_px: dict[str, float]
) -> dict[int, int]:
    """Rows of seeds → rows of the same seeds on their side, photo by photo; empty where
    too few are in the same places."""
    photos, others = list(here["photo"].unique()), list(turned["photo"].unique())
    if len(photos) != len(others):
        return {}
    found: dict[int, int] = {}
    for index, row in here.iterrows():
        beside = turned[turned["photo"] == others[photos.index(row["photo"])]]
        away = mm_per_px[row["photo"]] * np.hypot(
            beside["x_px"] - row["x_px"], beside["y_px"] - row["y_px"]
        )
        if len(away) and away.min() < SAME_PLACE * row["length_mm"]:
            found[int(index)] = int(away.idxmin())
    alike = len(found) >= SAME_SHARE * len(here) and len(set(found.values())) == len(
        found
    )
    return found if alike else {}


def _seeds(
    photo: str, image: np.ndarray, grains: Grains, view: View
) -> tuple[pd.DataFrame, list[tuple]]:
    """Rows of seeds.csv and, of whole seeds, of outlines.csv; sizes are corrected for
    the height of the widest section."""
    things = grains.things.assign(
        photo=photo, seed=np.arange(1, len(grains.things) + 1)
    )
    things["kind"] = _kinds(things, _contrasts(image, things))
    middle = (np.array(image.shape[1::-1]) - 1) / 2
    larger = 1 + magnification(things, middle, view)
    share = 1 / larger.mean(axis=1)
    for name, times in zip(("length", "width"), larger.T, strict=True):
        for size in (f"{name}_mm", f"{name}_sd_mm"):
            things[size] = (things[size] / times).round(5)
    things["area_mm2"] = (things.area_mm2 * share**2).round(4)
    outlines = []
    for row in np.flatnonzero(things.kind == WHOLE):
        edge, scale = things.edge[row], grains.scale
        points = (
            np.stack(scale.to_mm(*edge.T), -1)
            if isinstance(scale, BoardView)
            else edge * float(scale or 1.0)
        )
        terms = np.round(fourier_terms(aligned_outline(share[row] * points)), 6)
        outlines += [(photo, row + 1, h, *of) for h, of in enumerate(terms, 1)]
    rounded = things.reindex(columns=list(SEED_COLUMNS)).round({"x_px": 2, "y_px": 2})
    return rounded, outlines


def magnification(things: pd.DataFrame, middle: np.ndarray, view: View) -> np.ndarray:
    """Relative magnification (n, 2) of seeds' length and width due to their height;
    thickness t is assumed to be 0.8 widths. The widest section is t/2 above the paper:
    t/2D. At an angle θ off the camera's axis the top adds ½ (t/s)² tan²θ to a size s
    that points away from the picture's middle."""
    if view.distance_mm is None:
        return np.zeros((len(things), 2))
    thick = THICKNESS_SHARE * things.width_mm
    x, y = things.x_px - middle[0], things.y_px - middle[1]
    tangent = np.hypot(x, y) * things.length_mm / things.length_px / view.distance_mm
    across = np.radians(things.angle_deg) - np.arctan2(y, x)
    parts = (things.length_mm, np.cos(across)), (things.width_mm, np.sin(across))
    return np.column_stack(
        [
            thick / 2 / view.distance_mm + 0.5 * (thick / size * tangent * part) ** 2
            for size, part in parts
        ]
    )


def _magnification_sd(seeds: pd.DataFrame, view: View) -> float:
    """sd of the mean relative magnification, that of an unknown distance in it."""
    height = THICKNESS_SHARE / 2 * float(seeds["width_mm"].median())
    if not np.isfinite(height):
        return 0.0
    if view.distance_mm is not None:
        return float(height / view.distance_mm * np.hypot(THICKNESS_SD, DISTANCE_SD))
    low, high = 1e-3 / FARTHEST_M, 1e-3 / NEAREST_M  # 1/mm, log-uniform
    square = (high**2 - low**2) / 2 / np.log(high / low)
    return float(height * np.sqrt(square))


def _kinds(things: pd.DataFrame, contrast: np.ndarray) -> np.ndarray:
    seen, why = things.quality != FAILED, things.rejected
    area = things.area_px / max(float(np.median(things.area_px[seen])), 1e-9)
    bright = contrast / max(float(np.median(contrast[seen])), 1e-9)
    dented = things.edge.map(lambda edge: solidity(edge.astype(np.float32)) < DENTED)
    told = (
        (why == AT_BORDER, CUT),
        ((why == TOO_SMALL) & (area > 0.1), BROKEN),
        (~seen, OTHER),
        (bright < HUSK_SHARE, HUSK),
        (things.hidden > HIDDEN, TOUCHING),
        ((area < BROKEN_SHARE) | dented, BROKEN),
    )
    return np.select(*zip(*told, strict=True), WHOLE)


def _contrasts(image: np.ndarray, things: pd.DataFrame) -> np.ndarray:
    """Distance of each thing's median colour from the background's [levels]."""
    colour, labels = np.atleast_3d(image), np.zeros(image.shape[:2], np.int32)
    for number, edge in enumerate(things.edge, 1):
        cv2.fillPoly(labels, [np.rint(edge).astype(np.int32)], number)
    every = (labels > 0).astype(np.uint8)
    wide, tight = (cv2.dilate(every, np.ones((n, n), np.uint8)) for n in (25, 7))
    ground = wide - tight > 0
    behind = np.median(colour[ground], axis=0) if ground.any() else 0.0
    places = find_objects(labels, len(things))
    found = np.zeros(len(places))
    for k, at in ((k, at) for k, at in enumerate(places) if at is not None):
        own = np.median(colour[at][labels[at] == k + 1], axis=0)
        found[k] = np.linalg.norm(own - behind)
    return found


def _plausible(grains: Grains) -> Grains:
    """The grains, doubtful where no seed is so small or large; MeasurementError beyond
    what a seed's keys may say."""
    length = float(np.median(grains.seen.length_mm))
    said = tr("seeds of {:.3g} mm: is the scale right (millimetres a pixel)?", length)
    require(SIZE_LIMITS_MM[0] < length <= SIZE_LIMITS_MM[1], said)
    if PLAUSIBLE_MM[0] <= length <= PLAUSIBLE_MM[1]:
        return grains
    return replace(grains, things=doubted(grains.things, said))


def observe_seeds(
    path: Path, mm_per_px: float | None = None, mm_per_px_sd: float | None = None
) -> tuple[Grains, np.ndarray]:
    """Grains of a photo and an overlay (uint8 RGB); scale: `mm_per_px`, else that of a
    printed board, else sizes are in px."""
    image = read_photo(path)
    try:
        try:
            board, trouble = read_board(image), ""
        except MeasurementError as error:
            board, trouble = None, str(error)
        scale = board if mm_per_px is None else mm_per_px
        grains = measure_seeds(image, scale, mm_per_px_sd=mm_per_px_sd, board=board)
        if scale is not None:
            grains = _plausible(grains)
    except MeasurementError as error:
        raise MeasurementError(f"{path}: {error}") from error
    if scale is None:
        notes = (
            *grains.notes,
            tr("sizes are in px: no mm_per_px was given and {}", trouble),
        )
        grains = replace(grains, notes=notes)
    return grains, draw_grains(image, grains, board)
