"""Slides made by other code (sliding.py): clean ones raise no alarm, concealed effects are located, named and measured."""

import inspect
import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from sliding import Bench, G, readings, slides

from calibrate.diagnose.decide import ALPHA, Candidate, Verdict
from calibrate.diagnose.effects.slide import plate_vibration, stribeck
from calibrate.diagnose.slide import diagnose, motion
from calibrate.diagnose.slide.diagnose import diagnose_slide, fitted
from calibrate.diagnose.slide.model import Model, candidates
from calibrate.diagnose.slide.motion import LAWS, Laws, friction_at, mark_of, travel
from calibrate.diagnose.slide.problem import prepare
from calibrate.diagnose.slide.readings import grid_of
from calibrate.diagnose.slide.session import assemble
from calibrate.diagnose.slide.tilt import seen_tilt
from calibrate.twin.slides import read_slides

LIGHT = Bench(fps=120.0, rest_s=1.0)


def found(bench, seed, count=3):
    return diagnose_slide(slides(bench, count, np.random.default_rng(seed)), np.random.default_rng(0))


def test_a_block_on_a_still_plate_has_its_closed_form():
    """x = g (sin θ − μ cos θ) t²/2 from the onset, with μ = tan θ less what friction loses in motion."""
    angle, loss, onset = math.radians(25.0), 0.08, 0.237
    laws, tilt = Laws(static_excess=loss), np.array([angle, 0, 0, 0])
    friction = friction_at(onset, tilt, laws)
    assert friction == pytest.approx(math.tan(angle) - loss)
    t = np.linspace(0, 1, 101)
    x, v = travel(t, onset, tilt, laws._replace(friction=friction))
    pull = G * loss * math.cos(angle)
    assert x == pytest.approx(pull * np.clip(t - onset, 0, None) ** 2 / 2, abs=1e-12)
    assert v[-1] == pytest.approx(pull * (1 - onset))


def test_a_block_that_a_fit_drives_too_far_stays_finite():
    """Friction that falls with the way slid grows the travel exponentially."""
    tilt = np.array([math.radians(25.0), 0, 0, 0])
    x, v = travel(np.linspace(0, 60, 200), 0.0, tilt, Laws(friction=0.1, worn=-20.0))
    assert np.isfinite(x).all() and np.isfinite(v).all() and (np.diff(x) >= 0).all()


def test_machine_code_of_older_laws_is_not_taken_up_again():
    """It is kept under the mark of every law that goes into it."""
    sources = [inspect.getsource(law) for law in LAWS]
    for compiled in (motion._travel, motion._forces):
        assert compiled.py_func.__qualname__.endswith(mark_of(sources))
    for k, source in enumerate(sources):
        assert mark_of([*sources[:k], source.replace("1", "2"), *sources[k + 1 :]]) != mark_of(sources)
    modules = {name: value for name, value in vars(motion).items() if inspect.ismodule(value)}
    used = {name for name, value in modules.items() if ".effects." in value.__name__}
    assert used == {law.__name__.split(".")[-1] for law in LAWS}


def test_a_slowly_tilting_plate_gives_the_third_power():
    """x = g Ω t³/(6 cos θ₀) while θ is near θ₀."""
    rate, angle = math.radians(1.0), math.radians(20.0)
    tilt, t = np.array([angle, rate, 0, 0]), np.linspace(0, 0.3, 31)
    x, _ = travel(t, 0.0, tilt, Laws(friction=math.tan(angle), turning=0.0))
    assert x[-1] == pytest.approx(G * rate * 0.3**3 / 6 / math.cos(angle), rel=2e-3)


def test_clean_slides_raise_no_alarm_and_their_chi2_is_right():
    seen = slides(LIGHT, 4, np.random.default_rng(3))
    finding = diagnose_slide(seen, np.random.default_rng(0))
    assert finding.verdict == "none" and not finding.alarm
    prepared = prepare(assemble(seen))
    base = fitted(prepared, Model(prepared.session, 0.0, candidates(prepared.session)))
    assert base.chi2 / base.freedom == pytest.approx(1, abs=0.15)  # about 1,000 rows of correlated noise


