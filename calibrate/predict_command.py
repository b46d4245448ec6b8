"""Command-line front end of `benchtwin predict`: options, progress, printed prediction,
exit code."""

import json
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from rich.table import Table

from benchtwin.bench.outlets import csv_text
from benchtwin.bench.terminal import Terminal
from benchtwin.bench.whole_file import write_whole
from benchtwin.calibrate.prediction import beside
from benchtwin.calibrate.prediction.beside import Comparison, Measured
from benchtwin.calibrate.prediction.picture import picture
from benchtwin.calibrate.prediction.posterior import Kept, read_posterior
from benchtwin.calibrate.prediction.predict import (
    QUANTITIES,
    Prediction,
    digits,
    intervals,
    predict,
    rows,
    sign,
)
from benchtwin.calibrate.procedure.rigs import PARAMETERS
from benchtwin.calibrate.procedure.simulator import Simulator, campaign
from benchtwin.calibrate.statistics.predictive import LEAST_DRAWS, LEAST_PACKINGS
from benchtwin.twin import Parameters
from benchtwin.twin.bench_folder import Observed
from benchtwin.twin.command import (
    DONE,
    CampaignOptions,
    Misuse,
    check_out,
    exit_code,
    print_lines,
    progress_line,
)
from benchtwin.twin.job import Job, assigned, described, merge, rig_named
from benchtwin.twin.versions import versions

# what a prediction leaves in its folder
OURS = {"runs", "predicted.csv", "runs.csv", "prediction.json", "prediction.svg"}
INTERVAL = "95 %: low to high of a single packing, mean_low to mean_high of their mean"
COLUMNS = ("one packing, 95 %", "mean of many, 95 %", "sd by parameters", "by packing")


@dataclass(frozen=True)
class Asked(CampaignOptions):
    """Options. like: the recording.toml of --from; settings: {key: value} as
    `twin.job.assigned` takes them."""

    calibrated: Path
    rig: str
    out: Path
    beside: Path | Observed | None = None
    like: Path | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)
    draws: int = 12
    packings: int = 4
    rendered: bool = False


def predict_command(asked: Asked, simulator: Simulator | None = None) -> int:
    """Predict a rig; returns the exit code. simulator: instead of the campaign, for
    tests."""

    def work() -> int:
        found, seen, compared = predict_into(asked, simulator)
        if not asked.quiet:
            _show(found, seen, compared, asked.out)
        return DONE

    misuses = (FileNotFoundError, FileExistsError, ValueError)
    return exit_code("predict", asked.out, work, misuses=misuses)


def predict_into(
    asked: Asked, simulator: Simulator | None = None
) -> tuple[Prediction, Measured | None, list[Comparison]]:
    """Predict, compare where recordings are given, and write all of it into
    `asked.out`.

    Raises FileNotFoundError, FileExistsError and ValueError before anything runs;
    RuntimeError where the runs stop."""
    _check(asked)
    rig, kept = asked.rig, read_posterior(asked.calibrated)
    recorded = beside.recordings(asked.beside, rig) if asked.beside else []
    built = beside.described_by(recorded, rig) if recorded else {}
    base, description = _described(asked, kept, built)
    seen = beside.measured(recorded, rig, description) if recorded else None
    with ExitStack() as stack:
        show = stack.enter_context(progress_line(asked.quiet))
        simulate = simulator or stack.enter_context(
            campaign(
                asked.out / "runs",
                base=base,
                rendered=asked.rendered,
                workers=asked.workers,
                scheduler=asked.scheduler,
                progress=lambda state: show(f"{rig}: {state}"),
            )
        )
        found = predict(
            rig,
            kept,
            description,
            simulate,
            draws=asked.draws,
            packings=asked.packings,
            seed=asked.rng,
            measured=asked.rendered,
        )
    compared = beside.compare(found, seen) if seen is not None else []
    _write(asked, found, seen, compared, description)
    return found, seen, compared


def _check(asked: Asked) -> None:
    """Misuse for what cannot be; FileExistsError where `out` must not be replaced."""
    if asked.rig not in QUANTITIES:
        there = ", ".join(QUANTITIES)
        raise Misuse(f"--rig {asked.rig}: no such rig to predict; there are {there}")
    for option, least in (("draws", LEAST_DRAWS), ("packings", LEAST_PACKINGS)):
        if getattr(asked, option) < least:
            raise Misuse(f"--{option} {getattr(asked, option)}: at least {least}")
    check_out(asked.out, OURS, "prediction", "prediction.json", asked.overwrite)


def _described(asked: Asked, kept: Kept, built: dict) -> tuple[dict, dict]:
    """Fields of `Parameters` that are no contact parameters, and the rig's description:
    the calibration's seeds, and the rig of --from, else of the recordings beside it;
    settings change either. ValueError for what does not fit."""
    of, own = described(asked.like) if asked.like else (None, {})
    kind, default = rig_named(asked.rig)
    if of is not None and of != kind:
        raise Misuse(f"{asked.like} describes a {of}, not a {asked.rig}")
    start = merge(merge(default, kept.described), own if asked.like else built)
    plain = Parameters(rolling_convention=kept.rolling)
    parameters, description = assigned(plain, start, asked.settings)
    given = [n for n in PARAMETERS if getattr(parameters, n) != getattr(plain, n)]
    if given:
        why = "a prediction takes the contact parameters from the calibration"
        raise Misuse(f"setting {given[0]}: {why}")
    Job(kind, parameters, description)  # a rig that cannot be is refused
    base = {n: v for n, v in vars(parameters).items() if n not in PARAMETERS}
    return base, description


def _write(
    asked: Asked,
    found: Prediction,
    seen: Measured | None,
    compared: list[Comparison],
    description: dict,
) -> None:
    table, out = rows(found), asked.out
    quantities = table.drop(columns="rig").set_index("quantity")
    content = {
        "schema": 1,
        "rig": found.rig,
        "described": description,
        "interval": INTERVAL,
        "quantities": quantities.to_dict("index"),
        "beside": [asdict(c) for c in compared],
        "recordings": list(seen.recordings) if seen else [],
        "calibrated": str(asked.calibrated),
        "notes": _notes(found, seen),
        "random_seed": asked.rng,
        "versions": versions(),
    }
    out.mkdir(parents=True, exist_ok=True)
    write_whole(out / "predicted.csv", csv_text(table))
    write_whole(out / "runs.csv", csv_text(found.runs))
    write_whole(out / "prediction.svg", picture(found, seen, compared))
    text = json.dumps(
        content, indent=1, ensure_ascii=False, allow_nan=False, default=float
    )
    write_whole(out / "prediction.json", text)


def _notes(found: Prediction, seen: Measured | None) -> list[str]:
    return [*found.notes, *(seen.notes if seen else ())]


def _show(
    found: Prediction, seen: Measured | None, compared: list[Comparison], out: Path
) -> None:
    """The prediction in the terminal, and where to look."""
    console, shown = Terminal(), Table(box=None, pad_edge=False)
    shown.add_column(found.rig)
    for heading in COLUMNS:
        shown.add_column(heading, justify="right")
    for r in rows(found).itertuples():
        q = str(r.quantity)
        shown.add_row(
            QUANTITIES[found.rig][q],
            *intervals(r),
            *(digits(q, v, 1) + sign(q) for v in (r.parameter_sd, r.packing_sd)),
        )
    console.print(shown)
    written = f"picture: {out / 'prediction.svg'}; numbers: {out / 'predicted.csv'}"
    print_lines(console, *(c.said for c in compared), *_notes(found, seen), written)
