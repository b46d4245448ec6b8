"""Beliefs of `bench/priors.py` beside what public recordings tell.

    git clone https://github.com/DAIRLab/contact-nets CLONES/contact-nets
    git clone https://github.com/rizfn/AppStat2022 CLONES/AppStat2022
    git clone https://github.com/giiulia/LabI-Dynamics-Thermodynamics \\
        CLONES/LabI-Dynamics-Thermodynamics
    python benchmarks/learn_priors.py CLONES        → tables/learnt_priors.csv

What one set of recordings has in common (one table, one ruler) is one draw with an
error of its own; slides and bounces are a draw each. The sd between the draws about 0
is estimated by restricted likelihood over a prior that is even in its logarithm.
Nothing of the recordings is kept."""

import argparse
import pickle
import re
import struct
from collections import OrderedDict, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.optimize import brentq

from benchtwin.bench.priors import PRIORS

TABLE = Path(__file__).parent / "tables" / "learnt_priors.csv"
G = 9.80665
SIDE_M, FPS = 0.1048, 148.0  # contact-nets' cube and cameras; lengths in half sides
TOSSES = 285  # the other half is kept, to check against
SLIDES_M_S, FLAT, GAP_M, LEAST = 0.06, 0.9995, 0.003, 10  # a slide to rest: see below
GATES_M = np.array([0.187, 0.3645, 0.5465, 0.735, 0.9123])  # of AppStat2022's incline
BALLS_M, RAILS_M = {"big": 0.0150, "small": 0.0127}, 0.00605
AIR_KG_M3, DRAG = 1.2, 0.47  # of a sphere at 1e3 < Re < 1e5
PING_PONG = AIR_KG_M3 * DRAG * np.pi * 0.02**2 / 2 / 2.7e-3  # k in −k v² [1/m]


@dataclass(frozen=True)
class Draw:
    """One thing that people set up or stated: how far off it was, and how well that is
    known."""

    prior: str
    where: str
    off: float
    sd: float


# contact-nets (BSD-3): a cube tossed on a table


class TensorFile(pickle.Unpickler):
    """Reads a stored tensor and runs nothing that stands in the file."""

    def find_class(self, module: str, name: str):
        known = {
            ("torch._utils", "_rebuild_tensor_v2"): lambda *told: told,
            ("collections", "OrderedDict"): OrderedDict,
            ("torch", "FloatStorage"): "<f4",
            ("torch", "DoubleStorage"): "<f8",
        }
        return known[module, name]

    def persistent_load(self, told):
        return told


def tensor(file: Path) -> np.ndarray:
    """The array of a tensor that an old version of torch stored."""
    with file.open("rb") as stream:
        for _ in range(3):  # magic number, version, sizes
            TensorFile(stream).load()
        storage, offset, shape, stride, *_ = TensorFile(stream).load()
        TensorFile(stream).load()  # names of the storages
        (count,) = struct.unpack("<q", stream.read(8))
        kind = np.dtype(storage[1])
        flat = np.frombuffer(stream.read(count * kind.itemsize), kind)[offset:]
    strides = [step * kind.itemsize for step in stride]
    return np.lib.stride_tricks.as_strided(flat, shape, strides).astype(float)


