"""A film of a column of seeds whose gate is lifted → how fast the gate rose, and how
long the seeds flowed.

Only what differs between the first and the last picture counts: of a pixel beyond the
gate that is seeds in the end, (I − I_first) / (I_last − I_first) is how much of it is
seeds now. The gate's edge has passed a height when half of the strip beside it there
are seeds; a robust line (Theil and Sen) through these times over the height tells how
long the gate takes to rise as high as the seeds stood. Of a simulated collapse the same
numbers follow from its outlines."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import median_abs_deviation, theilslopes
from skimage.filters import threshold_otsu

from benchtwin.bench.language import tr
from benchtwin.vision.measurement import MeasurementError, Quantity, require
from benchtwin.vision.pile.repose import Repose

STRIP = 0.1  # beside the gate, of the column's height
# of the column's height: where less lies in the end, it may be loose seeds
LAYER = 0.15
HEIGHTS = np.arange(0.06, 0.46, 0.04)  # of the column's, that its edge passes
LEAST_HEIGHTS = 5  # for a line
BAND = 0.02  # of the column's height, above and below each of these
RIM_PX = 2  # beside the surface and the base line
# of pixels under the surface beyond the gate and behind it: how many change, at least
# how much more
LEAST_CONTRAST = 0.4
LEAST_CHANGED = 0.3  # of a band, to be read
# of the column's height beside the gate, and how much of it changes at least, where
# seeds came there after the first picture only
FOOT, MOST_BEFORE = 0.12, 0.5
# of a frame: sd of a time at which half of something is filled, between two frames
TIMED = 0.2
INDEPENDENT = 3  # of the times in a line: neighbours are read off the same seeds
UNSTEADY = 0.15  # of the gate's time: scatter about a steady rise
TOO_QUICK = 0.5  # of a frame: so little is no more than that the gate was quick
GATE, FLOW = "gate_lift_time", "collapse_time"


@dataclass(frozen=True)
class Collapse:
    """gate_s: in which the gate rises as high as the seeds stood, with sd; flow_s: from
    a quarter to three quarters of the run-out filled, with sd; steady_s: rms of the
    gate's times about a steady rise; late: whether seeds had run out before the first
    picture. NaN where it is not seen."""

    gate_s: float
    gate_sd_s: float
    flow_s: float
    flow_sd_s: float
    steady_s: float
    late: bool

    def quantities(self) -> tuple[Quantity, ...]:
        """Both times, as far as they are seen."""
        late = tr("the film begins after the gate began to rise") if self.late else ""
        frame = self.flow_sd_s / TIMED / np.sqrt(2)
        unsteady = self.steady_s > max(UNSTEADY * self.gate_s, frame)
        quick = self.gate_s < TOO_QUICK * frame
        reasons = (
            late,
            tr("the gate did not rise steadily") if unsteady else "",
            tr("the gate is up before the next frame") if quick else "",
        )
        gate = Quantity(GATE, self.gate_s, self.gate_sd_s, "s").doubt(*reasons)
        flow = Quantity(FLOW, self.flow_s, self.flow_sd_s, "s").doubt(late)
        return tuple(q for q in (gate, flow) if np.isfinite(q.value))


def collapse(
    t_s: np.ndarray, filled: np.ndarray, passed: np.ndarray, late: bool = False
) -> Collapse:
    """filled (n,): share of the run-out that is filled at t_s (n,); passed (n, k): of
    the strip beside the gate at HEIGHTS, NaN where nothing can be seen; late: whether
    seeds had run out before the first picture."""
    times = np.array([half_filled(t_s, row) for row in passed.T])
    seen = np.isfinite(times)
    slope = slope_sd = rms = np.nan
    frame = float(np.median(np.diff(t_s)))
    if seen.sum() >= LEAST_HEIGHTS:
        at = HEIGHTS[seen]
        slope, rest = theilslopes(times[seen], at)[:2]
        off = times[seen] - slope * at - rest
        rms = float(median_abs_deviation(off, scale="normal"))
        slope_sd = max(rms, TIMED * frame) / np.sqrt(INDEPENDENT) / float(np.std(at))
    quarter, most = (half_filled(t_s, filled, share) for share in (0.25, 0.75))
    return Collapse(
        float(np.maximum(slope, 0.0)),
        float(slope_sd),
        most - quarter,
        TIMED * frame * np.sqrt(2),
        float(rms),
        late,
    )


def half_filled(t_s: np.ndarray, filled: np.ndarray, share: float = 0.5) -> float:
    """When the share is passed for the last time; NaN if it is not, or was at first."""
    below = np.flatnonzero(~(filled >= share))
    if not len(below) or not 0 <= (k := below[-1]) < len(filled) - 1:
        return float("nan")
    return float(np.interp(share, filled[k : k + 2], t_s[k : k + 2]))


@dataclass(frozen=True, eq=False)
class Filmed:
    """A collapse as seen in a film, and its picture: arrived (h, w): when a pixel was
    half changed [s], NaN where it did not change."""

    collapse: Collapse
    arrived: np.ndarray


def filmed_collapse(
    t_s: np.ndarray, pictures: np.ndarray, found: Repose, factor: int, top_px: int
) -> Filmed:
    """pictures (n, h, w): grey, smaller by `factor` than the last one, in which the
    heap was found below its first top_px rows. MeasurementError where no column
    collapses in them."""
    require(
        sum(toe is None for toe in found.toes) == 1,
        tr("no gate: the heap leans on no wall, or on two"),
    )
    require(np.isfinite(t_s).all(), tr("no frame rate is known: camera.fps tells it"))
    grey = pictures
    surface, base = _lines(found, factor, top_px, grey.shape[2])
    difference = np.abs(grey[-1].astype(float) - grey[0])
    changed = difference > threshold_otsu(difference)
    arrived = _arrived(t_s, grey, changed)
    if found.toes[0] is not None:  # the wall to the left, the gate right of it
        grey, changed = grey[:, :, ::-1], changed[:, ::-1]
        surface, base = surface[::-1], base[::-1]
    first = grey[0].astype(float)
    change = grey[-1] - first
    rows = np.arange(grey.shape[1])[:, None]
    under = (rows > surface + RIM_PX) & (rows < base - RIM_PX)
    gate, top = _column(changed, under, rows < surface - RIM_PX)
    high = float(base[gate] - top)

    def seeds(part: np.ndarray) -> np.ndarray:
        """(n,) mean share of change of the pixels that changed there."""
        if part.sum() == 0:
            return np.full(len(grey), np.nan)
        return np.clip((grey[:, part] - first[part]) / change[part], 0, 1).mean(axis=1)

    columns = np.arange(grey.shape[2])
    strip = (columns >= gate) & (columns < gate + max(STRIP * high, 2.0))
    passed = []
    for height in HEIGHTS:
        level = np.abs(rows - (base[gate] - height * high)) <= max(BAND * high, 1.0)
        band = level & strip & under
        enough = (band & changed).sum() >= max(LEAST_CHANGED * band.sum(), 1)
        passed.append(seeds(band & changed if enough else np.zeros_like(band)))
    thick = (columns >= gate) & (base - surface > LAYER * high)
    filled = seeds(under & changed & thick)
    foot = under & strip & (rows > base[gate] - FOOT * high)
    column = changed & (rows < surface - RIM_PX) & (rows < base[gate] - high / 2)
    ends = np.flatnonzero(column.any(axis=0) & (columns < gate + strip.sum()))
    late = gate - ends.max(initial=0) > STRIP * high or (
        foot.any() and changed[foot].mean() < MOST_BEFORE
    )
    return Filmed(collapse(t_s, filled, np.array(passed).T, bool(late)), arrived)


def _lines(
    found: Repose, factor: int, top_px: int, wide: int
) -> tuple[np.ndarray, np.ndarray]:
    """Rows of surface and base line over each column of the small pictures; the base
    line's where no surface is seen."""
    columns = (np.arange(wide) + 0.5) * factor - 0.5 - found.roi[0]
    base = found.base.at(columns)
    surface = np.interp(columns, np.arange(found.surface.size), found.surface)
    surface = np.where(np.isfinite(surface), surface, base)
    above = top_px + found.roi[1] + 0.5
    return (surface + above) / factor - 0.5, (base + above) / factor - 0.5


