"""Seed on steel: one parameter, simulated over a range that is extended until the
bench's mean lies inside, and the surrogate through the runs."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from benchtwin.bench.language import tr
from benchtwin.bench.tells import ByCurve
from benchtwin.calibrate.procedure.bench import RigReadings
from benchtwin.calibrate.procedure.effort import Effort
from benchtwin.calibrate.procedure.simulator import (
    Run,
    Simulator,
    Unreachable,
    seed_numbers,
    usable,
)
from benchtwin.calibrate.statistics.bench import BenchMean
from benchtwin.calibrate.statistics.bounds import open_ends
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.equation import Equation, fit_equation
from benchtwin.calibrate.statistics.posterior import Observable, Posterior, on_grid
from benchtwin.calibrate.statistics.prior import Prior
from benchtwin.calibrate.statistics.surrogate import Surrogate, fit_surrogate

# of a single parameter: fine beside any interval, and quicker than a chain
GRID_CELLS = 40_001
# times that a range is extended: each at most doubles it, so that five can make it 32
# times as wide
EXTENSIONS = 5
# of them, those that only widen an interval which the range's end cuts off
WIDENINGS = 2
# half widths of the first range, and how far towards zero one step may go, as shares of
# its middle or its low end: far enough to see a slope, and never past zero
FIRST_HALF, NEARER = 0.25, 0.4
# of the variance from the surrogate, above which the range is narrowed around the
# answer where the runs scatter about it with so many times the variance of repeats
SURROGATE_SHARE, MISFIT = 0.25, 2.0


@dataclass(frozen=True, kw_only=True, eq=False)
class SteelFit:
    """What one rig says of its parameter.

    rows: what was simulated, a row a value; posterior: of this rig alone; direct: the
    parameter by the rig's own formula, without simulation; notes."""

    rig: ByCurve
    bench: BenchMean
    rows: pd.DataFrame
    surrogate: Surrogate
    posterior: Posterior
    direct: float | None
    notes: tuple[str, ...] = ()

    @property
    def equation(self) -> Equation:
        """The curve that a publication lays through such rows."""
        rig = self.rig
        return fit_equation(self.rows, rig.parameter, rig.response, rig.degree)

    @property
    def observable(self) -> Observable:
        name = f"{self.rig.name}: {self.rig.response}"
        return Observable(name, self.surrogate, self.bench)

    @property
    def value(self) -> float:
        """Median of the rig's own posterior."""
        return float(self.posterior.draws[self.rig.parameter].median())

    @property
    def sd(self) -> float:
        return float(self.posterior.draws[self.rig.parameter].std())

    @property
    def reached(self) -> bool:
        """Whether some value of those simulated gives the bench's mean."""
        return bool(self.posterior.tension["reached"].all())


def fit_steel(
    rig: ByCurve, runs: pd.DataFrame, readings: RigReadings, rows: pd.DataFrame
) -> SteelFit:
    """The surrogate through runs, a row each, and what the bench's mean then says; a
    single reading scatters as single runs do. ValueError as `fit_surrogate` and
    `bench_mean`."""
    x = runs[rig.parameter]
    box = Box.of({rig.parameter: (float(x.min()), float(x.max()))})
    surrogate = fit_surrogate(runs, rig.response, box)
    bench = readings.mean(other=(surrogate.noise_sd, surrogate.noise_df))
    observable = Observable(f"{rig.name}: {rig.response}", surrogate, bench)
    posterior = on_grid(
        [observable],
        Prior.uniform(box),
        rng=np.random.default_rng(1),
        cells=GRID_CELLS,
    )
    return SteelFit(
        rig=rig,
        bench=bench,
        rows=rows,
        surrogate=surrogate,
        posterior=posterior,
        direct=rig.direct(bench.value, readings.description),
    )


