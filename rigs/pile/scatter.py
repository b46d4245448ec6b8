"""Random scatter of heaps: roughness of grains along a flank, and variation of
packings."""

from dataclasses import dataclass, replace

import numpy as np

from benchtwin.bench import distributions as stats
from benchtwin.infer.noise import Noise, Stretch, estimate, frame_lag
from benchtwin.rigs.pile.flanks import STEP, Flank, Photo
from benchtwin.rigs.pile.heap_priors import PACKING_SD, PARTS, straight

SIGMA_FLOOR = 0.003  # of the height: model error of the family of shapes
ANGLE_SD_DEG = 0.1  # of a flank's line
CREEP_SD_DEG = 0.1  # of one heap's between its photos, before repeats say more
PRIOR_REPEATS = 4.0  # repeats that the prior PACKING_SD is worth
# orders of waves of missing physics, and of shorter ones, which are roughness
WAVES = 6
SHORT = 5
SKIN = 0.5  # seeds: beyond, the roughness of grains is not correlated
# below which repeats differ by more than roughness, and only they are used
ALIKE_P = 0.01
# of ln of the noise's power: packings are not Gaussian, and repeats are few
LEVEL_DOUBT = 0.15


@dataclass(frozen=True, eq=False)
class Scatter:
    """Roughness of surfaces and scatter of packings."""

    noise: Noise  # common to all flanks
    sigma: tuple[float, ...]  # (R,)
    lags: dict[tuple[int, int], np.ndarray]  # (n,) of each (photo, flank)
    even: dict[str, float]  # sds of PACKING_SD's parts, of both flanks alike
    odd: dict[str, float]  # and opposed
    creep_deg: float


def scatter_of(photos: tuple[Photo, ...]) -> Scatter:
    """Roughness by REML, packings from repeats (photos of equal `stated`)."""
    lags, one = _lags(photos)
    noise, sigma = _roughness(photos, lags, one)
    even, odd = _packing(photos, lags, noise, sigma)
    turned = [p for p in photos if np.isfinite(p.creep_deg)]
    creep = np.array([p.creep_deg for p in turned])
    creep_sd = pooled_sd(
        creep, np.zeros(len(creep)), [p.stated for p in turned], CREEP_SD_DEG
    )
    log_level_sd = max(LEVEL_DOUBT, noise.log_level_sd)
    return Scatter(
        replace(noise, log_level_sd=log_level_sd), sigma, lags, even, odd, creep_sd
    )


def cosines(u: np.ndarray, orders) -> np.ndarray:
    """(n, k) cosines of these orders along a flank."""
    return np.cos(np.pi * (u[:, None] - u[0]) / (u[-1] - u[0]) * np.array(list(orders)))


def _grain(photo: Photo) -> float:
    """Seed's length over the photo's unit, NaN where either is not stated."""
    return photo.seed_mm if photo.unit == "mm" else float("nan")


def _each(photos: tuple[Photo, ...]) -> list[tuple[tuple[int, int], Photo, Flank]]:
    return [
        ((r, k), p, f) for r, p in enumerate(photos) for k, f in enumerate(p.flanks)
    ]


def _lags(photos: tuple[Photo, ...]) -> tuple[dict[tuple[int, int], np.ndarray], float]:
    """Distances of rows of each flank, of equal correlation; one unit in seeds or
    NaN."""
    seeds = {at: f.length / _grain(p) for at, p, f in _each(photos)}
    one = STEP * float(np.mean(list(seeds.values())))
    return {
        at: frame_lag(f.u / STEP if np.isnan(one) else f.u * seeds[at] / one)
        for at, _, f in _each(photos)
    }, one


