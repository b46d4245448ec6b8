"""The same numbers as scipy.stats gives, without loading it."""

import subprocess
import sys

import numpy as np
import pytest
from scipy import stats

from benchtwin.bench import distributions as ours

P = np.array([1e-9, 0.001, 0.1, 0.5, 0.9, 0.975, 0.9999, 1.0])
X = np.array([0.0, 1e-6, 0.1, 1.0, 5.0, 50.0, 500.0, np.inf])


@pytest.mark.parametrize("df", [1, 2, 4.5, 9, 100, 1e6, np.inf])
def test_student(df):
    assert np.array_equal(ours.t.ppf(P, df), stats.t.ppf(P, df))


@pytest.mark.parametrize("df", [1, 2, 7.5, 100])
def test_chi_square_and_f(df):
    assert np.array_equal(ours.chi2.ppf(P, df), stats.chi2.ppf(P, df))
    assert np.array_equal(ours.chi2.sf(X, df), stats.chi2.sf(X, df))
    assert np.array_equal(ours.f.sf(X, df, df + 3), stats.f.sf(X, df, df + 3))


def test_normal():
    assert np.array_equal(ours.norm.ppf(P), stats.norm.ppf(P))
    assert np.array_equal(ours.norm.cdf(X), stats.norm.cdf(X))


@pytest.mark.parametrize("given", [(np.nan, 3), (0.5, np.nan)])
def test_what_is_unknown_stays_unknown(given):
    assert np.isnan(ours.t.ppf(*given)) and np.isnan(ours.chi2.ppf(*given))


def test_measuring_a_photo_loads_neither_statistics_nor_optimisers():
    code = (
        "import sys, benchtwin.measuring\n"
        "print(*(m for m in ('scipy.stats', 'scipy.optimize', 'openpyxl', 'numba')"
        " if m in sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.split() == [], done.stdout + done.stderr
