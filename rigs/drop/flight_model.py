"""From parameters to what a camera sees of one session: flights, then the picture.

Each flight has its own start: x, z, v_x, v_z at its middle; v_y², which only the air
feels; and y, v_y towards the camera, which show at a known distance. Flights are joined
by place only. Rows of prior knowledge stand beside the track: joined contacts, stated
falls, speeds along the line of sight."""

import math
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.polynomial import legendre

from benchtwin.bench.air import SLOWEST_M_S, drag_at, drag_over_mass
from benchtwin.bench.constants import G_M_S2
from benchtwin.bench.distributions import t as student
from benchtwin.infer.effect import Effect
from benchtwin.infer.power_law import NAMES
from benchtwin.infer.rivals import INSIDE_SDS
from benchtwin.rigs.drop.effects import EFFECTS
from benchtwin.rigs.drop.effects.hooks import Motion, View, scaled
from benchtwin.rigs.drop.nuisances import DEPTH_SD_M, LOCK, NUISANCES, READOUT
from benchtwin.rigs.drop.session import Session
from benchtwin.rigs.drop.trajectories import (
    NODES,
    accelerations,
    changes,
    shift_basis,
    speed_basis,
    speeds_at_nodes,
)

IN_FLIGHT = {
    n: e
    for n, e in EFFECTS.items()
    if e.acceleration or e.picture or e.clock or e.release
}
# what a law does that was found for unlisted physics is the model's own: Model.laws
FOUND = {
    n: Effect(n, "flight", "1", "", 0.01, -np.inf, np.inf, "", needs=lambda _: False)
    for n in NAMES
}
LAWS: dict[str, Effect] = IN_FLIGHT | NUISANCES | FOUND
ROUND_JOINT_SD_M = 2e-5  # sideways motion of the centre during a contact
TWICE_S = 5e-3  # from the contact of a long seed's one end to that of the other
LEAST_ASIDE_M_S = 0.01
ROUND = 0.02  # elongation below which a seed counts as a ball
ASIDE_SD = math.sqrt(2)  # of v_y² over its mean, v_y being normal


@dataclass(frozen=True, eq=False)
class Places:
    """Points in flights at which the model is evaluated, and the bases that depend on
    them."""

    flight: np.ndarray
    tau: np.ndarray
    shift: np.ndarray
    speed: np.ndarray
    runs: tuple[tuple[int, int, int], ...]  # (flight, first row, row after the last)


@dataclass(frozen=True, eq=False)
class Model:
    """A session, the names of its globals, and what does not change."""

    session: Session
    names: tuple[str, ...]
    aside_square: np.ndarray  # (F,) [m²/s²]: expected v_y², as of v_x across
    rolled: (
        np.ndarray
    )  # (F,) [rad/m]: spin over speed along the line of sight, as across
    rows: Places
    # (2 J): the J contacts seen from the flight before, then from the flight after
    contacts: Places
    begins: Places  # (F): each flight at its first row
    own_force: np.ndarray  # (R,) [m/s²] sd, each way
    own_shown: bool = False  # whether the flights show it
    own_beyond: float = 0.0  # ln likelihood over that of any within MOST_OWN
    laws: dict[str, Effect] = field(default_factory=dict)  # found


START = ("x", "z", "v_x", "v_z", "v_y_square", "y", "v_y")  # of each flight [m, s]
STARTS = len(START)
FLAT = 4  # the first of them, which have no prior: x, z, v_x, v_z
FELT = (2, 3, 4)  # of them, those on which forces depend: v_x, v_z, v_y²
NEARING = (5, 6)  # of them, those along the line of sight: y, v_y
SPIN = "own spin"
SMALL_M, SMALL_SQUARE = 1e-6, 1e-3  # for derivatives: of places [m], of v_y² [m²/s²]
NEAREST = 0.5  # greatest share of the way to the camera


def build(session: Session) -> Model:
    """A model with all globals that this session can say something about."""
    names = tuple(
        n
        for n, law in LAWS.items()
        if (not law.needs or law.needs(session))
        and (not n.startswith(LOCK) or session.view.pixel)
    )
    contacts = points_at(
        session, session.joint.T.ravel(), np.tile(session.joint_time, 2)
    )
    rows = points_at(
        session, session.flight, session.tau + session.middle[session.flight]
    )
    begins = points_at(
        session, np.arange(len(session.middle)), session.middle - session.half
    )
    return Model(
        session,
        names,
        *_aside(session),
        rows,
        contacts,
        begins,
        np.zeros(len(session.names)),
    )


