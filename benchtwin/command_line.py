"""The command line: one short function a verb, heavy imports inside."""

import io
import os
import sys
import tempfile
import traceback
from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False, rich_markup_mode=None)


def _version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        typer.echo(f"benchtwin {version('benchtwin')}")
        raise typer.Exit


@app.callback()
def benchtwin(
    version: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")] = False,
) -> None:
    """DEM contact parameters for seeds and grains, from what you film at the bench."""


@app.command()
def measure(
    paths: Annotated[list[Path], typer.Argument(help="Photos, folders of photos, recordings, bench folders, in any mix.")],
    out: Annotated[Path, typer.Option(help="Folder for measurements.csv, summary.csv, overlays/, tracks/, bounces.csv.")],
    window: Annotated[str, typer.Option(help="Piles: heights, in % of the crest's, between which the line is fitted.")] = "20-80",
    roi: Annotated[str, typer.Option(help="Piles: look only at X,Y,WIDTH,HEIGHT (px).")] = "",
    baseline: Annotated[str, typer.Option(help="Piles: the plate's line, X1,Y1,X2,Y2 or Y alone (px, y down).")] = "",
    trim: Annotated[bool, typer.Option(help="Readings: leave out one highest and one lowest, as the paper does.")] = False,
    seeds: Annotated[bool, typer.Option(help="The photos show spread seeds: measure the length and width of each.")] = False,
    overwrite: Annotated[bool, typer.Option(help="Replace an existing --out.")] = False,
    quiet: Annotated[bool, typer.Option(help="Print nothing but errors.")] = False,
) -> None:
    """Measure recordings: angles of repose, restitution, friction, each with its standard deviation and a picture.

    Exit code 0: something was measured; 1: nothing could be; 2: the command was misused.
    """
    from vision.command import measure_command

    raise typer.Exit(measure_command(paths, out, window, roi, baseline, trim, seeds, overwrite, quiet))


@app.command("import")
def import_(
    files: Annotated[list[Path], typer.Argument(help="Files of Tracker, ImageJ, phyphox, Kinovea, sensor apps; videos; folders.")],
    out: Annotated[Path, typer.Option(help="Bench folder to be written: a folder a recording, bench.toml with the questions.")],
    rig: Annotated[str, typer.Option(help="What all of them show: drop, slide, roll or pile; else told by the motion, or asked.")] = "",
    track: Annotated[int | None, typer.Option(min=1, help="Of several tracks this one; else the longest that falls.")] = None,
    overwrite: Annotated[bool, typer.Option(help="Replace a bench that this command wrote.")] = False,
    quiet: Annotated[bool, typer.Option(help="Print nothing but errors.")] = False,
) -> None:
    """Import files of other tools as a bench folder: what they hold, every guess marked, everything unknown as a question.

    Exit code 0: written, and what could not be read named; 1: nothing could be read; 2: the command was misused.
    """
    from vision.import_command import import_command

    raise typer.Exit(import_command(files, out, rig, track, overwrite, quiet))


@app.command()
def shape(
    photos: Annotated[list[Path], typer.Argument(help="Photos, or folders of photos, of seeds spread beside millimetre paper.")],
    out: Annotated[Path, typer.Option(help="Folder for the lot: seeds.csv, outlines.csv, lot.toml, pictures.")],
    side: Annotated[list[Path], typer.Option(help="Photos of the seeds on their side: they show the thickness.")] = [],  # noqa: B006
    mm_per_px: Annotated[float | None, typer.Option(help="Scale in the plane of the paper; else read from millimetre paper.")] = None,
    mm_per_px_sd: Annotated[float | None, typer.Option(help="How well that is known (standard deviation); else 1 %.")] = None,
    distance_mm: Annotated[float | None, typer.Option(help="Lens to paper: seeds lie above it and look larger for it.")] = None,
    scanner: Annotated[bool, typer.Option(help="Scanned from above: no perspective.")] = False,
    overwrite: Annotated[bool, typer.Option(help="Replace a lot that this command wrote.")] = False,
    quiet: Annotated[bool, typer.Option(help="Print nothing but errors.")] = False,
) -> None:
    """Measure the shapes of a lot of seeds: sizes and outlines, one by one, for simulations that use them ([seed] lot).

    Exit code 0: measured; 1: no whole seed was found; 2: the command was misused.
    """
    from vision.shape.command import shape_command

    raise typer.Exit(shape_command(photos, out, side, mm_per_px, mm_per_px_sd, distance_mm, scanner, overwrite, quiet))


