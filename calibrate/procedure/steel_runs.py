"""Seed–steel rigs simulated: a range of the parameter, extended until the bench's mean
lies inside, the answer verified."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from benchtwin.calibrate.procedure.bench import RigReadings
from benchtwin.calibrate.procedure.effort import Effort
from benchtwin.calibrate.procedure.rigs import Rig, direct
from benchtwin.calibrate.procedure.simulator import (
    Run,
    Simulator,
    seed_numbers,
    steel_rows,
    usable,
)
from benchtwin.calibrate.procedure.steel import SteelFit, fit_steel, verified
from benchtwin.calibrate.statistics.bench import BenchMean, verify
from benchtwin.calibrate.statistics.inversion import OutsideRange

EXTENSIONS = 5
# of the variance from the curve's shape, above which the range is narrowed around the
# answer
SHAPE_SHARE = 0.25
DEFAULT_CENTRE = {
    "drop": 0.5,
    "slide": 0.35,
    "roll": 0.02,
}  # where a range begins when the readings say nothing


class Unreachable(ValueError):
    """No physical value of the parameter gives the bench's mean: a finding for
    diagnosis."""


@dataclass(frozen=True)
class SteelStage:
    """What one rig's simulations need. fixed: parameters found before; description:
    sections of the recordings; seed: of the run; values: where to simulate, None to
    choose from the readings."""

    rig: Rig
    readings: RigReadings
    fixed: dict[str, float]
    description: dict
    simulate: Simulator
    effort: Effort
    seed: int
    values: tuple[float, ...] | None = None

    def runs(self, values, repeats: int, what: str) -> list[Run]:
        """Repeats of every value, each with a generator of its own; rolls alternately
        to either side."""
        return [
            Run(
                self.rig.name,
                {**self.fixed, self.rig.parameter: float(v)},
                seed_numbers(self.seed, self.rig.name, what, float(v), k),
                self._way(k),
            )
            for v in values
            for k in range(repeats)
        ]

    def _way(self, k: int) -> dict:
        if self.rig.name != "roll":
            return self.description
        return self.description | {
            "roll": (
                self.description.get("roll", {}) | {"direction": ("+x", "-x")[k % 2]}
            )
        }


def simulate_steel(stage: SteelStage, rng: np.random.Generator) -> SteelFit:
    """Simulate, fit, extend, narrow, verify. Raises Unreachable, SimulationFailed;
    ValueError for readings without scatter."""
    if stage.readings.values.size > 1:
        # readings that cannot be used are refused before anything is simulated
        stage.readings.mean()
    values, rows, notes = (
        np.array(stage.values or first_values(stage)),
        pd.DataFrame(),
        [],
    )
    for attempt in range(EXTENSIONS + 1):
        rows, more = _simulated(stage, values, rows)
        notes += more
        bench = _bench(stage, rows)
        try:
            fit = fit_steel(
                stage.rig, rows, bench, rng=rng, description=stage.readings.description
            )
            beyond = _beyond_interval(fit) if attempt < 2 else None
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
    return _verified(stage, fit)


def first_values(stage: SteelStage) -> np.ndarray:
    """Where to begin: about the parameter that Eqs. 1–3 give for the bench's mean."""
    rig, middle = stage.rig, float(stage.readings.values.mean())
    centre = (
        direct(rig.name, middle, stage.readings.description) or DEFAULT_CENTRE[rig.name]
    )
    half = max(min(rig.step, 0.4 * centre), 0.25 * centre)
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
    rows = pd.concat(
        [before, steel_rows(table[there], stage.rig.name, at[there.to_numpy()])]
    )
    return (
        rows.drop_duplicates(stage.rig.parameter).sort_values(
            stage.rig.parameter, ignore_index=True
        ),
        notes,
    )


def _bench(stage: SteelStage, rows: pd.DataFrame) -> BenchMean:
    """The bench's mean; a single reading scatters as single simulated runs do."""
    own = rows["repeats"] - 1
    sd = float(np.sqrt((own * rows[stage.rig.sd] ** 2).sum() / own.sum()))
    return stage.readings.mean(other=(sd, float(own.sum())))


def _beyond_interval(fit: SteelFit) -> OutsideRange | None:
    """The answer is inside, but its interval is cut off by an end of the range: where
    to go on."""
    i = fit.inverse
    reach = max(i.high - i.low, 4 * i.sd)
    if i.open_ends:
        side = "low" if i.low <= fit.rows[fit.rig.parameter].min() else "high"
        return OutsideRange(
            "", side, i.value - reach if side == "low" else i.value + reach
        )
    return None


def _next_values(
    rig: Rig, rows: pd.DataFrame, beyond: OutsideRange, levels: int
) -> np.ndarray:
    """Values beyond the range on the side that is asked for, up to a little past the
    guess, within the parameter's limits."""
    x = rows[rig.parameter].to_numpy()
    end, step = (x[0], -1) if beyond.side == "low" else (x[-1], 1)
    guess = beyond.about if np.isfinite(beyond.about) else end + step * np.ptp(x)
    # a straight guess may fall far off a curve: not farther than one range at a time
    reach = min(1.5 * abs(guess - end) + 0.1 * np.ptp(x), np.ptp(x))
    target = float(np.clip(end + step * reach, *rig.limits))
    if target <= 0.4 * end:
        target = max(rig.limits[0], 0.4 * end)
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
    close, notes = _simulated(
        stage,
        _three_digits(np.linspace(low, high, stage.effort.levels)),
        pd.DataFrame(),
    )
    try:
        again = fit_steel(
            stage.rig,
            close,
            _bench(stage, close),
            rng=rng,
            description=stage.readings.description,
        )
    except (OutsideRange, ValueError):
        return fit, notes
    return again, [
        *notes,
        (
            f"narrowed to {low:.3g} … {high:.3g}, because the curve does not follow the"
            " whole range"
        ),
    ]


def _verified(stage: SteelStage, fit: SteelFit) -> SteelFit:
    """Repeats at the answer, beside the bench."""
    table = stage.simulate(
        stage.runs([fit.inverse.value], stage.effort.verify, "verification")
    )
    there, notes = usable(table, stage.rig.response)
    values = table.loc[there, stage.rig.response].to_numpy(float)
    return replace(
        verified(fit, verify(values, fit.bench, name=stage.rig.name)),
        notes=(*fit.notes, *notes),
    )
