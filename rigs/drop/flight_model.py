"""From parameters to what a camera sees of one session: flights, then the picture.

Each flight has its own start: x, z, v_x, v_z at its middle; v_y², which only the air
feels; and y, v_y towards the camera, which show at a known distance. Flights are joined
by place only. Conditions of prior knowledge stand beside the track: joined contacts,
stated falls, motion along the line of sight."""

import math
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.polynomial import legendre

from benchtwin.bench.air import SLOWEST_M_S, drag_over_mass, drag_shape
from benchtwin.bench.constants import G_M_S2
from benchtwin.bench.distributions import t as student
from benchtwin.infer.effect import Effect
from benchtwin.infer.power_law import NAMES
from benchtwin.infer.rivals import INSIDE_SDS
from benchtwin.rigs.drop.effects import EFFECTS
from benchtwin.rigs.drop.effects.hooks import Motion, View, scaled
from benchtwin.rigs.drop.nuisances import APPROACH, DEPTH_SD_M, LOCK, NUISANCES, READOUT
from benchtwin.rigs.drop.session import Session
from benchtwin.rigs.drop.trajectories import (
    NODES,
    accelerations,
    shift_basis,
    speed_basis,
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

    @cached_property
    def fallen(self) -> np.ndarray:
        """The contacts that end a fall of stated height."""
        s = self.session
        before = s.joint[:, 0]
        stated = np.isfinite(s.release[s.recording[before]])
        return np.flatnonzero(s.falls[before] & stated)

    @cached_property
    def unjoined(self) -> np.ndarray:
        """The flights that follow on none that was seen."""
        return np.setdiff1d(
            np.arange(len(self.session.middle)), self.session.joint[:, 1]
        )

    @cached_property
    def condition_flights(self) -> np.ndarray:
        """(C, 2): the flights before and after that each of the conditions is of, or
        one flight twice; see `missed`."""
        joint, every = self.session.joint, np.arange(len(self.session.middle))
        alone = [joint[self.fallen, 0], every, every, self.unjoined]
        return np.vstack(
            [joint, joint, np.repeat(np.concatenate(alone), 2).reshape(-1, 2)]
        )

    def condition_sds(self, starts: np.ndarray, push: np.ndarray) -> np.ndarray:
        """(C,): how well each of the conditions holds [m, s]."""
        s, (before, after) = self.session, self.session.joint.T
        across = velocities(self.contacts, starts, push)[:, 0].reshape(2, -1)
        counts = np.where(s.falls, s.falls.sum(), (~s.falls).sum())
        # told by so many flights
        wider = student.ppf(0.975, counts) / INSIDE_SDS
        nearing = wider * np.sqrt(self.aside_square)
        # a long seed touches with one end, some ms later with the other
        rocks = 0.0 if s.elongation < ROUND else s.rocking_m
        least = rocks or ROUND_JOINT_SD_M
        lasts = np.bincount(s.recording, s.half)[s.recording]
        begun = np.where(
            s.falls, DEPTH_SD_M, lasts * nearing
        )  # or after unseen flights
        return np.concatenate(
            [
                least + 0.3 * s.frame_s * np.abs(across[1] - across[0]),
                ROUND_JOINT_SD_M + np.minimum(rocks, TWICE_S * nearing[after]),
                s.release_sd[s.recording[before[self.fallen]]],
                ASIDE_SD * self.aside_square,
                nearing,
                begun[self.unjoined],
            ]
        )


START = ("x", "z", "v_x", "v_z", "v_y_square", "y", "v_y")  # of each flight [m, s]
STARTS = len(START)
FLAT = 4  # the first of them, which have no prior: x, z, v_x, v_z
FELT = (2, 3, 4)  # of them, those on which forces depend: v_x, v_z, v_y²
SMALL = (1e-6, 1e-6, 1e-4, 1e-4, 1e-3, 1e-6, 1e-6)  # steps of them, for derivatives
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
    first = session.falls
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
    """Places (…, n, 2) [m] in the plane of the scale of seeds y + v_y τ nearer to the
    camera: about the middle of the view times 1/(1 − (y + v_y τ)/distance)."""
    away = session.away[session.recording[flight]]
    share = (starts[..., flight, 5] + starts[..., flight, 6] * tau) / away
    grown = 1 / (1 - np.minimum(share, NEAREST))[..., None]
    return session.view.middle + (true - session.view.middle) * grown


def pictured(true: np.ndarray, view: View, values: dict[str, float]) -> np.ndarray:
    """Places (n, 2) [m] as the camera shows them."""
    for name, value in values.items():
        picture = LAWS[name].picture
        if picture and value:
            true = picture(true, view, value)
    return true


def pushed(
    model: Model,
    starts: np.ndarray,
    values: dict[str, float],
    near: np.ndarray | None = None,
) -> np.ndarray:
    """Accelerations (F, POINTS, 2) at the flights' nodes, per stated second squared;
    near: others, from which to begin."""
    force = forces(model, values, starts[:, 4])
    return accelerations(starts[:, 2:4], model.session.half, force, near)


def forces(model: Model, values: dict[str, float], aside_square: np.ndarray):
    """force(velocity (F, p, 2)) per stated second², gravity and stated air included."""
    s = model.session
    # light: buoyancy, and added mass of half of it
    share, reynolds, lift, room, light = s.air_of_flights
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
    """True places (…, n, 2) [m] for starts (…, F, 7) and accelerations `push` (…, F,
    POINTS, 2)."""
    start = starts[..., at.flight, :]
    moved = [at.shift[a:b] @ push[..., f, :, :] for f, a, b in at.runs]
    straight = start[..., :2] + start[..., 2:4] * at.tau[:, None]
    return straight + (np.concatenate(moved, axis=-2) if moved else 0.0)


def velocities(at: Places, starts: np.ndarray, push: np.ndarray) -> np.ndarray:
    """Velocities (…, n, 2) [m per stated second]."""
    faster = np.einsum("np,...npc->...nc", at.speed, push[..., at.flight, :, :])
    return starts[..., at.flight, 2:4] + faster


def predict(
    model: Model, starts: np.ndarray, values: dict[str, float]
) -> tuple[np.ndarray, np.ndarray]:
    """What the camera reads (n, 2) [m]; by how much conditions are missed (C,)."""
    push = pushed(model, starts, values)
    true = true_places(model, starts, values, push)
    return pictured(true, model.session.view, values), missed(
        model, starts, values, push
    )


def true_places(
    model: Model, starts: np.ndarray, values: dict[str, float], push: np.ndarray
) -> np.ndarray:
    """(…, n, 2) [m]: of the rows, in the plane of the scale."""
    at = rows_at(model, values)
    true = places(at, starts, push)
    return nearer(true, model.session, starts, at.flight, at.tau)


def missed(
    model: Model, starts: np.ndarray, values: dict[str, float], push: np.ndarray
) -> np.ndarray:
    """(…, C) [m, s]: by how much each of the conditions is missed: places across at
    contacts, those towards the camera, stated falls; v_y² and v_y of each flight are
    the usual ones, and so is y where it follows on no other."""
    s, at = model.session, model.contacts
    joint, count, fell = s.joint.T.ravel(), len(s.joint), s.joint[model.fallen, 0]
    touch = places(at, starts, push)
    depth = starts[..., joint, 5] + at.tau * starts[..., joint, 6]
    fall = (
        released(model, starts, push, values)[..., fell] - touch[..., model.fallen, 1]
    )
    stated = s.release[s.recording[fell]] + release_of(values)
    return np.concatenate(
        [
            touch[..., count:, 0] - touch[..., :count, 0],
            depth[..., count:] - depth[..., :count],
            fall - stated,
            starts[..., 4] - model.aside_square,
            starts[..., 6] - values.get(APPROACH, 0.0),
            starts[..., model.unjoined, 5],
        ],
        axis=-1,
    )


def released(
    model: Model, starts: np.ndarray, push: np.ndarray, values: dict[str, float]
) -> np.ndarray:
    """(…, F) [m]: height at which a seed that passes each flight's first row was at
    rest. Drag k v² all the way, at three quarters of the speed: v² = (g/k)(1 −
    exp(−2 k h))."""
    share, reynolds = model.session.air_of_flights[:2, :, 0]
    up = velocities(model.begins, starts, push)[..., 1] * rate_of(values)
    usual = 0.75 * np.maximum(np.abs(up), SLOWEST_M_S)
    dragged = G_M_S2 * max(1 + values.get("air", 0.0), 0.0) * share
    k = np.maximum(dragged * drag_shape(usual, reynolds) / usual, 1e-9)
    above = -np.log1p(-np.minimum(k * up**2 / G_M_S2, 0.9)) / (2 * k)
    return places(model.begins, starts, push)[..., 1] + above


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
