"""What happens in impacts, on drops made by other code: tilt, laws of restitution, films, damage, shape, and what has no name."""

import math
from dataclasses import replace
from types import SimpleNamespace

import falling
import numpy as np
import pytest
from falling import Bench, G, tracks

from diagnose.finding import Question, answer
from diagnose.rigs.drop import diagnose
from diagnose.rigs.drop.bounce import bounces_of
from diagnose.rigs.drop.diagnose import diagnose_drop
from diagnose.rigs.drop.impacts import Impacts, chosen, heard, seeds_of
from diagnose.rigs.drop.scatter import scatter_of
from diagnose.rigs.drop.unlisted import law_in_words, windows_of

FALLING = ("restitution-falls-with-speed", "viscoelastic-restitution", "plastic-restitution", "plate-compliance")


def diagnose_impacts(impacts):
    """What a table of impacts alone tells."""
    told = {n: SimpleNamespace(description={}, session="") for n in impacts.names}
    alternatives, _ = diagnose._alternatives((), None, impacts, told, 1.0)
    return answer(Question("drop", tuple(alternatives), windows_of, lambda base, model: (), {}, law_in_words), np.random.default_rng(0))


LIGHT = Bench(fps=500.0)
BALL = replace(LIGHT, axes=(3.5e-3,) * 3)
STATED_BALL = {"length_mm": 7.0, "width_mm": 7.0, "thickness_mm": 7.0, "density_kg_m3": 1250.0}
SOY = {"length_mm": 8.72, "width_mm": 6.84, "thickness_mm": 5.98}
HEIGHTS = [0.310, 0.100, 0.030]


def drops(bench, seed, count=6, heights=None):
    made = tracks(bench, count, np.random.default_rng(seed), heights=heights)
    if bench.axes != BALL.axes:
        return made
    return [replace(t, description=t.description | {"seed": STATED_BALL}) for t in made]


def diagnosed(bench, seed, **more):
    return diagnose_drop(drops(bench, seed, **more), np.random.default_rng(0))


def falls(speed, count):
    return 0.7 - 0.08 * speed


def film(speed, count):
    return math.sqrt(max(0.55**2 - (0.15 / speed) ** 2, 0.0))


def damage(speed, count):
    return 0.6 * 0.93 ** (count - 1)


CASES = [
    ("plate-tilt", replace(BALL, tilt_deg=1.0), None, 1.0),
    ("impact-damage", replace(BALL, e=damage), [0.310, 0.100], -0.07),
]
MORE = [
    ("plate-tilt", replace(LIGHT, tilt_deg=1.5), None, 1.5),
    ("film-adhesion", replace(BALL, e=film, fps=1000.0), HEIGHTS, 0.15),
    ("restitution-falls-with-speed", replace(BALL, e=falls), None, 0.12),
    ("restitution-falls-with-speed", replace(LIGHT, e=falls), HEIGHTS, 0.12),
]


@pytest.mark.parametrize(
    ("effect", "bench", "heights", "true"), [*CASES, *(pytest.param(*case, marks=pytest.mark.slow) for case in MORE)]
)
def test_a_concealed_effect_of_impacts_is_located_named_and_measured(effect, bench, heights, true):
    found = diagnosed(bench, 1, heights=heights)
    assert found.alarm and found.sectors[0].name == "impact" and found.sectors[0].explained > 0.8
    assert found.names == (effect,) if effect not in FALLING else set(found.names) <= set(FALLING) and effect in found.names
    value = found.effects[effect].size
    half = (value.high95 - value.low95) / 2
    assert abs(value.value - true) < 2 * half  # four standard deviations: six cases must all pass


@pytest.mark.parametrize("bench", [LIGHT, BALL])
def test_clean_drops_raise_no_alarm(bench):
    found = diagnosed(bench, 2, count=5)
    assert found.verdict == "none" and not found.alarm and found.names == ()


def test_a_steep_plate_is_no_restitution_that_falls_with_the_count():
    """A ball that runs down the plate meets it more gently at every bounce, and leaves it less steeply."""
    found = diagnosed(replace(BALL, tilt_deg=4.0, angle=False, bounces=4), 1)
    assert found.verdict == "name" and found.names == ("plate-tilt",)
    assert found.parameters["plate-tilt"].low95 < 4.0 < found.parameters["plate-tilt"].high95  # friction's share is not known




