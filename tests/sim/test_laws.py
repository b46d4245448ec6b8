"""Force laws: each keeps the contract, and gives what its closed form says."""

import ast
import importlib
import inspect
import math
import re

import numpy as np
import pytest
from law_samples import FIXED, arity, functions, samples
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from benchtwin.sim.laws import KINDS, LAWS, hertz_mindlin

G = 9.81
NAMES = {name: function for name, function, _ in functions()}


@pytest.fixture(params=sorted(LAWS))
def law(request):
    return LAWS[request.param]


# ---- the contract ----


def test_registry_and_signature(law):
    assert (
        LAWS[law.name] is law
        and law.kind in KINDS
        and law.function.__name__ == law.name
    )
    names = list(inspect.signature(law.function).parameters)
    own = [p.name for p in (*law.memory, *law.parameters)]
    assert names[len(FIXED[law.kind]) :] == own
    if law.reach is not None:
        assert list(inspect.signature(law.reach).parameters) == [
            "radius",
            "modulus",
            *[p.name for p in law.parameters],
        ]
    assert all(p.low < p.high and p.unit and p.meaning for p in law.parameters)


def test_docstring_states_formula_units_range_source_and_example(law):
    text = " ".join(inspect.getdoc(law.function).split())
    assert "=" in text and re.search(r"\[.*\]", text), "formula and units"
    assert re.search(r"Sources?: ", text) and law.source and ">>>" in text
    limits = (
        "[Vv]alid|not for|for the speeds|Loss independent|Static|Memoryless|belongs"
        " to|must fit|rate jumps|Take it"
    )
    assert re.search(limits, text), "where it holds"


def test_only_scalars_and_math():
    """No law knows of arrays, devices or the engine: it imports `math` and the record's
    class, and calls math functions only."""
    allowed = {"abs", "min", "max", "range"}
    for name, function, _ in functions():
        module = ast.parse(
            inspect.getsource(importlib.import_module(function.__module__))
        )
        for node in ast.walk(module):
            if isinstance(node, ast.Import):
                assert [a.name for a in node.names] == ["math"], name
            if isinstance(node, ast.ImportFrom):
                assert node.module == "benchtwin.sim.laws.law", name
        body = ast.parse(inspect.getsource(function)).body[0]
        assert (
            not body.decorator_list
            and not body.args.defaults
            and not body.args.kwonlyargs
        ), name
        body.body = body.body[1:] if ast.get_docstring(body) else body.body
        for node in ast.walk(body):
            refused = (
                ast.Try
                | ast.Raise
                | ast.Subscript
                | ast.List
                | ast.Dict
                | ast.JoinedStr
                | ast.Lambda
            )
            assert not isinstance(node, refused), name
            assert not (
                isinstance(node, ast.Constant) and isinstance(node.value, str)
            ), name
            if isinstance(node, ast.Call):
                called = node.func
                known = isinstance(called, ast.Name) and called.id in allowed
                of_math = (
                    isinstance(called, ast.Attribute)
                    and getattr(called.value, "id", "") == "math"
                )
                assert known or of_math, f"{name} calls {ast.unparse(called)}"


def test_finite_over_the_whole_range():
    rng = np.random.default_rng(11)
    for name, function, ranges in functions():
        assert arity(function) == len(ranges), name
        for row in samples(ranges, 300, rng):
            result = function(*map(float, row))
            assert np.all(np.isfinite(result)), f"{name}{tuple(row)} = {result}"


def test_restitution_and_friction_stay_in_their_ranges():
    rng = np.random.default_rng(12)
    for name, function, ranges in functions():
        if name in LAWS and LAWS[name].kind in ("restitution", "friction"):
            values = [function(*map(float, row)) for row in samples(ranges, 300, rng)]
            top = 1.0 if LAWS[name].kind == "restitution" else math.inf
            assert min(values) >= 0.0 and max(values) <= top, name