def fades(v, x):
    return 0.03 * math.exp(-v / 0.05)


def grows(v, x):
    return 0.08 * v


CASES = [
    ("kinetic-friction", {"static": 0.006, "rates": (1.0, 5.0), "fps": 240.0}, 0.006, ("onset", "sliding")),
    ("viscous-sliding", {"friction": grows}, 0.08, ("sliding",)),
    ("clock-offset", {"clock_s": 0.4, "rates": (2.0, 6.0)}, 0.4, ("measurement", "onset")),
]
MORE = [
    ("stribeck", {"friction": fades}, 0.03, ("onset", "sliding")),
    ("adhesion", {"pull": 1e-3, "counts": (1, 4)}, 1.0, ("onset", "sliding")),
    ("partial-rolling", {"inertia": 0.4}, 0.4, ("onset", "sliding")),
]


@pytest.mark.parametrize(
    ("effect", "change", "true", "sectors"), [*CASES, *(pytest.param(*case, marks=pytest.mark.slow) for case in MORE)]
)
def test_a_concealed_effect_is_located_named_and_measured(effect, change, true, sectors):
    finding = found(replace(LIGHT, **change), 1, count=4)
    assert finding.alarm and finding.verdict == "name" and finding.names == (effect,)
    assert finding.sectors[0].name in sectors
    parameter = finding.parameters[effect]
    assert abs(parameter.value - true) < 1.1 * (parameter.high95 - parameter.low95)  # 4.3 sd: six cases must all pass


@pytest.mark.parametrize(
    ("static", "change", "tells"), [(0.002, {}, False), (0.006, {}, True), (0.006, {"rates": (1.0, 5.0), "fps": 240.0}, True)]
)
def test_friction_that_is_lost_at_once_or_over_the_first_speeds(static, change, tells):
    """What fades over a few mm/s looks the same where little is lost: a class; not so where the recordings tell."""
    finding = found(replace(LIGHT, static=static, **change), 1, count=4)
    assert finding.names == (("kinetic-friction",) if tells else ("kinetic-friction", "stribeck"))
    assert finding.verdict == ("name" if tells else "class") and any("fades" in note for note in finding.notes) != tells


def test_friction_that_fades_over_a_few_mm_per_s_is_not_called_lost_at_once():
    """Even where the candidate of greater speeds explains less."""
    finding = found(replace(LIGHT, friction=lambda v, x: 0.002 * math.exp(-((v / 0.004) ** 2))), 1, count=4)
    assert finding.verdict == "class" and set(finding.names) == {"kinetic-friction", "stribeck"}


@pytest.mark.parametrize(
    ("friction", "verdict", "names"),
    [
        (lambda v, x: 0.005 * v, "name", {"kinetic-friction", "viscous-sliding"}),
        pytest.param(lambda v, x: 0.02 * x, "unknown", set(), marks=pytest.mark.slow),
    ],
)
def test_what_friction_grows_with_is_told_beside_friction_lost_at_once(friction, verdict, names):
    """About the baseline the way slid comes first, and hides what stands for it: the speed, at two rates."""
    bench = replace(LIGHT, static=0.0015, friction=friction, rates=(1.0, 5.0), noise_mm=0.02)
    finding = found(bench, 3, count=4)
    assert finding.verdict == verdict and set(finding.names) == names
    assert names or "with the way slid to the power 1 " in finding.law  # beside the friction that is lost at once


def test_the_shape_of_fading_friction_has_no_kink():
    """A fit that is stopped at an edge goes back and forth there: the exponent changes with its parameter everywhere."""
    steep = [stribeck.friction(0.02, 1.0, 0.0, shape) for shape in np.linspace(-2.5, 2.5, 101)]
    assert (np.abs(np.diff(steep, 2)) < 0.01).all() and (np.diff(steep) > 0).all()
    assert stribeck.friction(0.05, 0.1, 0.0, 0.3) == pytest.approx(0.1 / math.e)
    assert stribeck.friction(0.05, 0.0, 0.0, 0.0) == 0.0


