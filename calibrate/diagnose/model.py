"""Model: what was named is switched on in the twin (a force law, the camera, the rig), and the twin is run again like the
recordings. COUNTERPARTS says what stands for each effect; AGAIN, how a rig is run again."""

import math
import traceback
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from calibrate.diagnose.finding import Finding

HARDLY = 0.95  # of what the old twin was off by


@dataclass(frozen=True)
class Counterpart:
    """What of the twin stands for an effect: kind "law", "camera" or "rig"; what is done, in words, {value} in its unit."""

    kind: str
    what: str


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

    @property
    def rows(self) -> list[dict]:
        """A row a recording, for the report."""
        return [
            {"recording": c.recording, "what": c.quantity, "old twin off by": c.before, "new twin off by": c.after,
             "unit": "" if c.unit == "1" else c.unit, "measured on": c.by}
            for c in self.compared
        ]  # fmt: skip

    def total(self, by: str = "track") -> tuple[float, float, str, str]:
        """Root mean squares over all recordings of the first quantity: before, after, unit, quantity."""
        first = next((c for c in self.compared if c.by == by), self.compared[0])
        own = [c for c in self.compared if c.quantity == first.quantity and c.by == first.by]
        before, after = (math.sqrt(np.mean([getattr(c, key) ** 2 for c in own])) for key in ("before", "after"))
        return before, after, first.unit, first.quantity

    def in_words(self) -> str:
        """ "run again with drag, the twin is off by 0.06 mm where it was off by 0.17 (place in flight, …)"."""
        if not self.compared:
            return "; ".join(self.notes)
        before, after, unit, quantity = self.total()
        held = ", each recording with what the others gave" if self.held_out else ""
        unit = "" if unit == "1" else f" {unit}"
        what = f"the twin is off by {after:.3g}{unit} where it was off by {before:.3g}"
        mended = "" if after < HARDLY * before else ": hardly mended, so the twin does not bear the verdict out"
        return f"run again with {' and '.join(self.effects)}, {what} ({quantity}{held}){mended}"

    def to_json(self) -> dict:
        """What stands under "twin" in diagnosis.json."""
        out = {"effects": list(self.effects), "change": self.change, "notes": list(self.notes), "held_out": self.held_out}
        if self.compared:
            before, after, unit, quantity = self.total()
            out |= {"quantity": quantity, "unit": unit, "rmse_before": before, "rmse_after": after}
        return out | {"recordings": [vars(c) for c in self.compared]}


SLOWER = "restitution follows {} spheres, {{value}} less at 2.0 than at 0.5 m/s"
# effect → what of the twin stands for it, by rig; what is not here has no counterpart
COUNTERPARTS: dict[str, dict[str, Counterpart]] = {
    "drop": {
        "drag": Counterpart("law", "the air's drag law is on, with drag over weight at 2 m/s {value} more than stated"),
        "magnus": Counterpart("law", "the Magnus law is on with C = {value}"),
        "draught": Counterpart("law", "the air moves at {value} m/s along x"),
        "restitution-falls-with-speed": Counterpart("law", SLOWER.format("viscoelastic")),
        "viscoelastic-restitution": Counterpart("law", SLOWER.format("viscoelastic")),
        "plastic-restitution": Counterpart("law", SLOWER.format("yielding")),
        "film-adhesion": Counterpart("law", "a film takes ½ m v² of every impact, v = {value} m/s"),
        "plate-tilt": Counterpart("rig", "the plate falls by {value}° towards +x"),
        "scale-error": Counterpart("camera", "a pixel of the camera is {value} of itself larger than stated"),
        "clock-error": Counterpart("camera", "the camera runs {value} of its rate faster than stated"),
        "camera-roll": Counterpart("camera", "the camera is rolled by {value}° more than stated"),
        "perspective": Counterpart("camera", "the camera's scale changes by {value} per metre of height"),
        "silhouette-wobble": Counterpart("camera", "the centre of the silhouette goes round by {value} mm as the seed turns"),
    },
    "slide": {
        "kinetic-friction": Counterpart("law", "friction falls by {value} once it slides"),
        "stribeck": Counterpart("law", "friction falls by {value} with sliding speed"),
        "viscous-sliding": Counterpart("law", "friction grows by {value} per m/s"),
    },
    "roll": {
        "slope": Counterpart("rig", "the level plate rises by {value}° along +x"),
        "viscous-rolling": Counterpart("law", "rolling friction grows by {value} per m/s"),
        "drag": Counterpart("law", "the air's drag law is on, with drag over weight at 0.5 m/s {value} more than stated"),
    },
    "pile": {
        "cohesion": Counterpart("law", "a film between seeds pulls with {value} of a seed's weight"),
        "gate-speed": Counterpart("rig", "the gate moves faster than stated by {value} of its speed"),
        "wall-friction": Counterpart("rig", "the box has its own sides, with friction, in place of smooth ones"),
        "particle-shape": Counterpart("rig", "seeds are longer by {value} of their length, at the same volume"),
    },
}  # fmt: skip
NONE_AT_ALL = {
    "impact-damage": "the twin's seeds do not remember their impacts",
    "plate-compliance": "the twin's plates are rigid; a restitution that falls with speed stands for it",
    "shape-conversion": "shape is the twin's own already: its seeds are not spheres",
    "reading-delay": "the twin reads its angles without delay", "stepped-tilt": "the twin's plate turns evenly",
    "plate-vibration": "its frequency was not recorded",
    "base-vibration": "how its base shook was not recorded",
    "base-tilt": "the twin's plate under a heap is level", "camera-roll": "the twin's camera of a heap is upright",
}  # fmt: skip


