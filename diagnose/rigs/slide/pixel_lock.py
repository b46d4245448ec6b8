"""Pixel lock of a travel: places are read too far towards pixel centres, by A sin φ + B cos φ.

φ = 2π x/pixel; A and B [px] are each recording's. Source: Westerweel, Exp. Fluids 29 (2000) S3.
"""

import numpy as np

POWERS = np.arange(2, 8)  # of the time since the onset: accelerations of degree 0 to 5
EARLIEST, LATEST = -0.1, 0.25  # of the slide's duration, after the onset as first guessed
ONSETS, MAX_ITERATIONS = 9, 3  # grid search for the onset, refined to 1e-3 of the duration
ENOUGH = 200  # rows used for the onset


def lock(time: np.ndarray, x_mm: np.ndarray, rest: int, pixel_mm: float) -> np.ndarray:
    """Error of x (n, 2) [mm] for A = 1 px and B = 1 px; rest: rows before the onset."""
    if not pixel_mm:
        return np.zeros((len(time), 2))
    phase = 2 * np.pi * smooth(time, x_mm, rest) / pixel_mm
    return pixel_mm * np.column_stack([np.sin(phase), np.cos(phase)])


def smooth(time: np.ndarray, x: np.ndarray, rest: int) -> np.ndarray:
    """Place (n,) by a curve of few terms: a row's own reading would explain its own noise."""
    few = slice(None, None, max(1, len(x) // ENOUGH))
    grid = time[rest] + (time[-1] - time[rest]) * np.linspace(EARLIEST, LATEST, ONSETS)
    for _ in range(MAX_ITERATIONS):
        left = [((x[few] - _from(onset, time[few], x[few])) ** 2).sum() for onset in grid]
        best = int(np.argmin(left))
        onset = grid[best]
        grid = np.linspace(grid[max(best - 1, 0)], grid[min(best + 1, ONSETS - 1)], ONSETS)
    return _from(onset, time, x)


def _from(onset: float, time: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Least-squares fit of rest and, from `onset` on, a polynomial acceleration."""
    since = np.clip((time - onset) / (time[-1] - onset), 0.0, None)
    design = np.column_stack([np.ones(len(time)), since[:, None] ** POWERS])
    return design @ np.linalg.lstsq(design, x, rcond=None)[0]
