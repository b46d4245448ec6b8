"""Noise of a track, estimated from the recording itself: white plus Ornstein–Uhlenbeck
(OU) noise.

    n_t = o_t + w_t,   var o = (1 − white) σ²,   var w = white σ²,
    cov(o_t, o_s) = (1 − white) σ² ρ^|t−s|

t, s are frame numbers, so lost frames need no filling in. ρ and the white share
maximise the restricted likelihood (REML; Patterson & Thompson 1971, Biometrika 58, 545)
about a flexible curve, so that missing physics is not taken for noise. The curve
absorbs slow noise, so a correlation longer than an eighth of a flight, or a third of a
rest, is not considered; of two descriptions that fit alike the one with less power at
low frequency is taken. Whitening is by the innovations of a Kalman filter, exact with
gaps."""

import itertools
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.optimize import minimize

from benchtwin.bench.robust import robust_sd

CELLS = 8  # correlation lengths that a stretch must hold: the curve absorbs longer ones
CELLS_AT_REST = 3  # the same beside a constant
COARSE = [
    (0.0, 0.0),
    *itertools.product((0.3, 0.6, 0.8, 0.9, 0.95, 0.98), (0.0, 0.4, 0.8)),
]
LEAST_ROWS = 40  # of a stretch that tells a correlation
FARTHEST = 6.0  # logit beyond which a share counts as 0 or 1
PRIOR_SD = 1.8  # of either logit
WIDEST_STEP = 0.4  # of a logit, for the likelihood's curvature
# sd of either wave of pixel lock: hundredths of a pixel (slide/session.py)
LOCK_PX = 0.03
AXES = ((1, 0), (-1, 0), (0, 1), (0, -1))
OUTLIER_SD = 6.0  # robust sds; 2e-9 by chance
ALIKE = 1e-2  # of the greatest: slopes that say the same
ENOUGH_FREEDOM = 10  # degrees of freedom that tell a recording's own σ


@dataclass(frozen=True)
class Noise:
    """White plus Ornstein–Uhlenbeck noise."""

    rho: float  # correlation of the OU part from frame to frame
    white: float  # white share of the variance
    log_level_sd: float  # sd of the logarithm of the noise power at low frequency

    @property
    def low_frequency(self) -> float:
        """Noise power at zero frequency over σ²: white + (1 − white)(1 + ρ)/(1 − ρ)."""
        return self.white + (1 - self.white) * (1 + self.rho) / (1 - self.rho)

    def whiten(self, rows: np.ndarray, lag: np.ndarray) -> np.ndarray:
        """Rows (n, p) of one series at lags (n,) with this noise of variance 1 made
        independent."""
        return whiten(rows[:, None, :], lag[:, None], self.rho, self.white)[0][:, 0]


@dataclass(frozen=True)
class Stretch:
    """One uninterrupted flight along one axis: data (n,) = design (n, p) θ + noise."""

    design: np.ndarray
    data: np.ndarray
    lag: np.ndarray  # (n,) frames since the row before, inf for the first

    def residual(self, noise: Noise) -> tuple[np.ndarray, int]:
        """Whitened residual (n,) about the design, and its degrees of freedom."""
        clean = noise.whiten(np.column_stack([self.design, self.data]), self.lag)
        solution, _, rank, _ = np.linalg.lstsq(clean[:, :-1], clean[:, -1], rcond=1e-10)
        return clean[:, -1] - clean[:, :-1] @ solution, len(clean) - int(rank)


def about_slopes(slopes: np.ndarray, left: np.ndarray, lag: np.ndarray) -> Stretch:
    """Residuals (n,) of a fit beside what its slopes (n, p) can still take."""
    size = np.linalg.norm(slopes, axis=0)
    basis, share, _ = np.linalg.svd(slopes[:, size > 0] / size[size > 0], False)
    return Stretch(basis[:, share > ALIKE * share[0]], left, lag)


def spreads(
    stretches: list[Stretch], owner: Iterable[int], count: int, noise: Noise
) -> np.ndarray:
    """σ (count,) of each recording, that of all where fewer than ENOUGH_FREEDOM tell
    it."""
    power, freedom = np.zeros(count), np.zeros(count)
    for r, stretch in zip(owner, stretches, strict=True):
        left, spare = stretch.residual(noise)
        power[r] += left @ left
        freedom[r] += spare
    pooled = np.sqrt(power.sum() / max(freedom.sum(), 1))
    own = np.sqrt(power / np.maximum(freedom, 1))
    return np.where(freedom >= ENOUGH_FREEDOM, own, pooled)