def test_damage_is_a_class_where_each_count_has_its_own_speed():
    """A ball from one height: e that falls with the count is e that rises with the speed."""
    found = diagnosed(replace(BALL, e=damage), 1)
    assert found.alarm and "impact-damage" in found.names
    rising = diagnosed(replace(BALL, e=lambda speed, count: 0.45 + 0.06 * speed), 1)
    assert rising.alarm and rising.verdict in ("class", "unknown", "name")


def test_a_stated_tilt_is_no_news_and_only_what_is_beyond_it_is_found():
    made = drops(replace(BALL, tilt_deg=2.0), 1)
    told = [replace(t, description=t.description | {"drop": t.description.get("drop", {}) | {"tilt_deg": 2.0}}) for t in made]
    assert diagnose_drop(told, np.random.default_rng(0)).verdict == "none"
    half = [replace(t, description=t.description | {"drop": t.description["drop"] | {"tilt_deg": 1.0}}) for t in told]
    found = diagnose_drop(half, np.random.default_rng(0))
    assert found.verdict == "name" and found.names == ("plate-tilt",)
    assert found.parameters["plate-tilt"].low95 < 1.0 < found.parameters["plate-tilt"].high95


def test_drag_and_tilt_together_are_both_named():
    found = diagnosed(replace(BALL, tilt_deg=1.0, stated_air=0.0), 1)
    assert found.verdict == "name" and set(found.names) == {"drag", "plate-tilt"}
    assert set(found.parameters) == {"drag", "plate-tilt"}
    assert {s.name for s in found.sectors} == {"flight", "measurement", "impact"}
    assert sum(s.explained > 0.2 for s in found.sectors) >= 2


@pytest.mark.slow
def test_a_camera_rolled_in_one_of_two_sessions_is_no_tilt():
    """Each session has a camera of its own: the roll is the second one's, and the plate is level."""
    straight, rolled = drops(LIGHT, 3, count=3), drops(replace(LIGHT, roll_deg=0.8), 4, count=3)
    both = [replace(t, session="one") for t in straight] + [
        replace(t, session="two", recording=f"{t.recording}b") for t in rolled
    ]
    found = diagnose_drop(both, np.random.default_rng(0))
    assert found.names == ("camera-roll",) and found.parameters["camera-roll"].value == pytest.approx(0.8, abs=0.1)


@pytest.mark.slow
def test_what_has_no_name_is_unknown_with_its_law():
    found = diagnosed(replace(LIGHT, e=lambda speed, count: 0.4 + 0.12 * speed), 2, count=9, heights=HEIGHTS)
    assert found.verdict == "unknown" and found.names == () and found.sectors[0].name == "impact"
    assert found.law.startswith("the restitution rises with speed of impact")


@pytest.mark.slow
def test_a_seed_much_longer_than_stated_shows_by_its_contacts():
    bench = replace(LIGHT, axes=(4.6e-3, 3.3e-3, 2.7e-3))
    told = [replace(t, description=t.description | {"seed": STATED_BALL}) for t in drops(bench, 2)]
    found = diagnose_drop(told, np.random.default_rng(0))
    assert "shape-conversion" in found.names and found.sectors[0].name == "impact"


def test_one_drop_is_too_little_for_a_verdict_on_impacts():
    found = diagnosed(replace(BALL, tilt_deg=3.0), 1, count=1)
    assert found.verdict != "name"


def hit(angle, e):
    """Before and after (v_x, v_z, ω anticlockwise) of an ellipsoid that falls upright in the picture plane, without friction."""
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    bench = replace(LIGHT, e=e, friction=0.0)
    state = (np.zeros(3), np.array([0.0, 0.0, -2.0]), turn, np.zeros(3))
    _, v, _, w = falling.bounce(state, bench, np.array([0.0, 0.0, 1.0]), 1)
    return (0.0, -2.0, 0.0), (v[0], v[2], -w[1])


