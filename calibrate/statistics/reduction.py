"""A surface reduced to its significant terms, lower-order relatives of kept terms
staying in (hierarchy)."""

from dataclasses import dataclass

import pandas as pd

from benchtwin.calibrate.statistics import terms as polynomial
from benchtwin.calibrate.statistics.assessment import coefficients
from benchtwin.calibrate.statistics.surface import Surface, refit


@dataclass(frozen=True, eq=False)
class Reduction:
    """A surface with its significant terms only, and the terms left out in order: steps
    has term, p."""

    surface: Surface
    steps: pd.DataFrame


def reduce(surface: Surface, alpha: float = 0.05) -> Reduction:
    """Backward elimination to terms with p < alpha, keeping a term as long as a
    higher-order relative of it stays (hierarchy)."""
    steps = []
    while len(surface.terms) > 1:
        p = coefficients(surface)["p"].to_numpy()
        free = [
            i
            for i, t in enumerate(surface.terms)
            if any(t) and not any(polynomial.inside(t, o) for o in surface.terms)
        ]
        worst = max(free, key=lambda i: p[i])
        if p[worst] < alpha:
            break
        steps.append((polynomial.name(surface.terms[worst]), float(p[worst])))
        kept = surface.terms[:worst] + surface.terms[worst + 1 :]
        surface = refit(surface, kept)
    return Reduction(surface, pd.DataFrame(steps, columns=["term", "p"]))
