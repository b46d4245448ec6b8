"""Outliers in a track: single rows off their neighbours, leaps to another object, rows
off a smooth curve."""

import numpy as np
from numpy.polynomial import legendre
from scipy.ndimage import maximum_filter1d, median_filter

from benchtwin.bench.robust import robust_sd

LEAST_ROWS = 15
# a row this many robust sds off its flight is an outlier: 2e-9 by chance, so none among
# 5,000 true rows
ALIKE_SDS = 4.0  # by which two rows of one place differ at most
SPIKE_SD = 6.0
SMOOTH = 6  # degree of the curve through a flight
# in typical steps; of the extent; in typical steps
LEAP = 5.0
LEAST_LEAP = 0.1
RETURN = 2.5
WINDOW, MOST_SLIPPED = 13, 12  # rows
STILL = 0.01  # of the extent: rows so near the first are those of a seed that is held
MOST_OUTLIERS = 0.05  # of a flight's rows; more are no outliers but its path


def despiked(height: np.ndarray) -> np.ndarray:
    """The heights with single rows far off their neighbours replaced, so that a spike
    is no contact."""
    middle, off, limit = _off_neighbours(height)
    return np.where(off > limit, middle, height)


def single_spikes(height: np.ndarray) -> np.ndarray:
    """Mask of single rows farther off both neighbours than a bouncing seed can move."""
    spikes = np.zeros(len(height), dtype=bool)
    _, off, limit = _off_neighbours(height)
    before, after = height[1:-1] - height[:-2], height[1:-1] - height[2:]
    nearer = np.minimum(np.abs(before), np.abs(after))
    spikes[1:-1] = (
        (off[1:-1] > limit[1:-1]) & (before * after > 0) & (nearer > limit[1:-1])
    )
    return spikes


def slips(frame: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Mask (n,) of the rows in which a tracker held another object: it leaps away, and
    back to where the seed can be by then. A leap is longer than LEAP typical steps
    (median of WINDOW steps about it) and a tenth of the extent; the step from before to
    after is no leap. At most MOST_SLIPPED rows at a time."""
    slipped = np.zeros(len(frame), dtype=bool)
    if len(frame) < LEAST_ROWS:
        return slipped
    rate = np.hypot(np.diff(x), np.diff(y)) / np.maximum(np.diff(frame), 1)
    typical = median_filter(rate, WINDOW, mode="nearest")
    extent = max(np.ptp(np.percentile(x, [5, 95])), np.ptp(np.percentile(y, [5, 95])))
    leap = (rate > LEAP * typical) & (rate > LEAST_LEAP * extent)
    after = 0
    for away in np.flatnonzero(leap):  # from row `away` to the next
        near = leap[away + 1 : away + 1 + MOST_SLIPPED]
        backs = [b for b in np.flatnonzero(near) + away + 1 if away >= after]
        for back in backs:
            between = np.hypot(x[back + 1] - x[away], y[back + 1] - y[away]) / (
                frame[back + 1] - frame[away]
            )
            if between <= max(
                RETURN * max(typical[away], typical[back]), 1e-9 * extent
            ):
                slipped[away + 1 : back + 1] = True
                after = back + 1
                break
    return slipped


def off_curve(time: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Mask (n,) of the rows of one flight that lie SPIKE_SD robust sds off a smooth
    curve."""
    left = curve_residuals(time, place)
    stray = np.abs(left) > SPIKE_SD * robust_sd(left) + 1e-12
    return stray if stray.mean() <= MOST_OUTLIERS else np.zeros(len(time), dtype=bool)


def curve_residuals(time: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Residuals (n,) of one flight about a polynomial, fitted twice, the second time
    without outliers."""
    basis = legendre.legvander(
        2 * (time - time[0]) / max(np.ptp(time), 1e-12) - 1,
        min(SMOOTH, len(time) // 10),
    )
    kept = np.ones(len(time), dtype=bool)
    for _ in range(2):
        left = place - basis @ np.linalg.lstsq(basis[kept], place[kept], rcond=None)[0]
        kept = np.abs(left) <= SPIKE_SD * robust_sd(left) + 1e-12
    return left


def rows_at_rest(place: np.ndarray, sd: float = 0.0) -> int:
    """Rows at the start that are within STILL of the extent of the first, or within
    what two rows of that sd may differ by; all where nothing moves; 0 for one alone."""
    near = max(STILL * float(np.ptp(place)), ALIKE_SDS * sd)
    still = np.abs(place - place[0]) < near
    count = len(place) if still.all() else int(np.argmin(still))
    return count if count > 1 else 0


def _off_neighbours(height: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Running median, distance of each row from it, and its limit: twice the greatest
    step nearby, or ten times the noise; of few rows none."""
    middle = median_filter(height, 7, mode="nearest")
    off = np.abs(height - middle)
    steps = np.abs(
        np.diff(median_filter(height, 3, mode="nearest"), append=height[-1:])
    )  # single rows off are not in it
    moving = 2.0 * maximum_filter1d(steps, 9, mode="nearest")
    few = np.inf if len(height) < LEAST_ROWS else 0.0
    return (middle, off, np.maximum(10 * float(np.median(off)), moving + few))
