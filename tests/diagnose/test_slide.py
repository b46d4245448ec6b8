"""Slides made by other code (sliding.py): clean ones raise no alarm, concealed effects
are located, named and measured."""

import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from sliding import AIRLESS, LIGHT, Bench, found, slides

from benchtwin.infer.alarm import ALARM_P
from benchtwin.infer.noise import Noise
from benchtwin.infer.problem import fit
from benchtwin.rigs.slide.diagnose import alternatives, diagnose_slide
from benchtwin.rigs.slide.problem import prepare
from benchtwin.rigs.slide.read import read_slides
from benchtwin.rigs.slide.session import assemble


def test_clean_slides_raise_no_alarm_and_their_chi2_is_right():
    seen = slides(LIGHT, 4, np.random.default_rng(3))
    finding = diagnose_slide(seen, np.random.default_rng(0))
    assert finding.verdict == "none" and not finding.alarm
    base = fit(alternatives(prepare(assemble(seen)), None)[0].problem)
    assert base.chi2 / base.problem.freedom == pytest.approx(
        1, abs=0.15
    )  # about 1,000 rows of correlated noise


def test_frictions_that_differ_are_no_pull_to_the_plate():
    """Ten times the usual scatter from slide to slide: a pull lowers all frictions, and
    with them what they differ by, which is no evidence of it."""
    seen = slides(replace(LIGHT, mu_sd=0.03), 5, np.random.default_rng(6))
    base = fit(alternatives(prepare(assemble(seen)), None)[0].problem)
    pulled = fit(base.problem, free=("adhesion",), start=base)
    assert base.chi2 - pulled.chi2 < 6.6  # 1 % of clean ones
    assert abs(pulled.by_name["adhesion"]) < 3 * pulled.sd("adhesion")


def test_slow_noise_is_estimated_from_the_rest():
    """Beside a short slide's curve a correlation of a third of it is not seen: its
    power was told to be a quarter, ± 15 %."""
    wandering = replace(LIGHT, rho=0.97, white=0.1, rates=(2.0,), rest_s=0.8, lost=0.0)
    true = wandering.noise_mm**2 * Noise(0.97, 0.1, 0.0).low_frequency
    for seed in range(3):
        told = prepare(assemble(slides(wandering, 6, np.random.default_rng(seed))))
        power = np.mean(np.concatenate(told.sigma) ** 2) * told.noise.low_frequency
        assert abs(math.log(power / true)) < 3 * told.noise.log_level_sd


def test_what_an_effect_makes_of_friction_is_weighed_without_scatter_too():
    """A pull and viscous friction that are missing look like friction that scatters
    along each slide: the effects are asked about beside it and without it."""
    missing = replace(
        LIGHT,
        pull=3e-3,
        friction=lambda v, x: 0.006 * v,
        rates=(1.0, 5.0),
        counts=(2, 8),
        fps=240.0,
        noise_mm=0.02,
        lost=0.0,
    )
    seen = slides(missing, 6, np.random.default_rng(1))
    found = alternatives(prepare(assemble(seen)), None)
    runs = [a.problem.model.session.runs for a in found]
    assert [any(run.wander.size for run in own) for own in runs] == [True, False]
    assert sum(a.odds for a in found) == 1.0


def fades(v, x):
    return 0.03 * math.exp(-v / 0.05)


def grows(v, x):
    return 0.08 * v


CASES = [
    pytest.param(
        "kinetic-friction",
        {"static": 0.006, "rates": (1.0, 5.0), "fps": 240.0},
        0.006,
        ("onset", "sliding"),
        marks=pytest.mark.slow,
    ),
    ("viscous-sliding", {"friction": grows}, 0.08, ("sliding",)),
    (
        "clock-offset",
        {"clock_s": 0.4, "rates": (2.0, 6.0)},
        0.4,
        ("measurement", "onset"),
    ),
]
MORE = [
    ("stribeck", {"friction": fades}, 0.03, ("onset", "sliding")),
    ("adhesion", {"pull": 1e-3, "counts": (1, 4)}, 1.0, ("onset", "sliding")),
    ("partial-rolling", {"inertia": 0.4}, 0.4, ("onset", "sliding")),
]


@pytest.mark.parametrize(
    ("effect", "change", "true", "sectors"),
    [*CASES, *(pytest.param(*case, marks=pytest.mark.slow) for case in MORE)],
)
def test_a_concealed_effect_is_located_named_and_measured(
    effect, change, true, sectors
):
    finding = found(replace(LIGHT, **change), 1, count=4)
    assert finding.alarm and finding.verdict == "name" and finding.names == (effect,)
    assert finding.sectors[0].name in sectors
    parameter = finding.parameters[effect]
    assert abs(parameter.value - true) < 1.1 * (
        parameter.high95 - parameter.low95
    )  # 4.3 sd: six cases must all pass