def test_a_law_switched_to_nothing_changes_nothing():
    one = (0.7, 0.5)
    assert LAWS["restitution_film"].function(*one, 0.0) == 0.5
    assert LAWS["restitution_viscoelastic"].function(*one, 0.0, 2.0) == 0.5
    assert LAWS["restitution_plastic"].function(*one, 1.0, 0.0) == 0.5
    assert LAWS["friction_kinetic"].function(*one, 0.0, 1e-3) == 0.5
    assert LAWS["friction_stribeck"].function(*one, 0.0, 0.1) == 0.5
    assert LAWS["friction_viscous"].function(*one, 0.0) == 0.5
    assert LAWS["restitution_power"].function(*one, 0.0, 1.0, 3.0) == 0.5
    assert LAWS["friction_power"].function(*one, 0.0, 1.0, 3.0) == 0.5
    assert LAWS["rolling_power"].function(2.0, 50.0, 3e-3, 0.01, 0.0, 1.0, 3.0) == 0.0
    assert not any(LAWS["push_power"].function(1, 0, 2, 0, 0, 0, 0.007, 0.0, 1.0, 3.0))
    assert LAWS["cohesion_dmt"].function(1e-5, 0.0, 3e-3, 1e8, 0.0) == 0.0
    stuck = LAWS["spring_jkr"].function(1e-5, 0.0, 3e-3, 1e8, 0.5, 0.0)
    stiffness = hertz_mindlin.normal_stiffness(1e-5, 3e-3, 1e8)
    force = hertz_mindlin.elastic_force(stiffness, 1e-5)
    damping = hertz_mindlin.damping_factor(0.5)
    assert stuck == pytest.approx((force, force, stiffness, damping), rel=1e-12)
    assert LAWS["cohesion_linear"].function(1e-5, 0.0, 3e-3, 1e8, 0.0) == 0.0


# ---- flight ----

AIR = (1.204, 1.825e-5, 1.0)
STILL = (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("re", "cd"),
    # Measured spheres: the standard drag curve, Clift, Grace & Weber (1978), chapter 5.
    # Brown & Lawler's fit keeps within 6 %.
    [
        (0.1, 243.7),
        (1.0, 27.15),
        (10.0, 4.29),
        (100.0, 1.09),
        (1000.0, 0.471),
        (10_000.0, 0.405),
    ],
)
def test_drag_follows_the_standard_curve(re, cd):
    density, viscosity, _ = AIR
    d = 0.007
    v = re * viscosity / density / d
    force = -drag_z(v, d)
    assert force / (math.pi / 8 * density * d**2 * v**2) == pytest.approx(cd, rel=0.06)


def drag_z(v, d, factor=1.0, wind=0.0):
    return LAWS["drag"].function(
        0.0, 0.0, v, 0.0, 0.0, 0.0, d, *AIR[:2], factor, 0.0, 0.0, wind
    )[2]


def test_drag_tends_to_stokes_and_scales_with_the_shape_factor():
    assert drag_z(1e-6, 1e-5) == pytest.approx(
        -3 * math.pi * AIR[1] * 1e-5 * 1e-6, rel=1e-3
    )
    assert drag_z(0.0, 0.007) == 0.0
    assert drag_z(2.0, 0.007, factor=1.15) == pytest.approx(1.15 * drag_z(2.0, 0.007))


def test_terminal_velocity_of_a_soybean():
    d, m = 7.1e-3, 2.27e-4
    fall = solve_ivp(
        lambda t, y: [y[1], -G + drag_z(y[1], d) / m],
        (0, 12),
        [0.0, 0.0],
        rtol=1e-9,
        atol=1e-9,
    )
    v = -fall.y[1, -1]
    assert drag_z(-v, d) == pytest.approx(m * G, rel=1e-5)  # weight and drag balance
    cd = 2 * m * G / (AIR[0] * math.pi / 4 * d**2 * v**2)
    assert v == pytest.approx(
        math.sqrt(4 / 3 * G * d / cd * m / (math.pi / 6 * d**3) / AIR[0]), rel=1e-9
    )
    assert 13.0 < v < 16.0  # seeds of this size in a wind tunnel: about 13 to 15 m/s


def test_draught_carries_a_seed_along_until_it_moves_with_the_air():
    law = LAWS["drag"].function
    assert law(0.3, 0.0, 0.0, 0, 0, 0, 0.007, *AIR, 0.3, 0.0, 0.0) == (0.0,) * 6
    force = law(0.0, 0.0, 0.0, 0, 0, 0, 0.007, *AIR, 0.3, 0.0, 0.0)
    assert (
        force[0]
        == pytest.approx(-law(-0.3, 0, 0, 0, 0, 0, 0.007, *AIR, *STILL)[0] * -1)
        and force[0] > 0
    )


