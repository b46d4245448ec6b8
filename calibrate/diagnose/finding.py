"""A finding: all that one rig's recordings told, in the form of diagnosis.json, with the curves that its report draws."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from calibrate.diagnose.decide import ALPHA, Candidate, Verdict
from calibrate.diagnose.linear import ridge, stacked
from calibrate.diagnose.locate import Location, Sector, Window
from calibrate.diagnose.problem import Fit, fit
from calibrate.diagnose.scores import HeldOut, held_out

NORMAL_95 = 1.959964
WEAK = 5.0  # times its sd, a prior moves what is known to a fifth of it by 0.2 %


@dataclass(frozen=True)
class Parameter:
    """Reported parameter of a named effect, in the unit of effects.json, with its 95 % interval."""

    unit: str
    value: float
    low95: float
    high95: float


@dataclass(frozen=True, eq=False)
class Curve:
    """What a report draws of one recording: what was seen (n,) along `axis` (n,), what the baseline and the verdict's model leave
    of it (n,), both in `unit`; `quantity` says what was seen."""

    recording: str
    quantity: str
    unit: str
    axis: str
    along: np.ndarray
    seen: np.ndarray
    left_by_baseline: np.ndarray
    left_by_model: np.ndarray


@dataclass(frozen=True, eq=False)
class Finding:
    """What one rig's recordings told; fields as in diagnosis.json, and what its report shows beside them.

    left_out: each effect of the model (a class: its best member) as the other recordings have it, one value a recording;
    beside it, as name.other, its further parameters.
    """

    rig: str
    recordings: tuple[str, ...]
    alarm: bool
    p_global: float
    sectors: tuple[Sector, ...]
    window: Window | None
    collapse: str
    verdict: str
    names: tuple[str, ...]
    ln_bayes_baseline: float
    ln_bayes_runner_up: float
    parameters: dict[str, Parameter]
    law: str | None
    held_out: HeldOut | None
    next_record: str | None
    candidates: tuple[Candidate, ...] = ()
    curves: tuple[Curve, ...] = ()
    notes: tuple[str, ...] = field(default=())
    left_out: dict[str, tuple[float, ...]] = field(default_factory=dict)

    @property
    def modelled(self) -> tuple[str, ...]:
        """The effects of the model: what was named, of a class its best member."""
        return tuple(n for n in self.left_out if "." not in n)

    def to_json(self) -> dict:
        """The rig's entry of diagnosis.json: plain values, null for what there is not (NaN included)."""
        window = self.window and {"axis": self.window.axis, "low": _plain(self.window.low), "high": _plain(self.window.high)}
        return {
            "alarm": self.alarm,
            "p_global": _plain(self.p_global),
            "sectors": [{"name": s.name, "explained": _plain(s.explained), "p": _plain(s.p)} for s in self.sectors],
            "window": window,
            "verdict": self.verdict,
            "names": list(self.names),
            "ln_bayes_baseline": _plain(self.ln_bayes_baseline),
            "ln_bayes_runner_up": _plain(self.ln_bayes_runner_up),
            "parameters": {
                name: {"unit": p.unit, "value": _plain(p.value), "low95": _plain(p.low95), "high95": _plain(p.high95)}
                for name, p in self.parameters.items()
            },
            "law": self.law,
            "held_out": {
                "rmse_ratio": _plain(self.held_out.rmse_ratio) if self.held_out else None,
                "removed_fraction": _plain(self.held_out.removed_fraction) if self.held_out else None,
            },
            "next_record": self.next_record,
            "recordings": list(self.recordings),
            "notes": list(self.notes),
        }


