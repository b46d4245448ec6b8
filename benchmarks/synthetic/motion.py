"""Motions with known truth: bouncing drops, sliding blocks, rolling seeds; and tracks
of them with noise.

Integrated from the equations of motion, independently of the formulas that are fitted
to them."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from benchtwin.vision.motion.track import Track, make_track

G = 9.80665


@dataclass(frozen=True)
class Motion:
    """A motion: place [mm, y up] and orientation [deg] at time t [s], and the true
    values.

    path(t) → x_mm, y_mm, angle_deg arrays. truth: the quantities of measurements.csv
    and what else is known. tilt(t) → the plate's angle in degrees (slide), or None."""

    path: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]]
    end_s: float
    truth: dict = field(default_factory=dict)
    tilt: Callable[[np.ndarray], np.ndarray] | None = None


def draw_drop(
    *,
    height_mm: float = 310.0,
    restitution: float | Sequence[float] = 0.5,
    lateral_m_s: float = 0.0,
    spin_rad_s: float = 0.0,
    kicks: Sequence[tuple[float, float]] = (),
    rest_s: float = 0.02,
    end_s: float | None = None,
    drag_per_m: float = 0.0,
    max_bounces: int = 12,
    radius_mm: float = 3.4,
    gravity: float = G,
) -> Motion:
    """A seed let go at `height_mm` (lowest point to plate) that bounces with
    `restitution` (one number, or one a bounce).

    y is the centroid's height over the plate. kicks: (Δ lateral m/s, Δ spin rad/s) of
    each bounce. drag_per_m: k of −k v|v|."""
    pieces = []  # (start, y0, vy, x0, vx, angle0, spin)
    t, vx, spin, x, angle = rest_s, lateral_m_s, spin_rad_s, 0.0, 0.0
    y, vy, low = (radius_mm + height_mm) / 1000, 0.0, radius_mm / 1000
    each = [restitution] if isinstance(restitution, float | int) else restitution
    bounces: list[dict[str, float]] = []
    for n in range(max_bounces + 1):
        flight, before, times, heights = _flight(y, vy, low, drag_per_m, gravity)
        pieces.append((t, flight, times, heights, x, vx, angle, spin))
        t, x, angle = t + flight, x + vx * flight, angle + spin * flight
        e = each[min(n, len(each) - 1)]
        kick = kicks[n] if n < len(kicks) else (0.0, 0.0)
        y, vy = low, e * before
        bounces.append(
            {
                "t_s": t,
                "before": before,
                "after": vy,
                "lateral_before": vx,
                "spin_before": spin,
            }
        )
        vx, spin = vx + kick[0], spin + kick[1]
        bounces[-1] |= {"lateral_after": vx, "spin_after": spin, "e": e}
        if vy < 0.02:
            break
    first = bounces[0]
    top = max(pieces[1][3]) - low if len(pieces) > 1 else 0.0
    truth = {
        "rebound_height": 1000 * top,
        "restitution": math.sqrt(1000 * top / height_mm),
        "impact_speed": first["before"],
        "rebound_speed": first["after"],
        "restitution_normal": first["e"],
        "bounces": bounces,
    }
    rest = (x, low, angle)

    def path(time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        time = np.asarray(time, dtype=float)
        px, py, pa = (
            np.zeros_like(time),
            np.full_like(time, 1000 * (radius_mm + height_mm) / 1000),
            np.zeros_like(time),
        )
        for start, flight, times, heights, x0, u, a0, w in pieces:
            here = (time >= start) & (time < start + flight)
            s = time[here] - start
            px[here], pa[here] = 1000 * (x0 + u * s), np.degrees(a0 + w * s)
            py[here] = 1000 * np.interp(s, times, heights)
        after = time >= t
        px[after], py[after], pa[after] = (
            1000 * rest[0],
            1000 * rest[1],
            np.degrees(rest[2]),
        )
        return px, py, pa

    return Motion(path, end_s or t + 0.02, truth)


def _flight(
    y: float, vy: float, low: float, drag: float, gravity: float, dt: float = 2e-5
):
    """One flight until y = low (velocity Verlet where there is drag): duration, speed
    at the end, path (times, heights)."""
    if drag == 0:
        end = math.sqrt(vy**2 + 2 * gravity * (y - low))
        last = (vy + end) / gravity
        times = np.linspace(0, last, max(int(last / dt), 2))
        return last, end, times, y + vy * times - gravity * times**2 / 2
    at, height, speed = [0.0], [y], vy

    def pull(v: float) -> float:
        return -gravity - drag * v * abs(v)

    while True:
        a = pull(speed)
        new = height[-1] + speed * dt + a * dt**2 / 2
        if new < low and speed + a * dt < 0:
            down = math.sqrt(speed**2 - 2 * a * (height[-1] - low))
            last = (height[-1] - low) * 2 / (down - speed)
            end = -(speed + a * last)
            return (
                at[-1] + last,
                end,
                np.array([*at, at[-1] + last]),
                np.array([*height, low]),
            )
        middle = speed + a * dt / 2
        speed += (a + pull(middle + a * dt / 2)) / 2 * dt
        at.append(at[-1] + dt)
        height.append(new)


def draw_slide(
    *,
    static: float = 0.35,
    kinetic: float = 0.28,
    tilt_rate_deg_s: float = 2.0,
    start_deg: float = 14.0,
    travel_mm: float = 80.0,
    wait_s: float = 0.0,
    slope_sign: float = 1.0,
) -> Motion:
    """A block on a plate that tilts at a constant rate from `start_deg`; it lets go at
    atan(static).

    x: travel along the plate (times `slope_sign`), y = 0. truth: slide_angle,
    static_friction, kinetic_friction."""
    onset = math.degrees(math.atan(static))
    begin = wait_s + (onset - start_deg) / tilt_rate_deg_s

    def tilt(time: np.ndarray) -> np.ndarray:
        return start_deg + tilt_rate_deg_s * np.maximum(
            np.asarray(time, dtype=float) - wait_s, 0.0
        )

    fine = np.arange(0, 60.0, 2e-4)
    angle = np.radians(onset + tilt_rate_deg_s * fine)
    # v' = pull + k v: the plate turns away from under the moving block, which presses
    # on it less by 2 ω v (Coriolis)
    k = 2 * kinetic * math.radians(tilt_rate_deg_s)
    pull = np.exp(-k * fine) * G * (np.sin(angle) - kinetic * np.cos(angle))
    speed = np.exp(k * fine) * np.concatenate(
        [[0.0], np.cumsum((pull[1:] + pull[:-1]) / 2) * 2e-4]
    )
    place = 1000 * np.concatenate(
        [[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2) * 2e-4]
    )
    end = (
        float(np.interp(travel_mm, place, fine)) if place[-1] > travel_mm else fine[-1]
    )

    def path(time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        time = np.asarray(time, dtype=float)
        x = np.interp(np.clip(time - begin, 0, end), fine, place)
        return slope_sign * x, np.zeros_like(x), np.zeros_like(x)

    truth = {
        "slide_angle": onset,
        "static_friction": static,
        "kinetic_friction": kinetic,
        "onset_s": begin,
    }
    return Motion(path, begin + end, truth, tilt)


def draw_roll(
    *,
    rolling: float = 0.012,
    incline_deg: float = 15.0,
    incline_mm: float = 10.0,
    rest_s: float = 0.1,
    end_rest_s: float = 0.3,
    corner_loss: float = 0.0,
    rock_mm: float = 0.0,
    rock_hz: float = 6.0,
    direction: float = 1.0,
) -> Motion:
    """A seed that rolls down `incline_mm` of a plate at `incline_deg`, then along the
    level until it stops.

    Accelerations (5/7) g (sin β − μ cos β) and −(5/7) μ g. x: travel along the path
    from the release, incline included. corner_loss: share of the speed lost at the
    junction. rock_mm: amplitude with which it rocks once it has stopped."""
    beta = math.radians(incline_deg)
    down = 5 / 7 * G * (math.sin(beta) - rolling * math.cos(beta))
    if down <= 0:
        raise ValueError(
            f"a seed with rolling friction {rolling} does not start on {incline_deg}°"
        )
    slow = 5 / 7 * rolling * G
    reach = math.sqrt(2 * incline_mm / 1000 / down)
    speed = down * reach * (1 - corner_loss)
    stop = speed / slow
    run = 1000 * speed**2 / (2 * slow)

    def path(time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        s = np.asarray(time, dtype=float) - rest_s
        first = 1000 * down * np.clip(s, 0, reach) ** 2 / 2
        late = np.clip(s - reach, 0, stop)
        x = first + 1000 * (speed * late - slow * late**2 / 2)
        rest = np.maximum(s - reach - stop, 0)
        x = x + rock_mm * np.sin(2 * np.pi * rock_hz * rest) * np.exp(-4 * rest)
        return direction * x, np.zeros_like(x), -np.degrees(x / 3.4) * direction

    friction = incline_mm * math.sin(beta) / (incline_mm * math.cos(beta) + run)
    truth = {
        "run_out": run,
        "rolling_friction": friction,
        "rolling_resistance": rolling,
        "incline_mm": incline_mm,
        "stop_s": rest_s + reach + stop,
        "junction_s": rest_s + reach,
    }
    return Motion(path, rest_s + reach + stop + end_rest_s, truth)


def film_track(
    motion: Motion,
    rng: np.random.Generator,
    *,
    fps: float = 5200.0,
    noise_mm: float = 0.025,
    ar: float = 0.0,
    until_s: float | None = None,
    tilt_noise_deg: float = 0.0,
    angle_noise_deg: float | None = None,
    start_s: float = 0.0,
) -> Track:
    """A track of the motion at `fps` with AR(1) noise of sd `noise_mm` and ρ = `ar`."""
    time = np.arange(start_s, motion.end_s if until_s is None else until_s, 1 / fps)
    x, y, angle = motion.path(time)
    extra: dict[str, Any] = {}
    if motion.tilt is not None:
        extra["tilt_deg"] = motion.tilt(time) + tilt_noise_deg * rng.standard_normal(
            len(time)
        )
    if angle_noise_deg is not None:
        extra["angle_deg"] = angle + correlated_noise(
            len(time), angle_noise_deg, ar, rng
        )
    x = x + correlated_noise(len(time), noise_mm, ar, rng)
    y = y + correlated_noise(len(time), noise_mm, ar, rng)
    return make_track(time, x, y, sd=max(noise_mm, 1e-6), **extra)


def correlated_noise(
    n: int, sd: float, ar: float, rng: np.random.Generator
) -> np.ndarray:
    """AR(1) noise of marginal sd `sd` and lag-one correlation `ar`, stationary from the
    first value."""
    white = sd * rng.standard_normal(n)
    if ar == 0:
        return white
    out = np.empty(n)
    out[0] = white[0]
    drive = math.sqrt(1 - ar**2)
    for i in range(1, n):
        out[i] = ar * out[i - 1] + drive * white[i]
    return out
