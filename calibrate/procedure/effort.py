"""How much is simulated: how many values, repeats and piles, and which pile stands for
the bench's."""

from dataclasses import dataclass, replace

from benchtwin.bench.exits import Misuse
from benchtwin.bench.language import tr
from benchtwin.bench.tells import BySurface

# some 500 seeds in place of thousands (docs/engine.md says what a run costs); what it
# does to the intervals: benchmarks/slices.py
SLAB_MM, FILL_MM = 30.0, 60.0
METHODS = ("posterior", "surface")  # of the piles
QUICKLY = "a quick calibration: fewer repeats and piles than usual, so wider intervals"


@dataclass(frozen=True)
class Effort:
    """levels: values a seed–steel parameter is simulated at; repeats: runs of each;
    design: runs of a rig that tells of seed on seed, over the whole range; more: most
    of them beyond the design; check: runs of each rig at the most probable set;
    surface: whether the piles follow the steps of a publication (steepest ascent,
    Box–Behnken), with so many runs at the centre; slab, fill_mm: width and filling of
    the slice that stands for the bench's pile, None for the pile as described; draws:
    effective ones from the posterior; unrecorded: whether rigs that the bench has not
    recorded are simulated too, to tell what they would add."""

    name: str
    levels: int = 6
    repeats: int = 8
    design: int = 40
    more: int = 16
    check: int = 8
    surface: bool = False
    centre: int = 5
    slab: float | None = SLAB_MM
    fill_mm: float = FILL_MM
    draws: int = 1000
    unrecorded: bool = False

    @classmethod
    def asked(
        cls, method: str, *, quick: bool, whole_pile: bool, next_test: bool
    ) -> "Effort":
        """As the command's options have it; Misuse for a method that is not there."""
        if method not in METHODS:
            raise Misuse(f"--method {method}: one of {', '.join(METHODS)}")
        effort = replace(
            QUICK if quick else FULL,
            surface=method == "surface",
            unrecorded=next_test,
        )
        return replace(effort, slab=None) if whole_pile else effort

    def notes(self) -> tuple[str, ...]:
        """What a reader of the report must know of it."""
        return (tr(QUICKLY),) if self.name == "quick" else ()

    def simulated(self, rig: BySurface, stated: dict) -> tuple[dict, tuple[str, ...]]:
        """The rig's section that is simulated where the bench states this one, and a
        note where it is another."""
        return rig.simulated(stated, self.slab, self.fill_mm)


FULL = Effort("full")
QUICK = Effort("quick", levels=5, repeats=4, design=24, more=8, check=4, centre=3)