def _column(changed, under, above) -> tuple[int, float]:
    """The column where the gate stood, and the row of the seeds' top behind it: from
    there outwards what is under the surface changed, behind it not."""
    count = under.sum(axis=0)
    share = (changed & under).sum(axis=0) / np.maximum(count, 1)
    score = np.cumsum(np.where(count > RIM_PX, share - 0.5, 0.0))
    gate = int(np.argmin(score)) + 1
    behind, beyond = share[:gate][count[:gate] > 0], share[gate:][count[gate:] > 0]
    told = len(behind) and len(beyond) and beyond.mean() - behind.mean()
    if not told > LEAST_CONTRAST:
        raise MeasurementError(tr("no seeds run out from behind a gate in this film"))
    emptied = (changed & above)[:, gate // 2 : gate]
    there = emptied.any(axis=0)
    require(there.any(), tr("no seeds sink behind the gate in this film"))
    return gate, float(np.median(emptied.argmax(axis=0)[there]))


def _arrived(t_s: np.ndarray, grey: np.ndarray, changed: np.ndarray) -> np.ndarray:
    """When each pixel that changed was half changed for good, NaN elsewhere."""
    middle, up = grey[[0, -1]].mean(axis=0), grey[-1] > grey[0]
    last = np.zeros(changed.shape, int)
    for k, picture in enumerate(grey):
        last[(picture > middle) != up] = k
    return np.where(changed, t_s[np.minimum(last + 1, len(t_s) - 1)], np.nan)