def tosses(clones: Path) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Place (n, 3) [m], the vertical in the cube's own axes (n, 3), gap below its
    lowest corner (n,) [m]."""
    folder = clones / "contact-nets" / "data" / "tosses_processed"
    for number in range(TOSSES):
        rows = tensor(folder / f"{number}.pt")[0]
        place, q = rows[:, :3] * SIDE_M / 2, rows[:, 3:7]
        w, x, y, z = (q / np.linalg.norm(q, axis=1)[:, None]).T
        up = np.column_stack(
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]
        )
        yield place, up, place[:, 2] - SIDE_M / 2 * np.abs(up).sum(1)


def of_tosses(clones: Path) -> Iterator[Draw]:
    """The table's slope, friction of each slide; and the scale, from gravity."""
    slides, falls, within = [], [], []
    for place, up, gap in tosses(clones):
        fall = int(np.argmax(gap < 0.004)) or len(gap)
        if fall >= LEAST + 4:
            t = np.arange(fall - 2) / FPS
            falls.append(-2 * np.polyfit(t, place[1 : fall - 1, 2], 2)[0])
        speed = np.hypot(*np.gradient(place[:, :2], 1 / FPS, axis=0).T)
        flat = np.abs(up).max(1) > FLAT
        edges = np.diff(np.r_[0, flat & (gap < GAP_M) & (speed > SLIDES_M_S), 0])
        runs = np.flatnonzero(edges).reshape(-1, 2)
        if not len(runs) or np.ptp(runs, axis=1).max() < LEAST:
            continue
        run = slice(*runs[np.argmax(np.ptp(runs, axis=1))])
        t = np.arange(run.stop - run.start) / FPS
        curve = np.polyfit(t, place[run, :2], 2)
        slides.append((2 * curve[0] / G, curve[1] / np.hypot(*curve[1])))
        within.append(_thirds(t, place[run, :2] @ slides[-1][1]))
    slowing, towards = (np.array(part) for part in zip(*slides, strict=True))
    columns = np.zeros((2 * len(slides), 3))  # friction, slopes along x and y
    columns[:, 0] = -towards.T.ravel()
    columns[: len(slides), 1] = columns[len(slides) :, 2] = 1
    found, cov = robust_line(columns, slowing.T.ravel())
    for k, axis in ((1, "x"), (2, "y")):
        sd = np.degrees(np.sqrt(cov[k, k]))
        yield Draw("level-plate", f"contact-nets, {axis}", np.degrees(found[k]), sd)
    gravity, sd = np.median(falls), 1.25 * np.std(falls) / np.sqrt(len(falls))
    yield Draw("scale", "contact-nets", gravity / G - 1, sd / G)
    each = -(slowing * towards).sum(1)
    middle = np.median(each)
    for k in map(int, np.flatnonzero(np.abs(each - middle) < 0.1)):
        yield Draw("friction-scatter", f"contact-nets {k}", each[k] - middle, 0.003)
    thirds = np.array([w for w in within if w is not None])
    for k, off in enumerate(thirds.ravel()):
        yield Draw("friction-within-run", f"contact-nets {k}", off, 0.005)
    late = thirds[:, 2] - thirds[:, 1]  # behind an unsteady start
    shared = np.median(late) / (1.4826 * np.median(np.abs(late - np.median(late))))
    yield Draw("friction-shared", "contact-nets", shared, len(late) ** -0.5)


def _thirds(t: np.ndarray, x: np.ndarray) -> np.ndarray | None:
    """Friction (3,) in each third of a slide, less its mean."""
    if len(t) < 3 * LEAST:
        return None
    parts = np.array_split(np.arange(len(t)), 3)
    mu = np.array([-2 * np.polyfit(t[p] - t[p].mean(), x[p], 2)[0] / G for p in parts])
    return mu - mu.mean()


