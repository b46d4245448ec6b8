"""Where on its way a seed is braked: resistance in one window of time, travel, speed or turn; and sectors."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from calibrate.diagnose.linear import chance, fall_of_chi2, projector, stacked
from calibrate.diagnose.locate import Sector, Windows, noise_doubt
from calibrate.diagnose.problem import Fit
from calibrate.diagnose.roll.model import moved, way_of
from calibrate.diagnose.roll.motion import NOTHING, Table
from calibrate.diagnose.roll.problem import PUSH

BINS = 5
POINTS = 400
SOON_S = (0.0, 0.015, 0.06)  # behind the corner: these still belong to the onset
RUN_OUT_BINS = 8


@dataclass(frozen=True, eq=False)
class Flown:
    """Each run at the fit: way, what is read and speed (n,) at the rows."""

    ways: tuple
    seen: tuple[np.ndarray, ...]
    speed: tuple[np.ndarray, ...]

    def since(self, r: int, times: np.ndarray) -> np.ndarray:
        return times - self.ways[r].t0


def flown(fit: Fit) -> Flown:
    """The fitted runs."""
    model, at = fit.problem.model, fit.by_name
    ways = tuple(way_of(model, r, own, at) for r, own in enumerate(fit.starts))
    found = [moved(model, r, own, at) for r, own in enumerate(fit.starts)]
    return Flown(ways, tuple(f[0] for f in found), tuple(f[1] for f in found))


def response(fit: Fit, at: Flown, r: int, **tables) -> np.ndarray:
    """(n,) [m]: change of run r's travel for a push (or resistance, or way) of PUSH, over PUSH."""
    out = moved(fit.problem.model, r, fit.starts[r], fit.by_name, **({"way": at.ways[r]} | tables))[0]
    return (out - at.seen[r]) / PUSH


def bump(low: float, high: float, reach: float) -> Table:
    """−PUSH between low and high, nothing elsewhere, over [0, reach]."""
    grid = np.linspace(0.0, reach, POINTS)
    width = grid[1]
    inside = np.clip((grid - low) / width + 0.5, 0, 1) * np.clip((high - grid) / width + 0.5, 0, 1)
    return Table(0.0, float(width), -PUSH * inside)


def windows_of(fit: Fit) -> Windows:
    """A resistance over weight in every bin of every axis, on the way from the release to the stop."""
    at, model = flown(fit), fit.problem.model
    last = [float(t[s > 0.01 * s.max()].max()) for t, s in zip((run.time_s for run in model.runs), at.speed, strict=True)]
    reach_t = max(t - way.t0 for t, way in zip(last, at.ways, strict=True))
    reach_x = max(float(x[-1] - way.x0) for x, way in zip(at.seen, at.ways, strict=True))
    top = max(float(s.max()) for s in at.speed)
    where, columns = [], []
    for axis, reach, unit in (("t_s", reach_t, 1.0), ("x_mm", reach_x, 1e3), ("v_m_s", top, 1.0)):
        for low, high in pairwise(np.linspace(0.0, reach, BINS + 1)):
            table = bump(low, high, 1.3 * reach)
            where.append((axis, low * unit, high * unit))
            columns.append([_at_axis(fit, at, r, axis, table) for r in range(len(model.runs))])
    if np.all(model.turn > 0) and all(run.turning for run in model.runs):
        for low, high in pairwise(np.linspace(0.0, 2 * np.pi, BINS + 1)):
            where.append(("phase", float(low), float(high)))
            columns.append([response(fit, at, r, place=_phase(model, at, r, low, high)) for r in range(len(model.runs))])
    return Windows([np.column_stack(c) for c in zip(*columns, strict=True)], tuple(where))


def _at_axis(fit: Fit, at: Flown, r: int, axis: str, table: Table) -> np.ndarray:
    if axis == "v_m_s":
        return response(fit, at, r, more=replace(table, values=-table.values))
    return response(fit, at, r, **{"time" if axis == "t_s" else "place": table})


def _phase(model, at: Flown, r: int, low: float, high: float) -> Table:
    """−PUSH where the ripple's argument, modulo 2π, lies between low and high."""
    reach = 1.3 * float(at.seen[r][-1] - at.ways[r].x0)
    grid = np.linspace(0.0, reach, 2000)
    phi = np.mod(model.turn[r] * (grid + at.ways[r].x0) + model.phase[r], 2 * np.pi)
    return Table(0.0, float(grid[1]), -PUSH * ((phi >= low) & (phi < high)))


def sectors_of(fit: Fit, rng: np.random.Generator) -> tuple[Sector, ...]:
    """Onset (incline, corner and 60 ms behind it) and run-out (what follows), each freed in windows common to all runs."""
    extra, owner = _sector_columns(fit)
    a, b = stacked(fit.problem.reduce(fit.starts, fit.values, extra)[0])
    a, columns = np.split(a, [len(fit.names)], axis=1)
    ripple = [i for i, n in enumerate(fit.names) if n.startswith("shape-barrier.") and fit.prior_sd[i] == 0]
    columns, owner = np.hstack([columns, a[:, ripple]]), [*owner, *(["run-out"] * len(ripple))]
    project, doubt = projector(a, fit.prior_sd), noise_doubt(fit, rng)
    fall, count = fall_of_chi2(columns, project, b)
    excess, found = max(fall - count, 0.0), []
    for name in ("onset", "run-out"):
        part, freedom = fall_of_chi2(columns[:, [o == name for o in owner]], project, b)
        share = float(np.clip((part - freedom) / excess, 0, 1)) if excess > 0 else float("nan")
        found.append(Sector(name, share, chance(part, freedom, doubt)))
    return tuple(sorted(found, key=lambda s: (-np.nan_to_num(s.explained), s.p)))


def _sector_columns(fit: Fit) -> tuple[list[np.ndarray], list[str]]:
    """Columns (n, K) of each run, and the sector of each column."""
    at, model, made, owner = flown(fit), fit.problem.model, [], []
    reach = max(float(x[-1] - way.corner) for x, way in zip(at.seen, at.ways, strict=True))
    for r, (run, way) in enumerate(zip(model.runs, at.ways, strict=True)):
        length = way.corner - way.x0
        corner_s = float(np.interp(way.corner, np.maximum.accumulate(at.seen[r]), run.time_s)) - way.t0
        soon = way.corner + float(np.interp(corner_s + way.t0 + SOON_S[-1], run.time_s, at.seen[r] - way.corner)) - way.x0
        total = 1.3 * (length + reach)
        columns, owner = [response(fit, at, r, way=replace(way, keep=way.keep * (1 - PUSH)))], ["onset"]
        for low, high in ((0.0, length / 2), (length / 2, length)):
            columns.append(response(fit, at, r, place=bump(low, high, 1.5 * length)))
            owner.append("onset")
        for low, high in pairwise(SOON_S):
            columns.append(response(fit, at, r, time=bump(corner_s + low, corner_s + high, corner_s + 0.2)))
            owner.append("onset")
        for low, high in pairwise(np.linspace(soon, length + reach, RUN_OUT_BINS + 1)):
            columns.append(response(fit, at, r, place=bump(low, high, total)))
            owner.append("run-out")
        columns += [response(fit, at, r, place=NOTHING if run.sign > 0 else _uphill(length, total))]
        owner.append("run-out")
        made.append(np.column_stack(columns))
    return made, owner


def _uphill(length: float, total: float) -> Table:
    """A push on the level of the runs towards −x only: what both directions do not share."""
    return bump(length, total, total)
