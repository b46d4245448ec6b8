"""A heap's flanks in shares of their own size, independent of position, size and angle.

    u = (distance out from the top of the flank's line) / (its way to the plate),
    v = height / H

A straight flank is v = 1 − u. The line is that through 20–80 % of the crest's height.
Two flanks: the top is where their lines meet. One flank: the wall's foot; a heap whose
top never moved (its line passes above it at the wall) starts where the line reaches the
crest's height, and its crest is not used, nor half a seed next to a wall."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.ndimage import uniform_filter1d

from benchtwin.bench.language import tr

LOW, HIGH = 0.2, 0.8  # of the crest's height: the line's window
STEP, REACH = 0.0125, 1.4  # of u
# height of the line at the wall, over the crest, above which the top never moved
PLATEAU = 1.15
WALL_JUMP = 0.12  # of the crest's height
LEAST_ROWS = 24  # three tenths of the flank's way
# of the flank's way, where no seed's size is known: half a seed, of which at a wall
# only the round side is seen
EDGE = 0.03
SAME_SIZE = 0.2  # of ln
# correlation of the grains' outline between photos that follow each other
SAME_VIEW = 0.5
GRAINS = 0.1  # of the heap's height: longer waves are its shape


@dataclass(frozen=True, eq=False)
class Flank:
    """One flank in shares of its own size."""

    side: int  # +1 right, −1 left
    u: np.ndarray  # this and v (n,): the surface
    v: np.ndarray
    angle_deg: float  # of its line
    height: float  # H, in the photo's unit
    length: float  # the line's way
    start: float  # where u = 0 lies along x


@dataclass(frozen=True, eq=False)
class Photo:
    """One heap in one photo, or the mean of several; as stated, NaN where not."""

    recording: str
    session: str
    unit: str
    flanks: tuple[Flank, ...]
    reference: str  # of angles: "plumb" (stated), "plate" (line) or "rows" (picture)
    plate_deg: float  # the plate's line against a stated plumb, clockwise
    plate_sd_deg: float
    plumb_sd_deg: float
    gate_speed_mm_s: float
    photo_s: float
    width_mm: float
    seed_mm: float
    rig_mm: float  # size of what was emptied
    plain: bool  # known to be usual
    notes: tuple[str, ...]
    conditions: dict
    creep_deg: float = float("nan")  # flattening between photos, see creep_deg

    @property
    def stated(self) -> tuple:
        """Known quantities that may differ; photos of equal `stated` are repeats."""
        size = np.round(np.log(self.rig_mm) / SAME_SIZE)
        known = np.nan_to_num(
            [
                self.gate_speed_mm_s,
                self.photo_s,
                self.width_mm,
                self.seed_mm,
                size,
                self.plain,
            ],
            nan=-1.0,
        )
        return (*known.tolist(), *sorted(self.conditions.items()))


def photos_of(piles) -> tuple[tuple[Photo, ...], tuple[str, ...]]:
    """Photos with a usable flank, and why others have none; ValueError without any."""
    photos: list[Photo] = []
    refused: list[str] = []
    kept: list = []
    for seen in piles:
        photo = None if seen.trouble else photo_of(seen)
        if photo is not None and photo.flanks:
            photos.append(photo)
            kept.append(seen)
        else:
            doubts = "; ".join(seen.notes)
            none = tr("no flank of at least {} steps between crest and toe", LEAST_ROWS)
            none += f": {doubts}" if doubts else ""
            refused.append(f"{seen.recording}: {seen.trouble or none}")
    if not photos:
        raise ValueError(
            tr("no photo shows a flank from crest to toe")
            + "".join(f"\n  {r}" for r in refused)
        )
    return tuple(_by_heap(photos, kept)), tuple(refused)


def _by_heap(photos: list[Photo], piles: list) -> list[Photo]:
    """Photos of one heap in one state, averaged: the same grains, packed once."""
    groups: dict[tuple, list[tuple]] = {}
    for photo, seen in zip(photos, piles, strict=True):
        since = photo.photo_s if np.isfinite(photo.photo_s) else None
        groups.setdefault((seen.heap or seen.recording, since), []).append(
            (seen, photo)
        )
    pairs = [tuple(map(list, zip(*group))) for group in groups.values()]
    return [
        replace(_mean(mine), creep_deg=creep_deg(seen, mine)) for seen, mine in pairs
    ]


def _mean(photos: list[Photo]) -> Photo:
    """The mean photo of one heap; a side that is not in all of them is left out."""
    first = photos[0]
    if len(photos) == 1:
        return first
    sides = [
        f.side
        for f in first.flanks
        if all(f.side in [g.side for g in p.flanks] for p in photos)
    ]
    flanks = tuple(
        _mean_flank([f for p in photos for f in p.flanks if f.side == side])
        for side in sides
    )
    plate = float(np.mean([p.plate_deg for p in photos]))
    notes = tuple(dict.fromkeys(n for p in photos for n in p.notes))
    name = first.recording.rpartition("/")[0] or first.recording
    return replace(
        first,
        recording=name,
        flanks=flanks or first.flanks,
        plate_deg=plate,
        notes=notes,
    )


def _mean_flank(flanks: list[Flank]) -> Flank:
    low, high = max(f.u[0] for f in flanks), min(f.u[-1] for f in flanks)
    at = flanks[0].u[(flanks[0].u >= low - 1e-9) & (flanks[0].u <= high + 1e-9)]
    v = np.mean([np.interp(at, f.u, f.v) for f in flanks], axis=0)
    means = (
        float(np.mean([getattr(f, k) for f in flanks]))
        for k in ("angle_deg", "height", "length", "start")
    )
    return Flank(flanks[0].side, at, v, *means)


def photo_of(seen) -> Photo:
    """Turned upright, heights from the plate's line, each flank in its own shares."""
    camera, pile, seed = (
        seen.description.get(s, {}) for s in ("camera", "pile", "seed")
    )
    plumb, plate_seen = camera.get("plumb_deg"), seen.base_source != "toe"
    reference = "plumb" if plumb is not None else "plate" if plate_seen else "rows"
    level = {"plumb": plumb, "plate": seen.base_deg, "rows": 0.0}[reference]
    x, height, shown = _upright(seen, level)
    crest = _upright_x(seen.crest_x, seen, level)
    notes: list[str] = []
    lean = float(np.tan(np.radians(seen.base_deg - level)))
    half = (
        seed.get("length_mm", float("nan")) / 2 if seen.unit == "mm" else float("nan")
    )
    toes = [t if t is None else _upright_x(t, seen, level) for t in seen.toes_x]
    flanks = _flanks(x, height, shown, crest, toes, lean, half, notes)
    box = pile.get("box_mm")
    both = plumb is not None and plate_seen
    return Photo(
        seen.recording,
        seen.session,
        seen.unit,
        flanks,
        reference,
        seen.base_deg - plumb if both else float("nan"),
        seen.base_sd_deg,
        camera["plumb_sd_deg"],
        pile.get("gate_speed_mm_s", float("nan")),
        pile.get("photo_s", float("nan")),
        box[1] if box else float("nan"),
        seed.get("length_mm", float("nan")),
        _rig_mm(pile),
        pile.get("plain", False),
        (*notes, *(n for n in seen.notes if "cut by" in n)),
        seen.description.get("conditions", {}),
    )


