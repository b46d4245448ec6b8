"""Noise of a session's rolls: of rows by themselves first, then about their fit."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre

from benchtwin.bench.priors import unstated_sd
from benchtwin.bench.robust import difference_noise
from benchtwin.infer.noise import Noise
from benchtwin.infer.problem import Fit
from benchtwin.infer.series import noise_about, spread_of_few
from benchtwin.rigs.roll.session import Run

EXACT_M = 3e-6  # floor for simulated tracks
ENOUGH_ROWS = (
    10  # spare rows from which gates' noise is estimated instead of taken as stated
)
USUAL_SD_M = unstated_sd("row-of-few") / 1000  # where neither stated nor estimated
STATED_LEVEL_SD = 0.3  # of ln of a stated noise's power
DEGREE = 6  # of smooth curves


@dataclass(frozen=True)
class RunNoise:
    """noise: common to the session; sigma (R,) [m] of each run."""

    noise: Noise
    sigma: np.ndarray


def first_noise(runs: tuple[Run, ...]) -> RunNoise:
    """White: of few rows as stated, else as usual; of many by their differences."""
    sigma = [
        _stated(run, USUAL_SD_M) if has_few_rows(run) else difference_noise(run.x, 2)
        for run in runs
    ]
    return RunNoise(Noise(0.0, 0.0, 1.0), np.maximum(sigma, EXACT_M))


def noise_of(base: Fit, before: RunNoise) -> RunNoise:
    """About a fit with the noise `before`; few rows keep their stated sds, but those of
    light gates that tell them better."""
    runs, sigma = base.problem.model.runs, before.sigma.copy()
    noise, factor = noise_about(base)
    few = [has_few_rows(run) for run in runs]
    if any(few):
        # five numbers nearly explain few rows of both legs: the usual sd counts as one
        passing = any(f and not run.stays for f, run in zip(few, runs, strict=True))
        told, spare = spread_of_few(base, float(passing))
        spare += passing
        for r in np.flatnonzero(few):
            stated = math.isfinite(_stated(runs[r], math.nan))
            if not stated or (runs[r].gates and spare >= ENOUGH_ROWS):
                factor[r] = told
        stated_all = all(
            np.isfinite(run.sd_m).all() for run in runs if has_few_rows(run)
        )
        level = STATED_LEVEL_SD if stated_all else math.sqrt(2 / max(spare, 1.0))
        noise = Noise(0.0, 0.0, level) if all(few) else noise
    return RunNoise(noise, np.maximum(factor * sigma, EXACT_M))


def _stated(run: Run, unstated: float) -> float:
    """Stated σ [m] of few rows."""
    stated = float(np.median(run.sd_m / row_weight(run)))
    return stated if stated > 0 else unstated


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


def smooth_curves(run: Run) -> np.ndarray:
    """(n, k) smooth curves over a run's way from release to stop."""
    rows = np.flatnonzero((run.time_s > run.way.release) & (run.time_s < run.way.stop))
    seen = len(run.time_s) + (run.junction is not None)
    out = np.zeros((seen, DEGREE + 1))
    if len(rows) > 2 * out.shape[1]:
        out[rows] = legendre.legvander(_tau(run, rows), DEGREE)
    return out * float(np.median(np.abs(np.diff(run.x)))) if len(run.x) > 1 else out


def _tau(run: Run, rows) -> np.ndarray:
    t = run.time_s[rows]
    return 2 * (t - t[0]) / (t[-1] - t[0]) - 1
