"""Balls drawn rolling past gates or before a slow camera: the equation of motion
integrated, the truth known, nothing of the reader."""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

G = 9.80665


@dataclass(frozen=True)
class Ball:
    """SI; inertia: 1 + I/(m r²); drag: k of a = −k v² in free flight; keep: share of
    the speed behind the corner at `length`."""

    beta: float
    mu: float
    inertia: float
    drag: float = 0.0
    length: float = np.inf
    keep: float = 1.0

    @property
    def acceleration(self) -> float:
        return G * (np.sin(self.beta) - self.mu * np.cos(self.beta)) / self.inertia


def way(ball: Ball, speed: float, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and places [m] on a fine grid, from x = 0 at `speed` until `seconds` or
    rest."""

    def leg(t0, x0, v0, drive, against, until):
        def rate(t, y):
            v = max(y[1], 0.0)
            return [
                v,
                (drive - against) * G / ball.inertia - ball.drag * v**2 / ball.inertia,
            ]

        ends = [lambda t, y: y[0] - until, lambda t, y: y[1] + (drive > 0)]
        for end in ends:
            end.terminal = True
        return solve_ivp(
            rate,
            (t0, seconds),
            [x0, v0],
            events=ends,
            rtol=1e-10,
            atol=1e-12,
            dense_output=True,
        )

    fine = np.linspace(0.0, seconds, 20_000)
    first = leg(
        0.0, 0.0, speed, np.sin(ball.beta), ball.mu * np.cos(ball.beta), ball.length
    )
    end = first.t[-1]
    x = first.sol(np.minimum(fine, end))[0]
    if np.isfinite(ball.length) and first.status == 1:
        place, fast = first.y[:, -1]
        second = leg(end, place, ball.keep * fast, 0.0, ball.mu, np.inf)
        x = np.where(fine <= end, x, second.sol(np.clip(fine, end, second.t[-1]))[0])
    return fine, x
