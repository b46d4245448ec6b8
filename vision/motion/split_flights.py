"""Cuts a track into drops where the seed is lifted and let go again, a drop into
flights at its lowest points, and finds which of them are free flights."""

import itertools

import numpy as np
from scipy.ndimage import median_filter
from scipy.signal import find_peaks

from benchtwin.bench.language import tr
from benchtwin.vision.measurement import require
from benchtwin.vision.motion.outliers import despiked

# sds of the noise by which a lowest point stands out: slow noise wanders over ± 3 of
# its own
LOW_SD = 8.0
SCATTER = 6.0  # times the scatter of the first two flights: no parabola
# of the track's height: contacts are no farther above its lowest place, however the
# seed lies
PLATE_SHARE = 0.15
# of the track's height, by which an apex lies above the one before where a hand lifted
# the seed: a spinning seed's rebounds rise by a tenth at most
LIFTED = 0.3
# of the track's height, by which what was thrown rises in a track without an impact: a
# hand that holds still moves by less
THROWN = 0.05


def releases(height: np.ndarray) -> list[slice]:
    """Rows of each drop of a track, in which the seed may be let go several times:
    after an impact it never rises above where it came from, unless it is lifted. A lift
    that no fall follows begins no drop."""
    smooth = despiked(height)
    reach, floor = float(np.ptp(smooth)), float(smooth.min())
    whole = [slice(0, len(height))]
    if reach <= 0:
        return whole
    least = max(0.002 * reach, min(LOW_SD * _scatter(smooth), 0.03 * reach))
    lows = [k for k in _lows(smooth, least) if smooth[k] < floor + PLATE_SHARE * reach]
    edges = [0, *lows, len(smooth) - 1]
    tops = [a + int(np.argmax(smooth[a : b + 1])) for a, b in itertools.pairwise(edges)]
    cuts = [0]
    for (one, other), low in zip(itertools.pairwise(tops), lows):
        fell = smooth[cuts[-1] : low].max(initial=floor) - smooth[low] > LIFTED * reach
        lifted = smooth[other] - smooth[one] > LIFTED * reach
        falls_again = smooth[other] - smooth[other:].min() > LIFTED * reach
        if fell and lifted and falls_again:
            resting = smooth[low:other] < smooth[low] + 0.05 * reach
            cuts.append(low + int(np.flatnonzero(resting)[-1]) + 1)
    return [slice(a, b) for a, b in itertools.pairwise([*cuts, len(height)])]


def splits(height: np.ndarray) -> list[list[tuple[int, int]]]:
    """Row ranges [start, stop) of the flights between contacts, without the rests at
    both ends: one list for each moment at which the seed may have been let go, the
    earliest first. Lowest points near the plate are contacts; any lowest point may be
    the last at which a hand, or a slip of the tracker, moved the place."""
    smooth = despiked(height)
    reach = float(np.ptp(smooth))
    require(reach > 0, tr("nothing falls: the height never changes"))
    # At a phone's frame rate every stretch contains contacts, which are no noise: hence
    # at most 3 % of the fall.
    lows = _lows(
        smooth, max(0.002 * reach, min(LOW_SD * _scatter(smooth), 0.03 * reach))
    )
    step = np.abs(np.diff(smooth, append=smooth[-1]))
    plate = smooth.min() + PLATE_SHARE * reach
    contacts = [
        low
        for low in lows
        if smooth[low] <= plate + step[max(low - 2, 0) : low + 2].max()
    ]
    return [
        _behind(smooth, begin, [low for low in contacts if low > begin])
        for begin in [0, *lows]
    ]


