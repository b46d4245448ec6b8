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
from benchtwin.infer.noise import frame_lag, whiten
from benchtwin.infer.problem import Problem
from benchtwin.rigs.drop.flight_model import (
    FLAT,
    IN_FLIGHT,
    LAWS,
    NEARING,
    SMALL_M,
    SPIN,
    STARTS,
    Model,
    growth,
    joint_sds,
    nearer,
    own_pushes,
    picture_slopes,
    places,
    push_slopes,
    pushed,
    pushed_sides,
    rows_at,
    side_rows,
    sides,
    touching,
    true_scale,
    unseen_rows,
    velocities,
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
from benchtwin.rigs.drop.trajectories import POINTS

STEP = 1e-3  # of a global's prior sd, for derivatives
MAX_ITERATIONS = 25  # large scale errors and strong winds converge slowly


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
    points compare."""
    pushes = np.zeros((0, len(starts), POINTS, 2)) if pushes is None else pushes
    noise = replace(noise, sigma=looser * noise.sigma)
    blocks = _blocks(model, noise, starts, values, pushes)
    lower, change = _eliminate(
        model, starts, values, blocks[:2], len(values) + len(pushes), blocks[2]
    )
    at = np.concatenate([values, np.zeros(len(pushes))])
    return tuple(replace(r, b=r.b + r.a @ at) for r in lower), change


def _blocks(
    model: Model,
    noise: TrackNoise,
    starts: np.ndarray,
    values: np.ndarray,
    pushes: np.ndarray,
):
    """Flights' triangles (locals | globals, pushes | own | smooth | residual), side
    rows, and how many own pushes a flight has."""
    s, at = model.session, dict(zip(model.names, values, strict=True))
    step = steps_of(model)
    push = pushed(model, starts, at)
    driven = push_slopes(model, starts, at, push, step)
    spun = [driven.pop(SPIN)] if SPIN in driven else []
    own = np.array([*spun, *own_pushes(model)]).reshape(-1, *push.shape)
    seen, columns = row_slopes(model, starts, at, push, driven, step)
    columns += list(_pushed_rows(model, np.concatenate([pushes, own])))
    jacobian = np.stack(
        [*columns, (s.places - seen).T], axis=-1
    )  # (2, n, locals + G + K + own + 1)
    triangles = [
        np.linalg.qr(white, mode="r")
        for white in whitened(model, noise, jacobian.swapaxes(0, 1))
    ]
    side, side_columns = side_slopes(model, starts, at, push, driven, step)
    sds = joint_sds(model, starts, push)
    side_columns += [pushed_sides(model, sds, push) for push in pushes]
    touched = np.array([touching(model, push) for push in own])
    touched = touched.reshape(len(own), 2 * len(s.joint))
    side_by = np.array(side_columns).T
    joined = side_rows(model, starts, at, sds, side_by, side, touched)
    return triangles, joined, len(own)


def steps_of(model: Model) -> dict[str, float]:
    """Steps of the globals for derivatives."""
    return {n: STEP * LAWS[n].prior_sd for n in model.names}


def slopes_at(
    model: Model, starts: np.ndarray, at: dict[str, float]
) -> tuple[np.ndarray, np.ndarray]:
    """What the camera reads (n, 2), and its derivatives (2, n, STARTS + G) by each
    row's own start and by the globals."""
    step, push = steps_of(model), pushed(model, starts, at)
    driven = push_slopes(model, starts, at, push, step)
    driven.pop(SPIN, None)
    seen, columns = row_slopes(model, starts, at, push, driven, step)
    return seen, np.stack(columns, axis=-1)


def side_slopes(
    model: Model,
    starts: np.ndarray,
    at: dict,
    push: np.ndarray,
    driven: dict,
    step: dict,
):
    """Side conditions (J + R,) and their derivatives; driven: those of `push`
    (push_slopes)."""
    side = sides(model, starts, push, at)
    slopes = [np.zeros_like(side) for _ in at]
    for k, n in enumerate(at):
        if n in driven:
            moved = at | {n: at[n] + step[n]}
            slopes[k] = (
                sides(model, starts, push + step[n] * driven[n], moved) - side
            ) / step[n]
    return side, slopes


def row_slopes(
    model: Model,
    starts: np.ndarray,
    at: dict,
    push: np.ndarray,
    driven: dict,
    step: dict,
):
    """What the camera reads (n, 2) and its derivatives (2, n) by starts and globals."""
    s, rows = model.session, rows_at(model, at)
    level = places(rows, starts, push)
    true = nearer(level, s, starts, rows.flight, rows.tau)
    seen, slopes = picture_slopes(true, s.view, at, step)
    carried = dict(
        zip(driven, _pushed_rows(model, np.array(list(driven.values()))), strict=True)
    )
    grown = growth(s, starts, rows.flight, rows.tau)[:, 0]

    def shown(moved: np.ndarray) -> np.ndarray:
        return moved[0] * slopes["x"] + moved[1] * slopes["z"]

    across, up = np.eye(2)[:, :, None]
    moves = [
        across,
        up,
        rows.tau * across + carried[2],
        rows.tau * up + carried[3],
        carried[4],
    ]
    if READOUT in at:
        late = velocities(rows, starts, push) * s.late[:, None]
        slopes[READOUT] = shown(grown * late.T)
    columns = [shown(grown * moved) for moved in moves]
    for p in NEARING:
        moved = starts + SMALL_M * (np.arange(STARTS) == p)
        columns.append(
            shown((nearer(level, s, moved, rows.flight, rows.tau) - true).T) / SMALL_M
        )
    return seen, columns + [
        slopes[n] if n in slopes else shown(grown * carried[n]) for n in at
    ]


def whitened(model: Model, noise: TrackNoise, jacobian: np.ndarray):
    """Whitened rows (2 n_f, locals + G + 10 + 1) of each flight, smooth columns
    included."""
    s, extra = model.session, len(SMOOTH)
    width = jacobian.shape[2]
    size = s.stop - s.first
    both = []
    for axis in (0, 1):
        rows, lag = (
            np.zeros((size.max(), len(size), width + extra)),
            np.full((size.max(), len(size)), np.inf),
        )
        for f, n in enumerate(size):
            here = slice(s.first[f], s.stop[f])
            sigma = noise.sigma[s.recording[f], axis] / s.weight[here, None]
            rows[:n, f, :width] = jacobian[here, axis] / sigma
            rows[:n, f, width:] = smooth_columns(
                s.tau[here], s.half[f]
            )  # in units of σ; their priors are flat
            lag[:n, f] = frame_lag(s.frame[here])
        both.append(whiten(rows, lag, noise.axes[axis].rho, noise.axes[axis].white)[0])
    for f, n in enumerate(size):
        across, up = both[0][:n, f], both[1][:n, f]
        nil = np.zeros((n, extra))
        yield np.vstack(
            [
                np.hstack(
                    [
                        across[:, : width - 1],
                        across[:, width:],
                        nil,
                        across[:, width - 1 : width],
                    ]
                ),
                np.hstack(
                    [up[:, : width - 1], nil, up[:, width:], up[:, width - 1 : width]]
                ),
            ]
        )


def _pushed_rows(model: Model, pushes: np.ndarray) -> np.ndarray:
    """(K, 2, n): displacement of the rows by accelerations (K, F, POINTS, 2)."""
    parts = [
        np.einsum("np,kpc->kcn", model.rows.shift[a:b], pushes[:, f], optimize=True)
        for f, a, b in model.rows.runs
    ]
    return np.concatenate(parts, axis=2)


@dataclass(frozen=True)
class _Columns:
    """Columns of one recording's rows: starts of its flights (STARTS each), its own
    deviations from globals (`owns`: which, and their sds), what pushes its flights of
    their own (`own` each), `count` globals and pushes, smooth errors of each flight,
    the residual."""

    flights: np.ndarray
    owns: dict[int, float]
    own: int
    count: int

    @classmethod
    def of(cls, model: Model, recording: int, own: int, count: int) -> "_Columns":
        session = model.session
        names = enumerate(model.names)
        owns = {k: LAWS[n].prior_sd for k, n in names if n.startswith(LOCK)}
        if session.air[recording].share > 0:
            owns = {model.names.index("air"): SEED_DRAG} | owns
        flights = np.flatnonzero(session.recording == recording)
        return cls(flights, owns, own, count)

    @property
    def deviations(self) -> int:
        return STARTS * len(self.flights)

    @property
    def spins(self) -> int:
        return self.deviations + len(self.owns)

    @property
    def local(self) -> int:
        """How many are the recording's own, and the first of the globals."""
        return self.spins + self.own * len(self.flights)

    @property
    def total(self) -> int:
        return self.local + self.count + 2 * len(SMOOTH) * len(self.flights) + 1

    @property
    def globals(self) -> slice:
        return slice(self.local, self.local + self.count)

    def starts_of(self, flight: int) -> int:
        """The first of a flight's starts."""
        return STARTS * int(np.searchsorted(self.flights, flight))

    def pushes_of(self, flight: int) -> slice:
        at = self.spins + self.own * int(np.searchsorted(self.flights, flight))
        return slice(at, at + self.own)

    def priors(self) -> list[np.ndarray]:
        """Rows that hold own deviations and pushes to their sds."""
        deviations = np.eye(len(self.owns), self.total, self.deviations)
        return [
            np.eye(self.total)[self.spins : self.local],
            deviations / np.array([*self.owns.values()])[:, None],
        ]

    def flight_rows(self, flight: int, triangle: np.ndarray) -> np.ndarray:
        """A flight's triangle (locals | globals, pushes | own | smooth | residual)."""
        block = np.zeros((len(triangle), self.total))
        at, own = self.starts_of(flight), STARTS + self.count
        block[:, at : at + STARTS] = triangle[:, :STARTS]
        block[:, self.globals] = triangle[:, STARTS:own]
        of_owns = [STARTS + k for k in self.owns]
        block[:, self.deviations : self.spins] = triangle[:, of_owns]
        block[:, self.pushes_of(flight)] = triangle[:, own : own + self.own]
        smooth = 2 * len(SMOOTH)
        first = self.globals.stop + smooth * int(np.searchsorted(self.flights, flight))
        block[:, first : first + smooth] = triangle[:, own + self.own : -1]
        block[:, -1] = triangle[:, -1]
        return block


def _recording_rows(
    model: Model,
    starts: np.ndarray,
    values: np.ndarray,
    blocks: tuple,
    recording: int,
    columns: _Columns,
) -> np.ndarray:
    """All rows of a recording, white."""
    triangles, sides = blocks
    rows = columns.priors()
    rows += [columns.flight_rows(f, triangles[f]) for f in columns.flights]
    approach = model.names.index(APPROACH)
    unseen = unseen_rows(model, starts, recording, values[approach])
    for at, entries, common, right in unseen:
        row = np.zeros((1, columns.total))
        row[0, columns.local + approach] = common
        row[0, [columns.starts_of(f) + p for f, p in at]] = entries
        row[0, -1] = right
        rows.append(row)
    for _, entries, across, right in (s for s in sides if s[0] == recording):
        row = np.zeros((1, columns.total))
        for f, entry in entries.items():
            first = columns.starts_of(f)
            row[0, first : first + 4] = entry[:4]
            row[0, columns.pushes_of(f)] = entry[4:]
        row[0, columns.globals], row[0, -1] = across, right
        rows.append(row)
    return np.vstack(rows)


def _eliminate(
    model: Model, starts: np.ndarray, values: np.ndarray, blocks, count: int, own: int
):
    """Reduced of each recording, and a function from a change of θ to that of
    starts. Volumes are those of starts in the lengths of the picture, where all places
    are alike beforehand: in true lengths a larger scale would be less probable."""
    session = model.session
    reduced, back = [], []
    ln_unit = np.log(true_scale(dict(zip(model.names, values, strict=True))))
    for r in range(len(session.names)):
        columns = _Columns.of(model, r, own, count)
        if not len(columns.flights):
            continue
        local = columns.local
        rows = _recording_rows(model, starts, values, blocks, r, columns)
        triangle = np.asarray(np.linalg.qr(rows, mode="r"))  # for numpy's types
        below, sizes = triangle[local:], np.abs(np.diag(triangle)[:local])
        if not sizes.all():  # singular: forces so great that starts have no effect
            below[:, -1], sizes = np.inf, np.ones(local)
        volume = FLAT * len(columns.flights) * ln_unit
        across, inside = columns.globals, triangle[:local, :local]
        reduced.append(
            Reduced(
                below[:, across],
                below[:, across.stop : -1],
                below[:, -1],
                half_ln_det=float(np.log(sizes).sum()) + volume,
                own=inside,
            )
        )
        back.append((columns, inside, triangle[:local, across], triangle[:local, -1]))

    def change(theta: np.ndarray) -> np.ndarray:
        out = np.zeros((len(session.middle), STARTS))
        for columns, inside, across, right in back:
            found = solve_triangular(inside, right - across @ theta)
            out[columns.flights] = found[: columns.deviations].reshape(-1, STARTS)
        return out

    return reduced, change


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