def _aside(session: Session) -> tuple[np.ndarray, np.ndarray]:
    """(F,) each: mean square of v_x [m²/s²], Σ ω v_x/Σ v_x² [rad/m]; of falls and of
    rebounds."""
    rows = zip(session.first, session.stop, strict=True)
    across = np.array(
        [np.polyfit(session.tau[a:b], session.places[a:b, 0], 1)[0] for a, b in rows]
    )
    first = np.array(
        [
            f == np.flatnonzero(session.recording == r)[0]
            for f, r in enumerate(session.recording)
        ]
    )
    means = [
        np.mean(across[kind] ** 2) if kind.any() else 0.0 for kind in (~first, first)
    ]
    aside = np.maximum(np.array(means)[first.astype(int)], LEAST_ASIDE_M_S**2)
    rolled = (
        ~first
        * (session.own_spin @ (~first * across))
        / max(float((~first * across**2).sum()), LEAST_ASIDE_M_S**2)
    )
    return aside, rolled


def points_at(session: Session, flight: np.ndarray, time: np.ndarray) -> Places:
    """Points at some times [s] in flights (n,)."""
    tau, half = time - session.middle[flight], session.half[flight]
    cuts = np.concatenate(
        [[0], np.flatnonzero(np.diff(flight)) + 1, [len(flight)]]
    ).astype(int)
    runs = tuple((int(flight[a]), int(a), int(b)) for a, b in pairwise(cuts) if b > a)
    shift = shift_basis(tau, half) * half[:, None] ** 2
    speed = speed_basis(tau, half) * half[:, None]
    return Places(flight, tau, shift, speed, runs)


def rows_at(model: Model, values: dict[str, float]) -> Places:
    """The rows' points, at the times at which the camera read them."""
    s, readout = model.session, values.get(READOUT, 0.0)
    if not readout:
        return model.rows
    return points_at(s, s.flight, s.middle[s.flight] + s.tau + readout * s.late)


def rate_of(values: dict[str, float]) -> float:
    """True over stated frame rate."""
    return float(
        np.prod([clock(v) for n, v in values.items() if (clock := LAWS[n].clock)])
    )


def true_scale(values: dict[str, float]) -> float:
    """True over stated lengths in the picture."""
    return float(
        np.prod([1 + v for n, v in values.items() if LAWS[n].picture is scaled])
    )


def release_of(values: dict[str, float]) -> float:
    """[m] by which the falls are deeper than stated."""
    return sum(law(v) for n, v in values.items() if (law := LAWS[n].release))


def nearer(
    true: np.ndarray,
    session: Session,
    starts: np.ndarray,
    flight: np.ndarray,
    tau: np.ndarray,
) -> np.ndarray:
    """Places (n, 2) [m] in the plane of the scale of seeds y + v_y τ nearer to the
    camera."""
    return session.view.middle + (true - session.view.middle) * growth(
        session, starts, flight, tau
    )


def growth(
    session: Session, starts: np.ndarray, flight: np.ndarray, tau: np.ndarray
) -> np.ndarray:
    """1/(1 − (y + v_y τ)/distance) (n, 1)."""
    share = (starts[flight, 5] + starts[flight, 6] * tau) / session.away[
        session.recording[flight]
    ]
    return 1 / (1 - np.minimum(share, NEAREST))[:, None]


def pictured(true: np.ndarray, view: View, values: dict[str, float]) -> np.ndarray:
    """Places (n, 2) [m] as the camera shows them."""
    for name, value in values.items():
        picture = LAWS[name].picture
        if picture and value:
            true = picture(true, view, value)
    return true


def picture_slopes(
    true: np.ndarray, view: View, values: dict[str, float], step: dict[str, float]
):
    """Places (n, 2) in the picture, and derivatives (2, n) by x, z and each law of the
    picture."""
    slopes = {"x": np.array([[1.0], [0.0]]), "z": np.array([[0.0], [1.0]])}
    for name, value in values.items():
        picture = LAWS[name].picture
        if picture is None:
            continue
        seen = picture(true, view, value)
        if value:
            turned = (
                np.array(
                    [
                        (picture(true + small, view, value) - seen).T
                        for small in SMALL_M * np.eye(2)
                    ]
                )
                / SMALL_M
            )
            slopes = {
                n: moved[0] * turned[0] + moved[1] * turned[1]
                for n, moved in slopes.items()
            }
        slopes[name] = (
            np.ascontiguousarray((picture(true, view, value + step[name]) - seen).T)
            / step[name]
        )
        true = seen
    return true, slopes


