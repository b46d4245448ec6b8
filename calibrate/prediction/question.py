"""What a prediction is asked for, checked before anything runs."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from benchtwin.bench.exits import Misuse
from benchtwin.calibrate.prediction.predict import QUANTITIES, Kept
from benchtwin.calibrate.prediction.written import OURS
from benchtwin.calibrate.procedure.rigs import PARAMETERS
from benchtwin.calibrate.statistics.predictive import LEAST_DRAWS, LEAST_PACKINGS
from benchtwin.twin import Parameters
from benchtwin.twin.command import check_out
from benchtwin.twin.job import Job, assigned, merge, rig_named
from benchtwin.twin.job import described as described_in


def check(rig: str, out: Path, draws: int, packings: int, *, overwrite: bool) -> None:
    """Misuse for what cannot be; FileExistsError where `out` must not be replaced."""
    if rig not in QUANTITIES:
        there = ", ".join(QUANTITIES)
        raise Misuse(f"--rig {rig}: no such rig to predict; there are {there}")
    for option, number, least in (
        ("draws", draws, LEAST_DRAWS),
        ("packings", packings, LEAST_PACKINGS),
    ):
        if number < least:
            raise Misuse(f"--{option} {number}: at least {least}")
    check_out(out, OURS, "prediction", "prediction.json", overwrite)


def described(
    rig: str, kept: Kept, like: Path | None, built: dict, settings: Mapping[str, Any]
) -> tuple[dict, dict]:
    """Fields of `Parameters` that are no contact parameters, and the rig's description:
    the calibration's seeds, and the rig of `like`, else of the recordings beside it
    (built); settings change either. ValueError for what does not fit."""
    of, own = described_in(like) if like else (None, {})
    kind, default = rig_named(rig)
    if of is not None and of != kind:
        raise Misuse(f"{like} describes a {of}, not a {rig}")
    start = merge(merge(default, kept.described), own if like else built)
    plain = Parameters(rolling_convention=kept.rolling)
    parameters, description = assigned(plain, start, settings)
    given = [n for n in PARAMETERS if getattr(parameters, n) != getattr(plain, n)]
    if given:
        why = "a prediction takes the contact parameters from the calibration"
        raise Misuse(f"setting {given[0]}: {why}")
    Job(kind, parameters, description)  # a rig that cannot be is refused
    base = {n: v for n, v in vars(parameters).items() if n not in PARAMETERS}
    return base, description