def test_two_effects_are_both_named_though_the_onset_has_two_minima():
    """Begun at the baseline's onset, a fit beside a clock's offset ends at a friction that is greater in motion than at rest."""
    finding = found(replace(LIGHT, static=0.003, clock_s=-0.3, rates=(1.0, 5.0), fps=240.0, noise_mm=0.02), 1, count=4)
    assert finding.verdict == "name" and set(finding.names) == {"kinetic-friction", "clock-offset"}
    assert finding.parameters["kinetic-friction"].value == pytest.approx(0.003, rel=0.1)
    assert finding.parameters["clock-offset"].value == pytest.approx(-0.3, abs=0.1)


def test_a_weight_that_turns_about_a_still_plate_is_no_news():
    """Beside a plate that turns it has no Coriolis acceleration, which looks like friction that grows with speed."""
    still = replace(LIGHT, turns=False, hinge_stated=False, rates=(2.0, 6.0), noise_mm=0.02)
    finding = found(still, 1, count=2)  # one at each rate
    assert finding.verdict == "none" and any("stands still" in note for note in finding.notes)
    assert found(replace(still, hinge_stated=True), 1, count=2).alarm


def test_what_a_plate_that_turns_and_one_that_stands_still_call_by_two_names_is_a_class(monkeypatch):
    """At one rate a plate's turning is friction that grows with speed: that it takes no parameter is no proof of it."""
    still = replace(LIGHT, turns=False, hinge_stated=False, rates=(4.0,), noise_mm=0.02)
    prepared = prepare(assemble(slides(still, 3, np.random.default_rng(1))))
    base = fitted(prepared, Model(prepared.session, 0.0, candidates(prepared.session)))
    both, one = ("kinetic-friction", "viscous-sliding"), ("kinetic-friction",)

    def told(fit, names, evidence):
        best = Candidate(names, (0.0,), (0.0,), 20.0, 1.0, 0.1, 1.0, 0.5, ())
        return diagnose.Told(fit, None, Verdict("name", names, 1e-9, (best,), 9.0, None), evidence)

    def verdict(more):
        monkeypatch.setattr(diagnose, "_told", lambda fit, rng: told(fit, one, 100.0 + more))
        return diagnose._or_still(prepared, told(base, both, 100.0), False, np.random.default_rng(0)).verdict

    assert verdict(6.0).verdict == "class" and verdict(6.0).names == both and "start_mm" in verdict(6.0).next_record
    assert verdict(-6.0).verdict == "name" and verdict(-6.0).names == both


def test_what_one_rate_and_one_load_cannot_tell_is_a_class():
    """A wrong sensor, a wrong clock, a pull and a little rolling all scale the acceleration and do nothing else."""
    finding = found(replace(LIGHT, offset_deg=4.0, noise_mm=0.02), 2, count=4)
    assert finding.verdict == "class" and {"angle-offset", "clock-offset", "adhesion"} <= set(finding.names)
    assert "tilt rate" in finding.next_record and "spirit level" in finding.next_record and "seed" in finding.next_record


@pytest.mark.parametrize("change", [{"step_deg": 0.5}, {"rounded_deg": 0.5}])
def test_stairs_of_the_tilt_are_seen_in_its_column(change):
    finding = found(replace(LIGHT, **change), 1)
    assert finding.names == ("stepped-tilt",) and finding.sectors[0].name == "measurement"
    assert finding.parameters["stepped-tilt"].value == pytest.approx(0.5, abs=0.01)


def test_a_noisy_or_finely_resolved_column_is_no_staircase():
    t = np.arange(0, 4, 0.01)
    ramp = 15 + 2 * t
    noisy = ramp + np.random.default_rng(1).normal(0, 0.1, len(t))
    assert seen_tilt(t, noisy, 3.0, 4.0).stair_deg == 0
    assert seen_tilt(t, np.round(ramp, 1), 3.0, 4.0).stair_deg == 0
    assert seen_tilt(t, np.ceil(ramp / 0.4) * 0.4, 3.0, 4.0).stair_deg == pytest.approx(0.4, rel=0.01)


def test_a_vibration_is_heard():
    finding = found(replace(LIGHT, shake=(0.3, 12.0), fps=200.0), 1)
    assert finding.names == ("plate-vibration",) and finding.sectors[0].name == "sliding"
    parameter = finding.parameters["plate-vibration"]
    assert parameter.low95 < 0.34 and parameter.high95 > 0.26