def test_restitution_of_a_central_impact_is_that_of_the_point_of_contact():
    """A third of a seed's loss of height is spin: where that is seen, e of the contact comes back to 3 %."""
    before, after = zip(*(hit(angle, 0.6) for angle in (0.0, 0.2, 0.4, -0.3)), strict=True)
    none, count = np.zeros(4), len(before)
    table = Impacts(
        ("a",), np.zeros(4, dtype=int), np.ones(4, dtype=int), np.array(before), np.array(after),
        np.column_stack([np.arange(count), np.arange(count) + 1]), np.zeros((count + 1, 3)), none, 0.0, seeds_of([{"seed": SOY}]),
        none,
    )  # fmt: skip
    seen = bounces_of(table, 0.19)
    plain = table.after[:, 1] / 2.0
    assert plain.min() < 0.5
    assert seen.e == pytest.approx(0.6, abs=0.02)
    assert seen.e_error == pytest.approx(np.zeros((4, 4)))


def test_a_badly_seen_spin_makes_the_restitution_of_a_long_seed_uncertain():
    """e of the point of contact holds the spins: its stated error is that of redrawn ones, and a ball's is nil."""
    before, after = (np.array(rows) for rows in zip(*(hit(angle, 0.6) for angle in (0.05, 0.2, 0.4, -0.3)), strict=True))
    sd, rng, flights = 3.0, np.random.default_rng(0), np.arange(8).reshape(4, 2)

    def seen(turned, long):
        sds = np.column_stack([np.zeros((8, 2)), np.full(8, sd)])
        one = np.ones(4, dtype=int)
        table = Impacts(
            ("a",), 0 * one, one, before + turned[0], after + turned[1], flights, sds, np.zeros(4), 0.0,
            seeds_of([{"seed": SOY}]), np.zeros(4),
        )  # fmt: skip
        return bounces_of(table, long)

    redrawn = [seen(sd * rng.normal(size=(2, 4, 1)) * [0, 0, 1], 0.19).e for _ in range(2000)]
    told = np.sqrt(np.diag(seen(np.zeros((2, 4, 3)), 0.19).e_error))
    assert told == pytest.approx(np.std(redrawn, axis=0), rel=0.1) and told.max() > 1e-3
    assert np.diag(seen(np.zeros((2, 4, 3)), 0.0).e_error) == pytest.approx(np.zeros(4))


def test_scatter_is_read_beside_a_law_and_outliers_have_little_say():
    rng = np.random.default_rng(3)
    x = np.tile(np.linspace(-1, 1, 10), 8)
    y = 0.5 + 0.3 * x + 0.02 * rng.normal(size=80)
    y[::10] += 1.0
    design = np.column_stack([np.ones(80), x])
    parts = [np.eye(80), np.diag(np.zeros(80))]
    found = scatter_of(y, design, np.zeros((80, 80)), parts, 0.003)
    sds = np.sqrt(np.diag(found.covariance))
    good = np.ones(80, dtype=bool)
    good[::10] = False
    # Student's weights cost a factor of up to 1.2, what 8 outliers leave up to 2
    assert 0.015 < np.median(sds[good]) < 0.05
    assert sds[~good].min() > 5 * np.median(sds[good])
    assert scatter_of(y[:3], design[:3], np.zeros((3, 3)), [np.eye(3), np.eye(3)], 0.003) is None
    twice = scatter_of(
        y, np.column_stack([design, 2 * x - 1]), np.zeros((80, 80)), parts, 0.003
    )  # a law of two columns all the same
    np.testing.assert_allclose(twice.covariance, found.covariance)


def repeated(scatter, rng):
    """Three drops of a ball, two bounces each: the second is lower by 8 %, and all scatter by `scatter`."""
    e = np.tile([0.42, 0.39], 3) + scatter * rng.normal(size=6)
    fall = np.sqrt(2 * G * np.repeat([0.11, 0.06, 0.11], 2))
    speed = np.where(np.arange(6) % 2, np.roll(e, 1) * fall, fall)
    nil, unseen, flights = np.zeros(6), np.full(6, np.nan), np.arange(12).reshape(6, 2)
    before, after = np.column_stack([nil, -speed, unseen]), np.column_stack([nil, e * speed, unseen])
    sds = np.tile([5e-4, 5e-4, np.nan], (12, 1))
    about = seeds_of([{"seed": STATED_BALL}] * 3)
    number = np.tile([1, 2], 3)
    return Impacts(tuple("abc"), np.repeat(np.arange(3), 2), number, before, after, flights, sds, nil, 0.0, about, unseen)