def robust_line(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least squares without what lies beyond 3 sds, and its covariance."""
    for _ in range(4):
        found = np.linalg.lstsq(a, b, rcond=None)[0]
        left = np.abs(b - a @ found)
        kept = left < 3 * 1.4826 * np.median(left)
        a, b = a[kept], b[kept]
    found = np.linalg.lstsq(a, b, rcond=None)[0]
    return found, np.linalg.inv(a.T @ a) * np.var(b - a @ found)


# AppStat2022: a ball on rails past light gates, the apparatus turned round


def of_gates(clones: Path) -> Iterator[Draw]:
    """The table's slope, from both directions of two balls."""
    folder = clones / "AppStat2022" / "Project" / "data" / "Project" / "incline_data"
    slopes = []
    for name, diameter in BALLS_M.items():
        found = defaultdict(list)
        for file in sorted(folder.glob("*.csv")):
            told = re.fullmatch(rf"{name}l?_(LR|RL)_\d+", file.stem, re.IGNORECASE)
            if told and (a := acceleration(file)) is not None:
                found[told[1].upper()].append(a)
        arm = (diameter / 2) ** 2 - (RAILS_M / 2) ** 2
        inertia = 1 + 0.4 * (diameter / 2) ** 2 / arm
        apart = np.mean(found["LR"]) - np.mean(found["RL"])
        slopes.append(np.degrees(apart / 2 * inertia / G))
    sd = np.ptp(slopes) / 2
    yield Draw("level-plate", "AppStat2022", float(np.mean(slopes)), float(sd))


def acceleration(file: Path) -> float | None:
    """Of the ball past the gates [m/s²]; None where they were not all passed."""
    time, volt = pd.read_csv(file, comment="#").to_numpy(float).T[:2]
    high = volt > 3.4
    edge = np.flatnonzero(high[1:] != high[:-1])
    if len(edge) != 2 * len(GATES_M) or high[0]:
        return None
    middle = (time[edge] + time[edge + 1]).reshape(-1, 2).mean(1) / 2
    return 2 * np.polyfit(middle - middle[0], GATES_M, 2)[0]


# LabI-Dynamics-Thermodynamics: impacts of a table-tennis ball, timed by their sound


def of_sounds(clones: Path) -> Iterator[Draw]:
    """How far stated heights are off by the bounces behind the first, and by how
    much restitution scatters from bounce to bounce."""
    folder = clones / "LabI-Dynamics-Thermodynamics" / "Coefficient_of_restitution"
    heights, scatter = defaultdict(list), list[float]()
    for file in sorted(folder.rglob("pingpong_ball/*.xlsx")):
        told = re.search(r",(\d+)cm$", file.stem)
        assert told is not None, file
        sheets = pd.read_excel(file, sheet_name=None, engine="calamine")
        for times in _impacts(sheets["All"]):
            speeds = np.array([speed_of_hop(t) for t in np.diff(times)])
            landing = [speed_after(hop) for hop in speeds]
            e = speeds[1:] / landing[:-1]
            kept = e[: max(3, len(e) // 2)]
            before = speeds[0] / np.median(kept)
            off = 1e3 * fall_of(before) - 10 * int(told[1])
            heights[told[1]].append(off)
            scatter.extend(kept - np.median(kept))
    each = [np.mean(offs) for offs in heights.values()]
    sd = float(np.std(each, ddof=1) / len(each) ** 0.5)
    yield Draw("release-height", "LabI", float(np.mean(each)), sd)
    for k, off in enumerate(scatter):
        yield Draw("bounce-scatter", f"LabI {k}", off, 0.001)


def _impacts(sheet: pd.DataFrame) -> Iterator[np.ndarray]:
    for i, name in enumerate(sheet.columns):
        if str(name).startswith("Event time"):
            pair = sheet.iloc[:, i : i + 2].apply(pd.to_numeric, errors="coerce")
            pair = pair.dropna().to_numpy()
            yield np.unique(np.append(pair[:, 0], pair[-1].sum()))


def speed_after(rise: float) -> float:
    """Speed at the landing of a hop that begins with a speed, with quadratic drag."""
    return rise / np.sqrt(1 + PING_PONG * rise**2 / G)


def speed_of_hop(time_s: float) -> float:
    """Speed with which a hop that lasts so long begins."""
    root = np.sqrt(PING_PONG * G)

    def lasts(v: float) -> float:
        top = np.log1p(PING_PONG * v**2 / G) / 2  # k times the height
        return (np.arctan(v * root / G) + np.arccosh(np.exp(top))) / root - time_s

    return brentq(lasts, 1e-6, 20.0)


def fall_of(speed: float) -> float:
    """Height [m] from which a fall ends with a speed."""
    return -np.log1p(-PING_PONG * speed**2 / G) / (2 * PING_PONG)


# what the draws say together


def spread(off: np.ndarray, sd: np.ndarray) -> tuple[float, float, float]:
    """sd of the draws about 0: median and 95 % interval, even in its logarithm."""
    tried = np.geomspace(0.02, 50, 400) * max(np.sqrt(np.mean(off**2)), sd.min())
    variance = tried[:, None] ** 2 + sd**2
    ln = -0.5 * (np.log(variance) + off**2 / variance).sum(1)
    share = np.cumsum(np.exp(ln - ln.max()))
    return tuple(np.interp([0.5, 0.025, 0.975], share / share[-1], tried))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("clones", type=Path)
    clones = parser.parse_args().clones
    draws = [*of_tosses(clones), *of_gates(clones), *of_sounds(clones)]
    rows = []
    for name in dict.fromkeys(d.prior for d in draws):
        own = [d for d in draws if d.prior == name]
        off, sd = (np.array([getattr(d, k) for d in own]) for k in ("off", "sd"))
        middle, low, high = spread(off, sd)
        prior = PRIORS[name]
        held = prior.unstated if prior.unstated is not None else prior.stated
        sets = "; ".join(dict.fromkeys(re.split(r"[ ,]", d.where)[0] for d in own))
        if len(own) < 10:
            print(*(f"{d.where}: {d.off:.3g} ± {d.sd:.2g}" for d in own), sep="\n")
        rows.append((name, prior.unit, held, middle, low, high, len(own), sets))
    columns = ["prior", "unit", "believed", "learnt", "low95", "high95", "draws"]
    table = pd.DataFrame(rows, columns=[*columns, "sets"])
    print(table.to_string(index=False, float_format="%.3g"))
    table.to_csv(TABLE, index=False, float_format="%.3g")


if __name__ == "__main__":
    main()
