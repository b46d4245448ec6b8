"""Beside peers: piles until the recommended parameters give the bench's angle within 2
%, and what each says of its uncertainty.

python -m venv benchmark-runs/peers
benchmark-runs/peers/bin/pip install grainlearning coexist 'setuptools<81'
    (GrainLearning asks for numpy 1, we for numpy 2)
python benchmarks/peers_calibrate.py ours [SEEDS]
    → benchmarks/tables/peers/ours.csv
benchmark-runs/peers/bin/python \\
    benchmarks/peers_calibrate.py grainlearning|coexist [SEEDS]
python benchmarks/peers_calibrate.py
    the table

No DEM: a pile's angle is the soybean paper's Eq. 8 over ranges two and a half times as
wide as its design, plus packing noise (NOISE_DEG: the paper's centre points, and a
reduced pile's). A bench is five piles of parameters drawn at random. Everyone gets the
same benches, ranges and noise, at most BUDGET piles; after every batch each says what
it recommends, with 95 % intervals."""

import argparse
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pandas as pd

TABLES = Path("benchmarks/tables/peers")
NAMES = ("seed_restitution", "seed_static_friction", "seed_rolling_friction")
LOW, HIGH = np.array([0.45, 0.20, 0.01]), np.array([0.70, 0.70, 0.06])
NOISE_DEG = (0.28, 1.3)
BENCH_PILES, BUDGET, WITHIN = 5, 120, 0.02
EQ8 = np.array(
    [30.04, 0.5875, 0.8375, 0.775, 0.075, 0.1, 0.35, -0.0325, -0.2825, -0.2575]
)
Answer = tuple[
    int, np.ndarray, np.ndarray, np.ndarray
]  # piles so far, recommended, low, high


def angle(x: np.ndarray) -> np.ndarray:
    """The paper's Eq. 8 at natural points (…, 3) [°]."""
    a, b, c = np.moveaxis(
        (np.asarray(x) - [0.60, 0.50, 0.04]) / [0.05, 0.10, 0.01], -1, 0
    )
    return (
        np.stack(
            [a * 0 + 1, a, b, c, a * b, a * c, b * c, a * a, b * b, c * c], axis=-1
        )
        @ EQ8
    )


class Bench:
    """One bench and its simulator. truth: (3,); target: mean angle of its piles [°];
    spent: piles simulated so far."""

    def __init__(self, seed: int, noise: float) -> None:
        self.rng, self.noise, self.spent = np.random.default_rng([seed, 8]), noise, 0
        self.truth = self.rng.uniform(LOW, HIGH)
        self.readings = angle(self.truth) + noise * self.rng.standard_normal(
            BENCH_PILES
        )
        self.target = float(self.readings.mean())

    def simulate(self, x: np.ndarray) -> np.ndarray:
        """Angles (n,) of one pile each at points (n, 3)."""
        self.spent += len(x)
        return angle(x) + self.noise * self.rng.standard_normal(len(x))


def grainlearning(bench: Bench, seed: int) -> Iterator[Answer]:
    """Its iterative Bayesian filter, 20 samples an iteration; interval: its estimate ±
    1.96 of its own sd."""
    from grainlearning.dynamic_systems import DynamicSystem
    from grainlearning.iterative_bayesian_filter import IterativeBayesianFilter

    system = DynamicSystem.from_dict(
        {
            "param_names": list(NAMES),
            "param_min": list(LOW),
            "param_max": list(HIGH),
            "num_samples": 20,
            "obs_data": [[bench.target]],
        }
    )
    sampling = {"max_num_components": 1, "random_state": seed, "n_init": 1}
    loop = IterativeBayesianFilter.from_dict(
        {"Bayes_filter": {"ess_target": 0.3}, "sampling": sampling}
    )
    loop.initialize(system)
    while bench.spent + 20 <= BUDGET:
        system.param_data = loop.param_data_list[-1]
        system.num_samples = len(system.param_data)
        system.set_sim_data(bench.simulate(system.param_data)[:, None, None])
        loop.solve(system)
        x = system.estimated_params[-1]
        sd = abs(x * system.estimated_params_cv[-1])
        yield bench.spent, x, x - 1.96 * sd, x + 1.96 * sd


SCRIPT = f"""# ACCESS PARAMETERS START
import coexist
parameters = coexist.create_parameters({list(NAMES)}, {LOW.tolist()}, {HIGH.tolist()})
# ACCESS PARAMETERS END
error = 0.0
"""


def coexist(bench: Bench, seed: int) -> Iterator[Answer]:
    """Its ACCES, 8 solutions at a time, on the squared distance from the bench's angle;
    interval: what it calls sigma, × 1.96.

    Its piles are run in this process instead of one interpreter each; everything else
    is its own. It recommends the solution with the smallest error so far."""
    from coexist import Access

    found: list[Answer] = []

    class InProcess(Access):
        def evaluate_solutions(self, solutions, epoch):
            error = (bench.simulate(np.asarray(solutions)) - bench.target) ** 2
            return np.column_stack([error, error])

        def finished(self, es):
            scaling = self.setup.scaling
            sd = es.result.stds * scaling
            best = np.asarray(es.result.xbest) * scaling
            found.append((bench.spent, best, best - 1.96 * sd, best + 1.96 * sd))
            return bench.spent + 8 > BUDGET or super().finished(es)

    with tempfile.TemporaryDirectory() as folder:
        script = Path(folder) / "pile.py"
        script.write_text(SCRIPT)
        import os

        here = Path.cwd()
        os.chdir(folder)  # it writes beside itself
        try:
            InProcess(str(script)).learn(
                num_solutions=8, target_sigma=0.01, random_seed=seed, verbose=0
            )
        finally:
            os.chdir(here)
    yield from found


