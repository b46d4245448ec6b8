"""Commands that simulate, and those on their results: one short function a command,
heavy imports inside."""

from pathlib import Path
from typing import Annotated

from typer import Exit

from benchtwin.options import (
    BenchFolder,
    EngineName,
    Pair,
    Quiet,
    Ranks,
    Rendered,
    Rng,
    Scheduler,
    Settings,
    Workers,
    given,
    pair_of,
    said,
)


def simulate(
    rig: Annotated[
        str,
        given(
            "drop, slide, roll, pile, cylinder (a pile from a lifting cylinder), drum"
            " (rotating), drawdown (a box empties through a slot) or bed (a seed falls"
            " onto seeds)."
        ),
    ],
    out: Annotated[
        Path,
        said("Bench folder for the recordings; their numbers go into OUT/measured."),
    ],
    restitution: Annotated[
        float | None, said("Seed on steel: coefficient of restitution.")
    ] = None,
    static_friction: Annotated[float | None, said("Seed on steel.")] = None,
    rolling_friction: Annotated[
        float | None, said("Seed on steel; EDEM's standard convention.")
    ] = None,
    seed_restitution: Annotated[
        float | None, said("Seed on seed: coefficient of restitution.")
    ] = None,
    seed_static_friction: Annotated[float | None, said("Seed on seed.")] = None,
    seed_rolling_friction: Annotated[
        float | None, said("Seed on seed; EDEM's standard convention.")
    ] = None,
    repeats: Annotated[
        int,
        said("How many recordings, each with seeds, placing and packing of its own."),
    ] = 1,
    rng: Rng = 1,
    setting: Settings = [],  # noqa: B006
    like: Annotated[
        Path | None,
        said("A recording.toml whose rig, seed and camera to copy.", "--from"),
    ] = None,
    track: Annotated[
        bool, said("Write the simulation's own track, no pictures: quick.")
    ] = False,
    threads: Annotated[int, said("Processor cores for one pile.", min=1)] = 2,
    engine: EngineName = "benchtwin",
    ranks: Ranks = 1,
    save: Annotated[
        str | None,
        said("vtkhdf: leave the last state, contacts included, as ParaView opens it."),
    ] = None,
    start: Annotated[
        Path | None,
        said("A .vtkhdf file: the heap that a pile or cylinder begins with."),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Simulate a rig, film or photograph it, and measure that as if it came from the
    bench.

    What is not given has the value that the soybean paper calibrated. Run again, the
    command goes on where it was stopped. Exit code 0: done and measured; 1: stopped, or
    nothing could be measured; 2: the command was misused."""
    from benchtwin.measure.command import measure_command
    from benchtwin.twin.simulate_command import simulate_command

    numbers = {
        "restitution": restitution,
        "static_friction": static_friction,
        "rolling_friction": rolling_friction,
        "seed_restitution": seed_restitution,
        "seed_static_friction": seed_static_friction,
        "seed_rolling_friction": seed_rolling_friction,
    }
    code = simulate_command(
        rig,
        out,
        numbers,
        repeats=repeats,
        rng=rng,
        settings=dict(setting),
        like=like,
        rendered=not track,
        threads=threads,
        engine=engine,
        ranks=ranks,
        quiet=quiet,
        save=save,
        start=start,
    )
    raise Exit(
        code
        or measure_command(
            [out], out / "measured", "20-80", "", "", False, False, True, quiet
        )
    )


def calibrate(
    bench: BenchFolder,
    out: Annotated[
        Path,
        said("Folder for result.json, tables/, report.html, and the simulated runs."),
    ],
    tables: Annotated[
        bool,
        said("Calibrate on the simulations in BENCH/tables instead of simulating."),
    ] = False,
    twin: Annotated[
        bool, said("With --tables: simulate what the tables hold, and show both.")
    ] = False,
    quick: Annotated[
        bool, said("Fewer repeats and piles: minutes, with wider intervals.")
    ] = False,
    whole_pile: Annotated[
        bool, said("Simulate the pile as described, not a slice of it: hours.")
    ] = False,
    next_test: Annotated[
        bool,
        said("Simulate rigs that the bench has not recorded, to tell what they add."),
    ] = False,
    rendered: Rendered = False,
    method: Annotated[
        str,
        said("posterior; or surface: piles by a publication's steps, Box-Behnken."),
    ] = "posterior",
    ranges: Annotated[
        list[Pair],
        said(
            "seed_restitution=0.45:0.70: where to look for it.",
            "--range",
            parser=pair_of,
            metavar="NAME=A:B",
        ),
    ] = [],  # noqa: B006
    priors: Annotated[
        list[Pair],
        said(
            "NAME=MEAN:SD of a parameter that is known beforehand.",
            "--prior",
            parser=pair_of,
            metavar="NAME=A:B",
        ),
    ] = [],  # noqa: B006
    rng: Rng = 1,
    workers: Workers = None,
    scheduler: Scheduler = None,
    engine: EngineName = "benchtwin",
    ranks: Ranks = 1,
    overwrite: Annotated[
        bool, said("Replace an existing result; finished runs are kept.")
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Calibrate contact parameters on a bench folder: values with intervals, and what
    the bench leaves open.

    Run again, a stopped calibration goes on where it was. Exit code 0: done; 1:
    stopped, or nothing could be calibrated; 2: the command was misused."""
    asked = locals() | {"ranges": dict(ranges), "priors": dict(priors)}
    from benchtwin.calibrate_command import Asked, calibrate_command

    raise Exit(calibrate_command(Asked(**asked)))


def predict(
    calibrated: Annotated[
        Path,
        given("What `benchtwin calibrate … --out DIR` left.", metavar="CALIBRATED"),
    ],
    rig: Annotated[
        str,
        said(
            "pile, cylinder (a heap left by a lifted cylinder), drum (rotating),"
            " drawdown or bed."
        ),
    ],
    out: Annotated[
        Path,
        said(
            "Folder for predicted.csv, prediction.json, prediction.svg, and the runs."
        ),
    ],
    beside: Annotated[
        Path | None,
        said("Recordings of that rig to compare with: a bench folder, or one."),
    ] = None,
    settings: Settings = [],  # noqa: B006
    like: Annotated[
        Path | None, said("A recording.toml whose rig and seed to copy.", "--from")
    ] = None,
    draws: Annotated[
        int, said("Parameter sets drawn from the posterior, a run each.")
    ] = 12,
    packings: Annotated[
        int, said("Runs at the posterior's mean: how much packings scatter.")
    ] = 4,
    rendered: Rendered = False,
    rng: Rng = 1,
    workers: Workers = None,
    scheduler: Scheduler = None,
    overwrite: Annotated[
        bool, said("Replace an existing prediction; finished runs are kept.")
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Predict another system from calibrated parameters, with intervals; beside
    recordings, whether they agree.

    Run again, a stopped prediction goes on where it was. Exit code 0: predicted; 1:
    stopped, or too many runs gave nothing; 2: the command was misused."""
    asked = locals() | {"settings": dict(settings)}
    from benchtwin.calibrate.predict_command import Asked, predict_command

    raise Exit(predict_command(Asked(**asked)))


def compare_engines(
    out: Annotated[
        Path,
        said(
            "Folder for compared.csv, compared.html, runs.csv, and the simulated runs."
        ),
    ],
    rows: Annotated[
        Path | None,
        said("CSV with a row of parameters a line; else the paper's optimum."),
    ] = None,
    packings: Annotated[
        int, said("Piles of each row, with seeds and packing of their own.")
    ] = 4,
    rng: Rng = 1,
    settings: Settings = [],  # noqa: B006
    ranks: Ranks = 1,
    workers: Workers = None,
    scheduler: Scheduler = None,
    quiet: Quiet = False,
) -> None:
    """Compare our engine with LAMMPS: reduced piles of the same law and packings, and
    where the two part.

    Run again, the command goes on where it was stopped. Exit code 0: compared; 1:
    stopped, or LAMMPS is not there; 2: the command was misused."""
    asked = locals() | {"settings": dict(settings)}
    from benchtwin.twin.compare.command import Compared, compare_command

    raise Exit(compare_command(Compared(**asked)))


def diagnose(
    bench: BenchFolder,
    out: Annotated[
        Path, said("Folder for diagnosis.json, report.html, and the twin's new runs.")
    ],
    rig: Annotated[list[str], said("Only this rig: drop, slide, roll or pile.")] = [],  # noqa: B006
    twin: Annotated[
        bool,
        said(
            "Run the twin again with what was found, and show whether it then agrees."
        ),
    ] = True,
    quick: Annotated[
        bool, said("The twin's tracks only: no pictures are rendered.")
    ] = False,
    rng: Rng = 1,
    overwrite: Annotated[bool, said("Replace an existing diagnosis.")] = False,
    quiet: Quiet = False,
) -> None:
    """Diagnose where recordings and simulation differ: where, what physics is left out,
    and whether it mends the twin.

    Exit code 0: done; 1: nothing could be diagnosed, or stopped; 2: the command was
    misused."""
    from benchtwin.diagnose_command import Asked, diagnose_command

    raise Exit(
        diagnose_command(
            Asked(bench, out, tuple(rig), rng, twin, quick, overwrite, quiet)
        )
    )


def export(
    folder: Annotated[
        Path, given("What `benchtwin calibrate … --out DIR` left.", metavar="DIR")
    ],
    to: Annotated[str, said("lammps, liggghts, yade, edem, or mercury.")],
    out: Annotated[
        Path | None, said("Folder for the cards; else DIR/export/ENGINE.")
    ] = None,
    overwrite: Annotated[bool, said("Replace cards that are there.")] = False,
    quiet: Quiet = False,
) -> None:
    """Write calibrated parameters as another DEM engine takes them, in its own
    conventions.

    Exit code 0: written; 1: it could not be; 2: the command was misused.
    """
    from benchtwin.calibrate.export_command import export_command

    raise Exit(export_command(folder, to, out, overwrite, quiet))


def prove(
    out: Annotated[
        Path,
        said("Folder for cases, keys, solutions, prove.json, cases.csv, report.html."),
    ],
    cases: Annotated[
        int, said("How many; half of them conceal nothing.", min=1, max=100_000)
    ] = 600,
    rng: Annotated[
        int | None,
        said("Seed of the random numbers: the same one, the same cases.", min=0),
    ] = None,
    workers: Annotated[
        int, said("Cases that are made and solved at a time.", min=1)
    ] = 1,
    limit_s: Annotated[
        float,
        said("A case that takes longer counts as one without a diagnosis.", min=1.0),
    ] = 600.0,
    keep_frames: Annotated[
        bool, said("Keep the pictures of solved cases, about 10 MB each.")
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Test `benchtwin diagnose` blind: cases with a concealed effect, made by other
    code, each solved once and scored.

    Run again with the same --rng, a stopped proof goes on where it was. Exit code 0:
    scored, whatever the scores; 1: stopped, or the folder holds another proof; 2: the
    command was misused."""
    asked = locals()
    from benchtwin.prove.command import prove_command

    raise Exit(prove_command(**asked))