def test_magnus_is_across_speed_and_spin_and_has_rubinow_and_kellers_size():
    v, w, d = np.array([1.0, -2.0, 0.5]), np.array([30.0, 10.0, -50.0]), 0.007
    force = np.array(LAWS["magnus"].function(*v, *w, d, 1.204, 2.0)[:3])
    assert force == pytest.approx(math.pi * 1.204 * (d / 2) ** 3 * np.cross(w, v))
    # As the diagnosis reports it: a = C (ρ A r / 2m) ω × v.
    a = np.array(LAWS["magnus"].function(*v, *w, d, 1.204, 0.7)[:3])
    assert a == pytest.approx(
        0.7 * 1.204 * (math.pi * d**2 / 4) * (d / 2) / 2 * np.cross(w, v)
    )


# ---- impact ----


def bounce_viscoelastic(beta, v):
    """Integrate m δ'' = −ρ (δ^1.5 + (3/2) A √δ δ') in the units of Schwager & Pöschel
    until the force vanishes."""
    # x = (ρ/m)^0.4 v^-0.8 δ, τ = (ρ/m)^0.4 v^0.2 t:  x'' = −x^1.5 − β v^0.2 √x x',  β =
    # (3/2) A (ρ/m)^0.4.
    b = beta * v**0.2

    def force(_, y):
        x = max(y[0], 0.0)
        return [y[1], -(x**1.5) - b * math.sqrt(x) * y[1]]

    def free(_, y):
        return y[0] + b * y[1] if y[1] < 0 else 1.0  # −x'' / √x

    free.terminal, free.direction = True, -1
    # The first instant by hand: √x is not smooth at 0.
    start = 1e-10
    return -solve_ivp(
        force, (0, 50), [start, 1.0], events=free, rtol=1e-10, atol=1e-13
    ).y[1, -1]


@pytest.mark.parametrize("k", [0.2, 0.4, 0.6, 0.8, 1.0])
@pytest.mark.parametrize("v", [0.1, 2.5])
def test_viscoelastic_restitution_is_the_solution_of_the_equation_of_motion(k, v):
    law = LAWS["restitution_viscoelastic"].function
    assert law(v, 1.0, k, 0.0) == pytest.approx(
        bounce_viscoelastic(k**2, v), abs=0.004 if k < 1 else 0.006
    )


def test_viscoelastic_asymptote_and_anchor():
    law = LAWS["restitution_viscoelastic"].function
    speeds = np.array([1e-10, 1e-8, 1e-6])
    loss = 1 - np.array([law(v, 1.0, 0.3, 0.0) for v in speeds])
    assert np.diff(np.log(loss)) / np.diff(np.log(speeds)) == pytest.approx(
        0.2, abs=0.003
    )
    assert law(2.466, 0.54, 0.9, 2.466) == pytest.approx(0.54) and law(
        0.5, 0.54, 0.9, 2.466
    ) > law(5.0, 0.54, 0.9, 2.466)
    k = brentq(lambda k: law(2.466, 1.0, k, 0.0) - 0.54, 0.0, 5.0)
    assert law(0.7, 1.0, k, 0.0) == pytest.approx(
        law(0.7, 0.54, k, 2.466)
    )  # anchored or not: one curve


def test_plastic_restitution_joins_at_yield_and_falls_as_the_fourth_root():
    law = LAWS["restitution_plastic"].function
    assert law(0.1, 0.8, 0.1, 0.0) == pytest.approx(0.8, abs=1e-12)
    assert law(0.1 * (1 + 1e-9), 0.8, 0.1, 0.0) == pytest.approx(0.8, abs=1e-8)
    far = [law(v, 1.0, 0.1, 0.0) for v in (1e3, 1e4)]
    assert far[1] / far[0] == pytest.approx(10**-0.25, rel=1e-4)
    assert far[1] == pytest.approx(1.185 * (0.1 / 1e4) ** 0.25, rel=1e-3)
    assert law(2.466, 0.54, 0.05, 2.466) == pytest.approx(0.54)


def test_film_restitution_takes_one_energy_from_every_impact_and_sticks_below_it():
    law = LAWS["restitution_film"].function
    for v in (0.4, 1.0, 2.5):
        assert (0.6 * v) ** 2 - (law(v, 0.6, 0.12) * v) ** 2 == pytest.approx(0.12**2)
    assert law(0.12 / 0.6 * 0.999, 0.6, 0.12) < 0.03 and law(
        0.1, 0.6, 0.12
    ) == pytest.approx(1e-3)


