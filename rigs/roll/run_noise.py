"""Noise of a session's rolls: residuals about curves more flexible than any effect, leg
by leg."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import block_diag

from benchtwin.bench.priors import unstated_sd
from benchtwin.infer.noise import Noise, Stretch, estimate, frame_lag, spreads
from benchtwin.rigs.roll.session import Run

EXACT_M = 3e-6  # floor for simulated tracks
ENOUGH_ROWS = (
    10  # spare rows from which gates' noise is estimated instead of taken as stated
)
USUAL_SD_M = unstated_sd("row-of-few") / 1000  # where neither stated nor estimated
STATED_LEVEL_SD = 0.3  # of ln of a stated noise's power
DEGREE_DOWN, DEGREE_LEVEL = 3, 6
SOON_S = (0.01, 0.025, 0.06, 0.15)  # behind the corner, where slip acts
LATE_S = (0.03, 0.08, 0.2)  # before the stop, where a seed's shape acts most
GUARD = 2  # averaged rows about the corner and the stop


@dataclass(frozen=True)
class RunNoise:
    """noise: common to the session; sigma (R,) [m] of each run."""

    noise: Noise
    sigma: np.ndarray


def estimate_noise(runs: tuple[Run, ...], turn: np.ndarray) -> RunNoise:
    """ρ and white share by REML over all runs, σ of each; short runs share one σ."""
    if any(has_few_rows(run) for run in runs):
        return _noise_of_few(runs, turn)
    found = [(r, s) for r, run in enumerate(runs) for s in _stretches(run, turn[r])]
    stretches = [s for _, s in found]
    noise = estimate(stretches)
    sigma = spreads(stretches, [r for r, _ in found], len(runs), noise)
    return RunNoise(noise, np.maximum(sigma, EXACT_M))


def has_few_rows(run: Run) -> bool:
    """Whether a run has so few rows that each is independent."""
    return bool(np.isinf(run.lag).all())


def row_weight(run: Run) -> np.ndarray:
    """(n,) sd of each row over the run's σ; light gates read times, so theirs grow with
    speed."""
    if not run.gates:
        return np.ones(len(run.x))
    speed = np.maximum(np.abs(np.gradient(run.x, run.time_s)), 1e-6)
    return speed / speed.mean()


def _noise_of_few(runs: tuple[Run, ...], turn: np.ndarray) -> RunNoise:
    """White noise, stated or of residuals; runs past the same gates share a mean."""
    long = [r for r, run in enumerate(runs) if not has_few_rows(run)]
    others = estimate_noise(tuple(runs[r] for r in long), turn[long]) if long else None
    power, spare = 0.0, 0.0
    left: dict[tuple | str, list[tuple[np.ndarray, int]]] = {}
    for run in (run for run in runs if has_few_rows(run)):
        unknowns = 3 if run.stays else 5
        t, way = run.time_s, run.way
        columns = [np.ones(len(t)), t - t.mean(), (t - t.mean()) ** 2]
        columns += [
            np.maximum(t - way.corner, 0) ** 2,
            np.maximum(t - way.stop, 0) ** 2,
        ]
        design = np.column_stack(columns[:unknowns]) / row_weight(run)[:, None]
        data = run.x / row_weight(run)
        rest = data - design @ np.linalg.lstsq(design, data, rcond=1e-12)[0]
        key = (run.sign, run.session, tuple(run.x)) if run.gates else run.recording
        left.setdefault(key, []).append((rest, max(len(run.x) - unknowns, 0)))
    for alike in left.values():
        rests = np.array([rest for rest, _ in alike])
        shared = len(rests) > 1 and rests.shape[1] > 0
        off = rests - rests.mean(0) if shared else rests
        power += float((off**2).sum())
        spare += sum(free for _, free in alike) * (
            (len(rests) - 1) / len(rests) if shared else 1
        )
    # five curves nearly explain few rows of both legs; what is usual counts as one row
    passing = any(has_few_rows(run) and not run.stays for run in runs)
    usual = 1 if passing or spare < 1 else 0
    sigma = np.zeros(len(runs))
    for r, run in enumerate(runs):
        stated = (
            float(np.median(run.sd_m / row_weight(run)))
            if has_few_rows(run)
            else math.nan
        )
        told = math.sqrt((usual * USUAL_SD_M**2 + power) / (usual + spare))
        sigma[r] = (
            stated if stated > 0 and not (run.gates and spare >= ENOUGH_ROWS) else told
        )
    if others is not None:
        sigma[long] = others.sigma
    stated_all = all(np.isfinite(run.sd_m).all() for run in runs if has_few_rows(run))
    level = STATED_LEVEL_SD if stated_all else math.sqrt(2 / (usual + spare))
    noise = Noise(0.0, 0.0, level) if others is None else others.noise
    return RunNoise(noise, np.maximum(sigma, EXACT_M))


def _stretches(run: Run, turn: float) -> list[Stretch]:
    """The run as one stretch with a curve in each leg, rows at the transitions left
    out."""
    t, way = run.time_s, run.way
    guard = GUARD * float(np.median(np.diff(t)))
    used, curves, data = [], [], []
    borders = (-np.inf, way.release, way.corner, way.stop, np.inf)
    for low, high, design in zip(
        borders[:-1], borders[1:], (_still, _down, _level, _still), strict=True
    ):
        rows = np.flatnonzero((t > low + guard) & (t < high - guard))
        if len(rows) < 8:
            continue
        columns = design(run, rows, turn)
        if len(rows) >= 2 * columns.shape[1]:
            used.append(rows)
            curves.append(columns / np.maximum(np.abs(columns).max(0), 1e-300))
            data.append(run.x[rows] - run.x[rows[0]])
    if not used:
        return []
    frame = np.cumsum(np.append(0.0, run.lag[1:]))[np.concatenate(used)]
    return [Stretch(block_diag(*curves), np.concatenate(data), frame_lag(frame))]


def smooth_curves(run: Run) -> np.ndarray:
    """(n, k) smooth curves over a run's way from release to stop."""
    rows = np.flatnonzero((run.time_s > run.way.release) & (run.time_s < run.way.stop))
    seen = len(run.time_s) + (run.junction is not None)
    out = np.zeros((seen, DEGREE_LEVEL + 1))
    if len(rows) > 2 * out.shape[1]:
        out[rows] = legendre.legvander(_tau(run, rows), DEGREE_LEVEL)
    return out * float(np.median(np.abs(np.diff(run.x)))) if len(run.x) > 1 else out


def _tau(run: Run, rows) -> np.ndarray:
    t = run.time_s[rows]
    return 2 * (t - t[0]) / (t[-1] - t[0]) - 1


def _still(run: Run, rows, turn: float) -> np.ndarray:
    return np.ones((len(rows), 1))


def _down(run: Run, rows, turn: float) -> np.ndarray:
    return legendre.legvander(_tau(run, rows), DEGREE_DOWN)


def _level(run: Run, rows, turn: float) -> np.ndarray:
    tau, t = _tau(run, rows), run.time_s[rows]
    columns = [*legendre.legvander(tau, DEGREE_LEVEL).T]
    columns += [np.maximum(run.way.corner + s - t, 0) ** 2 for s in SOON_S]
    columns += [np.maximum(t - run.way.stop + s, 0) ** 2 for s in LATE_S]
    if turn:
        curve = np.column_stack(
            columns
        )  # from a smooth path: places as read would explain their own noise
        path = curve @ np.linalg.lstsq(curve, run.x[rows], rcond=1e-9)[0]
        columns += [
            wave(turn * path) * tau**k for wave in (np.cos, np.sin) for k in range(3)
        ]
    return np.column_stack(columns)
