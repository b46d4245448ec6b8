"""The cases of drops, and how visible an effect is in them.

Flight and picture: by the tracks, every flight a free parabola upwards and every bounce
a free kick sideways. Impacts: by the numbers that a bounce gives, each with the scatter
that the seeds' shape and spin give it, the mean restitution free; shape by the places
of contact."""

from functools import partial
from typing import Any

import numpy as np
from numba import njit
from scipy.integrate import cumulative_trapezoid

from benchtwin.prove.cases.bench import Scene
from benchtwin.prove.cases.camera import magnification, stated_times
from benchtwin.prove.cases.drop import (
    DEPTH_SD_MM,
    EFFECTS,
    IN_CAMERA,
    IN_FLIGHT,
    PUSH_SD_M_S,
    RUN_SD,
    Path,
    camera_of,
    draw,
    places,
    record,
    simulate,
    with_strengths,
)
from benchtwin.prove.cases.ellipsoid import rotation
from benchtwin.prove.cases.flight_laws import acceleration, restitution
from benchtwin.prove.cases.record import Cases, field_of
from benchtwin.prove.cases.snr import WHITE, Change, Fitted, Visibility, fitted, slopes
from benchtwin.prove.cases.stated import known_plumb_deg, known_scale

MARGIN_S = 4e-4
# of the air that is stated, beside a seed whose size and mass are known or not
DRAG_SD = (0.15, 0.6)
# of g at an unknown place on earth, relative: a fall does not tell it from a wrong
# scale or clock
GRAVITY_SD = 5e-4
LEAST_MEASURED_E = 0.004
LITTLE = 0.15  # sds of restitution
# of the radius: how far beside the centre the roundest of seeds is touched
ROUGHNESS = 0.02


def visibility(scene: Scene, name: str) -> Visibility:
    """How visible the effect `name` is beside the others."""
    if name in IN_FLIGHT or name in IN_CAMERA:
        return _by_track(scene, name)
    if name == "shape_conversion":
        return _by_places_of_contact(scene)
    return _by_impact(scene, name)


def _by_track(scene: Scene, name: str) -> Visibility:
    scale_sd = known_scale(scene.request, scene.scale_sd)
    known = {
        "scale_error": float(np.hypot(scale_sd, GRAVITY_SD)),
        "roll_deg": known_plumb_deg(scene.request, scene.plumb_sd_deg),
        "distortion": 2e-4,
        "perspective": 1e-3,
    }
    drag_sd = DRAG_SD[not scene.request.sizes_known()]
    paths = [simulate(world) for world in scene.worlds]
    logs = np.concatenate([path.log for path in paths])
    kick_sd = 1e3 * float(np.std(logs["vx_out"] - logs["vx_in"]))
    changes = []
    for path, world in zip(paths, scene.worlds):
        columns, own = own_nuisances(path, kick_sd, timed=name.startswith("clock"))
        camera, session = camera_of(world), f" in session {world.session}"
        moved = slopes(partial(places, path), camera, known)
        columns |= {key + session: column for key, column in moved.items()}
        shared = {key + session: sd for key, sd in known.items()} | {"air": drag_sd}
        if scene.request.rendered:  # nobody says how long the shutter reads a frame
            late = 0.5 - places(path, camera)[1] / (2 * camera.half_mm)
            columns["readout" + session] = 1e3 * path.rows[:, [3, 5]].T * late
            shared["readout" + session] = 1 / world.fps / np.sqrt(12)
        calm = world._replace(drag=0.0)
        columns["air"] = pushed(path, calm, calm._replace(air=0.0))
        without = world._replace(**{name: 0.0})
        # the frames stay where they are in truth; what the clock says of them moves
        late = stated_times(camera, path.true_s)
        late = late - stated_times(camera_of(without), path.true_s)
        change = places(path, camera) - places(path, camera_of(without))
        change -= 1e3 * path.rows[:, [3, 5]].T * (late - late[0])
        change += pushed(path, world, without)
        flying = flights(path) >= 0
        columns = {key: column[:, flying] for key, column in columns.items()}
        changes.append(Change(change[:, flying], columns, own, shared))
    fit = fitted(changes, scene.noise)
    return Visibility(
        fit.snr, _moved(paths, changes, fit) if name in IN_FLIGHT else None
    )