def test_bounces_that_repeat_each_other_scatter_little_however_few():
    """Six bounces tell what is lost with the count where they repeat to .001; as a control not where they scatter by .03."""
    sharp, vague = (
        diagnose_impacts(repeated(scatter, np.random.default_rng(2))) for scatter in (0.001, 0.03)
    )
    assert sharp.alarm and "impact-damage" in sharp.names
    assert not vague.alarm


def test_what_two_bounces_of_a_ball_have_in_common_is_no_scatter():
    """Five bounces, e .47 at first and .376 after: a ball's later bounces scatter no more. As a control a long seed's do."""

    def told(sizes):
        table = chosen(repeated(0.0, np.random.default_rng(2)), np.arange(5))
        e = np.where(table.number > 1, 0.376, 0.47)
        after = np.column_stack([table.after[:, 0], -e * table.before[:, 1], table.after[:, 2]])
        return diagnose_impacts(replace(table, after=after, seeds=seeds_of([{"seed": sizes}] * 3)))

    ball = told(STATED_BALL | {"thickness_mm": 6.96})
    assert ball.alarm and "impact-damage" in ball.names
    assert not told(SOY).alarm


def lying(slope, rng):
    """Eight drops of a seed, three bounces each: e rises by `slope` to a silhouette on end, and scatters by .004."""
    size, count = 24, 3
    steep = rng.uniform(-1, 1, size)
    e, number = 0.5 + slope * steep + 0.004 * rng.normal(size=size), np.tile(np.arange(1, count + 1), 8)
    speed = np.array([1.5, 0.75, 0.38])[number - 1] * (1 + 0.02 * rng.normal(size=size))
    nil, unseen, flights = np.zeros(size), np.full(size, np.nan), np.arange(2 * size).reshape(size, 2)
    before, after = np.column_stack([nil, -speed, unseen]), np.column_stack([nil, e * speed, unseen])
    sds, about = np.tile([5e-4, 5e-4, np.nan], (2 * size, 1)), seeds_of([{"seed": STATED_BALL | {"thickness_mm": 6.6}}] * 8)
    return Impacts(tuple("abcdefgh"), np.repeat(np.arange(8), 3), number, before, after, flights, sds, nil, 0.0, about, steep)


def test_a_restitution_that_depends_on_how_the_seed_lies_has_no_name_and_its_law_is_said():
    """As controls none where it does not, and none where nobody saw how the seed lay."""
    tilted = lying(0.03, np.random.default_rng(4))
    found = diagnose_impacts(tilted)
    assert found.alarm and found.verdict == "unknown" and "lies to one on end" in found.law
    even = [lying(0.0, np.random.default_rng(seed)) for seed in range(4)]
    for quiet in (replace(tilted, steep=np.full(24, np.nan)), *even):
        assert not diagnose_impacts(quiet).alarm


def beside_the_centre(tilt_rad, rng):
    """Six drops of a pea, three bounces each: it hardly turns, and is touched 1 % of its radius beside its centre, each on its
    own side; spin and sideways kick as a ball's, I Δω = m (b Δv_n + h Δv_x)."""
    radius, (sides, number) = 3.5e-3, (rng.choice([-1, 1], 6), np.tile(np.arange(1, 4), 6))
    beside = np.repeat(sides, 3) * rng.uniform(0.005, 0.012, 18) + 0.002 * rng.normal(size=18)
    speed, nil = np.array([2.4, 1.3, 0.7])[number - 1], np.zeros(18)
    gain = 1.55 * speed
    kick = tilt_rad - 0.7 * beside
    turn = 2.5 * (0.3 * beside - 0.001 * rng.normal(size=18))  # over gain: b − 0.7 b is left of the offset
    before = np.column_stack([nil, -speed, nil])
    after = np.column_stack([kick * gain, 0.55 * speed, turn * gain / radius])
    about = seeds_of([{"seed": STATED_BALL | {"thickness_mm": 6.96}}] * 6)
    sds, flights = np.tile([5e-4, 5e-4, 0.3], (36, 1)), np.arange(36).reshape(18, 2)
    return Impacts(tuple("abcdef"), np.repeat(np.arange(6), 3), number, before, after, flights, sds, nil, 0.0, about, nil)






