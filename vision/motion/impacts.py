"""The times of successive impacts, heard by a microphone → speeds and restitution, from the intervals alone.

A free flight that starts and ends on the plate lasts Δt = 2 v / g, so v = g Δt / 2, its height is g Δt² / 8, and the
restitution of the impact between two flights is e = Δt₂ / Δt₁. The first impact's speed is √(2 g H) of the stated fall.
Air drag shortens a flight of a soybean from 78 mm by less than 0.1 %; it is left out.
"""

import math

import numpy as np
import pandas as pd

from vision.measurement import Quantity, failed
from vision.motion.rebound import HEIGHT_SD_MM
from vision.recording import Recording

G = 9.80665
TIME_SD_S = 2e-4  # of one impact in a sound record: the rise of the click
LONGEST_S = 20.0  # an interval longer than this (490 m up) is no seed's bounce but a time in another unit
JUMP = 2.0  # by more than this factor no restitution differs from the next


def measure_impacts(times: np.ndarray, recording: Recording) -> tuple[tuple[Quantity, ...], pd.DataFrame, list[str]]:
    """Quantities, the table of bounces, notes. times [s], increasing, at least two."""
    gap = np.diff(times)
    time_sd = max(TIME_SD_S, _rounding(times) / math.sqrt(12))
    notes = [f"each impact's time is taken to be known to {1000 * time_sd:.2g} ms"]
    height = recording.drop.height_mm
    fall_speed = math.sqrt(2 * G * height / 1000) if height else math.nan
    fall_sd = fall_speed * HEIGHT_SD_MM / height / 2 if height else math.nan
    speed, speed_sd = G * gap / 2, G * time_sd * math.sqrt(2) / 2
    before = np.concatenate([[fall_speed], speed[:-1]])
    e = speed / before
    # Neighbouring intervals share the impact between them, so their errors are opposite: + 2 e / … below.
    later = np.sqrt(2 + 2 * e[1:] + 2 * e[1:] ** 2) * time_sd / gap[:-1]
    e_sd = np.concatenate([[e[0] * math.hypot(speed_sd / speed[0], fall_sd / fall_speed) if height else math.nan], later])
    bounces = pd.DataFrame({
        "recording": recording.id, "bounce": np.arange(1, len(gap) + 1), "t_s": times[:-1], "t_sd_s": time_sd,
        "speed_before_m_s": before, "speed_before_sd_m_s": [fall_sd, *[speed_sd] * (len(gap) - 1)],
        "speed_after_m_s": speed, "speed_after_sd_m_s": speed_sd,
        "height_mm": 1000 * G * gap**2 / 8, "height_sd_mm": 1000 * G * gap / 4 * time_sd * math.sqrt(2),
        "restitution": e, "restitution_sd": e_sd,
    })  # fmt: skip
    top = float(bounces.height_mm[0])
    quantities = [
        Quantity("rebound_height", top, float(bounces.height_sd_mm[0]), "mm"),
        Quantity("rebound_speed", float(speed[0]), speed_sd, "m/s"),
    ]
    if height:
        quantities.insert(1, Quantity("restitution", math.sqrt(top / height), float(e_sd[0]), "1"))
        quantities.insert(2, Quantity("impact_speed", fall_speed, fall_sd, "m/s"))
        quantities.append(Quantity("restitution_normal", float(e[0]), float(e_sd[0]), "1"))
    else:
        text = f"{recording.toml}: [drop] height_mm is missing; the first impact's speed is needed"
        quantities[1:1] = [failed("restitution", "1", text), failed("impact_speed", "m/s", text)]
        if len(gap) > 1:
            second = Quantity("restitution_normal", float(e[1]), float(e_sd[1]), "1")
            quantities.append(
                second.doubt("of the second impact: [drop] height_mm is missing, so the first one's speed is unknown")
            )
        else:
            quantities.append(failed("restitution_normal", "1", text))
    if wrong := _wrong_unit(gap, e, top, recording):
        return tuple(failed(q.name, q.unit, wrong) for q in quantities), bounces, [*notes, wrong]
    if (at := _missing(e)) is not None:
        what = f"an impact seems to be missing: interval {at + 1} ({gap[at]:.4g} s) does not fit the others"
        if at < 2:
            quantities = [q if q.quality == "failed" or q.name == "impact_speed" else q.doubt(what) for q in quantities]
        notes.append(what)
    return tuple(quantities), bounces, notes


def _wrong_unit(gap: np.ndarray, e: np.ndarray, top: float, recording: Recording) -> str:
    """Why times and heights cannot be in the units they should be in; "" when they can."""
    if gap.max() > LONGEST_S:
        return f"an interval of {gap.max():.4g} s between impacts: t_s is to be in seconds (are these milliseconds?)"
    height = recording.drop.height_mm
    if height and e[0] > 1.05:
        return (
            f"the first interval of {gap[0]:.4g} s is a rebound of {top:.4g} mm, higher than the drop ([drop] height_mm = "
            f"{height:g}): is height_mm in millimetres and t_s in seconds, or was an impact missed?"
        )
    return ""


def _missing(e: np.ndarray) -> int | None:
    """The first interval that is too long for its neighbours, as when two were taken for one; None where all fit."""
    longer = np.flatnonzero(e > 1)
    known = np.isfinite(e[:-1])
    jump = np.abs(np.log(e[1:] / e[:-1], where=known, out=np.zeros(len(e) - 1))) > math.log(JUMP)
    jumps = [int(k) if e[k] > e[k + 1] else int(k) + 1 for k in np.flatnonzero(jump)]
    return min([*map(int, longer), *jumps], default=None)


def _rounding(times: np.ndarray) -> float:
    """The step to which the times were rounded when written: 0.001 for 0.271, 0.522."""
    for digits in range(7):
        if np.allclose(times, np.round(times, digits), rtol=0, atol=1e-9):
            return 10.0**-digits
    return 0.0
