"""Rolls, from recordings to a finding."""

import math

import numpy as np
from benchtwin.infer.alarm import ALARM_P as ALPHA
from benchtwin.infer.conditions import Contact, conditions_of, with_conditions
from benchtwin.infer.effect import separating_recordings
from benchtwin.infer.explanation import Alternative, Explanation
from benchtwin.infer.finding import (
    Curve,
    DiagnosisTask,
    Finding,
    Parameter,
    Sector,
    finding_of,
)
from benchtwin.infer.problem import Fit, fit
from benchtwin.rigs.roll.effects import EFFECTS
from benchtwin.rigs.roll.model import run_motion
from benchtwin.rigs.roll.problem import PRIORS, build, roll_problem
from benchtwin.rigs.roll.session import assemble
from benchtwin.rigs.roll.unlisted import (
    SEEN_P,
    arguments,
    find_ripple,
    law_of,
    windows_of,
)
from scipy import stats

BOTH_WAYS = (
    "the same plate run the other way: one direction alone cannot tell a slope of the"
    " level from rolling friction"
)
OTHER_LENGTH = (
    "the same roll from an incline of twice the length: this separates dependence on"
    " speed from dependence on place"
)
LEAST_READINGS = 3  # in either direction


def diagnose_roll(recordings, rng: np.random.Generator) -> Finding:
    """Finding of recordings (twin.roll_tracks.SeenRoll); ValueError where none can be
    used."""
    usable = [r for r in recordings if not r.trouble]
    if not any(len(r.x_mm) for r in usable):
        return diagnose_readings(usable)
    runs, seed, notes = assemble(usable)
    scales: dict[str, float] = {}  # relative sd, by session
    for r in (r for r in usable if len(r.x_mm)):
        sd = float(r.description["camera"]["scale_sd"])
        scales[r.session] = max(scales.get(r.session, 0.0), sd)
    turn, phase = arguments(runs, seed)
    problem = roll_problem(build(runs, seed, turn, phase, ripple=False), scales)
    base = fit(problem)
    ripple = find_ripple(base, rng)
    if ripple.p < SEEN_P:
        if np.isfinite(seed.rise_mm) and not seed.round:
            notes = (
                *notes,
                (
                    "Each seed climbs and falls twice a turn, as its stated shape (a"
                    f" rise of {seed.rise_mm:.2g} mm) lets it."
                ),
            )
        problem = roll_problem(
            build(runs, seed, ripple.turn, ripple.phase, ripple=True), scales
        )
    told = {r.recording: r for r in usable}
    about = [told[run.recording] for run in runs]
    follows, said = conditions_of(
        [r.description for r in about], [r.session for r in about]
    )
    friction = Contact("rolling_friction", "mu", 0.3, base.problem.model.mu, "run-out")
    one_way = len({run.sign for run in runs}) < 2

    def advice(names: tuple[str, ...]) -> str | None:
        return (
            separating_recordings(EFFECTS, names)
            if names
            else BOTH_WAYS
            if one_way
            else OTHER_LENGTH
        )

    asked = DiagnosisTask(
        "roll",
        (Alternative(with_conditions(problem, friction, follows)),),
        windows_of,
        curves_of,
        {friction.name: rolling_friction},
        law_of,
        advice,
        (*notes, *said, *corner_notes(base)),
    )
    return finding_of(asked, rng)


def corner_notes(base: Fit) -> tuple[str, ...]:
    """What the corner takes within the usual range, where it is significant."""
    model, at, sd = base.problem.model, base.by_name["corner"], base.sd("corner")
    lost = [
        float(np.mean([model.usual_loss(r, rank) for r in range(len(model.runs))]))
        for rank in (at - sd, at, at + sd)
    ]
    if lost[1] < 1.5 * (lost[2] - lost[0]):  # three standard deviations
        return ()
    return (
        (
            f"The corner takes {100 * lost[1]:.2g} % of the speed: no more than a sharp"
            " corner may."
        ),
    )


def curves_of(base: Fit, model: Fit) -> tuple[Curve, ...]:
    """Travel of each run over the time since its release."""
    out = []
    for r, run in enumerate(base.problem.model.runs):
        left = [
            1e3 * (run.x - run_motion(of.problem.model, r, of.starts[r], of.by_name)[0])
            for of in (base, model)
        ]
        since, way = run.time_s - base.starts[r][0], 1e3 * (run.x - base.starts[r][1])
        out.append(Curve(run.recording, "travel", "mm", "t_s", since, way, *left))
    return tuple(out)


