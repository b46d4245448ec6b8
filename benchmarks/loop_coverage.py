"""How often the pile posterior holds the truth, over many designs and many benches:
closed forms with packing noise, no DEM.

python benchmarks/loop_coverage.py [DESIGNS [BENCHES [SEED]]]
    → benchmarks/tables/loop/coverage.csv (three minutes a row)
python benchmarks/loop_coverage.py --more [DESIGNS [BENCH_PILES [SEED]]]
    → benchmarks/tables/loop/more_piles.csv
python benchmarks/loop_coverage.py --packings [BENCHES]
    how far medians of one bench differ by the simulated packings alone, printed

The design is a quick calibration's, run and fitted by the procedure itself; every bench
has one pile. --more: each design has one bench of BENCH_PILES piles; the same with the
design repeated, and with piles added where they tell most (procedure/seed_runs.py).
Responses are quadratics in the seed–seed parameters, of the sizes that 48 piles of
loop.py showed, in units of packing noise: angle, centroid angle, weights filled in and
left; packing noise correlated as there. bend: sd of ten cubic coefficients, drawn anew
for every design; quiet: by how much packing noise is divided. rank: share of the
posterior below the truth; joint: share of it denser than the truth."""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from benchtwin.calibrate.procedure.bench import RigReadings
from benchtwin.calibrate.procedure.effort import QUICK
from benchtwin.calibrate.procedure.observed import observed, steel_box
from benchtwin.calibrate.procedure.pile_stage import PileStage
from benchtwin.calibrate.procedure.rigs import RANGES, STEEL
from benchtwin.calibrate.procedure.seed_runs import add_piles, simulate_design
from benchtwin.calibrate.statistics import terms as polynomial
from benchtwin.calibrate.statistics.box import Box
from benchtwin.calibrate.statistics.information import weighted
from benchtwin.calibrate.statistics.posterior import log_posterior
from benchtwin.calibrate.statistics.prior import Prior

TABLE = Path("benchmarks/tables/loop/coverage.csv")
COLUMNS = (
    "repose_angle_deg",
    "true_centroid_angle_deg",
    "true_filled_mass_g",
    "true_retained_mass_g",
)
SD = np.array([3.77, 1.65, 1.20, 1.19])
IN_SD = np.array(
    [  # intercept, A … C, AB … BC, A² … C², in sds of one pile
        [6.3, 0.0, 0.3, 0.5, 0.05, 0.2, -0.3, 0.4, -0.6, -0.45],
        [13.4, 0.1, 0.6, 1.3, 0.0, 0.0, -0.1, 0.0, -1.1, -0.1],
        [27.6, 0.3, -1.0, -0.2, 0.5, 0.4, 0.2, -0.4, 0.4, 0.2],
        [27.8, 0.3, -0.9, -0.1, 0.5, 0.4, 0.2, -0.4, 0.3, 0.15],
    ]
)
CORRELATION = np.array(
    [
        [1, 0.24, -0.16, -0.15],
        [0.24, 1, 0.36, 0.37],
        [-0.16, 0.36, 1, 0.98],
        [-0.15, 0.37, 0.98, 1],
    ]
)
STEEL_TRUE = {
    "restitution": 0.4858,
    "static_friction": 0.3780,
    "rolling_friction": 0.0193,
}
STEEL_SD = {"restitution": 0.010, "static_friction": 0.0008, "rolling_friction": 0.0001}
STEEL_IN_SD = np.array(
    [[0.1, 0.4, 0.3], [0.1, 0.5, 0.4], [0.0, -0.2, 0.0], [0.0, -0.2, 0.0]]
)  # for ± 25 %
POINTS, LEVELS = 6_000, (0.50, 0.80, 0.95)
CASES = [
    (0.0, 1.0),
    (0.3, 1.0),
    (0.0, 4.0),
    (0.1, 4.0),
]  # bend in packing sds before they are divided, quiet