@app.command()
def clump(
    source: Annotated[Path, typer.Argument(metavar="FILE", help="Mesh of one seed (STL, PLY, OBJ), or voxels (.npy).")],
    out: Annotated[Path, typer.Option(help="Folder for the clump: a table, a picture, files for other DEM codes.")],
    spheres: Annotated[int | None, typer.Option(min=1, help="So many balls; else the fewest that --tolerance needs.")] = None,
    tolerance: Annotated[float | None, typer.Option(help="Rms surface error as a share of the mean radius; else 0.03.")] = None,
    unit: Annotated[str | None, typer.Option(help="Of the mesh's coordinates: mm, cm, m or inch.")] = None,
    voxel_mm: Annotated[float | None, typer.Option(help="Side of a voxel.")] = None,
    density_kg_m3: Annotated[float, typer.Option(help="Of the seed, for its mass and inertia.")] = 1000.0,
    overwrite: Annotated[bool, typer.Option(help="Replace a clump that is there.")] = False,
    quiet: Annotated[bool, typer.Option(help="Print nothing but errors.")] = False,
) -> None:
    """Fill a seed's true shape with overlapping balls, for LAMMPS, LIGGGHTS, YADE and EDEM; mass and inertia are the shape's.

    Exit code 0: written; 2: the command was misused, or the file is no closed shape.
    """
    from sim.seed.clump_command import clump_command

    raise typer.Exit(clump_command(source, out, spheres, tolerance, unit, voxel_mm, density_kg_m3, overwrite, quiet))


@app.command()
def simulate(
    rig: Annotated[str, typer.Argument(help="drop, slide, roll, pile, cylinder (a pile from a lifting cylinder) or drum (rotating).")],
    out: Annotated[Path, typer.Option(help="Bench folder for the recordings; their numbers go into OUT/measured.")],
    restitution: Annotated[float | None, typer.Option(help="Seed on steel: coefficient of restitution.")] = None,
    static_friction: Annotated[float | None, typer.Option(help="Seed on steel.")] = None,
    rolling_friction: Annotated[float | None, typer.Option(help="Seed on steel; EDEM's standard convention.")] = None,
    seed_restitution: Annotated[float | None, typer.Option(help="Seed on seed: coefficient of restitution.")] = None,
    seed_static_friction: Annotated[float | None, typer.Option(help="Seed on seed.")] = None,
    seed_rolling_friction: Annotated[float | None, typer.Option(help="Seed on seed; EDEM's standard convention.")] = None,
    repeats: Annotated[int, typer.Option(help="How many recordings, each with seeds, placing and packing of its own.")] = 1,
    rng: Annotated[int, typer.Option(min=0, help="Seed of the random numbers: the same one gives the same recordings.")] = 1,
    setting: Annotated[list[str], typer.Option("--set", help="KEY=VALUE of anything else: pile.fill_height_mm=80 …")] = [],  # noqa: B006
    like: Annotated[Path | None, typer.Option("--from", help="A recording.toml whose rig, seed and camera to copy.")] = None,
    track: Annotated[bool, typer.Option(help="Write the simulation's own track, no pictures: quick.")] = False,
    threads: Annotated[int, typer.Option(min=1, help="Processor cores for one pile.")] = 2,
    engine: Annotated[str, typer.Option(help="What computes it: benchtwin, or lammps (docs/lammps.md).")] = "benchtwin",
    ranks: Annotated[int, typer.Option(min=1, help="With --engine lammps: processes that share one run.")] = 1,
    quiet: Annotated[bool, typer.Option(help="Print nothing but errors.")] = False,
) -> None:
    """Simulate a rig, film or photograph it, and measure that as if it came from the bench.

    What is not given has the value that the soybean paper calibrated. Run again, the command goes on where it was stopped.
    Exit code 0: done and measured; 1: stopped, or nothing could be measured; 2: the command was misused.
    """
    from twin.simulate_command import simulate_command
    from vision.command import measure_command

    numbers = {
        "restitution": restitution,
        "static_friction": static_friction,
        "rolling_friction": rolling_friction,
        "seed_restitution": seed_restitution,
        "seed_static_friction": seed_static_friction,
        "seed_rolling_friction": seed_rolling_friction,
    }
    code = simulate_command(
        rig, out, numbers, repeats=repeats, rng=rng, settings=setting, like=like, rendered=not track, threads=threads,
        engine=engine, ranks=ranks, quiet=quiet,
    )  # fmt: skip
    raise typer.Exit(code or measure_command([out], out / "measured", "20-80", "", "", False, False, True, quiet))


