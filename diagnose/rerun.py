"""Model: what was named is switched on in the twin (a force law, the air, the rig, the camera), and the twin is run again like the
recordings. What stands for an effect is its `counterpart`.
"""

import importlib
import math
import traceback
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from diagnose.engine.conditions import Contact, conditions_of, effect_name
from diagnose.finding import Finding
from diagnose.words import MANY, effect_of, followed

HARDLY = 0.95  # of what the old twin was off by
FOLLOWING = ("drop", "slide")  # rigs whose recordings are run each with a parameter of its own


@dataclass(frozen=True)
class Compared:
    """One recording beside both twins: root mean square of what they leave of it, in the measure's unit; by: how they were
    measured, "track" or "pictures"."""

    recording: str
    quantity: str
    unit: str
    before: float
    after: float
    by: str


@dataclass(frozen=True, eq=False)
class Again:
    """The twin run again. effects: what was switched on; change, how: that in words, and how it was run; compared: one row a
    recording and quantity; held_out: each with the parameters that the *other* recordings gave; picture: PNG, empty without."""

    rig: str
    effects: tuple[str, ...]
    change: str
    how: str
    compared: tuple[Compared, ...]
    held_out: bool
    picture: bytes = b""
    caption: str = ""
    notes: tuple[str, ...] = ()
    figure: dict | None = None

    def total(self, by: str = "track") -> tuple[float, float, str, str]:
        """Root mean squares over all recordings of the first quantity: before, after, unit, quantity."""
        first = next((c for c in self.compared if c.by == by), self.compared[0])
        own = [c for c in self.compared if c.quantity == first.quantity and c.by == first.by]
        before, after = (math.sqrt(np.mean([getattr(c, key) ** 2 for c in own])) for key in ("before", "after"))
        return before, after, first.unit, first.quantity

    def in_words(self) -> str:
        """ "run again so that the plate rises by 0.2°, the twin is off by 0.97 mm where it was off by 7.7 mm (way …)"."""
        if not self.compared:
            return "; ".join(self.notes)
        before, after, unit, quantity = self.total()
        held = "; each recording with what the others gave" if self.held_out else ""
        unit = {"1": "", "°": "°"}.get(unit, f" {unit}")
        what = f"the twin is off by {after:.2g}{unit} where it was off by {before:.2g}{unit}"
        mended = "" if after < HARDLY * before else ": hardly mended, so the twin does not bear the verdict out"
        return f"run again so that {self.change}, {what} ({quantity}{held}){mended}"

    def to_json(self) -> dict:
        """What stands under "twin" in diagnosis.json."""
        out = {"effects": list(self.effects), "change": self.change, "notes": list(self.notes), "held_out": self.held_out}
        if self.compared:
            before, after, unit, quantity = self.total()
            out |= {"quantity": quantity, "unit": unit, "rmse_before": before, "rmse_after": after}
        return out | {"recordings": [vars(c) for c in self.compared]}


def settings(rig: str, values: dict[str, float]) -> dict[str, dict]:
    """What of the twin stands for these values (of an effect's parameters, by name): numbers of force laws by name ("laws"; a
    restitution's "fall" is e(0.5 m/s) − e(2 m/s)); "air": drag over weight beyond what is stated ("share") at a speed ("at_m_s"),
    wind_x [m/s], Magnus' C ("lift"); "rig": what is added to the rig's numbers. A camera effect's own law stands for it."""
    effects = {n: e for n in values if (e := effect_of(rig, n)) is not None}
    shown = {n: e.reported(values[n]) if e.reported else values[n] for n, e in effects.items()}
    out: dict[str, dict] = {}
    for effect in effects.values():
        if effect.counterpart and effect.counterpart.change:
            for part, numbers in effect.counterpart.change(shown).items():
                out.setdefault(part, {}).update(numbers)
    return out


def values_by_recording(finding: Finding) -> dict[str, dict[str, float]]:
    """Of every recording: each effect's parameters, as fitted, as the other recordings have them."""
    return {r: {n: v[min(k, len(v) - 1)] for n, v in finding.left_out.items()} for k, r in enumerate(finding.recordings)}


