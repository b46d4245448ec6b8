"""How visible an effect is in a case's drops.

Flight and picture: by the tracks, every flight a free parabola upwards and every bounce
a free kick sideways. Impacts: by the numbers that a bounce gives, each with the scatter
that the seeds' shape and spin give it, the mean restitution free; shape by the places
of contact."""

from dataclasses import replace

import numpy as np
from numba import njit
from scipy.integrate import cumulative_trapezoid

from benchtwin.prove.cases.camera import magnification, project, stated_times
from benchtwin.prove.cases.drop import (
    DEPTH_SD_MM,
    PUSH_SD_M_S,
    RUN_SD,
    Scene,
    SimulatedDrop,
    fly_all,
    world,
)
from benchtwin.prove.cases.drop_effects import IN_CAMERA, IN_FLIGHT
from benchtwin.prove.cases.ellipsoid import (
    E_LAW,
    T_BEGIN,
    T_END,
    TURN_IN,
    TURN_OUT,
    UPRIGHT,
    V_NORMAL,
    VX_IN,
    VX_OUT,
    VZ_IN,
    VZ_OUT,
    angle,
    outlines,
    rotation,
)
from benchtwin.prove.cases.flight_laws import acceleration, restitution
from benchtwin.prove.cases.snr import (
    Channel,
    Fitted,
    RecordingChange,
    Visibility,
    fitted,
    scatter_snr,
    spread_snr,
)
from benchtwin.prove.cases.stated import known_plumb_deg, known_scale

MARGIN_S = 4e-4
DRAG_SD = (
    0.15,
    0.6,
)  # of the air that is stated, beside a seed whose size and mass are known or not
# of g at an unknown place on earth, relative: a fall does not tell it from a wrong
# scale or clock
GRAVITY_SD = 5e-4
LEAST_MEASURED_E = 0.004
LITTLE = 0.15  # sds of restitution
# of the radius: how far beside the centre the roundest of seeds is touched
ROUGHNESS = 0.02


def visibility(scene: Scene, sizes: dict[str, float], name: str) -> Visibility:
    """How visible the effect `name` is in the world of all `sizes`."""
    drops = fly_all(scene, sizes)
    if name in IN_FLIGHT or name in IN_CAMERA:
        return _by_track(scene, drops, sizes, name)
    return _by_impact(scene, drops, sizes, name)


def _by_track(
    scene: Scene, drops: list[SimulatedDrop], sizes: dict[str, float], name: str
) -> Visibility:
    recordings, without = [], {k: v for k, v in sizes.items() if k != name}
    sessions = len(scene.cameras)
    scale_sd = known_scale(scene.request, scene.scale_sd)
    plumb_sd = known_plumb_deg(scene.request, scene.plumb_sd_deg)
    drag_sd = DRAG_SD[not scene.request.sizes_known()]
    shared_sd = np.r_[
        np.tile([np.hypot(scale_sd, GRAVITY_SD), plumb_sd, 2e-4, 1e-3], sessions),
        drag_sd,
    ]
    kick_sd = float(
        np.std(np.concatenate([d.log[:, VX_OUT] - d.log[:, VX_IN] for d in drops]))
    )
    for drop in drops:
        law, _, camera = world(scene, drop.run, without)
        base = _places(drop, drop.camera)
        if name in IN_CAMERA:
            # the frames stay where they are in truth; what the clock says of them moves
            late = stated_times(drop.camera, drop.true_s) - stated_times(
                camera, drop.true_s
            )
            speed = (1e3 * drop.rows[:, 3], 1e3 * drop.rows[:, 5])
            change = [
                b - w - v * (late - late[0])
                for b, w, v in zip(base, _places(drop, camera), speed)
            ]
        else:
            change = _pushed(drop, drop.law, law)
        shared = [np.zeros((len(drop.rows), len(shared_sd))) for _ in range(2)]
        for i, (key, sd) in enumerate(
            zip(("scale_error", "roll_deg", "distortion", "perspective"), shared_sd)
        ):
            moved = _places(
                drop, replace(drop.camera, **{key: getattr(drop.camera, key) + sd})
            )
            for axis in range(2):
                shared[axis][:, 4 * drop.run.session + i] = (
                    moved[axis] - base[axis]
                ) / sd
        stated_air, no_air = drop.law.copy(), drop.law.copy()
        # of the air that the recording states
        stated_air[1] = scene.air.drag
        no_air[1] = 0.0
        for axis, pushed in enumerate(_pushed(drop, stated_air, no_air)):
            shared[axis][:, -1] = pushed
        timed = name.startswith("clock")
        recordings.append(_recording_change(drop, change, shared, kick_sd, timed=timed))
    fit = fitted(recordings, shared_sd, scene.noise)
    return Visibility(
        fit.snr, _moved(drops, recordings, fit) if name in IN_FLIGHT else None
    )


