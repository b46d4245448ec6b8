"""Seed–steel rigs simulated: a range of the parameter, extended until the bench's mean
lies inside, the answer verified."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from benchtwin.bench.tells import ByCurve
from benchtwin.calibrate.procedure.bench import RigReadings
from benchtwin.calibrate.procedure.effort import Effort
from benchtwin.calibrate.procedure.simulator import (
    Run,
    Simulator,
    Unreachable,
    seed_numbers,
    steel_rows,
    usable,
)
from benchtwin.calibrate.procedure.steel import SteelFit, fit_steel
from benchtwin.calibrate.procedure.verification import verified
from benchtwin.calibrate.statistics.inversion import OutsideRange

# times that a range is extended: each at most doubles it, so that five can make it 32
# times as wide
EXTENSIONS = 5
# of them, those that only widen an interval which the range's end cuts off
WIDENINGS = 2
# half widths of the first range, and how far towards zero one step may go, as shares of
# its middle or its low end: far enough to see a slope, and never past zero
FIRST_HALF, NEARER = 0.25, 0.4
# of the variance from the curve's shape, above which the range is narrowed around the
# answer
SHAPE_SHARE = 0.25


@dataclass(frozen=True, kw_only=True)
class SteelStage:
    """What one rig's simulations need. fixed: parameters found before; description:
    sections of the recordings; seed: of the run; values: where to simulate, None to
    choose from the readings."""

    rig: ByCurve
    readings: RigReadings
    fixed: dict[str, float]
    description: dict
    simulate: Simulator
    effort: Effort
    seed: int
    values: tuple[float, ...] | None = None

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

    def fit(self, rows: pd.DataFrame, rng: np.random.Generator) -> SteelFit:
        """The rows fitted at the bench's mean; a single reading scatters as single
        simulated runs do. Raises as `fit_steel`."""
        own = rows["repeats"] - 1
        sd = float(np.sqrt((own * rows[self.rig.sd] ** 2).sum() / own.sum()))
        bench = self.readings.mean(other=(sd, float(own.sum())))
        stated = self.readings.description
        return fit_steel(self.rig, rows, bench, rng=rng, description=stated)


def simulate_steel(stage: SteelStage, rng: np.random.Generator) -> SteelFit:
    """Simulate, fit, extend, narrow, verify. Raises Unreachable, SimulationFailed;
    ValueError for readings without scatter."""
    if stage.readings.values.size > 1:
        # readings that cannot be used are refused before anything is simulated
        stage.readings.mean()
    rows, notes = pd.DataFrame(), []
    values = np.array(stage.values or first_values(stage))
    for attempt in range(EXTENSIONS + 1):
        rows, more = _simulated(stage, values, rows)
        notes += more
        try:
            fit = stage.fit(rows, rng)
            beyond = _beyond_interval(fit) if attempt < WIDENINGS else None
        except OutsideRange as error:
            fit, beyond = None, error
        if beyond is None:
            break
        values = _next_values(stage.rig, rows, beyond, stage.effort.levels)
        if not values.size or attempt == EXTENSIONS:
            break
        notes.append(
            f"range extended to {stage.rig.parameter} {values.min():.3g} …"
            f" {values.max():.3g}"
        )
    if fit is None:
        raise Unreachable(_unreachable(stage, str(beyond)))
    fit, more = _narrowed(stage, fit, rows, rng)
    fit = replace(fit, notes=(*dict.fromkeys(notes + more), *fit.notes))
    runs = stage.runs([fit.inverse.value], stage.effort.verify, "verification")
    return verified(fit, stage.rig, runs, stage.simulate)


def first_values(stage: SteelStage) -> np.ndarray:
    """Where to begin: about the parameter that Eqs. 1–3 give for the bench's mean."""
    rig, middle = stage.rig, float(stage.readings.values.mean())
    centre = rig.direct(middle, stage.readings.description) or rig.first
    half = max(min(rig.step, NEARER * centre), FIRST_HALF * centre)
    low, high = max(rig.limits[0], centre - half), min(rig.limits[1], centre + half)
    return _three_digits(np.linspace(low, high, stage.effort.levels))