def hertz(overlap, radius, modulus):
    return 4 / 3 * modulus * math.sqrt(radius) * max(overlap, 0.0) ** 1.5


def leave_through(law, numbers, speed, mass, radius=3e-3, modulus=1e8):
    """Speed after an elastic impact at `speed` under a law along the normal that acts,
    once touched, as far as it reaches; 0 if held."""
    reach = law.reach(radius, modulus, *numbers)
    names = [p.name for p in law.parameters]
    chosen = law.use(**dict(zip(names, numbers, strict=True)))

    def motion(_, y):
        (force, *_), _ = chosen.along_normal(y[0], -y[1], (radius, modulus, 1.0))
        beside = hertz(y[0], radius, modulus) if law.kind == "normal" else 0.0
        return [y[1], -(beside + force) / mass]

    def gone(_, y):
        return y[0] + reach * (1 - 1e-9)

    gone.terminal, gone.direction = True, -1
    time = (
        40 * 2.94 * (mass**2 / (radius * modulus**2 * max(speed, 1e-3))) ** 0.2
        + 4 * reach / speed
    )
    run = solve_ivp(
        motion,
        (0, time),
        [1e-15, speed],
        events=gone,
        rtol=1e-9,
        atol=1e-14,
        max_step=time / 2000,
    )
    return -run.y[1, -1] if len(run.t_events[0]) else 0.0


def test_film_adhesion_costs_pull_times_rupture_and_holds_slow_seeds():
    law, mass, pull, rupture = LAWS["film_adhesion"], 2.3e-4, 2e-3, 5e-5
    film_speed = math.sqrt(2 * pull * rupture / mass)
    assert leave_through(law, (pull, rupture), 0.1, mass) == pytest.approx(
        math.sqrt(0.1**2 - film_speed**2), rel=1e-3
    )
    assert leave_through(law, (pull, rupture), 0.9 * film_speed, mass) == 0.0
    assert law.reach(3e-3, 1e8, pull, rupture) == rupture


def test_a_liquid_bridge_pulls_as_its_closed_form_and_takes_its_work():
    """Touching equal balls: 2π R γ cos θ (Israelachvili); a ball on a plate: twice as
    much; what it takes of an impact is the integral of its pull over the gap."""
    law, ball, tension, volume = LAWS["liquid_bridge"], 4e-3, 0.072, 1e-10
    between, on_plate = (
        -law.function(0.0, 0.0, r, 1e8, tension, 30.0, volume) for r in (ball / 2, ball)
    )
    whole = 2 * math.pi * ball * tension * math.cos(math.radians(30))
    assert between == pytest.approx(whole) and on_plate == pytest.approx(2 * whole)
    end = law.reach(ball / 2, 1e8, tension, 30.0, volume)
    assert end == pytest.approx((1 + math.radians(30) / 2) * volume ** (1 / 3))
    assert law.function(-1.001 * end, 0.0, ball / 2, 1e8, tension, 30.0, volume) == 0.0
    gaps = np.linspace(0.0, end, 20001)
    scaled = gaps * math.sqrt(ball / volume)
    work = np.trapezoid(whole / (1 + 1.05 * scaled + 2.5 * scaled**2), gaps)
    mass, speed, own = 2.3e-4, 0.2, (tension, 30.0, volume)
    half = solve_ivp(
        lambda t, s: [s[1], law.function(-s[0], 0.0, ball / 2, 1e8, *own) / mass],
        (0, 4 * end / speed),
        [0.0, speed],
        rtol=1e-9,
        atol=1e-14,
        max_step=end / speed / 2000,
    )
    left = math.sqrt(speed**2 - 2 * work / mass)
    assert half.y[1, -1] == pytest.approx(left, rel=1e-4)


