"""What comes out of a campaign: a row a job, in the order in which the jobs were
given."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import pandas as pd

DONE, UNMEASURED, FAILED, MISSING = "done", "unmeasured", "failed", "missing"
_RANK = {"good": 0, "doubtful": 1, "failed": 2}


@dataclass(frozen=True)
class Measurement:
    """One measured number, as vision's Quantity has it: value ± 1.96 sd is a 95 %
    interval; quality good, doubtful or failed."""

    name: str
    value: float
    sd: float
    unit: str
    quality: str = "good"
    reason: str = ""

    def column(self, suffix: str = "") -> str:
        """Its column in a table: slide_angle_deg, slide_angle_sd_deg; restitution,
        restitution_sd."""
        unit = self.unit.replace("/", "_").replace("²", "2").replace("%", "percent")
        unit = "" if self.unit in ("", "1") else f"_{unit}"
        return f"{self.name}{suffix}{unit}"


@dataclass(frozen=True)
class Measured:
    """What a job's work hands back.

    truth: what the simulation itself knows, by names with units. track: to be kept in
    place of the frames. reason: why nothing could be measured, "" when something was.
    warming_s: how long compiling, or waiting for it, took; not counted as the job's.
    """

    measurements: tuple[Measurement, ...] = ()
    truth: dict[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    track: pd.DataFrame | None = None
    reason: str = ""
    warming_s: float = 0.0


@dataclass(frozen=True)
class Outcome:
    """One job's end.

    status: "done"; "unmeasured": it ran, but nothing could be measured on it; "failed":
    it did not run to its end; "missing": not run yet. reason says why, rerun is the
    command that runs a failed one alone. folder: its recording. seconds: what it took
    once its kernels were compiled."""

    key: str
    status: str
    measurements: tuple[Measurement, ...] = ()
    truth: dict[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    reason: str = ""
    rerun: str = ""
    folder: str = ""
    seconds: float = float("nan")

    @property
    def quality(self) -> str:
        """The worst of its measurements; "failed" without any."""
        return max(
            (m.quality for m in self.measurements),
            key=lambda q: _RANK.get(q, 2),
            default="failed",
        )


@dataclass(frozen=True)
class Results:
    """Outcomes in the order of the jobs."""

    outcomes: tuple[Outcome, ...]

    @cached_property
    def table(self) -> pd.DataFrame:
        """A row a job: key, status, quality, NAME_UNIT and NAME_sd_UNIT a quantity,
        true_NAME_UNIT, seconds, reason, rerun."""
        rows = []
        for o in self.outcomes:
            quality = o.quality if o.status == DONE else ""
            row: dict = {"key": o.key, "status": o.status, "quality": quality}
            for m in o.measurements:
                row[m.column()], row[m.column("_sd")] = m.value, m.sd
            row |= {f"true_{name}": value for name, value in o.truth.items()}
            rows.append(row)
        table = pd.DataFrame(
            rows, columns=None if rows else ["key", "status", "quality"]
        )
        for name in ("seconds", "reason", "rerun"):
            table[name] = [getattr(o, name) for o in self.outcomes]
        return table

    @property
    def failed(self) -> tuple[Outcome, ...]:
        """Jobs that did not run to their end, each once."""
        return tuple({o.key: o for o in self.outcomes if o.status == FAILED}.values())

    def counts(self) -> dict[str, int]:
        """How many rows have which status."""
        return {
            status: sum(o.status == status for o in self.outcomes)
            for status in (DONE, UNMEASURED, FAILED, MISSING)
        }


def in_order(keys: Sequence[str], outcomes: dict[str, Outcome]) -> Results:
    """Results of these keys; what has no outcome is missing."""
    return Results(tuple(outcomes.get(key) or Outcome(key, MISSING) for key in keys))
