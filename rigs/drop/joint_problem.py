"""All drops of a bench as one problem: flights by session, impacts at the fitted
speeds.

Each session has its own camera, so effects of the picture or the clock have one value a
session, freed together; reported is that of the session with most rows. Impacts are
computed anew from the flights at every linearisation; the flights' uncertainty is in
their covariance."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.linalg import block_diag

from benchtwin.bench.language import tr
from benchtwin.bench.priors import FARTHEST_M, NEAREST_M, unstated_sd
from benchtwin.infer.effect import Effect
from benchtwin.infer.evidence import PRIOR_WIDTHS, UnknownScatter
from benchtwin.infer.linear import Reduced, ridge, stacked
from benchtwin.infer.own_scatter import own_scatter
from benchtwin.infer.problem import Fit, Problem, fit
from benchtwin.rigs.drop import impact_problem
from benchtwin.rigs.drop.flight_model import LAWS, OWN, STARTS, Model, build
from benchtwin.rigs.drop.impact_problem import ImpactModel, updated
from benchtwin.rigs.drop.impacts import (
    Impacts,
    concatenated,
    impacts_of,
    speeds_at_contacts,
    subset,
    usable_rows,
    with_speeds,
)
from benchtwin.rigs.drop.nuisances import APPROACH, READOUT
from benchtwin.rigs.drop.reduction import MAX_ITERATIONS, problem_of
from benchtwin.rigs.drop.second_contacts import without_second_contacts
from benchtwin.rigs.drop.session import Session, assemble, block_of
from benchtwin.rigs.drop.track_noise import TrackNoise, estimate_noise

WIDEST = max(PRIOR_WIDTHS)  # of an effect, times its usual size
DISTANCES_M = np.geomspace(FARTHEST_M, NEAREST_M, 10)
TOO_NEAR = 12.0  # ln of the likelihood below the greatest, as no greater one follows
ODD_FLIGHTS = 0.03  # share of recordings that are pushed otherwise than the others
# m/s², of a force on each flight of its own, which is a finding and no scatter: a
# thirtieth of the weight, beside .05 to .15 (at most .3) in real tosses
MOST_OWN = 0.3
READOUT_STEP_S = 1e-5  # for derivatives
TOLD = 3  # flights of each recording that tell forces: a force shows by length squared


@dataclass(frozen=True, eq=False)
class PreparedSession:
    """One session: its tracks, their noise, the problem of its flights."""

    tracks: tuple
    noise: TrackNoise
    problem: Problem


def prepare_sessions(
    tracks, unstated_m: float = np.inf
) -> tuple[tuple[PreparedSession, ...], tuple[str, ...]]:
    """One a session, and notes on those left out; ValueError where none can be used."""
    found, notes = [], []
    for session in dict.fromkeys(t.session for t in tracks):
        own = tuple(t for t in tracks if t.session == session)
        try:
            seen = assemble(own, unstated_m, 0.0)
            noise = estimate_noise(seen)
            own, twice = without_second_contacts(own, seen, noise)
            if twice or any(block_of(t) > 1 for t in own if not t.trouble):
                seen = assemble(own, unstated_m)
                noise = estimate_noise(seen)
        except ValueError as error:
            notes.append(
                tr("session {!r} left out: {}", session, error)
                if session
                else str(error)
            )
            continue
        notes += [*seen.notes, *twice]
        found.append(PreparedSession(own, noise, problem_of(build(seen), noise)))
    if not found:
        raise ValueError("; ".join(notes) or tr("no drop was filmed"))
    return tuple(found), tuple(notes)


def prepared_drops(
    tracks,
) -> tuple[tuple[PreparedSession, ...], Fit, tuple[str, ...]]:
    """The sessions with what differs from flight to flight as great as they show it
    (motion towards a camera whose distance is not stated, own forces); their flights,
    fitted with nothing missing; notes."""
    stated = all(t.description["camera"].get("distance_mm") for t in tracks)
    sessions, notes = prepare_sessions(tracks, np.inf if stated else FARTHEST_M)
    if not stated:
        sessions = tuple(map(with_distance, sessions))
    flights = fit_flights(sessions)
    found = with_own_forces(sessions, flights)
    return found, fit_flights(found, flights), notes


def with_distance(session: PreparedSession) -> PreparedSession:
    """The same session at the distance at which motion towards the camera is as visible
    as these recordings show it, effects being free: the root of the mean square of
    1/distance, log-uniform beforehand."""
    ln: list[float] = []
    flights = None
    for away in DISTANCES_M:  # from far to near, until one is too near
        flights = fit_flights((_at_distance(session, away),), flights)
        ln.append(_ln_restricted(flights))
        if ln[-1] < max(ln) - TOO_NEAR:
            break
    weight = np.exp(np.array(ln) - max(ln))
    away = float((weight @ DISTANCES_M[: len(ln)] ** -2 / weight.sum()) ** -0.5)
    return _at_distance(session, away)


def _at_distance(prepared: PreparedSession, away_m: float) -> PreparedSession:
    """The same session with another distance where none is stated."""
    model: Model = prepared.problem.model
    used = [t for t in prepared.tracks if not t.trouble]
    stated = [bool(t.description["camera"].get("distance_mm")) for t in used]
    away = np.where(stated, model.session.away, away_m)
    moved = replace(model, session=replace(model.session, away=away))
    return replace(prepared, problem=problem_of(moved, prepared.noise))


def _ln_restricted(at: Fit) -> float:
    """ln of the likelihood, locals and globals integrated out, linearised at a fit."""
    reduced, wide = at.reduced, _wide_sds(at)
    left = ridge(*stacked(reduced), wide)
    kept = wide > 0
    scaled = left[1][np.ix_(kept, kept)] / np.outer(wide[kept], wide[kept])
    own = sum(r.half_ln_det for r in reduced)
    return -0.5 * left[2] + 0.5 * float(np.linalg.slogdet(scaled)[1]) - own


def _wide_sds(of: Fit) -> np.ndarray:
    """Prior sds (G,) of the globals where effects are free, too, each within WIDEST
    times its usual size."""
    effects = of.problem.effects
    usual = [effects[n].prior_sd if n in effects else 0.0 for n in of.names]
    return of.baseline_sd + WIDEST * np.array(usual)


def with_own_forces(
    sessions: tuple[PreparedSession, ...], flights: Fit
) -> tuple[PreparedSession, ...]:
    """The same sessions, each flight with a force of its own, of the size that these
    recordings show; flights: as fitted without.

    Free beside it is what flights of one number have in common (the falls, the first
    rebounds), and so are effects, each within WIDEST times its usual size."""
    joint: JointModel = flights.problem.model
    pushes = [_by_number(part.model.session) for part in joint.parts]
    reduced = flights.problem.reduce(flights.starts, flights.values, (pushes, None))[0]
    width, count = len(flights.values), len(pushes[0])
    wide = _wide_sds(flights)

    made = [
        replace(r, a=np.hstack([r.a[:, :width] * wide, r.a[:, width:], r.a[:, width:]]))
        for r in reduced
    ]
    known = np.eye(width, width + 2 * count)
    made.append(Reduced(known, np.zeros((width, 0)), np.zeros(width)))
    usual = np.full(count, unstated_sd("own-force"))
    own = own_scatter(tuple(made), width + count, usual, True, ODD_FLIGHTS, MOST_OWN)
    times = own.times[:-1]  # of all but what was made of the priors
    by_name = dict(zip(joint.recordings, own.sd[0] * times, strict=True))

    def of_each(names: tuple[str, ...]) -> np.ndarray:
        return np.array([by_name.get(name, own.sd[0]) for name in names])

    models = [
        replace(
            model,
            own_force=of_each(model.session.names),
            own_shown=own.shown,
            own_beyond=own.beyond,
        )
        for model in (s.problem.model for s in sessions)
    ]
    return tuple(
        replace(s, problem=problem_of(model, s.noise))
        for s, model in zip(sessions, models, strict=True)
    )


def _by_number(session: Session) -> np.ndarray:
    """(4 TOLD, F, POINTS, 2) [m/s²]: OWN on each recording's flights of one number, of
    those numbers that are longest."""
    before = [
        int((session.recording[:f] == r).sum()) for f, r in enumerate(session.recording)
    ]
    lengths = np.bincount(before, session.half**4, minlength=TOLD)
    told = np.argsort(-lengths)[:TOLD]
    on = (np.array(before) == told[:, None]).astype(float)
    return np.einsum("nf,kpc->nkfpc", on, OWN).reshape(-1, len(before), *OWN.shape[1:])


@dataclass(frozen=True, eq=False)
class JointModel:
    """The sessions' problems as one, and all impacts."""

    parts: tuple[Problem, ...]
    spots: tuple[np.ndarray, ...]  # where each part's globals are
    cuts: np.ndarray  # bounds of each part's locals
    table: Impacts | None = None  # all impacts
    kept: np.ndarray | None = None  # those used
    impacts: ImpactModel | None = None  # None where there are too few
    own_names: tuple[str, ...] = ()
    own_spot: np.ndarray | None = None  # where its globals are

    @property
    def recordings(self) -> tuple[str, ...]:
        """Those with flights that can be used, in the order of their rows; then those
        that were only heard."""
        named = {n for p in self.parts for n in p.recordings}
        heard = self.impacts.impacts.names if self.impacts else ()
        flown = (n for p in self.parts for n in p.model.session.flown)
        return (*flown, *(n for n in heard if n not in named))

    def split(self, starts: np.ndarray, values: np.ndarray):
        """(part, its starts, its values) for every session."""
        for k, (part, spot) in enumerate(zip(self.parts, self.spots, strict=True)):
            yield part, starts[self.cuts[k] : self.cuts[k + 1]], values[spot]

    def impacts_at(self, starts: np.ndarray, values: np.ndarray) -> ImpactModel:
        """The impacts at the speeds that these flights have."""
        assert (
            self.table is not None
            and self.kept is not None
            and self.impacts is not None
        )  # called only with impacts
        flown = [
            speeds_at_contacts(p.model, s, dict(zip(p.names, v, strict=True)))
            for p, s, v in self.split(starts, values)
        ]
        speeds = np.concatenate([np.zeros((2, 0, 2)), *flown], axis=1)
        return updated(self.impacts, subset(with_speeds(self.table, speeds), self.kept))


