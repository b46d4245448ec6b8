"""Which directions of the parameters the bench resolves."""

import numpy as np
import pandas as pd

from benchtwin.calibrate.statistics.posterior import Posterior


def directions(posterior: Posterior, resolved_below: float = 0.5) -> pd.DataFrame:
    """Principal directions of the posterior in units of the prior's sd, best resolved
    first.

    Columns direction (1 …), one a factor (components of the unit vector), sd_ratio
    (posterior over prior sd along it), resolved (sd_ratio < resolved_below), statement.
    """
    names = list(posterior.draws.columns)
    scaled = posterior.draws.to_numpy() / posterior.prior.sd
    spread, vectors = np.linalg.eigh(np.atleast_2d(np.cov(scaled, rowvar=False)))
    rows = []
    for i, (variance, vector) in enumerate(zip(spread, vectors.T)):
        vector = vector * np.sign(vector[np.argmax(abs(vector))])
        ratio = float(np.sqrt(max(variance, 0)))
        mix = " ".join(
            f"{'−' if c < 0 else '+'} {abs(c):.2f} {n}"
            for c, n in zip(vector, names)
            if abs(c) >= 0.1
        )
        resolved = "resolved" if ratio < resolved_below else "not resolved"
        said = (
            f"{resolved}: {mix.removeprefix('+ ')}; the bench narrows it by"
            f" {max(0, 100 * (1 - ratio)):.0f} %"
        )
        rows.append([i + 1, *vector, ratio, ratio < resolved_below, said])
    return pd.DataFrame(
        rows, columns=["direction", *names, "sd_ratio", "resolved", "statement"]
    )
