"""How much is simulated: how many values, repeats and piles, and which pile stands for
the bench's."""

from dataclasses import dataclass

# some 500 seeds in place of thousands (docs/engine.md says what a run costs); what it
# does to the intervals: benchmarks/slices.py
SLAB_MM, FILL_MM = 30.0, 60.0
# the paper's rig, for a bench that states none: box, plate, filling
BOX_MM, PLATE_MM, HIGH_MM = (105.0, 105.0, 200.0), (200.0, 200.0), 100.0
QUICKLY = "a quick calibration: fewer repeats and piles than usual, so wider intervals"


@dataclass(frozen=True)
class Effort:
    """levels: values a seed–steel parameter is simulated at; repeats: runs of each;
    verify: verification runs of a rig; path: piles a group of the ascent; noise: piles
    of one point that tell the packing noise; design: the piles' second-order design,
    "box-behnken" or "central-composite" (face-centred); centre: its centre points;
    most: largest number of replicates a design point gets; more: most piles beyond the
    design; piles: verification piles; power: with which main effects are to be found;
    slab, fill_mm: width and filling of the slice that stands for the bench's pile, None
    for the pile as described; draws: effective ones from the posterior."""

    name: str
    levels: int = 6
    repeats: int = 8
    verify: int = 10
    path: int = 1
    noise: int = 5
    design: str = "box-behnken"
    centre: int = 5
    most: int = 2
    more: int = 16
    piles: int = 10
    power: float = 0.80
    slab: float | None = SLAB_MM
    fill_mm: float = FILL_MM
    draws: int = 1000

    def notes(self) -> tuple[str, ...]:
        """What a reader of the report must know of it."""
        return (QUICKLY,) if self.name == "quick" else ()


FULL = Effort("full")
QUICK = Effort(
    "quick", levels=5, repeats=4, verify=5, noise=3, centre=3, most=1, more=8, piles=3
)


def pile_description(stated: dict, effort: Effort) -> tuple[dict, tuple[str, ...]]:
    """[pile] of the simulations, and notes where it is not the bench's own.

    stated: the bench's own section. A slice as long as the box between smooth sides
    takes the place of a pile that is wider or filled higher; a bench that is such a
    slice itself, or a lifted cylinder, is simulated as it is."""
    filled = stated.get("fill_height_mm", HIGH_MM)
    low = "fill_height_mm" in stated and filled <= effort.fill_mm
    small = stated.get("slab") and low
    if effort.slab is None or stated.get("cylinder_mm") or small:
        return dict(stated), ()
    length, _, height = stated.get("box_mm", BOX_MM)
    width, fill = effort.slab, min(effort.fill_mm, filled)
    slab = {
        "box_mm": [length, width, height],
        "gate_mm": [width, height],
        "plate_mm": [stated.get("plate_mm", PLATE_MM)[0], width],
        "fill_height_mm": fill,
        "slab": True,
    }
    kept = {k: v for k, v in stated.items() if k in ("gate_speed_mm_s", "photo_s")}
    note = (
        f"the pile was simulated as a slice {width:g} mm wide between smooth sides,"
        f" filled {fill:g} mm high, in place of the pile as described: --whole-pile"
        " simulates that"
    )
    return slab | kept, (note,)