def slipped(amplitude, omega, growth, phase):
    """Speed at which it slides on when the mean pull is up to the friction, the wave's own taken off, and the way until then:
    brute force, from rest, sticking whenever it stops."""
    times = np.linspace(-1.1 * amplitude / growth, 0.5 * amplitude / growth, 20_000)
    h, speed, way = times[1] - times[0], 0.0, 0.0
    for t in times:
        speed = max(speed + h * (growth * t + amplitude * math.sin(omega * t + phase)), 0.0)
        way += h * speed
    end, angle = times[-1], omega * times[-1] + phase
    mean = speed - growth * end**2 / 2 + amplitude / omega * math.cos(angle)
    return mean, way - growth * end**3 / 6 - mean * end + amplitude / omega**2 * math.sin(angle)


@pytest.mark.parametrize("in_a_wave", [0.1, 0.4, 1.0])
def test_a_shaken_block_slips_before_it_slides(in_a_wave):
    """The law against brute force, over the phases; in_a_wave: by how much of a the pull grows meanwhile."""
    a, hertz = 0.06, 20.0
    omega, growth, log = 2 * math.pi * hertz, in_a_wave * a * hertz, math.log(hertz / plate_vibration.HERTZ)
    speeds, ways = np.array([slipped(a, omega, growth, phase) for phase in np.arange(0, 2 * math.pi, 0.4)]).T
    low, high = (plate_vibration.released(a, log, chance) for chance in (-1.0, 1.0))
    assert low < speeds.mean() < high and speeds.std() < 0.6 * (high - low)
    assert speeds.max() == pytest.approx(a / omega, rel=0.03)
    way, speed = plate_vibration.crept(a, log, growth, 0.0)
    assert way == pytest.approx(ways.mean(), rel=0.15 + 1.2 * in_a_wave) and speed == pytest.approx(a / omega)
    assert plate_vibration.crept(a, log, growth, -1.01 * a / growth) == (0.0, 0.0)
    before = [plate_vibration.crept(a, log, growth, -0.5 * a / growth - h)[0] for h in (0.0, 1e-6)]
    assert (before[0] - before[1]) / 1e-6 == pytest.approx(plate_vibration.crept(a, log, growth, -0.5 * a / growth)[1], rel=1e-3)


def test_a_vibration_too_small_to_be_heard_is_known_by_how_the_block_lets_go():
    """A ripple of 5 µm under noise of 30: the block lets go early, and is the faster for it."""
    quiet = replace(LIGHT, noise_mm=0.03)
    finding = found(replace(quiet, shake=(0.06, 17.0), rates=(2.0, 4.0)), 1, count=5)
    assert finding.verdict == "name" and finding.names == ("plate-vibration",)
    assert any("ripple" in note for note in finding.notes)
    parameter = finding.parameters["plate-vibration"]
    assert parameter.low95 < 0.06 < parameter.high95


@pytest.mark.parametrize(
    "friction",
    [
        lambda v, x: 0.006 * (1 - math.exp(-v / 0.03)),
        pytest.param(lambda v, x: 0.004 * math.log1p(v / 0.001), marks=pytest.mark.slow),
    ],
)
def test_friction_that_grows_in_the_first_moments_is_no_vibration(friction):
    """A block that creeps is faster at first too; but what holds it goes on growing."""
    finding = found(replace(LIGHT, friction=friction, noise_mm=0.03, rates=(2.0, 4.0)), 1, count=5)
    assert finding.alarm and "plate-vibration" not in finding.names


def test_friction_that_grows_with_the_way_is_outside_the_library():
    finding = found(replace(LIGHT, friction=lambda v, x: 0.1 * x), 1, count=4)
    assert finding.verdict == "unknown" and finding.names == ()
    assert finding.sectors[0].name == "sliding"
    assert "grows with" in finding.law and finding.next_record


