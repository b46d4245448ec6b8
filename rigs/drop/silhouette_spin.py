"""Spin of a seed from its silhouette's rotation.

A silhouette rotates as its seed only where the seed spins about the line of sight.
Otherwise it rotates unevenly, and its mean rate is the spin about the line of sight
plus an error of the size of that unevenness (free ellipsoids in any attitude: DOUBT).
"""

from dataclasses import dataclass

import numpy as np

from benchtwin.bench.robust import difference_noise

QUARTERS = 4
WINDOWS = (0, 1, 2, 4, 8, 16, 32, 64, 128)  # half widths, in rows
CONSISTENT = 2.5  # sds within which longer windows must agree with shorter ones
# variance of rate less spin, over that of the rate from quarter to quarter: 0.4 to 1.5,
# by shape and turns
DOUBT = 2 / 3
LEAST_TRUST = 0.2  # part of the rates' variance that is the spins' at least


@dataclass(frozen=True)
class SilhouetteRotation:
    """Rotation in one flight."""

    angle: np.ndarray  # (n,) [rad], smoothed
    rate: float  # [rad/s]
    white: float  # variance of the rate by noise of the angle
    uneven: float  # from quarter to quarter, beyond that
    span_s: float


def silhouette_rotation(
    angle_deg: np.ndarray | None, rows: np.ndarray, time: np.ndarray
) -> SilhouetteRotation:
    """Of `rows` of a track; no rotation where fewer than five angles were seen."""
    angles = np.full(len(rows), np.nan) if angle_deg is None else angle_deg[rows]
    seen = np.isfinite(angles)
    if seen.sum() < 5:
        return SilhouetteRotation(
            np.zeros(len(rows)), 0.0, 0.0, 0.0, float(np.ptp(time))
        )
    late, angle = time[seen] - time[0], np.radians(angles[seen])
    quarters = zip(
        np.array_split(late, QUARTERS), np.array_split(angle, QUARTERS), strict=True
    )
    rates = [np.polyfit(t, a, 1)[0] for t, a in quarters if len(t) > QUARTERS]
    white = (
        12 * noise_of(angle) ** 2 / (len(late) * np.ptp(late) ** 2)
    )  # of the slope, by white noise
    uneven = (
        float(np.var(rates, ddof=1)) - QUARTERS**3 * white
        if len(rates) == QUARTERS
        else 0.0
    )
    whole = np.interp(time - time[0], late, smoothed(angle))
    return SilhouetteRotation(
        whole, float(np.polyfit(late, angle, 1)[0]), white, uneven, float(np.ptp(time))
    )


def spin_calibration(found: list[SilhouetteRotation]) -> tuple[np.ndarray, np.ndarray]:
    """Share (F,) of each rate that counts as spin, and sd (F,) [rad/s] of spin less
    rate.

    Half by the unevenness of all flights, half by each one's own. Spin given the rate
    is normal about share · rate with sd √share · sd (Carroll et al. 2006, Measurement
    Error in Nonlinear Models, ch. 4)."""
    rate, white, uneven, weight = (
        np.array([getattr(t, key) for t in found])
        for key in ("rate", "white", "uneven", "span_s")
    )
    weight = weight / max(weight.sum(), 1e-300)
    turned = float(weight @ np.maximum(rate**2 - white, 0.0))
    doubt = min(DOUBT * max(float(weight @ uneven), 0.0), (1 - LEAST_TRUST) * turned)
    own = white + (doubt + DOUBT * np.maximum(uneven, 0.0)) / 2
    spins = turned - doubt
    return spins / np.maximum(spins + own, 1e-300), np.sqrt(own)


def smoothed(angle: np.ndarray) -> np.ndarray:
    """Straight lines over as many rows as agree (Goldenshluger & Nemirovski 1997)."""
    sd = noise_of(angle)
    best, low, high = angle.copy(), angle - CONSISTENT * sd, angle + CONSISTENT * sd
    open_ = np.full(len(angle), sd > 0)
    for reach in (w for w in WINDOWS if 0 < w < len(angle) // 2):
        value, spread = _lines(angle, reach)
        low, high = (
            np.maximum(low, value - CONSISTENT * sd * spread),
            np.minimum(high, value + CONSISTENT * sd * spread),
        )
        open_ &= low <= high
        best[open_] = value[open_]
    return best


def _lines(angle: np.ndarray, reach: int) -> tuple[np.ndarray, np.ndarray]:
    """Value (n,) at each row of the line through its neighbours, and its sd for unit
    noise."""
    at = np.arange(len(angle), dtype=float)
    first, stop = (
        np.maximum(at - reach, 0).astype(int),
        np.minimum(at + reach + 1, len(at)).astype(int),
    )

    def total(values: np.ndarray) -> np.ndarray:
        whole = np.concatenate([[0.0], np.cumsum(values)])
        return whole[stop] - whole[first]

    count, middle = total(np.ones_like(at)), total(at) / (stop - first)
    width = total(at**2) - count * middle**2
    mean = total(angle) / count
    slope = (total(at * angle) - count * middle * mean) / width
    return mean + slope * (at - middle), np.sqrt(1 / count + (at - middle) ** 2 / width)


def noise_of(angle: np.ndarray) -> float:
    """sd [rad] of the angle's white noise, robust, from second differences."""
    return difference_noise(angle, 2) if len(angle) > 2 else 0.0