def _moved(paths: list[Path], changes: list[Change], fit: Fitted) -> float | None:
    """By how many sds restitution is off where a force is left out; None if fits
    differ.

    Each flight's speed takes its part of the force: δe/e = δv_out/v_out − δv_in/v_in,
    by straight lines through the flights and by a fit with all nuisances."""
    off = []
    for path, change, own in zip(paths, changes, fit.own, strict=True):
        flight = flights(path)
        inside = flight[flight >= 0]
        up, t = change.rows[1], path.true_s[flight >= 0]
        parts = [np.flatnonzero(inside == k) for k in range(int(flight.max()) + 1)]
        if min(map(len, parts)) < 4:
            continue
        lines = [np.polyfit(t[part], up[part], 1)[0] for part in parts]
        ends = [np.polyfit(t[part[-4:]], up[part[-4:]], 1)[0] for part in parts]
        fits = [own[f"speed {k}"] for k in range(len(parts))]
        log = path.log[: len(parts) - 1]
        slopes_of = np.array([lines, fits])
        late = slopes_of - ends
        v_in, v_out = 1e3 * log["vz_in"], 1e3 * log["vz_out"]
        change_of_e = -v_out / v_in * (slopes_of[:, 1:] / v_out - late[:, :-1] / v_in)
        off.append(change_of_e)
    by_method = np.hstack(off) if off else np.empty((2, 0))
    if by_method.shape[1] < 4:
        return None
    e = np.concatenate([-path.log["vz_out"] / path.log["vz_in"] for path in paths])
    plain, nuisanced = by_method.mean(axis=1) / np.std(e) * np.sqrt(len(e))
    less, more = sorted(map(abs, (plain, nuisanced)))
    alike = more < LITTLE or (plain * nuisanced > 0 and more < 3 * less)
    return float(plain) if alike else None


def own_nuisances(
    path: Path, kick_sd: float, timed: bool = False
) -> tuple[dict[str, np.ndarray], dict[str, float]]:
    """Columns and sds of what is each recording's own: height and speed of flights,
    kicks of bounces [mm/s]; timed: impacts move, too."""
    flight, t = flights(path), path.true_s
    count = int(flight.max()) + 1
    nil, one = np.zeros_like(t), np.ones_like(t)
    log = path.log[: count - 1]
    kicked = [np.maximum(t - at, 0) for at in (log["begin_s"] + log["end_s"]) / 2]
    jumps = [(t > at) * one for at in log["end_s"]] if timed else []
    columns = {
        f"across {k}": np.array([column, nil])
        for k, column in enumerate([one, t, *kicked, *jumps])
    }
    for k in range(count):
        columns[f"height {k}"] = np.array([nil, flight == k])
        columns[f"speed {k}"] = np.array([nil, (flight == k) * t])
    own = dict.fromkeys(columns, np.inf)
    camera = path.world.camera
    place = 1e3 * path.rows[:, [0, 2]].T - np.array(camera.centre_mm)[:, None]
    larger = magnification(camera.distance_mm, 1e3 * path.rows[:, 1])
    nearer = -place * larger**2 / camera.distance_mm  # for each mm behind
    sds = [DEPTH_SD_MM, 1e3 * PUSH_SD_M_S, *[max(kick_sd, 1.0)] * (count - 1)]
    for k, (column, sd) in enumerate(zip([one, t, *kicked], sds, strict=True)):
        columns[f"depth {k}"], own[f"depth {k}"] = column * nearer, sd
    return columns, own


def flights(path: Path) -> np.ndarray:
    """Which flight each frame is in; −1 while held or near a contact."""
    t = path.true_s
    flight = np.searchsorted(path.log["begin_s"], t, side="left")
    for hit in path.log:
        flight[(t > hit["begin_s"] - MARGIN_S) & (t < hit["end_s"] + MARGIN_S)] = -1
    flight[t <= 0] = -1
    return flight


def pushed(path: Path, world: Any, other: Any) -> np.ndarray:
    """What the difference of two worlds' flights moves (2, n) [mm], (x, z); the speed
    is put right at every bounce, the height too."""
    flight = flights(path)
    moved = np.zeros((2, len(flight)))
    across = 0.0
    for k in range(flight.max() + 1):
        rows = np.flatnonzero(flight == k)
        if len(rows) < 3:
            continue
        off = differences(path.rows[rows], world, other)[:, [0, 2]].T
        for _ in range(2):
            off = cumulative_trapezoid(off, path.true_s[rows], initial=0)
        moved[:, rows] = 1e3 * off
        moved[0, rows] += across  # a bounce kicks, it does not displace
        across = moved[0, rows[-1]]
    return moved


@njit(cache=True)
def differences(rows, world, other):
    """Acceleration in one world less that in another, (n, 3) for states (n, 13)."""
    out = np.empty((len(rows), 3))
    for i in range(len(rows)):
        place, v = rows[i, :3], rows[i, 3:6]
        spin = rotation(rows[i, 6:10]) @ rows[i, 10:13]
        out[i] = acceleration(place, v, spin, world)
        out[i] -= acceleration(place, v, spin, other)
    return out


def _by_places_of_contact(scene: Scene) -> Visibility:
    """How much more they scatter: 2 ln of the likelihoods' ratio, expected."""
    plain = scene.changed(shape_conversion=0.0)
    now, usual = (
        float(np.hypot(np.std(_offsets(one)), ROUGHNESS)) for one in (scene, plain)
    )
    ratio = now / usual
    gain = len(_offsets(scene)) * (ratio**2 - 1 - 2 * np.log(ratio))
    return Visibility(float(np.sqrt(max(gain, 0.0))))


