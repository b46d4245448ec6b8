"""Drops, from tracks to a finding: flights and impacts as one problem, and its
alternatives."""

import math
from functools import partial

import numpy as np

from benchtwin.bench.constants import G_M_S2
from benchtwin.bench.language import tr
from benchtwin.infer.conditions import Contact, conditions_of
from benchtwin.infer.effect import separating_recordings
from benchtwin.infer.evidence import Kind
from benchtwin.infer.explanation import (
    UNSHAPED,
    Alternative,
    Explanation,
    ln_bayes_bound,
)
from benchtwin.infer.finding import Curve, Finding
from benchtwin.infer.inference import finding_of
from benchtwin.infer.posterior import LISTED_ODDS
from benchtwin.infer.problem import Fit, Problem, fit, ln_evidence
from benchtwin.infer.task import DiagnosisTask
from benchtwin.rigs.drop import impact_problem
from benchtwin.rigs.drop.effects import EFFECTS
from benchtwin.rigs.drop.effects.impacts import SHAPE
from benchtwin.rigs.drop.effects.stated_height import RELEASE_HEIGHT
from benchtwin.rigs.drop.flight_model import Model, predict
from benchtwin.rigs.drop.impact_problem import elongation_of
from benchtwin.rigs.drop.impact_quantities import (
    elongation_test,
    impact_quantities,
)
from benchtwin.rigs.drop.impacts import Impacts, impacts_from_times
from benchtwin.rigs.drop.joint_problem import (
    JointModel,
    prepared_drops,
    session_fits,
    with_impacts,
)
from benchtwin.rigs.drop.nuisances import HEIGHT
from benchtwin.rigs.drop.track_noise import UNSEEN_M
from benchtwin.rigs.drop.unlisted import law_of, windows_of
from benchtwin.vision.motion.least_squares import slopes

RESTITUTION = Contact("restitution", "e", 1.0, "impact")
# what is unlisted, of another size in each flight
PUSHED = f"{UNSHAPED} flight: another push in each"
FEW = "too few impacts were seen to tell an effect from their scatter"
CONTRADICTION_SDS = 3.0  # of a stated height that the recordings contradict
AXES = ("place across", "height")


def diagnose_drop(tracks, rng: np.random.Generator) -> Finding:
    """Finding of drops (read.SeenTrack): with rows, or with times of impacts
    only."""
    usable = [t for t in tracks if not t.trouble]
    filmed, listened = (
        [t for t in usable if len(t.frame)],
        [t for t in usable if not len(t.frame) and len(t.contacts_s)],
    )
    if not filmed and not listened:
        raise ValueError(
            "; ".join(t.trouble for t in tracks if t.trouble) or tr("there is no drop")
        )
    told = {t.recording: t for t in usable}
    sounds = impacts_from_times(listened) if listened else None
    sessions, flights, notes = prepared_drops(filmed) if filmed else ((), None, ())
    alternatives, conditions, said = _alternatives(sessions, flights, sounds, told)
    notes = (*notes, *said)
    few = alternatives[0].problem.model.impacts is None
    contact = {} if few else {RESTITUTION.name: restitution}
    asked = DiagnosisTask(
        "drop",
        tuple(alternatives),
        windows_of,
        curves_of,
        contact,
        law_of,
        partial(separating_recordings, EFFECTS),
        (*notes, *((tr(FEW),) if few else ())),
        remarks,
        follows=(RESTITUTION, conditions),
    )
    return finding_of(asked, rng)


def _alternatives(sessions, flights: Fit | None, sounds: Impacts | None, told: dict):
    """Seeds as stated; and, if contacts lie too far from the centre for that, longer
    seeds."""
    names = tuple(n for s in sessions for n in s.problem.recordings) + (
        sounds.names if sounds else ()
    )
    about = [told[n] for n in names]
    conditions, notes = conditions_of(
        names, [t.description for t in about], [t.session for t in about]
    )
    z = np.hstack([c.columns(names) for c in conditions]) if conditions else None
    plain = with_impacts(flights, sessions, sounds, z)
    if plain is None:
        raise ValueError(
            tr("{}: the times of at least 5 impacts in all are needed", tr(FEW))
        )
    joint: JointModel = plain.model
    out = [Alternative(plain), *_pushed(plain)]
    if joint.impacts is None or all(
        (s.noise.sigma[:, 0] >= UNSEEN_M).all() for s in sessions
    ):
        return out, conditions, notes  # places across were not seen
    impacts = joint.impacts.impacts
    stated = elongation_of(impacts)
    shape = elongation_test(impacts, impact_quantities(impacts, stated), stated)
    if shape.p < 0.05:
        longer = with_impacts(flights, sessions, sounds, z, shape.elongation)
        assert longer is not None  # as above
        out.append(
            Alternative(
                longer,
                LISTED_ODDS,
                tr(
                    "contacts lie as far beside the centre as those of a seed of"
                    " elongation {:.2g}",
                    shape.elongation,
                ),
                (SHAPE.name,),
                sector=SHAPE.sector,
                ln_likelihood=ln_bayes_bound(shape.p) + _same(plain, longer),
                p=shape.p,
            )
        )
    return out, conditions, notes


def _pushed(plain: Problem) -> list[Alternative]:
    """The same, of flights that differ by more than flights do: its rows, which allow
    for that, do not tell. 1/B bounds how often noise gives a Bayes factor of B."""
    models = [part.model for part in plain.model.parts]
    beyond = max((model.own_beyond for model in models), default=0.0)
    if not beyond > 0:
        return []
    said, p = own_forces_in_words(models), math.exp(-beyond)
    return [
        Alternative(
            plain,
            LISTED_ODDS,
            said,
            (PUSHED,),
            Kind.UNLISTED,
            "flight",
            ln_likelihood=beyond,
            p=p,
        )
    ]