def _moved(
    drops: list[SimulatedDrop], recordings: list[RecordingChange], fit: Fitted
) -> float | None:
    """By how many sds restitution is off where a force is left out; None if fits
    differ.

    Each flight's speed takes its part of the force: δe/e = δv_out/v_out − δv_in/v_in,
    by straight lines through the flights and by a fit with all nuisances."""
    off = []
    for drop, recording, own in zip(drops, recordings, fit.own, strict=True):
        flight = _flights(drop)
        inside, count = flight >= 0, int(flight.max()) + 1
        change = recording.channels[1].change
        t = drop.true_s[inside]
        rows = flight[inside]
        last = [np.flatnonzero(rows == k)[-4:] for k in range(count)]
        if min(len(part) for part in last) < 4:
            continue
        lines = np.array(
            [np.polyfit(t[rows == k], change[rows == k], 1)[0] for k in range(count)]
        )
        # upwards a flight has a height and a speed
        slopes = np.array([lines, own[-3 * count - 1 : -count - 1][1::2]])
        ends = slopes - [np.polyfit(t[part], change[part], 1)[0] for part in last]
        v_in, v_out = (
            1e3 * drop.log[: count - 1, column] for column in (VZ_IN, VZ_OUT)
        )
        off += list(
            zip(*(-v_out / v_in * (slopes[:, 1:] / v_out - ends[:, :-1] / v_in)))
        )
    e = np.concatenate([-drop.log[:, VZ_OUT] / drop.log[:, VZ_IN] for drop in drops])
    if len(off) < 4:
        return None
    plain, nuisanced = np.mean(off, axis=0) / np.std(e) * np.sqrt(len(e))
    alike = max(abs(plain), abs(nuisanced)) < LITTLE or 1 / 3 < nuisanced / plain < 3
    return float(plain) if alike else None


def _recording_change(
    drop: SimulatedDrop, change, shared, kick_sd: float, timed: bool = False
) -> RecordingChange:
    """Own height and speed of flights, own kicks of bounces; timed: impacts move
    too."""
    flight = _flights(drop)
    inside = flight >= 0
    t, count = drop.true_s, flight.max() + 1
    across = [np.ones_like(t), t] + [
        np.maximum(t - b, 0)
        for b in drop.log[: count - 1, [T_BEGIN, T_END]].mean(axis=1)
    ]
    if timed:
        across += [(t > b) * 1.0 for b in drop.log[: count - 1, T_END]]
    up = [(flight == k) * f for k in range(count) for f in (np.ones_like(t), t)]
    deep, p, q = np.column_stack(across[: 1 + count]), len(across), len(up)
    own = [np.zeros((len(t), p + q + 1 + count)) for _ in range(2)]
    own[0][:, :p], own[1][:, p : p + q] = np.column_stack(across), np.column_stack(up)
    smaller = (
        -(magnification(drop.camera, 1e3 * drop.rows[:, 1]) ** 2)
        / drop.camera.distance_mm
    )  # for each mm behind
    for axis, (column, centre) in enumerate(zip((0, 2), drop.camera.centre_mm)):
        own[axis][:, p + q :] = (
            deep * ((1e3 * drop.rows[:, column] - centre) * smaller)[:, None]
        )
    deep_sd = [DEPTH_SD_MM, 1e3 * PUSH_SD_M_S, *[max(1e3 * kick_sd, 1.0)] * (count - 1)]
    channels = tuple(
        Channel(change[i][inside], own[i][inside], shared[i][inside]) for i in range(2)
    )
    return RecordingChange(channels, np.r_[np.full(p + q, np.inf), deep_sd])


def _flights(drop: SimulatedDrop) -> np.ndarray:
    """Which flight each frame is in; −1 while held or near a contact."""
    t, flight = drop.true_s, np.zeros(len(drop.true_s), int)
    for k, row in enumerate(drop.log):
        flight[t > row[T_BEGIN]] = k + 1
    for row in drop.log:
        flight[(t > row[T_BEGIN] - MARGIN_S) & (t < row[T_END] + MARGIN_S)] = -1
    flight[t <= 0] = -1
    return flight


def _places(drop: SimulatedDrop, camera) -> tuple[np.ndarray, np.ndarray]:
    turned = angle(outlines(drop.rows, np.array(drop.run.axes)))
    x = drop.rows[:, 0] * 1e3
    z = drop.rows[:, 2] * 1e3
    return project(camera, x, z, turned, drop.rows[:, 1] * 1e3)


def _pushed(
    drop: SimulatedDrop, law: np.ndarray, other: np.ndarray
) -> list[np.ndarray]:
    """What the difference of two flight laws moves [mm], (x, z); the speed is put right
    at every bounce, the height too."""
    flight = _flights(drop)
    moved = [np.zeros(len(drop.rows)) for _ in range(2)]
    across = 0.0
    for k in range(flight.max() + 1):
        rows = np.flatnonzero(flight == k)
        if len(rows) < 3:
            continue
        difference = differences(drop.rows[rows], law, other)
        for axis, column in enumerate((0, 2)):
            speed = cumulative_trapezoid(
                difference[:, column], drop.true_s[rows], initial=0
            )
            moved[axis][rows] = 1e3 * cumulative_trapezoid(
                speed, drop.true_s[rows], initial=0
            )
        moved[0][rows] += across  # a bounce kicks, it does not displace
        across = moved[0][rows[-1]]
    return moved