def _offsets(scene: Scene) -> np.ndarray:
    """Distance of contacts beside the centre (n,), over the radius, by turn and
    kick."""
    log = np.concatenate([simulate(world).log for world in scene.worlds])
    radius = np.prod(scene.worlds[0].lot_axes_mm) ** (1 / 3) * 5e-4
    turn, kick = log["turn_out"] - log["turn_in"], log["vx_out"] - log["vx_in"]
    return (0.4 * radius * turn - kick) / (log["vz_out"] - log["vz_in"])


def _by_impact(scene: Scene, name: str) -> Visibility:
    paths = [simulate(world) for world in scene.worlds]
    log = np.concatenate([path.log for path in paths])
    if len(log) < 4:
        return Visibility(0.0)
    one, speed = scene.worlds[0], -log["vz_in"]
    radius = np.mean(one.lot_axes_mm) * 5e-4
    measured = LEAST_MEASURED_E + 3 * scene.noise.sd * 1e-3 / (speed * 0.1)
    if name == "plate_tilt":
        change = (1 + log["e"]) * np.radians(one.plate_tilt)
        turning = log["turn_in"] * radius * np.isfinite(one.angle_sd_deg)
        # nobody states how much of it friction takes
        columns = {"slip": (log["vx_in"] + turning) / speed}
        sd = np.hypot(np.std((log["vx_out"] - log["vx_in"]) / speed), measured)
        own = {}
    else:
        pairs = zip(paths, scene.worlds, strict=True)
        change = np.concatenate([_restitution_change(*pair, name) for pair in pairs])
        # what the picture shows of the exchange
        turned = (log["turn_out"] ** 2 - log["turn_in"] ** 2) * (radius / speed) ** 2
        columns = {"e": np.ones(len(log)), "turned": turned}
        floating = np.column_stack([*columns.values()])
        returned = log["vz_out"] / speed - log["e"]
        rest = returned - floating @ np.linalg.lstsq(floating, returned, rcond=None)[0]
        # a bounce that goes wholly into spin is an outlier that no fit would follow
        scatter = 1.4826 * np.median(np.abs(rest - np.median(rest)))
        sd = np.hypot(scatter, measured)
        own = {"seed": RUN_SD}
        columns["seed"] = columns["e"]
    shared = dict.fromkeys([key for key in columns if key not in own], np.inf)
    ends = np.cumsum([len(path.log) for path in paths])
    changes = [
        Change(
            (change[rows] / sd[rows])[None],
            {key: (column[rows] / sd[rows])[None] for key, column in columns.items()},
            own,
            shared,
        )
        for rows in np.split(np.arange(len(log)), ends[:-1])
    ]
    snr = fitted(changes, WHITE).snr
    # of a law, of a loss that grows and of a condition: at which speed, impact or value
    # is e to be compared?
    if name != "film_adhesion":
        return Visibility(snr)
    mean_sd = np.hypot(np.mean(sd) / np.sqrt(len(log)), RUN_SD / np.sqrt(len(paths)))
    return Visibility(snr, float(np.mean(change) / mean_sd))


def _restitution_change(path: Path, world: Any, name: str) -> np.ndarray:
    """What the effect makes of e at each impact of one drop."""
    log = path.log
    if name == "film_adhesion":
        lost = world.film_adhesion / log["normal_m_s"]
        return np.sqrt(np.maximum(log["e"] ** 2 - lost**2, 0)) - log["e"]
    other = with_strengths(world._replace(**{name: 0.0}))
    hits = enumerate(zip(log["normal_m_s"], log["upright"]))
    return log["e"] - [restitution(v, k, upright, other) for k, (v, upright) in hits]


def scored(scene: Scene, name: str) -> bool:
    """Not where a camera's effect is in one of two sessions only."""
    return not (field_of(name) in IN_CAMERA and scene.request.separated)


CASES = Cases(
    rig="drop",
    share=0.55,
    colour="#1f5fa8",
    effects=EFFECTS,
    draw=draw,
    visibility=visibility,
    record=record,
    scored=scored,
    design=("stated_mm", "session"),
    follows="restitution",
    singles=(
        "drag",
        "magnus",
        "draught",
        "viscoelastic-restitution",
        "plastic-restitution",
        "plate-compliance",
        "film-adhesion",
        "impact-damage",
        "plate-tilt",
        "shape-conversion",
        "camera-roll",
        "perspective",
        "silhouette-wobble",
    ),
    need_separation=("film-adhesion", "impact-damage"),
    confounded=("scale-error", "clock-error", "film-adhesion", "impact-damage"),
    separable=("film-adhesion", "impact-damage", "draught", "camera-roll"),
    pairs=(
        ("drag", "plate-tilt"),
        ("drag", "camera-roll"),
        ("drag", "silhouette-wobble"),
        ("plate-tilt", "perspective"),
        ("camera-roll", "viscoelastic-restitution"),
        ("draught", "viscoelastic-restitution"),
        ("perspective", "impact-damage"),
    ),
)
