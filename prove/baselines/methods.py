"""Baselines: white-noise BIC, sparse regression of derivatives, a Gaussian process for
the discrepancy, all parameters free."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.signal import savgol_filter

from benchtwin.prove.baselines.drops import Flight, bounces, impact_columns, read_drops

BIC_MARGIN = 10.0  # "very strong", Kass & Raftery, J. Am. Stat. Assoc. 90 (1995) 773
FREE_T = 3.0
GP_MARGIN = 5.0
SPARSE_M_S2 = 0.2  # a term smaller than this, root mean square, is dropped
POINTS = 60  # of a flight: a process that needs more is noise
SECTORS = dict.fromkeys(("drag", "draught", "magnus"), "flight") | dict.fromkeys(
    ("camera-roll", "scale-error", "perspective", "silhouette-wobble"), "measurement"
)  # of what is seen in flights; what bounces tell is "impact"


def answer(
    names: Sequence[str] = (), parameters: dict | None = None, unknown: bool = False
) -> dict:
    """A diagnosis of the drop in the solver's schema."""
    sector = SECTORS.get(names[0], "impact") if names else "flight"
    rig = {
        "alarm": bool(names) or unknown,
        "verdict": "name" if names else "unknown" if unknown else "none",
        "names": list(names),
        "sectors": [{"name": sector, "explained": 1.0, "p": 0.0}],
        "held_out": {},
        "parameters": parameters or {},
    }
    return {"schema": 1, "rigs": {"drop": rig}}


def _tracks(drops: list[list[Flight]]) -> tuple[np.ndarray, pd.DataFrame]:
    """All flights' residuals, and what effects do to them."""
    flights = [f for d in drops for f in d]
    residual = np.concatenate([f.residual() for f in flights])
    return residual, pd.concat([f.columns() for f in flights])


def _impacts(drops: list[list[Flight]], least: int) -> tuple[np.ndarray, pd.DataFrame]:
    """Restitutions less their mean, and what effects do to them; nothing of fewer than
    `least` bounces."""
    found = bounces(drops)
    shapes = impact_columns(found)
    if len(found) < least:
        return np.zeros(0), shapes.iloc[:0, :0]
    e = found["restitution"].to_numpy()
    return e - e.mean(), shapes - shapes.mean()


def white_bic(drops: list[list[Flight]]) -> dict:
    """The candidate with the best BIC if it beats none by BIC_MARGIN; every frame
    counts as independent."""
    (residual, columns), (e, shapes) = _tracks(drops), _impacts(drops, 4)
    gains = columns.apply(_bic_gain, residual=residual)
    losses = shapes.apply(_bic_gain, residual=e)
    if max(gains.max(), losses.max()) < BIC_MARGIN:
        return answer()
    if losses.max() > gains.max():
        return answer([losses.idxmax()])
    best = gains.idxmax()
    column = columns[best].to_numpy()
    value = float(column @ residual) / float(column @ column)
    off = 1.96 * float(np.std(residual - value * column) / np.linalg.norm(column))
    stated = {"unit": "", "value": value, "low95": value - off, "high95": value + off}
    # magnus is in arbitrary units
    parameters = {} if best == "magnus" else {best: stated}
    return answer([best], parameters)


def _bic_gain(column: pd.Series, residual: np.ndarray) -> float:
    """By how much one more free coefficient lowers n ln(RSS/n) + k ln n."""
    size = float(column @ column)
    if size <= 0:
        return -np.inf
    n, rss = len(residual), float(residual @ residual)
    left = max(rss - float(column @ residual) ** 2 / size, 1e-12 * rss)
    return n * np.log(rss / left) - np.log(n)


def all_free(drops: list[list[Flight]]) -> dict:
    """Everything fitted at once by least squares; what lies FREE_T standard errors off
    zero is named."""
    return answer(_significant(*_tracks(drops)) + _significant(*_impacts(drops, 8)))


def _significant(residual: np.ndarray, columns: pd.DataFrame) -> list[str]:
    columns = columns.loc[:, (columns != 0).any()]
    if columns.empty:
        return []
    a = columns / np.sqrt((columns**2).sum())
    inverse = np.linalg.pinv(a.T @ a)
    coefficient = inverse @ (a.T @ residual)
    spread = np.std(residual - a @ coefficient) * np.sqrt(np.diag(inverse))
    return list(columns.columns[np.abs(coefficient) > FREE_T * spread])


def sindy(drops: list[list[Flight]]) -> dict:
    """Sparse regression (sequentially thresholded least squares) of smoothed
    accelerations on speeds and height."""
    parts = [_smooth(f) for flights in drops for f in flights]
    vx, vy, ax, ay = np.hstack([np.zeros((4, 0)), *parts])
    size = np.hypot(vx, vy)
    library = pd.DataFrame(
        {"1": 1.0, "vx": vx, "vy": vy, "v vx": size * vx, "v vy": size * vy, "v": size}
    )
    across, up = _sparse(library, ax), _sparse(library, ay + 9.80665)
    names = []
    if up["v vy"] < 0:
        names.append("drag")
    elif up["1"]:
        names.append("scale-error")
    if across["1"]:
        names.append("camera-roll")
    elif across["v"]:
        names.append("draught")
    return answer(names, unknown=bool(across.any() or up.any()))


def _smooth(flight: Flight) -> np.ndarray:
    """(vx, vy, ax, ay) in m and s (4, n) by Savitzky–Golay over 20 ms; none where the
    flight is too short."""
    step = float(np.median(np.diff(flight.t)))
    window = max(7, round(0.02 / step) // 2 * 2 + 1)
    if len(flight.t) < window + 4:
        return np.zeros((4, 0))
    places = np.array([flight.x, flight.y]) * 1e-3
    out = [savgol_filter(places, window, 3, deriv=d, delta=step) for d in (1, 2)]
    return np.vstack(out)[:, window // 2 : -(window // 2)]


def _sparse(library: pd.DataFrame, target: np.ndarray) -> pd.Series:
    """Coefficients by sequentially thresholded least squares; Brunton et al., PNAS 113
    (2016) 3932."""
    a = library / np.sqrt((library**2).mean())
    kept = pd.Series(len(a) > 0, index=a.columns)
    while True:
        out = pd.Series(0.0, index=a.columns)
        out[kept] = np.linalg.lstsq(a.loc[:, kept], target, rcond=None)[0]
        small = kept & (out.abs() < SPARSE_M_S2)
        if not small.any():
            return out
        kept &= ~small


def gp(drops: list[list[Flight]]) -> dict:
    """A Gaussian process in time (Kennedy & O'Hagan 2001): whether, never what, is
    missing."""
    gain = sum(_gp_gain(f) for flights in drops for f in flights)
    return answer(unknown=gain > GP_MARGIN)


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