def run_again(found, folder: Path, *, pictures: bool, say: Callable[[str], None]):
    """The diagnosis with what the twin shows of every rig of which something was named, or of which a class has a best member."""
    twins = {}
    for rig, finding in found.findings.items():
        if finding.left_out:
            say(f"{rig}: running the twin again with {' and '.join(finding.modelled)}")
            twins[rig] = _again(rig, finding, found, folder, pictures, say)
    return replace(found, twins=twins)


def _again(rig: str, finding: Finding, found, folder: Path, pictures: bool, say) -> Again:
    effects = finding.modelled
    nothing = Again(rig, effects, "the twin was not run again", "", (), False)
    if missing := [e for e in effects if e not in COUNTERPARTS[rig]]:
        why = [f"{e}: {NONE_AT_ALL.get(e, 'nothing in the twin stands for it')}" for e in missing]
        return replace(nothing, notes=tuple(f"the twin was not run again: {line}" for line in why))
    if rig not in AGAIN:
        return replace(nothing, notes=(f"the twin of a {rig} is not run again",))
    try:
        return AGAIN[rig]()(finding, found.recordings[rig], folder, pictures, say)
    except (ValueError, RuntimeError) as error:  # a rig that does not fit, the engine's watches, no renderer
        return replace(nothing, notes=(f"the twin could not be run again: {error}",))
    except OSError:
        raise
    except Exception as error:  # a fault of ours must not cost the verdict
        place = traceback.extract_tb(error.__traceback__)[-1]
        where = f"{Path(place.filename).name}:{place.lineno}"
        return replace(nothing, notes=(f"the twin could not be run again, a fault of benchtwin: {error!r} in {where}",))


def change_in_words(rig: str, finding: Finding) -> str:
    """What was changed, with the values that all recordings gave."""
    values = {n: v for c in finding.candidates if set(c.names) == set(finding.modelled) for n, v in zip(c.names, c.value)}
    return "; ".join(COUNTERPARTS[rig][n].what.format(value=f"{values.get(n, float('nan')):.3g}") for n in finding.modelled)


def _drop():
    from calibrate.diagnose.drop.again import drops_again

    return drops_again


def _slide():
    from calibrate.diagnose.slide.again import slides_again

    return slides_again


def _roll():
    from calibrate.diagnose.roll.again import rolls_again

    return rolls_again


def _pile():
    from calibrate.diagnose.pile.again import piles_again

    return piles_again


AGAIN: dict[str, Callable] = {"drop": _drop, "slide": _slide, "roll": _roll, "pile": _pile}
