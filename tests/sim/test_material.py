"""Materials and contacts: closed forms of Chung & Ooi, the paper's values, a softened
one's step, errors by name."""

import pytest

from benchtwin.sim.material import (
    Q235,
    SOYBEAN,
    SOYBEAN_Q235,
    SOYBEAN_SOYBEAN,
    Contact,
    Material,
    effective_moduli,
)


def solid(young, poisson, density):
    return Material("solid", density, young / (2 * (1 + poisson)), poisson)


def test_the_papers_values():
    assert (SOYBEAN.density_kg_m3, SOYBEAN.shear_modulus_pa, SOYBEAN.poisson_ratio) == (
        1250.0,
        3.23e8,
        0.4,
    )
    assert (Q235.density_kg_m3, Q235.shear_modulus_pa, Q235.poisson_ratio) == (
        7850.0,
        8.2e10,
        0.28,
    )
    assert (
        SOYBEAN_Q235.restitution,
        SOYBEAN_Q235.static_friction,
        SOYBEAN_Q235.rolling_friction,
    ) == (0.54, 0.34, 0.01)
    assert (
        SOYBEAN_SOYBEAN.restitution,
        SOYBEAN_SOYBEAN.static_friction,
        SOYBEAN_SOYBEAN.rolling_friction,
    ) == (0.65, 0.55, 0.04)
    assert all(x.source for x in (SOYBEAN, Q235, SOYBEAN_Q235, SOYBEAN_SOYBEAN))
    assert SOYBEAN.young_modulus_pa == pytest.approx(9.044e8)


def test_effective_moduli_of_equal_materials_and_against_steel():
    young, shear = effective_moduli(SOYBEAN, SOYBEAN)
    assert young == pytest.approx(SOYBEAN.young_modulus_pa / (2 * (1 - 0.4**2)))
    assert shear == pytest.approx(SOYBEAN.shear_modulus_pa / (2 * (2 - 0.4)))
    assert effective_moduli(SOYBEAN, Q235) == effective_moduli(Q235, SOYBEAN)
    assert effective_moduli(SOYBEAN, Q235)[0] == pytest.approx(
        SOYBEAN.young_modulus_pa / (1 - 0.4**2), rel=0.005
    )


def test_softening_a_hundredfold_lengthens_the_step_as_the_power_says():
    soft = SOYBEAN.softened(SOYBEAN.shear_modulus_pa / 100)
    longer = soft.rayleigh_step_s(1.6e-3) / SOYBEAN.rayleigh_step_s(1.6e-3)
    assert longer == pytest.approx(10.0)
    assert "softened from 3.23e+08 Pa" in soft.source


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (
            lambda: Material("x", -1.0, 1e9, 0.3),
            "material 'x': density_kg_m3 = -1 kg/m3: must be 0.01 to 30000",
        ),
        (lambda: Material("x", 1e3, float("nan"), 0.3), "shear_modulus_pa = nan"),
        (
            lambda: Material("x", 1e3, 1e9, 0.6),
            "poisson_ratio = 0.6 -: must be 0 to 0.5",
        ),
        (lambda: Material("", 1e3, 1e9, 0.3), "needs one"),
        (lambda: SOYBEAN.softened(1e9), "must be below the real"),
        (lambda: SOYBEAN.rayleigh_step_s(-1.0), "radius_m = -1"),
        (lambda: Contact(("a", "b"), 1.2, 0.3, 0.1), "contact a–b: restitution = 1.2"),
        (lambda: Contact(("a", "b"), 0.5, -0.3, 0.1), "static_friction = -0.3"),
        (lambda: Contact(("a", "b"), 0.5, 0.3, float("inf")), "rolling_friction = inf"),
        (
            lambda: Contact(("a", "b"), 0.5, 0.3, 0.1, "mine"),
            "rolling_convention = 'mine'",
        ),
        (lambda: Contact(("a",), 0.5, 0.3, 0.1), "two materials' names"),
        (
            lambda: SOYBEAN_Q235.rolling_friction_in("b", on_wall=True),
            "convention = 'b'",
        ),
    ],
)
def test_errors_name_the_parameter_and_its_range(make, says):
    with pytest.raises(ValueError, match=says):
        make()
