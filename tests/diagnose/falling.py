"""Drops made by other means than the solver's: a rigid ellipsoid in 3-D, fixed-step
Runge–Kutta, impulses at its lowest point.

Air by Abraham (1970), impacts by Coulomb's impulse with a given restitution of the
point of contact, a camera with a clock, scale, roll and trapezoid of its own, and noise
that is drawn frame by frame. Shares no formula with diagnose."""

import math
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

G, PIXEL_MM = 9.80665, 0.25
STATED = {
    "length_mm": 8.72,
    "width_mm": 6.84,
    "thickness_mm": 5.98,
    "density_kg_m3": 1250.0,
}


@dataclass(frozen=True)
class Bench:
    """What is true, and what is stated; lengths in m unless the name says otherwise."""

    axes: tuple[float, float, float] = (4.36e-3, 3.42e-3, 2.99e-3)
    density: float = 1250.0
    e: object = 0.55  # number, or a function (speed, count) → number
    friction: float = 0.3
    height: float = 0.310
    air: float = 1.2  # true air density
    stated_air: float = 1.2
    shape_drag: float = 1.0  # C_d over Abraham's
    lift: float = 0.0  # C of the Magnus law
    wind: float = 0.0
    lifted: float = (
        0.0  # 1/s: an upward pull that grows with the speed, which is on nobody's list
    )
    # against the motion, over the weight, at a speed [m/s], and as which power of it
    braked: tuple[float, float, float] = (0.0, 1.0, 1.0)
    spin: float = 0.0  # about the viewing axis at release
    tip_deg: float = 6.0  # sd of how far from flat a seed is let go
    bounces: int = 3
    fps: float = 1000.0
    tilt_deg: float = 0.0
    scale: float = 0.0  # true/stated − 1
    clock: float = 0.0
    roll_deg: float = 0.0
    keystone: float = 0.0  # 1/m
    away: float = (
        math.inf
    )  # distance of a pinhole from the plane in which the seed is let go
    wobble_mm: float = 0.0
    beside_mm: float = 0.0  # a tracked point from the centre of mass, along 0°
    lock_mm: float = 0.0  # by which places are read too far towards whole pixels
    noise_mm: float = 0.05
    rho: float = 0.9
    white: float = 0.0
    lost: float = 0.0
    stated_away_mm: float | None = None
    angle: bool = True
    more: dict = field(default_factory=dict)


def pull(bench: Bench, v, w) -> tuple[float, float, float]:
    """Acceleration [m/s²] at speed v [m/s] and spin w [1/s]."""
    volume = 4 / 3 * math.pi * math.prod(bench.axes)
    mass, radius = bench.density * volume, math.prod(bench.axes) ** (1 / 3)
    x, y, z = v[0] - bench.wind, v[1], v[2]
    speed = math.sqrt(x * x + y * y + z * z) + 1e-12
    drag = 0.0
    if bench.air:
        re = bench.air * speed * 2 * radius / 1.81e-5
        coefficient = (
            bench.shape_drag * 24 / 9.06**2 * (1 + 9.06 / math.sqrt(re + 1e-9)) ** 2
        )
        drag = 0.5 * bench.air * coefficient * math.pi * radius**2 * speed / mass
    if bench.braked[0]:
        share, at, power = bench.braked
        drag += share * G * (speed / at) ** power / speed
    lift = bench.lift * 1.2 * math.pi * radius**3 / (2 * mass)
    return (
        lift * (w[1] * v[2] - w[2] * v[1]) - drag * x,
        lift * (w[2] * v[0] - w[0] * v[2]) - drag * y,
        lift * (w[0] * v[1] - w[1] * v[0]) - drag * z + bench.lifted * speed - G,
    )


