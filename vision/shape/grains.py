"""Photo of spread seeds → length and width of every seed, as a caliper measures them,
and their distribution."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
import pandas as pd

from benchtwin.bench.language import tr
from benchtwin.bench.priors import unstated_sd
from benchtwin.vision.board.view import BoardView, sheet_mask
from benchtwin.vision.measurement import (
    DOUBTFUL,
    FAILED,
    GOOD,
    MeasurementError,
    require,
)
from benchtwin.vision.shape.outline import centroid, ellipse_agreement, feret, solidity
from benchtwin.vision.shape.silhouettes import (
    Piece,
    Relief,
    make_relief,
    split,
    touching_patch,
    without_thin_parts,
)
from benchtwin.vision.shape.subpixel_outline import Edge, find_edge

LEAST_AREA_PX = 60  # smaller things are dust
NO_DUST_PX = 2000  # specks and crumbs are smaller
ALIKE = 2.2  # ratio of the areas of seeds of one lot
CONVEX = 0.955  # least solidity of a single grain; touching grains have notches
# reached by seeds without shadow; dark seeds measured with their shadow start at 1.85
MOST_SOFTNESS = 1.8
# Edges of seeds without shadow lean by .017 at most on average, each by .02; those of
# dark seeds with as dark a shadow by .08.
LEAST_LEAN, LEAN_SD = 0.04, 0.02
AT_BORDER = "cut by the picture's border"
TOO_SMALL = "too small for a seed"
TOO_LARGE = "too large for a seed"
HIDDEN = "too much of its edge is hidden by neighbours"
AT_SHEET = "it touches the board's sheet"
ONE_LAMP = (
    "the edges of all seeds are softer on one side: a shadow is measured with them;"
    " light them from all sides"
)


SIZES = tuple(
    f"{name}{end}_{unit}"
    for unit in ("px", "mm")
    for name in ("length", "width")
    for end in ("", "_sd")
)
THING = (
    *("x_px", "y_px", *SIZES, "angle_deg", "area_px", "area_mm2"),
    *("quality", "rejected", "reason", "edge", "hidden", "lean_x", "lean_y"),
)


@dataclass(frozen=True)
class Grains:
    """All seeds of a picture, left to right in rows, and rejected things.

    things: a row for each, of columns THING. Lengths in mm are NaN where the scale is
    unknown; edge (n, 2): outline [px]. quality failed: no whole seed, not part of the
    distribution; reason says why, rejected is the kind of reason (AT_BORDER …).
    angle_deg: direction of the length, clockwise from the picture's x axis, −90 to 90.
    hidden: share of the edge that neighbours cover, where an ellipse replaces it.
    lean_x, lean_y: see Edge.

    **Length** is the largest, **width** the smallest Feret diameter. Thickness cannot
    be seen from above. A seed's widest section lies about half its thickness t above
    the paper: at the camera's distance D it looks larger by t/(2D), 1 % for 6 mm at 300
    mm. This is not corrected and not in the sd, since D is not known. Each sd contains
    the edge's noise, the error of its level, and the scale's sd at the seed; the last
    is common to all seeds of a picture."""

    things: pd.DataFrame
    scale: BoardView | float | None
    notes: tuple[str, ...] = ()
    stated_scale_sd: float = unstated_sd("scale")  # relative

    @property
    def grains(self) -> tuple[Any, ...]:
        """The things one by one."""
        return tuple(self.things.itertuples(index=False))

    @property
    def seen(self) -> pd.DataFrame:
        """The seeds that count."""
        return self.things[self.things.quality != FAILED]

    @property
    def measured(self) -> tuple[Any, ...]:
        """The seeds that count, one by one."""
        return tuple(self.seen.itertuples(index=False))

    @property
    def common_doubt(self) -> str:
        """The reasons for which most of the seeds are doubtful, "" for none."""
        reasons = self.seen.reason.map(lambda said: [*dict.fromkeys(said.split("; "))])
        counts = reasons.explode().value_counts(sort=False)
        most = len(self.seen) / 2
        return "; ".join(why for why, n in counts.items() if why and n > most)

    def table(self) -> pd.DataFrame:
        """seeds.csv: a row for each thing found; columns in px without a scale."""
        unit, area = ("px", "px") if self.scale is None else ("mm", "mm2")
        sizes = [name for name in SIZES if name.endswith(unit)]
        names = ["x_px", "y_px", *sizes, "angle_deg", f"area_{area}"]
        table = self.things[[*names, "quality", "reason"]].copy()
        table.insert(0, "seed", np.arange(1, len(table) + 1))
        return table

    def distribution(self) -> pd.DataFrame:
        """n, mean, sd, min and max over the seeds that count, and the mean's sd; rows
        length and width. mean_sd is √(spread²/n + common²), where common is the scale's
        sd, which does not average out."""
        unit, common = ("px", 0.0) if self.scale is None else ("mm", self.common_sd())
        sizes = self.seen[[f"length_{unit}", f"width_{unit}"]]
        told = sizes.set_axis(["length", "width"], axis=1)
        told = told.agg(["count", "mean", "std", "min", "max"]).T
        told = told.rename(columns={"count": "n", "std": "sd"}).astype({"n": int})
        told["mean_sd"] = np.hypot(told.sd / np.sqrt(told.n), common * told["mean"])
        told.insert(0, "unit", unit)
        return told.rename_axis("quantity").reset_index()

    def common_sd(self) -> float:
        """Relative sd of the scale, which all seeds share."""
        if not isinstance(self.scale, BoardView):
            return self.stated_scale_sd
        places = zip(self.seen.x_px, self.seen.y_px, strict=True)
        return float(np.mean([_scale_sd(self.scale, x, y) for x, y in places]))


def doubted(things: pd.DataFrame, why: str) -> pd.DataFrame:
    """The things, of which the seeds that count are doubtful for one more reason."""
    seen = things.quality != FAILED
    said = things.reason.map(lambda reason: "; ".join(filter(None, (reason, why))))
    return things.assign(
        quality=things.quality.mask(seen, DOUBTFUL),
        reason=things.reason.mask(seen, said),
    )


def measure_seeds(
    image: np.ndarray,
    scale: BoardView | float | None = None,
    *,
    mm_per_px_sd: float | None = None,
    board: BoardView | None = None,
) -> Grains:
    """Length and width of every seed on a contrasting background in `image` ((h, w) or
    (h, w, 3), uint8 or uint16).

    scale: of a printed board that lies beside them, or mm per px (with its sd
    `mm_per_px_sd`; 1 % when not stated), or None: sizes in px. `board`: whose sheet is
    no place for seeds (default: `scale` if it is one). A shadow as dark
    as the seeds counts as seed (doubtful): light them from all sides. Valid for seeds
    of 12 px and more with a contrast of at least some 5 % of white that do not lie on
    each other. Raises MeasurementError when no whole seed is found."""
    if (
        not isinstance(image, np.ndarray)
        or image.dtype not in (np.uint8, np.uint16)
        or image.ndim not in (2, 3)
    ):
        raise MeasurementError(
            tr("a picture must be grey or RGB with 8 or 16 bits a channel")
        )
    if image.ndim == 3 and image.shape[2] != 3:
        image = image[..., 0]
    if min(image.shape[:2]) < 24:
        raise MeasurementError(
            tr(
                "the picture is too small ({} × {} px) to measure seeds in it",
                image.shape[1],
                image.shape[0],
            )
        )
    if isinstance(scale, int | float) and not (np.isfinite(scale) and scale > 0):
        raise MeasurementError(tr("mm_per_px = {} is not a scale", scale))
    board = board or (scale if isinstance(scale, BoardView) else None)
    region = None if board is None else sheet_mask(image.shape[:2], board)
    relief = make_relief(image, region)
    stated = mm_per_px_sd is not None and isinstance(scale, int | float)
    relative_sd = mm_per_px_sd / scale if stated else unstated_sd("scale")
    found = _find_grains(relief, scale, relative_sd, region)
    things = pd.DataFrame([g for g in found if g is not None], columns=list(THING))
    seen = things[things.quality != FAILED]
    if seen.empty:
        why = f" ({things.reason[0]})" if len(things) else ""
        raise MeasurementError(tr("no whole seed found in the picture{}", why))
    if _all_lean(seen):
        things = doubted(things, tr(ONE_LAMP))
    notes = [tr("thickness cannot be seen from above")]
    if isinstance(scale, BoardView):
        notes += [tr("the scale's board: {}", doubt) for doubt in scale.doubts]
    row = max(float(np.nanmedian(things.length_px)), 1.0)
    # in rows, each from left to right
    order = np.lexsort((things.x_px, (things.y_px / row).round()))
    things = things.iloc[order].reset_index(drop=True)
    return Grains(things, scale, tuple(notes), relative_sd)


def _find_grains(
    relief: Relief, scale, relative_sd: float, region: np.ndarray | None
) -> Iterator[tuple | None]:
    """A row of THING for every connected patch of the mask, several for touching seeds;
    rejected things too."""
    yield from (_rejected(other, TOO_LARGE) for other in relief.others)
    contours = cv2.findContours(relief.mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[
        0
    ]
    patches = [c[:, 0] for c in contours if cv2.contourArea(c) >= LEAST_AREA_PX]
    typical = _typical_area(patches, relief)
    for patch in patches:
        area = cv2.contourArea(patch)
        reason = _rejection(patch, area, typical, relief, region)
        if reason:
            if area >= 0.1 * typical:  # smaller specks are ignored
                yield _rejected(patch, reason)
            continue
        if solidity(patch) >= CONVEX and area < 2.5 * typical:
            pieces = [Piece(patch.astype(float), np.ones(len(patch), bool))]
        else:
            shape, corner = touching_patch(relief, patch)
            pieces = [
                replace(p, outline=p.outline + corner)
                for p in split(without_thin_parts(shape, typical))
            ]
        for piece in pieces:
            yield _grain(piece, relief, typical, scale, relative_sd)


def _grain(
    piece: Piece, relief: Relief, typical: float, scale, relative_sd: float
) -> tuple | None:
    area = cv2.contourArea(piece.outline.astype(np.float32))
    if area < 0.25 * typical:
        if area >= 0.1 * typical:
            return _rejected(piece.outline, TOO_SMALL)
        return None
    edge = find_edge(relief.height, piece.outline, piece.free)
    if edge is None:
        return _rejected(piece.outline, HIDDEN)
    return _sized(edge, scale, relative_sd, _doubts(edge, area, typical))


def _sized(edge: Edge, scale, relative_sd: float, doubts: list[str]) -> tuple:
    (x, y), area = centroid(edge.points)
    *px, angle = feret(edge.points)
    # A size has two edges; hidden parts have the error of the ellipse.
    noise = np.hypot(edge.sd_px * np.sqrt(2), 2 * edge.level_px)
    px_sd = [float(np.hypot(noise, 0.03 * edge.hidden * size)) for size in px]
    mm, relative, area_mm2 = [np.nan, np.nan], np.nan, np.nan
    if isinstance(scale, BoardView):
        flat = np.stack(scale.to_mm(*edge.points.T), -1)
        mm, relative = [*feret(flat)[:2]], _scale_sd(scale, x, y)
        area_mm2 = centroid(flat)[1]
    elif scale is not None:
        mm, relative = [size * scale for size in px], relative_sd
        area_mm2 = area * scale**2
    mm_sd = [
        float(size * np.hypot(sd / seen, relative))
        for size, sd, seen in zip(mm, px_sd, px, strict=True)
    ]
    sizes = np.array([px, px_sd, mm, mm_sd]).reshape(2, 2, 2).swapaxes(1, 2)
    told = DOUBTFUL if doubts else GOOD, "", "; ".join(doubts)
    numbers = (x, y, *sizes.ravel().tolist(), angle, area, area_mm2)
    return (*numbers, *told, edge.points, edge.hidden, *edge.lean)


def _all_lean(seen: pd.DataFrame) -> bool:
    """Whether the edges of all seeds are softer on the same side: a lamp's shadows lie
    on one side of all, whatever lies on the seeds themselves on any."""
    lean = seen[["lean_x", "lean_y"]].to_numpy(float)
    mean, scatter = lean.mean(0), np.hypot(LEAN_SD, lean.std(0).max())
    return np.hypot(*mean) > max(LEAST_LEAN, 4 * scatter / np.sqrt(len(lean)))


def _doubts(edge: Edge, area: float, typical: float) -> list[str]:
    soft = edge.softness > MOST_SOFTNESS or edge.rim > 0.2
    told = (
        (
            edge.hidden > 0.3,
            tr("{:.0f} % of its edge is hidden by neighbours", 100 * edge.hidden),
        ),
        (
            edge.lost > 0.25,
            tr("no clear edge over {:.0f} % of its outline", 100 * edge.lost),
        ),
        (
            soft,
            tr(
                "its edge is soft or darker on one side: a shadow may be measured with"
                " it"
            ),
        ),
        (
            solidity(edge.points.astype(np.float32)) < 0.95,
            tr("its outline is dented: two seeds, or a broken one"),
        ),
        (ellipse_agreement(edge.points) < 0.93, tr("its outline is no ellipse")),
        (
            edge.rim_drop > 0.25,
            tr("its rim is much fainter than its middle, its edge uncertain"),
        ),
        (
            not 1 / ALIKE < area / typical < ALIKE,
            tr("its area is {:.1g} times that of most", area / typical),
        ),
    )
    return [why for holds, why in told if holds]


def _typical_area(patches: list[np.ndarray], relief: Relief) -> float:
    """Typical area of a seed: that of the convex whole patches of which most are alike;
    each counts one, but the less the smaller it is where it may be dust."""
    whole = [p for p in patches if not _at_border(p, relief.mask.shape)]
    lone = [cv2.contourArea(p) for p in whole if solidity(p) >= CONVEX]
    # nearly all touch: split them first
    if sum(lone) < 0.2 * sum(cv2.contourArea(p) for p in whole):
        lone = [
            cv2.contourArea(q.outline.astype(np.float32))
            for p in whole
            for q in split(touching_patch(relief, p)[0])
        ]
    areas = np.array(lone)
    require(
        len(areas),
        tr(
            "no seeds stand out from the ground; spread them on paper or cloth of a"
            " contrasting colour"
        ),
    )
    apart = np.abs(np.log(areas[:, None] / areas))
    alike = apart < np.log(ALIKE)
    most = (alike * np.minimum(areas, NO_DUST_PX)).sum(1).argmax()
    return float(np.median(areas[alike[most]]))


def _rejection(
    patch: np.ndarray,
    area: float,
    typical: float,
    relief: Relief,
    region: np.ndarray | None,
) -> str:
    """Why a patch is no whole seed; "" where it may be one or several."""
    if region is not None:
        x = np.clip(patch[:, 0], 2, region.shape[1] - 3)
        y = np.clip(patch[:, 1], 2, region.shape[0] - 3)
        if any(
            region[y + dy, x + dx].any()
            for dx, dy in ((2, 0), (-2, 0), (0, 2), (0, -2))
        ):
            return AT_SHEET
    told = (
        (_at_border(patch, relief.mask.shape), AT_BORDER),
        (area < 0.25 * typical, TOO_SMALL),
        (
            area > 3.5 * typical and solidity(patch) >= CONVEX,
            TOO_LARGE,
        ),
    )
    return next((why for holds, why in told if holds), "")


def _rejected(patch: np.ndarray, why: str) -> tuple:
    edge, unknown = patch.astype(float), float("nan")
    (x, y), area = centroid(edge)
    sizes = (unknown,) * (len(SIZES) + 1)
    said = (area, unknown, FAILED, why, tr(why))
    return (x, y, *sizes, *said, edge, 0.0, unknown, unknown)


def _at_border(patch: np.ndarray, shape: tuple[int, int]) -> bool:
    return bool(
        (patch <= 1).any()
        or (patch[:, 0] >= shape[1] - 2).any()
        or (patch[:, 1] >= shape[0] - 2).any()
    )


def _scale_sd(scale: BoardView, x: float, y: float) -> float:
    return scale.sd_at(x, y) / float(scale.at(x, y))