def refined_level_sd(level_sd: float, freedom: int) -> float:
    """`level_sd` once that many further degrees of freedom tell the noise power."""
    return float(np.sqrt(2 / (2 / max(level_sd, 1e-6) ** 2 + freedom)))


def frame_lag(frame: np.ndarray) -> np.ndarray:
    """Frames since the row before (n,); inf for the first row."""
    return np.concatenate([[np.inf], np.maximum(np.diff(frame), 1e-9)]).astype(float)


def whiten(
    rows: np.ndarray, lag: np.ndarray, rho: float, white: float
) -> tuple[np.ndarray, np.ndarray]:
    """Rows (n, s, p) of s series with noise of variance 1, made independent with
    variance 1.

    lag (n, s): frames since the row before, inf where a stretch begins. Returns the
    rows and ln of the innovation variance (n, s)."""
    carried = np.where(
        np.isfinite(lag), rho ** np.where(np.isfinite(lag), lag, 0.0), 0.0
    )
    return _innovations(np.ascontiguousarray(rows, float), carried, float(white))


@njit(cache=True)
def _innovations(
    rows: np.ndarray, carried: np.ndarray, white: float
) -> tuple[np.ndarray, np.ndarray]:
    """Kalman filter: innovations over their sd, ln of their variance."""
    n, series, columns = rows.shape
    out, log_variance = np.empty_like(rows), np.empty((n, series))
    for j in range(series):
        state, left = np.zeros(columns), 0.0
        for i in range(n):
            c = carried[i, j]
            before = c * c * left + (1 - white) * (1 - c * c)
            variance = before + white
            gain = before / variance
            left = before * (1 - gain)
            log_variance[i, j] = np.log(variance)
            scale = 1 / np.sqrt(variance)
            for k in range(columns):
                innovation = rows[i, j, k] - c * state[k]
                state[k] = c * state[k] + gain * innovation
                out[i, j, k] = scale * innovation
    return out, log_variance


def estimate(stretches: list[Stretch]) -> Noise:
    """ρ and white share common to all stretches, by REML; white if all are too
    short."""
    usable = [
        s for s in stretches if len(s.data) >= max(LEAST_ROWS, 3 * s.design.shape[1])
    ]
    if not usable:
        return Noise(0.0, 0.0, 1.0)
    packed = _pack(usable)
    at_rest = [s for s in usable if s.design.shape[1] == 1]
    longest = _usual_length(usable) / CELLS  # correlation that these stretches can tell
    if at_rest:
        longest = max(longest, _usual_length(at_rest) / CELLS_AT_REST)
    highest = max(1 - 1 / longest, 0.5)

    def loss(rho: float, white: float) -> float:
        return _loss(packed, rho, white)[0] + np.log(
            Noise(rho, white, 0.0).low_frequency
        )

    grid = [theta for theta in COARSE if theta[0] < highest]
    start = min(grid, key=lambda theta: loss(*theta))
    rho, white = start if start[0] else (0.2, 0.2)
    shares = np.clip([rho / highest, white], 0.02, 0.98)
    begin = np.log(shares / (1 - shares))
    found = minimize(
        lambda u: loss(*_from_logits(u, highest)),
        begin,
        method="Nelder-Mead",
        options={
            "xatol": 0.03,
            "fatol": 0.02,
            "maxfev": 40,
            "initial_simplex": begin + 0.7 * np.array([[0, 0], [1, 0], [0, 1]]),
        },
    )
    rho, white = _from_logits(found.x, highest)
    if loss(0.0, 0.0) <= found.fun:
        spare = sum(len(s.data) - s.design.shape[1] for s in usable)
        return Noise(0.0, 0.0, float(np.sqrt(2 / spare)))
    return Noise(rho, white, _log_level_sd(packed, found.x, highest))


def _usual_length(stretches: list[Stretch]) -> float:
    """Rows of the stretch that holds the middle one of all rows."""
    lengths = np.sort([len(s.data) for s in stretches])
    return float(lengths[np.searchsorted(np.cumsum(lengths), lengths.sum() / 2)])


def _from_logits(u: np.ndarray, highest: float) -> tuple[float, float]:
    rho, white = 1 / (1 + np.exp(-np.clip(u, -12, 12)))
    return float(rho * highest), float(white)


