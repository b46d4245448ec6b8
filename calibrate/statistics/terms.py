"""Polynomial terms in coded factors: a term is a tuple of exponents, (1, 0, 1) being
A·C. Named as Design-Expert names them."""

from itertools import combinations, product
from math import comb

import numpy as np
from numpy.typing import ArrayLike

from benchtwin.calibrate.statistics.box import Box

LETTERS = "ABCDEFGHJKLMNOP"  # Design-Expert leaves I out: it stands for the intercept
Term = tuple[int, ...]


def full(factors: int, order: str = "quadratic") -> tuple[Term, ...]:
    """All terms of a model: intercept, A, B …, then AB, AC …, then A², B² and so on.

    order: "linear", "interactions" or "quadratic". Raises ValueError for another.

    >>> [name(t) for t in full(2)]
    ['intercept', 'A', 'B', 'AB', 'A²', 'B²']
    """
    if order not in ("linear", "interactions", "quadratic"):
        raise ValueError(f"order: linear, interactions or quadratic, not {order!r}")
    unit = np.eye(factors, dtype=int)
    terms = [np.zeros(factors, dtype=int), *unit]
    if order != "linear":
        terms += [unit[i] + unit[j] for i, j in combinations(range(factors), 2)]
    if order == "quadratic":
        terms += list(2 * unit)
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
    coded = np.atleast_2d(np.asarray(coded, dtype=float))
    out = np.ones((coded.shape[0], len(terms)))
    for column, term in enumerate(terms):
        for factor, exponent in enumerate(term):
            for _ in range(exponent):
                out[:, column] *= coded[:, factor]
    return out


def inside(term: Term, other: Term) -> bool:
    """Whether `other` is a higher-order relative of `term` (A of AB and of A²), so that
    hierarchy keeps `term` with it."""
    return term != other and all(e <= f for e, f in zip(term, other))


def gradient(
    coded: ArrayLike, terms: tuple[Term, ...], coefficients: np.ndarray
) -> np.ndarray:
    """∂f/∂z of f = Σ β_t z^t at coded points (n, k): (n, k)."""
    coded = np.atleast_2d(np.asarray(coded, dtype=float))
    out = np.zeros_like(coded)
    for factor in range(coded.shape[1]):
        lower = tuple(
            (*t[:factor], max(t[factor] - 1, 0), *t[factor + 1 :]) for t in terms
        )
        out[:, factor] = matrix(coded, lower) @ (
            np.array([t[factor] for t in terms]) * coefficients
        )
    return out


def natural_coefficients(
    box: Box, terms: tuple[Term, ...], coefficients: np.ndarray
) -> dict[Term, float]:
    """Coefficients of the same polynomial in natural units: {term: coefficient},
    lower-order terms appearing where needed.

    z^e = ((x − c)/h)^e = h^−e Σ_j C(e, j) x^j (−c)^(e−j), multiplied out over the
    factors."""
    centre, half = box.centre, box.half_width
    out: dict[Term, float] = {}
    for term, coefficient in zip(terms, coefficients):
        for powers in product(*(range(e + 1) for e in term)):
            part = coefficient
            for j, e, c, h in zip(powers, term, centre, half):
                part *= comb(e, j) * (-c) ** (e - j) / h**e
            out[powers] = out.get(powers, 0.0) + float(part)
    return out
