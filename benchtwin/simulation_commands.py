"""Commands that simulate, and those on their results, each a function, with its heavy
imports inside."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from benchtwin.bench.terminal import Terminal
from benchtwin.blas import on_one_blas_thread
from benchtwin.options import (
    Bench,
    BenchFolder,
    Calibrated,
    EngineName,
    Names,
    Pairs,
    Place,
    Progress,
    Quiet,
    Ranks,
    Rendered,
    Rng,
    Rows,
    Scheduler,
    Settings,
    Values,
    Workers,
    given,
    pair_of,
    said,
)
from benchtwin.recording_commands import measure

if TYPE_CHECKING:
    from benchtwin.calibrating import CalibrationSummary
    from benchtwin.comparing import EngineComparison
    from benchtwin.diagnosing import DiagnosisSummary
    from benchtwin.exporting import Cards
    from benchtwin.measuring import Measurements
    from benchtwin.predicting import PredictionSummary
    from benchtwin.simulating import Simulations
    from benchtwin.twin.parameters import Parameters


@on_one_blas_thread
def simulate(
    rig: str,
    parameters: "Parameters | None" = None,
    *,
    out: Place,
    repeats: int = 1,
    rng: int = 1,
    settings: Values | None = None,
    like: Place | None = None,
    rendered: bool = False,
    threads: int = 2,
    engine: str = "benchtwin",
    ranks: int = 1,
    save: str | None = None,
    start: Place | None = None,
    progress: bool = False,
) -> "Simulations":
    """Simulate a rig into the bench folder `out`, and measure that as if it came from
    the bench.

    Parameters
    ----------
    rig
        drop, slide, roll, pile, cylinder (a pile from a lifting one), drum
        (rotating), or a rig of your own.
    parameters
        Contact parameters, else those that the soybean paper calibrated.
    out
        Bench folder for the recordings.
    repeats
        Recordings, each with seeds, placing and packing of its own.
    rng
        Seed of the random numbers.
    settings
        Keys of recording.toml by their dotted names, {"drop.height_mm": 200.0}.
    like
        A recording whose rig, seed and camera to copy.
    rendered
        Film or photograph the run, else its track is written.
    threads
        Processor cores for one pile.
    engine
        "benchtwin" or "lammps".
    ranks
        Processes that share one LAMMPS pile.
    save
        "vtkhdf" for state.vtkhdf in each recording, the last state with its
        contacts.
    start
        Such a file, whose heap a pile or cylinder begins with.
    progress
        Show progress on stderr.

    Returns
    -------
    Simulations
        The recordings, measured as if they came from the bench. Called again, it
        goes on where it was stopped.

    Raises
    ------
    ValueError
        For a rig, number or setting that does not fit.
    FileExistsError
        Where `out` holds other recordings of these names.
    RuntimeError
        Where a run cannot end.
    """
    from benchtwin.simulating import Simulations
    from benchtwin.twin.engine import Engine
    from benchtwin.twin.parameters import Parameters
    from benchtwin.twin.simulate_into import jobs_of, run_jobs

    jobs = jobs_of(
        rig,
        parameters or Parameters(),
        dict(settings or {}),
        repeats=repeats,
        rng=rng,
        like=None if like is None else Path(like),
        rendered=rendered,
        engine=Engine(engine, ranks),
        start=None if start is None else Path(start),
        save=save,
    )
    names = run_jobs(jobs, rig, Path(out), threads, quiet=not progress, save=save)
    return Simulations(Path(out), names)


def simulate_and_measure(
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
    settings: Settings = None,
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
        said("A .vtkhdf file, a LAMMPS dump or a VTK file: the heap to begin with."),
    ] = None,
    progress: Progress = False,
) -> "Measurements":
    """Simulate a rig, film or photograph it, and measure that as if it came from the
    bench.

    What is not given has the value that the soybean paper calibrated. Run again, the
    command goes on where it was stopped. Exit code 0: done and measured; 1: stopped, or
    nothing could be measured; 2: the command was misused."""
    from benchtwin.twin.parameters import Parameters

    numbers: dict[str, Any] = {
        "restitution": restitution,
        "static_friction": static_friction,
        "rolling_friction": rolling_friction,
        "seed_restitution": seed_restitution,
        "seed_static_friction": seed_static_friction,
        "seed_rolling_friction": seed_rolling_friction,
    }
    simulate(
        rig,
        Parameters(**{name: n for name, n in numbers.items() if n is not None}),
        out=out,
        repeats=repeats,
        rng=rng,
        settings=settings,
        like=like,
        rendered=not track,
        threads=threads,
        engine=engine,
        ranks=ranks,
        save=save,
        start=start,
        progress=progress,
    )
    return measure(out, out=out / "measured", overwrite=True, progress=progress)


@on_one_blas_thread
def calibrate(
    bench: BenchFolder,
    *,
    out: Annotated[
        Place | None,
        said("Folder for result.json, tables/, report.html, and the simulated runs."),
    ] = None,
    tables: Annotated[
        bool,
        said("Calibrate on the simulations in BENCH/tables instead of simulating."),
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
        Pairs | None,
        said(
            "seed_restitution=0.30:0.70: where to look for it.",
            "--range",
            parser=pair_of,
            metavar="NAME=A:B",
        ),
    ] = None,
    priors: Annotated[
        Pairs | None,
        said(
            "NAME=MEAN:SD of a parameter that is known beforehand.",
            "--prior",
            parser=pair_of,
            metavar="NAME=A:B",
        ),
    ] = None,
    rng: Rng = 1,
    workers: Workers = None,
    scheduler: Scheduler = None,
    engine: EngineName = "benchtwin",
    ranks: Ranks = 1,
    overwrite: Annotated[
        bool, said("Replace an existing result; finished runs are kept.")
    ] = False,
    progress: Progress = False,
) -> "CalibrationSummary":
    """Calibrate contact parameters on a bench folder: values with intervals, and what
    the bench leaves open.

    Run again, a stopped calibration goes on where it was. Exit code 0: done; 1:
    stopped, or nothing could be calibrated; 2: the command was misused.
    \f
    Parameters
    ----------
    bench
        Its folder, or what `measure` found on it: no recording is then read again.
    out
        Folder for result.json, tables, report and finished simulations; only with
        tables=True may it be left out.
    tables
        Calibrate on the simulations in BENCH/tables instead of simulating.
    quick
        Fewer repeats and piles, wider intervals.
    whole_pile
        Simulate the pile as described, not a slice of it.
    next_test
        Simulate rigs that the bench has not recorded, to tell what they would add.
    rendered
        Film every run and measure the pictures.
    method
        "posterior", or "surface": piles by a publication's steps (steepest ascent,
        Box–Behnken, analysis of variance, optimum).
    ranges
        (low, high) in which to look for a seed–seed parameter, by its name.
    priors
        (mean, sd) of a parameter known beforehand, by its name.
    rng
        Seed of the random numbers.
    workers
        Processes that simulate, else one a core.
    scheduler
        tcp://host:port of a dask scheduler.
    engine
        "benchtwin" or "lammps".
    ranks
        Processes that share one run of LAMMPS.
    overwrite
        Replace a result; finished simulations are kept.
    progress
        Show progress on stderr.

    Returns
    -------
    CalibrationSummary
        Parameters with intervals and status, what is open, and the files.

    Raises
    ------
    FileNotFoundError
        For a bench that is not there.
    FileExistsError
        Where `out` must not be replaced.
    ValueError
        Where an option does not fit or nothing can be calibrated.
    RuntimeError
        Where simulations fail.

    Notes
    -----
    A script guards its call by `if __name__ == "__main__":`, because the workers are
    processes that import it.
    """
    from benchtwin import calibrating as parts
    from benchtwin.calibrate.procedure import calibrate_tables
    from benchtwin.calibrate.procedure.effort import Effort
    from benchtwin.calibrate.procedure.pairs import pairs
    from benchtwin.calibrate.procedure.simulated import Prescribed, calibrate_simulated
    from benchtwin.calibrate.procedure.simulator import campaign
    from benchtwin.measuring import recordings_of
    from benchtwin.twin.engine import Engine

    recordings = recordings_of(bench)
    if out is None:
        if not tables:
            raise ValueError(
                "calibrate: out names the folder that keeps finished simulations; only"
                " tables=True needs none"
            )
        return parts.summary(calibrate_tables(recordings, seed=rng))
    folder = Path(out)
    parts.make_room(recordings, folder, overwrite)
    if tables:
        return parts.written(calibrate_tables(recordings, seed=rng), folder)
    computed = Engine(engine, ranks)
    if scheduler is None:
        computed.ready(workers)
    effort = Effort.asked(
        method, quick=quick, whole_pile=whole_pile, next_test=next_test
    )
    options = {
        "rendered": rendered,
        "quick": quick,
        "whole_pile": whole_pile,
        "next_test": next_test,
        "method": method,
        "ranges": dict(ranges or {}),
        "priors": dict(priors or {}),
    }
    prescribed = Prescribed.asked(options | computed.told)
    converted: list[str] = []
    with (
        parts.stages(quiet=not progress) as (say, show),
        campaign(
            folder / "runs",
            rendered=rendered,
            workers=workers,
            scheduler=scheduler,
            progress=show,
            engine=computed,
            say=converted.append,
        ) as simulator,
    ):
        found = calibrate_simulated(
            recordings,
            simulator,
            effort=effort,
            seed=rng,
            prescribed=prescribed,
            say=say,
            so_far=lambda calibration: parts.report(calibration, folder),
        )
        shown, why = pairs(found, folder / "twin", effort, say, computed)
    return parts.written(found.adding(pairs=shown).saying(*why, *converted), folder)


@on_one_blas_thread
def predict(
    calibrated: Annotated[
        Calibrated,
        given("What `benchtwin calibrate … --out DIR` left.", metavar="CALIBRATED"),
    ],
    rig: Annotated[
        str,
        said(
            "pile, cylinder (a heap left by a lifted cylinder), drum (rotating),"
            " drawdown or bed."
        ),
    ],
    *,
    out: Annotated[
        Place,
        said(
            "Folder for predicted.csv, prediction.json, prediction.html, and the runs."
        ),
    ],
    beside: Annotated[
        Bench | None,
        said("Recordings of that rig to compare with: a bench folder, or one."),
    ] = None,
    settings: Settings = None,
    like: Annotated[
        Place | None, said("A recording.toml whose rig and seed to copy.", "--from")
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
    progress: Progress = False,
) -> "PredictionSummary":
    """Predict another system from calibrated parameters, with intervals; beside
    recordings, whether they agree.

    Run again, a stopped prediction goes on where it was. Exit code 0: predicted; 1:
    stopped, or too many runs gave nothing; 2: the command was misused.
    \f
    Parameters
    ----------
    calibrated
        What `calibrate` found, or the folder that it wrote.
    rig
        "pile", "cylinder" (a heap left by a lifted cylinder), "drum", "drawdown" or
        "bed".
    out
        Folder for the prediction and its finished runs.
    beside
        Recordings of that rig: a bench folder, or what `measure` found on it.
    settings
        Keys of recording.toml by their dotted names, {"drum.speed_rpm": 20.0}.
    like
        A recording whose rig and seed to copy.
    draws
        Sets of parameters from the posterior, a run each.
    packings
        Runs at the most probable set.
    rendered
        Film every run and measure the pictures.
    rng, workers, scheduler, overwrite, progress
        As `calibrate` takes them.

    Returns
    -------
    PredictionSummary
        Quantities with intervals, and whether the recordings agree.

    Raises
    ------
    FileNotFoundError
        For a calibration that is not there.
    FileExistsError
        Where `out` must not be replaced.
    ValueError
        For what does not fit.
    RuntimeError
        Where runs fail.
    """
    from benchtwin.calibrate.prediction import beside as comparing
    from benchtwin.calibrate.prediction.predict import predict as predicted
    from benchtwin.calibrate.prediction.predict import read_posterior
    from benchtwin.calibrate.prediction.question import check, described
    from benchtwin.calibrate.prediction.written import write
    from benchtwin.calibrate.procedure.simulator import campaign
    from benchtwin.calibrating import folder_of
    from benchtwin.measuring import recordings_of
    from benchtwin.predicting import summary
    from benchtwin.shown import write_page
    from benchtwin.twin.command import progress_line

    source, folder = folder_of(calibrated), Path(out)
    check(rig, folder, draws, packings, overwrite=overwrite)
    kept = read_posterior(source)
    recorded = (
        [] if beside is None else comparing.recordings(recordings_of(beside), rig)
    )
    built = comparing.described_by(recorded, rig) if recorded else {}
    given = None if like is None else Path(like)
    base, description = described(rig, kept, given, built, dict(settings or {}))
    seen = comparing.measured(recorded, rig, description) if recorded else None
    with (
        progress_line(quiet=not progress) as show,
        campaign(
            folder / "runs",
            base=base,
            rendered=rendered,
            workers=workers,
            scheduler=scheduler,
            progress=lambda state: show(f"{rig}: {state}"),
        ) as simulator,
    ):
        found = predicted(
            rig,
            kept,
            description,
            simulator,
            draws=draws,
            packings=packings,
            seed=rng,
            measured=rendered,
        )
    compared = comparing.compare(found, seen) if seen is not None else []
    write(folder, found, seen, compared, description, calibrated=source, seed=rng)
    answer = summary(found, seen, compared, folder)
    write_page(answer, folder / "prediction.html")
    return answer


@on_one_blas_thread
def compare(
    *,
    out: Annotated[
        Place,
        said(
            "Folder for compared.csv, compared.html, runs.csv, and the simulated runs."
        ),
    ],
    rows: Annotated[
        Rows | None,
        said("CSV with a row of parameters a line; else the paper's optimum."),
    ] = None,
    packings: Annotated[
        int, said("Piles of each row, with seeds and packing of their own.")
    ] = 4,
    rng: Rng = 1,
    settings: Settings = None,
    ranks: Ranks = 1,
    workers: Workers = None,
    scheduler: Scheduler = None,
    progress: Progress = False,
) -> "EngineComparison":
    """Compare our engine with LAMMPS: reduced piles of the same law and packings, and
    where the two part.

    Run again, the command goes on where it was stopped. Exit code 0: compared; 1:
    stopped, or LAMMPS is not there; 2: the command was misused.
    \f
    Parameters
    ----------
    out
        Folder for tables, a picture and the finished runs.
    rows
        Contact parameters by name, a mapping a row, or a CSV that holds them; none:
        the soybean paper's optimum.
    packings
        Piles of each row, with seeds and packing of their own.
    settings
        Keys of recording.toml by their dotted names, {"pile.fill_height_mm": 40.0}.
    ranks
        Processes that share one LAMMPS pile.
    rng, workers, scheduler, progress
        As `calibrate` takes them.

    Returns
    -------
    EngineComparison
        Differences with intervals. Called again, it goes on where it was stopped.

    Raises
    ------
    FileExistsError
        Where `out` holds something else.
    ValueError
        For an unknown name or what cannot be simulated.
    RuntimeError
        Where LAMMPS is not there, or no pile of both was measured.
    """
    from benchtwin.comparing import EngineComparison
    from benchtwin.shown import write_page
    from benchtwin.twin import compare as parts
    from benchtwin.twin.command import check_out, print_lines, progress_line

    folder, (at, ignored) = Path(out), parts.rows_of(rows)
    check_out(folder, parts.FILES, "comparison")
    if not 1 <= packings <= 1000:
        raise ValueError(f"--packings {packings}: 1 to 1000")
    jobs = {
        name: parts.piles(at, engine, packings, rng, dict(settings or {}))
        for name, engine in parts.engines(ranks, workers, scheduler).items()
    }
    notes = [*(f"{n}: no parameter, not used" for n in ignored)]
    notes += parts.converted(jobs, at)
    if progress:
        print_lines(Terminal(stderr=True), *notes)
    with progress_line(quiet=not progress) as show:
        runs, failed = parts.run(
            jobs, at, folder, workers=workers, scheduler=scheduler, progress=show
        )
    table = parts.differences(runs)
    if table.empty:
        why = failed[0] if failed else "none was run"
        raise RuntimeError(f"no pile of both engines was measured: {why}")
    parts.write(folder, table, runs, [*notes, *failed])
    said = parts.verdict(table)
    found = EngineComparison(table, runs, said, tuple(notes), folder, tuple(failed))
    write_page(found, folder / "compared.html")
    return found


@on_one_blas_thread
def diagnose(
    bench: BenchFolder,
    *,
    out: Annotated[
        Place | None,
        said("Folder for diagnosis.json, report.html, and the twin's new runs."),
    ] = None,
    rigs: Annotated[
        Names, said("Only this rig: drop, slide, roll or pile.", "--rig")
    ] = (),
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
    progress: Progress = False,
) -> "DiagnosisSummary":
    """Diagnose where recordings and simulation differ: where, what physics is left out,
    and whether it mends the twin.

    Exit code 0: done; 1: nothing could be diagnosed, or stopped; 2: the command was
    misused.
    \f
    Parameters
    ----------
    bench
        Its folder, or what `measure` found on it: no recording is then read again.
    out
        Folder for diagnosis.json, report and the twin's new runs; none of them
        without it.
    rigs
        Only these of drop, slide, roll and pile.
    twin
        Run the twin again with what was found.
    quick
        Its tracks only, no pictures.
    rng
        Seed of the random numbers.
    overwrite
        Replace a diagnosis.
    progress
        Show progress on stderr.

    Returns
    -------
    DiagnosisSummary
        A verdict a rig. A rig that cannot be diagnosed raises nothing:
        `not_diagnosed` says why.

    Raises
    ------
    FileNotFoundError
        For a bench that is not there.
    FileExistsError
        Where `out` must not be replaced.
    ValueError
        For an unknown rig.
    """
    from benchtwin import diagnosing as parts
    from benchtwin.diagnose.bench import diagnose_bench
    from benchtwin.measuring import recordings_of
    from benchtwin.twin.command import progress_line

    recordings, only = recordings_of(bench), parts.known(rigs)
    if out is None:
        return parts.summary(diagnose_bench(recordings, seed=rng, only=only))
    folder = Path(out)
    parts.check(recordings, folder, overwrite=overwrite)
    with progress_line(quiet=not progress) as show:
        found = diagnose_bench(recordings, seed=rng, only=only, say=show)
        if twin:
            found = parts.modelled(found, folder, pictures=not quick, say=show)
    return parts.written(found, folder)


def export(
    result: Annotated[
        Calibrated,
        given("What `benchtwin calibrate … --out DIR` left.", metavar="DIR"),
    ],
    engine: Annotated[str, said("lammps, liggghts, yade, edem, or mercury.", "--to")],
    *,
    out: Annotated[
        Place | None, said("Folder for the cards; else DIR/export/ENGINE.")
    ] = None,
    overwrite: Annotated[bool, said("Replace cards that are there.")] = False,
    progress: Progress = False,
) -> "Cards":
    """Write calibrated parameters as another DEM engine takes them, in its own
    conventions.

    Exit code 0: written; 1: it could not be; 2: the command was misused.
    \f
    Parameters
    ----------
    result
        What `calibrate` found, or the folder that it wrote.
    engine
        "lammps", "liggghts", "yade", "edem" or "mercury".
    out
        Where to, else RESULT/export/ENGINE.
    overwrite
        Replace cards that are there.
    progress
        Print the files' names.

    Returns
    -------
    Cards
        The engine's files as texts, and where they were written.

    Raises
    ------
    FileNotFoundError
        For a folder without result.json.
    FileExistsError
        Where a card must not be replaced.
    ValueError
        For an unknown engine, or a result that lacks a number.
    """
    from benchtwin.calibrate.export import cards, read_result, write_cards
    from benchtwin.calibrating import folder_of
    from benchtwin.exporting import Cards

    calibrated = folder_of(result)
    folder = calibrated / "export" / engine if out is None else Path(out)
    texts = cards(read_result(calibrated), engine)
    write_cards(texts, folder, overwrite=overwrite)
    return Cards(engine, folder, texts)


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
) -> int:
    """Test `benchtwin diagnose` blind: cases with a concealed effect, made by other
    code, each solved once and scored.

    Run again with the same --rng, a stopped proof goes on where it was. Exit code 0:
    scored, whatever the scores; 1: stopped, or the folder holds another proof; 2: the
    command was misused."""
    from benchtwin.prove.command import prove_command

    return prove_command(
        out,
        cases,
        rng,
        workers=workers,
        limit_s=limit_s,
        keep_frames=keep_frames,
        quiet=quiet,
    )
