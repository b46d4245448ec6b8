"""`benchtwin shape`: measures photos of spread seeds and writes a lot of seed
shapes."""

import math
from collections.abc import Callable
from pathlib import Path

import tomli_w
from PIL import Image
from rich.text import Text

from benchtwin.bench.exits import DONE, FAILED, say
from benchtwin.bench.language import tr
from benchtwin.bench.outlets import csv_text, plain
from benchtwin.bench.terminal import Terminal
from benchtwin.vision.evidence.photo import PHOTO_SUFFIXES
from benchtwin.vision.measurement import MeasurementError, require
from benchtwin.vision.out_folder import check_out, new_folder
from benchtwin.vision.overlay.seeds import draw_outlines, draw_sizes
from benchtwin.vision.shape.lot import (
    OUTLINES,
    SEEDS,
    SIZES,
    SUMMARY,
    WHOLE,
    lot_summary,
    read_lot,
)
from benchtwin.vision.shape.lot_photos import View, measure_lot_photos, with_thickness

LEAST_DISTANCE_MM = 50.0  # of any lens
OWN = {SEEDS, OUTLINES, SUMMARY, "overlays", "outlines.png", "sizes.png"}


def shape_command(
    photos: list[Path],
    out: Path,
    side: list[Path],
    mm_per_px: float | None,
    mm_per_px_sd: float | None,
    distance_mm: float | None,
    scanner: bool,
    overwrite: bool,
    quiet: bool,
) -> int:
    """Measure the seeds of all photos and write the lot into the folder `out`; returns
    the exit code."""
    console = Terminal(stderr=True, quiet=quiet)
    check_out(out, "a lot", _is_own, overwrite)
    require(
        not scanner or distance_mm is None,
        "--scanner and --distance-mm: a scanner has no distance; give one of them",
    )
    if distance_mm is not None and not distance_mm > LEAST_DISTANCE_MM:
        raise MeasurementError(
            f"--distance-mm {distance_mm:g}: must be above {LEAST_DISTANCE_MM:g}; it is"
            " the lens's distance from the paper"
        )
    view = View(mm_per_px, mm_per_px_sd, math.inf if scanner else distance_mm)
    found, turned = _photos(photos), _photos(side)

    def report(name: str) -> None:
        status.update(Text(plain(f"measuring {name}")))

    try:
        with (
            new_folder(out, _is_own, overwrite) as part,
            console.status("measuring") as status,
        ):
            content, notes = _write(part, found, turned, view, report)
    except MeasurementError as error:
        return say("shape", error, FAILED)
    if not quiet:
        _show(content, notes, out)
    return DONE


def _is_own(path: Path) -> bool:
    return path.name in OWN


def _write(
    part: Path,
    photos: list[Path],
    turned: list[Path],
    view: View,
    report: Callable[[str], None],
) -> tuple[dict, tuple[str, ...]]:
    """Measure the photos and write the lot's files; returns the content of lot.toml and
    the notes."""
    lot_photos, thickness = measure_lot_photos(photos, view, report), None
    if turned:
        lot_photos, thickness = with_thickness(
            lot_photos, measure_lot_photos(turned, view, report)
        )
    for file, table in ((SEEDS, lot_photos.seeds), (OUTLINES, lot_photos.outlines)):
        (part / file).write_text(csv_text(table, None), encoding="utf8")
    lot = read_lot(part)
    content = lot_summary(
        lot_photos.seeds, lot, lot_photos.scale, lot_photos.common, thickness
    )
    (part / SUMMARY).write_text(tomli_w.dumps(content), encoding="utf8")
    (part / "overlays").mkdir()
    pictures = {
        f"overlays/{Path(name).stem}.png": p for name, p in lot_photos.pictures.items()
    }
    pictures |= {"outlines.png": draw_outlines(lot), "sizes.png": draw_sizes(lot)}
    for name, picture in pictures.items():
        Image.fromarray(picture).save(part / name)
    return content, lot_photos.notes


def _photos(paths: list[Path]) -> list[Path]:
    found: list[Path] = []
    for path in paths:
        if path.is_dir():
            inside = sorted(
                p for p in path.iterdir() if p.suffix.lower() in PHOTO_SUFFIXES
            )
            require(
                inside, tr("{}: no photo in it ({})", path, ", ".join(PHOTO_SUFFIXES))
            )
            found += inside
        elif path.is_file():
            found.append(path)
        else:
            raise MeasurementError(tr("{}: no such file or folder", path))
    if twice := {p.name for p in found if sum(q.name == p.name for q in found) > 1}:
        raise MeasurementError(
            tr("{}: two photos of one name; seeds are named by their photo", min(twice))
        )
    return found


def _show(content: dict, notes: tuple[str, ...], out: Path) -> None:
    kinds = sorted(content["counts"].items(), key=lambda item: item[0] != WHOLE)
    print(", ".join(f"{n} {kind}" for kind, n in kinds))
    for name in SIZES:
        if name in content:
            of = content[name]
            ends = " to ".join(f"{end:.3f}" for end in of["mean_low_high_mm"])
            interval = f" ({ends})" if ends else ""
            sd = f", sd {of['sd_mm']:.3f}" if "sd_mm" in of else ""
            print(f"{name:9}  {of['mean_mm']:.3f}{interval} mm{sd}, n = {of['n']}")
    print(
        *(f"doubtful: {doubt}" for doubt in content["doubts"]),
        *notes,
        tr(
            "Seeds: {}; summary: {}; look at {} and {}",
            out / SEEDS,
            out / SUMMARY,
            out / "overlays",
            out / "outlines.png",
        ),
        sep="\n",
    )