def fly(state, bench: Bench, dt: float):
    """One Runge–Kutta step of (position, velocity, rotation matrix, spin): 3-D,
    tumbling free of torque (spin kept)."""
    p, v, turn, w = state
    speed, spin = v.tolist(), w.tolist()

    def after(h, k):
        return [a + h * b for a, b in zip(speed, k)]

    k1 = pull(bench, speed, spin)
    k2 = pull(bench, after(dt / 2, k1), spin)
    k3 = pull(bench, after(dt / 2, k2), spin)
    k4 = pull(bench, after(dt, k3), spin)
    k1, k2, k3, k4 = (np.array(k) for k in (k1, k2, k3, k4))
    p = p + dt * v + dt * dt / 6 * (k1 + k2 + k3)
    v = v + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return p, v, turned_by(*spin, dt) @ turn, w


@lru_cache(maxsize=64)
def turned_by(x: float, y: float, z: float, dt: float):
    """What a spin [1/s] turns in a step [s]; the same from one impact to the next."""
    return rotation(np.array([x, y, z]) * dt)


def rotation(vector):
    """Rodrigues."""
    angle = math.sqrt(vector @ vector)
    if angle < 1e-14:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


def lowest(turn, axes, normal):
    """From the centre to the ellipsoid's furthest point against `normal`."""
    reach = turn @ (np.square(axes) * (normal @ turn))
    return -reach / math.sqrt(normal @ reach)


def bounce(state, bench: Bench, normal, count):
    """Impulse at the point of contact: restitution along the normal, stick if Coulomb
    allows, else sliding."""
    p, v, turn, w = state
    mass = bench.density * 4 / 3 * math.pi * np.prod(bench.axes)
    a, b, c = np.square(bench.axes)
    inertia = turn @ np.diag(mass / 5 * np.array([b + c, a + c, a + b])) @ turn.T
    arm = lowest(turn, bench.axes, normal)
    cross = np.array([[0, -arm[2], arm[1]], [arm[2], 0, -arm[0]], [-arm[1], arm[0], 0]])
    give = np.eye(3) / mass - cross @ np.linalg.inv(inertia) @ cross
    before = v + np.cross(w, arm)
    closing = -before @ normal
    e = bench.e(closing, count) if callable(bench.e) else bench.e
    impulse = np.linalg.solve(give, -before + e * closing * normal)
    along = impulse - (impulse @ normal) * normal
    if np.linalg.norm(along) > bench.friction * (impulse @ normal):
        slip = before - (before @ normal) * normal
        away = normal - bench.friction * slip / (np.linalg.norm(slip) + 1e-12)
        impulse = (1 + e) * closing / (normal @ give @ away) * away
    return (
        p,
        v + impulse / mass,
        turn,
        w + np.linalg.solve(inertia, np.cross(arm, impulse)),
    )


def motion(bench: Bench, rng):
    """t, x, z, angle in the picture, y away from the camera, and the times of contact,
    one row a frame."""
    tip = np.radians(bench.tip_deg) * rng.normal()
    turn = (
        rotation(np.array([0, 0, rng.uniform(0, 2 * math.pi)]))
        @ rotation(np.array([0, tip, 0]))
        @ rotation(np.array([rng.uniform(0, 6), 0, 0]))
    )
    tilt = math.radians(bench.tilt_deg)
    normal = np.array([math.sin(tilt), 0.0, math.cos(tilt)])
    state = (
        np.array([0, 0, bench.height])
        - lowest(turn, bench.axes, np.array([0, 0, 1.0])),
        np.zeros(3),
        turn,
        np.array([0.0, -bench.spin, 0.0]),
    )
    dt = min(1e-3, 1 / bench.fps)
    per_frame = max(round(1 / bench.fps / dt), 1)
    dt = 1 / bench.fps / per_frame
    rows, hits, angle, t = [(0.0, *state[0][[0, 2]], 0.0, 0.0)] * 1, [], 0.0, 0.0
    for frame in range(1, 40_000):
        for _ in range(per_frame):
            new = fly(state, bench, dt)
            near = new[0] @ normal < max(bench.axes)
            if near and (new[0] + lowest(new[2], bench.axes, normal)) @ normal < 0:
                low, high = 0.0, dt
                for _ in range(40):
                    mid = (low + high) / 2
                    there = fly(state, bench, mid)
                    low, high = (
                        (mid, high)
                        if (there[0] + lowest(there[2], bench.axes, normal)) @ normal
                        > 0
                        else (low, mid)
                    )
                there = fly(state, bench, low)
                if (
                    there[1] + np.cross(there[3], lowest(there[2], bench.axes, normal))
                ) @ normal < 0:
                    if not hits or t + low - hits[-1] > 0.01:
                        hits.append(t + low)
                    there = bounce(there, bench, normal, len(hits))
                new = fly(there, bench, dt - low)
            angle -= new[3][1] * dt
            state, t = new, t + dt
        rows.append((frame / bench.fps, state[0][0], state[0][2], angle, state[0][1]))
        if len(hits) > bench.bounces or t > 3:
            break
    return np.array(rows), hits


