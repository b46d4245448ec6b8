"""Springs in the place of Hertz's, and what sticks, inside the engine: impacts and
prescribed presses come out as the closed forms say, between balls and on a plate.

Each law acts between seeds and a plate of one material of its own, so that all are
compiled into one step loop."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from benchtwin.sim.engine.step import Every, init, load, run, save
from benchtwin.sim.engine.time_step import time_step
from benchtwin.sim.engine.walls import Plane
from benchtwin.sim.engine.world import Placed, Scattered, World
from benchtwin.sim.laws import LAWS, Law, Parameter
from benchtwin.sim.material import Contact, Material, effective_moduli
from benchtwin.sim.seed import Seed

R, DENSITY, STIFFNESS, YIELD, WORK = 3e-3, 1250.0, 1e4, 2e5, 0.5
BALL = Seed.from_spheres([[0, 0, 0]], [R], DENSITY)
SOLIDS = {
    name: Material(name, DENSITY, 1e7, 0.3)
    for name in ("linear", "hysteretic", "plastic", "sticky", "hard")
}
MODULUS, _ = effective_moduli(SOLIDS["hard"], SOLIDS["hard"])
LAW = {
    "linear": LAWS["spring_linear"].use(
        between=("linear", "linear"), stiffness=STIFFNESS
    ),
    "hysteretic": LAWS["spring_walton_braun"].use(
        between=("hysteretic", "hysteretic"), stiffness=STIFFNESS
    ),
    "plastic": LAWS["spring_thornton"].use(
        between=("plastic", "plastic"), yield_pressure=YIELD
    ),
    "sticky": LAWS["spring_jkr"].use(between=("sticky", "sticky"), work=WORK),
    "hard": LAWS["cohesion_dmt"].use(between=("hard", "hard"), work=WORK),
}
PHASES = 8  # impacts that begin at different moments of a step


def world(name, places, speeds, *, plate=True, seed=BALL, e=0.5, mu=0.3, **options):
    """Seeds of a material that has its own law, on a plate of it or alone; the others'
    plates are far away."""
    solid, far = SOLIDS[name], [m for n, m in SOLIDS.items() if n != name]
    walls = [Plane(f"far {m.name}", m, (0, 0, -9)) for m in far]
    walls.append(Plane("plate", solid, (0, 0, 0 if plate else -9)))
    contacts = tuple(Contact((name, m.name), e, mu, 0.0) for m in SOLIDS.values())
    placed = Placed((seed,), solid, np.array(places), velocities=np.array(speeds))
    given = {"gravity": (0, 0, 0), "most_overlap": 0.5, "most_gain": 5e-3} | options
    return World((placed,), tuple(walls), contacts, tuple(LAW.values()), **given)


def rebounds(name, speed, *, plate=True, seed=BALL, **options):
    """Speed after over speed before of impacts at PHASES moments of a step, on the
    plate or of two balls head on."""
    low = float((seed.radii_m - seed.centres_m[:, 2]).max())
    at = np.arange(PHASES) * 4.0 * seed.bounding_radius_m
    down = np.tile([0.0, 0.0, -speed], (PHASES, 1))

    def of(step):
        gaps = speed * step * (1 + np.arange(PHASES) / PHASES)
        up = (low + gaps) if plate else (2 * low + gaps)
        places = np.column_stack([at, 0 * at, up])
        if plate:
            return world(name, places, down, seed=seed, **options)
        under = np.column_stack([at, 0 * at, 0 * at])
        both = np.concatenate([places, under]), np.concatenate([down / 2, -down / 2])
        return world(name, *both, plate=False, seed=seed, **options)

    made = of(time_step(of(1e-6)))
    clear = 1.02 * low if plate else 2.02 * low

    def over(world, state):
        x, v = state.positions[:, 2], state.velocities[:, 2]
        gap, opening = (x, v) if plate else (np.subtract(*np.split(x, 2)), _apart(v))
        return bool(((opening > 0) & (gap > clear)).all()) or state.time_s > 0.1

    state = run(made, init(made, np.random.default_rng(0)), over, every_s=1e-5)
    v = state.velocities[:, 2]
    return (v if plate else _apart(v)) / speed


def _apart(v):
    return np.subtract(*np.split(v, 2))


def pressed(name, overlaps, **options):
    """Force [N] on a ball that is held, step after step, at these overlaps with another
    at rest."""
    places = np.array([[0, 0, 2 * R - overlaps[0]], [0, 0, 0]])
    made = world(name, places, np.zeros((2, 3)), plate=False, mu=0.0, **options)
    state, force = init(made, np.random.default_rng(0), allowed_overlap=1.0), []
    for overlap in overlaps:
        places[0, 2] = 2 * R - overlap
        state.motion[:, :9] = 0.0
        state.motion[:, :3] = places[state.ids]
        state.load[:] = 0.0
        state = run(made, state, steps=1)
        force.append(state.load[np.argsort(state.ids)[0], 2])
    return np.array(force)


# ---- linear spring and dashpot ----


@pytest.mark.parametrize("plate", [True, False])
@pytest.mark.parametrize("e", [0.1, 0.5, 0.9])
def test_a_linear_spring_gives_back_what_was_entered_at_any_speed(e, plate):
    """exp(−π ζ/√(1 − ζ²)) = e, though it pulls at the end of contact."""
    for speed in (0.05, 1.5):
        back = rebounds("linear", speed, plate=plate, e=e)
        assert back == pytest.approx(e, rel=4e-3)


@pytest.mark.parametrize("e", [0.3, 0.7])
def test_a_linear_spring_that_may_not_pull_gives_back_more(e):
    """exp(−(ζ/√(1 − ζ²)) (π − arctan(2 ζ √(1 − ζ²)/(1 − 2 ζ²)))), Schwager & Pöschel
    (2007)."""
    zeta = -math.log(e) / math.hypot(math.log(e), math.pi)
    root = math.sqrt(1 - zeta**2)
    angle = math.pi - math.atan2(2 * zeta * root, 1 - 2 * zeta**2)
    clipped = math.exp(-zeta / root * angle)
    back = rebounds("linear", 1.0, e=e, pull_at_end=False, rayleigh_fraction=0.05)
    assert clipped > 1.02 * e and back == pytest.approx(clipped, rel=4e-3)


def in_touch_s(name, **options):
    """How long an impact of 0.5 m/s lasts, to a hundredth of it."""
    made = world(name, [[0, 0, R + 1e-6]], [[0, 0, -0.5]], **options)
    made = replace(made, rayleigh_fraction=0.02)
    low, dt = [], time_step(made)

    def look(world, state):
        low.append(state.positions[0, 2] < R)

    run(made, init(made, np.random.default_rng(0)), 2e-3, [Every(dt, look)])
    return sum(low) * dt


def test_contacts_of_linear_springs_last_as_long_as_they_should():
    """π √(m/k)/√(1 − ζ²) with a dashpot; half of a loading along k_1 and half of an
    unloading along k_1/e² without, after which the dent lies open at e v."""
    e, natural = 0.5, math.pi * math.sqrt(BALL.mass_kg / STIFFNESS)
    zeta = -math.log(e) / math.hypot(math.log(e), math.pi)
    damped = natural / math.sqrt(1 - zeta**2)
    assert in_touch_s("linear", e=e) == pytest.approx(damped, rel=0.01)
    deepest = 0.5 * math.sqrt(BALL.mass_kg / STIFFNESS)
    dent = (1 - e**2) * deepest / (e * 0.5)
    hysteretic = (1 + e) * natural / 2 + dent
    assert in_touch_s("hysteretic", e=e) == pytest.approx(hysteretic, rel=0.01)


# ---- springs that remember ----


@pytest.mark.parametrize("plate", [True, False])
@pytest.mark.parametrize("e", [0.3, 0.8])
def test_walton_and_braun_s_restitution_is_that_of_its_stiffnesses(e, plate):
    """√(k_1/k_2) at any speed, without a dashpot."""
    for speed in (0.05, 1.5):
        back = rebounds("hysteretic", speed, plate=plate, e=e)
        assert back == pytest.approx(e, rel=2e-3)


def test_walton_and_braun_s_branches_after_part_of_an_unloading():
    """Down and up along k_2 = 4 k_1, on along k_1, then along a k_2 from deeper; a
    contact that ended is forgotten."""
    micron = np.array([10, 9, 9.5, 10, 12, 11, 8, 9, 10, -1, 5])
    by_hand = [0.10, 0.06, 0.08, 0.10, 0.12, 0.08, 0.0, 0.0, 0.04, 0.0, 0.05]
    force = pressed("hysteretic", 1e-6 * micron)
    assert force == pytest.approx(np.array(by_hand), abs=1e-9)


def yield_speed(radius, mass):
    """√(2 W/m) with W = (8/15) E* √R* δ_y^2.5, Hertz's work up to yield."""
    deep = radius * (math.pi * YIELD / (2 * MODULUS)) ** 2
    work = 8 / 15 * MODULUS * math.sqrt(radius) * deep**2.5
    return math.sqrt(2 * work / mass)


