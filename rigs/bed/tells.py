"""What drops on a bed tell a calibration: how far they rise, by all parameters of seed
on seed together."""

from benchtwin.bench.language import tr
from benchtwin.bench.tells import BySurface
from benchtwin.rigs.bed import RIG
from benchtwin.sim.rigs.bed import Bed

NOTE = (
    "each simulated bed is read by the mean of its drops, so that its scatter is not"
    " that of single drops at the bench"
)


def as_described(
    stated: dict, width_mm: float | None, fill_mm: float
) -> tuple[dict, tuple[str, ...]]:
    """[bed] of the simulations: as the bench states it. A bench drops single seeds, so
    that it is never quite the same."""
    return {"drops": Bed().drops, **stated}, (tr(NOTE),)


TELLS = BySurface(
    rig=RIG,
    simulated=as_described,
    shown=lambda stated: {},
    not_seen=("true_stayed", "true_sd_mm", "true_first_rebound_mm"),
    minutes=4.0,  # ten drops
    per_run=Bed().drops,
    within="true_sd_mm",
)
