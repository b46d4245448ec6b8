"""Baselines: white-noise BIC, sparse regression of derivatives, a Gaussian process for
the discrepancy, all parameters free."""

import warnings
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from benchtwin.prove.baselines.drops import (
    FLIGHT_NAMES,
    IMPACT_NAMES,
    Flight,
    bounces,
    impact_columns,
    read_drops,
    smooth_acceleration,
)

BIC_MARGIN = 10.0  # "very strong", Kass & Raftery, J. Am. Stat. Assoc. 90 (1995) 773
FREE_T = 3.0
GP_MARGIN = 5.0
SPARSE_M_S2 = 0.2  # a term smaller than this, root mean square, is dropped
POINTS = 60  # of a flight: a process that needs more is noise


def answer(
    alarm: bool,
    verdict: str,
    names: Sequence[str] = (),
    sector: str = "flight",
    parameters: dict | None = None,
) -> dict:
    """A diagnosis of the drop in the solver's schema."""
    sectors = [{"name": sector, "explained": 1.0, "p": 0.0}]
    rig = {
        "alarm": bool(alarm),
        "verdict": verdict,
        "names": list(names),
        "sectors": sectors,
        "held_out": {},
    }
    rig["parameters"] = parameters or {}
    return {"schema": 1, "rigs": {"drop": rig}}


def sector_of(name: str) -> str:
    """Where an effect acts: "impact", "flight" or "measurement"."""
    if name in IMPACT_NAMES:
        return "impact"
    return "flight" if name in ("drag", "draught", "magnus") else "measurement"


def white_bic(drops: list[list[Flight]]) -> dict:
    """The candidate with the best BIC if it beats none by BIC_MARGIN; every frame
    counts as independent."""
    residual, columns = _stacked(drops)
    gains = {
        name: _bic_gain(residual, columns[:, k]) for k, name in enumerate(FLIGHT_NAMES)
    }
    found = bounces(drops)
    if len(found) > 3:
        e = found["restitution"].to_numpy()
        shapes = impact_columns(found)
        gains |= {
            name: _bic_gain(e - e.mean(), shapes[:, k] - shapes[:, k].mean())
            for k, name in enumerate(IMPACT_NAMES)
        }
    best = max(gains, key=gains.__getitem__)
    if gains[best] < BIC_MARGIN:
        return answer(False, "none")
    return answer(
        True, "name", [best], sector_of(best), _parameter(best, residual, columns)
    )


def _bic_gain(residual: np.ndarray, column: np.ndarray) -> float:
    """By how much one more free coefficient lowers n ln(RSS/n) + k ln n."""
    size = float(column @ column)
    if size <= 0:
        return -np.inf
    n, rss = len(residual), float(residual @ residual)
    left = max(rss - float(column @ residual) ** 2 / size, 1e-12 * rss)
    return n * np.log(rss / left) - np.log(n)


def _parameter(name: str, residual: np.ndarray, columns: np.ndarray) -> dict:
    if name not in FLIGHT_NAMES or name == "magnus":
        return {}
    c = columns[:, FLIGHT_NAMES.index(name)]
    value = float(c @ residual) / float(c @ c)
    se = float(np.std(residual - value * c)) / float(np.sqrt(c @ c))
    low, high = value - 1.96 * se, value + 1.96 * se
    return {name: {"unit": "", "value": value, "low95": low, "high95": high}}


def all_free(drops: list[list[Flight]]) -> dict:
    """Everything fitted at once by least squares; what lies FREE_T standard errors off
    zero is named."""
    residual, columns = _stacked(drops)
    names = _significant(residual, columns, FLIGHT_NAMES)
    found = bounces(drops)
    if len(found) > len(IMPACT_NAMES) + 3:
        e, shapes = found["restitution"].to_numpy(), impact_columns(found)
        names += _significant(e - e.mean(), shapes - shapes.mean(axis=0), IMPACT_NAMES)
    sector = sector_of(names[0]) if names else "flight"
    return answer(bool(names), "name" if names else "none", names, sector)


def _significant(
    residual: np.ndarray, columns: np.ndarray, names: tuple[str, ...]
) -> list[str]:
    seen = np.flatnonzero((columns**2).sum(axis=0) > 0)
    scale = np.sqrt((columns[:, seen] ** 2).sum(axis=0))
    a = columns[:, seen] / scale
    inverse = np.linalg.pinv(a.T @ a)
    coefficient = inverse @ (a.T @ residual)
    spread = np.std(residual - a @ coefficient) * np.sqrt(np.diag(inverse))
    return [
        names[k] for k, c, s in zip(seen, coefficient, spread) if abs(c) > FREE_T * s
    ]


