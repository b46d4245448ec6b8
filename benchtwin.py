"""The front door: the command line, one short function a verb, heavy imports inside."""

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False, rich_markup_mode=None)


@app.callback()
def benchtwin() -> None:
    """DEM contact parameters for seeds and grains, from what you film at the bench."""


@app.command()
def measure(
    paths: Annotated[list[Path], typer.Argument(help="Photos, folders of photos, recordings, bench folders, in any mix.")],
    out: Annotated[Path, typer.Option(help="Folder for measurements.csv, overlays/, tracks/, bounces.csv.")],
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


def main() -> None:
    app()


if __name__ == "__main__":
    main()
