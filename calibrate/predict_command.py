"""Command-line front end of `benchtwin predict`: options, progress, printed prediction, exit code."""

import json
import sys
from contextlib import ExitStack
from dataclasses import asdict, dataclass, fields
from pathlib import Path

from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.table import Table

from calibrate.prediction.beside import (
    Comparison,
    Measured,
    compare,
    described_by,
    measured,
    recordings,
)
from calibrate.prediction.picture import picture
from calibrate.prediction.posterior import Kept, read_posterior
from calibrate.prediction.predict import QUANTITIES, RIG_OF, Prediction, predict, rows
from calibrate.procedure.rigs import PARAMETERS
from calibrate.procedure.simulator import Simulator, campaign
from calibrate.result_file import write
from calibrate.statistics.predictive import LEAST_DRAWS, LEAST_PACKINGS
from twin import Parameters
from twin.command import Misuse
from twin.job import CYLINDER, Job, assigned, described, merge
from twin.versions import versions

DONE, STOPPED, MISUSED = 0, 1, 2
OURS = {
    "runs",
    "predicted.csv",
    "runs.csv",
    "prediction.json",
    "prediction.svg",
}  # what a prediction leaves in its folder


@dataclass(frozen=True)
class Asked:
    """What was typed. like: the recording.toml of --from; settings: "KEY=VALUE" as `benchtwin
    simulate --set` takes them."""

    calibrated: Path
    rig: str
    out: Path
    beside: Path | None = None
    like: Path | None = None
    settings: tuple[str, ...] = ()
    draws: int = 12
    packings: int = 4
    rendered: bool = False
    rng: int = 1
    workers: int | None = None
    scheduler: str | None = None
    overwrite: bool = False
    quiet: bool = False


def predict_command(asked: Asked, simulator: Simulator | None = None) -> int:
    """Predict a rig; returns the exit code. simulator: in the place of the campaign, for tests."""
    try:
        found, seen, compared = predict_into(asked, simulator)
    except KeyboardInterrupt:
        return _say(f"stopped; the same command goes on where it stopped ({asked.out})", STOPPED)
    except (FileNotFoundError, FileExistsError, ValueError) as error:
        return _say(error, MISUSED)
    except RuntimeError as error:  # too many runs gave nothing; the campaign stopped
        return _say(error, STOPPED)
    except OSError as error:
        return _say(f"{error.filename or asked.out}: {error.strerror or error}", STOPPED)
    if not asked.quiet:
        _show(found, seen, compared, asked.out)
    return DONE


def predict_into(
    asked: Asked, simulator: Simulator | None = None
) -> tuple[Prediction, Measured | None, list[Comparison]]:
    """Predict, compare where recordings are given, and write all of it into `asked.out`.

    Raises FileNotFoundError, FileExistsError and ValueError before anything runs; RuntimeError
    where the runs stop.
    """
    _check(asked)
    kept = read_posterior(asked.calibrated)
    beside = recordings(asked.beside, asked.rig) if asked.beside else []
    base, description = _described(asked, kept, described_by(beside, asked.rig) if beside else {})
    seen = measured(beside, asked.rig, description) if beside else None
    with ExitStack() as stack:
        simulate = simulator or stack.enter_context(_campaign(asked, base, stack))
        found = predict(
            asked.rig, kept, description, simulate, draws=asked.draws, packings=asked.packings,
            seed=asked.rng, measured=asked.rendered,
        )  # fmt: skip
    compared = compare(found, seen) if seen is not None else []
    _write(asked, found, seen, compared, description)
    return found, seen, compared


def _check(asked: Asked) -> None:
    """Misuse for what cannot be; FileExistsError where `out` holds something that must not be
    replaced."""
    if asked.rig not in QUANTITIES:
        raise Misuse(
            f"--rig {asked.rig}: no such rig to predict; there are {' and '.join(QUANTITIES)}"
        )
    if asked.draws < LEAST_DRAWS:
        raise Misuse(f"--draws {asked.draws}: at least {LEAST_DRAWS}")
    if asked.packings < LEAST_PACKINGS:
        raise Misuse(f"--packings {asked.packings}: at least {LEAST_PACKINGS}")
    if asked.out.exists() and not asked.out.is_dir():
        raise FileExistsError(f"{asked.out}: is a file; --out names a folder")
    there = (
        {p.name for p in asked.out.iterdir() if not p.name.startswith(".")}
        if asked.out.is_dir()
        else set()
    )
    if there - OURS:
        raise FileExistsError(
            f"{asked.out}: holds {sorted(there - OURS)[0]}, which no prediction wrote; "
            "choose another --out"
        )
    if "prediction.json" in there and not asked.overwrite:
        raise FileExistsError(
            f"{asked.out}: holds a prediction already; choose another --out, or say --overwrite"
        )


