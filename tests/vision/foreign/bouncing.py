"""A ball that bounces, in closed form: let go at rest, impacts of one restitution, no
air. Shares nothing with the readers."""

import numpy as np

G = 9.80665
HEIGHT_M, RESTITUTION = 0.5, 0.8
IMPACTS_S = np.sqrt(2 * HEIGHT_M / G) * np.cumsum(
    [1.0, 2 * RESTITUTION, 2 * RESTITUTION**2, 2 * RESTITUTION**3, 2 * RESTITUTION**4]
)


def height_m(t: np.ndarray) -> np.ndarray:
    """Height above the plate [m] at the times t [s] after the release, up to the fifth
    impact."""
    y = HEIGHT_M - G * t**2 / 2
    speed = np.sqrt(2 * G * HEIGHT_M)
    for k, at in enumerate(IMPACTS_S[:-1], 1):
        s = t - at
        y = np.where(s >= 0, speed * RESTITUTION**k * s - G * s**2 / 2, y)
    return y


def ball(fps: float = 120.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Frames, x and y [m] of a film of it that ends before the fourth impact; it drifts
    sideways by 20 mm/s."""
    frame = np.arange(int(IMPACTS_S[3] * fps))
    t = frame / fps
    return frame, 0.1 + 0.02 * t, height_m(t)
