"""Drops, from tracks to a finding: flights and impacts as one problem, and the alternatives of its baseline."""

from dataclasses import replace
from functools import partial

import numpy as np

from diagnose.effects.drop import EFFECTS
from diagnose.effects.drop.shape_conversion import SHAPE
from diagnose.effects.effect import separating_recordings
from diagnose.engine.conditions import Contact, conditions_of, with_conditions
from diagnose.engine.posterior import LISTED_ODDS, Alternative, Explanation, of_p_value
from diagnose.engine.problem import Fit, Problem, fit, ln_evidence
from diagnose.finding import Curve, Finding, Question, answer
from diagnose.rigs.drop import impact_problem
from diagnose.rigs.drop.bounce import bounces_of
from diagnose.rigs.drop.curves import curves_of, impact_curves
from diagnose.rigs.drop.impact_problem import elongation_of
from diagnose.rigs.drop.impacts import Impacts, heard
from diagnose.rigs.drop.joint import Joint, Sitting, flown, moved_to, parts_of, sittings_of, with_impacts
from diagnose.rigs.drop.noise_of_track import UNSEEN_M
from diagnose.rigs.drop.nuisances import DISTANCES_M
from diagnose.rigs.drop.shape import shape_of
from diagnose.rigs.drop.unlisted import law_in_words, windows_of

RESTITUTION = Contact("restitution", "e", 0.1, 1.0, "impact", "restitution")
WORTH = 1e-3  # weight of a distance, beside the likeliest, below which it is left
FEW = "too few impacts were seen to tell an effect from their scatter"


def diagnose_drop(tracks, rng: np.random.Generator) -> Finding:
    """Finding of all drops of a bench (twin.tracks.SeenTrack, of one session or several; those in trouble are left out;
    those without rows have the times of their impacts only). ValueError where nothing can be used."""
    usable = [t for t in tracks if not t.trouble]
    filmed, listened = [t for t in usable if len(t.frame)], [t for t in usable if not len(t.frame) and len(t.contacts_s)]
    if not filmed and not listened:
        raise ValueError("; ".join(t.trouble for t in tracks if t.trouble) or "there is no drop")
    told = {t.recording: t for t in usable}
    sounds = heard(listened) if listened else None
    baselines, notes = _distances(filmed) if filmed else ([((), None, 1.0)], ())
    alternatives: list[Alternative] = []
    for sittings, flights, odds in baselines:
        made, said = _alternatives(sittings, flights, sounds, told, odds)
        alternatives += made
        notes = (*notes, *(n for n in said if n not in notes))
    few = alternatives[0].problem.model.impacts is None
    contact = {} if few else {RESTITUTION.name: restitution}
    asked = Question(
        "drop", tuple(alternatives), windows_of, _curves, contact, law_in_words, partial(separating_recordings, EFFECTS),
        (*notes, *((FEW,) if few else ())),
    )  # fmt: skip
    return answer(asked, rng)


def _distances(filmed) -> tuple[list[tuple[tuple[Sitting, ...], Fit, float]], tuple[str, ...]]:
    """(sessions, flights fitted, odds) at every distance that the camera may stand at; one where all state theirs."""
    stated = all(t.description["camera"].get("distance_mm") for t in filmed)
    sittings, notes = sittings_of(filmed, np.inf if stated else DISTANCES_M[-1])
    if stated:
        return [(sittings, flown(sittings), 1.0)], notes
    found: list[tuple[tuple[Sitting, ...], Fit, float]] = []
    level: list[float] = []
    for away in DISTANCES_M[::-1]:  # the nearer the camera, the more it allows for: what is too near stays so
        moved = sittings if not found else tuple(moved_to(s, away) for s in sittings)
        found.append((moved, flown(moved, found[-1][1] if found else None), 1 / len(DISTANCES_M)))
        level.append(ln_evidence(found[-1][1]))
        if level[-1] < max(level) + np.log(WORTH):
            break
    return [one for one, value in zip(found, level, strict=True) if value > max(level) + np.log(WORTH)], notes


def _alternatives(sittings, flights: Fit | None, sounds: Impacts | None, told: dict, odds: float):
    """The seeds as stated; and as long as their contacts show, where they lie further beside the centre than stated axes reach."""
    names = tuple(n for s in sittings for n in s.problem.recordings) + (sounds.names if sounds else ())
    about = [told[n] for n in names]
    follows, notes = conditions_of([t.description for t in about], [t.session for t in about])
    z = np.hstack([c.z for c in follows]) if follows else None
    plain = with_impacts(flights, sittings, sounds, z)
    if plain is None:
        raise ValueError(f"{FEW}: the times of at least 5 impacts in all are needed")
    kept = [names.index(n) for n in plain.recordings]
    follows = tuple(replace(c, z=c.z[kept]) for c in follows)
    out = [Alternative(with_conditions(plain, RESTITUTION, follows), odds)]
    joint: Joint = plain.model
    if joint.impacts is None or all((s.noise.sigma[:, 0] >= UNSEEN_M).all() for s in sittings):
        return out, notes  # nobody looked how far beside their centre seeds are struck
    impacts = joint.impacts.impacts
    stated = elongation_of(impacts)
    shape = shape_of(impacts, bounces_of(impacts, stated), stated)
    if shape.p < 0.05:
        longer = with_impacts(flights, sittings, sounds, z, shape.elongation)
        assert longer is not None  # the impacts are enough, as above
        out.append(Alternative(
            with_conditions(longer, RESTITUTION, follows), odds * LISTED_ODDS,
            f"contacts lie as far beside the centre as those of a seed of elongation {shape.elongation:.2g}",
            (SHAPE.name,), SHAPE.sector, {}, of_p_value(shape.p) + _same(plain, longer), shape.p,
        ))  # fmt: skip
    return out, notes


def _same(plain: Problem, longer: Problem) -> float:
    """Takes the likelihood of the impacts' rows about each baseline out of the comparison: the wider scatter of a longer seed would be
    counted twice, here and in the p value."""
    return ln_evidence(fit(plain)) - ln_evidence(fit(longer))


def restitution(e: Explanation) -> tuple[float, float]:
    """Mean over these impacts of what the explanation's laws say, and its sd."""
    joint: Joint = e.fit.problem.model
    struck = joint.struck(e.fit.starts, e.fit.values)
    assert joint.own_spot is not None  # asked for where there are impacts
    at, count = e.fit.values[joint.own_spot], len(struck.e_rows)

    def mean(values: np.ndarray) -> float:
        return float(impact_problem.predict(struck, dict(zip(joint.own_names, values, strict=True)))[:count].mean())

    here = mean(at)
    slope = np.array([(mean(at + 1e-4 * unit) - here) / 1e-4 for unit in np.eye(len(at))])
    return here, float(np.sqrt(slope @ e.fit.covariance[np.ix_(joint.own_spot, joint.own_spot)] @ slope))


def _curves(base: Fit, model: Fit) -> tuple[Curve, ...]:
    pairs = zip(parts_of(base), parts_of(model), strict=True)
    flights = tuple(curve for one, two in pairs for curve in curves_of(one, two))
    return (*flights, *impact_curves(base, model)) if base.problem.model.impacts is not None else flights
