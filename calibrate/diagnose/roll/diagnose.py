"""Rolls, from recordings to a finding."""

from dataclasses import replace
from functools import partial

import numpy as np

from calibrate.diagnose.decide import ALPHA, LN_BF_RIVAL, Verdict
from calibrate.diagnose.finding import NORMAL_95, Finding, Parameter, finding_of
from calibrate.diagnose.locate import Location, locate
from calibrate.diagnose.name import name
from calibrate.diagnose.problem import Fit, fit
from calibrate.diagnose.roll.curves import curves_of
from calibrate.diagnose.roll.law import law_of, named_and_nameless
from calibrate.diagnose.roll.problem import MU_SD, build, roll_problem, scatter_of
from calibrate.diagnose.roll.readings import diagnose_readings
from calibrate.diagnose.roll.ripple import (
    Ripple,
    arguments,
    as_seen,
    as_stated,
    common_rise,
    find_ripple,
    held_out_rise,
    left_out_rise,
    of_this_size,
)
from calibrate.diagnose.roll.rough import roughness
from calibrate.diagnose.roll.session import assemble
from calibrate.diagnose.roll.windows import sectors_of, windows_of

BOTH_WAYS = "the same plate run the other way: one direction alone cannot tell a slope of the level from rolling friction"


OTHER_LENGTH = "the same roll from an incline of twice the length: what depends on speed parts from what depends on place"
OF_SPEED = ("viscous-rolling", "drag")  # along one way a seed's speed and place go together


def diagnose_roll(recordings, rng: np.random.Generator) -> Finding:
    """Finding of recordings (calibrate.twin.roll_tracks.SeenRoll); ValueError where none can be used."""
    usable = [r for r in recordings if not r.trouble]
    if not usable:
        raise ValueError("none of the recordings can be used")
    if not any(len(r.x_mm) for r in usable):
        return diagnose_readings(usable)
    runs, seed, notes = assemble(usable)
    scales = _scales(usable)
    turn, phase = arguments(runs, seed)
    plain = partial(roll_problem, build(runs, seed, turn, phase, ripple=False), scales)
    base = fit(plain())
    scatter = scatter_of(base)
    if scatter > MU_SD:
        base = fit(plain(mu_sd=scatter))
        notes += (f"rolling friction differs by {100 * scatter:.2g} % from run to run, which is taken for the seeds' own",)
    ripple = find_ripple(base, rng)
    rough = roughness(base if ripple.p >= ALPHA else _rippled(runs, seed, scales, ripple, scatter))
    if rough.any():
        base = fit(plain(mu_sd=scatter, rough=rough))
        share = 100 * float(np.median(rough)) / base.problem.model.mu
        notes += (
            f"friction changes by {share:.2g} % along each run's own way, which is taken for the seeds' own: they are no balls",
        )
        ripple = find_ripple(base, rng)
    news: Ripple | None = ripple
    if ripple.p < ALPHA:
        base, more, news = _with_ripple(runs, seed, scales, ripple, scatter, rough)
        notes += more
    notes += usual_loss_of(base)
    where = _located(base, news, rng)
    found = _held_against_the_nameless(base, name(base, where, rng))
    return _finding(base, where, found, notes, rng)


def lost_at_corner(found: Fit) -> tuple[float, float]:
    """Share of the speed that the corner takes in all, mean over the runs, and its sd."""
    at, model, names = found.by_name, found.problem.model, ("corner-loss", "corner")
    usual = [float(np.mean([model.usual_loss(r, at["corner"] + d) for r in range(len(model.runs))])) for d in (-0.01, 0.0, 0.01)]
    slope = np.array([1.0, (usual[2] - usual[0]) / 0.02])
    rows = [found.names.index(n) for n in names]
    return at["corner-loss"] + usual[1], float(np.sqrt(slope @ found.covariance[np.ix_(rows, rows)] @ slope))


def usual_loss_of(base: Fit) -> tuple[str, ...]:
    """What the corner takes by itself, where it is seen: no news, but to be known."""
    lost, sd = lost_at_corner(base)
    if lost < 3 * sd:
        return ()
    return (f"the corner takes {100 * lost:.2g} % of the speed, no more than a sharp one may: no news",)


def _scales(recordings) -> dict[str, float]:
    """sd of the scale, relative, of each session."""
    out: dict[str, float] = {}
    for r in recordings:
        if len(r.x_mm):
            out[r.session] = max(out.get(r.session, 0.0), float(r.description["camera"]["scale_sd"]))
    return out


def _rippled(runs, seed, scales, ripple: Ripple, scatter: float) -> Fit:
    """With a ripple as great as it likes: what is rough must be so beside it."""
    model = build(runs, seed, ripple.turn, ripple.phase, ripple=True)
    return fit(roll_problem(model, scales, mu_sd=scatter), free=("shape-barrier",))


