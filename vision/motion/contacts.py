"""Where a track is cut into flights: at its lowest points, where they stand out, without the rests at both ends."""

import numpy as np
from scipy.ndimage import median_filter
from scipy.signal import find_peaks

from vision.measurement import MeasurementError
from vision.motion.strays import despiked

LOW_SD = 8.0  # sds of the noise by which a lowest point stands out: noise that is slow wanders over ± 3 of its own


def split(height: np.ndarray) -> list[tuple[int, int]]:
    """Row ranges [start, stop) of the flights: between lowest points that stand out, without the rests at both ends."""
    smooth = despiked(height)
    reach = float(np.ptp(smooth))
    if reach <= 0:
        raise MeasurementError("nothing falls: the height never changes")
    # At a phone's frame rate a stretch holds contacts, which are no noise: hence no more than 3 % of the fall.
    lows = _lows(smooth, max(0.002 * reach, min(LOW_SD * _scatter(smooth), 0.03 * reach)))
    # The first flight starts where the seed has left its rest: 1 % of the fall below the highest place.
    first_low = lows[0] if lows else int(np.argmin(smooth))
    before = smooth[: first_low + 1]
    fall = before.max() - before[-1]
    still = np.flatnonzero(before > before.max() - 0.01 * fall)
    start = 0 if fall < 0.02 * reach else min(int(still[-1]) + 1, max(first_low - 3, 0))
    ends = [start, *[low for low in lows if low > start]]
    ranges = list(zip(ends[:-1], [e + 1 for e in ends[1:]]))
    return [*ranges, (ends[-1], _end_of_last(smooth, ends[-1], bool(lows)))]


def _lows(height: np.ndarray, least: float) -> list[int]:
    """Lowest rows where a median over a hundredth of the track, which few stray rows cannot lower, has a low `least` deep."""
    width = min(len(height) // 100, 15) | 1
    near = find_peaks(-median_filter(height, width, mode="nearest"), prominence=least)[0]
    spans = [range(max(low - width // 2, 0), min(low + width // 2 + 1, len(height))) for low in near]
    return [min(span, key=height.__getitem__) for span in spans]


def _scatter(height: np.ndarray) -> float:
    """sd of the rows about parabolas through short stretches, of the quietest sixth: many hold a contact. Slow noise is in it."""
    size = max(9, len(height) // 32)
    if len(height) < size:
        return 0.0
    stretches = height[: len(height) // size * size].reshape(-1, size)
    basis = np.linalg.qr(np.vander(np.linspace(-1, 1, size), 3))[0]
    left = stretches - stretches @ basis @ basis.T
    return float(np.sqrt(np.quantile((left**2).sum(1) / (size - 3), 0.15)))


def _end_of_last(height: np.ndarray, start: int, after_contact: bool) -> int:
    """Where the last flight ends: back at the level it left from, at rest, or with the track."""
    tail = height[start:]
    if not after_contact:
        return start + int(np.argmin(tail > tail.min() + 0.005 * np.ptp(tail))) + 1 if np.ptp(tail) > 0 else len(height)
    apex = int(np.argmax(tail))
    level = tail[0] + 0.05 * (tail[apex] - tail[0])
    low = np.flatnonzero(tail[apex:] < level)
    return start + apex + int(low[0]) + 1 if len(low) else len(height)