@app.command()
def calibrate(
    bench: Annotated[Path, typer.Argument(metavar="BENCH", help="Bench folder: recordings of drop, slide, roll and pile.")],
    out: Annotated[Path, typer.Option(help="Folder for result.json, tables/, report.html, and the simulated runs.")],
    tables: Annotated[bool, typer.Option(help="Calibrate on the simulations in BENCH/tables instead of simulating.")] = False,
    twin: Annotated[bool, typer.Option(help="With --tables: simulate what the tables hold, and show both.")] = False,
    quick: Annotated[bool, typer.Option(help="Fewer repeats and piles: minutes, with wider intervals.")] = False,
    whole_pile: Annotated[bool, typer.Option(help="Simulate the pile as described, not a slice of it: hours.")] = False,
    rendered: Annotated[bool, typer.Option(help="Film every simulated run and measure the pictures: slower.")] = False,
    design: Annotated[str, typer.Option(help="Of the piles: box-behnken, or central-composite (face-centred).")] = "box-behnken",
    ranges: Annotated[list[str], typer.Option("--range", help="seed_restitution=0.45:0.70: where to look for it.")] = [],  # noqa: B006
    priors: Annotated[list[str], typer.Option("--prior", help="NAME=MEAN:SD of a parameter that is known beforehand.")] = [],  # noqa: B006
    rng: Annotated[int, typer.Option(min=0, help="Seed of the random numbers: the same one gives the same result.")] = 1,
    workers: Annotated[int | None, typer.Option(min=1, help="Processes that simulate; else one a core.")] = None,
    scheduler: Annotated[str | None, typer.Option(help="tcp://host:port of a dask scheduler to simulate on.")] = None,
    engine: Annotated[str, typer.Option(help="What computes the runs: benchtwin, or lammps (docs/lammps.md).")] = "benchtwin",
    ranks: Annotated[int, typer.Option(min=1, help="With --engine lammps: processes that share one run.")] = 1,
    overwrite: Annotated[bool, typer.Option(help="Replace an existing result; finished runs are kept.")] = False,
    quiet: Annotated[bool, typer.Option(help="Print nothing but errors.")] = False,
) -> None:
    """Calibrate contact parameters on a bench folder: values with intervals, and what the bench leaves open.

    Run again, a stopped calibration goes on where it was.
    Exit code 0: done; 1: stopped, or nothing could be calibrated; 2: the command was misused.
    """
    from calibrate.calibrate_command import Asked, calibrate_command

    asked = Asked(
        bench, out, tables=tables, twin=twin, quick=quick, whole_pile=whole_pile, rendered=rendered, design=design,
        ranges=tuple(ranges), priors=tuple(priors), rng=rng, workers=workers, scheduler=scheduler, engine=engine,
        ranks=ranks, overwrite=overwrite, quiet=quiet,
    )  # fmt: skip
    raise typer.Exit(calibrate_command(asked))


@app.command()
def predict(
    calibrated: Annotated[Path, typer.Argument(metavar="CALIBRATED", help="What `benchtwin calibrate … --out DIR` left.")],
    rig: Annotated[str, typer.Option(help="cylinder (a heap left by a lifted cylinder) or drum (rotating).")],
    out: Annotated[Path, typer.Option(help="Folder for predicted.csv, prediction.json, prediction.svg, and the runs.")],
    beside: Annotated[Path | None, typer.Option(help="Recordings of that rig to compare with: a bench folder, or one.")] = None,
    setting: Annotated[list[str], typer.Option("--set", help="KEY=VALUE: drum.speed_rpm=20, pile.cylinder_mm=[50,120] …")] = [],  # noqa: B006
    like: Annotated[Path | None, typer.Option("--from", help="A recording.toml whose rig and seed to copy.")] = None,
    draws: Annotated[int, typer.Option(help="Parameter sets drawn from the posterior, a run each.")] = 12,
    packings: Annotated[int, typer.Option(help="Runs at the posterior's mean: how much packings scatter.")] = 4,
    rendered: Annotated[bool, typer.Option(help="Film every run and measure the pictures: slower.")] = False,
    rng: Annotated[int, typer.Option(min=0, help="Seed of the random numbers: the same one gives the same result.")] = 1,
    workers: Annotated[int | None, typer.Option(min=1, help="Processes that simulate; else one a core.")] = None,
    scheduler: Annotated[str | None, typer.Option(help="tcp://host:port of a dask scheduler to simulate on.")] = None,
    overwrite: Annotated[bool, typer.Option(help="Replace an existing prediction; finished runs are kept.")] = False,
    quiet: Annotated[bool, typer.Option(help="Print nothing but errors.")] = False,
) -> None:
    """Predict another system from calibrated parameters, with intervals; beside recordings, whether they agree.

    Run again, a stopped prediction goes on where it was.
    Exit code 0: predicted; 1: stopped, or too many runs gave nothing; 2: the command was misused.
    """
    from calibrate.predict_command import Asked, predict_command

    asked = Asked(
        calibrated, rig, out, beside=beside, like=like, settings=tuple(setting), draws=draws, packings=packings,
        rendered=rendered, rng=rng, workers=workers, scheduler=scheduler, overwrite=overwrite, quiet=quiet,
    )  # fmt: skip
    raise typer.Exit(predict_command(asked))