def joint_flights(sessions: tuple[PreparedSession, ...]) -> Problem:
    """The flights of all sessions as one problem."""
    parts = tuple(s.problem for s in sessions)
    order = sorted(range(len(parts)), key=lambda k: -parts[k].freedom)
    names: list[str] = []
    effects, known, spots = {}, {}, {}
    for rank, k in enumerate(order):
        spot = []
        for n in parts[k].names:
            law = LAWS[n]
            of_session = n == APPROACH or any((law.picture, law.clock, law.release))
            own = f"{n}@{k + 1}" if rank and of_session else n
            if own not in names:
                names.append(own)
                known[own] = parts[k].known_sd.get(n, 0.0)
            if n in parts[k].effects and own not in effects:
                effect = parts[k].effects[n]
                effects[own] = (
                    effect
                    if own == n
                    else replace(effect, name=own, group=effect.group or n)
                )
            spot.append(names.index(own))
        spots[k] = np.array(spot)
    joint = JointModel(
        parts,
        tuple(spots[k] for k in range(len(parts))),
        np.cumsum([0, *(len(p.starts) for p in parts)]),
    )
    return _problem(joint, tuple(names), effects, known)


def with_impacts(
    flights: Fit | None,
    sessions: tuple[PreparedSession, ...],
    heard: Impacts | None,
    follows,
    long: float | None = None,
) -> Problem | None:
    """The flights' problem, with impacts if enough; long: elongation of seeds, None: as
    stated."""
    joint = (
        flights.problem.model if flights else JointModel((), (), np.zeros(1, dtype=int))
    )
    fits = session_fits(flights) if flights else ()
    parts = (
        [
            impacts_of(part, s.noise, s.tracks)
            for part, s in zip(fits, sessions, strict=True)
        ]
        if flights
        else []
    )
    table = concatenated([*parts, heard] if heard is not None else parts)
    kept = usable_rows(table)
    model = (
        impact_problem.model_of(subset(table, kept), long, follows)
        if len(kept)
        else None
    )
    if model is None:
        return flights.problem if flights else None
    effects, names, known = impact_problem.globals_of(model)
    above = flights.problem.names if flights else ()
    every = tuple(dict.fromkeys((*above, *names)))
    joint = replace(
        joint,
        table=table,
        kept=kept,
        impacts=model,
        own_names=names,
        own_spot=np.array([every.index(n) for n in names]),
    )
    if flights is None:
        return _problem(joint, names, effects, known)
    whole = _problem(
        joint,
        every,
        flights.problem.effects | effects,
        flights.problem.known_sd | known,
    )
    return replace(whole, starts=flights.starts)


