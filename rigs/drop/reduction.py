"""Linearisation of a session's flights, rows compressed by QR.

Locals are the flights' starts (v_y² with its usual size as prior), each seed's drag
beside the lot's, each recording's pixel lock, and what pushes each flight of its own: a
force, and, where spin does, the difference between its spin and its silhouette's
rotation. Smooth curves are Legendre polynomials of degrees 2 to 6."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.linalg import solve_triangular

from benchtwin.bench.air import SEED_DRAG
from benchtwin.bench.constants import G_M_S2
from benchtwin.infer.effect import Effect
from benchtwin.infer.linear import Reduced
from benchtwin.infer.noise import frame_lag
from benchtwin.infer.problem import Problem
from benchtwin.rigs.drop.flight_model import (
    FELT,
    FLAT,
    IN_FLIGHT,
    LAWS,
    SMALL,
    STARTS,
    Model,
    missed,
    own_pushes,
    pictured,
    pushed,
    true_places,
    true_scale,
)
from benchtwin.rigs.drop.nuisances import (
    APPROACH,
    HEIGHT,
    LOCK,
    NUISANCES,
    OFF_CENTRE,
    PRIORS,
    READOUT,
)
from benchtwin.rigs.drop.session import Session
from benchtwin.rigs.drop.track_noise import (
    EXACT_M,
    SMOOTH,
    TRACKER_PX,
    TrackNoise,
    estimate_noise,
    smooth_columns,
)

STEP = 1e-3  # of a global's prior sd, for derivatives
SMALL_M, SMALL_PUSH = 1e-6, 1e-3  # the same: of a place, of a push
MAX_ITERATIONS = 25  # large scale errors and strong winds converge slowly


@dataclass(frozen=True, eq=False)
class Slopes:
    """What a camera reads and the conditions at a point, and their derivatives by what
    a flight has of its own (L: start and pushes) and by what all have in common (G + K:
    globals and further pushes)."""

    seen: np.ndarray  # (n, 2)
    missed: np.ndarray  # (C,)
    sds: np.ndarray  # (C,)
    rows: np.ndarray  # (n, 2, L + G + K): by the own of each row's flight
    conditions: np.ndarray  # (C, G + K)
    own: np.ndarray  # (C, 2, L): by that of the flight before and of that after


def slopes_at(
    model: Model,
    starts: np.ndarray,
    at: dict[str, float],
    more: np.ndarray | None = None,
) -> Slopes:
    """By small differences, of the conditions by the flights' own for every second
    flight at once, as they are of successive ones; more (K, F, POINTS, 2): further
    pushes."""
    push, view = pushed(model, starts, at), model.session.view
    moved, driven, step, own = _moves(model, starts, at, push, more)
    true, off = (of(model, starts, at, push) for of in (true_places, missed))
    seen = pictured(true, view, at)
    x, z = (
        (pictured(true + m, view, at) - seen) / SMALL_M for m in SMALL_M * np.eye(2)
    )

    def shown(carried: np.ndarray) -> np.ndarray:
        return carried[..., :1] * x + carried[..., 1:] * z

    def by_global(name: str) -> tuple[np.ndarray, np.ndarray]:
        small = STEP * LAWS[name].prior_sd
        there = at | {name: at[name] + small}
        if LAWS[name].picture:
            return (pictured(true, view, there) - seen) / small, np.zeros(len(off))
        felt = starts, there, pushed(model, starts, there, push)
        carried = (true_places(model, *felt) - true) / small
        return shown(carried), (missed(model, *felt) - off) / small

    rows_by, conditions_by = zip(*map(by_global, at), strict=True)
    flown = starts + moved, at, push + driven
    to = shown((true_places(model, *flown) - true) / step[:, None, None])
    conditions = (missed(model, *flown) - off) / step[:, None]
    even = (np.arange(len(starts)) % 2 == 0)[:, None]
    halves = [
        missed(model, starts + w * moved[:own], at, push + w[..., None] * driven[:own])
        for w in (even, ~even)
    ]
    by_own = (np.array(halves) - off) / step[:own, None]
    each, parity = np.arange(len(off))[:, None], model.condition_flights % 2
    return Slopes(
        seen,
        off,
        model.condition_sds(starts, push),
        np.moveaxis(np.concatenate([to[:own], rows_by, to[own:]]), 0, -1),
        np.concatenate([conditions_by, conditions[own:]]).T,
        by_own[parity, :, each],
    )


def _moves(
    model: Model,
    starts: np.ndarray,
    at: dict[str, float],
    push: np.ndarray,
    more: np.ndarray | None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
    """Small steps of starts (L + K, F, STARTS) and pushes (L + K, F, POINTS, 2), and
    their sizes (L + K,): of the flights' own, which are L (starts, one sd of own spins
    where these were seen, of own forces), and by further pushes."""
    s, own = model.session, list(own_pushes(model))
    if s.spins:
        faster = replace(s, own_spin=s.own_spin + s.own_spin_sd)
        spun = pushed(replace(model, session=faster), starts, at, push)
        own = [spun - push, *own]
    pushes = [*own, *(() if more is None else more)]
    step = np.array([*SMALL, *[SMALL_PUSH] * len(pushes)])
    moved = np.zeros((len(step), *starts.shape))
    driven = np.zeros((len(step), *push.shape))
    for p in range(STARTS):
        moved[p, :, p] = step[p]
        if p in FELT:
            driven[p] = pushed(model, starts + moved[p], at, push) - push
    if pushes:
        driven[STARTS:] = SMALL_PUSH * np.array(pushes)
    return moved, driven, step, STARTS + len(own)


def reduce(
    model: Model,
    noise: TrackNoise,
    starts: np.ndarray,
    values: np.ndarray,
    pushes: np.ndarray | None = None,
    looser: float = 1.0,
):
    """See Problem.reduce; pushes (K, F, POINTS, 2): accelerations at the flights'
    nodes; looser: factor on the sds of rows.

    The last entry of each b is the residual that no parameter changes, so that χ² of
    points compare. Volumes are those of starts in the lengths of the picture, where all
    places are alike beforehand: in true lengths a larger scale would be less
    probable."""
    s, at = model.session, dict(zip(model.names, values, strict=True))
    found = slopes_at(model, starts, at, pushes)
    noise = replace(noise, sigma=looser * noise.sigma)
    jacobian = np.dstack([found.rows, s.places - found.seen])
    flights = [np.linalg.qr(w, mode="r") for w in whitened(model, noise, jacobian)]
    ln_unit, common = np.log(true_scale(at)), found.conditions.shape[1]
    theta = np.append(values, np.zeros(common - len(values)))
    reduced, back = [], []
    for r in np.unique(s.recording):
        own = np.flatnonzero(s.recording == r)
        rows, local = _recording_rows(model, r, found, flights)
        triangle = np.asarray(np.linalg.qr(rows, mode="r"))  # for numpy's types
        below, sizes = triangle[local:], np.abs(np.diag(triangle)[:local])
        if not sizes.all():  # singular: forces so great that starts have no effect
            below[:, -1], sizes = np.inf, np.ones(local)
        shared, inside = slice(local, local + common), triangle[:local, :local]
        reduced.append(
            Reduced(
                below[:, shared],
                below[:, shared.stop : -1],
                below[:, -1] + below[:, shared] @ theta,
                half_ln_det=float(np.log(sizes).sum()) + FLAT * len(own) * ln_unit,
                own=inside,
            )
        )
        back.append((own, inside, triangle[:local, shared], triangle[:local, -1]))

    def change(moved: np.ndarray) -> np.ndarray:
        out = np.zeros((len(s.middle), STARTS))
        for own, inside, across, right in back:
            to = solve_triangular(inside, right - across[:, : len(moved)] @ moved)
            out[own] = to[: STARTS * len(own)].reshape(-1, STARTS)
        return out

    return tuple(reduced), change


def whitened(model: Model, noise: TrackNoise, jacobian: np.ndarray):
    """White rows (2 n_f, columns + 10) of each flight from rows (n, 2, columns), those
    of its smooth errors across and up behind them."""
    s = model.session
    for f, rows in enumerate(map(slice, s.first, s.stop)):
        lag, smooth = frame_lag(s.frame[rows]), smooth_columns(s.tau[rows], s.half[f])
        sigma = noise.sigma[s.recording[f]] / s.weight[rows, None]
        both = []
        for k, axis in enumerate(noise.axes):
            # smooth columns in units of σ: their priors are flat
            columns = np.kron(np.eye(2)[k], smooth)
            scaled = jacobian[rows, k] / sigma[:, k, None]
            both.append(axis.whiten(np.hstack([scaled, columns]), lag))
        yield np.vstack(both)


def _recording_rows(
    model: Model, r: int, found: Slopes, flights: list[np.ndarray]
) -> tuple[np.ndarray, int]:
    """All rows of a recording, white, and how many columns are its own. Columns: starts
    of its flights, its own deviations from globals, own pushes of its flights, globals
    and further pushes, smooth errors of each flight, the residual."""
    own, common = (
        np.flatnonzero(model.session.recording == r),
        found.conditions.shape[1],
    )
    deviations = _deviations(model, r)
    pushes, smooth = found.own.shape[2] - STARTS, 2 * len(SMOOTH)
    first = STARTS * len(own)
    local = first + len(deviations) + pushes * len(own)
    total = local + common + smooth * len(own) + 1

    def of_flight(f: int) -> np.ndarray:
        """Places of its starts and pushes."""
        k = int(np.searchsorted(own, f))
        behind = first + len(deviations) + pushes * k
        return np.r_[STARTS * k : STARTS * (k + 1), behind : behind + pushes]

    shared, rows = np.arange(local, local + common), [np.eye(total)[first:local]]
    rows[0][: len(deviations)] /= np.array([*deviations.values()])[:, None]
    for k, f in enumerate(own):
        behind = local + common + smooth * k + np.arange(smooth)
        block = np.zeros((len(flights[f]), total))
        at = np.r_[of_flight(f), shared, total - 1, behind]
        block[:, at] = flights[f]
        block[:, first : first + len(deviations)] = block[
            :, local + np.array([*deviations], int)
        ]
        rows.append(block)
    for c in np.flatnonzero(np.isin(model.condition_flights[:, 0], own)):
        row = np.zeros((1, total))
        for f, by in zip(model.condition_flights[c], found.own[c], strict=True):
            row[0, of_flight(f)] = by
        row[0, shared], row[0, -1] = found.conditions[c], -found.missed[c]
        rows.append(row / found.sds[c])
    return np.vstack(rows), local


def _deviations(model: Model, r: int) -> dict[int, float]:
    """Globals from which a recording has deviations of its own, by number, with their
    sds: drag of its seed, pixel lock."""
    air = {"air": SEED_DRAG} if model.session.air[r].share > 0 else {}
    locks = {n: LAWS[n].prior_sd for n in model.names if n.startswith(LOCK)}
    return {model.names.index(n): sd for n, sd in (air | locks).items()}


def problem_of(model: Model, noise: TrackNoise | None = None) -> Problem:
    """The problem of a session, its noise estimated unless given."""
    s = model.session
    noise = noise or estimate_noise(s)
    rows = 2 * len(s.tau) + int(np.isfinite(s.release).sum()) + len(s.joint)
    effects = {n: IN_FLIGHT[n] for n in model.names if n in IN_FLIGHT} | model.laws

    def with_effect(effect: Effect) -> Problem:
        names, laws = (*model.names, effect.name), model.laws | {effect.name: effect}
        return problem_of(replace(model, names=names, laws=laws), noise)

    return Problem(
        "drop",
        s.names,
        effects,
        model.names,
        known_sd(s),
        _parabolas(model),
        partial(reduce, model, noise),
        rows - 4 * len(s.middle),
        noise.level_sd,
        model,
        MAX_ITERATIONS,
        with_effect=with_effect,
        own_sd=np.full(STARTS * len(s.middle), np.inf),
    )


def known_sd(session: Session) -> dict[str, float]:
    """Prior sd of every nuisance: as stated, else from PRIORS."""
    known = {n: PRIORS.get(n, law.prior_sd) for n, law in NUISANCES.items()}
    known["scale"] = float(np.hypot(session.scale_sd, known["scale"]))
    across_seen = np.ptp(session.places[:, 0]) >= EXACT_M
    known["plumb"] = session.plumb_sd_deg if across_seen else 0.0
    known[HEIGHT] = session.height_sd_mm
    known[READOUT] = session.readout_sd_s
    if np.isinf(session.away).all():
        known[APPROACH] = 0.0
    known["air"] = float(
        np.median([a.sd / a.share if a.share else 0.0 for a in session.air])
    )
    turning = 1e3 * float(
        np.hypot(TRACKER_PX * session.view.pixel, session.uneven_m)
    )  # [mm] of an outline that turns
    known |= {"wobble": turning, "wobble.other": turning}
    # the optical axis lies between the fall and the middle of the view, uniformly
    aside = abs(session.view.fall) / session.view.reach / np.sqrt(3)
    return known | {"lens.x": PRIORS["lens"] * float(np.hypot(OFF_CENTRE, aside))}


def _parabolas(model: Model) -> np.ndarray:
    """Starts (F, 7): a straight line across and a parabola of g upwards."""
    session = model.session
    out = np.zeros((len(session.middle), STARTS))
    for f in range(len(out)):
        rows = slice(session.first[f], session.stop[f])
        tau = session.tau[rows]
        up = session.places[rows, 1] + G_M_S2 * tau**2 / 2
        slope, level = np.polynomial.polynomial.polyfit(
            tau, np.column_stack([session.places[rows, 0], up]), 1
        )[::-1]
        out[f, :5] = [*level, *slope, model.aside_square[f]]
    return out
