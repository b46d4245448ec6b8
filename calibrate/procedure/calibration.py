"""All that a calibration found, and its parameters as one table."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
import pandas as pd
from scipy import stats

from benchtwin.calibrate.procedure.bench import Bench, contradictory, missing
from benchtwin.calibrate.procedure.joint import LEVEL, Joint, fit_joint
from benchtwin.calibrate.procedure.pile import PileFit
from benchtwin.calibrate.procedure.pile_surrogate import PileObservables
from benchtwin.calibrate.procedure.simulator import SimulationFailed, Unreachable
from benchtwin.calibrate.procedure.steel import SteelFit, together
from benchtwin.calibrate.statistics.bounds import interval, open_ends

# share of its prior's sd that a bench must take away for a parameter to count as
# resolved, and to be said to be narrowed at all
NARROWED_LEAST, NARROWED_SOMEWHAT = 0.5, 0.05
# standard deviations between two rigs that tell one parameter: 1 in 370 by chance
CONTRADICTS = 3
COLUMNS = ["parameter", "value", "low", "high", "level", "unit", "status"]
COLUMNS += ["source", "budget"]
FOLLOWS = ["item", "printed", "recomputed", "follows"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Calibration:
    """What is known of a bench: handed on from rig to rig, each of which returns it
    with what it found; never changed.

    mode: "tables" or "simulated"; beside: what further rigs say of seed on seed;
    refused: {rig: why it gave nothing}; checks: printed
    values beside recomputed ones; flags: contradictions in a publication, as sentences;
    findings: what a diagnosis should look at; options: how it was run; seed: of all
    randomness; finished: False in a report that is written while simulations still run;
    more: further tables, and the pairs shown."""

    mode: str
    bench: Bench
    steel: dict[str, SteelFit] = field(default_factory=dict)
    pile: PileFit | None = None
    beside: dict[str, PileObservables] = field(default_factory=dict)
    joint: Joint | None = None
    refused: dict[str, str] = field(default_factory=dict)
    findings: tuple[str, ...] = ()
    options: dict = field(default_factory=dict)
    seed: int = 1
    checks: pd.DataFrame = field(default_factory=lambda: pd.DataFrame(columns=FOLLOWS))
    flags: tuple[str, ...] = ()
    finished: bool = True
    title: str = ""
    more: dict = field(default_factory=dict)

    @classmethod
    def of(cls, mode: str, bench: Bench, seed: int, options: dict) -> Self:
        """A bench of which nothing but its readings is known yet."""
        return cls(
            mode=mode,
            bench=bench,
            seed=seed,
            refused=missing(bench),
            findings=tuple(contradictory(bench)),
            options=options,
            finished=False,
        )

    @property
    def on_steel(self) -> dict[str, tuple[float, float]]:
        """{parameter: (value, sd)} of seed on steel."""
        return together(self.steel.values())

    def with_steel(self, name: str, fit: SteelFit) -> Self:
        """With what a seed–steel rig gave; not where another rig contradicts it."""
        before = self.on_steel.get(fit.rig.parameter)
        if before is not None:
            apart = abs(fit.inverse.value - before[0])
            if apart > CONTRADICTS * np.hypot(fit.inverse.sd, before[1]):
                why = f"its {fit.inverse.value:.4g} contradicts {before[0]:.4g}"
                said = f"{why}, the {fit.rig.parameter} of the rigs before it"
                found = replace(self, findings=(*self.findings, f"{name}: {said}"))
                return found.without(name, ValueError(said))
        return replace(self, steel={**self.steel, name: fit})

    def trying(
        self, name: str, fit: Callable[[], SteelFit | PileFit | PileObservables]
    ) -> Self:
        """With what a rig gives; where it gives nothing, with why."""
        try:
            found = fit()
        except Unreachable as error:
            findings = (*self.findings, str(error))
            return replace(self.without(name, error), findings=findings)
        except (ValueError, FileNotFoundError, SimulationFailed) as error:
            return self.without(name, error)
        if isinstance(found, PileFit):
            return self.with_pile(found)
        if isinstance(found, PileObservables):
            return replace(self, beside={**self.beside, name: found}).saying(
                *(f"{name}: {note}" for note in found.notes)
            )
        return self.with_steel(name, found)

    def with_pile(self, pile: PileFit) -> Self:
        """With what the pile gave."""
        return replace(self, pile=pile, findings=(*self.findings, *pile.findings))

    def checked(self, checks: pd.DataFrame, flags: list[str]) -> Self:
        """With printed values beside recomputed ones, and contradictions."""
        both = [t for t in (self.checks, checks) if len(t)] or [self.checks]
        table = pd.concat(both, ignore_index=True)
        return replace(self, checks=table, flags=(*self.flags, *flags))

    def without(self, rig: str, why: Exception) -> Self:
        """A rig gave nothing, and why."""
        return replace(self, refused={**self.refused, rig: str(why)})

    def saying(self, *notes: str) -> Self:
        """With sentences for the reader behind those that are said already."""
        said = [*self.options.get("said", []), *notes]
        return replace(self, options={**self.options, "said": said})

    def adding(self, **more: object) -> Self:
        """With further tables."""
        return replace(self, more={**self.more, **more})

    def joined(self, rng: np.random.Generator, **options: Any) -> Self:
        """Finished: with the posterior of all parameters together (`fit_joint`).
        ValueError where no rig gave anything."""
        if not self.steel and self.pile is None:
            why = "; ".join(f"{rig}: {reason}" for rig, reason in self.refused.items())
            folder = self.bench.folder
            raise ValueError(f"{folder}: nothing could be calibrated: {why}")
        joint = fit_joint(self.steel, self.pile, self.beside, rng=rng, **options)
        return replace(self, joint=joint, finished=True)

    @property
    def not_following(self) -> pd.DataFrame:
        """Rows of `checks` whose printed value does not follow from the tables."""
        return self.checks[~self.checks["follows"].to_numpy(bool)]


def parameters(c: Calibration) -> pd.DataFrame:
    """One row a parameter: parameter, value, low, high, level, unit, status, source,
    budget.

    status: "calibrated", or a sentence that says on what, that the parameter is bounded
    on one side only, or that it is not resolved. budget: shares of the variance by
    name."""
    rows = [_steel_row(c, name) for name in c.on_steel]
    if c.pile is not None and c.joint is not None:
        rows += [_seed_row(c, c.pile, c.joint, name) for name in c.pile.box.names]
    return pd.DataFrame(rows, columns=COLUMNS)


def _steel_row(c: Calibration, name: str) -> tuple:
    """As its rig says; of several rigs' parameter their mean, with the narrowest's
    budget."""
    fits = [fit for fit in c.steel.values() if fit.rig.parameter == name]
    best = min(fits, key=lambda fit: fit.inverse.sd).inverse
    value, low, high = best.value, best.low, best.high
    if len(fits) > 1:
        value, sd = c.on_steel[name]
        half = stats.norm.ppf((1 + best.level) / 2) * sd
        low, high = max(low, value - half), min(high, value + half)
    status = bounded(low, high, best.open_ends)
    if any(fit.verification and not fit.verification.agrees for fit in fits):
        status = "doubtful: its verification disagrees with the bench"
    source = "; ".join(_source(fit) for fit in fits)
    return name, value, low, high, best.level, "1", status, source, dict(best.budget)


def _source(fit: SteelFit) -> str:
    mean = f"{fit.bench.value:.4g} ± {fit.bench.sd:.2g} {fit.rig.unit}"
    return f"{fit.rig.name}: {fit.rig.response} {mean} on the {fit.by}"


def _seed_row(c: Calibration, pile: PileFit, joint: Joint, name: str) -> tuple:
    """The optimum's coordinate, and the posterior's interval around it; the posterior's
    median where other rigs tell the parameter, too, or packing noise hides the angle
    and something else of the same piles is seen.

    An end that the posterior does not exclude, or at which the optimum stands, is open.
    An optimum outside the interval widens it to itself: any point of the sheet fits as
    well."""
    posterior = joint.posterior
    value, draws = pile.optimum.point[name], posterior.draws[name]
    ends = open_ends(draws, pile.box.range(name))
    if c.beside or (pile.weak and pile.informative):
        value = float(draws.median())
    elif name in pile.optimum.boundary:
        ends |= {pile.optimum.boundary[name]}
    low, high = interval(draws, _searched(pile, name), ends, LEVEL)
    low, high = min(low, value), max(high, value)
    prior_sd = posterior.prior.sd[list(posterior.draws.columns).index(name)]
    narrowed = 1.0 - float(draws.std() / prior_sd)
    status = _seed_status(c, pile, narrowed, low, high, ends)
    mean = f"{pile.bench.value:.4g} ± {pile.bench.sd:.2g}°"
    source = f"pile: repose angle {mean}, one point of a sheet that fits"
    names = posterior.tension["observable"]
    also = [n.removeprefix("pile: ") for n in names if n.startswith("pile: ")][1:]
    also += [n for n in names if n.split(": ")[0] in c.beside]
    source += f"; with {', '.join(also)}" if also else ""
    budget = _seed_budget(pile, name, float(draws.var()))
    return name, value, low, high, LEVEL, "1", status, source, budget


def _seed_status(
    c: Calibration,
    pile: PileFit,
    narrowed: float,
    low: float,
    high: float,
    ends: frozenset[str],
) -> str:
    """narrowed: the share of its prior's sd that the recordings take away from the
    parameter."""
    if narrowed < NARROWED_LEAST or len(ends) == 2:
        if narrowed >= NARROWED_SOMEWHAT:
            by = f"narrows it by {100 * narrowed:.0f} %"
        else:
            by = "says nothing of it"
        who = " with the ".join(("the pile", *c.beside))
        return (
            f"not resolved: {who} {by}; it may be anything from {low:.3g} to {high:.3g}"
        )
    if c.beside or not pile.weak:
        return bounded(low, high, ends)
    if not pile.informative:
        return "not calibrated: the scatter between packings hides the pile's angle"
    on = " and ".join(of.rsplit("_", 1)[0].replace("_", " ") for of in pile.informative)
    said = bounded(low, high, ends, f" on {on}")
    return f"{said}; the scatter between packings hides the angle"


def bounded(low: float, high: float, ends: frozenset[str], on: str = "") -> str:
    """Status of a parameter whose interval is open at some of its ends.

    >>> bounded(0.436, 0.7, frozenset({"high"}))
    'only bounded: at least 0.436; nothing is known beyond 0.7'
    """
    if not ends:
        return f"calibrated{on}"
    if len(ends) == 2:
        return f"not bounded{on}: it may be anything from {low:.3g} to {high:.3g}"
    if "high" in ends:
        return (
            f"only bounded{on}: at least {low:.3g}; nothing is known beyond {high:.3g}"
        )
    return f"only bounded{on}: at most {high:.3g}; nothing is known below {low:.3g}"


def _searched(pile: PileFit, name: str) -> tuple[float, float]:
    """The range that was simulated: all of the path, or the box where there was
    none."""
    if pile.path is None:
        return pile.box.range(name)
    return float(pile.path.errors[name].min()), float(pile.path.errors[name].max())


def _seed_budget(pile: PileFit, name: str, variance: float) -> dict[str, float]:
    """Shares of a seed–seed parameter's variance: what it can move on the sheet at no
    cost, and the angle's own errors."""
    sheet, s = pile.sheet.table, pile.surface
    several = len(sheet) > 2 and variance > 0
    free = min(1.0, float(sheet[name].var()) / variance) if several else 0.0
    parts = {
        "bench scatter": pile.bench.scatter_sd**2,
        "measuring": pile.bench.shared_sd**2,
        "surface": float(s.variance(pile.optimum.coded)[0]) - s.lack_sd**2,
        "lack of fit": s.lack_sd**2,
    }
    total = sum(parts.values()) or 1.0
    of_angle = {k: (1 - free) * v / total for k, v in parts.items()}
    return {"free on the sheet": free} | of_angle