@pytest.mark.parametrize("plate", [True, False])
def test_thornton_s_restitution_is_his_closed_form(plate):
    """One below yield; Eq. 26 of 1997 above; at last falling as v^−¼."""
    share = 1.0 if plate else 0.5
    own = yield_speed(share * R, share * BALL.mass_kg)
    closed = LAWS["restitution_plastic"].function
    for times in (0.8, 3.0, 30.0, 300.0):
        back = rebounds("plastic", times * own, plate=plate, rayleigh_fraction=0.05)
        by_hand = closed(times * own, 1.0, own, 0.0)
        assert back == pytest.approx(by_hand, rel=4e-3)
    ratio = closed(480 * own, 1, own, 0) / closed(30 * own, 1, own, 0)
    assert ratio == pytest.approx(0.5, rel=0.01)


def test_thornton_s_branches_after_part_of_an_unloading():
    """By his own equations: the force at a greatest overlap by the plastic branch, the
    way back a Hertz spring of the dent's radius R_p = (4 E*/(3 F*)) ((2 F* + F_y)/(2π
    p_y))^1.5, the same up again."""
    radius, p = R / 2, YIELD
    at_yield = radius * (math.pi * p / (2 * MODULUS)) ** 2
    first = 4 / 3 * MODULUS * math.sqrt(radius) * at_yield**1.5

    def loaded(x):
        return first + math.pi * p * radius * (x - at_yield)

    def back(x, deepest):
        top = loaded(deepest)
        wide = ((2 * top + first) / (2 * math.pi * p)) ** 1.5
        dent = 4 * MODULUS / (3 * top) * wide
        open_ = deepest - (top / (4 / 3 * MODULUS * math.sqrt(dent))) ** (2 / 3)
        return 4 / 3 * MODULUS * math.sqrt(dent) * max(x - open_, 0.0) ** 1.5

    a, b = 40 * at_yield, 60 * at_yield
    way = np.array([0.5 * at_yield, a, 0.99 * a, 0.995 * a, a, b, 0.99 * b, 0.5 * b])
    hertz = 4 / 3 * MODULUS * math.sqrt(radius) * (0.5 * at_yield) ** 1.5
    by_hand = [hertz, loaded(a), back(way[2], a), back(way[3], a), loaded(a)]
    by_hand += [loaded(b), back(way[6], b), 0.0]
    assert back(way[2], a) < 0.97 * loaded(way[2])
    assert pressed("plastic", way) == pytest.approx(np.array(by_hand), rel=1e-9)