def _problem(
    joint: JointModel, names: tuple[str, ...], effects: dict, known: dict[str, float]
) -> Problem:
    parts = joint.parts

    def unknown_scatter(
        problem: Problem, reduced: tuple[Reduced, ...]
    ) -> UnknownScatter:
        assert joint.impacts is not None
        hits = dict(
            zip(
                joint.impacts.impacts.names,
                (len(rows) for rows, _ in joint.impacts.blocks),
                strict=True,
            )
        )
        loose = [
            np.arange(len(r.b)) >= len(r.b) - hits[n]
            for n, r in zip(problem.recordings, reduced, strict=True)
        ]
        return UnknownScatter(
            uncertain=np.concatenate(loose), level_sd=joint.impacts.level_sd
        )

    freedom = sum(p.freedom for p in parts) + (
        len(joint.impacts.y) if joint.impacts else 0
    )
    return Problem(
        "drop",
        joint.recordings,
        effects,
        names,
        known,
        np.vstack([np.zeros((0, STARTS)), *(p.starts for p in parts)]),
        partial(_reduced, joint, len(names)),
        freedom,
        max(
            (p.level_sd for p in parts),
            default=joint.impacts.level_sd if joint.impacts else 0.0,
        ),
        joint,
        MAX_ITERATIONS,
        unknown_scatter=unknown_scatter if joint.impacts is not None else None,
        with_effect=partial(_with_effect, joint, names, effects, known),
    )


