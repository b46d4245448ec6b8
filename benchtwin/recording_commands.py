"""Commands on recordings and benches: one short function a command, heavy imports
inside."""

import sys
from pathlib import Path
from typing import Annotated

from typer import Exit

from benchtwin.options import Quiet, given, said


def measure(
    paths: Annotated[
        list[Path],
        given("Photos, folders of photos, recordings, bench folders, in any mix."),
    ],
    out: Annotated[
        Path,
        said(
            "Folder for measurements.csv, summary.csv, overlays/, tracks/, bounces.csv."
        ),
    ],
    window: Annotated[
        str,
        said("Piles: heights, in % of the crest's, between which the line is fitted."),
    ] = "20-80",
    roi: Annotated[str, said("Piles: look only at X,Y,WIDTH,HEIGHT (px).")] = "",
    baseline: Annotated[
        str, said("Piles: the plate's line, X1,Y1,X2,Y2 or Y alone (px, y down).")
    ] = "",
    trim: Annotated[
        bool, said("Readings: leave out one highest and one lowest, as the paper does.")
    ] = False,
    seeds: Annotated[
        bool,
        said("The photos show spread seeds: measure the length and width of each."),
    ] = False,
    overwrite: Annotated[bool, said("Replace an existing --out.")] = False,
    quiet: Quiet = False,
) -> None:
    """Measure recordings: angles of repose, restitution, friction, each with its
    standard deviation and a picture.

    Exit code 0: something was measured; 1: nothing could be; 2: the command was
    misused."""
    asked = locals()
    from benchtwin.measure.command import measure_command

    raise Exit(measure_command(**asked))