def ours(effort: str) -> Callable[[Bench, int], Iterator[Answer]]:
    """The pile's part of the calibration, without its check: the most probable set, and
    the posterior's intervals."""
    from benchtwin.calibrate.procedure.bench import RigReadings
    from benchtwin.calibrate.procedure.calibration import LEVEL
    from benchtwin.calibrate.procedure.effort import FULL, QUICK
    from benchtwin.calibrate.procedure.pile_stage import PileStage
    from benchtwin.calibrate.procedure.seed_runs import simulate_seeds
    from benchtwin.calibrate.statistics.bounds import interval, open_ends
    from benchtwin.calibrate.statistics.box import Box
    from benchtwin.calibrate.statistics.posterior import on_grid
    from benchtwin.calibrate.statistics.prior import Prior

    def run(bench: Bench, seed: int) -> Iterator[Answer]:
        def simulate(runs) -> pd.DataFrame:
            x = np.array([[r.values[n] for n in NAMES] for r in runs])
            return pd.DataFrame(
                {
                    "status": "done",
                    "reason": "",
                    "rerun": "",
                    "repose_angle_deg": bench.simulate(x),
                }
            )

        stage = PileStage(
            readings=RigReadings(
                rig="pile",
                response="repose_angle_deg",
                values=bench.readings,
                reading_sd=np.zeros(BENCH_PILES),
            ),
            fixed={},
            description={},
            simulate=simulate,
            effort={"quick": QUICK, "full": FULL}[effort],
            seed=seed,
            box=Box(NAMES, LOW, HIGH),
        )
        seen = simulate_seeds(stage, ())
        rng, prior = np.random.default_rng(seed), Prior.uniform(seen.box)
        found = on_grid(list(seen.observables), prior, rng=rng)
        limits = zip(seen.box.low, seen.box.high)
        ends = [
            interval(x, limit, open_ends(x, limit), LEVEL)
            for x, limit in zip(found.draws.to_numpy().T, limits)
        ]
        low, high = np.array(ends).T  # as the procedure states it
        yield bench.spent, np.array([found.mode[n] for n in NAMES]), low, high

    return run


def study(
    name: str, method: Callable[[Bench, int], Iterator[Answer]], seeds: int
) -> pd.DataFrame:
    """One row an answer: method, noise_deg, seed, runs, off (of the angle that the
    answer truly gives), held_… and width_… (of the range) of the intervals."""
    rows = []
    for noise in NOISE_DEG:
        for seed in range(seeds):
            bench = Bench(seed, noise)
            for runs, x, low, high in method(bench, seed):
                row = {"method": name, "noise_deg": noise, "seed": seed, "runs": runs}
                row["off"] = abs(float(angle(x)) / bench.target - 1)
                low, high = np.maximum(low, LOW), np.minimum(high, HIGH)
                for n, t, a, b, whole in zip(NAMES, bench.truth, low, high, HIGH - LOW):
                    row |= {
                        f"held_{n}": int(a <= t <= b),
                        f"width_{n}": max(0.0, b - a) / whole,
                    }
                rows.append(row)
        print(name, noise, flush=True)
    return pd.DataFrame(rows)


def summary(answers: pd.DataFrame) -> pd.DataFrame:
    """One row a method and noise: piles until within 2 % for good (median, 90 %; inf
    where not within BUDGET), share of benches that end there, share of 95 % intervals
    that hold the truth at the end, their median width over the range."""
    rows = []
    for (method, noise), t in answers.groupby(["method", "noise_deg"], sort=False):
        first = t.groupby("seed").apply(_for_good, include_groups=False)
        last = t.sort_values("runs").groupby("seed").tail(1)
        held = last[[f"held_{n}" for n in NAMES]].to_numpy().mean()
        width = float(np.median(last[[f"width_{n}" for n in NAMES]]))
        median, nine = (
            float(np.quantile(first, q, method="higher")) for q in (0.5, 0.9)
        )
        rows.append(
            (
                method,
                noise,
                len(first),
                median,
                nine,
                np.isfinite(first).mean(),
                last["runs"].median(),
                held,
                width,
            )
        )
    columns = [
        "method",
        "noise_deg",
        "benches",
        "median_runs",
        "runs_90",
        "reached",
        "runs_at_end",
        "held_95",
        "width",
    ]
    return pd.DataFrame(rows, columns=columns)


def _for_good(answers: pd.DataFrame) -> float:
    """Piles after which every answer gives the angle within WITHIN."""
    t = answers.sort_values("runs")
    far = np.flatnonzero(t["off"].to_numpy() > WITHIN)
    after = far[-1] + 1 if far.size else 0
    return float(t["runs"].iloc[after]) if after < len(t) else np.inf


def main(which: str, seeds: int) -> None:
    TABLES.mkdir(parents=True, exist_ok=True)
    if which == "ours":
        found = pd.concat(
            [
                study(f"benchtwin, {effort}", ours(effort), seeds)
                for effort in ("quick", "full")
            ]
        )
    else:
        found = study(
            which, {"grainlearning": grainlearning, "coexist": coexist}[which], seeds
        )
    found.to_csv(TABLES / f"{which}.csv", index=False, float_format="%.4g")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "which", nargs="?", choices=["ours", "grainlearning", "coexist"]
    )
    parser.add_argument("seeds", type=int, nargs="?", default=100)
    arguments = parser.parse_args()
    if arguments.which:
        main(arguments.which, arguments.seeds)
    files = [TABLES / f"{name}.csv" for name in ("ours", "grainlearning", "coexist")]
    print(
        summary(pd.concat([pd.read_csv(f) for f in files if f.exists()]))
        .round(3)
        .to_string(index=False)
    )