def _three_digits(values: np.ndarray) -> np.ndarray:
    return np.array([float(f"{v:.3g}") for v in values])


def _simulated(
    stage: SteelStage, values: np.ndarray, before: pd.DataFrame
) -> tuple[pd.DataFrame, list[str]]:
    """Rows of these values added to those before, in order."""
    runs = stage.runs(values, stage.effort.repeats, "curve")
    table = stage.simulate(runs)
    there, notes = usable(table, stage.rig.response)
    at = np.array([r.values[stage.rig.parameter] for r in runs])
    new = steel_rows(table[there], stage.rig, at[there.to_numpy()])
    rows = pd.concat([before, new]).drop_duplicates(stage.rig.parameter)
    return rows.sort_values(stage.rig.parameter, ignore_index=True), notes


def _beyond_interval(fit: SteelFit) -> OutsideRange | None:
    """The answer is inside, but its interval is cut off by an end of the range: where
    to go on."""
    i = fit.inverse
    reach = max(i.high - i.low, 4 * i.sd)
    if not i.open_ends:
        return None
    if i.low <= fit.rows[fit.rig.parameter].min():
        return OutsideRange("", "low", i.value - reach)
    return OutsideRange("", "high", i.value + reach)


def _next_values(
    rig: ByCurve, rows: pd.DataFrame, beyond: OutsideRange, levels: int
) -> np.ndarray:
    """Values beyond the range on the side that is asked for, up to a little past the
    guess, within the parameter's limits."""
    x = rows[rig.parameter].to_numpy()
    end, step = (x[0], -1) if beyond.side == "low" else (x[-1], 1)
    guess = beyond.about if np.isfinite(beyond.about) else end + step * np.ptp(x)
    # a straight guess may fall far off a curve: not farther than one range at a time
    reach = min(1.5 * abs(guess - end) + 0.1 * np.ptp(x), np.ptp(x))
    target = float(np.clip(end + step * reach, *rig.limits))
    if target <= NEARER * end:
        target = max(rig.limits[0], NEARER * end)
    if abs(target - end) < 1e-3 * np.ptp(x):
        return np.zeros(0)
    new = _three_digits(np.linspace(end, target, max(3, levels // 2) + 1)[1:])
    return np.unique(new[~np.isin(new, x)])


def _unreachable(stage: SteelStage, why: str) -> str:
    rig = stage.rig
    return (
        f"finding for diagnosis: no {rig.parameter} from {rig.limits[0]:g} to"
        f" {rig.limits[1]:g} gives the bench's {stage.readings.values.mean():.4g}"
        f" {rig.unit}: {why}"
    )


def _narrowed(
    stage: SteelStage, fit: SteelFit, rows: pd.DataFrame, rng: np.random.Generator
) -> tuple[SteelFit, list[str]]:
    """Where the curve's shape rather than scatter makes the error, or the curves
    disagree, values close about the answer are simulated and fitted alone."""
    disagree = any("curves disagree" in n for n in fit.notes)
    if stage.values or (fit.inverse.budget["fit"] <= SHAPE_SHARE and not disagree):
        return fit, []
    x = rows[stage.rig.parameter]
    half = max(0.15 * fit.inverse.value, 3 * fit.inverse.sd, 0.02 * float(np.ptp(x)))
    low, high = np.clip(
        [fit.inverse.value - half, fit.inverse.value + half], *stage.rig.limits
    )
    values = _three_digits(np.linspace(low, high, stage.effort.levels))
    close, notes = _simulated(stage, values, pd.DataFrame())
    try:
        again = stage.fit(close, rng)
    except ValueError:  # OutsideRange too
        return fit, notes
    notes.append(
        f"narrowed to {low:.3g} … {high:.3g}, because the curve does not follow the"
        " whole range"
    )
    return again, notes