def test_jkr_agrees_with_its_parametric_form_and_its_landmarks():
    law, r, e, w = LAWS["spring_jkr"], 3e-3, 5e6, 0.2

    def whole(overlap):
        return law.function(overlap, 0.0, r, e, 1.0, w)[0]

    reach, strongest = law.reach(r, e, w), 1.5 * math.pi * w * r
    a_snap = (math.pi * w * r**2 / (8 * e)) ** (1 / 3)
    for a in a_snap * np.array([1.02, 1.5, 3.0, 10.0, 60.0]):
        overlap = a**2 / r - math.sqrt(2 * math.pi * w * a / e)
        force = 4 * e * a**3 / (3 * r) - math.sqrt(8 * math.pi * w * e * a**3)
        assert whole(overlap) == pytest.approx(force, rel=1e-7, abs=1e-9 * strongest)
    pulls = np.array([whole(x) for x in np.linspace(-reach, 2 * reach, 4001)])
    assert -pulls.min() == pytest.approx(strongest, rel=1e-6)
    assert -whole(-reach) == pytest.approx(
        5 / 9 * strongest, rel=2e-3
    )  # a double root: half the digits
    assert -whole(0.0) == pytest.approx(8 / 9 * strongest, rel=1e-9)
    # Deep in contact the terms in √w cancel at a given overlap; what is left is −π w
    # R*.
    deep = 1e5 * reach
    assert whole(deep) - hertz(deep, r, e) == pytest.approx(-math.pi * w * r, rel=1e-4)


def test_jkr_sticking_speed_of_a_dry_seed_is_millimetres_a_second():
    # Work to break the neck: 7.09 (w⁵ R*⁴/E*²)^⅓, Thornton & Ning (1998), Powder
    # Technol. 99, 154–162.
    law, mass, r, e, w = LAWS["spring_jkr"], 2.3e-4, 3e-3, 1e8, 0.1
    work = 7.09 * (w**5 * r**4 / e**2) ** (1 / 3)
    v_s = math.sqrt(2 * work / mass)
    assert 1e-3 < v_s < 5e-3
    assert (
        leave_through(law, (w,), 1.05 * v_s, mass) > 0.0
        and leave_through(law, (w,), 0.95 * v_s, mass) == 0.0
    )
    assert leave_through(law, (w,), 3 * v_s, mass) == pytest.approx(
        math.sqrt(8) * v_s, rel=0.01
    )


def test_linear_cohesion_is_energy_density_times_hertzian_area():
    law = LAWS["cohesion_linear"].function
    r, overlap = 3e-3, 2e-5
    assert law(overlap, 0.0, r, 1e8, 5e4) == pytest.approx(
        -5e4 * math.pi * (math.sqrt(r * overlap)) ** 2
    )
    assert law(-1e-6, 0.0, r, 1e8, 5e4) == 0.0


# ---- sliding, rolling, moving walls ----


def test_friction_laws_have_their_ends_and_speeds():
    kinetic, stribeck, viscous = (
        LAWS[f"friction_{n}"].function for n in ("kinetic", "stribeck", "viscous")
    )
    assert kinetic(1e-4, 0.5, 0.1, 1e-3) == pytest.approx(0.5, abs=2e-3) and kinetic(
        5e-3, 0.5, 0.1, 1e-3
    ) == pytest.approx(0.4)
    assert (
        stribeck(0.05, 0.5, 0.1, 0.05) == pytest.approx(0.5 - 0.1 * (1 - math.exp(-1)))
        and stribeck(5, 0.5, 0.1, 0.05) == 0.4
    )
    assert (
        viscous(2.0, 0.3, 0.05) == pytest.approx(0.4)
        and viscous(50.0, 0.3, -0.05) == 0.0
    )
    assert (
        kinetic(1.0, 0.1, 0.5, 1e-3) == 0.0 and stribeck(9.0, 0.1, 0.5, 0.05) == 0.0
    )  # never negative


def test_sliding_block_with_stribeck_friction_stops_where_the_integral_says():
    law, v0 = LAWS["friction_stribeck"].function, 0.5
    speeds = np.linspace(0.0, v0, 20_001)
    distance = np.trapezoid([v / (G * law(v, 0.34, 0.1, 0.05)) for v in speeds], speeds)
    dt, v, x = 1e-6, v0, 0.0
    while v > 0:
        v -= G * law(v, 0.34, 0.1, 0.05) * dt
        x += v * dt
    assert x == pytest.approx(distance, rel=1e-4) and distance > v0**2 / (2 * 0.34 * G)


