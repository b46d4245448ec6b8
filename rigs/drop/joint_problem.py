"""All drops of a bench as one problem: flights by session, impacts at the fitted
speeds.

Each session has its own camera, so effects of the picture or the clock have one value a
session, freed together; reported is that of the session with most rows. Impacts are
computed anew from the flights at every linearisation; the flights' uncertainty is in
their covariance."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from benchtwin.infer.effect import Effect
from benchtwin.infer.evidence import UnknownScatter
from benchtwin.infer.linear import Reduced
from benchtwin.infer.noise import block_mean_noise
from benchtwin.infer.problem import Fit, Problem, fit
from benchtwin.rigs.drop import impact_problem
from benchtwin.rigs.drop.flight_model import LAWS, STARTS, build
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
from benchtwin.rigs.drop.reduction import MAX_ITERATIONS, problem_of
from benchtwin.rigs.drop.second_contacts import without_second_contacts
from benchtwin.rigs.drop.session import assemble, block_of
from benchtwin.rigs.drop.track_noise import TrackNoise, estimate_noise
from scipy.linalg import block_diag


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
            block = block_of(next(t for t in own if not t.trouble))
            fine = assemble(own, unstated_m, 0.0)
            noise = estimate_noise(fine)
            own, twice = without_second_contacts(own, fine, noise)
            if block > 1 or twice:
                seen = assemble(own, unstated_m)
                noise = estimate_noise(
                    seen,
                    (
                        block_mean_noise(noise.axes[0], block),
                        block_mean_noise(noise.axes[1], block),
                    ),
                )
            else:
                seen = fine
        except ValueError as error:
            notes.append(
                f"session {session!r} left out: {error}" if session else str(error)
            )
            continue
        notes += [*seen.notes, *twice]
        found.append(PreparedSession(own, noise, problem_of(build(seen), noise)))
    if not found:
        raise ValueError("; ".join(notes) or "no drop was filmed")
    return tuple(found), tuple(notes)


def at_distance(prepared: PreparedSession, away_m: float) -> PreparedSession:
    """The same session with another distance where none is stated."""
    seen = assemble(prepared.tracks, away_m)
    return replace(prepared, problem=problem_of(build(seen), prepared.noise))


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
        speeds = [
            speeds_at_contacts(p.model, s, dict(zip(p.names, v, strict=True)))
            for p, s, v in self.split(starts, values)
        ]
        halves = [np.array_split(s, 2) for s in speeds] or [list(np.zeros((2, 0, 2)))]
        every = np.vstack([*(h[0] for h in halves), *(h[1] for h in halves)])
        heard = len(self.table) - len(every) // 2
        if heard:
            every = np.vstack(
                [
                    every[: len(every) // 2],
                    self.table.before[-heard:, :2],
                    every[len(every) // 2 :],
                    self.table.after[-heard:, :2],
                ]
            )
        return updated(self.impacts, subset(with_speeds(self.table, every), self.kept))


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
            of_session = any((law.picture, law.clock, law.release))
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
    recordings = _filmed(joint)
    if joint.impacts is not None:
        struck = joint.impacts.impacts.names
        recordings = tuple(
            n for n in struck if n in recordings or n not in _named(joint)
        )

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
        recordings,
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
        assert all(part.with_effect for part in joint.parts)
        joint = replace(
            joint,
            parts=tuple(part.with_effect(effect) for part in joint.parts),
            spots=tuple(np.append(spot, len(names)) for spot in joint.spots),
        )
    return _problem(joint, (*names, own), effects | {own: effect}, known)


def _reduced(
    joint: JointModel, count: int, starts: np.ndarray, values: np.ndarray, extra=None
):
    """See Problem.reduce; extra: (K accelerations of each session, K' columns on impact
    rows)."""
    pushes, struck_columns = (
        extra if extra is not None else ([None] * len(joint.parts), None)
    )
    more = 0 if not pushes or pushes[0] is None else len(pushes[0])
    width = count + more + (0 if struck_columns is None else len(struck_columns))
    out: list[Reduced] = []
    back = []
    for k, (part, own, at) in enumerate(joint.split(starts, values)):
        made, change = part.reduce(own, at, pushes[k])
        for r in made:
            a = np.zeros((len(r.b), width))
            a[:, joint.spots[k]] = r.a[:, : len(at)]
            a[:, count : count + more] = r.a[:, len(at) :]
            out.append(replace(r, a=a))
        back.append((joint.spots[k], change))
    if joint.impacts is not None:
        out = _with_impacts(joint, out, count, width, starts, values, struck_columns)

    def changed(theta: np.ndarray) -> np.ndarray:
        theta = theta if theta.ndim == 1 else theta[0]
        return np.vstack(
            [np.zeros((0, STARTS)), *(change(theta[spot]) for spot, change in back)]
        )

    return tuple(out), changed


def _with_impacts(
    joint: JointModel, flights: list[Reduced], count, width, starts, values, columns
) -> list[Reduced]:
    """Each recording's rows with those of its impacts; recordings only heard stand
    last."""
    assert joint.own_spot is not None
    model = joint.impacts_at(starts, values)
    made = impact_problem.reduce(
        model, joint.own_names, np.zeros(0), values[joint.own_spot], columns
    )[0]
    by_name = dict(zip(_filmed(joint), flights, strict=True))
    out = []
    for name, hits in zip(model.impacts.names, made, strict=True):
        if name in _named(joint) and name not in by_name:
            continue  # none of its flights could be used
        a = np.zeros((len(hits.b), width))
        a[:, joint.own_spot] = hits.a[:, : len(joint.own_spot)]
        if columns is not None:
            a[:, width - len(columns) :] = hits.a[:, len(joint.own_spot) :]
        flown = by_name.get(name)
        if flown is None:
            out.append(replace(hits, a=a))
            continue
        b, smooth = (
            np.concatenate([flown.b, hits.b]),
            block_diag(flown.smooth, hits.smooth),
        )
        out.append(Reduced(np.vstack([flown.a, a]), smooth, b, None, flown.half_ln_det))
    return out


def _named(joint: JointModel) -> set[str]:
    return {n for p in joint.parts for n in p.recordings}


def _filmed(joint: JointModel) -> tuple[str, ...]:
    """Recordings with flights, in the order of their rows."""
    sessions = [p.model.session for p in joint.parts]
    return tuple(s.names[r] for s in sessions for r in np.unique(s.recording))


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