def pushed(model: Model, starts: np.ndarray, values: dict[str, float]) -> np.ndarray:
    """Accelerations (F, POINTS, 2) at the flights' nodes, per stated second squared."""
    return accelerations(
        starts[:, 2:4], model.session.half, forces(model, values, starts[:, 4])
    )


def push_slopes(
    model: Model,
    starts: np.ndarray,
    values: dict[str, float],
    push: np.ndarray,
    step: dict[str, float],
) -> dict:
    """Derivatives of `push` by FELT, by globals, and by SPIN, one sd of all own
    spins."""
    s = model.session
    velocity = speeds_at_nodes(starts[:, 2:4], s.half, push)

    def force(
        model: Model = model,
        values: dict[str, float] = values,
        aside_square: np.ndarray = starts[:, 4],
    ) -> np.ndarray:
        return forces(model, values, aside_square)(velocity)

    now, nil = force(), np.zeros_like(push)
    aside = (force(aside_square=starts[:, 4] + SMALL_SQUARE) - now) / SMALL_SQUARE
    direct: dict[int | str, np.ndarray] = dict(
        zip(FELT, (nil, nil, aside), strict=True)
    )
    for n in (n for n in values if LAWS[n].picture is None):
        direct[n] = (force(values=values | {n: values[n] + step[n]}) - now) / step[n]
    if s.spins:
        direct[SPIN] = (
            force(
                replace(model, session=replace(s, own_spin=s.own_spin + s.own_spin_sd))
            )
            - now
        )
    speeds = np.zeros((len(direct), len(starts), 2))
    speeds[0, :, 0] = speeds[1, :, 1] = 1.0
    found = changes(
        velocity,
        s.half,
        forces(model, values, starts[:, 4]),
        speeds,
        np.array(list(direct.values())),
    )
    return dict(zip(direct, found, strict=True))


def forces(model: Model, values: dict[str, float], aside_square: np.ndarray):
    """force(velocity (F, p, 2)) per stated second², gravity and stated air included."""
    s = model.session
    keys = ("share", "reynolds_per_speed", "lift", "room", "buoyancy")
    air = np.array([[getattr(s.air[r], key) for r in s.recording] for key in keys])[
        ..., None
    ]
    share, reynolds, lift, room, light = (
        air  # light: buoyancy, and added mass of half of it
    )
    rate, dragged = rate_of(values), 1 + values.get("air", 0.0)
    room = room * max(dragged, 0.0)
    acting = [
        (law, v)
        for n, v in values.items()
        if (law := model.laws.get(n, LAWS[n]).acceleration) and v
    ]

    def force(velocity: np.ndarray) -> np.ndarray:
        motion = Motion(
            velocity * rate,
            aside_square[:, None] * rate**2,
            model.rolled[:, None],
            s.own_spin[:, None] * rate,
            reynolds,
            lift,
            room,
            G_M_S2,
            values.get("air-slope", 0.0),
        )
        out = np.zeros_like(velocity)
        out[..., 1] = -G_M_S2 * (1 - light)
        if share.any():
            out += drag_over_mass(motion, dragged * share[..., None])
        for law, value in acting:
            out += law(motion, value)
        return out / (1 + light / 2)[..., None] / rate**2

    return force


def places(at: Places, starts: np.ndarray, push: np.ndarray) -> np.ndarray:
    """True places (n, 2) [m] for starts (F, 7) and accelerations `push` (F, POINTS,
    2)."""
    start = starts[at.flight]
    moved = [at.shift[a:b] @ push[f] for f, a, b in at.runs]
    return (
        start[:, :2]
        + start[:, 2:4] * at.tau[:, None]
        + np.concatenate(moved or [np.zeros((0, 2))])
    )


def velocities(at: Places, starts: np.ndarray, push: np.ndarray) -> np.ndarray:
    """Velocities (n, 2) [m per stated second]."""
    return starts[at.flight, 2:4] + np.einsum("np,npc->nc", at.speed, push[at.flight])


