"""The centre rises and falls twice a turn: h = ½ (c cos φ + s sin φ), rise √(c² +
s²)."""

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.infer.effect import Effect

NAME, PRIOR_SD_MM = "shape-barrier", 0.1


def rise(e) -> tuple[float, float]:
    """√ of the mean of c² + s² over the runs [mm], corrected for its variance; and its
    sd."""
    mean, covariance = e.table.estimate(e.names, 5.0)
    first = sum(len(e.table.index[n]) for n in e.names[: e.names.index(NAME)]) + 1
    own = np.arange(first, first + len(e.table.index[NAME]) - 1)
    square = mean[own] ** 2 - np.diag(covariance)[own]
    size = float(np.sqrt(max(2 * square.mean(), 0.0)))
    slope = 2 * mean[own] / max(size, 1e-6) / len(own)
    return size, float(np.sqrt(slope @ covariance[np.ix_(own, own)] @ slope))


def quadratures(count: int) -> dict[str, Effect]:
    """c ("cos") and s ("sin") [mm] of `count` recordings."""
    found = [
        Effect(
            name=f"{NAME}.{kind}.{r}",
            sector="run-out",
            unit="mm",
            meaning=tr("{} of the rise", kind),
            prior_sd=PRIOR_SD_MM,
            low=-5.0,
            high=5.0,
            source=f"see {NAME}",
            group=NAME,
        )
        for r in range(count)
        for kind in ("cos", "sin")
    ]
    return {e.name: e for e in found}


def ripple(at: dict[str, float], r: int) -> tuple[float, float]:
    """c and s [m] of recording r."""
    return at.get(f"{NAME}.cos.{r}", 0.0) / 1000, at.get(f"{NAME}.sin.{r}", 0.0) / 1000


EFFECTS = (
    Effect(
        name=NAME,
        sector="run-out",
        unit="mm",
        meaning="rise",
        prior_sd=PRIOR_SD_MM,
        low=0.0,
        high=5.0,
        summary=rise,
        source=(
            "potential energy of an ellipse that rolls: its centre rises by the"
            " difference of its half axes"
        ),
        wording=("the seed's shape makes it climb as it rolls", "mm"),
        not_simulated="shape is the twin's own already",
        separating="the seed's turning in the picture (angle_deg), and its sizes",
    ),
)
