"""What a contact parameter was found to follow."""

from dataclasses import dataclass, field

from benchtwin.infer.verdict import Interval


@dataclass(frozen=True)
class Point:
    """Of a curve: condition (number, or a level's place) and parameter beside its
    mean."""

    at: float
    size: Interval


@dataclass(frozen=True, eq=False)
class Follow:
    """A contact parameter that follows a condition. Sizes are as reported."""

    parameter: str
    condition: str
    shape: str  # line | levelling off | steepening | highest | lowest | levels
    p: float  # over all conditions
    probability: float
    slope: Interval  # of a straight line, per unit of the condition; NaN for words
    curve: tuple[Point, ...]
    levels: tuple[str, ...]
    at: dict[str, float]  # the condition, by recording
    seen: dict[str, tuple[float, float]]  # own value beside the mean, and its sd
    shift: dict[str, float]  # by recording, in the global's unit, mean 0
    left_out: dict[str, float]  # the same as the other recordings have it, as reported
    unlisted: bool = False  # it says when, not why
    as_well: tuple[str, ...] = field(default=())  # conditions that explain as much

    @property
    def name(self) -> str:
        return f"{self.parameter}-follows-{self.condition}"

    @property
    def names(self) -> tuple[str, ...]:
        """The effects of which one is there."""
        more = (f"{self.parameter}-follows-{c}" for c in self.as_well)
        return (self.name, *more)

    @property
    def unit(self) -> str:
        """Of `slope`."""
        if self.levels:
            return "1"
        return f"1/{self.condition.rpartition('_')[2]}"

    def to_json(self) -> dict:
        """Its entry under "follows" of diagnosis.json."""
        return {
            "parameter": self.parameter,
            "condition": self.condition,
            "shape": self.shape,
            "p": self.p,
            "probability": self.probability,
            "as_well": list(self.as_well),
            "slope": vars(self.slope) | {"unit": self.unit},
            "curve": [
                {"at": self.levels[int(p.at)] if self.levels else p.at} | vars(p.size)
                for p in self.curve
            ],
        }


@dataclass(frozen=True)
class ConditionTable:
    """found: what is followed; p: how often scatter alone makes as much of any
    condition; next: the likeliest beside what was found, and its probability; far: a
    recording that was left out, and by how much it lies off, as reported."""

    found: tuple[Follow, ...] = ()
    p: float | None = None  # None where nothing could be tested
    next: tuple[str, float] | None = None
    far: tuple[str, float] | None = None
