"""Drop tracks of a bench cut into flights, and linear candidate effects: common to all
baselines."""

import tomllib
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.integrate import cumulative_trapezoid
from scipy.signal import savgol_filter

G = 9806.65  # mm/s²
LEAST_JUMP = 250.0  # mm/s upwards, within a few milliseconds: a bounce
FLIGHT_NAMES = (
    "drag",
    "draught",
    "camera-roll",
    "scale-error",
    "perspective",
    "magnus",
    "silhouette-wobble",
)
IMPACT_NAMES = (
    "viscoelastic-restitution",
    "plastic-restitution",
    "film-adhesion",
    "impact-damage",
)


@dataclass(frozen=True, eq=False)
class Flight:
    """One free flight: times [s], places [mm], spin in the picture [rad/s] and angle
    [rad] (zero where not seen)."""

    t: np.ndarray
    x: np.ndarray
    y: np.ndarray
    spin: float
    angle: np.ndarray

    def residual(self) -> np.ndarray:
        """Places less what gravity does, less the best straight line, (2n,): x, then
        y."""
        return np.r_[self.bare(self.x), self.bare(self.y + 0.5 * G * self.t**2)]

    def bare(self, values: np.ndarray) -> np.ndarray:
        """values (n,) less their best straight line in time."""
        s = self.t - self.t.mean()
        return values - values.mean() - s * float(s @ values) / float(s @ s)

    def speeds(self) -> tuple[np.ndarray, np.ndarray]:
        """Velocity along the fitted parabola [mm/s]."""
        vx, middle = np.polyfit(self.t, self.x, 1)[0], self.t.mean()
        vy = np.polyfit(self.t, self.y + 0.5 * G * (self.t - middle) ** 2, 1)[0]
        return np.full(len(self.t), vx), vy - G * (self.t - middle)

    def columns(self) -> np.ndarray:
        """What each of FLIGHT_NAMES does to residual() per unit of its parameter, (2n,
        7); magnus in arbitrary units."""
        vx, vy = self.speeds()
        size, zero = np.hypot(vx, vy), np.zeros(len(self.t))
        drag = (-G * size * vx / 4e6, -G * size * vy / 4e6)
        pushes = {
            0: drag,
            1: (size / 1e3 * 10.0, zero),
            2: (zero - G * np.pi / 180, zero),
            5: (-self.spin * vy, self.spin * vx),
        }
        middle = self.y - self.y.mean()
        moved = {
            k: (_twice(ax, self.t), _twice(ay, self.t))
            for k, (ax, ay) in pushes.items()
        }
        moved |= {
            3: (zero, 0.5 * G * self.t**2),
            4: (middle * self.x * 1e-3, middle**2 * 1e-3),
        }
        moved[6] = (np.cos(2 * self.angle), np.sin(2 * self.angle))
        pairs = [moved[k] for k in range(len(FLIGHT_NAMES))]
        return np.column_stack([np.r_[self.bare(x), self.bare(y)] for x, y in pairs])


def _twice(values: np.ndarray, t: np.ndarray) -> np.ndarray:
    return cumulative_trapezoid(
        cumulative_trapezoid(values, t, initial=0), t, initial=0
    )


def read_drops(bench: Path) -> list[list[Flight]]:
    """The flights of every drop that has a track."""
    drops = []
    for file in sorted(bench.glob("*/track.csv")):
        if (
            tomllib.loads(
                (file.parent / "recording.toml").read_text(encoding="utf8")
            ).get("rig")
            == "drop"
        ):
            drops.append(cut(pd.read_csv(file)))
    return [d for d in drops if d]


def cut(track: pd.DataFrame) -> list[Flight]:
    """Flights of one track, between its bounces; frames near a bounce, and before the
    seed falls, are left out."""
    t, x, y = (track[name].to_numpy(float) for name in ("t_s", "x_mm", "y_mm"))
    if "angle_deg" in track:
        angle = np.unwrap(np.radians(track["angle_deg"].to_numpy(float)))
    else:
        angle = np.zeros(len(t))
    step = float(np.median(np.diff(t)))
    reach = max(4, round(0.006 / step))
    ends = [_fallen(t, y, reach), *_bounces(t, y, reach), len(t) - 1]
    flights = []
    for a, b in pairwise(ends):
        rows = slice(a + 3, b - 2)
        if b - a > 20:
            spin = np.polyfit(t[rows], angle[rows], 1)[0]
            flights.append(
                Flight(t[rows] - t[a], x[rows], y[rows], float(spin), angle[rows])
            )
    return flights


def _fallen(t: np.ndarray, y: np.ndarray, reach: int) -> int:
    """The first row from which it surely falls: 1 mm below where it was at first."""
    below = np.flatnonzero(
        np.convolve(y, np.ones(reach) / reach, "valid") < y[:reach].mean() - 1.0
    )
    return int(below[0]) if len(below) else 0


def _bounces(t: np.ndarray, y: np.ndarray, reach: int) -> list[int]:
    """Rows where the speed upwards jumps most."""
    lever = np.arange(reach) - (reach - 1) / 2
    slopes = (
        np.convolve(y, -lever, "valid")
        / float(lever @ lever)
        / float(np.median(np.diff(t)))
    )  # of rows i … i + reach − 1
    jump = np.zeros(len(t))
    jump[reach : len(t) - reach + 1] = slopes[reach:] - slopes[:-reach]
    found = []
    while jump.max() > LEAST_JUMP:
        i = int(np.argmax(jump))
        found.append(i)
        jump[max(0, i - 2 * reach) : i + 2 * reach] = 0
    return sorted(found)


def bounces(drops: list[list[Flight]]) -> pd.DataFrame:
    """count, speed [m/s] and restitution of every bounce between two flights."""
    rows = []
    for flights in drops:
        for k, (before, after) in enumerate(pairwise(flights)):
            speed, back = -before.speeds()[1][-1], after.speeds()[1][0]
            if speed > 100 and back > 0:
                rows.append(
                    {"count": k, "speed_m_s": speed / 1e3, "restitution": back / speed}
                )
    return pd.DataFrame(rows, columns=["count", "speed_m_s", "restitution"])


def impact_columns(found: pd.DataFrame) -> np.ndarray:
    """What each of IMPACT_NAMES does to the restitution, (n, 4), in arbitrary units."""
    v = found["speed_m_s"].to_numpy()
    return np.column_stack(
        [-(v**0.2), v**-0.25, -1 / v**2, found["count"].to_numpy(float)]
    )


def smooth_acceleration(
    flight: Flight,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray] | None:
    """(vx, vy, ax, ay) in m and s by Savitzky–Golay over 20 ms; None where the flight
    is too short."""
    step = float(np.median(np.diff(flight.t)))
    window = max(7, round(0.02 / step) // 2 * 2 + 1)
    if len(flight.t) < window + 4:
        return None
    out = [
        savgol_filter(v, window, 3, deriv=d, delta=step) * 1e-3
        for d in (1, 2)
        for v in (flight.x, flight.y)
    ]
    return tuple(v[window // 2 : -(window // 2)] for v in out)