def beside_mean(contact: Contact, finding: Finding, recordings: list) -> dict[str, float]:
    """By how much each recording's own contact parameter lies beside the mean by the conditions that were named, each as the other
    recordings have it."""
    by_name = {r.recording: r for r in recordings}
    used = [by_name[n] for n in finding.recordings]
    more = np.zeros(len(used))
    for condition in conditions_of([r.description for r in used], [r.session for r in used])[0]:
        name = effect_name(contact, condition)
        if name in finding.left_out:
            columns = [name, *(f"{name}.{level}" for level in condition.levels[1:])]
            more += contact.scale * (condition.z * np.array([finding.left_out[n] for n in columns]).T).sum(axis=1)
    return dict(zip(finding.recordings, more.tolist(), strict=True))


def secant(
    miss: Callable[[float], float], low: float, high: float, limits: tuple[float, float], *, iterations: int, close: float
) -> float:
    """A zero of `miss` within limits, by so many secant steps from two points or until |miss| < `close`: the better of the last two."""
    at_low, at_high = miss(low), miss(high)
    for _ in range(iterations):
        if abs(at_high) < close or abs(at_high - at_low) < 1e-9:
            break
        step = float(np.clip(high - at_high * (high - low) / (at_high - at_low), *limits))
        low, at_low, high, at_high = high, at_high, step, miss(step)
    return float(high if abs(at_high) < abs(at_low) else low)


def change_in_words(rig: str, finding: Finding) -> str:
    """What was changed, with the values that all recordings gave."""
    return "; ".join(_change(rig, name, finding) for name in finding.modelled)


def _change(rig: str, name: str, finding: Finding) -> str:
    if found := followed(name):
        return f"{found[0]} of each recording follows its {found[1]}"
    told = finding.effects.get(name)
    effect = effect_of(rig, name)
    assert effect is not None and effect.counterpart is not None  # why_not asks first
    return effect.counterpart.what.format(value=f"{told.size.value if told else math.nan:.3g}")


def run_again(found, folder: Path, *, pictures: bool, say: Callable[[str], None]):
    """The diagnosis with what the twin shows of every rig of which something was named, or of which a class has a best member."""
    twins = {}
    for rig, finding in found.findings.items():
        if effects := _asked(finding):
            say(f"{rig}: running the twin again with {' and '.join(effects)}")
            twins[rig] = _again(rig, effects, finding, found, folder, pictures, say)
    return replace(found, twins=twins)


def _asked(finding: Finding) -> tuple[str, ...]:
    """The effects of the model, and what was named that is another baseline."""
    return tuple(dict.fromkeys((*finding.modelled, *(finding.names if finding.verdict == "name" else ()))))


def _again(rig: str, effects: tuple[str, ...], finding: Finding, found, folder: Path, pictures: bool, say) -> Again:
    nothing = Again(rig, effects, "the twin was not run again", "", (), False)
    if why := [f"{e}: {reason}" for e in effects if (reason := why_not(rig, e))]:
        return replace(nothing, notes=tuple(f"the twin was not run again: {line}" for line in why))
    try:
        resimulate = importlib.import_module(f"diagnose.rigs.{rig}.resimulation").resimulate
        return resimulate(finding, found.recordings[rig], folder, pictures, say)
    except (ValueError, RuntimeError) as error:  # a rig that does not fit, the engine's watches, no renderer
        return replace(nothing, notes=(f"the twin could not be run again: {error}",))
    except OSError:
        raise
    except Exception as error:  # a fault of ours must not cost the verdict
        place = traceback.extract_tb(error.__traceback__)[-1]
        where = f"{Path(place.filename).name}:{place.lineno}"
        return replace(nothing, notes=(f"the twin could not be run again, a fault of benchtwin: {error!r} in {where}",))


def why_not(rig: str, name: str) -> str:
    """Why nothing in the twin stands for an effect; "" where something does."""
    effect = effect_of(rig, name)
    if effect is None and (found := followed(name)):
        return "" if rig in FOLLOWING else f"the twin's {MANY[rig]} have one {found[0]} for all"
    if effect is None or effect.counterpart is None:
        return (effect and effect.untwinned) or "nothing in the twin stands for it"
    return ""