# ---- surfaces that stick ----


@pytest.mark.parametrize(("name", "share"), [("sticky", 1.5), ("hard", 2.0)])
def test_the_strongest_pull_is_jkr_s_and_dmt_s(name, share):
    """(3/2) π w R* and 2π w R*; nothing before touch, and JKR's neck holds beyond
    it."""
    pull, radius = share * math.pi * WORK * R / 2, R / 2
    reach = LAWS["spring_jkr"].reach(radius, MODULUS, WORK)
    come = np.linspace(-1.5 * reach, 2 * reach, 701)
    force = pressed(name, np.concatenate([come, come[::-1]]))
    there, back = np.split(force, 2)
    assert (there[come < 0] == 0).all()
    assert back.min() == pytest.approx(-pull, rel=2e-3)
    apart = come[::-1] < 0
    held = come[::-1][apart & (back < 0)]
    assert held.min(initial=0.0) == pytest.approx(
        -reach if name == "sticky" else 0.0, abs=0.01 * reach
    )


@pytest.mark.parametrize("plate", [True, False])
def test_an_impact_costs_jkr_s_neck_and_dmt_s_nothing(plate):
    """7.09 (w⁵ R*⁴/E*²)^⅓ of energy, Thornton & Ning (1998)."""
    share = 1.0 if plate else 0.5
    mass = share * BALL.mass_kg
    lost = 7.09 * (WORK**5 * (share * R) ** 4 / MODULUS**2) ** (1 / 3)
    own = math.sqrt(2 * lost / mass)
    fine = {"plate": plate, "e": 1.0, "rayleigh_fraction": 0.005}
    for times in (1.2, 3.0):
        back = rebounds("sticky", times * own, **fine)
        assert back == pytest.approx(math.sqrt(1 - times**-2), rel=4e-3)
    assert rebounds("hard", own, **fine) == pytest.approx(1.0, rel=4e-3)
    held = world("sticky", [[0, 0, R + 1e-6]], [[0, 0, -0.8 * own]], e=1.0)
    held = replace(held, rayleigh_fraction=0.02)
    state = run(held, init(held, np.random.default_rng(0)), 0.02)
    assert state.positions[0, 2] < R + LAWS["spring_jkr"].reach(R, MODULUS, WORK)


