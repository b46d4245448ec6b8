"""Quantiles and tails of distributions, to the last bit those of scipy.stats, which
takes a second to load and calls the same functions of scipy.special. A number gives a
number, an array an array."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import special


class Student:
    """Student's t."""

    @staticmethod
    def ppf(p: ArrayLike, df: ArrayLike) -> Any:
        """Quantile at p with df > 0 degrees of freedom, which may be endless."""
        return special.stdtrit(df, p)


class Normal:
    """The standard normal distribution."""

    @staticmethod
    def ppf(p: ArrayLike) -> Any:
        """Quantile at p."""
        return special.ndtri(p)

    @staticmethod
    def cdf(x: ArrayLike) -> Any:
        """Probability below x."""
        return special.ndtr(x)


class ChiSquare:
    """The χ² distribution."""

    @staticmethod
    def ppf(p: ArrayLike, df: ArrayLike) -> Any:
        """Quantile at p with df degrees of freedom."""
        return 2.0 * special.gammaincinv(np.asarray(df, float) / 2.0, p)

    @staticmethod
    def sf(x: ArrayLike, df: ArrayLike) -> Any:
        """Probability above x."""
        return special.chdtrc(df, x)


class FisherF:
    """Fisher's F distribution."""

    @staticmethod
    def sf(x: ArrayLike, dfn: ArrayLike, dfd: ArrayLike) -> Any:
        """Probability above x with so many degrees of freedom above and below."""
        return special.fdtrc(dfn, dfd, x)


t, norm, chi2, f = Student, Normal, ChiSquare, FisherF