def _behind(
    smooth: np.ndarray, begin: int, contacts: list[int]
) -> list[tuple[int, int]]:
    """The ranges if the seed was let go behind row `begin`. The first starts where the
    seed has left its rest: 1 % of the fall below the highest place; of one that was
    thrown, and rose, with the track."""
    top = begin + int(np.argmax(smooth[begin:]))
    first = contacts[0] if contacts else top + int(np.argmin(smooth[top:]))
    before, reach = smooth[begin : first + 1], float(np.ptp(smooth))
    fall = before.max() - before[-1]
    thrown = not contacts and before.max() - before[0] > THROWN * reach
    start = begin
    if fall > 0.02 * reach and not thrown:
        still = np.flatnonzero(before > before.max() - 0.01 * fall)
        start += min(int(still[-1]) + 1, max(first - begin - 3, 0))
    ends = [start, *[low for low in contacts if low > start]]
    ranges = list(zip(ends[:-1], [e + 1 for e in ends[1:]]))
    return [*ranges, (ends[-1], _end_of_last(smooth, ends[-1], bool(contacts)))]


def _lows(height: np.ndarray, least: float) -> list[int]:
    """Rows of the minima that are `least` deep in the running median over a hundredth
    of the track, which outliers do not move."""
    width = min(len(height) // 100, 15) | 1
    near = find_peaks(-median_filter(height, width, mode="nearest"), prominence=least)[
        0
    ]
    spans = [
        range(max(low - width // 2, 0), min(low + width // 2 + 1, len(height)))
        for low in near
    ]
    return [min(span, key=height.__getitem__) for span in spans]


def _scatter(height: np.ndarray) -> float:
    """sd of the rows about parabolas through short stretches: their 15th percentile,
    since many contain a contact."""
    size = max(9, len(height) // 32)
    if len(height) < size:
        return 0.0
    stretches = height[: len(height) // size * size].reshape(-1, size)
    basis = np.linalg.qr(np.vander(np.linspace(-1, 1, size), 3))[0]
    left = stretches - stretches @ basis @ basis.T
    return float(np.sqrt(np.quantile((left**2).sum(1) / (size - 3), 0.15)))


def _end_of_last(height: np.ndarray, start: int, after_contact: bool) -> int:
    """Where the last flight ends: back at the level it left from, at rest, or with the
    track."""
    tail = height[start:]
    apex = int(np.argmax(tail))
    if not after_contact:
        fall = tail[apex:]
        falls = fall > fall.min() + 0.005 * np.ptp(tail)
        return start + apex + int(np.argmin(falls)) + 1 if falls[0] else len(height)
    level = tail[0] + 0.05 * (tail[apex] - tail[0])
    low = np.flatnonzero(tail[apex:] < level)
    return start + apex + int(low[0]) + 1 if len(low) else len(height)


def free_flights(
    rows: tuple[np.ndarray, ...],
    height: np.ndarray,
    residual: np.ndarray,
    contact_states: list[tuple[float, float]],
    step_s: float,
) -> int:
    """Number of flights that are free: up to the first (after two) that is no parabola
    of their common acceleration, or ends in mid-air. Rocking, rolling and leaving the
    picture make minima of the height as well. contact_states: height and speed at each
    contact."""
    return min(
        _scattering_alike(rows, residual),
        _at_plate(contact_states, height, step_s),
    )


def _scattering_alike(rows, residual: np.ndarray) -> int:
    """Number of flights up to the first (after two) that scatters SCATTER times as much
    as the first two."""
    parts = np.split(residual, np.cumsum([len(r) for r in rows])[:-1])
    scatter = [float(np.sqrt(np.median(p**2))) for p in parts]
    typical = max(scatter[:2])
    return next(
        (k for k in range(2, len(rows)) if scatter[k] > SCATTER * typical), len(rows)
    )


def _at_plate(
    contact_states: list[tuple[float, float]], height: np.ndarray, step_s: float
) -> int:
    """Number of flights up to the first contact that is not at the plate: there the
    seed had left the picture."""
    plate, reach = np.quantile(height, 0.01), np.ptp(height)
    off = [
        abs(h - plate) > PLATE_SHARE * reach + step_s * abs(v)
        for h, v in contact_states
    ]
    return off.index(True) + 1 if any(off) else len(contact_states) + 1
