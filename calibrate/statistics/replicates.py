"""How many replicates a design needs against packing noise, and what shared packings
save.

A main effect is the change of the response from a factor's low to its high, 2β. With
every row of a design X run r times,
    se(β_j) = σ √([(XᵀX)⁻¹]_jj / r),
    power = P(|t'(ν, |β_j|/se)| > t_{1−α/2}(ν)),   ν = n r − p.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy import stats

from benchtwin.calibrate.statistics import terms as polynomial


@dataclass(frozen=True)
class Noise:
    """Scatter of one run: sd on df degrees of freedom, low and high its two-sided
    `level` interval (χ²)."""

    sd: float
    df: int
    low: float
    high: float
    level: float


def packing_noise(
    table: pd.DataFrame, response: str, *, point: str | None = None, level: float = 0.80
) -> Noise:
    """Scatter of runs that differ in packing only: one row a run; `point` names the
    column that tells design points apart, if several.

    level 0.80: its upper end is the value that the true sd lies below with 90 %
    assurance. Raises ValueError: column missing, fewer than two runs at any point, all
    runs of a point equal (their seeds did not differ)."""
    y = pd.Series(table[response].to_numpy(float))
    groups = np.zeros(len(y)) if point is None else table[point].to_numpy()
    within = y - y.groupby(groups).transform("mean")
    df = int(len(y) - pd.Series(groups).nunique())
    if df < 1:
        raise ValueError(
            f"{response}: packing noise needs at least two runs of a point; here is"
            f" {len(y)} run"
        )
    if not within.any():
        raise ValueError(
            f"{response}: runs at the same point are all equal; did their packings"
            " differ?"
        )
    variance = float(np.sum(within**2)) / df
    quantile = stats.chi2.ppf([(1 + level) / 2, (1 - level) / 2], df)
    ends = np.sqrt(df * variance / quantile)
    return Noise(float(np.sqrt(variance)), df, float(ends[0]), float(ends[1]), level)


def power(
    coded: np.ndarray,
    effect: float,
    sd: float,
    replicates: int,
    *,
    terms: str = "quadratic",
    alpha: float = 0.05,
) -> float:
    """Smallest power over the factors with which a main effect 2β = effect is found
    significant; coded: (n, k) design points."""
    x = polynomial.matrix(coded, polynomial.full(coded.shape[1], terms))
    df = replicates * len(x) - x.shape[1]
    if df < 1:
        raise ValueError(
            f"{len(x)} runs leave no degrees of freedom beside {x.shape[1]} terms"
        )
    main = np.diag(np.linalg.inv(x.T @ x))[1 : 1 + coded.shape[1]].max()
    shift = abs(effect) / 2 / (sd * np.sqrt(main / replicates))
    limit = stats.t.ppf(1 - alpha / 2, df)
    if shift > limit + 10:  # certain to 1e-15; scipy's non-central t gives NaN there
        return 1.0
    return float(stats.nct.sf(limit, df, shift) + stats.nct.cdf(-limit, df, shift))


@dataclass(frozen=True, eq=False)
class Plan:
    """How often every design point is to be run.

    replicates: needed if the noise is at its upper limit; replicates_at_estimate: if it
    is as measured. table: replicates, runs, power, power_cautious. reached: whether the
    power is reached within the largest number allowed. statement: this in words."""

    replicates: int
    replicates_at_estimate: int
    reached: bool
    table: pd.DataFrame
    statement: str


def plan(
    coded: np.ndarray,
    effect: float,
    noise: Noise,
    *,
    wanted: float = 0.80,
    alpha: float = 0.05,
    terms: str = "quadratic",
    most: int = 30,
    correlation: float = 0.0,
) -> Plan:
    """Replicates a design point so that main effects of size `effect` (low → high, unit
    of the response) are found with power `wanted`.

    correlation: between runs of different points on the same packing (see
    `common_packing`); what a packing shares cancels in effects, σ² → σ²(1 −
    correlation). Raises ValueError for effect 0, wanted outside (0, 1), correlation
    outside [0, 1)."""
    if effect == 0 or not np.isfinite(effect):
        raise ValueError(f"effect: a size other than zero, not {effect:g}")
    if not 0 < wanted < 1 or not 0 <= correlation < 1 or most < 1:
        raise ValueError(
            f"wanted in (0, 1), not {wanted:g}; correlation in [0, 1), not"
            f" {correlation:g}; most at least 1"
        )
    coded = np.asarray(coded, dtype=float)
    shrink = np.sqrt(1 - correlation)
    rows = []
    for r in range(1, most + 1):
        likely, cautious = (
            power(coded, effect, s * shrink, r, terms=terms, alpha=alpha)
            for s in (noise.sd, noise.high)
        )
        rows.append((r, r * len(coded), likely, cautious))
        if cautious >= wanted:
            break
    columns = ["replicates", "runs", "power", "power_cautious"]
    needed, reached = r, bool(cautious >= wanted)
    at_estimate = next((r for r, _, likely, _ in rows if likely >= wanted), most)
    said = (
        f"noise {noise.sd:.2g} ({noise.low:.2g} to {noise.high:.2g}): main effects of"
        f" {abs(effect):.2g} are found with {wanted:.0%} power by {needed} runs a point"
        f" ({at_estimate} if the noise is as measured)"
    )
    if not reached:
        often = "one run a point finds" if most == 1 else f"{most} runs a point find"
        effects = f"main effects of {abs(effect):.2g}"
        said = f"even {often} {effects} with {cautious:.0%} power only"
    table = pd.DataFrame(rows, columns=columns)
    return Plan(needed, at_estimate, reached, table, said)


@dataclass(frozen=True)
class Pairing:
    """What the same packings at every design point are worth.

    correlation: of runs on the same packing, with its 90 % interval low, high; gain:
    factor on the number of runs saved for effects, 1/(1 − correlation); worth_it:
    whether the interval excludes zero."""

    correlation: float
    low: float
    high: float
    gain: float
    worth_it: bool


def common_packing(
    table: pd.DataFrame, response: str, *, point: str, packing: str
) -> Pairing:
    """Correlation of runs that share a packing, from a full table of points × packings,
    one run each.

    ICC(C,1) of the two-way layout: (MS_packing − MS_rest)/(MS_packing + (n − 1)
    MS_rest), n points (McGraw & Wong 1996), interval by F. A mean level is not helped:
    packings shared by all points scatter it as before. Raises ValueError for a table
    with gaps or repeats."""
    if table.duplicated([point, packing]).any():
        raise ValueError(f"{point} and {packing}: one run each; some pairs come twice")
    wide = table.pivot(index=point, columns=packing, values=response).to_numpy()
    n, m = wide.shape
    if n < 2 or m < 2 or not np.isfinite(wide).all():
        raise ValueError(
            f"{point} × {packing}: at least 2 × 2 and every pair run; here are {n} ×"
            f" {m} with gaps or too few"
        )
    by_packing = wide.mean(axis=0)
    rest = wide - by_packing - wide.mean(axis=1, keepdims=True) + wide.mean()
    ms_packing = n * np.var(by_packing, ddof=1)
    ms_rest = float(np.sum(rest**2)) / ((n - 1) * (m - 1))
    if ms_rest <= 0:
        raise ValueError(
            f"{response}: runs of a packing differ by nothing but the point; the noise"
            " is not known"
        )
    ratio = ms_packing / ms_rest
    quantile = stats.f.ppf([0.95, 0.05], m - 1, (n - 1) * (m - 1))
    value, low, high = (
        float((f - 1) / (f + n - 1)) for f in (ratio, *(ratio / quantile))
    )
    return Pairing(value, low, high, float(1 / (1 - max(value, 0.0))), low > 0)