@app.command("compare-engines")
def compare_engines(
    out: Annotated[Path, typer.Option(help="Folder for compared.csv, compared.html, runs.csv, and the simulated runs.")],
    rows: Annotated[Path | None, typer.Option(help="CSV with a row of parameters a line; else the paper's optimum.")] = None,
    packings: Annotated[int, typer.Option(help="Piles of each row, with seeds and packing of their own.")] = 4,
    rng: Annotated[int, typer.Option(min=0, help="Seed of the random numbers: the same one gives the same packings.")] = 1,
    setting: Annotated[list[str], typer.Option("--set", help="KEY=VALUE of the pile: pile.fill_height_mm=40 …")] = [],  # noqa: B006
    ranks: Annotated[int, typer.Option(min=1, help="Of LAMMPS: processes that share one pile.")] = 1,
    workers: Annotated[int | None, typer.Option(min=1, help="Processes that simulate; else one a core.")] = None,
    scheduler: Annotated[str | None, typer.Option(help="tcp://host:port of a dask scheduler to simulate on.")] = None,
    quiet: Annotated[bool, typer.Option(help="Print nothing but errors.")] = False,
) -> None:
    """Compare our engine with LAMMPS: reduced piles of the same law and packings, and where the two part.

    Run again, the command goes on where it was stopped.
    Exit code 0: compared; 1: stopped, or LAMMPS is not there; 2: the command was misused.
    """
    from twin.compare.command import Compared, compare_command

    asked = Compared(out, rows, packings, rng, tuple(setting), ranks, workers, scheduler, quiet)
    raise typer.Exit(compare_command(asked))


@app.command()
def diagnose(
    bench: Annotated[Path, typer.Argument(metavar="BENCH", help="Bench folder: recordings of drop, slide, roll and pile.")],
    out: Annotated[Path, typer.Option(help="Folder for diagnosis.json, report.html, and the twin's new runs.")],
    rig: Annotated[list[str], typer.Option(help="Only this rig: drop, slide, roll or pile.")] = [],  # noqa: B006
    twin: Annotated[bool, typer.Option(help="Run the twin again with what was found, and show whether it then agrees.")] = True,
    quick: Annotated[bool, typer.Option(help="The twin's tracks only: no pictures are rendered.")] = False,
    rng: Annotated[int, typer.Option(help="Seed of the random numbers: the same one gives the same result.")] = 1,
    overwrite: Annotated[bool, typer.Option(help="Replace an existing diagnosis.")] = False,
    quiet: Annotated[bool, typer.Option(help="Print nothing but errors.")] = False,
) -> None:
    """Diagnose where recordings and simulation differ: where, what physics is left out, and whether it mends the twin.

    Exit code 0: done; 1: nothing could be diagnosed, or stopped; 2: the command was misused.
    """
    from diagnose.diagnose_command import Asked, diagnose_command

    raise typer.Exit(diagnose_command(Asked(bench, out, tuple(rig), rng, twin, quick, overwrite, quiet)))


@app.command()
def seeds(kind: Annotated[str, typer.Argument(metavar="[KIND]", help="soybean, maize …; none: all kinds.")] = "") -> None:
    """List published sizes, densities and contact parameters of seeds and grains, each with its source.

    Exit code 0: listed; 2: there is no such kind.
    """
    from vision.evidence.seed_kinds import kinds, known

    try:
        chosen = [known(kind)] if kind else list(kinds())
    except ValueError as error:
        print(f"benchtwin seeds: {error}", file=sys.stderr)
        raise typer.Exit(2) from error
    for name in chosen:
        print(name, *(f"  {entry}" for entry in kinds()[name]), sep="\n")


@app.command()
def export(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="What `benchtwin calibrate … --out DIR` left.")],
    to: Annotated[str, typer.Option(help="lammps, liggghts, yade, edem, or mercury.")],
    out: Annotated[Path | None, typer.Option(help="Folder for the cards; else DIR/export/ENGINE.")] = None,
    overwrite: Annotated[bool, typer.Option(help="Replace cards that are there.")] = False,
    quiet: Annotated[bool, typer.Option(help="Print nothing but errors.")] = False,
) -> None:
    """Write calibrated parameters as another DEM engine takes them, in its own conventions.

    Exit code 0: written; 1: it could not be; 2: the command was misused.
    """
    from calibrate.export_command import export_command

    raise typer.Exit(export_command(folder, to, out, overwrite, quiet))


