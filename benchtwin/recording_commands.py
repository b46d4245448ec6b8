"""Commands on recordings and benches, each a function, with its heavy imports
inside."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from benchtwin.bench.exits import DONE, FAILED
from benchtwin.blas import on_one_blas_thread
from benchtwin.options import (
    Line,
    Paths,
    Place,
    Progress,
    Quiet,
    Region,
    Window,
    given,
    line_of,
    region_of,
    said,
    window_of,
)

if TYPE_CHECKING:
    from benchtwin.measuring import Measurements


@on_one_blas_thread
def measure(
    paths: Annotated[
        Paths,
        given("Photos, folders of photos, recordings, bench folders, in any mix."),
    ],
    *,
    out: Annotated[
        Place | None,
        said(
            "Folder for measurements.csv, summary.csv, overlays/, tracks/, bounces.csv."
        ),
    ] = None,
    window_pct: Annotated[
        Window,
        said(
            "Piles: heights, in % of the crest's, between which the line is fitted.",
            "--window",
            parser=window_of,
            metavar="<str>",
        ),
    ] = (20.0, 80.0),
    region_px: Annotated[
        Region | None,
        said(
            "Piles: look only at X,Y,WIDTH,HEIGHT (px).",
            "--roi",
            parser=region_of,
            metavar="<str>",
        ),
    ] = None,
    baseline_px: Annotated[
        Line | None,
        said(
            "Piles: the plate's line, X1,Y1,X2,Y2 or Y alone (px, y down).",
            "--baseline",
            parser=line_of,
            metavar="<str>",
        ),
    ] = None,
    trim: Annotated[
        bool, said("Readings: leave out one highest and one lowest, as the paper does.")
    ] = False,
    seeds: Annotated[
        bool,
        said("The photos show spread seeds: measure the length and width of each."),
    ] = False,
    overwrite: Annotated[bool, said("Replace an existing --out.")] = False,
    progress: Progress = False,
) -> "Measurements":
    """Measure recordings: angles of repose, restitution, friction, each with its
    standard deviation and a picture.

    Exit code 0: something was measured; 1: nothing could be; 2: the command was
    misused.
    \f
    Parameters
    ----------
    paths
        One path or several, each a file, a recording or a bench folder.
    out
        Folder for the files that the command writes (tables, tracks, pictures of
        what was found); none without it.
    window_pct
        Of piles: heights in % of the crest's between which the line is fitted.
    region_px
        Of piles: where to look (x, y, width, height) [px].
    baseline_px
        Of piles: the plate's line (x1, y1, x2, y2) [px], y down.
    trim
        Of readings leave out one highest and one lowest.
    seeds
        The photos show spread seeds, whose lengths and widths are measured.
    overwrite
        Replace results that are there.
    progress
        Show progress on stderr.

    Returns
    -------
    Measurements
        A recording that cannot be measured stands in its tables with the reason.

    Raises
    ------
    FileNotFoundError
        For a path that is not there.
    MeasurementError
        For a window below a tenth of the crest's height, or where `out` must not be
        replaced.
    OSError
        Where it cannot be written.
    """
    from benchtwin.measure.measured import (
        existing,
        measured,
        observed_under,
        results_in,
    )
    from benchtwin.measuring import Measurements, fractions
    from benchtwin.vision.pile.repose import PileOptions

    options = PileOptions(fractions(window_pct), region_px, baseline_px)
    chosen = existing(paths)
    observed, unread = observed_under(chosen, options, trim)
    kept = []
    with results_in(out, chosen, unread, overwrite) as add:
        for observation in measured(observed, seeds=seeds, progress=progress):
            add(observation)
            kept.append(observation)
    return Measurements(
        tuple(kept), observed, None if out is None else Path(out), unread
    )


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
) -> int:
    """Import files of other tools as a bench folder: what they hold, every guess
    marked, everything unknown as a question.

    Exit code 0: written, and what could not be read named; 1: nothing could be read; 2:
    the command was misused."""
    from benchtwin.vision.import_command import import_command

    return import_command(files, out, rig, track, overwrite, quiet)


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
) -> int:
    """Measure the shapes of a lot of seeds: sizes and outlines, one by one, for
    simulations that use them ([seed] lot).

    Exit code 0: measured; 1: no whole seed was found; 2: the command was misused.
    """
    from benchtwin.vision.shape.command import shape_command

    return shape_command(
        photos,
        out,
        side,
        mm_per_px=mm_per_px,
        mm_per_px_sd=mm_per_px_sd,
        distance_mm=distance_mm,
        scanner=scanner,
        overwrite=overwrite,
        quiet=quiet,
    )


def board(
    out: Annotated[Path, said("PDF or PNG to be written.")],
    size: Annotated[str, said("Paper: A4, A5 or A6.")] = "A5",
) -> None:
    """Make a board to print: wherever a picture or film shows it, scale, level and the
    camera's pitch are read from it, and nothing of them need be stated.

    Exit code 0: written; 2: the command was misused."""
    from benchtwin.vision.board.sheet import sheet_of, write_board

    sheet = sheet_of(size)
    write_board(sheet, out)
    print(
        f"{out}: print it on {sheet.name} at 100 % and measure its line"
        f" ({sheet.line_mm} mm); docs/filming.md says where it stands"
    )


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
) -> int:
    """Fill a seed's true shape with overlapping balls, for LAMMPS, LIGGGHTS, YADE and
    EDEM; mass and inertia are the shape's.

    Exit code 0: written; 2: the command was misused, or the file is no closed shape.
    """
    from benchtwin.sim.seed.clump_command import clump_command

    return clump_command(
        source,
        out,
        spheres=spheres,
        tolerance=tolerance,
        unit=unit,
        voxel_mm=voxel_mm,
        density_kg_m3=density_kg_m3,
        overwrite=overwrite,
        quiet=quiet,
    )


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

    for name in [known(kind)] if kind else kinds():
        print(name, *(f"  {entry}" for entry in kinds()[name]), sep="\n")


def new(
    bench: Annotated[Path, given("Folder to make.", metavar="BENCH")],
) -> None:
    """Make an empty bench: a folder with a bench.toml that names every key, with what
    it means.

    Exit code 0: made; 2: it is there already, or cannot be written.
    """
    from benchtwin.vision.new_bench import new_bench

    print(
        f"{new_bench(bench)}: say there what is known, and put recordings beside it"
        f" (benchtwin page {bench} helps with both)"
    )


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
    from benchtwin.page.command import page

    page(folder, port, browser)


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
    from benchtwin.report.pdf import page_of, print_pdf

    report = page_of(results)
    to = out or report.with_suffix(".pdf")
    print_pdf(report, to)
    if not quiet:
        print(to)


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
    from benchtwin.report.pack import pack

    packed = pack(bench, results or [], out, runs)
    if not quiet:
        print(*packed.in_words(out), sep="\n")


def unpack(
    packed: Annotated[Path, given("What `benchtwin pack` made: a folder or a zip.")],
    out: Annotated[Path | None, said("Folder to copy it to; else only check.")] = None,
    quiet: Quiet = False,
) -> int:
    """Check a pack, file by file, and copy it into a folder.

    Exit code 0: every file is as it was packed; 1: some are not, or it cannot be
    written; 2: it is no pack, or of a newer format.
    """
    from benchtwin.report.unpack import unpack

    opened = unpack(packed, out)
    if not (quiet and opened.whole):
        print(*opened.in_words(), sep="\n")
    return DONE if opened.whole else FAILED