def angle_read(delay_mm=0.0, clock_s=0.0, pull=0.0, grid=0.0):
    """Reader of an angle: small steps until the block has moved by `delay_mm`."""

    def read(rate, count, rng):
        mu, omega, weight, dt = 0.4 + rng.normal(0, 0.003), math.radians(rate), 0.234e-3 * count, 2e-3
        t, x, v = 0.3 / omega, 0.0, 0.0
        while x <= 1e-3 * delay_mm:
            a = G * math.sin(omega * t) - mu * (G * math.cos(omega * t) + pull / weight)
            if a > 0 or v > 0:
                v += a * dt
                x += v * dt
                if not delay_mm:
                    break
            t += dt
        angle = math.degrees(omega * t) - rate * clock_s + rng.normal(0, 0.03)
        return math.ceil(angle / grid) * grid if grid else angle

    return read


def told(reader, rates, counts, **more):
    rng = np.random.default_rng(4)
    return diagnose_slide(readings(reader, rates, counts, 8, rng, **more), rng)


def test_readings_of_several_rates_and_loads():
    """Overshoot as the rate to the 2/3, as the rate, or as one over the load."""
    late = told(angle_read(delay_mm=5.0), (1, 3, 10), (4, 4, 4))
    assert late.names == ("reading-delay",) and abs(late.parameters["reading-delay"].value - 5) < 2
    assert late.sectors[0].name == "measurement"
    soon = told(angle_read(delay_mm=0.2), (0.5, 2, 5), (4, 4, 4))  # the overshoot's slope has no bound at a travel of nil
    assert soon.verdict in ("name", "class") and "reading-delay" in soon.names
    off = told(angle_read(clock_s=-0.2), (1, 3, 10), (4, 4, 4))
    assert "clock-offset" in off.names
    pulled = told(angle_read(pull=0.3e-3), (2, 2, 2), (1, 2, 4))
    assert pulled.names == ("adhesion",) and pulled.parameters["adhesion"].value == pytest.approx(0.3, abs=0.05)
    assert told(angle_read(), (1, 3, 10), (1, 2, 4)).verdict == "none"
    assert told(angle_read(grid=0.5), (2, 2, 2), (4, 4, 4)).names == ("stepped-tilt",)
    odd = told(angle_read(grid=0.37), (2, 2, 2), (4, 4, 4))
    assert odd.names == ("stepped-tilt",) and odd.parameters["stepped-tilt"].value == pytest.approx(0.37, abs=0.005)


def test_readings_that_never_differ_were_read_on_one_stair():
    """Friction differs from run to run, so equal angles are those of a stair; how high it is they do not tell."""
    same = told(lambda rate, count, rng: 21.74, (2, 2, 2), (4, 4, 4))
    step = same.parameters["stepped-tilt"]
    assert same.names == ("stepped-tilt",) and step.low95 < 1 < step.high95 and step.high95 > 5 * step.low95
    assert grid_of([np.array([21.74, 21.74, 21.74])]) is None


def test_one_rate_or_one_load_says_nothing_of_delay_or_pull():
    """Exact twins of friction itself."""
    assert told(angle_read(delay_mm=5.0), (2, 2, 2), (4, 4, 4)).verdict == "none"
    assert told(angle_read(pull=0.3e-3), (2, 2, 2), (4, 4, 4)).verdict == "none"
    assert told(angle_read(pull=0.3e-3), (2, 2, 2), (1, 2, 4), masses=False).verdict != "name"


def test_one_recording_is_never_enough_for_a_name():
    finding = found(replace(LIGHT, static=0.05), 1, count=1)
    assert finding.alarm and finding.verdict != "name" and finding.held_out is None