def together(fits: Iterable[SteelFit]) -> dict[str, tuple[float, float]]:
    """{parameter: (value, sd)}; of several rigs that tell one parameter the mean, each
    weighed by 1/sd²."""
    found: dict[str, tuple[float, float]] = {}
    for fit in fits:
        new, name = (fit.value, fit.sd), fit.rig.parameter
        found[name] = _weighed(found[name], new) if name in found else new
    return found


def _weighed(a: tuple[float, float], b: tuple[float, float]) -> tuple[float, float]:
    share = b[1] ** 2 / (a[1] ** 2 + b[1] ** 2)
    value = share * a[0] + (1 - share) * b[0]
    return value, a[1] * b[1] / float(np.hypot(a[1], b[1]))


@dataclass(frozen=True, kw_only=True)
class SteelStage:
    """What one rig's simulations need. fixed: parameters found before; description:
    sections of the recordings; seed: of the run."""

    rig: ByCurve
    readings: RigReadings
    fixed: dict[str, float]
    description: dict
    simulate: Simulator
    effort: Effort
    seed: int

    def runs(self, values: ArrayLike, repeats: int, what: str) -> list[Run]:
        """Repeats of every value, each with a generator of its own; with what its
        runs have by turns."""
        name, parameter = self.rig.name, self.rig.parameter
        return [
            Run(
                name,
                {**self.fixed, parameter: float(v)},
                seed_numbers(self.seed, name, what, float(v), k),
                self._turn(k),
            )
            for v in np.asarray(values)
            for k in range(repeats)
        ]

    def _turn(self, k: int) -> dict:
        section = self.description.get(self.rig.name, {})
        return self.description | {self.rig.name: self.rig.rig.turn(k, section)}

    def fit(self, runs: pd.DataFrame) -> SteelFit:
        return fit_steel(self.rig, runs, self.readings, self._rows(runs))

    def _rows(self, runs: pd.DataFrame) -> pd.DataFrame:
        """A row a value: parameter, mean response, sd of single runs, repeats."""
        by = runs.groupby(self.rig.parameter)[self.rig.response]
        rows = {self.rig.response: by.mean(), self.rig.sd: by.std(ddof=1)}
        return pd.DataFrame(rows | {"repeats": by.count()}).reset_index()


def simulate_steel(stage: SteelStage) -> SteelFit:
    """Simulate, fit, extend, narrow. Raises Unreachable, SimulationFailed; ValueError
    for readings without scatter."""
    if stage.readings.values.size > 1:
        # readings that cannot be used are refused before anything is simulated
        stage.readings.mean()
    values = first_values(stage)
    runs, notes = _simulated(stage, values)
    for attempt in range(EXTENSIONS + 1):
        fit = stage.fit(runs)
        beyond = _beyond(fit, widen=attempt < WIDENINGS)
        if beyond is None or attempt == EXTENSIONS:
            break
        values = _next_values(stage, runs, *beyond)
        if not values.size:
            break
        new, more = _simulated(stage, values)
        runs = pd.concat([runs, new], ignore_index=True)
        ends = f"{values.min():.3g} … {values.max():.3g}"
        notes += [*more, tr("range extended to {} {}", stage.rig.parameter, ends)]
    if not fit.reached:
        rig, x = stage.rig, fit.rows[stage.rig.parameter]
        raise Unreachable(
            tr(
                "finding for diagnosis: no {} from {:g} to {:g} gives the bench's"
                " {:.4g} {}",
                rig.parameter,
                x.min(),
                x.max(),
                fit.bench.value,
                rig.unit,
            )
        )
    fit, more = _narrowed(stage, fit)
    return replace(fit, notes=tuple(dict.fromkeys(notes + more)))


def first_values(stage: SteelStage) -> np.ndarray:
    """Where to begin: about the parameter that Eqs. 1–3 give for the bench's mean."""
    rig, middle = stage.rig, float(stage.readings.values.mean())
    centre = rig.direct(middle, stage.readings.description) or rig.first
    half = max(min(rig.step, NEARER * centre), FIRST_HALF * centre)
    low, high = max(rig.limits[0], centre - half), min(rig.limits[1], centre + half)
    return _three_digits(np.linspace(low, high, stage.effort.levels))


