"""Rolls, from recordings to a finding."""

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.infer.conditions import Contact, conditions_of
from benchtwin.infer.effect import separating_recordings
from benchtwin.infer.explanation import Alternative, Explanation
from benchtwin.infer.finding import Curve, Finding
from benchtwin.infer.inference import finding_of
from benchtwin.infer.problem import Fit, Problem, fit
from benchtwin.infer.task import DiagnosisTask
from benchtwin.rigs.roll.effects import EFFECTS
from benchtwin.rigs.roll.model import run_motion
from benchtwin.rigs.roll.problem import build, roll_problem
from benchtwin.rigs.roll.readings import (
    LEAST_READINGS,
    no_windows,
    ruler_problem,
    rulers_of,
)
from benchtwin.rigs.roll.readings import curves_of as readings_curves
from benchtwin.rigs.roll.run_noise import RunNoise, first_noise, noise_of
from benchtwin.rigs.roll.session import Run, Seed, assemble
from benchtwin.rigs.roll.unlisted import (
    SEEN_P,
    arguments,
    find_ripple,
    law_of,
    windows_of,
)

BOTH_WAYS = (
    "the same plate run the other way: one direction alone cannot tell a slope of the"
    " level from rolling friction"
)
OTHER_LENGTH = (
    "the same roll from an incline of twice the length: this separates dependence on"
    " speed from dependence on place"
)


def diagnose_roll(recordings, rng: np.random.Generator) -> Finding:
    """Finding of recordings (read.SeenRoll); ValueError where none can be
    used."""
    usable = [r for r in recordings if not r.trouble]
    if not any(len(r.x_mm) for r in usable):
        return diagnose_readings(usable, rng)
    runs, seed, notes = assemble(usable)
    problem, base, said_of_shape = baseline(runs, seed, scales_of(usable), rng)
    notes = (*notes, *said_of_shape)
    told = {r.recording: r for r in usable}
    about = [told[run.recording] for run in runs]
    conditions, said = conditions_of(
        problem.recordings, [r.description for r in about], [r.session for r in about]
    )
    friction = Contact("rolling_friction", "mu", base.problem.model.mu, "run-out")
    one_way = len({run.sign for run in runs}) < 2

    def advice(names: tuple[str, ...]) -> str | None:
        return (
            separating_recordings(EFFECTS, names)
            if names
            else tr(BOTH_WAYS)
            if one_way
            else tr(OTHER_LENGTH)
        )

    asked = DiagnosisTask(
        "roll",
        (Alternative(problem),),
        windows_of,
        curves_of,
        {friction.name: rolling_friction},
        law_of,
        advice,
        (*notes, *said, *corner_notes(base)),
        follows=(friction, conditions),
    )
    return finding_of(asked, rng)


def scales_of(recordings) -> dict[str, float]:
    """Relative sd of the scale, by session."""
    scales: dict[str, float] = {}
    for r in (r for r in recordings if len(r.x_mm)):
        sd = float(r.description["camera"]["scale_sd"])
        scales[r.session] = max(scales.get(r.session, 0.0), sd)
    return scales


def baseline(
    runs: tuple[Run, ...],
    seed: Seed,
    scales: dict[str, float],
    rng: np.random.Generator,
) -> tuple[Problem, Fit, tuple[str, ...]]:
    """The problem, with the ripple of an oblong seed where the runs show one, the fit
    with nothing missing and without ripple, and notes."""
    noise, (turn, phase) = session_noise(runs, seed, scales), arguments(runs, seed)
    problem = roll_problem(build(runs, seed, turn, phase, ripple=False), scales, noise)
    base = fit(problem)
    ripple = find_ripple(base, rng)
    if ripple.p >= SEEN_P:
        return problem, base, ()
    model = build(runs, seed, ripple.turn, ripple.phase, ripple=True)
    notes = (
        (
            tr(
                "Each seed climbs and falls twice a turn, as its stated shape (a rise"
                " of {:.2g} mm) lets it.",
                seed.rise_mm,
            )
        ),
    )
    stated = np.isfinite(seed.rise_mm) and not seed.round
    return roll_problem(model, scales, noise), base, notes if stated else ()


def session_noise(
    runs: tuple[Run, ...], seed: Seed, scales: dict[str, float]
) -> RunNoise:
    """Noise about the fit with nothing missing; a ripple is not taken for noise."""
    first = first_noise(runs)
    model = build(runs, seed, *arguments(runs, seed), ripple=True)
    return noise_of(fit(roll_problem(model, scales, first)), first)


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
            tr(
                "The corner takes {:.2g} % of the speed: no more than a sharp corner"
                " may.",
                100 * lost[1],
            )
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


def diagnose_readings(recordings, rng: np.random.Generator) -> Finding:
    """Finding of run-outs that were read off; ValueError where they tell nothing."""
    rulers, notes = rulers_of(recordings)
    problem = ruler_problem(rulers)
    conditions, said = conditions_of(
        problem.recordings,
        [one.description for one in rulers],
        [one.session for one in rulers],
    )
    friction = Contact("rolling_friction", "mu", problem.model.mu, "run-out")
    if not problem.effects and not conditions:
        raise ValueError(
            tr(
                "run-outs alone tell nothing of what is missing; {} readings in either"
                " direction would tell a slope: record {}, or film the roll",
                LEAST_READINGS,
                tr(BOTH_WAYS),
            )
        )
    asked = DiagnosisTask(
        "roll",
        (Alternative(problem),),
        no_windows,
        readings_curves,
        {friction.name: rolling_friction},
        advice=lambda names: tr(
            "a film of the roll, which shows more than its run-out"
        ),
        notes=(*notes, *said),
        follows=(friction, conditions),
    )
    return finding_of(asked, rng)
