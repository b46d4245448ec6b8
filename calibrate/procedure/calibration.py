"""All that a calibration found, and its parameters as one table."""

from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from calibrate.procedure.bench import Bench
from calibrate.procedure.joint import Joint
from calibrate.procedure.pile import PileFit, weak
from calibrate.procedure.steel import SteelFit

LEVEL = 0.95
NARROWED_LEAST = 0.5  # share of its prior's sd that a bench must take away for a parameter to count as resolved
FOLLOWS = ["item", "printed", "recomputed", "follows"]


@dataclass(frozen=True, eq=False)
class Calibration:
    """mode: "tables" or "simulated"; refused: {rig: why it gave nothing}; checks: printed values beside recomputed ones; flags:
    what a publication contradicts, as sentences; findings: what diagnosis should look at; options: how it was run; seed: of all
    randomness; finished: False in a report that is written while simulations still run."""

    mode: str
    bench: Bench
    steel: dict[str, SteelFit]
    pile: PileFit | None
    joint: Joint | None
    refused: dict[str, str]
    checks: pd.DataFrame
    flags: tuple[str, ...]
    findings: tuple[str, ...]
    options: dict
    seed: int
    finished: bool = True
    title: str = ""
    more: dict = field(default_factory=dict)


def parameters(c: Calibration) -> pd.DataFrame:
    """One row a parameter: parameter, value, low, high, level, unit, status, source, budget (shares of the variance, by name).

    status: "calibrated", or a sentence: on what, at which limit of what was simulated, or that it is not resolved.
    """
    rows = [_steel_row(fit) for fit in c.steel.values()]
    if c.pile is not None and c.joint is not None:
        rows += [_seed_row(c.pile, c.joint, name) for name in c.pile.box.names]
    columns = ["parameter", "value", "low", "high", "level", "unit", "status", "source", "budget"]
    return pd.DataFrame(rows, columns=columns)


def _steel_row(fit: SteelFit) -> tuple:
    i = fit.inverse
    source = f"{fit.rig.name}: {fit.rig.response} {fit.bench.value:.4g} ± {fit.bench.sd:.2g} {fit.rig.unit} on the {fit.by}"
    cut = [n for n in fit.notes if "cut off" in n]
    status = f"calibrated; {cut[0].partition(':')[0]}" if cut else "calibrated"
    if fit.verification is not None and not fit.verification.agrees:
        status = "doubtful: its verification disagrees with the bench"
    return fit.rig.parameter, i.value, i.low, i.high, i.level, "1", status, source, dict(i.budget)


def _seed_row(pile: PileFit, joint: Joint, name: str) -> tuple:
    """The optimum's coordinate, and the posterior's interval around it; the posterior's median where packing noise hides the
    angle and something else of the same piles is seen.

    At a limit of the box the interval is one-sided. What only the design's box cuts off goes on to the end of
    the path. A point off the posterior's middle widens it to itself: any point of the sheet fits as well.
    """
    value, draws = pile.optimum.point[name], joint.posterior.draws[name]
    j = pile.box.names.index(name)
    edge = pile.optimum.boundary.get(name)
    hidden = weak(pile.surface)
    if hidden and pile.shown:
        value, edge = float(draws.median()), None
    tail = 1 - LEVEL
    ends = {"low": (0.0, 1 - tail), "high": (tail, 1.0)}.get(edge or "", (tail / 2, 1 - tail / 2))
    low, high = (float(v) for v in np.quantile(draws, ends))
    if edge:
        low, high = (float(pile.box.low[j]), high) if edge == "low" else (low, float(pile.box.high[j]))
    low, high = beyond((low, high), (pile.box.low[j], pile.box.high[j]), _sought(pile, name))
    low, high = min(low, value), max(high, value)
    ratio = float(draws.std() / joint.posterior.prior.sd[list(joint.posterior.draws.columns).index(name)])
    status = _seed_status(pile, name, edge, 1.0 - ratio, (low, high), hidden=hidden)
    source = f"pile: repose angle {pile.bench.value:.4g} ± {pile.bench.sd:.2g}°, one point of a sheet that fits"
    also = [row.removeprefix("pile: ") for row in joint.posterior.tension["observable"] if row.startswith("pile: ")][1:]
    source += f"; with {', '.join(also)}" if also else ""
    return name, value, low, high, LEVEL, "1", status, source, _seed_budget(pile, name, float(draws.var()))


def _seed_status(pile: PileFit, name: str, edge: str | None, narrowed: float, within: tuple[float, float], *, hidden: bool) -> str:
    """What the pile says of one seed–seed parameter; narrowed: the share of its prior's sd that the pile takes away."""
    low, high = (f"{v:.3g}" for v in within)
    limit = f"at the {edge} limit of what was simulated" if edge else ""
    if narrowed < NARROWED_LEAST:
        by = f"the pile narrows it by {100 * narrowed:.0f} %" if narrowed >= 0.05 else "the pile says nothing of it"
        return f"{f'{limit}, ' if limit else ''}not resolved: {by}; it may be anything from {low} to {high}"
    if hidden and pile.shown:
        seen = " and ".join(of.rsplit("_", 1)[0].replace("_", " ") for of in pile.shown)
        return f"calibrated on {seen}; the scatter between packings hides the angle"
    if hidden:
        return "not calibrated: the scatter between packings hides the pile's angle"
    return limit or "calibrated"


def beyond(interval: tuple[float, float], box: tuple[float, float], sought: tuple[float, float]) -> tuple[float, float]:
    """An interval that comes as near as a tenth of the design's box to an end of it, carried on to the end of what was asked for:
    the posterior knows nothing beyond the box, and other values may fit there.

    >>> beyond((0.555, 0.61), (0.55, 0.65), (0.45, 0.70))
    (0.45, 0.61)
    """
    low, high, tenth = *interval, (box[1] - box[0]) / 10
    low = min(low, sought[0]) if low < box[0] + tenth else low
    high = max(high, sought[1]) if high > box[1] - tenth else high
    return float(low), float(high)


def _sought(pile: PileFit, name: str) -> tuple[float, float]:
    """Where a parameter was looked for: all of the path, or the box where there was none."""
    if pile.path is None:
        j = pile.box.names.index(name)
        return float(pile.box.low[j]), float(pile.box.high[j])
    return float(pile.path.errors[name].min()), float(pile.path.errors[name].max())


def _seed_budget(pile: PileFit, name: str, variance: float) -> dict[str, float]:
    """Shares of a seed–seed parameter's variance: what it can move on the sheet at no cost, and the angle's own errors."""
    sheet = pile.sheet.table
    free = min(1.0, float(sheet[name].var()) / variance) if len(sheet) > 2 and variance > 0 else 0.0
    s = pile.surface
    fit = float(s.variance(pile.optimum.coded)[0]) - s.lack_sd**2
    parts = {"bench scatter": pile.bench.scatter_sd**2, "measuring": pile.bench.shared_sd**2, "surface": fit,
             "lack of fit": s.lack_sd**2}  # fmt: skip
    total = sum(parts.values()) or 1.0
    return {"free on the sheet": free} | {k: (1 - free) * v / total for k, v in parts.items()}