def _three_digits(values: np.ndarray) -> np.ndarray:
    return np.array([float(f"{v:.3g}") for v in values])


def _simulated(stage: SteelStage, values: np.ndarray) -> tuple[pd.DataFrame, list[str]]:
    """Runs of these values that gave something, and what to say of the others."""
    runs = stage.runs(values, stage.effort.repeats, "curve")
    table = stage.simulate(runs)
    there, notes = usable(table, stage.rig.response)
    at = [r.values[stage.rig.parameter] for r in runs]
    read = {
        stage.rig.parameter: at,
        stage.rig.response: list(table[stage.rig.response]),
    }
    return pd.DataFrame(read)[there.to_numpy()], notes


def _beyond(fit: SteelFit, *, widen: bool) -> tuple[str, float] | None:
    """On which side of the range to go on, and about how far; None where the bench's
    mean lies inside, with `widen` its interval too."""
    limits = fit.surrogate.box.range(fit.rig.parameter)
    if not fit.reached:
        seen = fit.surrogate.evaluate(np.array(limits)[:, None])[0]
        slope = (seen[1] - seen[0]) / (limits[1] - limits[0])
        k = int(np.argmin(abs(fit.bench.value - seen)))
        off = (fit.bench.value - seen[k]) / slope if slope else np.nan
        return ("low", "high")[k], float(limits[k] + off)
    draws = fit.posterior.draws[fit.rig.parameter].to_numpy()
    ends = sorted(open_ends(draws, limits)) if widen else []
    reach = 4 * fit.sd
    return next(
        ((e, fit.value + (reach if e == "high" else -reach)) for e in ends), None
    )


def _next_values(
    stage: SteelStage, runs: pd.DataFrame, side: str, about: float
) -> np.ndarray:
    """Values beyond the range on the side that is asked for, up to a little past the
    guess, within the parameter's limits."""
    rig, x = stage.rig, np.unique(runs[stage.rig.parameter])
    end, step = (x[0], -1) if side == "low" else (x[-1], 1)
    guess = about if np.isfinite(about) else end + step * np.ptp(x)
    # a straight guess may fall far off a curve: not farther than one range at a time
    reach = min(1.5 * abs(guess - end) + 0.1 * np.ptp(x), np.ptp(x))
    target = float(np.clip(end + step * reach, *rig.limits))
    if target <= NEARER * end:
        target = max(rig.limits[0], NEARER * end)
    if abs(target - end) < 1e-3 * np.ptp(x):
        return np.zeros(0)
    many = max(3, stage.effort.levels // 2) + 1
    new = _three_digits(np.linspace(end, target, many)[1:])
    return np.unique(new[~np.isin(new, x)])


def _narrowed(stage: SteelStage, fit: SteelFit) -> tuple[SteelFit, list[str]]:
    """Where the surrogate does not follow the runs, and that matters, values close
    about the answer are simulated and fitted alone."""
    within = float(np.sqrt(np.mean(fit.rows[stage.rig.sd].dropna() ** 2)))
    own = float(fit.surrogate.evaluate([[fit.value]])[1][0])
    matters = own > SURROGATE_SHARE * (own + fit.bench.sd**2)
    if not matters or fit.surrogate.noise_sd**2 <= MISFIT * within**2:
        return fit, []
    x = fit.rows[stage.rig.parameter]
    half = max(0.15 * fit.value, 3 * fit.sd, 0.02 * float(np.ptp(x)))
    low, high = np.clip([fit.value - half, fit.value + half], *stage.rig.limits)
    values = _three_digits(np.linspace(low, high, stage.effort.levels))
    close, notes = _simulated(stage, values)
    again = stage.fit(close)
    if not again.reached:
        return fit, notes
    said = tr(
        "narrowed to {:.3g} … {:.3g}, because the surrogate does not follow", low, high
    )
    return again, [*notes, tr("{} the whole range", said)]