def test_what_cannot_be_used_says_why():
    (good,) = slides(LIGHT, 1, np.random.default_rng(1))
    late = good.time_s > good.time_s[-1] - 0.4
    cut = replace(good, time_s=good.time_s[late], x_mm=good.x_mm[late], frame=good.frame[late], tilt_deg=good.tilt_deg[late])
    still = replace(good, x_mm=0 * good.x_mm)
    unlevel = replace(good, tilt_deg=None, description=good.description | {"slide": {}})
    flat = replace(good, tilt_deg=0 * good.tilt_deg)
    short = replace(good, time_s=good.time_s[:9], x_mm=good.x_mm[:9], frame=good.frame[:9], tilt_deg=good.tilt_deg[:9])
    wrongs = ((still, "does not slide"), (cut, "onset"), (unlevel, "tilt_deg"), (flat, "does not tilt"), (short, "rows"))
    for wrong, why in wrongs:
        with pytest.raises(ValueError, match=why):
            diagnose_slide([wrong], np.random.default_rng(0))
    holes = replace(good, x_mm=np.where(np.arange(len(good.x_mm)) % 9 == 0, np.nan, good.x_mm))
    finding = diagnose_slide([holes, replace(still, recording="still")], np.random.default_rng(0))
    assert finding.verdict == "none" and any("still: left out" in note for note in finding.notes)


def test_slides_on_disk(tmp_path):
    (seen,) = slides(LIGHT, 1, np.random.default_rng(1))
    for name, column in (("a", {"tilt_deg": seen.tilt_deg}), ("b", {})):
        (tmp_path / name).mkdir()
        table = {"t_s": seen.time_s, "x_mm": seen.x_mm, "y_mm": 0 * seen.x_mm, **column}
        pd.DataFrame(table).to_csv(tmp_path / name / "track.csv", index=False)
        (tmp_path / name / "recording.toml").write_text('rig = "slide"\n[seed]\nmass_g = 0.2\ncount = 4\n', encoding="utf8")
    (tmp_path / "c").mkdir()
    (tmp_path / "c" / "readings.csv").write_text("slide_angle_deg\n21.4\n22.3\n", encoding="utf8")
    (tmp_path / "c" / "recording.toml").write_text('rig = "slide"\n[slide]\ntilt_rate_deg_s = 2.0\n', encoding="utf8")
    a, b, c = read_slides(tmp_path)
    assert not a.trouble and a.tilt_deg == pytest.approx(seen.tilt_deg) and a.description["camera"]["scale_sd"] == 0.01
    assert "tilt_deg" in b.trouble
    assert c.angles_deg == pytest.approx([21.4, 22.3]) and c.description["slide"]["tilt_rate_deg_s"] == 2.0
    with pytest.raises(FileNotFoundError):
        read_slides(tmp_path / "nowhere")


def usual(seed):
    """A clean session as stated uncertainties leave it."""
    g = np.random.default_rng(1000 + seed)
    bench = Bench(
        mu=g.uniform(0.25, 0.6), rates=[(2.0,), (1.0, 4.0), (0.5,), (5.0,), (2.0, 6.0)][seed % 5],
        counts=[(4,), (1, 4)][seed % 2], fps=float(g.choice([120, 200, 400])),
        rho=(0, 0.5, 0.8, 0.9)[seed % 4], white=float(g.choice([0, 0.3])),
        noise_mm=float(g.choice([0.02, 0.05, 0.1])), hinge_stated=bool(seed % 3), tilt_column=bool(seed % 7),
        sign=float(g.choice([-1, 1])),
    )  # fmt: skip
    return slides(bench, int(g.integers(1, 7)), g)


@pytest.mark.slow
def test_false_alarms_on_clean_slides():
    findings = [diagnose_slide(usual(seed), np.random.default_rng(0)) for seed in range(100)]
    assert sum(f.p_global < ALPHA for f in findings) <= 3  # 0.5 expected; more than 3 has a chance of 2e-3
    assert not any(f.verdict == "name" for f in findings)


@pytest.mark.slow
def test_intervals_cover():
    """Kinetic friction of a few thousandths, in 40 sessions: 95 % of the intervals should hold it."""
    rng, inside, names = np.random.default_rng(7), 0, 0
    for seed in range(40):
        true = rng.uniform(0.004, 0.02)
        finding = found(replace(LIGHT, static=true, rates=(1.0, 5.0), fps=240.0), 100 + seed, count=4)
        if finding.names == ("kinetic-friction",) and finding.verdict == "name":
            names += 1
            p = finding.parameters["kinetic-friction"]
            inside += p.low95 <= true <= p.high95
    assert names >= 36 and inside >= 0.85 * names  # of 40 at 95 %, fewer than 34 has a chance of 1e-2