def _with_ripple(
    runs, seed, scales, ripple: Ripple, scatter: float, rough: np.ndarray
) -> tuple[Fit, tuple[str, ...], Ripple | None]:
    """A baseline beside which the ripple is a candidate; or, where the stated shape makes such a ripple, with it."""
    model = build(runs, seed, ripple.turn, ripple.phase, ripple=True)
    problem = roll_problem(model, scales, mu_sd=scatter, rough=rough)
    freed = fit(problem, free=("shape-barrier",))
    rise, sd, _ = common_rise(freed)
    if not as_stated(rise, sd, seed):
        return fit(of_this_size(problem, freed)), (), ripple
    note = f"the centre rises by {rise:.2g} mm as the seed turns, as its stated shape makes it ({seed.rise_mm:.2g} mm): no news"
    return fit(roll_problem(model, scales, shape_known=seed.rise_mm, mu_sd=scatter, rough=rough)), (note,), None


def _located(base: Fit, ripple: Ripple | None, rng: np.random.Generator) -> Location:
    """Window, excess and p as everywhere; sectors freed in windows; a ripple that was looked for by itself counts as well."""
    where = locate(base, windows_of(base), rng)
    p = where.p if ripple is None else min(1.0, 2 * min(where.p, ripple.p))
    return replace(where, p=p, sectors=sectors_of(base, rng))


def _held_against_the_nameless(base: Fit, found: Verdict) -> Verdict:
    """Unknown where a law that no candidate stands for (resistance in one part of the plate, growing with travel or time) does
    clearly better than what was named; a class of what grows with speed where it does as well."""
    if found.verdict not in ("name", "class"):
        return found
    best = max((c for c in found.candidates if set(c.names) <= set(found.names)), key=lambda c: c.ln_bayes)
    named, nameless = named_and_nameless(base, fit(base.problem, free=best.names, start=base))
    if nameless > named + LN_BF_RIVAL:
        return replace(found, verdict="unknown", names=())
    if found.verdict == "name" and nameless > named - LN_BF_RIVAL and set(found.names) <= set(OF_SPEED):
        present = tuple(n for n in OF_SPEED if n in base.problem.effects)
        return replace(found, verdict="class", names=present, next_record=OTHER_LENGTH)
    return found


def _finding(base: Fit, where: Location, found: Verdict, notes: tuple[str, ...], rng: np.random.Generator) -> Finding:
    where = _with_its_sector_first(base, where, found)
    model = fit(base.problem, free=found.names, start=base) if found.names else None
    law = law_of(base, where) if found.verdict == "unknown" else None
    found = _next(base, found)
    made = finding_of(base, where, found, law=law, curves=curves_of(base, model), notes=notes)
    return made if model is None else _reported(made, base, model)


def _reported(made: Finding, base: Fit, model: Fit) -> Finding:
    """With a ripple's rise and all that the corner takes, for which several globals stand."""
    if "shape-barrier" in made.parameters:
        rise, sd, scatter = common_rise(as_seen(model))
        half = NORMAL_95 * float(np.hypot(sd, scatter / np.sqrt(len(base.problem.recordings))))
        told = {"shape-barrier": Parameter("mm", rise, max(rise - half, 0.0), rise + half)}
        made = replace(made, parameters=made.parameters | told)
    if "corner-loss" in made.parameters:
        lost, sd = lost_at_corner(model)
        told = {"corner-loss": Parameter("1", lost, lost - NORMAL_95 * sd, lost + NORMAL_95 * sd)}
        made = replace(made, parameters=made.parameters | told)
    if "shape-barrier" in made.left_out:
        made = replace(made, left_out=made.left_out | {"shape-barrier": left_out_rise(as_seen(model))})
        made = replace(made, held_out=held_out_rise(as_seen(model), base))
    return made


def _with_its_sector_first(base: Fit, where: Location, found: Verdict) -> Location:
    """A named effect has its own sector, where that explains the excess as well as any other does."""
    own = [base.problem.effects[n].sector for n in found.names if n in base.problem.effects]
    mine = [s for s in where.sectors if s.name in own and s.explained > 0.5]
    return replace(where, sectors=tuple([*mine, *(s for s in where.sectors if s not in mine)]))


def _next(base: Fit, found: Verdict) -> Verdict:
    """What to record next: for rolls, not for drops."""
    one_way = len({run.sign for run in base.problem.model.runs}) < 2
    if found.verdict == "unknown":
        return replace(found, next_record=OTHER_LENGTH)
    if found.verdict == "class" and found.next_record and "drop" in found.next_record:
        return replace(found, next_record=BOTH_WAYS if one_way else "more recordings of the same roll")
    return replace(found, next_record=BOTH_WAYS) if found.verdict == "none" and one_way else found