def _rig_mm(pile: dict) -> float:
    """√(width × fill height) of what was emptied, or its width; NaN if not stated."""
    across = pile.get("cylinder_mm", pile.get("box_mm", [float("nan")]))[0]
    if "fill_height_mm" in pile:
        return float(np.sqrt(across * pile["fill_height_mm"]))
    return float(across)


def _upright(seen, level_deg: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places along the reference horizontal, heights above the plate's line, and
    whether the surface is seen there (n,)."""
    there = np.isfinite(seen.z)
    x, z = seen.x[there], seen.z[there] - seen.base_z
    c, s = np.cos(np.radians(level_deg)), np.sin(np.radians(level_deg))
    along, up = x * c - z * s, x * s + z * c
    order = np.argsort(along, kind="stable")
    along, up = along[order], up[order]
    shown = ~seen.hidden[there][order] if len(seen.hidden) else np.isfinite(along)
    return along, up + np.tan(np.radians(seen.base_deg - level_deg)) * along, shown


def _upright_x(x: float, seen, level_deg: float) -> float:
    """The same for one place on the surface."""
    z = (
        np.interp(x, seen.x[np.isfinite(seen.z)], seen.z[np.isfinite(seen.z)])
        - seen.base_z
    )
    return float(x * np.cos(np.radians(level_deg)) - z * np.sin(np.radians(level_deg)))


def _flanks(
    x,
    height,
    shown,
    crest: float,
    toes,
    lean: float,
    half_seed: float,
    notes: list[str],
) -> tuple[Flank, ...]:
    """shown (n,): where the surface is seen; lean: how far the plate falls per x;
    half_seed: in the photo's unit, or NaN."""
    found = []
    for side, toe in ((-1, toes[0]), (1, toes[1])):
        if toe is None:
            continue
        out = side * (x - crest)  # distance out from the crest
        order = np.argsort(out, kind="stable")
        line = _line(out[order], height[order], side * (toe - crest))
        if line is not None:
            found.append((side, toe, line))
    top = _top(x, height, crest, found, notes)
    made = []
    for side, toe, (slope, level) in found:
        start, cut = top
        out = side * (x - start)
        level = level - slope * side * (start - crest)  # height of the line where u = 0
        if not np.isfinite(level) or level <= 0:
            continue
        length = level / slope
        edge = (
            0.0
            if len(found) > 1
            else half_seed / length
            if np.isfinite(half_seed)
            else EDGE
        )
        u, v = _rows(
            out[shown] / length,
            height[shown] / level,
            max(cut, edge),
            min(side * (toe - start) / length, REACH),
        )
        if len(u) >= LEAST_ROWS:
            angle = float(np.degrees(np.arctan(slope + side * lean)))
            made.append(Flank(side, u, v, angle, level, length, start))
    return tuple(made)


def _line(
    out: np.ndarray, height: np.ndarray, toe: float
) -> tuple[float, float] | None:
    """Slope (falling, positive) and height at the crest of the line through the window,
    or None."""
    here = (out >= 0) & (out <= toe)
    if here.sum() < LEAST_ROWS // 2:
        return None
    at, surface = out[here], height[here]
    smooth = uniform_filter1d(surface, max(3, len(at) // 20) | 1, mode="nearest")
    top = float(smooth[: max(3, len(at) // 20)].max())
    below = smooth < HIGH * top, smooth < LOW * top
    if not (below[0].any() and below[1].any()):
        return None
    first, last = int(below[0].argmax()), int(below[1].argmax())
    if last - first < 10:
        return None
    slope, level = np.polyfit(at[first:last], surface[first:last], 1)
    return (-float(slope), float(level)) if slope < 0 else None


def _top(x, height, crest: float, found, notes: list[str]) -> tuple[float, float]:
    """Where u = 0 lies, and from which u on rows are used."""
    if len(found) == 2:
        (_, _, (left, level_left)), (_, _, (right, level_right)) = found
        return crest + (level_right - level_left) / (left + right), 0.0
    if not found:
        return crest, 0.0
    side, _, (slope, level) = found[0]
    top = float(
        np.interp(
            crest,
            x,
            uniform_filter1d(height, max(3, len(x) // 100) | 1, mode="nearest"),
        )
    )
    wall = _wall(side * (x - crest), height, top)
    if level - slope * wall <= PLATEAU * top:
        return crest + side * wall, 0.0
    notes.append(tr("the heap's top was never moved: its crest is not judged"))
    return crest + side * (level - top) / slope, 0.15


def _wall(out: np.ndarray, height: np.ndarray, top: float) -> float:
    """How far behind the crest (≤ 0) the surface goes on."""
    order = np.argsort(-out, kind="stable")
    behind = order[out[order] <= 0]
    reach = 0.0
    for i in behind:
        if abs(height[i] - top) > WALL_JUMP * top:
            break
        reach = float(out[i])
    return reach


def _rows(
    u: np.ndarray, v: np.ndarray, low: float, high: float
) -> tuple[np.ndarray, np.ndarray]:
    """Means over steps of u between `low` and `high`."""
    edges = np.arange(low, high, STEP)
    if len(edges) < 2:
        return np.zeros(0), np.zeros(0)
    inside = (u >= edges[0]) & (u < edges[-1])
    cell = np.searchsorted(edges, u[inside], side="right") - 1
    count = np.bincount(cell, minlength=len(edges) - 1)
    mean = np.bincount(cell, v[inside], minlength=len(edges) - 1) / np.maximum(count, 1)
    return (edges[:-1] + STEP / 2)[count > 0], mean[count > 0]


def creep_deg(piles: list, photos: list) -> float:
    """By how much flanks [deg] flatten from first to last photo; NaN where not
    comparable."""
    angles = [_angle_deg(photo) for photo in photos]
    if (
        len(piles) < 2
        or not np.isfinite(angles).all()
        or min(_alike(a, b) for a, b in pairwise(piles)) < SAME_VIEW
    ):
        return float("nan")
    turns = np.arange(len(angles))
    return float(-np.polyfit(turns, angles, 1)[0] * turns[-1])


def _angle_deg(photo) -> float:
    """Mean angle of the flanks against the plate, NaN where the camera's tilt is
    unknown."""
    known = np.isfinite(photo.plate_deg)
    if len(photo.flanks) < 2 and photo.reference != "plate" and not known:
        return float("nan")
    lean = photo.plate_deg if known else 0.0
    return float(np.mean([f.angle_deg - f.side * lean for f in photo.flanks]))


def _alike(one, other) -> float:
    """Correlation of the short waves of two surfaces."""
    count = min(len(one.z), len(other.z))
    if (
        count < 2
        or one.unit != other.unit
        or abs(one.x[0] - other.x[0]) > abs(one.x[1] - one.x[0])
    ):
        return 0.0
    height, column = float(np.nanmax(one.z - one.base_z)), float(one.x[1] - one.x[0])
    high = max(3, round(GRAINS * height / column)) | 1
    a, b = (_grains(seen.z[:count], high) for seen in (one, other))
    there = np.isfinite(one.z[:count]) & np.isfinite(other.z[:count])
    a, b = a[there], b[there]
    if len(a) > 2 and a.std() > 0 and b.std() > 0:
        return float(np.corrcoef(a, b)[0, 1])
    return 0.0


def _grains(z: np.ndarray, wide: int) -> np.ndarray:
    """A surface (n,) less its mean over `wide` columns."""
    there = np.isfinite(z)
    whole = np.interp(np.arange(len(z)), np.flatnonzero(there), z[there])
    return whole - uniform_filter1d(whole, wide)
