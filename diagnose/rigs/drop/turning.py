"""How a seed turns, as its silhouette shows it: the angle row by row, the mean rate, and what that rate says of the spin.

A silhouette turns as its seed does only where the seed turns about the line of sight. Else it turns unevenly, and its mean rate
is the spin about the line of sight plus an error of the size of that unevenness (free ellipsoids in any attitude: DOUBT below).
"""

from dataclasses import dataclass

import numpy as np

QUARTERS = 4
WINDOWS = (0, 1, 2, 4, 8, 16, 32, 64, 128)  # rows to either side of the one asked about
CONSISTENT = 2.5  # sd within which means over longer windows must agree with those over shorter ones
DOUBT = 2 / 3  # variance of rate less spin, over that of the rate from quarter to quarter: 0.4 to 1.5, by shape and turns
LEAST_TRUST = 0.2  # part of the rates' variance that is the spins' at least


@dataclass(frozen=True)
class Turning:
    """One flight: angle (n,) [rad], smoothed; rate [rad/s] at which it turned; white: variance of the rate by the angle's noise;
    uneven: variance of the rate from quarter to quarter beyond that noise, may be negative; span_s."""

    angle: np.ndarray
    rate: float
    white: float
    uneven: float
    span_s: float


def turning(angle_deg: np.ndarray | None, rows: np.ndarray, time: np.ndarray) -> Turning:
    """Of `rows` of a track, at `time` (n,) [s]; nothing turns where fewer than five angles were seen."""
    angles = np.full(len(rows), np.nan) if angle_deg is None else angle_deg[rows]
    seen = np.isfinite(angles)
    if seen.sum() < 5:
        return Turning(np.zeros(len(rows)), 0.0, 0.0, 0.0, float(np.ptp(time)))
    late, angle = time[seen] - time[0], np.radians(angles[seen])
    quarters = zip(np.array_split(late, QUARTERS), np.array_split(angle, QUARTERS), strict=True)
    rates = [np.polyfit(t, a, 1)[0] for t, a in quarters if len(t) > QUARTERS]
    white = 12 * noise_of(angle) ** 2 / (len(late) * np.ptp(late) ** 2)  # variance of the slope of all that noise alone makes
    uneven = float(np.var(rates, ddof=1)) - QUARTERS**3 * white if len(rates) == QUARTERS else 0.0
    whole = np.interp(time - time[0], late, smoothed(angle))
    return Turning(whole, float(np.polyfit(late, angle, 1)[0]), white, uneven, float(np.ptp(time)))


def trusted(found: list[Turning]) -> tuple[np.ndarray, np.ndarray]:
    """How far each flight's rate is to be trusted as its spin, share (F,) of it, and the sd (F,) [rad/s] of spin less rate.

    Both by the unevenness of the session's flights, of each by half its own: one that turns little shows little of it. Spin given
    the rate is normal about share · rate with sd √(share) sd (regression calibration: Carroll et al. 2006, Measurement Error in
    Nonlinear Models, ch. 4), a spin of unbiased sign and size: an effect in proportion to the spin is else found too small.
    """
    rate, white, uneven, weight = (np.array([getattr(t, key) for t in found]) for key in ("rate", "white", "uneven", "span_s"))
    weight = weight / max(weight.sum(), 1e-300)
    turned = float(weight @ np.maximum(rate**2 - white, 0.0))
    doubt = min(DOUBT * max(float(weight @ uneven), 0.0), (1 - LEAST_TRUST) * turned)
    own = white + (doubt + DOUBT * np.maximum(uneven, 0.0)) / 2
    spins = turned - doubt
    return spins / np.maximum(spins + own, 1e-300), np.sqrt(own)


def smoothed(angle: np.ndarray) -> np.ndarray:
    """(n,) by straight lines over as many neighbouring rows as agree with all shorter windows within the noise: long ones while a
    silhouette turns evenly, none where it whirls. A noisy angle makes a ripple of two a turn too small.

    Goldenshluger, Nemirovski (1997), Math. Methods Statist. 6, 135.
    """
    sd = noise_of(angle)
    best, low, high = angle.copy(), angle - CONSISTENT * sd, angle + CONSISTENT * sd
    open_ = np.full(len(angle), sd > 0)
    for reach in (w for w in WINDOWS if 0 < w < len(angle) // 2):
        value, spread = _lines(angle, reach)
        low, high = (np.maximum(low, value - CONSISTENT * sd * spread), np.minimum(high, value + CONSISTENT * sd * spread))
        open_ &= low <= high
        best[open_] = value[open_]
    return best


def _lines(angle: np.ndarray, reach: int) -> tuple[np.ndarray, np.ndarray]:
    """Value (n,) at each row of the line through its neighbours, and its sd for noise of sd 1."""
    at = np.arange(len(angle), dtype=float)
    first, stop = np.maximum(at - reach, 0).astype(int), np.minimum(at + reach + 1, len(at)).astype(int)

    def total(values: np.ndarray) -> np.ndarray:
        whole = np.concatenate([[0.0], np.cumsum(values)])
        return whole[stop] - whole[first]

    count, middle = total(np.ones_like(at)), total(at) / (stop - first)
    width = total(at**2) - count * middle**2
    mean = total(angle) / count
    slope = (total(at * angle) - count * middle * mean) / width
    return mean + slope * (at - middle), np.sqrt(1 / count + (at - middle) ** 2 / width)


def noise_of(angle: np.ndarray) -> float:
    """sd [rad] of the angle's white noise: second differences, whose few large ones are the seed's own."""
    return 1.4826 * float(np.median(np.abs(np.diff(angle, 2)))) / np.sqrt(6) if len(angle) > 2 else 0.0