def _plain(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def finding_of(
    base: Fit,
    where: Location,
    found: Verdict,
    *,
    law: str | None = None,
    curves: tuple[Curve, ...] = (),
    notes: tuple[str, ...] = (),
    draw: Callable[[Fit, Fit], tuple[Curve, ...]] | None = None,
) -> Finding:
    """A verdict with parameters and held-out figures of the model that it names (a class: of its best member).

    draw(baseline with what was named at nil, model) → further curves; without a model both are the baseline.
    """
    best = next((c for c in found.candidates if set(c.names) <= set(found.names)), None) if found.names else None
    chosen = next((c for c in found.candidates if c.names == tuple(sorted(found.names))), best) if found.names else None
    names = chosen.names if chosen else ()
    model = fit(base.problem, free=names, start=base) if names else None
    if draw:
        curves = (*curves, *draw(without(base, names), model or base))
    return Finding(
        base.problem.rig, base.problem.recordings, found.p_global < ALPHA, found.p_global, where.sectors,
        where.window, where.collapse, found.verdict, found.names, chosen.ln_bayes if chosen else float("nan"),
        found.ln_bayes_runner_up, parameters_of(model, names) if model and found.verdict == "name" else {}, law,
        held_out(model, base, names) if model else None, found.next_record, found.candidates, curves, notes,
        left_out_values(model, names) if model else {},
    )  # fmt: skip


def credited(where: Location, base: Fit, found: Verdict) -> Location:
    """With the share that a definite name has of the excess, where its own fit takes more than its sector's columns about the
    baseline: a law that is not linear, or that lets a recording's own numbers move, explains more at its place than about nil."""
    own = {base.problem.effects[n].sector for n in found.names}
    if found.verdict != "name" or len(own) != 1 or not where.excess > 0:
        return where
    fall = base.chi2 - fit(base.problem, free=found.names, start=base).chi2
    taken = sum(len(base.problem.columns_of(n)) for n in found.names)
    share = float(np.clip((fall - 2 * taken) / where.excess, 0, 1))
    sectors = [replace(s, explained=max(s.explained, share)) if s.name in own else s for s in where.sectors]
    return replace(where, sectors=tuple(sorted(sectors, key=lambda s: (-np.nan_to_num(s.explained), s.name not in own, s.p))))


def left_out_values(model: Fit, names: tuple[str, ...]) -> dict[str, tuple[float, ...]]:
    """Each effect as the other recordings have it, one value a recording; of a single recording its own. Further parameters
    of an effect stand beside it, under their own names."""
    every = model.reduced
    out: dict[str, list[float]] = {n: [] for name in names for n in model.problem.columns_of(name)}
    for r in range(len(every)):
        others = every[:r] + every[r + 1 :] or every
        values = ridge(*stacked(others), model.prior_sd)[0]
        for n in out:
            out[n].append(float(values[model.names.index(n)]))
    return {n: tuple(values) for n, values in out.items()}


def without(base: Fit, effects: tuple[str, ...]) -> Fit:
    """The baseline with `effects` at nil, which it may hold only loosely."""
    known = {n: sd for n, sd in base.problem.known_sd.items() if n not in effects}
    return base if len(known) == len(base.problem.known_sd) else fit(replace(base.problem, known_sd=known), start=base)


def parameters_of(model: Fit, names: tuple[str, ...]) -> dict[str, Parameter]:
    """Value and 95 % interval of each effect; the noise's own doubt widens it, and what a good bench leaves open of the same
    (a plumb line's 0.05°), for that is no effect. A prior tells what is likely to be there, not how much of it was seen: here it
    counts for little; that of a further parameter (a frequency, a scale) is knowledge of the law."""
    wider = math.exp(model.problem.level_sd**2 / 2)
    prior_sd = np.where(np.isin(model.names, names), WEAK, 1.0) * model.prior_sd
    values, covariance, _ = ridge(*stacked(model.reduced), prior_sd)
    out = {}
    for n in names:
        i = model.names.index(n)
        open_anyway = model.problem.known_sd.get(n, 0.0)
        value, half = float(values[i]), NORMAL_95 * math.hypot(wider * math.sqrt(covariance[i, i]), open_anyway)
        shown = model.problem.effects[n].reported or float
        out[n] = Parameter(model.problem.effects[n].unit, shown(value), shown(value - half), shown(value + half))
    return out
