"""The times of successive impacts, as a microphone hears them → speeds and restitution, from the intervals alone.

A free flight that starts and ends on the plate lasts Δt = 2 v / g, so v = g Δt / 2, its height is g Δt² / 8, and the
restitution of the impact between two flights is e = Δt₂ / Δt₁. The first impact's speed is √(2 g H) of the stated fall.
Air drag shortens a flight of a soybean from 78 mm by less than 0.1 %; it is left out. Where nobody says how well the times are
known, they are so well that rounding and scatter fit: times that err shift two intervals against each other, a restitution that
scatters does not.
"""

import math

import numpy as np
import pandas as pd

from vision.measurement import DOUBTFUL, FAILED, GOOD, Quantity, failed
from vision.motion.rebound import HEIGHT_SD_MM
from vision.recording import Recording

G = 9.80665
USUAL_SD_S, USUAL_FACTOR = 2e-4, 2.0  # of a time read off a sound record, before its scatter is looked at
LONGEST_S = 20.0  # an interval longer than this (490 m up) is no seed's bounce but a time in another unit
NOT_FIRST = "the impacts before were not all heard, so the speed of the first of these is unknown"
JUMP = 2.0  # by more than this factor no restitution differs from the next


def measure_impacts(
    times: np.ndarray, sd: np.ndarray | None, recording: Recording, *, first: bool = True
) -> tuple[tuple[Quantity, ...], pd.DataFrame, list[str]]:
    """Quantities, the table of bounces, notes. times [s], increasing, at least two; sd [s] of each, None where nobody knows;
    first: whether the first of them is the first after the release."""
    gap = np.diff(times)
    notes = []
    if sd is None:
        sd = np.full(len(times), usual_sd(times))
        notes.append(f"no sd_s is stated: each impact's time is taken to be known to {1000 * sd[0]:.2g} ms, by rounding and scatter")
    gap_sd = np.hypot(sd[:-1], sd[1:])
    height = recording.drop.height_mm if first else None
    fall_speed = math.sqrt(2 * G * height / 1000) if height else math.nan
    fall_sd = fall_speed * HEIGHT_SD_MM / height / 2 if height else math.nan
    speed, speed_sd = G * gap / 2, G * gap_sd / 2
    before = np.concatenate([[fall_speed], speed[:-1]])
    e = speed / before
    # Neighbouring intervals share the impact between them, so their errors are opposite.
    later = np.sqrt((e[1:] * sd[:-2]) ** 2 + ((1 + e[1:]) * sd[1:-1]) ** 2 + sd[2:] ** 2) / gap[:-1]
    e_sd = np.concatenate([[e[0] * math.hypot(speed_sd[0] / speed[0], fall_sd / fall_speed) if height else math.nan], later])
    bounces = pd.DataFrame({
        "recording": recording.id, "bounce": np.arange(1, len(gap) + 1), "t_s": times[:-1], "t_sd_s": sd[:-1],
        "speed_before_m_s": before, "speed_before_sd_m_s": [fall_sd, *speed_sd[:-1]],
        "speed_after_m_s": speed, "speed_after_sd_m_s": speed_sd,
        "height_mm": 1000 * G * gap**2 / 8, "height_sd_mm": 1000 * G * gap / 4 * gap_sd,
        "restitution": e, "restitution_sd": e_sd, "quality": _qualities(e, bool(height)),
    })  # fmt: skip
    top = float(bounces.height_mm[0])
    quantities = [
        Quantity("rebound_height", top, float(bounces.height_sd_mm[0]), "mm"),
        Quantity("rebound_speed", float(speed[0]), float(speed_sd[0]), "m/s"),
    ]
    if height:
        quantities.insert(1, Quantity("restitution", math.sqrt(top / height), float(e_sd[0]), "1"))
        quantities.insert(2, Quantity("impact_speed", fall_speed, fall_sd, "m/s"))
        quantities.append(Quantity("restitution_normal", float(e[0]), float(e_sd[0]), "1"))
    else:
        text = f"{recording.toml}: [drop] height_mm is missing; the first impact's speed is needed" if first else NOT_FIRST
        quantities[1:1] = [failed("restitution", "1", text), failed("impact_speed", "m/s", text)]
        if len(gap) > 1:
            second = Quantity("restitution_normal", float(e[1]), float(e_sd[1]), "1")
            why = "[drop] height_mm is missing, so the first one's speed is unknown" if first else NOT_FIRST
            quantities.append(second.doubt(f"of the second impact: {why}"))
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


def _qualities(e: np.ndarray, fallen: bool) -> list[str]:
    """Of each bounce: failed where no speed before it is known, doubtful where its restitution is none or leaves the others."""
    jump = np.zeros(len(e), bool)
    middle = np.nanmedian(e) if np.isfinite(e).any() else math.nan
    jump[np.isfinite(e)] = np.abs(np.log(e[np.isfinite(e)] / middle)) > math.log(JUMP)
    return [FAILED if not np.isfinite(value) else DOUBTFUL if value >= 1 or off else GOOD for value, off in zip(e, jump)]


def usual_sd(times: np.ndarray) -> float:
    """The sd [s] of times that nobody states one of: at least their rounding, and what their scatter says beside that of e."""
    least = _rounding(times) / math.sqrt(12)
    sigma = np.maximum(np.geomspace(2e-6, 2e-2, 41), least)
    log_weight = -0.5 * (np.log(sigma / USUAL_SD_S) / math.log(USUAL_FACTOR)) ** 2
    gap = np.diff(times)
    if len(gap) > 2:
        y = np.diff(np.log(gap))
        slope = np.zeros((len(y), len(times)))  # of y with the times
        for k in range(len(y)):
            slope[k, k : k + 3] = 1 / gap[k], -1 / gap[k] - 1 / gap[k + 1], 1 / gap[k + 1]
        centred = np.linalg.svd(np.ones((len(y), 1)))[0][:, 1:].T  # e itself is unknown
        values, shape = centred @ y, centred @ slope @ slope.T @ centred.T
        axes, turned = np.linalg.eigh(shape)
        seen = (turned.T @ values) ** 2
        variance = sigma[:, None, None] ** 2 * np.maximum(axes, 0) + np.geomspace(1e-3, 0.2, 15)[:, None] ** 2
        each = -0.5 * (np.log(variance) + seen / variance).sum(axis=2)
        log_weight = log_weight + np.logaddexp.reduce(each, axis=1)
    weight = np.exp(log_weight - log_weight.max())
    return float(max(np.exp(weight @ np.log(sigma) / weight.sum()), least))


def _rounding(times: np.ndarray) -> float:
    """The step to which the times were rounded when written: 0.001 for 0.271, 0.522."""
    for digits in range(7):
        if np.allclose(times, np.round(times, digits), rtol=0, atol=1e-9):
            return 10.0**-digits
    return 0.0
