"""Results of measurements: quantities with standard deviation and quality."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pandas as pd

from benchtwin.bench.language import tr
from benchtwin.bench.numbers import plus_minus

GOOD, DOUBTFUL, FAILED = "good", "doubtful", "failed"
NARROWED = 2 / 3  # of what was believed: an sd above it is hardly the data's
VAGUE = 0.5  # relative sd
BELIEVED = "the data hardly tell it: this is what was believed before"
OF_A_REBOUND = ("rebound_height", "rebound_speed", "restitution_normal")
_RANK = {GOOD: 0, DOUBTFUL: 1, FAILED: 2}


class MeasurementError(ValueError):
    """A recording cannot be measured; the message says why and what to do. recording:
    its name, where it cannot be read."""

    def __init__(self, message: str, recording: str = "?"):
        super().__init__(message)
        self.recording = recording


def require(holds: object, otherwise: str) -> None:
    """MeasurementError with these words where something does not hold."""
    if not holds:
        raise MeasurementError(otherwise)


@dataclass(frozen=True)
class Quantity:
    """One measured number.

    `sd` is one standard deviation such that value ± 1.96 sd is a 95 % interval (a small
    sample's wider interval is already in it). `sd_common`, included in `sd`, is the
    part that is the same error in all recordings of one session: the scale, the plumb
    line, the protractor; it does not shrink in a mean. `quality` is good, doubtful or
    failed (value NaN), `reason` says why. `believed_sd`: its sd before the data, by the
    priors alone, infinite where nothing was believed; a number whose sd the data narrow
    by less than a third is doubtful."""

    name: str
    value: float
    sd: float
    unit: str
    quality: str = GOOD
    reason: str = ""
    sd_common: float = 0.0
    believed_sd: float = math.inf

    def __post_init__(self) -> None:
        if self.quality == GOOD and self.sd > NARROWED * self.believed_sd:
            told = self.doubt(tr(BELIEVED))
            object.__setattr__(self, "quality", told.quality)
            object.__setattr__(self, "reason", told.reason)

    @property
    def in_words(self) -> str:
        """ "centroid angle 27.93 ± 0.25°"."""
        name = self.name.replace("_", " ")
        return f"{name} {plus_minus(self.value, self.sd, self.unit)}"

    def doubt(self, *reasons: str) -> "Quantity":
        """The quantity, at best doubtful, with more reasons; unchanged where all of
        them are empty."""
        if not any(reasons):
            return self
        worse = self.quality if self.quality == FAILED else DOUBTFUL
        reason = "; ".join(r for r in (self.reason, *reasons) if r)
        return replace(self, quality=worse, reason=reason)


@dataclass(frozen=True)
class Observation:
    """The results for one recording.

    `pictures` are overlays by name (uint8 RGB, at most about 1600 px wide; the first
    belongs to the quantities); `track`, `bounces`, `readings` and `seeds` are tables
    with unit-suffixed columns, or None; `notes` say what was skipped or assumed;
    `places` is where a film's seed was found (frame, x_px, y_px from the picture's top,
    left_out); `repeats` are the quantities of each repeat where one recording holds
    several (ten drops in one sound), of which `quantities` are the means. `bench` (a
    folder's name), `session` and `conditions` are the recording's, and `stated` what it
    states of rig and seed, so that repeats can be gathered; `heap` is what was found in
    a pile's photo, `collapse` how a film shows it come about."""

    recording: str
    rig: str
    quantities: tuple[Quantity, ...]
    notes: tuple[str, ...] = ()
    pictures: Mapping[str, np.ndarray] = field(default_factory=dict)
    track: pd.DataFrame | None = None
    bounces: pd.DataFrame | None = None
    readings: pd.DataFrame | None = None
    seeds: pd.DataFrame | None = None
    places: pd.DataFrame | None = None
    repeats: tuple[tuple[Quantity, ...], ...] = ()
    bench: str = ""
    session: str | None = None
    conditions: Mapping[str, float | str] = field(default_factory=dict)
    stated: Mapping[str, float | str] = field(default_factory=dict)
    heap: Any = None  # pile.repose.Repose, which needs this module
    collapse: Any = None  # pile.collapse.Collapse


def vague(quantity: Quantity) -> str:
    """A doubt of a number that is above 0 whatever it is, and known to half of itself
    at best; ""."""
    known = quantity.sd <= VAGUE * abs(quantity.value) or not math.isfinite(quantity.sd)
    return "" if known else tr("known no better than to half of itself")


def with_doubts(
    bounces: pd.DataFrame | None, quantities: Iterable[Quantity]
) -> pd.DataFrame | None:
    """A drop's bounces with the doubts of its quantities: the first is at best as good
    as what is known of its rebound, all are doubtful where all of that is."""
    known = {q.name: q.quality for q in quantities if q.quality != FAILED}
    if bounces is None or not len(bounces):
        return bounces
    rebound = {known[n] for n in OF_A_REBOUND if n in known}
    count = len(bounces) if rebound == {DOUBTFUL} else DOUBTFUL in rebound
    unsure = np.arange(len(bounces)) < count
    good = (bounces["quality"] == GOOD).to_numpy()
    quality = bounces["quality"].where(~(unsure & good), DOUBTFUL)
    return bounces.assign(quality=quality)


def failed(name: str, unit: str, reason: str) -> Quantity:
    """A quantity that could not be measured."""
    return Quantity(name, float("nan"), float("nan"), unit, FAILED, reason)


def all_failed(
    names_and_units: Iterable[tuple[str, str]], reason: str
) -> tuple[Quantity, ...]:
    """Quantities that could not be measured, for one reason."""
    return tuple(failed(name, unit, reason) for name, unit in names_and_units)


def worst(quantities: Iterable[Quantity]) -> str:
    """The lowest quality among `quantities`; failed when there are none."""
    return max((q.quality for q in quantities), key=_RANK.__getitem__, default=FAILED)
