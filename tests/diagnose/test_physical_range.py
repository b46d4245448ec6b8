import numpy as np
import pytest
from scipy.stats import multivariate_normal, norm

from benchtwin.infer.physical_range import ln_within

INFINITE = np.full(2, np.inf)


def test_one_quantity_and_independent_ones_are_exact():
    mean, sd = np.array([0.3, -1.2]), np.array([0.5, 2.0])
    low, high = np.array([0.0, -np.inf]), np.array([1.0, 0.4])
    p = np.exp(ln_within(mean, np.diag(sd**2), low, high))
    each = norm.cdf((high - mean) / sd) - norm.cdf((low - mean) / sd)
    assert p == pytest.approx(each.prod(), rel=1e-9)


def test_far_from_the_range_the_logarithm_stays_finite():
    ln = ln_within(np.array([-40.0]), np.eye(1), np.zeros(1), np.full(1, np.inf))
    assert ln == pytest.approx(norm.logsf(40.0), rel=1e-9)


@pytest.mark.parametrize("correlation", [-0.95, -0.6, 0.3, 0.95])
def test_two_alike_quantities_of_one_sign(correlation):
    """Against the bivariate normal's own integral, within what Mendell & Elston's
    moments leave."""
    rng = np.random.default_rng(3)
    covariance = np.array([[1, correlation], [correlation, 1]])
    for mean in rng.normal(scale=2, size=(40, 2)):
        p = np.exp(ln_within(mean, covariance, np.zeros(2), INFINITE))
        exact = multivariate_normal(-mean, covariance).cdf(np.zeros(2))
        assert p == pytest.approx(exact, abs=0.03)


def test_two_of_one_sign_of_which_the_sum_is_told():
    """Each may be positive; both cannot, where their sum is 14 sds below 0, and P is
    below that of the sum."""
    far = np.array([[100.0, -99.99], [-99.99, 100.0]])
    joint = ln_within(np.array([-1.0, -1.0]), far, np.zeros(2), INFINITE)
    assert joint < norm.logsf(2 / np.sqrt(0.02))