def _described(asked: Asked, kept: Kept, beside: dict) -> tuple[dict, dict]:
    """Fields of `Parameters` that are no contact parameters, and the rig's description: the
    calibration's seeds, and the rig of --from, else of the recordings beside it; --set changes
    either. ValueError for what does not fit."""
    of, own = described(asked.like) if asked.like else (None, {})
    if of is not None and of != RIG_OF[asked.rig]:
        raise Misuse(f"{asked.like} describes a {of}, not a {asked.rig}")
    default = CYLINDER if asked.rig == "cylinder" else {}
    start = merge(merge(default, kept.described), own if asked.like else beside)
    parameters, description = assigned(
        Parameters(rolling_convention=kept.rolling), start, list(asked.settings)
    )
    plain = Parameters()
    given = [n for n in PARAMETERS if getattr(parameters, n) != getattr(plain, n)]
    if given:
        raise Misuse(
            f"--set {given[0]}: a prediction takes the contact parameters from the calibration"
        )
    Job(
        RIG_OF[asked.rig], parameters, description
    )  # a rig that cannot be is refused before anything runs
    base = {
        f.name: getattr(parameters, f.name) for f in fields(parameters) if f.name not in PARAMETERS
    }
    return base, description


def _campaign(asked: Asked, base: dict, stack: ExitStack):
    """The campaign that simulates, with its progress."""
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    console = Console(stderr=True)
    progress = stack.enter_context(
        Progress(*columns, console=console, disable=asked.quiet, transient=True)
    )
    task = progress.add_task(asked.rig, total=None)

    def told(state) -> None:
        progress.update(task, description=f"{asked.rig}: {state}")

    return campaign(
        asked.out / "runs",
        base=base,
        rendered=asked.rendered,
        workers=asked.workers,
        scheduler=asked.scheduler,
        progress=told,
    )


def _write(
    asked: Asked,
    found: Prediction,
    seen: Measured | None,
    compared: list[Comparison],
    description: dict,
) -> None:
    table = rows(found)
    content = {
        "schema": 1,
        "rig": found.rig,
        "described": description,
        "unit": "deg",
        "interval": "95 %: low to high of a single packing, mean_low to mean_high of their mean",
        "quantities": {
            row.pop("quantity"): row for row in table.drop(columns="rig").to_dict("records")
        },
        "beside": [asdict(c) for c in compared],
        "recordings": list(seen.recordings) if seen else [],
        "calibrated": str(asked.calibrated),
        "notes": [*found.notes, *(seen.notes if seen else ())],
        "random_seed": asked.rng,
        "versions": versions(),
    }
    asked.out.mkdir(parents=True, exist_ok=True)
    write(asked.out / "predicted.csv", table.to_csv(index=False, float_format="%.6g"))
    write(asked.out / "runs.csv", found.runs.to_csv(index=False, float_format="%.6g"))
    write(asked.out / "prediction.svg", picture(found, seen, compared))
    write(
        asked.out / "prediction.json",
        json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False, default=float),
    )


def _say(error: object, code: int) -> int:
    print(f"benchtwin predict: {error}", file=sys.stderr)
    return code


def _show(found: Prediction, seen: Measured | None, compared: list[Comparison], out: Path) -> None:
    """The prediction in the terminal, and where to look."""
    console = Console(width=None if sys.stdout.isatty() else 160, highlight=False)
    shown = Table(box=None, pad_edge=False)
    for heading in (
        found.rig,
        "one packing, 95 %",
        "mean of many, 95 %",
        "sd by parameters",
        "by packing",
    ):
        shown.add_column(heading, justify="left" if heading == found.rig else "right")
    for r in rows(found).itertuples():
        one, many = (
            f"{r.mean:.1f} ({r.low:.1f} to {r.high:.1f})°",
            f"{r.mean_low:.1f} to {r.mean_high:.1f}°",
        )
        shown.add_row(
            QUANTITIES[found.rig][str(r.quantity)],
            one,
            many,
            f"{r.parameter_sd:.2f}°",
            f"{r.packing_sd:.2f}°",
        )
    console.print(shown)
    notes = [*found.notes, *(seen.notes if seen else ())]
    for line in (
        *(c.said for c in compared),
        *notes,
        f"picture: {out / 'prediction.svg'}; numbers: {out / 'predicted.csv'}",
    ):
        console.print(line, markup=False, soft_wrap=True)