def test_last_hops_of_a_dozen_rows_show_a_film():
    """Three drops of a ball at 500 fps: what is left of .5 m/s, a hop of 26 ms, is a third of what a constant e would leave."""

    def thick(speed, count):
        return math.sqrt(max(0.65**2 - (0.3 / speed) ** 2, 0.0))

    found = diagnosed(replace(BALL, e=thick, fps=500.0), 1, count=3, heights=[0.110, 0.060])
    assert found.verdict == "name" and found.names == ("film-adhesion",) and found.p_global < 1e-4
    assert found.parameters["film-adhesion"].low95 < 0.3 < found.parameters["film-adhesion"].high95


def heard_times(e_of, height, hops, rng):
    speed, time, out = math.sqrt(2 * G * height), 0.3, [0.3]
    for n in range(hops):
        speed *= e_of(speed, n + 1) * (1 + 0.005 * rng.normal())
        time += 2 * speed / G
        out.append(time)
    return np.array(out)


def microphone(e_of, seed, heights=(0.31, 0.1)):
    rng = np.random.default_rng(seed)
    about = [{"seed": STATED_BALL, "drop": {"height_mm": 1e3 * h}, "air": {"density_kg_m3": 0.0}} for h in (*heights, *heights, *heights)]
    times = [heard_times(e_of, d["drop"]["height_mm"] / 1e3, 5, rng) for d in about]
    return heard([
        SimpleNamespace(recording=n, description=d, contacts_s=t, contacts_sd_s=np.full(len(t), 2e-4))
        for n, d, t in zip("abcdef", about, times, strict=True)
    ])






def test_times_of_impacts_alone_show_restitution_that_falls_with_speed():
    found = diagnose_impacts(microphone(lambda v, n: 0.75 - 0.09 * v, 1))
    assert found.verdict in ("name", "class") and set(found.names) <= set(FALLING)
    value = found.parameters["restitution-falls-with-speed"]
    assert value.value == pytest.approx(0.135, abs=0.02)
    assert diagnose_impacts(microphone(lambda v, n: 0.6, 2)).verdict == "none"


SHAPES = {"soy": LIGHT.axes, "ball": BALL.axes, "wheat": (3.2e-3, 1.6e-3, 1.4e-3), "round": (3.5e-3, 3.4e-3, 3.3e-3)}


def usual(seed):
    """Clean drops of any seed: e scatters by up to 5 % a bounce, scale, roll and drag as their stated sds leave them."""
    rng = np.random.default_rng(5000 + seed)
    axes = list(SHAPES.values())[seed % 4]
    middle, spread = rng.uniform(0.4, 0.7), float(rng.choice([0.0, 0.02, 0.05]))
    bench = replace(
        LIGHT, axes=axes, e=lambda v, n: min(middle * (1 + spread * rng.normal()), 0.95), rho=(0.0, 0.5, 0.8, 0.9)[seed % 4],
        scale=rng.normal(0, 8e-4), roll_deg=rng.normal(0, 0.05), shape_drag=1 + 0.15 * rng.normal(),
        tip_deg=float(rng.choice([6.0, 90.0])), angle=bool(rng.random() < 0.7),
    )  # fmt: skip
    made = tracks(bench, int(rng.integers(3, 8)), rng, heights=(None, [0.31, 0.1], HEIGHTS)[seed % 3])
    sizes = dict(zip(("length_mm", "width_mm", "thickness_mm"), (2e3 * a for a in axes), strict=True))
    return [replace(t, description=t.description | {"seed": sizes | {"density_kg_m3": 1250.0}}) for t in made]


@pytest.mark.slow
def test_false_alarms_of_the_whole_drop():
    found = [diagnose_drop(usual(seed), np.random.default_rng(0)) for seed in range(100)]
    print("alarms:", [(seed, f.names, f.p_global) for seed, f in enumerate(found) if f.alarm])
    assert sum(f.alarm for f in found) <= 3  # 0.5 expected; more than 3 has a chance of 2e-3
    assert not any(f.verdict == "name" for f in found)