def test_a_damped_impact_of_sticky_balls_is_the_equation_of_motion_s():
    """m a = F − γ √(S m) v from touch to the neck's end, by an ODE solver: at usual
    steps, whatever the moment at which a step meets the surface."""
    law, mass, v0, e = LAW["sticky"], BALL.mass_kg, 0.5, 0.6
    reach = LAWS["spring_jkr"].reach(R, MODULUS, WORK)

    def motion(_, y):
        (force, _, stiffness, damping), _ = law.along_normal(y[0], 0, (R, MODULUS, e))
        return [y[1], -(force + damping * math.sqrt(stiffness * mass) * y[1]) / mass]

    def gone(_, y):
        return y[0] + reach * (1 - 1e-9)

    gone.terminal, gone.direction = True, -1
    end = solve_ivp(motion, (0, 0.01), [0, v0], events=gone, rtol=1e-9, atol=1e-14)
    back = rebounds("sticky", v0, e=e)
    assert back == pytest.approx(-end.y[1, -1] / v0, rel=1.2e-2)


# ---- whatever the spring ----


@pytest.mark.parametrize("name", SOLIDS)
def test_two_unequal_balls_keep_their_momentum_and_make_no_energy(name):
    small, large = (Seed.from_spheres([[0, 0, 0]], [r], DENSITY) for r in (R, 2 * R))
    made = world(
        name, [[0, 0, 3.001 * R], [0, 0, 0]], [[0.1, 0, -0.6], [0, 0, 0.1]], plate=False
    )
    placed = replace(made.seeds[0], shapes=(small, large), shape_of=np.array([0, 1]))
    made = replace(made, seeds=(placed,))
    state, energy = init(made, np.random.default_rng(0)), []
    before = state.masses @ state.velocities
    for _ in range(40):
        state = run(made, state, steps=25)
        energy.append(0.5 * state.masses @ (state.velocities**2).sum(axis=1))
    assert state.velocities[0, 2] > state.velocities[1, 2]  # they met
    after = state.masses @ state.velocities
    assert after == pytest.approx(before, abs=1e-12 * np.abs(before).max())
    assert energy[-1] < (0.5 * state.masses @ [0.37, 0.01])


@pytest.mark.parametrize("name", ["linear", "hysteretic"])
def test_a_seed_of_three_balls_rebounds_as_one_ball(name):
    flat = [[-2 * R, 0, 0], [0, 0, 0], [2 * R, 0, 0]]
    seed = Seed.from_spheres(flat, [R] * 3, DENSITY)
    assert rebounds(name, 0.5, seed=seed) == pytest.approx(0.5, rel=4e-3)