def _with_effect(
    joint: JointModel,
    names: tuple[str, ...],
    effects: dict[str, Effect],
    known: dict[str, float],
    effect: Effect,
) -> Problem:
    """With one more law of impacts, or of the flights of all sessions."""
    own = effect.name
    if effect.restitution:
        assert joint.impacts is not None and joint.own_spot is not None
        impacts = replace(joint.impacts, laws=joint.impacts.laws | {own: effect})
        joint = replace(
            joint,
            impacts=impacts,
            own_names=(*joint.own_names, own),
            own_spot=np.append(joint.own_spot, len(names)),
        )
    else:
        more: list[Problem] = []
        for part in joint.parts:
            assert part.with_effect is not None
            more.append(part.with_effect(effect))
        joint = replace(
            joint,
            parts=tuple(more),
            spots=tuple(np.append(spot, len(names)) for spot in joint.spots),
        )
    return _problem(joint, (*names, own), effects | {own: effect}, known)


def _reduced(
    joint: JointModel, count: int, starts: np.ndarray, values: np.ndarray, extra=None
):
    """See Problem.reduce; extra: (K accelerations of each session, K' columns on impact
    rows)."""
    pushes, struck = extra if extra is not None else ([None] * len(joint.parts), None)
    more = 0 if not pushes or pushes[0] is None else len(pushes[0])
    width = count + more + (0 if struck is None else len(struck))
    rows: dict[str, list[Reduced]] = {n: [] for n in joint.recordings}
    back = []

    def put(name: str, made: Reduced, spot: np.ndarray, first: int) -> None:
        """Rows with globals that stand at `spot`, and further columns from `first`."""
        a = np.zeros((len(made.b), width))
        a[:, spot] = made.a[:, : len(spot)]
        further = made.a[:, len(spot) :]
        a[:, first : first + further.shape[1]] = further
        if name in rows:  # else none of its flights could be used
            rows[name].append(replace(made, a=a))

    for k, (part, own, held) in enumerate(joint.split(starts, values)):
        flights, change = part.reduce(own, held, pushes[k])
        for name, made in zip(part.model.session.flown, flights, strict=True):
            put(name, made, joint.spots[k], count)
        back.append((joint.spots[k], change))

    def changed(theta: np.ndarray) -> np.ndarray:
        theta = theta if theta.ndim == 1 else theta[0]
        return np.vstack(
            [np.zeros((0, STARTS)), *(change(theta[spot]) for spot, change in back)]
        )

    if joint.impacts is not None:
        assert joint.own_spot is not None
        model = joint.impacts_at(starts, values)
        at = dict(zip(joint.own_names, values[joint.own_spot], strict=True))
        felt, slopes_of_y = _felt(joint, starts, values, changed, model)
        told = list(zip(values[felt], slopes_of_y, strict=True))
        hits = impact_problem.reduce(model, at, struck, told)
        for name, made in zip(model.impacts.names, hits, strict=True):
            put(name, made, np.append(joint.own_spot, felt), count + more)
    return tuple(map(_as_one, rows.values())), changed