def import_(
    files: Annotated[
        list[Path],
        given(
            "Files of Tracker, ImageJ, phyphox, Kinovea, sensor apps; videos; folders."
        ),
    ],
    out: Annotated[
        Path,
        said(
            "Bench folder to be written: a folder a recording, bench.toml with the"
            " questions."
        ),
    ],
    rig: Annotated[
        str,
        said(
            "What all of them show: drop, slide, roll or pile; else told by the"
            " motion, or asked."
        ),
    ] = "",
    track: Annotated[
        int | None,
        said("Of several tracks this one; else the longest that falls.", min=1),
    ] = None,
    overwrite: Annotated[
        bool, said("Replace a bench that this command wrote.")
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Import files of other tools as a bench folder: what they hold, every guess
    marked, everything unknown as a question.

    Exit code 0: written, and what could not be read named; 1: nothing could be read; 2:
    the command was misused."""
    from benchtwin.vision.import_command import import_command

    raise Exit(import_command(files, out, rig, track, overwrite, quiet))


def shape(
    photos: Annotated[
        list[Path],
        given("Photos, or folders of photos, of seeds spread beside a printed board."),
    ],
    out: Annotated[
        Path, said("Folder for the lot: seeds.csv, outlines.csv, lot.toml, pictures.")
    ],
    side: Annotated[
        list[Path], said("Photos of the seeds on their side: they show the thickness.")
    ] = [],  # noqa: B006
    mm_per_px: Annotated[
        float | None,
        said("Scale in the plane of the seeds; else read from the board."),
    ] = None,
    mm_per_px_sd: Annotated[
        float | None, said("How well that is known (standard deviation); else 1 %.")
    ] = None,
    distance_mm: Annotated[
        float | None, said("Lens to paper: seeds lie above it and look larger for it.")
    ] = None,
    scanner: Annotated[bool, said("Scanned from above: no perspective.")] = False,
    overwrite: Annotated[bool, said("Replace a lot that this command wrote.")] = False,
    quiet: Quiet = False,
) -> None:
    """Measure the shapes of a lot of seeds: sizes and outlines, one by one, for
    simulations that use them ([seed] lot).

    Exit code 0: measured; 1: no whole seed was found; 2: the command was misused.
    """
    asked = locals()
    from benchtwin.vision.shape.command import shape_command

    raise Exit(shape_command(**asked))


def board(
    out: Annotated[Path, said("PDF or PNG to be written.")],
    size: Annotated[str, said("Paper: A4, A5 or A6.")] = "A5",
) -> None:
    """Make a board to print: wherever a picture or film shows it, scale, level and the
    camera's pitch are read from it, and nothing of them need be stated.

    Exit code 0: written; 2: the command was misused."""
    from benchtwin.vision.board.command import board_command

    raise Exit(board_command(out, size))


def clump(
    source: Annotated[
        Path,
        given("Mesh of one seed (STL, PLY, OBJ), or voxels (.npy).", metavar="FILE"),
    ],
    out: Annotated[
        Path,
        said("Folder for the clump: a table, a picture, files for other DEM codes."),
    ],
    spheres: Annotated[
        int | None,
        said("So many balls; else the fewest that --tolerance needs.", min=1),
    ] = None,
    tolerance: Annotated[
        float | None,
        said("Rms surface error as a share of the mean radius; else 0.03."),
    ] = None,
    unit: Annotated[
        str | None, said("Of the mesh's coordinates: mm, cm, m or inch.")
    ] = None,
    voxel_mm: Annotated[float | None, said("Side of a voxel.")] = None,
    density_kg_m3: Annotated[
        float, said("Of the seed, for its mass and inertia.")
    ] = 1000.0,
    overwrite: Annotated[bool, said("Replace a clump that is there.")] = False,
    quiet: Quiet = False,
) -> None:
    """Fill a seed's true shape with overlapping balls, for LAMMPS, LIGGGHTS, YADE and
    EDEM; mass and inertia are the shape's.

    Exit code 0: written; 2: the command was misused, or the file is no closed shape.
    """
    asked = locals()
    from benchtwin.sim.seed.clump_command import clump_command

    raise Exit(clump_command(**asked))


def seeds(
    kind: Annotated[
        str, given("soybean, maize …; none: all kinds.", metavar="[KIND]")
    ] = "",
) -> None:
    """List published sizes, densities and contact parameters of seeds and grains, each
    with its source.

    Exit code 0: listed; 2: there is no such kind.
    """
    from benchtwin.bench.seed_kinds import kinds, known

    try:
        chosen = [known(kind)] if kind else list(kinds())
    except ValueError as error:
        print(f"benchtwin seeds: {error}", file=sys.stderr)
        raise Exit(2) from error
    for name in chosen:
        print(name, *(f"  {entry}" for entry in kinds()[name]), sep="\n")


def new(
    bench: Annotated[Path, given("Folder to make.", metavar="BENCH")],
) -> None:
    """Make an empty bench: a folder with a bench.toml that names every key, with what
    it means.

    Exit code 0: made; 2: it is there already, or cannot be written.
    """
    from benchtwin.vision.measurement import MeasurementError
    from benchtwin.vision.new_bench import new_bench

    try:
        print(
            f"{new_bench(bench)}: say there what is known, and put recordings beside it"
            f" (benchtwin page {bench} helps with both)"
        )
    except (MeasurementError, OSError) as error:
        print(f"benchtwin new: {error}", file=sys.stderr)
        raise Exit(2) from error


def page(
    folder: Annotated[
        Path, given("A bench folder, a folder of benches, or a new one.")
    ] = Path(),
    port: Annotated[int, said("Of this machine; 0: a free one.", min=0, max=65535)] = 0,
    browser: Annotated[bool, said("Open the page in the browser.")] = True,
) -> None:
    """Open benches in the browser: add files, correct, calibrate, diagnose, see the
    results. Only this machine reaches it.

    Exit code 0: ended with Ctrl+C; 2: the folder or the port cannot be used.
    """
    from benchtwin.page.command import page_command

    raise Exit(page_command(folder, port, browser))


def pdf(
    results: Annotated[
        Path, given("Folder of results with a report.html, or the page itself.")
    ],
    out: Annotated[
        Path | None, said("The PDF; else report.pdf beside the page.")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Print a report as PDF, by Chromium, Chrome or Edge.

    Exit code 0: printed; 1: it cannot be; 2: there is no report.
    """
    from benchtwin.report.pdf import pdf_command

    raise Exit(pdf_command(results, out, quiet))


def pack(
    bench: Annotated[Path, given("Bench folder.", metavar="BENCH")],
    out: Annotated[Path, said("Folder to make; a zip where the name ends in .zip.")],
    results: Annotated[
        list[Path] | None,
        given("Folders of results: measured, calibrated, diagnosed …"),
    ] = None,
    runs: Annotated[
        bool, said("With the simulations that results are computed from.")
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Pack a bench and its results for an archive such as Zenodo: versions, a hash of
    every file, what to cite, nothing of this machine.

    Exit code 0: packed; 1: it cannot be written; 2: the command was misused.
    """
    from benchtwin.report.archive.commands import pack_command

    raise Exit(pack_command(bench, results or [], out, runs, quiet))


def unpack(
    packed: Annotated[Path, given("What `benchtwin pack` made: a folder or a zip.")],
    out: Annotated[Path | None, said("Folder to copy it to; else only check.")] = None,
    quiet: Quiet = False,
) -> None:
    """Check a pack, file by file, and copy it into a folder.

    Exit code 0: every file is as it was packed; 1: some are not, or it cannot be
    written; 2: it is no pack, or of a newer format.
    """
    from benchtwin.report.archive.commands import unpack_command

    raise Exit(unpack_command(packed, out, quiet))