@pytest.mark.slow
def test_what_one_rate_and_one_load_cannot_tell_is_a_class():
    """A wrong sensor, a wrong clock, a pull and a little rolling all scale the
    acceleration and do nothing else."""
    finding = found(replace(LIGHT, offset_deg=4.0, noise_mm=0.02), 2, count=4)
    assert (
        finding.verdict == "class"
        and len(
            {"angle-offset", "clock-offset", "adhesion", "partial-rolling"}
            & set(finding.names)
        )
        >= 2
    )
    assert finding.next_record


@pytest.mark.slow
@pytest.mark.parametrize(
    "counts", [pytest.param((1,), marks=pytest.mark.slow), (1, 4, 8)]
)
def test_air_is_no_viscous_friction(counts):
    """Drag of a sphere of the seed's volume on every seed, none in another's lee; as a
    control, of nothing that is stated."""
    blown = replace(
        LIGHT,
        air=0.076,
        rates=(0.5, 2.0, 6.0),
        counts=counts,
        noise_mm=0.03,
        travel_mm=120.0,
    )
    assert found(blown, 4, count=6).verdict == "none"
    assert "viscous-sliding" in found(replace(blown, stated_air=0.0), 4, count=6).names


@pytest.mark.slow
def test_weak_viscous_friction_is_in_the_class_of_scaled_acceleration():
    """It fits as well, and has less evidence only because it might have been much
    more."""
    finding = found(
        replace(AIRLESS, friction=lambda v, x: 0.002 * v, rates=(1.0,), noise_mm=0.03),
        4,
    )
    assert finding.verdict == "class" and {
        "adhesion",
        "angle-offset",
        "clock-offset",
        "viscous-sliding",
    } <= set(finding.names)


@pytest.mark.slow
def test_friction_that_grows_with_the_way_is_never_a_name():
    """From rest, way goes as the square of speed: laws of speed are about as probable
    as something unlisted, and neither is said for certain."""
    finding = found(replace(LIGHT, friction=lambda v, x: 0.1 * x), 1, count=4)
    assert finding.alarm and finding.verdict in ("class", "unknown")
    assert finding.p_verdict < 0.8 and finding.next_record
    assert finding.sectors[0].name == "sliding"
    unlisted = sum(
        p for names, p in finding.explanations if finding.unlisted & set(names)
    )
    assert unlisted > 0.2


def test_outlying_rows_are_dropped_without_an_alarm():
    """Four rows in a thousand lie anywhere within 20 mm: of each run the same rows
    slide as without them, but those."""
    seen, clean = (
        slides(replace(LIGHT, stray=share), 4, np.random.default_rng(1))
        for share in (0.004, 0.0)
    )
    lost = [len(c.x_mm) - len(s.x_mm) for s, c in zip(seen, clean, strict=True)]
    assert sum(lost) >= 4 and max(lost) <= 8
    session, without = assemble(seen), assemble(clean)
    assert not session.notes
    assert all(
        abs(len(a.time) - len(b.time)) <= 5
        for a, b in zip(session.runs, without.runs, strict=True)
    )
    assert diagnose_slide(seen, np.random.default_rng(0)).verdict == "none"


@pytest.mark.slow
def test_one_recording_is_never_enough_for_a_name():
    finding = found(replace(LIGHT, static=0.05), 1, count=1)
    assert finding.alarm and finding.verdict != "name" and finding.held_out is None


def test_what_cannot_be_used_says_why():
    (good,) = slides(LIGHT, 1, np.random.default_rng(1))
    late = good.time_s > good.time_s[-1] - 0.4
    cut = replace(
        good,
        time_s=good.time_s[late],
        x_mm=good.x_mm[late],
        frame=good.frame[late],
        sd_mm=good.sd_mm[late],
        tilt_deg=good.tilt_deg[late],
    )
    still = replace(good, x_mm=0 * good.x_mm)
    unlevel = replace(good, tilt_deg=None, description=good.description | {"slide": {}})
    short = replace(
        good,
        time_s=good.time_s[:3],
        x_mm=good.x_mm[:3],
        frame=good.frame[:3],
        sd_mm=good.sd_mm[:3],
        tilt_deg=good.tilt_deg[:3],
    )
    wrongs = (
        (still, "does not slide"),
        (cut, "onset"),
        (unlevel, "start_deg"),
        (short, "rows"),
    )
    for wrong, why in wrongs:
        with pytest.raises(ValueError, match=why):
            diagnose_slide([wrong], np.random.default_rng(0))
    holes = replace(
        good, x_mm=np.where(np.arange(len(good.x_mm)) % 9 == 0, np.nan, good.x_mm)
    )
    finding = diagnose_slide(
        [holes, replace(still, recording="still")], np.random.default_rng(0)
    )
    assert finding.verdict == "none" and any(
        "still: left out" in note for note in finding.notes
    )


