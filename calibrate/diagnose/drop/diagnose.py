"""Drops, from tracks to a finding: flight and picture first, then, with what was found there allowed for, the impacts."""

from dataclasses import replace

import numpy as np

from calibrate.diagnose.air import air_of
from calibrate.diagnose.decide import ALPHA
from calibrate.diagnose.drop.curves import curves_of
from calibrate.diagnose.drop.impact_diagnosis import diagnose_impacts, with_law
from calibrate.diagnose.drop.impacts import Impacts, heard, impacts_of, joined
from calibrate.diagnose.drop.merge import merged
from calibrate.diagnose.drop.sessions import Sitting, all_windows, joint_problem, parts_of, sittings_of
from calibrate.diagnose.drop.unnamed import law_of_flights
from calibrate.diagnose.finding import Finding, credited, finding_of
from calibrate.diagnose.locate import locate
from calibrate.diagnose.name import name
from calibrate.diagnose.problem import Fit, fit

LEAST_IMPACTS = 3
FLIGHTS = 0.25  # of the chance of a false alarm: a threshold costs hundreds of rows less of what they can show than a few bounces
NEARER = "camera.distance_mm is not stated: a seed that comes nearer to the camera looks as if a force drove it"
FEW = "too few impacts were seen to tell an effect from their scatter"


def diagnose_drop(tracks, rng: np.random.Generator) -> Finding:
    """Finding of all drops of a bench (calibrate.twin.tracks.SeenTrack, of one session or several; those in trouble are left out;
    those without rows have the times of their impacts only). ValueError where nothing can be used."""
    usable = [t for t in tracks if not t.trouble]
    filmed, listened = [t for t in usable if len(t.frame)], [t for t in usable if not len(t.frame) and len(t.contacts_s)]
    if not filmed and not listened:
        raise ValueError("; ".join(t.trouble for t in tracks if t.trouble) or "there is no drop")
    if not filmed:
        return _of_sound(listened, rng)
    sittings, notes = sittings_of(filmed)
    flights = fit(joint_problem(tuple(s.problem for s in sittings)))
    hit = any(len(s.problem.model.session.joint) >= 1 for s in sittings) or bool(listened)
    alpha = FLIGHTS * ALPHA if hit else ALPHA
    where = locate(flights, all_windows(flights), rng)
    found = name(flights, where, rng, alpha=alpha)
    where = credited(where, flights, found)
    finding = replace(finding_of(flights, where, found, notes=notes, draw=_curves), alarm=found.p_global < alpha)
    if found.verdict == "unknown":
        finding = with_law(finding, law_of_flights(flights))
        near = all(np.isinf(s.problem.model.session.away).all() for s in sittings) and hit
        finding = replace(finding, notes=(*finding.notes, NEARER)) if near else finding
    if not hit:
        return finding
    below = diagnose_impacts(_impacts(flights, sittings, found, listened), rng, alpha=(1 - FLIGHTS) * ALPHA)
    if below is None:
        return replace(finding, p_global=min(1.0, finding.p_global / FLIGHTS), notes=(*finding.notes, FEW))
    return merged(finding, where, *below, share=FLIGHTS)


def _impacts(flights: Fit, sittings: tuple[Sitting, ...], found, listened) -> Impacts:
    """From the flights as they are once what was found there is allowed for: all members of a class, for none is known."""
    free = tuple(n for n in found.names if n in flights.problem.effects)
    at = fit(flights.problem, free=free, start=flights) if free else flights
    parts = [impacts_of(part, s.noise, s.tracks) for part, s in zip(parts_of(at), sittings, strict=True)]
    return joined([*parts, _heard(listened)] if listened else parts)


def _heard(listened) -> Impacts:
    about = [t.description for t in listened]
    return heard(tuple(t.recording for t in listened), [t.contacts_s for t in listened], about, [air_of(d) for d in about])


def _of_sound(listened, rng: np.random.Generator) -> Finding:
    """The times of impacts alone: restitution is all that they tell."""
    told = diagnose_impacts(_heard(listened), rng)
    if told is None:
        raise ValueError(f"{FEW}: the times of at least {LEAST_IMPACTS + 2} impacts in all are needed")
    return told[0]


def _curves(before: Fit, after: Fit):
    pairs = zip(parts_of(before), parts_of(after), strict=True)
    return tuple(curve for one, two in pairs for curve in curves_of(one, two))
