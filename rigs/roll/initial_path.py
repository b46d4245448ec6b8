"""A first path of a roll: at rest, speeding up, slowing down, at rest. Initialises the
fit.

x = x₀ + a D(t; t₀, t₁) + a k L(t; t₀, t₁, t₂): the speed of D grows by 1 a second from
t₀ to t₁, where it ends; that of L begins with the speed then reached and falls to 0 at
t₂; k: what the corner leaves of the speed."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from benchtwin.bench.language import tr

LATEST = 30.0  # corner and stop, in durations of the track
LEAST_BEFORE = 3  # rows before the corner that tell where it is
LOSS_CHI2 = 12.0  # fall of χ² by which a corner is seen to take some of the speed
CORNER_BEFORE = 0.1  # its begin, in its durations


@dataclass(frozen=True)
class Path:
    """Times [s] of release, corner, stop; place at release [m]; acceleration [m/s²];
    share of the speed that the corner leaves."""

    release: float
    corner: float
    stop: float
    place: float
    acceleration: float
    kept: float = 1.0

    @property
    def slowing(self) -> float:
        """Deceleration on the level [m/s²]."""
        return (
            self.kept
            * self.acceleration
            * (self.corner - self.release)
            / max(self.stop - self.corner, 1e-9)
        )

    @property
    def way_down(self) -> float:
        """Length of the incline [m]."""
        return self.acceleration * (self.corner - self.release) ** 2 / 2


def shapes(time: np.ndarray, release: float, corner: float, stop: float) -> np.ndarray:
    """D and L (n, 2) above."""
    down = np.clip(time - release, 0, max(corner - release, 0.0))
    level = np.clip(time - corner, 0, max(stop - corner, 1e-9))
    top = max(corner - release, 0.0)
    slowed = top * (level - level**2 / (2 * max(stop - corner, 1e-9)))
    return np.column_stack([down**2 / 2, slowed])


def fit_path(time: np.ndarray, x: np.ndarray) -> Path:
    """Least squares over all six numbers, from several starts; ValueError where nothing
    rolls."""
    thin = slice(None, None, max(1, len(time) // 200))
    t, y = time[thin], x[thin]
    begin, end = t[0], t[-1]
    span, way = end - begin, np.ptp(y)
    quarter = [
        float(np.interp(q * way + y[0], np.maximum.accumulate(y), t))
        for q in (0.01, 0.05, 0.2, 0.99)
    ]

    def solve(times, loses):
        both = shapes(t, *times)
        design = np.column_stack([np.ones(len(t)), both if loses else both.sum(1)])
        found = np.linalg.lstsq(design, y, rcond=None)[0]
        return found[[0, 1, -1]], y - design @ found

    def times_of(u):
        up, on = np.exp(np.minimum(u[1:], math.log(LATEST * span)))
        return u[0], u[0] + up, u[0] + up + on

    def misfit(u, loses):
        found, left = solve(times_of(u), loses)
        return np.log(left @ left + 1e-18) + 10 * (found[1:].min() < 0)

    def descended(start, loses, precision, most):
        options = {"xatol": precision[0], "fatol": precision[1], "maxfev": most}
        return minimize(misfit, start, (loses,), "Nelder-Mead", options=options)

    def first(share):
        up = share * span
        on = max(quarter[3] - quarter[0] - up, 0.2 * span)
        start = np.array([quarter[0], np.log(up), np.log(on)])
        return descended(start, False, (1e-5, 1e-4), 150)

    best = min(
        (first(share) for share in (0.03, 0.1, 0.25)), key=lambda found: found.fun
    )
    best = descended(best.x, False, (1e-6, 1e-6), 300)
    losing = descended(best.x, True, (1e-6, 1e-6), 300)
    loses = len(t) * (best.fun - losing.fun) > LOSS_CHI2
    release, corner, stop = times_of((losing if loses else best).x)
    (place, acceleration, level), _ = solve((release, corner, stop), loses)
    if not min(acceleration, level) > 0 or way < 2e-3:
        raise ValueError(tr("the track shows no seed that speeds up and slows down"))
    times = float(release), float(corner), float(stop)
    kept = float(level / acceleration)
    path = Path(*times, float(place), float(acceleration), kept)
    seen = corner > time[min(LEAST_BEFORE, len(time) - 1)]
    return path if seen else _gentle(path, float(begin), float(span))


def _gentle(path: Path, begin: float, span: float) -> Path:
    """The same motion from `begin` on, of a seed that came down a gentle incline: of
    any whose end is not in the track, the best conditioned."""
    corner = begin - CORNER_BEFORE * span
    speed = path.slowing * (path.stop - corner)
    end = path.place + path.way_down + path.slowing * (path.stop - path.corner) ** 2 / 2
    place = end - path.slowing * (path.stop - corner) ** 2 / 2 - speed * span / 2
    return Path(corner - span, corner, path.stop, place, speed / span)


def path_on_incline(time: np.ndarray, x: np.ndarray) -> Path:
    """Of a seed that stays on its incline: a parabola; corner and stop lie behind
    it."""
    going = int(np.argmax(x > x[0] + 0.02 * np.ptp(x)))
    first = max(min(going - 1, len(x) - 3), 0)
    at = time.mean()
    half, speed, place = np.polyfit(time[first:] - at, x[first:], 2)
    if not half > 0:
        raise ValueError(
            tr("the seed does not speed up on its incline: are its rows in order?")
        )
    rest = -speed / (2 * half)
    corner = time[-1] + 0.3 * (time[-1] - at - rest)
    return Path(
        float(at + rest),
        float(corner),
        float(2 * corner - at - rest),
        float(place - half * rest**2),
        float(2 * half),
    )


FEW_UNKNOWNS = 5  # of a path: place, release, corner, stop, acceleration
USUAL_FRICTION = 0.03


def path_of_few(
    time: np.ndarray, x: np.ndarray, f: float, incline: float, length: float
) -> Path:
    """Of few rows on both legs, from stated incline [rad] and length [m]; f: g over
    inertia."""
    if not (np.isfinite(incline) and np.isfinite(length)):
        if len(x) > FEW_UNKNOWNS:
            return fit_path(time, x)
        absent = [
            key
            for key, value in (("incline_deg", incline), ("incline_length_mm", length))
            if not np.isfinite(value)
        ]
        raise ValueError(
            tr(
                "[roll] {} missing: {} rows are too few without it, {} would do; [roll]"
                " level = false says that the seed stays on its incline",
                tr(" and ").join(absent),
                len(x),
                FEW_UNKNOWNS + 1,
            )
        )
    drive = f * (np.sin(incline) - USUAL_FRICTION * np.cos(incline))
    down = (2 * length / drive) ** 0.5
    if x[0] < 0.5 * length:
        release = time[0] - (2 * max(x[0], 0.0) / drive) ** 0.5
    else:  # the first rows are on the level, or next to it
        release = time[0] - down - max(x[0] - length, 0.0) / (drive * down)
    level = np.maximum(x - length, 1e-3)[x > length]
    slow = (drive * down) ** 2 / 2 / max(level.max() if len(level) else length, 1e-3)
    return Path(
        float(release),
        float(release + down),
        float(release + down + drive * down / slow),
        0.0,
        float(drive),
    )