def test_slides_on_disk(tmp_path):
    (seen,) = slides(LIGHT, 1, np.random.default_rng(1))
    for name, column in (("a", {"tilt_deg": seen.tilt_deg}), ("b", {})):
        (tmp_path / name).mkdir()
        table = {"t_s": seen.time_s, "x_mm": seen.x_mm, "y_mm": 0 * seen.x_mm, **column}
        pd.DataFrame(table).to_csv(tmp_path / name / "track.csv", index=False)
        (tmp_path / name / "recording.toml").write_text(
            'rig = "slide"\n[seed]\nmass_g = 0.2\ncount = 4\n', encoding="utf8"
        )
    (tmp_path / "c").mkdir()
    (tmp_path / "c" / "readings.csv").write_text(
        "slide_angle_deg\n21.4\n22.3\n", encoding="utf8"
    )
    (tmp_path / "c" / "recording.toml").write_text(
        'rig = "slide"\n[slide]\ntilt_rate_deg_s = 2.0\n', encoding="utf8"
    )
    a, b, c = read_slides(tmp_path)
    assert not a.trouble and a.tilt_deg == pytest.approx(
        np.interp(a.time_s, seen.time_s, seen.tilt_deg)
    )
    assert a.description["camera"]["scale_sd"] == 0.01
    assert "tilt_deg" in b.trouble
    assert (
        c.angles_deg == pytest.approx([21.4, 22.3])
        and c.description["slide"]["tilt_rate_deg_s"] == 2.0
    )
    with pytest.raises(FileNotFoundError):
        read_slides(tmp_path / "nowhere")


def usual(seed):
    """A clean session as stated uncertainties leave it."""
    g = np.random.default_rng(1000 + seed)
    bench = Bench(
        mu=g.uniform(0.25, 0.6),
        rates=[(2.0,), (1.0, 4.0), (0.5,), (5.0,), (2.0, 6.0)][seed % 5],
        counts=[(4,), (1, 4)][seed % 2],
        fps=float(g.choice([120, 200, 400])),
        rho=(0, 0.5, 0.8, 0.9)[seed % 4],
        white=float(g.choice([0, 0.3])),
        noise_mm=float(g.choice([0.02, 0.05, 0.1])),
        hinge_stated=bool(seed % 3),
        tilt_column=bool(seed % 7),
        sign=float(g.choice([-1, 1])),
    )
    return slides(bench, int(g.integers(1, 7)), g)


@pytest.mark.slow
def test_false_alarms_on_clean_slides():
    findings = [
        diagnose_slide(usual(seed), np.random.default_rng(0)) for seed in range(100)
    ]
    assert (
        sum(f.p_global < ALARM_P for f in findings) <= 3
    )  # 0.5 expected; more than 3 has a chance of 2e-3
    assert not any(f.verdict == "name" for f in findings)


@pytest.mark.slow
def test_intervals_cover():
    """Kinetic friction of a few thousandths, in 40 sessions: 95 % of the intervals
    should hold it."""
    rng, inside, names = np.random.default_rng(7), 0, 0
    for seed in range(40):
        true = rng.uniform(0.004, 0.02)
        finding = found(
            replace(LIGHT, static=true, rates=(1.0, 5.0), fps=240.0),
            100 + seed,
            count=4,
        )
        if finding.names == ("kinetic-friction",) and finding.verdict == "name":
            names += 1
            p = finding.parameters["kinetic-friction"]
            inside += p.low95 <= true <= p.high95
    assert (
        names >= 36 and inside >= 0.85 * names
    )  # of 40 at 95 %, fewer than 34 has a chance of 1e-2


def test_where_the_tilt_began_is_not_known_from_a_rate_alone():
    """A film that begins a second before the slide, on a plate that has long been
    tilting: no news."""
    bench = replace(LIGHT, tilt_column=False, start_stated=False, rates=(2.0, 6.0))
    assert found(bench, 1, count=4).verdict == "none"
