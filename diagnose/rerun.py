"""The simulation run again with what was named; rigs/RIG/resimulation.py runs it."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.bench.rigs import RIGS
from benchtwin.diagnose.words import (
    effect_named,
    effect_of,
    fault_in_words,
    followed_condition,
)
from benchtwin.infer.effect import Effect
from benchtwin.infer.finding import Finding
from benchtwin.infer.power_law import NAMES as LAW_NAMES

TELLING = 10.0  # odds, below which two causes are not told apart
NO_LAWS: Mapping[str, Effect] = {}
CONFIRMED_RATIO = 0.95  # new over old error, above which the verdict is not confirmed


@dataclass(frozen=True)
class Comparison:
    """Root mean square error of one recording without and with the change."""

    recording: str
    quantity: str
    unit: str
    before: float
    after: float
    by: str


@dataclass(frozen=True, eq=False)
class Resimulation:
    """The simulation run again."""

    rig: str
    effects: tuple[str, ...]  # what was changed
    change: str  # the same in words
    how: str  # it was run
    compared: tuple[Comparison, ...]
    held_out: bool  # whether values are those of the *other* recordings
    picture: bytes = b""  # PNG, or empty
    caption: str = ""
    notes: tuple[str, ...] = ()
    figure: dict | None = None
    # rms of recordings about the mean of their repeats, of the first quantity
    repeats: float | None = None
    # what else explains, and how many times as likely the effects are
    rival: tuple[str, float] | None = None

    def total(self, by: str = "track") -> tuple[float, float, str, str]:
        """Root mean square of the first quantity: before, after, unit, quantity."""
        first = next((c for c in self.compared if c.by == by), self.compared[0])
        own = [
            c
            for c in self.compared
            if c.quantity == first.quantity and c.by == first.by
        ]
        before, after = (
            math.sqrt(np.mean([getattr(c, key) ** 2 for c in own]))
            for key in ("before", "after")
        )
        return before, after, first.unit, first.quantity

    def in_words(self) -> str:
        """One sentence: run again so that the plate slopes by 0.2°, the twin is off by
        0.97 mm where it was off by 7.7 mm."""
        if not self.compared:
            return "; ".join(self.notes)
        before, after, unit, quantity = self.total()
        held = tr("; each recording with what the others gave") if self.held_out else ""
        unit = {"1": "", "°": "°"}.get(unit, f" {unit}")
        what = tr(
            "the twin is off by {:.2g}{} where it was off by {:.2g}{}",
            after,
            unit,
            before,
            unit,
        )
        if self.repeats is not None:
            what += tr(
                ", and repeats are off each other's mean by {:.2g}{}",
                self.repeats,
                unit,
            )
        confirmed = (
            ""
            if after < CONFIRMED_RATIO * before
            else tr(
                ": an improvement of less than 5 %, which does not confirm the verdict"
            )
        )
        of_law = set(self.effects) <= set(LAW_NAMES)
        how = tr("with this law") if of_law else tr("so that {}", self.change)
        found = tr(
            "run again {}, {} ({}{}){}{}",
            how,
            what,
            quantity,
            held,
            confirmed,
            self._rival(),
        )
        return "; ".join((found, *self.notes))

    def _rival(self) -> str:
        if self.rival is None:
            return ""
        other, odds = self.rival
        if odds >= TELLING:
            return tr(
                "; simulations make it {:.2g} times as likely as that {}", odds, other
            )
        if odds <= 1 / TELLING:
            return tr(
                "; simulations make it {:.2g} times likelier that {}", 1 / odds, other
            )
        return tr("; whether {} instead, simulations do not tell", other)

    def to_json(self) -> dict:
        """The entry "twin" of diagnosis.json."""
        out = {
            "effects": list(self.effects),
            "change": self.change,
            "notes": list(self.notes),
            "held_out": self.held_out,
        }
        if self.compared:
            before, after, unit, quantity = self.total()
            out |= {
                "quantity": quantity,
                "unit": unit,
                "rmse_before": before,
                "rmse_after": after,
                "rmse_repeats": self.repeats,
                "rival": self.rival,
            }
        return out | {"recordings": [vars(c) for c in self.compared]}


def simulation_settings(
    rig: str, values: dict[str, float], laws: Mapping[str, Effect] = NO_LAWS
) -> dict[str, dict]:
    """Settings of the simulation for these values of effects' parameters, by name;
    laws: those that were found.

    "laws": numbers of force laws, by name ("fall" of a restitution: e(0.5 m/s) − e(2
    m/s); "weights" of a push: along the motion, over the weight); "air": drag over
    weight beyond what is stated ("share") at a speed ("at_m_s"), wind_x [m/s], Magnus'
    C ("lift"); "rig": added to the rig's numbers. Effects of the camera have their own
    law."""
    named = {n: laws.get(n) or effect_named(rig, n) for n in values}
    effects = {n: e for n, e in named.items() if e is not None}
    shown = {
        n: e.reported(values[n]) if e.reported else values[n]
        for n, e in effects.items()
    }
    out: dict[str, dict] = {}
    changes = [e.counterpart.change for e in effects.values() if e.counterpart]
    for change in filter(None, changes):
        for part, numbers in change(shown).items():
            out.setdefault(part, {}).update(numbers)
    return out


def values_by_recording(finding: Finding) -> dict[str, dict[str, float]]:
    """For every recording, each effect's fitted parameters as the other recordings have
    them."""
    return {
        r: {n: v[min(k, len(v) - 1)] for n, v in finding.left_out.items()}
        for k, r in enumerate(finding.recordings)
    }


def condition_shifts(finding: Finding) -> dict[str, float]:
    """Each recording's contact parameter beside the mean, by the conditions that it
    follows."""
    each = [finding.left_out[f.name] for f in finding.follows]
    more = np.sum([np.zeros(len(finding.recordings)), *map(np.array, each)], axis=0)
    return dict(zip(finding.recordings, more.tolist(), strict=True))


def secant(
    miss: Callable[[float], float],
    low: float,
    high: float,
    limits: tuple[float, float],
    *,
    iterations: int,
    close: float,
) -> float:
    """A zero of `miss` within `limits`, by secant steps; the better of the last two
    points."""
    at_low, at_high = miss(low), miss(high)
    for _ in range(iterations):
        if abs(at_high) < close or abs(at_high - at_low) < 1e-9:
            break
        step = float(
            np.clip(high - at_high * (high - low) / (at_high - at_low), *limits)
        )
        low, at_low, high, at_high = high, at_high, step, miss(step)
    return float(high if abs(at_high) < abs(at_low) else low)


def differences(drawn: list[np.ndarray], least: int) -> list[np.ndarray]:
    """Pictures less the first one, as bright as the greatest of all, or of `least`,
    allows."""
    gaps = [np.abs(drawn[0].astype(int) - other) for other in drawn[1:]]
    bright = 255 / max(least, *(int(gap.max()) for gap in gaps))
    return [np.minimum(bright * gap, 255).astype(np.uint8) for gap in gaps]


def change_in_words(finding: Finding) -> str:
    """What was changed, with the values that all recordings gave."""
    said = []
    for name in finding.modelled:
        if found := followed_condition(name):
            said.append(tr("{} of each recording follows its {}", found[0], found[1]))
            continue
        told, effect = finding.effects.get(name), effect_of(finding, name)
        assert (
            effect is not None and effect.counterpart is not None
        )  # see reason_not_simulated
        value = f"{told.size.value if told else math.nan:.3g}".replace("-", "−")
        said.append(tr(effect.counterpart.what).format(value=value))
    return "; ".join(said)


def resimulate_all(found, folder: Path, *, pictures: bool, say: Callable[[str], None]):
    """The diagnosis with simulations of every rig in which something was named or
    likeliest."""
    twins = {}
    for rig, finding in found.findings.items():
        named = finding.names if finding.verdict == "name" else ()
        effects = tuple(dict.fromkeys((*finding.modelled, *named)))
        if effects := effects or tuple(finding.laws):
            say(
                tr("{}: running the twin again with {}", rig, tr(" and ").join(effects))
            )
            twins[rig] = _resimulated(
                rig, effects, finding, found, folder, pictures, say
            )
    return replace(found, twins=twins)


def _resimulated(
    rig: str,
    effects: tuple[str, ...],
    finding: Finding,
    found,
    folder: Path,
    pictures: bool,
    say,
) -> Resimulation:
    why = [
        tr("was not run again: {}: {}", e, r)
        for e in effects
        if (r := reason_not_simulated(rig, e, finding.laws))
    ]
    if not why:
        try:
            resimulate = RIGS[rig].part("resimulate")
            used = found.recordings[rig]
            again = resimulate(finding, used, folder, pictures, say)
            beyond = tuple(
                tr("without the law's second term: {}", e.not_simulated)
                for n, e in finding.laws.items()
                if n not in effects
            )
            return replace(again, notes=(*again.notes, *beyond))
        except (
            ValueError,
            RuntimeError,
        ) as error:  # rig, engine's watches, or no renderer
            why = [tr("could not be run again: {}", error)]
        except OSError:
            raise
        except Exception as error:  # an error here must not lose the verdict
            why = [
                tr(
                    "could not be run again, a fault of benchtwin: {}",
                    fault_in_words(error),
                )
            ]
    notes = tuple(tr("the twin {}", line) for line in why)
    return Resimulation(
        rig, effects, tr("the twin was not run again"), "", (), False, notes=notes
    )


def reason_not_simulated(
    rig: str, name: str, laws: Mapping[str, Effect] = NO_LAWS
) -> str:
    """Why the simulation has no counterpart of an effect; "" where it has one."""
    effect = laws.get(name) or effect_named(rig, name)
    if effect is None and (found := followed_condition(name)):
        if RIGS[rig].own_parameters:
            return ""
        return tr("the twin's {} have one {} for all", RIGS[rig].in_plural, found[0])
    if effect is None or effect.counterpart is None:
        return (effect and effect.not_simulated) or tr(
            "nothing in the twin stands for it"
        )
    return ""