@njit(cache=True)
def differences(rows, law, other):
    """Acceleration under one law less that under another, (n, 3) for states (n, 13)."""
    out = np.empty((len(rows), 3))
    for i in range(len(rows)):
        row = rows[i]
        spin = np.zeros(3)
        r = rotation(row[6:10])
        for k in range(3):
            for j in range(3):
                spin[k] += r[k, j] * row[10 + j]
        out[i] = acceleration(row[:3], row[3:6], spin, law) - acceleration(
            row[:3], row[3:6], spin, other
        )
    return out


def _by_impact(
    scene: Scene, drops: list[SimulatedDrop], sizes: dict[str, float], name: str
) -> Visibility:
    log = np.concatenate([d.log for d in drops])
    if len(log) < 4:
        return Visibility(0.0)
    speed = -log[:, VZ_IN]
    returned = log[:, VZ_OUT] / speed - log[:, E_LAW]
    kicked = (log[:, VX_OUT] - log[:, VX_IN]) / speed
    measured = LEAST_MEASURED_E + 3 * scene.noise.sd * 1e-3 / (speed * 0.1)
    if name == "shape-conversion":
        others = {k: v for k, v in sizes.items() if k != name}
        before = np.concatenate([d.log for d in fly_all(scene, others)])
        now, usual = (
            np.hypot(np.std(_offsets(scene, rows)), ROUGHNESS) for rows in (log, before)
        )
        return Visibility(spread_snr(now / usual, len(log)))
    if name == "plate-tilt":
        change = (1 + log[:, E_LAW]) * np.radians(sizes[name])
        if scene.angle_sd_deg:
            turning = log[:, TURN_IN] * np.mean(scene.stated_axes_mm) * 5e-4
        else:
            turning = 0.0
        # nobody states how much of it friction takes
        slip = (log[:, VX_IN] + turning) / speed
        return Visibility(
            scatter_snr(change, np.hypot(np.std(kicked), measured), slip[:, None])
        )
    change = np.concatenate([_restitution_change(scene, d, sizes, name) for d in drops])
    radius = np.mean(scene.stated_axes_mm) * 5e-4
    # what the picture shows of the exchange
    turned = (log[:, TURN_OUT] ** 2 - log[:, TURN_IN] ** 2) * (radius / speed) ** 2
    floating = np.column_stack([np.ones(len(log)), turned])
    rest = returned - floating @ np.linalg.lstsq(floating, returned, rcond=None)[0]
    # a bounce that goes wholly into spin is an outlier that no fit would follow
    scatter = 1.4826 * np.median(np.abs(rest - np.median(rest)))
    sd = np.hypot(scatter, measured)
    own = np.repeat(np.eye(len(drops)), [len(d.log) for d in drops], axis=0)
    known = np.r_[np.inf, np.inf, np.full(len(drops), RUN_SD)]
    snr = scatter_snr(change, sd, np.column_stack([floating, own]), known)
    mean_sd = np.hypot(np.mean(sd) / np.sqrt(len(log)), RUN_SD / np.sqrt(len(drops)))
    # of a law, of a loss that grows and of a condition: at which speed, impact or value
    # is e to be compared?
    return Visibility(
        snr, float(np.mean(change) / mean_sd) if name == "film-adhesion" else None
    )


def _offsets(scene: Scene, log: np.ndarray) -> np.ndarray:
    """Distance of contacts beside the centre (n,), over the radius, by turn and
    kick."""
    radius = np.prod(scene.stated_axes_mm) ** (1 / 3) * 5e-4
    turn, kick = log[:, TURN_OUT] - log[:, TURN_IN], log[:, VX_OUT] - log[:, VX_IN]
    return (0.4 * radius * turn - kick) / (log[:, VZ_OUT] - log[:, VZ_IN])


def _restitution_change(
    scene: Scene, drop: SimulatedDrop, sizes: dict[str, float], name: str
) -> np.ndarray:
    """What the effect makes of e at each impact of one drop."""
    if name == "film-adhesion":
        e, lost = drop.log[:, E_LAW], sizes[name] / drop.log[:, V_NORMAL]
        return np.sqrt(np.maximum(e**2 - lost**2, 0)) - e
    _, other, _ = world(scene, drop.run, {k: v for k, v in sizes.items() if k != name})
    hits = [(row[V_NORMAL], k, row[UPRIGHT]) for k, row in enumerate(drop.log)]
    return np.array(
        [restitution(*hit, drop.impact) - restitution(*hit, other) for hit in hits]
    )
