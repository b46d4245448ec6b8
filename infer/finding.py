"""A finding: what one rig's recordings gave, as in diagnosis.json, with curves for the
report."""

import math
from dataclasses import dataclass, field

import numpy as np

from benchtwin.infer.effect import Effect
from benchtwin.infer.explanation import UNSHAPED
from benchtwin.infer.follow import Follow
from benchtwin.infer.held_out import HeldOut
from benchtwin.infer.unlisted import Window
from benchtwin.infer.verdict import EffectEstimate, ParameterShift

MOST_EXPLANATIONS = 20
PLAIN_FIELDS = (  # of a finding, as they are in diagnosis.json
    "alarm",
    "p_global",
    "verdict",
    "names",
    "p_verdict",
    "matters",
    "ln_bayes_baseline",
    "ln_bayes_runner_up",
    "law",
    "next_record",
    "recordings",
    "notes",
)


@dataclass(frozen=True)
class Sector:
    """explained: share of what is missing, or NaN; p: that noise alone fits as badly
    there."""

    name: str
    explained: float
    p: float


@dataclass(frozen=True)
class Parameter:
    """Reported parameter of a named effect with its 95 % interval."""

    unit: str
    value: float
    low95: float
    high95: float


@dataclass(frozen=True)
class StatedKey:
    """The key of an effect; what recordings state by it, what would state all of the
    effect in the place of each, with its sd, and how much of what is stated the
    effect's number holds."""

    key: str
    stated: tuple[float, ...]
    should_be: tuple[float, ...]
    sd: float
    held: float


@dataclass(frozen=True, eq=False)
class Curve:
    """What a report draws of one recording: `seen` (n,) over `along` (n,), and
    residuals."""

    recording: str
    quantity: str  # of `seen`
    unit: str
    axis: str  # name of `along` with its unit
    along: np.ndarray
    seen: np.ndarray
    left_by_baseline: np.ndarray
    left_by_model: np.ndarray


@dataclass(frozen=True, eq=False)
class Finding:
    """What one rig's recordings gave; fields as in diagnosis.json."""

    rig: str
    recordings: tuple[str, ...]
    alarm: bool
    p_global: float
    sectors: tuple[Sector, ...]
    window: Window | None
    best_axis: str  # the quantity that unlisted physics follows best
    verdict: str
    names: tuple[str, ...]
    ln_bayes_baseline: float
    ln_bayes_runner_up: float
    parameters: dict[str, Parameter]
    law: str | None
    held_out: HeldOut | None
    next_record: str | None
    p_verdict: float = 1.0
    matters: bool = False
    explanations: tuple[tuple[tuple[str, ...], float], ...] = ()
    effects: dict[str, EffectEstimate] = field(default_factory=dict)
    contact: dict[str, ParameterShift] = field(default_factory=dict)
    curves: tuple[Curve, ...] = ()
    notes: tuple[str, ...] = field(default=())
    left_out: dict[str, tuple[float, ...]] = field(default_factory=dict)
    unlisted: frozenset[str] = frozenset({UNSHAPED})  # of the explanations' parts
    laws: dict[str, Effect] = field(default_factory=dict)  # found for what is unlisted
    senseless: bool = False  # what is unlisted is of no shape that could act
    follows: tuple[Follow, ...] = ()  # parameters that follow conditions
    keys: dict[str, StatedKey] = field(default_factory=dict)  # that state effects

    @property
    def modelled(self) -> tuple[str, ...]:
        """The effects of the model: those named; of a class the likeliest
        explanation."""
        return tuple(n for n in self.left_out if "." not in n)

    @property
    def moves_mm(self) -> float:
        """By how much at most what is missing moves a tracked path beside the
        baseline's best fit; NaN where nothing is tracked in mm, nothing is missing, or
        what is missing is in no fit: something unlisted without a law."""
        fitted = self.laws.keys() & self.left_out.keys()
        if self.verdict == "none" or (self.verdict == "unknown" and not fitted):
            return math.nan
        off = [c.left_by_baseline - c.left_by_model for c in self.curves]
        paths = [o for o, c in zip(off, self.curves, strict=True) if c.unit == "mm"]
        return max((float(np.nanmax(np.abs(o))) for o in paths), default=math.nan)

    def to_json(self) -> dict:
        """The rig's entry of diagnosis.json; null for what there is not."""
        held = self.held_out
        return _plain(
            {key: getattr(self, key) for key in PLAIN_FIELDS}
            | {
                "sectors": [vars(s) for s in self.sectors],
                "window": (
                    self.window
                    and {k: v for k, v in vars(self.window).items() if k != "p"}
                ),
                "parameters": {name: vars(p) for name, p in self.parameters.items()},
                "follows": [f.to_json() for f in self.follows],
                "keys": {
                    name: {"key": k.key, "stated": k.stated, "should_be": k.should_be}
                    for name, k in self.keys.items()
                },
                "moves_mm": self.moves_mm,
                "explanations": [
                    {"effects": names, "probability": p}
                    for names, p in self.explanations[:MOST_EXPLANATIONS]
                ],
                "effects": {
                    name: (
                        {"probability": e.probability, "unit": e.unit} | vars(e.size)
                    )
                    for name, e in self.effects.items()
                },
                "contact_parameters": {
                    name: {
                        "unit": "1",
                        "nothing_missing": vars(m.nothing_missing),
                        "explained": vars(m.explained),
                        "shift_sds": m.shift_sds,
                    }
                    for name, m in self.contact.items()
                },
                "held_out": (
                    vars(held)
                    if held
                    else {"rmse_ratio": None, "removed_fraction": None}
                ),
            }
        )


def _plain(value):
    """For JSON: lists for tuples, null for NaN and infinity."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    return value
