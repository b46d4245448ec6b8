"""What a verdict must not say: one of several that no recording at hand tells apart, or a library's name for what is outside it.

Angle offset, clock offset, adhesion under one load and a little added inertia all do one thing to a track: they scale the
acceleration after the onset, by cos θ₀, by 1/(1 + κ); at one rate so does, nearly, friction that grows with speed. Whichever
prior is wider must not decide between them.
"""

from dataclasses import replace

import numpy as np

from calibrate.diagnose.decide import LN_BF_RIVAL, Candidate, Verdict, possible
from calibrate.diagnose.effects.slide.stribeck import SHAPE, SPEED
from calibrate.diagnose.problem import Fit, Problem, fit
from calibrate.diagnose.slide.model import RIVAL

SCALING = ("angle-offset", "clock-offset", "adhesion", "partial-rolling")
ALSO_SCALING = (*SCALING, "viscous-sliding")
LN_BF_TWIN = 5.0  # the priors of twins differ by no more than that
ALIKE = 1.05  # rates, loads
FADES_OVER = np.arange(SPEED.low + 0.25, 0.0, 0.5)  # ln of speed scales, amid equal parts of their range
SLOWEST_LN = -1.5  # of the speed scale over 0.05 m/s: friction that is gone by 11 mm/s is as good as kinetic friction
RATE = "the same slide at three times the tilt rate: a clock's error in angle grows with the rate, a sensor's does not"
LOAD = "the same slide with one seed, and with eight seeds taped together: a pull counts for less the heavier the block"
LEVEL = "a reading of the tilt sensor on the plate levelled with a spirit level, and a ruler in the picture"


def honest(base: Fit, verdict: Verdict) -> Verdict:
    """The verdict with its twins, with none of the rivals outside the library, and with the recording that separates."""
    if verdict.verdict == "none":
        return verdict
    chosen = next((c for c in verdict.candidates if set(c.names) <= set(verdict.names)), None) if verdict.names else None
    if RIVAL.name in verdict.names:
        left = tuple(n for n in verdict.names if n != RIVAL.name)
        outside = verdict.verdict == "name" or chosen is None or RIVAL.name in chosen.names or not left
        if outside:
            return replace(verdict, verdict="unknown", names=(), next_record=_advice(base, ("viscous-sliding",)))
        verdict = replace(verdict, names=left)
    if verdict.verdict == "name" and chosen and "stribeck" in chosen.names:
        slow = fit(base.problem, free=chosen.names, start=base).by_name["stribeck.ln-speed"]
        if slow < SLOWEST_LN:
            verdict = replace(verdict, verdict="class", names=tuple(dict.fromkeys((*chosen.names, "kinetic-friction"))))
    if verdict.verdict == "name" and may_fade(base, verdict.names):
        verdict = replace(verdict, verdict="class", names=(*verdict.names, "stribeck"))
    members = tuple(dict.fromkeys((*verdict.names, *_also_scaling(chosen, verdict)))) if chosen else verdict.names
    if len(members) > len(verdict.names) and verdict.verdict in ("name", "class"):
        verdict = replace(verdict, verdict="class", names=members)
    if verdict.verdict == "class" or verdict.next_record:
        return replace(verdict, next_record=_advice(base, verdict.names) or verdict.next_record)
    return verdict


def _also_scaling(chosen: Candidate, verdict: Verdict) -> list[str]:
    """What might stand in the place of one of `chosen` that scales the acceleration, beside the same others."""
    out: list[str] = []
    for rival in verdict.candidates:
        mine, its = set(chosen.names) - set(rival.names), set(rival.names) - set(chosen.names)
        swapped = len(mine) == len(its) == 1 and mine <= set(SCALING) and its <= set(ALSO_SCALING)
        if swapped and rival.ln_bayes > chosen.ln_bayes - LN_BF_TWIN and possible(rival):
            out += its
    return out


def may_fade(base: Fit, names: tuple[str, ...]) -> bool:
    """Whether friction may as well fade over the first speeds as be lost at once: then it is not told, and less of it is lost.

    Mean over speed scales v_s of exp(-Δχ²/2) against e^-3, ln v_s as likely anywhere from the least that it physically may be to
    the typical one (what fades over more shows by itself); the candidate's own prior takes greater speeds for granted.
    """
    fading = tuple("stribeck" if n == "kinetic-friction" else n for n in names)
    if "kinetic-friction" not in names or "stribeck" in names or not set(fading) <= set(base.problem.effects):
        return False
    best = fit(base.problem, free=names, start=base)
    swap = {"stribeck": best.by_name["kinetic-friction"], "kinetic-friction": 0.0}
    near = replace(best, values=np.array([swap.get(n, v) for n, v in best.by_name.items()]))
    likely = 0.0
    for ln_speed in FADES_OVER:
        near = fit(_at_speed(base.problem, ln_speed), free=fading, start=near)
        likely += np.exp((best.chi2 - near.chi2) / 2) / len(FADES_OVER)
    return not likely < np.exp(-LN_BF_RIVAL)


def _at_speed(problem: Problem, ln_speed: float) -> Problem:
    """The problem where friction fades over that speed, in the typical way."""
    at = np.where(np.array(problem.names) == SPEED.name, ln_speed, 0.0)

    def reduce(starts, values, extra=None):
        reduced, change = problem.reduce(starts, values + at, extra)
        return tuple(replace(r, b=r.b - r.a[:, : len(at)] @ at) for r in reduced), change

    held = {n: e for n, e in problem.effects.items() if n not in (SPEED.name, SHAPE.name)}  # no candidates: they stay as they are
    return replace(problem, effects=held, reduce=reduce, elsewhere=(), cheap=None)


def _advice(base: Fit, names: tuple[str, ...]) -> str | None:
    """The recordings that tell these apart and are not at hand yet."""
    session, effects = base.problem.model.session, base.problem.effects
    one_rate = len(session.rates) and session.rates.max() < ALIKE * session.rates.min()
    one_load = not np.isfinite(session.masses).all() or session.masses.max() < ALIKE * session.masses.min()
    out = []
    if one_rate and {"clock-offset", "reading-delay"} & set(names):
        out.append(RATE)
    if one_load and "adhesion" in names:
        out.append(LOAD)
    if {"angle-offset", "partial-rolling"} & set(names):
        out.append(LEVEL)
    wanted = sorted(names, key=lambda n: n != "reading-delay")  # whose advice holds for its rivals too
    out = out or [effects[n].separating for n in wanted if n in effects and effects[n].separating][:1]
    return "; ".join(out) or None
