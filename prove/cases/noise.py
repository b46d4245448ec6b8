"""Tracking noise as cameras have it: white and slowly varying, heavy tails, pulled
towards whole pixels, frames lost."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numba import njit
from scipy.signal import lfilter

RHOS = (0.0, 0.3, 0.5, 0.7, 0.9, 0.97)


@dataclass(frozen=True)
class Noise:
    """Noise of one coordinate."""

    sd: float  # [mm]
    rho: float  # of the slow part
    white: float  # share of the variance
    tail: float  # degrees of freedom of Student's t, inf: Gaussian
    lock: float  # amplitude towards whole pixels [mm]
    pixel: float  # [mm]
    lost: float  # share of frames


def draw_noise(
    rng: np.random.Generator, *, sd: tuple[float, float], pixel: float
) -> Noise:
    """A noise with its sd log-uniform within `sd` [mm]."""
    size = float(np.exp(rng.uniform(*np.log(sd))))
    rho = float(rng.choice(RHOS))
    lock = size * rng.uniform(0.1, 0.3) if rng.random() < 0.3 else 0.0
    tail = float(rng.choice([np.inf, 8.0, 5.0]))
    lost = float(rng.choice([0.0, 0.002, 0.01]))
    return Noise(
        size,
        rho,
        float(rng.uniform(0.0, 0.4)) if rho else 1.0,
        tail,
        float(lock),
        pixel,
        lost,
    )


def noisy(values: np.ndarray, noise: Noise, rng: np.random.Generator) -> np.ndarray:
    """values (n,) [mm] with the noise on them; no frame is lost here."""
    n = len(values)
    drive = shocks(n, noise.tail, rng) * np.sqrt(1 - noise.rho**2)
    drive[0] /= np.sqrt(1 - noise.rho**2)  # begins with the spread that it keeps
    slow = lfilter([1.0], [1.0, -noise.rho], drive)
    white = shocks(n, noise.tail, rng)
    lock = noise.lock * np.sin(2 * np.pi * values / noise.pixel)
    coloured = np.sqrt(noise.white) * white + np.sqrt(1 - noise.white) * slow
    return values + lock + noise.sd * (coloured)


def shocks(n: int, tail: float, rng: np.random.Generator) -> np.ndarray:
    """(n,) independent numbers of unit variance, heavy-tailed when `tail` is
    finite."""
    if np.isinf(tail):
        return rng.standard_normal(n)
    return rng.standard_t(tail, n) * np.sqrt((tail - 2) / tail)


def kept(n: int, noise: Noise, rng: np.random.Generator) -> np.ndarray:
    """Mask (n,) of the frames that are not lost; some losses come in runs."""
    lost = rng.random(n) < noise.lost / 2
    for start in np.flatnonzero(rng.random(n) < noise.lost / 10):
        lost[start : start + 5] = True
    lost[: min(3, n)] = lost[-min(3, n) :] = False
    return ~lost


def tracked(
    t: np.ndarray,
    x: np.ndarray,
    y: np.ndarray,
    noise: Noise,
    rng: np.random.Generator,
    **read: Callable[[np.random.Generator], np.ndarray],
) -> pd.DataFrame:
    """The track that is recorded of places (n,) [mm] at stated times (n,) [s], and
    columns that other instruments read with errors of their own."""
    table = {
        "t_s": t,
        "x_mm": noisy(x, noise, rng).round(5),
        "y_mm": noisy(y, noise, rng).round(5),
        **{column: values(rng) for column, values in read.items()},
        "sd_mm": float(f"{noise.sd:.3g}"),
    }
    return pd.DataFrame(table)[kept(len(t), noise, rng)]


@njit(cache=True)
def whitened(columns, rho, white, sd):
    """Innovations of white + first-order noise for each of the columns (n, p), in sds
    (Kalman filter, one state)."""
    n, p = columns.shape
    out = np.empty((n, p))
    slow, fast = (1 - white) * sd**2, white * sd**2 + 1e-12 * sd**2
    state, variance = np.zeros(p), slow
    for i in range(n):
        total = variance + fast
        gain = variance / total
        for j in range(p):
            off = columns[i, j] - state[j]
            out[i, j] = off / np.sqrt(total)
            state[j] = rho * (state[j] + gain * off)
        variance = rho**2 * (1 - gain) * variance + (1 - rho**2) * slow
    return out