class Piles:
    """A simulator of piles: one truth, drawn with its cubic part."""

    def __init__(self, rng: np.random.Generator, bend: float, quiet: float) -> None:
        self.box, self.rng, self.quiet = Box.of(RANGES), rng, quiet
        self.cubes = [
            tuple(sorted((i, j, k)))
            for i in range(3)
            for j in range(i, 3)
            for k in range(j, 3)
        ]
        self.bent = bend * rng.standard_normal((len(COLUMNS), len(self.cubes)))
        self.noise: dict[tuple, np.ndarray] = {}
        self.root = np.linalg.cholesky(CORRELATION)

    def mean(self, natural: dict[str, float]) -> np.ndarray:
        z = self.box.coded([[natural[n] for n in RANGES]])
        steel = np.array([(natural[n] / STEEL_TRUE[n] - 1) / 0.25 for n in STEEL_TRUE])
        cubic = np.array([z[0, list(c)].prod() for c in self.cubes])
        return SD * (
            IN_SD @ polynomial.matrix(z, polynomial.full(3))[0]
            + self.bent @ cubic
            + STEEL_IN_SD @ steel
        )

    def pile(self, natural: dict[str, float]) -> np.ndarray:
        return self.mean(natural) + SD / self.quiet * (
            self.root @ self.rng.standard_normal(len(COLUMNS))
        )

    def __call__(self, runs) -> pd.DataFrame:
        rows = [
            dict(zip(COLUMNS, self.pile(r.values)))
            | {
                "status": "done",
                "reason": "",
                "rerun": "",
            }
            for r in runs
        ]
        return pd.DataFrame(rows)


def readings(piles: np.ndarray) -> RigReadings:
    """A bench's piles (n, columns)."""
    further = {c.removeprefix("true_"): v for c, v in zip(COLUMNS[1:], piles.T[1:])}
    return RigReadings(
        rig="pile",
        response=COLUMNS[0],
        values=piles[:, 0],
        reading_sd=np.zeros(len(piles)),
        further=further,
    )


def design(
    piles: Piles, found: dict, *, times: int = 1
) -> tuple[PileStage, pd.DataFrame]:
    """A stage, and all piles of a quick design, run so many times over."""
    steel = steel_box(found, {rig.parameter: rig.limits for rig in STEEL.values()})
    assert steel is not None  # there is something found
    stage = PileStage(
        readings=readings(np.ones((1, len(COLUMNS)))),
        fixed={n: v for n, (v, _) in found.items()},
        description={},
        simulate=piles,
        effort=QUICK,
        seed=1,
        box=Box.of(RANGES),
        steel=steel,
        steel_found=found,
    )
    done = [simulate_design(stage, k) for k in range(times)]
    return stage, pd.concat(done, ignore_index=True)


def bench(
    stage: PileStage,
    table: pd.DataFrame,
    truth: dict,
    rng: np.random.Generator,
) -> dict:
    """Ranks of one bench's truth in its posterior, on the piles of the table, and the
    seed–seed parameters' sds in those of the prior."""
    steel, found = stage.steel, stage.steel_found
    assert steel is not None and stage.readings is not None
    names, ends = (
        (*RANGES, *steel.names),
        np.array([*RANGES.values(), *zip(steel.low, steel.high)]),
    )
    prior = Prior(Box(names, ends[:, 0], ends[:, 1]), found)
    seen = observed(table, stage.readings, Box.of(RANGES), steel, alike=True)
    points = np.vstack([[truth[n] for n in names], prior.draw(POINTS, rng)])
    density = log_posterior(
        points, list(seen.observables), prior, seen.correlation.to_numpy()
    )
    log_weight = (density - prior.log_density(points))[
        1:
    ]  # the points carry the prior already
    weight = np.exp(log_weight - log_weight.max())
    weight /= weight.sum()
    ranks = {
        f"rank_{n}": float(weight @ (points[1:, j] < truth[n]))
        for j, n in enumerate(RANGES)
    }
    sd = np.sqrt(weight @ (points[1:] - weight @ points[1:]) ** 2) / prior.sd
    of = {
        "joint": float(weight @ (density[1:] > density[0])),
        "points": 1 / float(np.sum(weight**2)),
        "piles": len(table),
    }
    return ranks | of | {f"sd_{n}": float(sd[j]) for j, n in enumerate(RANGES)}