@app.command()
def prove(
    out: Annotated[Path, typer.Option(help="Folder for cases, keys, solutions, prove.json, cases.csv, report.html.")],
    cases: Annotated[int, typer.Option(min=1, max=100_000, help="How many; half of them conceal nothing.")] = 600,
    rng: Annotated[int | None, typer.Option(min=0, help="Seed of the random numbers: the same one, the same cases.")] = None,
    workers: Annotated[int, typer.Option(min=1, help="Cases that are made and solved at a time.")] = 1,
    limit_s: Annotated[float, typer.Option(min=1.0, help="A case that takes longer counts as one without a diagnosis.")] = 600.0,
    keep_frames: Annotated[bool, typer.Option(help="Keep the pictures of solved cases, about 10 MB each.")] = False,
    quiet: Annotated[bool, typer.Option(help="Print nothing but errors.")] = False,
) -> None:
    """Test `benchtwin diagnose` blind: cases with a concealed effect, made by other code, each solved once and scored.

    Run again with the same --rng, a stopped proof goes on where it was.
    Exit code 0: scored, whatever the scores; 1: stopped, or the folder holds another proof; 2: the command was misused.
    """
    from prove.command import prove_command

    raise typer.Exit(prove_command(out, cases, rng, workers=workers, limit_s=limit_s, keep_frames=keep_frames, quiet=quiet))


@app.command()
def new(bench: Annotated[Path, typer.Argument(metavar="BENCH", help="Folder to make.")]) -> None:
    """Make an empty bench: a folder with a bench.toml that names every key, with what it means.

    Exit code 0: made; 2: it is there already, or cannot be written.
    """
    from vision.measurement import MeasurementError
    from vision.new_bench import new_bench

    try:
        print(f"{new_bench(bench)}: say there what is known, and put recordings beside it (benchtwin page {bench} helps with both)")
    except (MeasurementError, OSError) as error:
        print(f"benchtwin new: {error}", file=sys.stderr)
        raise typer.Exit(2) from error


@app.command()
def page(
    folder: Annotated[Path, typer.Argument(help="A bench folder, a folder of benches, or a new one.")] = Path(),
    port: Annotated[int, typer.Option(min=0, max=65535, help="Of this machine; 0: a free one.")] = 0,
    browser: Annotated[bool, typer.Option(help="Open the page in the browser.")] = True,
) -> None:
    """Open benches in the browser: add files, correct, calibrate, diagnose, see the results. Only this machine reaches it.

    Exit code 0: ended with Ctrl+C; 2: the folder or the port cannot be used.
    """
    from page.command import page_command

    raise typer.Exit(page_command(folder, port, browser))


def _keep_compiled_code() -> None:
    """Numba keeps what it compiled beside the source or in the user's cache; where it may write to neither, in /tmp."""
    try:
        cache = Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache").expanduser()
        cache.mkdir(parents=True, exist_ok=True)
        if os.access(Path(__file__).parents[1] / "calibrate", os.W_OK) or os.access(cache, os.W_OK):
            return
    except (OSError, RuntimeError):  # no home at all
        pass
    user = getattr(os, "getuid", lambda: 0)()
    folder = Path(tempfile.gettempdir()) / f"benchtwin-kernels-{user}"
    folder.mkdir(mode=0o700, exist_ok=True)
    if folder.stat().st_uid != user:  # compiled code is not taken from another's folder
        folder = Path(tempfile.mkdtemp(prefix="benchtwin-kernels-"))
    os.environ.setdefault("NUMBA_CACHE_DIR", str(folder))


def main() -> None:
    """The command line. A fault of ours ends it with one line and exit code 1; BENCHTWIN_TRACEBACK=1 shows where it arose."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # matrices are small: more threads wait for each other, and take longer
    _keep_compiled_code()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal that has no "±" shows "?"
    try:
        app()
    except Exception as error:
        if os.environ.get("BENCHTWIN_TRACEBACK"):
            raise
        place = traceback.extract_tb(error.__traceback__)[-1]
        where = f"{Path(place.filename).name}:{place.lineno}"
        sys.exit(f"benchtwin: a fault of benchtwin, please report it: {error!r} in {where} (BENCHTWIN_TRACEBACK=1 shows more)")
