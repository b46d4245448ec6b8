"""Plates of seeds, whatever falls or slides on them: what all rigs say of them."""

from benchtwin.bench.priors import stated_sd, unstated_sd
from benchtwin.bench.section import COVERAGE_LIMITS
from benchtwin.bench.tells import Believed

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