def drawn(rng: np.random.Generator) -> dict[str, float]:
    """True parameters of a bench."""
    return {n: float(rng.uniform(*RANGES[n])) for n in RANGES} | STEEL_TRUE


def study(
    designs: int, benches: int, *, bend: float, quiet: float, seed: int
) -> pd.DataFrame:
    """One row a bench: design, ranks, joint, points (effective number)."""
    rows = []
    for d in range(designs):
        rng = np.random.default_rng([seed, d])
        piles = Piles(rng, bend, quiet)
        found = {
            n: (STEEL_TRUE[n] + sd * rng.standard_normal(), sd)
            for n, sd in STEEL_SD.items()
        }
        stage, table = design(piles, found)
        for _ in range(benches):
            truth = drawn(rng)
            of = replace(stage, readings=readings(piles.pile(truth)[None]))
            rows.append({"design": d} | bench(of, table, truth, rng))
    return pd.DataFrame(rows)


WAYS = {  # times, piles added at most
    "the design": (1, 0),
    "the design twice": (2, 0),
    "the design four times": (4, 0),
    "8 piles more": (1, 8),
    "24 piles more": (1, 24),
}


def study_more(
    designs: int, bench_piles: int, *, bend: float, quiet: float, seed: int
) -> pd.DataFrame:
    """One row a design, bench and way: ranks, joint, piles, sds."""
    rows = []
    for d in range(designs):
        for way, (times, more) in WAYS.items():
            rng = np.random.default_rng([seed, d])
            piles, truth = Piles(rng, bend, quiet), drawn(rng)
            found = {
                n: (STEEL_TRUE[n] + sd * rng.standard_normal(), sd)
                for n, sd in STEEL_SD.items()
            }
            at_bench = readings(
                np.array([piles.pile(truth) for _ in range(bench_piles)])
            )
            stage, table = design(piles, found, times=times)
            stage = replace(stage, readings=at_bench, effort=replace(QUICK, more=more))
            if more:
                table, _ = add_piles(stage, table)
            seen = bench(stage, table, truth, rng)
            rows.append({"way": way, "design": d} | seen)
    return pd.DataFrame(rows)


def study_packings(benches: int, quiet: float = 1.0, bend: float = 0.1) -> pd.DataFrame:
    """A row a bench of ten piles, set of packings and parameter: low, median, high,
    truth of a quick calibration; three sets of packings a bench."""
    rows = []
    for b in range(benches):
        rng = np.random.default_rng([5, b])
        piles, truth = Piles(rng, bend, quiet), drawn(rng)
        at_bench = readings(np.array([piles.pile(truth) for _ in range(10)]))
        found = {
            n: (STEEL_TRUE[n] + sd * rng.standard_normal(), sd)
            for n, sd in STEEL_SD.items()
        }
        for packings in range(3):
            piles.rng = np.random.default_rng([9, b, packings])
            stage, table = design(piles, found)
            stage = replace(stage, readings=at_bench, seed=packings)
            table, _ = add_piles(stage, table)
            seen = observed(table, at_bench, stage.box, stage.steel, alike=True)
            posterior = weighted(
                seen.observables,
                Prior(stage.wide, found),
                seen.correlation.to_numpy(),
                np.random.default_rng(1),
            )
            draws = posterior.draw(8000, np.random.default_rng(2))
            for k, name in enumerate(RANGES):
                ends = np.quantile(draws[:, k], [0.025, 0.5, 0.975])
                rows.append((b, packings, name, *ends, truth[name]))
    columns = ["bench", "packings", "parameter", "low", "median", "high", "truth"]
    return pd.DataFrame(rows, columns=columns)


