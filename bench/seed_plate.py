"""Plates of seeds, whatever falls or slides on them: what all rigs say of them."""

from collections.abc import Callable

from benchtwin.bench.language import tr
from benchtwin.bench.priors import stated_sd, unstated_sd
from benchtwin.bench.rig import Rig
from benchtwin.bench.section import COVERAGE_LIMITS
from benchtwin.bench.tells import Believed, BySurface, nothing_left_out

LAID_BY_HAND = 0.78  # share of a plate that seeds cover which people lay side by side
SDS = 3.0  # to either side, as far as it is simulated
PAGE = "seed-plate.md"


def open_coverage(rig: str, section: dict) -> dict[str, Believed]:
    """What is believed of a plate's coverage, as {"rig.coverage": …}: as stated with
    its sd, else as people lay seeds."""
    mean, known = section.get("coverage", LAID_BY_HAND), "coverage" in section
    own = (stated_sd if known else unstated_sd)("plate-coverage")
    sd = section.get("coverage_sd", own)
    least, most = COVERAGE_LIMITS
    ends = max(least, mean - SDS * sd), min(most, mean + SDS * sd)
    return {f"{rig}.coverage": Believed(mean, sd, ends)}


def lost_in_glue(section: dict) -> float:
    """rms of the share that hard glue takes of a rise, where none is stated."""
    return 0.0 if "glue_loss" in section else unstated_sd("plate-glue")


def told_on_seeds(
    rig: Rig,
    variant: str,
    parameter: str,
    *,
    per_run: int,
    minutes: float,
    left_out: Callable[[dict], float] = nothing_left_out,
) -> BySurface:
    """What a rig tells of seed on seed in its variant on a plate of seeds, the
    `parameter` by itself. per_run: of its readings, all on one card or plate, that one
    simulated run is the mean of; minutes: that these take at a bench; left_out: of what
    is simulated."""
    many = rig.in_plural  # in words, and the key that says how many are simulated
    (_, unit), *_ = rig.readings.values()

    def as_described(
        stated: dict, width_mm: float | None, fill_mm: float
    ) -> tuple[dict, tuple[str, ...]]:
        """The section of the simulations: as the bench states it. A bench reads single
        ones, so that it is never quite the same."""
        note = tr(
            "each simulated plate of seeds is read by the mean of its {}, so that its"
            " scatter is not that of single {} at the bench",
            many,
            many,
        )
        return {**stated, many: per_run}, (note,)

    return BySurface(
        rig=rig,
        variant=variant,
        plural=f"{many} on a plate of seeds",
        simulated=as_described,
        shown=lambda stated: {},
        not_seen=(f"true_sd_{unit}",),
        minutes=minutes,
        left_open=lambda section: open_coverage(rig.name, section),
        left_out=left_out,
        usual={"coverage": LAID_BY_HAND},
        per_run=per_run,
        within=f"true_sd_{unit}",
        answers=(parameter,),
        page=PAGE,
        sample=f"samples/soybean-bench/{variant}-01",
    )