def _felt(
    joint: JointModel, starts: np.ndarray, values: np.ndarray, changed, model
) -> tuple[np.ndarray, list[np.ndarray]]:
    """Where the globals stand (g,) on which the speeds at all impacts depend: each
    session's readout [s]. And by how much the impacts' residuals fall with each (g, m)
    [1/s], the flights' starts being fitted again."""
    spots = [
        spot[part.names.index(READOUT)]
        for part, spot in zip(joint.parts, joint.spots, strict=True)
        if part.known_sd.get(READOUT)
    ]
    out, still = [], changed(np.zeros(len(values)))
    for spot in spots:
        step = READOUT_STEP_S * np.eye(len(values))[spot]
        there = joint.impacts_at(starts + changed(step) - still, values + step)
        out.append((model.y - there.y) / READOUT_STEP_S)
    return np.array(spots, dtype=int), out


def _as_one(parts: list[Reduced]) -> Reduced:
    """A recording's rows of flights and of impacts."""
    return Reduced(
        np.vstack([r.a for r in parts]),
        block_diag(*(r.smooth for r in parts)),
        np.concatenate([r.b for r in parts]),
        half_ln_det=sum(r.half_ln_det for r in parts),
    )


def session_fits(whole: Fit) -> tuple[Fit, ...]:
    """The fit of each session's flights within a joint fit."""
    joint, prior, covariance = whole.problem.model, whole.prior_sd, whole.covariance
    return tuple(
        Fit(part, prior[at], values, covariance[np.ix_(at, at)], starts, whole.chi2, ())
        for at, (part, starts, values) in zip(
            joint.spots, joint.split(whole.starts, whole.values)
        )
    )


def fit_flights(sessions: tuple[PreparedSession, ...], near: Fit | None = None) -> Fit:
    """The flights fitted with nothing missing, from `near` if there is one."""
    return fit(joint_flights(sessions), start=near)