def predict(
    model: Model, starts: np.ndarray, values: dict[str, float]
) -> tuple[np.ndarray, np.ndarray]:
    """What the camera reads (n, 2) [m]; side conditions (J + R,) in sds."""
    push, rows = pushed(model, starts, values), rows_at(model, values)
    true = nearer(
        places(rows, starts, push), model.session, starts, rows.flight, rows.tau
    )
    return pictured(true, model.session.view, values), sides(
        model, starts, push, values
    )


def sides(
    model: Model, starts: np.ndarray, push: np.ndarray, values: dict[str, float]
) -> np.ndarray:
    """(J + R,), see `predict`."""
    count = len(model.session.joint)
    touch = places(model.contacts, starts, push)
    joined = (touch[count:, 0] - touch[:count, 0]) / joint_sds(model, starts, push)
    return np.concatenate([joined, _falls(model, starts, push, touch[:count], values)])


def joint_sds(model: Model, starts: np.ndarray, push: np.ndarray) -> np.ndarray:
    """(J,) [m]: how well places across before and after a contact agree."""
    s, count = model.session, len(model.session.joint)
    speed = velocities(model.contacts, starts, push)[:, 0]
    # a long seed touches with one end, some ms later with the other
    least = ROUND_JOINT_SD_M if s.elongation < ROUND else s.rocking_m
    return least + 0.3 * s.frame_s * np.abs(speed[count:] - speed[:count])


def _falls(
    model: Model,
    starts: np.ndarray,
    push: np.ndarray,
    touch: np.ndarray,
    values: dict[str, float],
) -> np.ndarray:
    """Stated less fitted falls (R,) from the first apex to its contact, in sds; 0 if
    not stated."""
    s = model.session
    out = np.zeros(len(s.names))
    apex = released(model, starts, push, values)
    for j, (before, _) in enumerate(s.joint):
        r = s.recording[before]
        if np.isfinite(s.release[r]) and before == np.flatnonzero(s.recording == r)[0]:
            fall = s.release[r] + release_of(values)
            out[r] = (apex[before] - touch[j, 1] - fall) / s.release_sd[r]
    return out


def released(
    model: Model, starts: np.ndarray, push: np.ndarray, values: dict[str, float]
) -> np.ndarray:
    """(F,) [m]: height at which a seed that passes each flight's first row was at
    rest. Drag k v² all the way, at three quarters of the speed: v² = (g/k)(1 −
    exp(−2 k h))."""
    s, dragged = model.session, max(1 + values.get("air", 0.0), 0.0)
    up = velocities(model.begins, starts, push)[:, 1] * rate_of(values)
    k = [
        max(dragged * drag_at(s.air[r], 0.75 * max(abs(v), SLOWEST_M_S)), 1e-9)
        for r, v in zip(s.recording, up, strict=True)
    ]
    lost = np.minimum(np.array(k) * up**2 / G_M_S2, 0.9)
    above = -np.log1p(-lost) / (2 * np.array(k))
    return places(model.begins, starts, push)[:, 1] + above