def main_packings(benches: int) -> None:
    t = study_packings(benches)
    half = (t["high"] - t["low"]) / 2
    by = t.assign(half=half).groupby(["parameter", "bench"], sort=False)
    apart = (by["median"].max() - by["median"].min()) / by["half"].mean()
    of = apart.groupby("parameter", sort=False)
    print("largest difference of medians over three sets of packings, in half widths")
    print(of.agg(["median", "max"]).round(2))
    off = ((t["median"] - t["truth"]) / half) ** 2
    print("median's error in half widths, rms")
    print(np.sqrt(off.groupby(t["parameter"], sort=False).mean()).round(2))


def rates(found: pd.DataFrame) -> pd.DataFrame:
    """How often the sets hold the truth: set, level, rate, se (benches of one design
    share its surface: between designs)."""
    rows = []
    for name in [c for c in found if c.startswith("rank_") or c == "joint"]:
        for level in LEVELS:
            held = (
                found[name] <= level
                if name == "joint"
                else abs(found[name] - 0.5) <= level / 2
            )
            by = held.groupby(found["design"]).mean()
            rows.append(
                (
                    name.removeprefix("rank_"),
                    level,
                    float(by.mean()),
                    float(by.std(ddof=1) / np.sqrt(len(by))),
                )
            )
    return pd.DataFrame(rows, columns=["set", "level", "rate", "se"])


def main(designs: int, benches: int, seed: int) -> None:
    parts = []
    for bend, quiet in CASES:
        found = study(designs, benches, bend=bend, quiet=quiet, seed=seed)
        parts.append(
            rates(found).assign(
                bend=bend, quiet=quiet, designs=designs, benches=benches
            )
        )
        shown = parts[-1].pivot(index="set", columns="level", values="rate").round(3)
        print(f"bend {bend:g}, noise / {quiet:g}\n{shown}", flush=True)
    TABLE.parent.mkdir(parents=True, exist_ok=True)
    pd.concat(parts).to_csv(TABLE, index=False, float_format="%.4g")


def main_more(designs: int, bench_piles: int, seed: int) -> None:
    parts = []
    for bend, quiet in CASES:
        found = study_more(designs, bench_piles, bend=bend, quiet=quiet, seed=seed)
        for way, rows in found.groupby("way", sort=False):
            held = rates(rows)
            held = (
                held[held["level"] == 0.95]
                .set_index("set")["rate"]
                .add_prefix("holds_95_")
            )
            of = rows[["piles", *(f"sd_{n}" for n in RANGES)]].mean()
            parts.append(
                {
                    "bend": bend,
                    "quiet": quiet,
                    "bench_piles": bench_piles,
                    "designs": designs,
                    "way": way,
                }
                | dict(of)
                | dict(held)
            )
            print(
                {
                    k: v if isinstance(v, str) else round(float(v), 3)
                    for k, v in parts[-1].items()
                },
                flush=True,
            )
        pd.DataFrame(parts).to_csv(
            TABLE.with_name("more_piles.csv"), index=False, float_format="%.4g"
        )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("designs", type=int, nargs="?", default=150)
    parser.add_argument(
        "benches",
        type=int,
        nargs="?",
        help="benches of a design, default 8; with --more piles of a bench, default 5",
    )
    parser.add_argument("seed", type=int, nargs="?", default=2)
    parser.add_argument("--more", action="store_true")
    parser.add_argument("--packings", action="store_true")
    asked = parser.parse_args()
    if asked.packings:
        main_packings(asked.designs)
    elif asked.more:
        main_more(asked.designs, asked.benches or 5, asked.seed)
    else:
        main(asked.designs, asked.benches or 8, asked.seed)