def test_viscous_rolling_slows_a_ball_as_the_closed_form():
    # v' = −(5/7) g (μ_r + k v): v = (v_0 + μ_r/k) exp(−(5/7) g k t) − μ_r/k.
    mu_r, k, m, r, v0 = 0.01, 0.05, 2.3e-4, 3e-3, 0.3
    constant, growing = (
        LAWS["rolling_type_a"].function,
        LAWS["rolling_viscous"].function,
    )

    def slow(_, y):
        w = y[0] / r
        torque = constant(m * G, w, r, mu_r) + growing(m * G, w, r, mu_r, k)
        return [-torque * r / (1.4 * m * r**2)]

    run = solve_ivp(slow, (0, 0.5), [v0], rtol=1e-10, atol=1e-12)
    assert run.y[0, -1] == pytest.approx(
        (v0 + mu_r / k) * math.exp(-5 / 7 * G * k * 0.5) - mu_r / k, rel=1e-8
    )


def test_powers_join_the_laws_of_which_they_are_the_general_case():
    viscous, power = LAWS["rolling_viscous"].function, LAWS["rolling_power"].function
    assert power(2.0, 50.0, 3e-3, 0.01, 0.06, 0.3, 1.0) == pytest.approx(
        viscous(2.0, 50.0, 3e-3, 0.01, 0.2)
    )
    viscous, power = LAWS["friction_viscous"].function, LAWS["friction_power"].function
    assert power(0.2, 0.3, 0.06, 0.3, 1.0) == pytest.approx(viscous(0.2, 0.3, 0.2))
    assert power(0.9, 0.3, -0.2, 0.3, 1.0) == 0.0  # never negative
    # a resistance that falls with speed never drives
    assert LAWS["rolling_power"].function(
        2.0, 50.0, 3e-3, 0.01, -0.5, 0.15, 1.0
    ) == pytest.approx(-0.01 * 2.0 * 3e-3)


def test_a_push_is_along_the_motion_and_of_its_power():
    v = np.array([1.0, -2.0, 0.5])
    fast = np.linalg.norm(v)
    force = np.array(LAWS["push_power"].function(*v, 0, 0, 0, 0.007, 2e-3, 1.5, 3.0))
    assert force[:3] == pytest.approx(-2e-3 * (fast / 1.5) ** 3 * v / fast)
    assert (
        LAWS["push_power"].function(*[0.0] * 6, 0.007, 2e-3, 1.5, -1.0)[:3] == (0,) * 3
    )


def test_a_restitution_of_a_power_holds_at_its_speed_and_has_its_slope():
    law = LAWS["restitution_power"].function
    for power in (-1.0, 0.0, 2.0):
        assert law(0.8, 0.5, -0.07, 0.8, power) == 0.5
        near = law(0.8 * math.exp(1e-4), 0.5, -0.07, 0.8, power) - 0.5
        assert near == pytest.approx(-0.07e-4, rel=1e-3)
    assert law(1.3, 0.5, -0.07, 0.8, 1e-6) == pytest.approx(
        law(1.3, 0.5, -0.07, 0.8, 0.0), abs=1e-6
    )


def test_wall_motions_have_the_rate_that_they_say():
    steady, shaken = LAWS["motion_steady"].function, LAWS["motion_vibration"].function
    for t in (0.013, 0.37, 1.21):
        for f, numbers in ((steady, (0.02, 0.1, 1.0)), (shaken, (9.81, 50.0, 0.4))):
            h = 1e-6
            assert f(t, *numbers)[1] == pytest.approx(
                (f(t + h, *numbers)[0] - f(t - h, *numbers)[0]) / (2 * h), abs=1e-7
            )
    assert steady(9.0, 0.02, 0.1, 1.0) == (0.02, 0.0)
    t = np.linspace(0, 0.02, 2001)
    rates = np.array([shaken(x, 9.81, 50.0, math.pi / 2) for x in t])
    assert rates[0] == pytest.approx(
        [0, 0], abs=1e-15
    )  # where the wall was built, from rest
    assert np.abs(np.gradient(rates[:, 1], t)).max() == pytest.approx(9.81, rel=1e-4)


def test_a_choice_names_what_is_wrong():
    with pytest.raises(ValueError, match="lift"):
        LAWS["magnus"].use()
    with pytest.raises(ValueError, match=r"factor = -1.*outside 0.0 … 20.0"):
        LAWS["drag"].use(factor=-1)
    assert LAWS["drag"].use(wind_x=0.2).numbers == (1.204, 1.825e-5, 1.0, 0.2, 0.0, 0.0)