@pytest.mark.parametrize("name", SOLIDS)
def test_a_bed_goes_on_bit_for_bit_from_a_file(name, tmp_path):
    """Sixty balls, whose lists are made anew on the way: what each contact remembers is
    in the checkpoint."""
    made = world(name, [[0, 0, R]], [[0, 0, 0]], gravity=(0, 0, -9.81), mu=0.3)
    walls = [*made.walls]
    for k, (x, y) in enumerate([(1, 0), (-1, 0), (0, 1), (0, -1)]):
        point, normal = (-0.013 * x, -0.013 * y, 0.0), (x, y, 0)
        walls.append(Plane(f"side {k}", SOLIDS[name], point, normal))
    low, high = (-0.013, -0.013, 0.0), (0.013, 0.013, 0.09)
    seeds = (Scattered((BALL,), SOLIDS[name], 60, low, high),)
    made = replace(made, seeds=seeds, walls=tuple(walls))
    start = init(made, np.random.default_rng(3))
    half = run(made, start, 0.14)
    save(half, tmp_path / "half.npz")
    on = run(made, load(tmp_path / "half.npz"), 0.18)
    whole = run(made, start, 0.18)
    assert np.array_equal(on.motion, whole.motion)
    assert np.array_equal(on.pair_memory, whole.pair_memory)
    assert half.pair_touch.sum() > 30 and on.positions[:, 2].max() < 0.05
    if name in ("hysteretic", "plastic"):
        assert (half.pair_memory[half.pair_touch > 0, 8:].max(axis=1) > 0).all()


def counted(overlap, closing_speed, radius, modulus, touched, push):
    """A push [N] that is there from the second step of a contact on."""
    return push * min(touched, 1.0), touched + 1.0


def test_a_law_that_adds_a_force_may_remember_too():
    law = Law(
        "counted",
        "normal",
        counted,
        (Parameter("push", "N", 0.0, 1.0, ""),),
        memory=(Parameter("touched", "1", 0.0, 1e9, "steps so far"),),
    )
    touching = (1e-6, 0.0, (R, MODULUS, 1.0))
    chosen = law.use(push=0.25)
    assert chosen.along_normal(*touching) == ((0.0,), (1.0,))
    assert chosen.along_normal(*touching, (1.0,)) == ((0.25,), (2.0,))
    with pytest.raises(ValueError, match=r"returns .* not one finite number"):
        replace(law, memory=(), function=lambda o, v, r, m, push: (push, 0.0))


# ---- what is refused ----


def test_two_springs_between_two_materials_are_refused():
    made = world("linear", [[0, 0, R]], [[0, 0, 0]])
    two = (*made.laws, LAWS["spring_jkr"].use(work=0.1))
    words = "2 of kind spring between linear and linear, 'spring_linear' and 'spring_j"
    with pytest.raises(ValueError, match=words):
        replace(made, laws=two)


def test_a_stiffness_that_needs_too_many_steps_is_refused_with_their_number():
    made = world("linear", [[0, 0, R]], [[0, 0, 0]])
    stiff = LAWS["spring_linear"].use(between=("linear", "linear"), stiffness=1e12)
    made = replace(made, laws=(stiff, *made.laws[1:]))
    with pytest.raises(
        ValueError, match=r"'spring_linear' asks for .* s, 1.9e\+09 for"
    ):
        init(made, np.random.default_rng(0))


def test_the_step_is_a_fiftieth_of_the_stiffest_contact():
    """m is that of two balls, k that of unloading; JKR's neck is stiffer than Hertz's
    at its beginning."""
    made = world("hysteretic", [[0, 0, R]], [[0, 0, 0]], e=0.5)
    fine = replace(made, laws=made.laws[:2])
    stiff = STIFFNESS / 0.25
    by_hand = math.pi * math.sqrt(BALL.mass_kg / 2 / stiff) / 50
    assert time_step(fine) == pytest.approx(by_hand)
