"""Polynomial terms in coded factors: a term is a tuple of exponents, (1, 0, 1) being
A·C. Named as Design-Expert names them."""

from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

LETTERS = "ABCDEFGHJKLMNOP"  # Design-Expert leaves I out: it stands for the intercept
Term = tuple[int, ...]


def full(factors: int) -> tuple[Term, ...]:
    """All terms of a quadratic: intercept, A, B …, then AB, AC …, then A², B² and so
    on.

    >>> [name(t) for t in full(2)]
    ['intercept', 'A', 'B', 'AB', 'A²', 'B²']
    """
    unit = np.eye(factors, dtype=int)
    pairs = (unit[i] + unit[j] for i, j in combinations(range(factors), 2))
    terms = [np.zeros(factors, dtype=int), *unit, *pairs, *(2 * unit)]
    return tuple(tuple(int(e) for e in t) for t in terms)


def name(term: Term) -> str:
    """(0, 1, 1) → "BC", (2, 0, 0) → "A²", (0, 0, 0) → "intercept"."""
    power = {1: "", 2: "²", 3: "³"}
    return (
        "".join(LETTERS[i] + power.get(e, f"^{e}") for i, e in enumerate(term) if e)
        or "intercept"
    )


def matrix(coded: ArrayLike, terms: tuple[Term, ...]) -> np.ndarray:
    """Model matrix (n, p) of coded points (n, k)."""
    coded, exponents = np.atleast_2d(np.asarray(coded, dtype=float)), np.array(terms)
    powers = [np.ones_like(coded)]
    while len(powers) <= exponents.max():
        powers.append(powers[-1] * coded)
    out = np.ones((len(coded), len(terms)))
    for j, exponent in enumerate(exponents.T):
        out *= np.stack([p[:, j] for p in powers], axis=1)[:, exponent]
    return out
