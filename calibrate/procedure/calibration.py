"""All that a calibration found, and its parameters as one table."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
import pandas as pd

from benchtwin.bench.language import tr
from benchtwin.bench.numbers import to_interval
from benchtwin.calibrate.procedure.bench import Bench, contradictory, missing
from benchtwin.calibrate.procedure.joint import Joint, fit_joint
from benchtwin.calibrate.procedure.next_tests import in_words, untried_in_words
from benchtwin.calibrate.procedure.observed import PileObservables
from benchtwin.calibrate.procedure.rigs import PARAMETERS, SEED_FACTORS
from benchtwin.calibrate.procedure.simulator import SimulationFailed, Unreachable
from benchtwin.calibrate.procedure.steel import SteelFit, together
from benchtwin.calibrate.procedure.surface import SurfaceFit
from benchtwin.calibrate.statistics.bench import Verification
from benchtwin.calibrate.statistics.bounds import interval, open_ends

LEVEL = 0.95
# share of its prior's sd that a bench must take away for a parameter to count as
# resolved
NARROWED_LEAST = 0.5
SAYS_NOTHING = 0.95  # share of its prior's sd that is left
# standard deviations between two rigs that tell one parameter: 1 in 370 by chance
CONTRADICTS = 3
CALIBRATED, BOUNDED = "calibrated", "only bounded"
UNRESOLVED, DOUBTFUL = "not resolved", "doubtful"
COLUMNS = ["parameter", "value", "low", "high", "level", "unit", "status", "remark"]
COLUMNS += ["most_probable_set", "source", "budget"]
FOLLOWS = ["item", "printed", "recomputed", "follows"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Calibration:
    """What is known of a bench: handed on from rig to rig, each of which returns it
    with what it found; never changed.

    mode: "tables" or "simulated"; steel, seeds: what each rig says of seed on steel and
    of seed on seed; surface: the steps of a publication; joint: all of them together;
    verified: simulations of the most probable set beside the bench, by observable;
    refused: {rig: why it gave nothing}; checks: printed values beside recomputed ones;
    flags: contradictions in a publication, as sentences; findings: what a diagnosis
    should look at; options: how it was run; seed: of all randomness; finished: False in
    a report that is written while simulations still run; more: further tables, and the
    pairs shown."""

    mode: str
    bench: Bench
    steel: dict[str, SteelFit] = field(default_factory=dict)
    seeds: dict[str, PileObservables] = field(default_factory=dict)
    surface: SurfaceFit | None = None
    joint: Joint | None = None
    verified: dict[str, Verification] = field(default_factory=dict)
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
        """{parameter: (value, sd)} of seed on steel, by its own rigs."""
        return together(self.steel.values())

    @property
    def most_probable(self) -> dict[str, float]:
        """The set of parameters with the highest joint density, in the digits that
        their intervals carry: what is exported and simulated."""
        table = parameters(self)
        return dict(zip(table["parameter"], table["most_probable_set"]))

    def with_steel(self, name: str, fit: SteelFit) -> Self:
        """With what a seed–steel rig gave; not where another rig contradicts it."""
        before = self.on_steel.get(fit.rig.parameter)
        if before is not None:
            apart = abs(fit.value - before[0])
            if apart > CONTRADICTS * np.hypot(fit.sd, before[1]):
                why = tr("its {:.4g} contradicts {:.4g}", fit.value, before[0])
                said = tr("{}, the {} of the rigs before it", why, fit.rig.parameter)
                found = replace(self, findings=(*self.findings, f"{name}: {said}"))
                return found.without(name, ValueError(said))
        return replace(self, steel={**self.steel, name: fit})

    def with_seeds(self, name: str, seen: PileObservables) -> Self:
        """With what a rig says of seed on seed."""
        said = (f"{name}: {note}" for note in seen.notes)
        found = replace(self, findings=(*self.findings, *seen.findings))
        return replace(found, seeds={**self.seeds, name: seen}).saying(*said)

    def trying(self, name: str, fit: Callable[[], Self]) -> Self:
        """What a rig makes of this; where it gives nothing, with why."""
        try:
            return fit()
        except Unreachable as error:
            findings = (*self.findings, str(error))
            return replace(self.without(name, error), findings=findings)
        except (ValueError, FileNotFoundError, SimulationFailed) as error:
            return self.without(name, error)

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
        """With the posterior of all parameters together (`fit_joint`). ValueError where
        no rig gave anything."""
        if not self.steel and not self.seeds:
            why = "; ".join(f"{rig}: {reason}" for rig, reason in self.refused.items())
            folder = self.bench.folder
            raise ValueError(tr("{}: nothing could be calibrated: {}", folder, why))
        joint = fit_joint(self.steel, self.seeds, rng=rng, **options)
        missed = joint.posterior.tension.query("not reached")
        findings = (
            tr(
                "finding for diagnosis: nothing that was simulated gives the bench's {}"
                " {:.4g}: it comes to {:.4g}",
                row.observable,
                row.bench,
                row.predicted,
            )
            for row in missed.itertuples()
        )
        return replace(self, joint=joint, findings=(*self.findings, *findings))

    @property
    def not_following(self) -> pd.DataFrame:
        """Rows of `checks` whose printed value does not follow from the tables."""
        return self.checks[~self.checks["follows"].to_numpy(bool)]


def parameters(c: Calibration) -> pd.DataFrame:
    """One row a parameter, all that is printed, drawn or exported of it: parameter;
    value (the posterior's median); low, high (interval at `level`); unit; status
    (CALIBRATED, BOUNDED, UNRESOLVED, DOUBTFUL) and remark, what it means;
    most_probable_set, its value in the one set with the highest joint density; source;
    budget (shares of its variance by name, where one reading tells it alone).

    Numbers have the digits that the interval carries."""
    if c.joint is None:
        return pd.DataFrame(columns=COLUMNS)
    known = c.joint.posterior.draws.columns
    rows = [_row(c, c.joint, name) for name in PARAMETERS if name in known]
    return pd.DataFrame(rows, columns=COLUMNS)


def advice(c: Calibration) -> list[str]:
    """Which test to run next, in sentences: first such as tell by themselves what is
    left open, then what more of the recorded ones would leave."""
    if c.joint is None:
        return []
    simulated = in_words(c.joint.next_tests)
    if not c.seeds or c.options.get("effort", {}).get("unrecorded", True):
        return simulated
    table = parameters(c)
    left = table.loc[table["status"] != CALIBRATED, "parameter"]
    of_seeds = [name for name in left if name in SEED_FACTORS]
    return [*untried_in_words(of_seeds, c.bench.rigs), *simulated]


def _row(c: Calibration, joint: Joint, name: str) -> tuple:
    posterior = joint.posterior
    draws, limits = posterior.draws[name], posterior.prior.box.range(name)
    ends = open_ends(draws, limits)
    low, high = interval(draws, limits, ends, LEVEL)
    middle, most_probable = (
        to_interval(v, low, high) for v in (draws.median(), posterior.mode[name])
    )
    low, high = to_interval(low, low, high), to_interval(high, low, high)
    telling = _telling(c, name)
    status, remark = _status(c, joint, name, (low, high), ends)
    found = (name, middle, low, high, LEVEL, "1", status, remark, most_probable)
    return *found, "; ".join(telling), _budget(c, name)


def _telling(c: Calibration, name: str) -> list[str]:
    """Readings that depend on a parameter more than as a nuisance: of its own rig for
    seed on steel, of all that tell of seed on seed for those."""
    rigs = [fit.observable for fit in c.steel.values() if fit.rig.parameter == name]
    if name in SEED_FACTORS:
        rigs = [o for seen in c.seeds.values() for o in seen.observables]
    return [f"{o.name} {o.bench.value:.4g} ± {o.bench.sd:.2g}" for o in rigs]


def _status(
    c: Calibration,
    joint: Joint,
    name: str,
    found: tuple[float, float],
    ends: frozenset[str],
) -> tuple[str, str]:
    """Status and remark of a parameter with this interval and these open ends."""
    own = [n for n, fit in c.steel.items() if fit.rig.parameter == name]
    rigs = list(c.seeds) if name in SEED_FACTORS else own
    if off := [
        o for o, v in c.verified.items() if o.split(": ")[0] in rigs and not v.agrees
    ]:
        said = ", ".join(off)
        return DOUBTFUL, tr(
            "simulations of the most probable set miss the bench's {}", said
        )
    ratio = joint.table.set_index("factor").loc[name, "sd_ratio"]
    if 1 - ratio < NARROWED_LEAST or len(ends) == 2:
        narrower = tr("only {:.1f} times narrower", 1 / ratio)
        return UNRESOLVED, (
            tr("the recordings say next to nothing of it")
            if ratio > SAYS_NOTHING
            else tr("the recordings make its interval {}", narrower)
        )
    low, high = (f"{v:g}" for v in found)
    if "high" in ends:
        return BOUNDED, tr("at least {}; nothing is known beyond {}", low, high)
    if "low" in ends:
        return BOUNDED, tr("at most {}; nothing is known below {}", high, low)
    return CALIBRATED, ""


def _budget(c: Calibration, name: str) -> dict[str, float]:
    """Shares of the variance of a parameter that one reading tells alone."""
    fits = [fit for fit in c.steel.values() if fit.rig.parameter == name]
    if len(fits) != 1:
        return {}
    (fit,) = fits
    parts = {
        "bench scatter": fit.bench.scatter_sd**2,
        "measuring": fit.bench.shared_sd**2,
        "simulation": float(fit.surrogate.evaluate([[fit.value]])[1][0]),
    }
    return {part: v / sum(parts.values()) for part, v in parts.items()}
