"""Drop tracks of a bench cut into flights, and linear candidate effects: common to all
baselines."""

import tomllib
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.integrate import cumulative_trapezoid
from scipy.signal import find_peaks

G = 9806.65  # mm/s²
LEAST_JUMP = 250.0  # mm/s upwards, within a few milliseconds: a bounce


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
        return self._bare(self.x, self.y + 0.5 * G * self.t**2)

    def _bare(self, *pair: np.ndarray) -> np.ndarray:
        """Both (n,) less their best straight lines in time, (2n,)."""
        both = np.column_stack(pair)
        line = np.column_stack([np.ones_like(self.t), self.t])
        return (both - line @ np.linalg.lstsq(line, both, rcond=None)[0]).T.ravel()

    def speeds(self) -> tuple[np.ndarray, np.ndarray]:
        """Velocity along the fitted parabola [mm/s]."""
        vx, middle = np.polyfit(self.t, self.x, 1)[0], self.t.mean()
        vy = np.polyfit(self.t, self.y + 0.5 * G * (self.t - middle) ** 2, 1)[0]
        return np.full(len(self.t), vx), vy - G * (self.t - middle)

    def columns(self) -> pd.DataFrame:
        """What each effect does to residual() per unit of its parameter, (2n, 7);
        magnus in arbitrary units."""
        vx, vy = self.speeds()
        size, zero = np.hypot(vx, vy), np.zeros(len(self.t))
        pushes = {
            "drag": (-G * size * vx / 4e6, -G * size * vy / 4e6),
            "draught": (size / 1e3 * 10.0, zero),
            "camera-roll": (zero - G * np.pi / 180, zero),
            "magnus": (-self.spin * vy, self.spin * vx),
        }
        middle = self.y - self.y.mean()
        moved = {name: map(self._twice, pair) for name, pair in pushes.items()} | {
            "scale-error": (zero, 0.5 * G * self.t**2),
            "perspective": (middle * self.x * 1e-3, middle**2 * 1e-3),
            "silhouette-wobble": (np.cos(2 * self.angle), np.sin(2 * self.angle)),
        }
        return pd.DataFrame({name: self._bare(*pair) for name, pair in moved.items()})

    def _twice(self, values: np.ndarray) -> np.ndarray:
        for _ in range(2):
            values = cumulative_trapezoid(values, self.t, initial=0)
        return values


def read_drops(bench: Path) -> list[list[Flight]]:
    """The flights of every drop that has a track."""
    drops = []
    for file in sorted(bench.glob("*/track.csv")):
        text = (file.parent / "recording.toml").read_text(encoding="utf8")
        if tomllib.loads(text).get("rig") == "drop":
            drops.append(cut(pd.read_csv(file)))
    return [d for d in drops if d]


def cut(track: pd.DataFrame) -> list[Flight]:
    """Flights of one track, between its bounces; frames near a bounce, and before the
    seed falls, are left out."""
    track = track.reindex(columns=["t_s", "x_mm", "y_mm", "angle_deg"]).fillna(0.0)
    t, x, y, angle = track.to_numpy(float).T
    angle = np.unwrap(np.radians(angle))
    step = float(np.median(np.diff(t)))
    reach = max(4, round(0.006 / step))
    # it surely falls from where it is 1 mm below where it was at first
    smooth = np.convolve(y, np.ones(reach) / reach, "valid")
    fallen = int(np.argmax(smooth < y[:reach].mean() - 1.0))
    flights = []
    for a, b in pairwise([fallen, *_bounces(y, step, reach), len(t) - 1]):
        rows = slice(a + 3, b - 2)
        if b - a > 20:
            spin = float(np.polyfit(t[rows], angle[rows], 1)[0])
            flights.append(Flight(t[rows] - t[a], x[rows], y[rows], spin, angle[rows]))
    return flights


def _bounces(y: np.ndarray, step: float, reach: int) -> np.ndarray:
    """Rows where the speed upwards jumps most."""
    lever = np.arange(reach) - (reach - 1) / 2
    # of rows i … i + reach − 1
    slopes = np.convolve(y, -lever, "valid") / float(lever @ lever) / step
    jump = slopes[reach:] - slopes[:-reach]
    return reach + find_peaks(jump, height=LEAST_JUMP, distance=2 * reach)[0]


def bounces(drops: list[list[Flight]]) -> pd.DataFrame:
    """count, speed [m/s] and restitution of every bounce between two flights."""
    rows = []
    for flights in drops:
        for k, (before, after) in enumerate(pairwise(flights)):
            speed, back = -before.speeds()[1][-1], after.speeds()[1][0]
            if speed > 100 and back > 0:
                rows.append((k, speed / 1e3, back / speed))
    return pd.DataFrame(rows, columns=["count", "speed_m_s", "restitution"])


def impact_columns(found: pd.DataFrame) -> pd.DataFrame:
    """What each effect does to the restitution of bounces, (n, 4), in arbitrary
    units."""
    v = found["speed_m_s"]
    return pd.DataFrame(
        {
            "viscoelastic-restitution": -(v**0.2),
            "plastic-restitution": v**-0.25,
            "film-adhesion": -1 / v**2,
            "impact-damage": found["count"].astype(float),
        }
    )
