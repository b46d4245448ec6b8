"""Is Laplace's evidence good enough to tell explanations apart? Importance sampling of
the same integral beside it.

    .venv/bin/python benchmarks/laplace.py

It takes two to five minutes and writes tables/laplace.csv.

Of each sample bench and rig: the explanations that hold weight, each fitted in full.
Laplace's ln Z of their globals (priors at their usual width, each recording's own
numbers eliminated) beside DRAWS points of a Student's t about the fit, at every one of
which the recordings are predicted anew. What counts is the difference between two
explanations: `off` is Laplace's error in ln Z less that of nothing missing."""

import argparse
import time
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pandas as pd
from scipy import stats
from scipy.special import logsumexp

from benchtwin.diagnose import bench
from benchtwin.infer import inference
from benchtwin.infer.problem import Fit, ln_evidence

SAMPLES = Path(__file__).parents[1] / "samples"
BENCHES = {
    "concealed-roll": "roll",
    "soybean-bench": "roll",
    "damp-slides": "slide",
    "concealed-drop": "drop",
}
DRAWS, FREEDOM, WIDER = 400, 6, 1.2
HOLDS = 0.005  # weight from which an explanation is looked at


def sampled(fit: Fit, rng: np.random.Generator) -> tuple[float, float]:
    """ln Z by importance sampling, and the effective share of the draws."""
    kept = np.flatnonzero(fit.prior_sd > 0)
    sd = fit.prior_sd[kept]
    proposal = stats.multivariate_t(
        fit.values[kept],
        WIDER**2 * fit.covariance[np.ix_(kept, kept)],
        df=FREEDOM,
        allow_singular=True,
    )
    points = np.atleast_2d(proposal.rvs(DRAWS, random_state=rng))
    weight = np.empty(DRAWS)
    shift = fit.problem.reduce(fit.starts, fit.values)[1]
    for k, point in enumerate(points):
        values = fit.values.copy()
        values[kept] = point
        reduced = fit.problem.reduce(fit.starts + shift(values - fit.values), values)[0]
        left = sum(
            float(((r.b - r.a @ values) ** 2).sum()) + 2 * r.half_ln_det
            for r in reduced
        )
        weight[k] = (
            -0.5 * left + stats.norm.logpdf(point, 0, sd).sum() - proposal.logpdf(point)
        )
    weight = np.where(np.isfinite(weight), weight, -np.inf)
    total = logsumexp(weight)
    return float(total - np.log(DRAWS)), float(
        np.exp(2 * total - logsumexp(2 * weight)) / DRAWS
    )


def posterior_of(folder: Path, rig: str):
    """The posterior over explanations of one rig of a bench."""
    kept = []
    explain = inference.explain

    def keep(alternatives, windows, bases):
        kept.append(explain(alternatives, windows, bases))
        return kept[-1]

    with patch.object(inference, "explain", keep):
        bench.diagnose_bench(folder, only=(rig,))
    return kept[-1]


def _free(fit: Fit, name: str) -> bool:
    """Whether a listed effect was free in this fit, and not only what a good bench
    leaves open of the same."""
    problem = fit.problem
    return all(
        np.isclose(fit.prior_sd[problem.names.index(c)], problem.effects[c].prior_sd)
        for c in problem.columns_of(name)
    )


def main() -> None:
    rows = []
    for name, rig in BENCHES.items():
        posterior, rng = posterior_of(SAMPLES / name, rig), np.random.default_rng(1)
        own = [
            e
            for e in posterior.explanations
            if e.names == e.listed and (e.probability > HOLDS or not e.names)
        ]
        fitted = [e for e in own if all(_free(e.fit, n) for n in e.names)]
        for e in fitted:
            began = time.perf_counter()
            found, share = sampled(e.fit, rng)
            rows.append(
                {
                    "bench": name,
                    "rig": rig,
                    "explanation": " + ".join(e.names) or "nothing missing",
                    "alternative": e.alternative,
                    "probability": round(e.probability, 4),
                    "ln_z_laplace": ln_evidence(e.fit),
                    "ln_z_sampled": found,
                    "effective_share": round(share, 2),
                    "seconds": round(time.perf_counter() - began, 1),
                }
            )
            print(rows[-1], flush=True)
    table = pd.DataFrame(rows)
    error = table.ln_z_laplace - table.ln_z_sampled
    nothing = {
        (r.bench, r.alternative): e
        for r, e in zip(table.itertuples(), error, strict=True)
        if r.explanation == "nothing missing"
    }
    table["off"] = [
        e - nothing.get((r.bench, r.alternative), 0.0)
        for r, e in zip(table.itertuples(), error, strict=True)
    ]
    table.round(3).to_csv(Path(__file__).parent / "tables" / "laplace.csv", index=False)
    print(table.round(3).to_string())


if __name__ == "__main__":
    argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    ).parse_args()
    main()
