"""The tables in BENCH/tables/: what each must hold. Errors name the file, the row and
what belongs there."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pandas as pd

from benchtwin.bench.language import tr
from benchtwin.bench.tells import ByCurve
from benchtwin.calibrate.procedure.rigs import (
    PILE,
    SEED_FACTORS,
    SEED_LIMITS,
)
from benchtwin.calibrate.statistics.box import Box
from benchtwin.twin.bench_folder import read_numbers

# the factors of design.csv, in the order of the columns of levels.csv
LETTERS = ("A", "B", "C")
# what a reading can be at all: up to 100 m, up to the vertical
READING = {"mm": (0.0, 100_000.0), "deg": (0.0, 90.0)}
CODED = (-2.0, 2.0)  # axial points of a rotatable design stand at 1.68
ANY = (-1e9, 1e9)  # whatever is a number
SEEDS = {name: (0.0, SEED_LIMITS[name][1]) for name in SEED_FACTORS}


def steel_table(file: Path, rig: ByCurve) -> pd.DataFrame:
    """drop.csv, slide.csv, roll.csv: the rig's parameter, its reading, and where it is
    there the sd of single runs.

    These and the readers below raise FileNotFoundError and ValueError.
    """
    needed = {rig.parameter: (0.0, rig.limits[1]), rig.response: READING[rig.unit]}
    return _numbers(file, needed, {rig.sd: READING["mm"]})


def levels_table(file: Path) -> pd.DataFrame:
    """levels.csv: three rows, coded −1, 0, 1, and the factors' values; 0 midway."""
    levels = _numbers(file, {"coded": (-1.0, 1.0), **SEEDS})
    if sorted(levels["coded"]) != [-1, 0, 1]:
        found = ", ".join(f"{v:g}" for v in levels["coded"])
        raise ValueError(
            tr(
                "{}: column coded should hold −1, 0 and 1, a row each; here are {}",
                file,
                found,
            )
        )
    by = levels.set_index("coded")
    for name in (c for c in levels if c != "coded"):
        low, middle, high = by.loc[-1, name], by.loc[0, name], by.loc[1, name]
        if low < high and abs(middle - (low + high) / 2) > 0.01 * (high - low):
            raise ValueError(
                tr(
                    "{}: {} at 0 should be midway, {:g}; here is {:g}",
                    file,
                    name,
                    (low + high) / 2,
                    middle,
                )
            )
    return levels


def levels_box(file: Path) -> Box:
    """The box that the levels −1 and 1 of levels.csv span."""
    by = levels_table(file).set_index("coded")
    with naming(file):
        return Box(tuple(by.columns), *by.loc[[-1, 1]].to_numpy(float))


def design_table(file: Path, box: Box) -> pd.DataFrame:
    """design.csv, a row a pile, A, B, C coded: its factors in natural units, to twelve
    digits, and its angle."""
    columns = dict.fromkeys(LETTERS, CODED) | {PILE.response: READING["deg"]}
    coded = _numbers(file, columns)
    natural = np.round(box.natural(coded[list(LETTERS)]), 12)
    design = pd.DataFrame(natural, columns=list(box.names))
    return design.assign(**{PILE.response: coded[PILE.response]})


def path_table(file: Path) -> pd.DataFrame:
    """path.csv, a row a group of the steepest ascent: its number (else 1 …), factors,
    angle, the error printed if it is."""
    optional = {"group": ANY, "relative_error_percent": ANY}
    path = _numbers(file, {**SEEDS, PILE.response: READING["deg"]}, optional)
    if "group" not in path:
        path.insert(0, "group", np.arange(1, len(path) + 1))
    if len(part := path.index[path["group"] % 1 != 0]):
        raise ValueError(
            tr(
                "{}: group = {:g} in row {}; it should be a whole number",
                file,
                path["group"][part[0]],
                part[0] + 2,
            )
        )
    return path.astype({"group": int})


@contextmanager
def naming(file: Path) -> Iterator[None]:
    """What is wrong with a table's numbers, with its file."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from error


def _numbers(file: Path, needed: dict, optional: dict | None = None) -> pd.DataFrame:
    if not file.is_file():
        raise FileNotFoundError(
            tr("{}: not there; it should have the columns {}", file, ", ".join(needed))
        )
    return read_numbers(file, needed, optional)