def _roughness(
    photos: tuple[Photo, ...], lags, one: float
) -> tuple[Noise, tuple[float, ...]]:
    """Noise common to all flanks, and each photo's sd, ∝ seed over height where known.

    Its power is that of waves just shorter than a flexible curve absorbs, and of the
    longer ones that repeats differ by beyond the packing's parts."""
    flanks = _each(photos)
    noise = estimate(
        [Stretch(cosines(f.u, range(WAVES + 3)), f.v, lags[at]) for at, _, f in flanks]
    )
    if np.isfinite(one):
        noise = replace(noise, rho=min(noise.rho, float(np.exp(-one / SKIN))))
    size = {
        at: _grain(p) / f.height if np.isfinite(one) else 1.0 for at, p, f in flanks
    }
    high = range(WAVES + 3, WAVES + 3 + SHORT)
    short = np.concatenate(
        [
            _waves(f, lags[at], noise, cosines(f.u, range(WAVES + 3)), high) / size[at]
            for at, _, f in flanks
        ]
    )
    groups: dict[tuple, list[np.ndarray]] = {}
    for at, p, f in flanks:
        long = _waves(f, lags[at], noise, _packed(f.u), range(3, WAVES + 3)) / size[at]
        groups.setdefault((p.stated, f.side), []).append(long)
    repeated = sum(
        float(((g - np.mean(g, axis=0)) ** 2).sum()) for g in groups.values()
    )
    freedom = sum((len(g) - 1) * len(g[0]) for g in groups.values())
    power = (float(short @ short) + repeated) / (len(short) + freedom)
    count = len(short) + freedom
    if (
        freedom
        and stats.f.sf(
            repeated / freedom * len(short) / float(short @ short), freedom, len(short)
        )
        < ALIKE_P
    ):
        power, count = repeated / freedom, freedom
    noise = replace(noise, log_level_sd=float(np.sqrt(2 / count)))
    # plus one sd of the estimate
    sd = float(np.exp(noise.log_level_sd / 2)) * float(np.sqrt(power))
    mean_size = [
        np.mean([size[r, k] for k in range(len(p.flanks))])
        for r, p in enumerate(photos)
    ]
    return noise, tuple(max(sd * float(k), SIGMA_FLOOR) for k in mean_size)


def _waves(
    flank: Flank, lag: np.ndarray, noise: Noise, beside: np.ndarray, orders
) -> np.ndarray:
    """Whitened amplitudes (k,) of cosines of these orders beside the columns
    `beside`."""
    rows = np.column_stack(
        [beside, cosines(flank.u, orders), flank.v - straight(flank.u)]
    )
    white = noise.whiten(rows, lag)
    return np.linalg.qr(white[:, :-1])[0][:, beside.shape[1] :].T @ white[:, -1]


def _packed(u: np.ndarray) -> np.ndarray:
    """What packings vary along a surface: level, slope, and PARTS."""
    return np.column_stack(
        [np.ones(len(u)), u - 0.5, *(part(u) for part in PARTS.values())]
    )


def _packing(
    photos: tuple[Photo, ...], lags, noise: Noise, sigma
) -> tuple[dict[str, float], dict[str, float]]:
    """sd of what repeats vary, roughness removed: both flanks alike, and opposed."""
    seen: dict[tuple[int, int], tuple[np.ndarray, np.ndarray]] = {}
    for at, _, f in _each(photos):
        rows = np.column_stack([_packed(f.u), f.v - straight(f.u)])
        white = noise.whiten(rows / sigma[at[0]], lags[at])
        inverse = np.linalg.inv(white[:, :-1].T @ white[:, :-1])
        values = inverse @ (white[:, :-1].T @ white[:, -1])
        errors = np.sqrt(np.diag(inverse))
        seen[at] = (
            np.append(values[2:], f.angle_deg),
            np.append(errors[2:], ANGLE_SD_DEG),
        )
    both = [r for r, p in enumerate(photos) if len(p.flanks) == 2]
    error = {
        r: np.sqrt(sum(seen[r, k][1] ** 2 for k in range(len(p.flanks))))
        / len(p.flanks)
        for r, p in enumerate(photos)
    }
    mean = [
        np.mean([seen[r, k][0] for k in range(len(p.flanks))], axis=0)
        for r, p in enumerate(photos)
    ]
    half = [(seen[r, 1][0] - seen[r, 0][0]) / 2 for r in both]
    even, odd = {}, {}
    for i, (name, sd) in enumerate(PACKING_SD.items()):
        own = sd / np.sqrt(2)
        even[name] = pooled_sd(
            np.array([m[i] for m in mean]),
            np.array([e[i] for e in error.values()]),
            [p.stated for p in photos],
            own,
        )
        odd[name] = pooled_sd(
            np.array([h[i] for h in half]),
            np.array([error[r][i] for r in both]),
            [photos[r].stated for r in both],
            own,
        )
    return even, odd


def pooled_sd(
    values: np.ndarray, errors: np.ndarray, group: list, prior_sd: float
) -> float:
    """sd of `values` about group means beyond `errors`, weighted by its share, with a
    prior."""
    least = 0.1 * PRIOR_REPEATS * prior_sd**2
    sums, freedom = PRIOR_REPEATS * prior_sd**2, PRIOR_REPEATS
    for key in dict.fromkeys(group):
        own = np.array([g == key for g in group])
        spare, noise = own.sum() - 1, float((errors[own] ** 2).mean())
        counts = (prior_sd**2 / (prior_sd**2 + noise)) ** 2
        sums += counts * (
            float(((values[own] - values[own].mean()) ** 2).sum()) - spare * noise
        )
        freedom += counts * spare
    return float(np.sqrt(max(sums, least) / freedom))