def _pack(stretches: list[Stretch]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows (n, s, p + 1) padded with zeros, lags (n, s), number of true rows (s,)."""
    count = np.array([len(s.data) for s in stretches])
    p = max(s.design.shape[1] for s in stretches)
    n = count.max()
    rows, lag = np.zeros((n, len(count), p + 1)), np.full((n, len(count)), np.inf)
    for j, (s, m) in enumerate(zip(stretches, count, strict=True)):
        rows[:m, j, : s.design.shape[1]] = s.design
        rows[:m, j, p] = s.data
        lag[:m, j] = s.lag
    return rows, lag, count


def _loss(packed, rho: float, white: float) -> tuple[float, float]:
    """−2 ln of the restricted likelihood, σ of each stretch profiled out, and the mean
    of ln σ²."""
    rows, lag, count = packed
    clean, log_variance = whiten(rows, lag, rho, white)
    there = np.arange(len(rows))[:, None] < count
    p = rows.shape[2] - 1
    columns = np.moveaxis(clean, 1, 0)
    gram = np.swapaxes(columns, 1, 2) @ columns
    design = gram[:, :p, :p]
    scale = np.sqrt(np.maximum(np.einsum("sii->si", design), 1e-300))
    scale[scale < 1e-100] = 1.0
    design = design / scale[:, :, None] / scale[:, None, :]
    values, vectors = np.linalg.eigh(design)
    kept = values > 1e-10
    seen = np.einsum("sij,si->sj", vectors, gram[:, :p, p] / scale) ** 2 / np.where(
        kept, values, np.inf
    )
    freedom = count - kept.sum(1)
    left = np.maximum(gram[:, p, p] - seen.sum(1), 1e-14 * gram[:, p, p] + 1e-300)
    determinant = (
        np.log(np.where(kept, values, 1.0)).sum(1) + 2 * np.log(scale).sum(1)
    ).sum()
    loss = (freedom * np.log(left)).sum() + (log_variance * there).sum() + determinant
    return float(loss), float(np.average(np.log(left / freedom), weights=freedom))


def _log_level_sd(packed, at: np.ndarray, highest: float) -> float:
    """sd of ln of the low-frequency power by the likelihood's curvature; at most
    0.7."""
    centre = np.clip(at, -FARTHEST, FARTHEST)

    def measured(*shares: tuple[float, float]) -> np.ndarray:
        """(n, 2): −ln likelihood and ln power, so many steps from the centre."""
        places = [centre + share * step for share in np.array(shares)]
        found = [(_loss(packed, *_from_logits(u, highest)), u) for u in places]
        low = [Noise(*_from_logits(u, highest), 0.0).low_frequency for u in places]
        return np.array([(f[0] / 2, f[1] + np.log(p)) for (f, _), p in zip(found, low)])

    step = np.full(2, WIDEST_STEP)
    here = measured((0, 0))[0, 0]
    for _ in range(2):
        about = measured(*AXES)
        rise = (
            (about[0][0] + about[1][0] - 2 * here) / 2,
            (about[2][0] + about[3][0] - 2 * here) / 2,
        )
        step = np.minimum(step / np.sqrt(np.maximum(rise, 0.25)), WIDEST_STEP)
    loss, level = measured(*AXES, (1, 1), (-1, -1)).T
    cross = (loss[4] + loss[5] + 2 * here - loss[:4].sum()) / 2
    curve = np.array(
        [[loss[0] + loss[1] - 2 * here, cross], [cross, loss[2] + loss[3] - 2 * here]]
    )
    slope = np.array([level[0] - level[1], level[2] - level[3]]) / 2
    values, vectors = np.linalg.eigh(curve + np.diag((step / PRIOR_SD) ** 2))
    if values[0] <= 0:
        return 0.7
    spread = (vectors.T @ slope) ** 2 / values
    return float(min(np.sqrt(spread.sum() + 2 / packed[2].sum()), 0.7))


def outliers(innovations: np.ndarray) -> np.ndarray:
    """Which innovations (n,) lie more than OUTLIER_SD robust standard deviations
    off."""
    return np.abs(innovations) > OUTLIER_SD * robust_sd(innovations) + 1e-300


def maximum_draws(
    covariance: np.ndarray,
    rng: np.random.Generator,
    *,
    level_sd: float = 0.0,
    draws: int = 20_000,
) -> np.ndarray:
    """Draws of max |z| for normal z with this covariance; level_sd: of ln of all
    power."""
    values, vectors = np.linalg.eigh(covariance)
    root = vectors * np.sqrt(np.maximum(values, 0))
    scores = rng.standard_normal((draws, len(values))) @ root.T
    return np.abs(scores).max(axis=1) * np.exp(
        0.5 * level_sd * rng.standard_normal(draws)
    )