def rolling_friction(e: Explanation) -> tuple[float, float]:
    """Of the pair, in EDEM's standard model: torque μ_r F_n R over F_n R."""
    model = e.fit.problem.model
    return model.mu * (1 + e.fit.by_name["mu"]), model.mu * e.fit.sd("mu")


def diagnose_readings(recordings) -> Finding:
    """Slope from both directions; ValueError where incline or length are not stated."""
    names = tuple(r.recording for r in recordings)
    ways = {
        s: [
            r
            for r in recordings
            if (r.description["roll"].get("direction") or "+x") == s
        ]
        for s in ("+x", "-x")
    }
    values = {
        s: np.concatenate([r.run_out_mm for r in found] or [np.zeros(0)])
        for s, found in ways.items()
    }
    if min(len(v) for v in values.values()) < LEAST_READINGS:
        note = (
            f"run-outs alone tell nothing of what is missing; {LEAST_READINGS} readings"
            " in either direction would tell a slope"
        )
        return _finding(
            names,
            1.0,
            None,
            float("nan"),
            (note,),
            "the same plate run the other way, or a film of the roll",
        )
    told = recordings[0].description["roll"]
    if not told.get("incline_deg") or not told.get("incline_length_mm"):
        raise ValueError(
            "[roll] incline_deg and incline_length_mm are missing; without them"
            " run-outs do not give a slope"
        )
    slope, sd, p, freedom = _slope(values, told)
    bayes = 0.5 * stats.chi2.isf(max(p, 1e-300), 1) - 0.5 * math.log1p((0.5 / sd) ** 2)
    half = sd * float(stats.t.isf(0.025, freedom))
    return _finding(
        names, p, Parameter("deg", slope, slope - half, slope + half), bayes, (), None
    )


def _slope(
    values: dict[str, np.ndarray], told: dict
) -> tuple[float, float, float, float]:
    """Slope [deg], sd, p on a level plate, degrees of freedom (Welch)."""
    beta, way = math.radians(told["incline_deg"]), told["incline_length_mm"]
    plus, minus = (float(values[s].mean()) for s in ("+x", "-x"))
    share = {s: float(values[s].var(ddof=1)) / len(values[s]) for s in values}

    def solve(a: float, b: float) -> float:
        """θ of run-outs a, b: μ + θ = E/a, μ − θ = E/b, E = S (sin β − μ cos β)."""
        half = (1 / a + 1 / b) / 2
        mu = half * way * math.sin(beta) / (1 + half * way * math.cos(beta))
        energy = way * (math.sin(beta) - mu * math.cos(beta))
        return math.degrees(
            math.asin(float(np.clip(energy * (1 / a - 1 / b) / 2, -0.5, 0.5)))
        )

    slope, step = solve(plus, minus), 1e-3
    by_plus, by_minus = (
        (solve(plus + step, minus) - slope) / step,
        (solve(plus, minus + step) - slope) / step,
    )
    parts = by_plus**2 * share["+x"], by_minus**2 * share["-x"]
    sd = math.sqrt(sum(parts) + PRIORS["level"] ** 2)
    freedom = sum(parts) ** 2 / sum(
        v**2 / (len(values[s]) - 1) for v, s in zip(parts, ("+x", "-x"), strict=True)
    )
    return slope, sd, float(2 * stats.t.sf(abs(slope) / sd, freedom)), freedom


def _finding(
    names, p: float, slope: Parameter | None, bayes: float, notes, advice: str | None
) -> Finding:
    """A finding with a slope, or with none."""
    seen = slope if p < ALPHA else None
    alarm = seen is not None
    named = (
        {"slope": seen} if seen and bayes > 5 and seen.low95 * seen.high95 > 0 else {}
    )
    verdict = "name" if named else "class" if alarm else "none"
    sectors = (Sector("run-out", 1.0 if alarm else float("nan"), p),)
    return Finding(
        "roll",
        names,
        alarm,
        p,
        sectors,
        None,
        "",
        verdict,
        ("slope",) if alarm else (),
        bayes if alarm else float("nan"),
        bayes if alarm else float("nan"),
        named,
        None,
        None,
        (
            advice
            if not alarm
            else (
                None
                if named
                else "more run-outs in either direction, or a film of the roll"
            )
        ),
        notes=tuple(notes),
    )