def sindy(drops: list[list[Flight]]) -> dict:
    """Sparse regression (sequentially thresholded least squares) of smoothed
    accelerations on speeds and height."""
    parts = [
        p
        for flights in drops
        for f in flights
        if (p := smooth_acceleration(f)) is not None
    ]
    if not parts:
        return answer(False, "none")
    vx, vy, ax, ay = (np.concatenate(column) for column in zip(*parts))
    size = np.hypot(vx, vy)
    library = np.column_stack([np.ones_like(vx), vx, vy, size * vx, size * vy, size])
    across, up = _sparse(library, ax), _sparse(library, ay + 9.80665)
    names = []
    if up[4] < 0:
        names.append("drag")
    elif up[0]:
        names.append("scale-error")
    if across[0]:
        names.append("camera-roll")
    elif across[5]:
        names.append("draught")
    alarm = bool(np.any(across) or np.any(up))
    verdict = "name" if names else "unknown" if alarm else "none"
    return answer(alarm, verdict, names, sector_of(names[0]) if names else "flight")


def _sparse(library: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Coefficients of the columns that are kept; by pysindy where it is installed."""
    scale = np.sqrt((library**2).mean(axis=0))
    a = library / scale
    try:
        from pysindy.optimizers import STLSQ
    except ImportError:
        return _thresholded(a, target) / scale
    with warnings.catch_warnings():
        # that the threshold took all terms is an answer
        warnings.simplefilter("ignore")
        sparse = STLSQ(threshold=SPARSE_M_S2, alpha=1e-6)
        return np.ravel(sparse.fit(a, target[:, None]).coef_) / scale


def _thresholded(a: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Sequentially thresholded least squares; Brunton et al., PNAS 113 (2016) 3932."""
    kept = np.ones(a.shape[1], dtype=bool)
    out = np.zeros(a.shape[1])
    for _ in range(20):
        out[:] = 0
        if not kept.any():
            break
        out[kept] = np.linalg.lstsq(a[:, kept], target, rcond=None)[0]
        small = np.abs(out) < SPARSE_M_S2
        if not (small & kept).any():
            break
        kept &= ~small
    return out


def gp(drops: list[list[Flight]]) -> dict:
    """A Gaussian process in time (Kennedy & O'Hagan 2001): whether, never what, is
    missing."""
    missing = sum(_gp_gain(f) for flights in drops for f in flights) > GP_MARGIN
    return answer(missing, "unknown" if missing else "none")


def _gp_gain(flight: Flight) -> float:
    """Log marginal likelihood that the best process adds to white noise alone, less 2
    for its two numbers."""
    n = len(flight.t)
    rows = np.unique(np.linspace(0, n - 1, min(n, POINTS)).astype(int))
    t, both = flight.t[rows], np.column_stack(np.split(flight.residual(), 2))[rows]
    m, best = len(rows), np.zeros(2)
    white = -0.5 * m * np.log((both**2).sum(axis=0) / m)
    for length in (0.005, 0.02, 0.08):
        for ratio in (0.1, 1.0, 10.0):
            k = np.eye(m) + ratio * np.exp(-0.5 * ((t[:, None] - t) / length) ** 2)
            low = np.linalg.cholesky(k)
            z = np.linalg.solve(low, both)
            size = np.log(np.diag(low)).sum()
            best = np.maximum(
                best, -0.5 * m * np.log((z**2).sum(axis=0) / m) - size - white - 2
            )
    return float(best.sum())


def _stacked(drops: list[list[Flight]]) -> tuple[np.ndarray, np.ndarray]:
    flights = [f for d in drops for f in d]
    return np.concatenate([f.residual() for f in flights]), np.concatenate(
        [f.columns() for f in flights]
    )


METHODS: dict[str, Callable[[list[list[Flight]]], dict]] = {
    "white-noise BIC": white_bic,
    "SINDy on derivatives": sindy,
    "GP discrepancy": gp,
    "all parameters free": all_free,
}


def diagnose(bench: Path, method: str) -> dict | None:
    """What a method says of a bench folder; None where it holds no drop tracks."""
    drops = read_drops(bench)
    return METHODS[method](drops) if drops else None
