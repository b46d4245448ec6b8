"""The files of a lot of seeds measured from photos, as `benchtwin shape` writes them.

seeds.csv: a row for each thing found; outlines.csv: elliptic Fourier terms of each
whole seed [mm]; lot.toml: a summary."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from benchtwin.bench.distributions import t as student
from benchtwin.bench.language import tr
from benchtwin.bench.section import SIZE_LIMITS_MM
from benchtwin.vision.measurement import MeasurementError, require
from benchtwin.vision.shape.outline import from_fourier_terms

SEEDS, OUTLINES, SUMMARY = "seeds.csv", "outlines.csv", "lot.toml"
WHOLE = "whole"
TOUCHING = "touching another"
BROKEN = "broken"
HUSK = "husk"
CUT = "cut by the border"
OTHER = "other"
SIZES = ("length", "width", "thickness")
SEED_COLUMNS = (
    "photo",
    "seed",
    "kind",
    "x_px",
    "y_px",
    *(f"{name}{end}_mm" for name in SIZES for end in ("", "_sd")),
    "area_mm2",
    "reason",
)
OUTLINE_COLUMNS = ("photo", "seed", "harmonic", "ax", "bx", "ay", "by")


@dataclass(frozen=True, eq=False)
class MeasuredSeed:
    """One whole seed: its sizes [mm], a thickness of NaN where no photo shows it;
    terms (h, 4): Fourier terms of the outline [mm]."""

    photo: str
    seed: int
    length_mm: float
    width_mm: float
    thickness_mm: float
    terms: np.ndarray

    def outline_mm(self, points: int) -> np.ndarray:
        """Its outline (points, 2) about the centroid, length along x, counter-clockwise
        [mm]."""
        return from_fourier_terms(self.terms, points)


@dataclass(frozen=True, eq=False)
class Lot:
    """The whole seeds of a lot, in the order of seeds.csv."""

    seeds: tuple[MeasuredSeed, ...]

    def sizes_mm(self) -> np.ndarray:
        """Length, width, thickness of each seed (n, 3); NaN for an unknown
        thickness."""
        sizes = [(s.length_mm, s.width_mm, s.thickness_mm) for s in self.seeds]
        return np.array(sizes, float).reshape(-1, 3)


def read_lot(folder: Path) -> Lot:
    """Read a lot that `benchtwin shape` wrote; MeasurementError naming the file and
    what is wrong."""
    rows = _table(folder / SEEDS, SEED_COLUMNS)
    lines = _table(folder / OUTLINES, OUTLINE_COLUMNS)
    outlines = dict(list(lines.sort_values("harmonic").groupby(["photo", "seed"])))
    seeds = []
    for row in rows[rows["kind"] == WHOLE].to_dict("records"):
        key = (str(row["photo"]), int(row["seed"]))
        if (outline := outlines.get(key)) is None:
            raise MeasurementError(
                tr(
                    "{}: no outline of seed {}:{}, which {} lists as whole",
                    folder / OUTLINES,
                    key[0],
                    key[1],
                    SEEDS,
                )
            )
        if list(outline["harmonic"]) != list(range(1, len(outline) + 1)):
            raise MeasurementError(
                tr(
                    "{}: seed {}:{}: harmonic must be 1, 2, 3 … without a gap",
                    folder / OUTLINES,
                    key[0],
                    key[1],
                )
            )
        sizes = [float(row[f"{name}_mm"]) for name in SIZES]
        for name, size in zip(SIZES[:2], sizes):
            if not SIZE_LIMITS_MM[0] <= size <= SIZE_LIMITS_MM[1]:
                raise MeasurementError(
                    tr(
                        "{}: seed {}:{}: {}_mm must be 0.05 to 2000",
                        folder / SEEDS,
                        key[0],
                        key[1],
                        name,
                    )
                )
        terms = outline[["ax", "bx", "ay", "by"]].to_numpy(float)
        seeds.append(MeasuredSeed(*key, *sizes, terms))
    require(seeds, tr("{}: no whole seed in it", folder / SEEDS))
    return Lot(tuple(seeds))


def _table(file: Path, columns: tuple[str, ...]) -> pd.DataFrame:
    try:
        table = pd.read_csv(file, dtype={"photo": str, "kind": str, "reason": str})
    except FileNotFoundError:
        raise MeasurementError(
            tr("{}: is missing; benchtwin shape writes it", file)
        ) from None
    except (ValueError, OSError) as error:
        raise MeasurementError(
            tr("{}: cannot be read as a table: {}", file, error)
        ) from error
    if missing := [name for name in columns if name not in table]:
        raise MeasurementError(tr("{}: column {} is missing", file, missing[0]))
    for name in set(columns) - {"photo", "kind", "reason"}:
        numbers = pd.to_numeric(table[name], errors="coerce")
        wrong = (numbers.isna() & table[name].notna()) | np.isinf(numbers)
        if wrong.any():
            row = int(wrong.argmax())
            raise MeasurementError(
                tr(
                    "{}: row {}: {} = {!r} is not a number",
                    file,
                    row + 2,
                    name,
                    table[name].iloc[row],
                )
            )
        table[name] = numbers
    for name in {"seed", "harmonic"} & set(columns):
        require(
            not table[name].isna().any(),
            tr("{}: column {} must hold a whole number in every row", file, name),
        )
    return table


def doubts_of(rows: pd.DataFrame) -> list[str]:
    """Why whole seeds are doubtful, each with how many of them: "15 of 15: …"."""
    whole = rows[rows["kind"] == WHOLE]
    said = whole["reason"].fillna("").str.split("; ").explode()
    counts = said[said != ""].value_counts()
    return [
        tr("{} of {} whole seeds: {}", n, len(whole), why) for why, n in counts.items()
    ]


def lot_summary(
    rows: pd.DataFrame,
    lot: Lot,
    scale: str,
    common: float,
    thickness: tuple[float, float, int] | None,
) -> dict:
    """Contents of lot.toml: counts of each kind, scale, doubts, mean with 95 % interval
    and sd of each size, correlations. common: relative sd of the errors
    that all seeds share, for each size. thickness: mean, sd [mm] and number where it is
    from other seeds of the lot."""
    sizes = lot.sizes_mm()
    content: dict = {
        "counts": {
            kind: int((rows["kind"] == kind).sum()) for kind in rows["kind"].unique()
        },
        "scale": scale,
        "doubts": doubts_of(rows),
    }
    for k, name in enumerate(SIZES):
        values = sizes[np.isfinite(sizes[:, k]), k]
        if len(values):
            mean = float(values.mean())
            sd = float(values.std(ddof=1)) if len(values) > 1 else np.nan
            n = len(values)
        elif name == "thickness" and thickness is not None:
            mean, sd, n = thickness
        else:
            continue
        half = float(
            np.hypot(
                student.ppf(0.975, n - 1) * sd / np.sqrt(n) if n > 1 else np.inf,
                1.96 * common * mean,
            )
        )
        interval = (
            [round(mean - half, 4), round(mean + half, 4)] if np.isfinite(half) else []
        )
        content[name] = {
            "mean_mm": round(mean, 4),
            "mean_low_high_mm": interval,
            **({"sd_mm": round(sd, 4)} if n > 1 else {}),
            "n": n,
        }
    seen = [k for k in range(3) if np.isfinite(sizes[:, k]).all()]
    if len(sizes) > 2:
        matrix = np.corrcoef(sizes[:, seen].T)
        pairs = {
            f"{SIZES[i]}_{SIZES[j]}": round(float(matrix[a, b]), 3)
            for a, i in enumerate(seen)
            for b, j in enumerate(seen)
            if a < b
        }
        content["correlations"] = {
            name: value for name, value in pairs.items() if np.isfinite(value)
        }
    return content