def _same(plain: Problem, longer: Problem) -> float:
    """ln likelihood of the plain baseline less that of the longer seed: scatter counts
    in p."""
    return ln_evidence(fit(plain)) - ln_evidence(fit(longer))


def restitution(e: Explanation) -> tuple[float, float]:
    """Mean over these impacts of what the explanation's laws give, and its sd."""
    joint: JointModel = e.fit.problem.model
    struck = joint.impacts_at(e.fit.starts, e.fit.values)
    assert joint.own_spot is not None  # called only with impacts
    at, count = e.fit.values[joint.own_spot], len(struck.e_rows)
    covariance = e.fit.covariance[np.ix_(joint.own_spot, joint.own_spot)]
    # of what happened, not of what was read
    told = np.array([not is_of_heights(n) for n in joint.own_names])

    def mean(values: np.ndarray) -> float:
        known = dict(zip(joint.own_names, told * values, strict=True))
        return float(impact_problem.predict(struck, known)[:count].mean())

    slope = slopes(mean, at, np.sqrt(np.diag(covariance)))[0]
    return mean(at), float(np.sqrt(slope @ covariance @ slope))


def is_of_heights(name: str) -> bool:
    """Whether a global says by how much stated heights are off."""
    return name.startswith((HEIGHT, RELEASE_HEIGHT))


def remarks(fit: Fit) -> tuple[str, ...]:
    """Notes on what differs from flight to flight, and on stated heights."""
    models = [part.model for part in fit.problem.model.parts]
    if not any(model.own_shown for model in models):
        return heights_in_words(fit)
    said, own = [own_forces_in_words(models)], _own_force(models)
    for model in models:
        for name, force in zip(model.session.names, model.own_force, strict=True):
            if force > own:
                said.append(
                    tr(
                        "{}: something of its own pushes it much harder than the other"
                        " flights (taken as {:.0f} times as hard), so that it counts"
                        " little",
                        name,
                        force / own,
                    )
                )
    return (*said, *heights_in_words(fit))


def _own_force(models: list[Model]) -> float:
    """Of each flight [m/s²], of those that are not odd."""
    return min(float(model.own_force.min()) for model in models)


def own_forces_in_words(models: list[Model]) -> str:
    """By how much flights differ, and why they may."""
    own = _own_force(models)
    return tr(
        "beside all that they have in common each flight is pushed by {:.2g} m/s²"
        " ({:.2g} % of its weight) of its own, another way each time: spin, a turning"
        " seed tracked beside its centre of mass, motion towards the camera, or seeds"
        " that differ",
        own,
        100 * own / G_M_S2,
    )


def heights_in_words(fit: Fit) -> tuple[str, ...]:
    """Stated heights that the recordings contradict, though not beyond what people
    err."""
    said = []
    for name, value in fit.by_name.items():
        usual = fit.problem.known_sd.get(name, 0.0)
        if not name.startswith(HEIGHT) or not usual:
            continue
        sd = fit.sd(name)
        if abs(value) > max(usual, CONTRADICTION_SDS * sd):
            session = name.partition(":")[2]
            where = tr(" of session {!r}", session) if session else ""
            low = tr("low") if value > 0 else tr("high")
            said.append(
                tr(
                    "the stated heights{} are {:.2g} ± {:.1g} mm {}",
                    where,
                    abs(value),
                    sd,
                    low,
                )
            )
    return tuple(said)


def curves_of(base: Fit, model: Fit) -> tuple[Curve, ...]:
    """Places over time, and restitution and kicks over impact speed, of each
    recording."""
    pairs = zip(session_fits(base), session_fits(model), strict=True)
    curves = [curve for pair in pairs for curve in _flight_curves(*pair)]
    if base.problem.model.impacts is not None:
        curves += _impact_curves(base, model)
    return tuple(curves)


def _flight_curves(before: Fit, after: Fit) -> list[Curve]:
    """Two curves a recording, across and up [mm], over the time [s] since its first
    row."""
    s = before.problem.model.session
    left = [
        1e3 * (s.places - predict(of.problem.model, of.starts, of.by_name)[0])
        for of in (before, after)
    ]
    time, whose = s.middle[s.flight] + s.tau, s.recording[s.flight]
    out = []
    for r, name in enumerate(s.names):
        rows = np.flatnonzero(whose == r)
        if not len(rows):
            continue  # none of its flights could be used
        rows = rows[np.argsort(time[rows], kind="stable")]
        for axis, quantity in enumerate(AXES):
            part = [values[rows, axis] for values in (1e3 * s.places, *left)]
            out.append(
                Curve(name, quantity, "mm", "t_s", time[rows] - time[rows].min(), *part)
            )
    return out


def _impact_curves(before: Fit, after: Fit) -> list[Curve]:
    models = [
        of.problem.model.impacts_at(of.starts, of.values) for of in (before, after)
    ]
    model, left = models[0], []
    for of, struck in zip((before, after), models, strict=True):
        at = {n: of.by_name[n] for n in of.problem.model.own_names}
        left.append(struck.y - impact_problem.predict(struck, at))
    out = []
    for r, recording in enumerate(model.impacts.names):
        for rows, first, quantity in (
            (model.e_rows, 0, "restitution"),
            (model.kick_rows, len(model.e_rows), tr("sideways kick")),
        ):
            own = np.flatnonzero(model.impacts.recording[rows] == r)
            if len(own):
                own = own[np.argsort(model.bounces.speed[rows[own]])]
                parts = [values[first + own] for values in (model.y, *left)]
                out.append(
                    Curve(
                        recording,
                        quantity,
                        "1",
                        "v_m_s",
                        model.bounces.speed[rows[own]],
                        *parts,
                    )
                )
    return out