def contact_states(
    model: Model, starts: np.ndarray, push: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times (J,) at which successive flights meet in height [s]; places and velocities
    (2 J, 2) there, of the flights before, then of those after."""
    s, time = model.session, model.session.joint_time
    count, flights = len(time), model.session.joint.T.ravel()
    for _ in range(2):
        at = points_at(s, flights, np.tile(time, 2))
        place, speed = places(at, starts, push), velocities(at, starts, push)
        late = (place[count:, 1] - place[:count, 1]) / (
            speed[:count, 1] - speed[count:, 1]
        )
        time = time + late
    # within the last step, which is short, all fall freely
    late, weight = np.tile(late, 2)[:, None], np.array([0.0, G_M_S2])
    place = place + speed * late - weight * late**2 / 2
    return time, place, speed - weight * late


def pushed_sides(model: Model, sds: np.ndarray, push: np.ndarray) -> np.ndarray:
    """Change of the side conditions (J + R,) by an acceleration, falls neglected."""
    count, touch = len(model.session.joint), touching(model, push)
    return np.concatenate(
        [(touch[count:] - touch[:count]) / sds, np.zeros(len(model.session.names))]
    )


# accelerations (6, POINTS, 2) that a flight has of its own, in sds, across and up:
# steady, and Legendre's first two polynomials of time: a body is pushed as it is let go
OWN = np.array(
    [
        legendre.legval(NODES, shape)[:, None] * way
        for shape in np.eye(3)
        for way in np.eye(2)
    ]
)


def own_pushes(model: Model) -> np.ndarray:
    """(K, F, POINTS, 2): one sd of each flight's own forces, OWN; (0, …) where none was
    seen."""
    force = model.own_force[model.session.recording]
    return np.einsum("f,kpc->kfpc", force, OWN[: len(OWN) * force.any()])


def touching(model: Model, push: np.ndarray) -> np.ndarray:
    """(2 J,) [m]: displacement across of seeds at their contacts by an acceleration."""
    return np.einsum(
        "np,np->n", model.contacts.shift, push[model.contacts.flight, :, 0]
    )


def side_rows(
    model: Model,
    starts: np.ndarray,
    at: dict,
    sds: np.ndarray,
    side_columns: np.ndarray,
    side,
    own: np.ndarray,
):
    """Rows of contacts, falls: (recording, {flight: entries by x, z, v_x, v_z and by
    its own pushes}, by globals, right side); own (K, 2 J): see `touching`."""
    s = model.session
    count, rows = len(s.joint), []
    for j, (before, after) in enumerate(s.joint):
        sd = sds[j]
        taus = model.contacts.tau[[j, count + j]]
        entries = {
            before: np.array([-1, 0, -taus[0], 0, *-own[:, j]]) / sd,
            after: np.array([1, 0, taus[1], 0, *own[:, count + j]]) / sd,
        }
        rows.append((s.recording[before], entries, side_columns[j], -side[j]))
    for r in np.flatnonzero(np.isfinite(s.release)):
        flight = int(np.flatnonzero(s.recording == r)[0])
        touched = np.flatnonzero(s.joint[:, 0] == flight)
        if not len(touched):  # its first contact was left out
            continue
        j = int(touched[0])
        slope = (
            starts[flight, 3] * rate_of(at) ** 2 / G_M_S2 - model.contacts.tau[j]
        ) / s.release_sd[r]  # air neglected
        rows.append(
            (
                r,
                {flight: np.array([0, 0, 0, slope, *np.zeros(len(own))])},
                side_columns[count + r],
                -side[count + r],
            )
        )
    return rows


def unseen_rows(model: Model, starts: np.ndarray, r: int, approach: float):
    """Rows for motion along the line of sight: v_y² of usual size, v_y about what all
    flights have in common, y continuous at contacts: (entries' places, entries, entry
    by APPROACH, right side)."""
    s, flights = model.session, np.flatnonzero(model.session.recording == r)
    begins = len(np.unique(s.recording))
    counts = np.where(flights == flights[0], begins, len(s.recording) - begins)
    wider = student.ppf(0.975, np.maximum(counts, 1)) / INSIDE_SDS
    for f in flights:
        sd = ASIDE_SD * model.aside_square[f]
        yield ((f, 4),), 1 / sd, 0.0, (model.aside_square[f] - starts[f, 4]) / sd
    joints = {int(after): j for j, (_, after) in enumerate(s.joint)}
    for f, times in zip(flights, wider, strict=True):  # told by so many flights
        sd = times * math.sqrt(model.aside_square[f])
        yield ((f, 6),), 1 / sd, -1 / sd, (approach - starts[f, 6]) / sd
        j = joints.get(int(f))
        if j is None:
            sd = (
                DEPTH_SD_M if f == flights[0] else s.half[flights].sum() * sd
            )  # after unseen flights
            yield ((f, 5),), 1 / sd, 0.0, -starts[f, 5] / sd
            continue
        before, taus = s.joint[j, 0], model.contacts.tau[[j, len(s.joint) + j]]
        apart = (
            starts[f, 5]
            + taus[1] * starts[f, 6]
            - starts[before, 5]
            - taus[0] * starts[before, 6]
        )
        moved = ROUND_JOINT_SD_M
        if not s.elongation < ROUND:
            moved += min(s.rocking_m, TWICE_S * sd)
        entries = np.array([1, taus[1], -1, -taus[0]]) / moved
        yield ((f, 5), (f, 6), (before, 5), (before, 6)), entries, 0.0, -apart / moved
