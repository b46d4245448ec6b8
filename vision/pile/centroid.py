"""Centroid angle of a pile: atan(z̄ / x̄) of the part of its outline above a tenth of
the crest's height.

z̄ is the mean height above that level; x̄ is the mean distance from the wall that the
pile leans on or, without a wall, from the heap's own axis. For a straight-sided pile
this is the angle of repose. All of the outline counts, so no single seed decides:
between packings of a few hundred seeds it scatters less than half as much as a line
through part of the slope."""

from dataclasses import replace

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.vision.measurement import Quantity, failed
from benchtwin.vision.pile.heap import BaseLine, Heap

NAME = "centroid_angle"
FOOT = 0.1  # of the crest's height: what is lower does not count
# of the crest's height: what leans on a wall stands higher there; and what may be taken
# for that height as well, where seeds beside the wall are missing
HIGH, LESS_HIGH = 0.8, 0.6
BARE = 0.02  # of the crest's height: lower is bare plate
# of the crest's height: how far beyond the toe loose seeds may belong to the pile
LOOSE = 0.25
# of the way from wall to toe: how far behind the picture's border its wall may stand,
# when a frame is drawn beside all of a wall whose face is seen from aside
BEHIND = 0.06
MARGIN = 2  # small px by which heap.py widens a wall when it removes it


def centroid_angle(
    surface: np.ndarray,
    base: BaseLine,
    heap: Heap,
    factor: float,
) -> Quantity:
    """The quantity `centroid_angle`; failed, with the reason, where the pile's foot or
    its wall is not in the picture. surface (w,): rows [px, y down], NaN where there is
    none; heap: in small px of `factor` px each."""
    good = {f.side: f for f in heap.flanks if not f.problem}
    walls = {f.side for f in heap.flanks if f.at_wall}
    if not good or len(good) + len(walls) < 2:
        return failed(
            NAME, "deg", tr("the pile's foot is not in the picture on both sides")
        )
    ends = {side: (flank.toe + 0.5) * factor for side, flank in good.items()}
    leaning = walls - set(good)
    faces, others = (
        {s: _wall_face(surface, base, heap, factor, s, share) for s in leaning}
        for share in (HIGH, LESS_HIGH)
    )
    ends |= faces
    found = _rise_and_reach(surface, base, heap, factor, ends, leaning)
    if found is None:
        return failed(NAME, "deg", tr("nothing stands above the base line"))
    slope, rise, reach = found
    toes = _alternative_toes(surface, base, heap, factor, ends, good)
    elsewhere = [
        _rise_and_reach(surface, base, heap, factor, ends | end, leaning)
        for end in (others, *toes)
    ]
    wall, *slopes = [slope if other is None else other[0] for other in elsewhere]
    toe_sd = float(np.ptp([slope, *slopes])) / 2
    # half a small pixel in the surface's height, one in where the wall or the foot
    # stands
    edge_sd = slope * np.hypot(
        0.5 * factor / rise, (0.5 if len(good) == 2 else 1.0) * factor / reach
    )
    behind = [
        _wall_behind(surface, base, heap, factor, ends, side) - slope
        for side, face in faces.items()
        if min(face, surface.size - 1 - face) <= MARGIN * factor
    ]
    # the other face of the wall is as likely where few seeds lie beside it
    off = np.linalg.norm([edge_sd, toe_sd, wall - slope, *behind])
    sd = float(np.degrees(off / (1 + slope**2)))
    return Quantity(NAME, float(np.degrees(np.arctan(slope))), sd, "deg")


def _rise_and_reach(
    surface, base: BaseLine, heap: Heap, factor: float, ends: dict, leaning: set
) -> tuple[float, float, float] | None:
    """z̄/x̄, z̄ and x̄ [px] between the two ends; None where nothing is above the foot.
    leaning: sides with a wall."""
    x = np.arange(surface.size)
    inside = (x >= ends["left"]) & (x <= ends["right"]) & np.isfinite(surface)
    rows = surface[inside]
    for side in leaning:  # beside the wall, whose blurred edge hides them
        hidden = np.abs(x[inside] - ends[side]) < (MARGIN + 0.5) * factor
        if hidden.any() and not hidden.all():
            rows[hidden] = rows[~hidden][0 if side == "left" else -1]
    height = np.clip(
        base.at(x[inside]) - rows - FOOT * heap.height_px * factor, 0.0, None
    )
    area = height.sum()
    if not area > 0:
        return None
    middle = float((x[inside] * height).sum() / area)
    axis = next((ends[side] for side in leaning), middle)
    reach = float((np.abs(x[inside] - axis) * height).sum() / area)
    rise = float((height**2).sum() / 2 / area)
    return rise / reach, rise, reach


def _wall_behind(
    surface, base: BaseLine, heap: Heap, factor: float, ends: dict, side: str
) -> float:
    """z̄/x̄ with the wall of that side behind the picture's border, to which the surface
    goes on as high as at the border."""
    more = max(round(BEHIND * (ends["right"] - ends["left"])), 1)
    before, after = (more, 0) if side == "left" else (0, more)
    blurred = min(round((MARGIN + 1) * factor), surface.size // 2)
    level = surface[blurred if side == "left" else -blurred - 1]
    longer = surface.copy()
    longer[slice(blurred) if side == "left" else slice(-blurred, None)] = level
    longer = np.pad(longer, (before, after), mode="edge")
    base = replace(base, intercept=base.intercept - base.slope * before)
    ends = {"left": ends["left"], "right": ends["right"] + more}
    found = _rise_and_reach(longer, base, heap, factor, ends, {side})
    assert found is not None  # it holds what was found without the addition
    return found[0]


def _alternative_toes(
    surface, base: BaseLine, heap: Heap, factor: float, ends: dict, good
) -> tuple[dict, dict]:
    """Two other choices of the toes: the first bare column outwards from the crest, and
    LOOSE of the height beyond the toe."""
    height = heap.height_px * factor
    bare = base.at(np.arange(surface.size)) - surface <= BARE * height
    crest = int(heap.crest * factor)
    nearer = {
        "left": np.flatnonzero(bare[:crest]),
        "right": crest + np.flatnonzero(bare[crest:]),
    }
    near = {
        side: float(nearer[side][-1 if side == "left" else 0])
        if len(nearer[side])
        else ends[side]
        for side in good
    }
    return near, {
        side: ends[side] + (-LOOSE if side == "left" else LOOSE) * height
        for side in good
    }


def _wall_face(
    surface, base: BaseLine, heap: Heap, factor: float, side: str, share: float
) -> float:
    """Column [px] of the face of the wall on that side, where what is higher than
    `share` of the crest leans on it. A near camera sees the face from aside: seeds
    before and behind the crest meet it elsewhere in the picture."""
    high = base.at(np.arange(surface.size)) - surface > share * heap.height_px * factor
    for low, end in heap.walls:
        high[int((low + MARGIN) * factor) : int((end - MARGIN) * factor) + 1] = False
    crest = min(int((heap.crest + 0.5) * factor), surface.size - 1)
    if side == "left":
        below = np.flatnonzero(~high[:crest])
        return float(below[-1] + 1 if below.size else 0)
    below = np.flatnonzero(~high[crest + 1 :])
    return float(crest + below[0] if below.size else surface.size - 1)