def noise(n, bench: Bench, rng):
    """White plus first-order correlated noise [mm], frame by frame."""
    slow, out = rng.normal(), np.empty(n)
    for i in range(n):
        slow = (
            bench.rho * slow + math.sqrt(1 - bench.rho**2) * rng.normal() if i else slow
        )
        out[i] = slow
    return bench.noise_mm * (
        math.sqrt(1 - bench.white) * out + math.sqrt(bench.white) * rng.normal(size=n)
    )


def film(bench: Bench, rng):
    """Columns of a track.csv [s, mm, mm, deg] and the frame numbers."""
    rows, _ = motion(bench, rng)
    t, x, z, angle, y = rows.T
    smaller = bench.away / (bench.away + y) if bench.away < math.inf else 1.0
    x, z = x * smaller, bench.height / 3 + (z - bench.height / 3) * smaller
    x, z = (
        1e3 * x + bench.wobble_mm * np.cos(2 * angle) + bench.beside_mm * np.cos(angle),
        1e3 * z + bench.wobble_mm * np.sin(2 * angle) + bench.beside_mm * np.sin(angle),
    )
    middle = 500 * bench.height
    roll = math.radians(bench.roll_deg)
    x, z = (
        x * math.cos(roll) + (z - middle) * math.sin(roll),
        middle + (z - middle) * math.cos(roll) - x * math.sin(roll),
    )
    shrink = (1 + bench.scale) * (1 + bench.keystone * (z - middle) / 1000)
    x, z = x / shrink, z / shrink
    x, z = (
        place + bench.lock_mm * np.sin(2 * math.pi * place / PIXEL_MM)
        for place in (x, z)
    )
    x, z = x + noise(len(t), bench, rng), z + noise(len(t), bench, rng)
    keep = rng.random(len(t)) >= bench.lost
    return (
        t[keep] * (1 + bench.clock),
        x[keep],
        z[keep],
        np.degrees(angle[keep]) + rng.normal(0, 1, keep.sum()),
        np.arange(len(t))[keep],
    )


def tracks(bench: Bench, count: int, rng, *, heights=None):
    """`count` recordings as twin.tracks gives them."""
    from pathlib import Path

    from benchtwin.bench.keys import Air, Camera, Seed
    from benchtwin.rigs.drop.keys import Drop
    from benchtwin.rigs.drop.read import drop_of
    from benchtwin.vision.motion.track import make_track
    from benchtwin.vision.recording import Recording

    out = []
    for i in range(count):
        here = replace(bench, height=heights[i % len(heights)]) if heights else bench
        t, x, z, angle, frame = film(here, rng)
        camera = Camera(
            fps=bench.fps,
            mm_per_px=PIXEL_MM,
            mm_per_px_sd=0.0002,
            plumb_deg=0.0,
            plumb_sd_deg=0.05,
            distance_mm=bench.stated_away_mm,
        )
        seed, air = Seed(**STATED), Air(density_kg_m3=bench.stated_air)
        told = Recording(
            f"drop-{i:02d}",
            Path(),
            "drop",
            "track.csv",
            (),
            seed=seed,
            camera=camera,
            air=air,
            drop=Drop(height_mm=1e3 * here.height),
        )
        seen = {"angle_deg": angle} if bench.angle else {}
        out.append(drop_of(make_track(t, x, z, frame=frame, **seen), told))
    return out
