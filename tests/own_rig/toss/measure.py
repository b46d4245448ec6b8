"""A track of a seed thrown upwards → its speed, y(t) = y₀ + v t − g t²/2."""

import numpy as np

from benchtwin.bench.constants import G_M_S2
from benchtwin.vision.foreign.as_evidence import read_track
from benchtwin.vision.measurement import MeasurementError, Observation, Quantity
from benchtwin.vision.recording import Recording


def observe(recording: Recording, options=None, progress=None) -> Observation:
    """The launch speed [m/s] by least squares, gravity known."""
    if recording.evidence != "track.csv":
        raise MeasurementError(f"{recording.path}: a toss is measured on a track.csv")
    rows = read_track(recording.files[0]).rows
    t, y = rows.t_s.to_numpy() - rows.t_s.iloc[0], rows.y_mm.to_numpy() / 1000
    lines = np.column_stack([np.ones_like(t), t])
    found, *_ = np.linalg.lstsq(lines, y + G_M_S2 / 2 * t**2, rcond=None)
    off = y + G_M_S2 / 2 * t**2 - lines @ found
    covariance = off.var(ddof=2) * np.linalg.inv(lines.T @ lines)
    sd = float(np.sqrt(covariance[1, 1]))
    speed = Quantity("launch_speed", float(found[1]), sd, "m/s")
    return Observation(recording.id, "toss", (speed,))
