"""Speeds and restitution of a drop from the times of its impacts.

A free flight that starts and ends on the plate lasts Δt = 2 v / g, so v = g Δt / 2, its
height is g Δt² / 8, and the restitution of the impact between two flights is e = Δt₂ /
Δt₁. The first impact's speed is √(2 g H) of the stated fall. Air drag is allowed for
where the seed is described (a = −g − k v |v|, in closed form); otherwise a soybean's
drag is part of the error. Unknown sds of the times are estimated from their rounding
and scatter: an error of a time changes two intervals in opposite ways, a scatter of the
restitution does not."""

import math

import numpy as np
import pandas as pd
from benchtwin.bench.constants import G_MM_S2
from benchtwin.vision.measurement import (
    DOUBTFUL,
    FAILED,
    GOOD,
    Quantity,
    all_failed,
    failed,
)
from benchtwin.vision.motion.gravity import SHAPE_SD, UNKNOWN_DRAG_PER_M, drag_per_metre
from benchtwin.vision.motion.rebound import HEIGHT_SD_MM
from benchtwin.vision.recording import Recording

G = G_MM_S2 / 1000  # m/s²
PRIOR_SD_S, PRIOR_FACTOR = 2e-4, 2.0  # log-normal prior of the sd of an impact time
LONGEST_S = 20.0  # of an interval (490 m up): longer ones are times in another unit
NOT_FIRST = (
    "the impacts before were not all heard, so the speed of the first of these is"
    " unknown"
)
# share of a fall's energy lost to the air, above which √(H2/H1) is no restitution
MOST_LOST = 0.1
JUMP = 2.0  # greatest factor between successive restitutions


def measure_impacts(
    times: np.ndarray,
    sd: np.ndarray | None,
    recording: Recording,
    *,
    first: bool = True,
) -> tuple[tuple[Quantity, ...], pd.DataFrame, list[str]]:
    """Quantities, the table of bounces, notes; times, sd [s]; first: whether the first
    impact is that after the release."""
    gap = np.diff(times)
    notes = []
    if sd is None:
        sd = estimate_time_sds(times)
        notes.append(
            "no sd_s is stated: each impact's time is taken to be known to"
            f" {1000 * sd[0]:.2g} ms, by rounding and scatter"
        )
    gap_sd = np.hypot(sd[:-1], sd[1:])
    height = recording.drop.height_mm if first else None
    drag, drag_sd, drag_notes = _drag(recording, float(gap[0]), height)
    notes += drag_notes
    before, speed, rise = _through_air(gap, height, drag)
    fall_speed, air = before[0], _through_air(gap, height, drag + drag_sd)
    e, e_air = speed / before, air[1] / air[0] - speed / before
    fall_sd = (
        math.hypot(fall_speed * HEIGHT_SD_MM / height / 2, air[0][0] - fall_speed)
        if height
        else math.nan
    )
    speed_sd = np.hypot(G * gap_sd / 2, air[1] - speed)
    before_sd = np.hypot(G * gap_sd[:-1] / 2, (air[0] - before)[1:])
    # Neighbouring intervals share the impact between them, so their errors are
    # opposite.
    later = (
        np.sqrt((e[1:] * sd[:-2]) ** 2 + ((1 + e[1:]) * sd[1:-1]) ** 2 + sd[2:] ** 2)
        / gap[:-1]
    )
    first_sd = (
        e[0] * math.hypot(gap_sd[0] / gap[0], HEIGHT_SD_MM / height / 2)
        if height
        else math.nan
    )
    e_sd = np.hypot(np.concatenate([[first_sd], later]), e_air)
    bounces = pd.DataFrame(
        {
            "recording": recording.id,
            "bounce": np.arange(1, len(gap) + 1),
            "t_s": times[:-1],
            "t_sd_s": sd[:-1],
            "speed_before_m_s": before,
            "speed_before_sd_m_s": [fall_sd, *before_sd],
            "speed_after_m_s": speed,
            "speed_after_sd_m_s": speed_sd,
            "height_mm": 1000 * rise,
            "height_sd_mm": 1000 * np.hypot(G * gap / 4 * gap_sd, air[2] - rise),
            "restitution": e,
            "restitution_sd": e_sd,
            "quality": _qualities(e),
        }
    )
    top = float(bounces.height_mm[0])
    quantities = [
        Quantity("rebound_height", top, float(bounces.height_sd_mm[0]), "mm"),
        Quantity("rebound_speed", float(speed[0]), float(speed_sd[0]), "m/s"),
    ]
    if height:
        by_height = math.sqrt(top / height)
        by_height_sd = (
            by_height
            / 2
            * math.hypot(float(bounces.height_sd_mm[0]) / top, HEIGHT_SD_MM / height)
        )
        if (lost := 1 - fall_speed**2 / (2 * G * height / 1000)) > MOST_LOST:
            text = (
                f"the air takes {100 * lost:.0f} % of the fall: √(H2/H1) ="
                f" {by_height:.4g} is no restitution"
            )
            notes.append(f"{text}; the ratio of the speeds is given")
            by_height, by_height_sd = float(e[0]), float(e_sd[0])
        quantities.insert(1, Quantity("restitution", by_height, by_height_sd, "1"))
        quantities.insert(2, Quantity("impact_speed", fall_speed, fall_sd, "m/s"))
        quantities.append(
            Quantity("restitution_normal", float(e[0]), float(e_sd[0]), "1")
        )
    else:
        text = (
            f"{recording.toml}: [drop] height_mm is missing; the first impact's speed"
            " is needed"
            if first
            else NOT_FIRST
        )
        quantities[1:1] = all_failed(
            (("restitution", "1"), ("impact_speed", "m/s")), text
        )
        if len(gap) > 1:
            second = Quantity("restitution_normal", float(e[1]), float(e_sd[1]), "1")
            reason = (
                "[drop] height_mm is missing, so the first one's speed is unknown"
                if first
                else NOT_FIRST
            )
            quantities.append(second.doubt(f"of the second impact: {reason}"))
        else:
            quantities.append(failed("restitution_normal", "1", text))
    if wrong := _wrong_unit(gap, e, top, recording):
        return (
            tuple(failed(q.name, q.unit, wrong) for q in quantities),
            bounces,
            [*notes, wrong],
        )
    if (at := _missed_interval(e)) is not None:
        what = (
            f"an impact seems to be missing: interval {at + 1} ({gap[at]:.4g} s) does"
            " not fit the others"
        )
        if at < 2:
            quantities = [
                (
                    q
                    if q.quality == "failed" or q.name == "impact_speed"
                    else q.doubt(what)
                )
                for q in quantities
            ]
        notes.append(what)
    return tuple(quantities), bounces, notes


def _drag(
    recording: Recording, gap: float, height: float | None
) -> tuple[float, float, list[str]]:
    """k [1/m] of a = −k v |v|, its sd, and a note."""
    speed = math.sqrt(2 * G * height / 1000) if height else G * gap / 2
    drag = drag_per_metre(recording, 0.75 * speed)
    if drag is None:
        return (
            0.0,
            UNKNOWN_DRAG_PER_M,
            [
                "air drag is not allowed for: [seed] sizes and mass_g or density_kg_m3"
                " are unknown"
            ],
        )
    share = drag * speed**2 / G
    return (
        drag,
        SHAPE_SD * drag,
        (
            [f"air drag (up to {100 * share:.1f} % of the weight) is allowed for"]
            if drag
            else []
        ),
    )


def _through_air(
    gap: np.ndarray, height: float | None, drag: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(m,) each: speed before and after each impact [m/s], height of the flight after
    it [m]; the first speed is the stated fall's."""
    k = max(drag, 1e-9)
    up = G * gap / 2
    for _ in range(12):  # Newton's steps would be two; the duration is nearly 2 v / g
        rise = np.log1p(k * up**2 / G) / (2 * k)
        lasts = (
            np.arctan(up * math.sqrt(k / G))
            + np.arcsinh(np.sqrt(np.expm1(2 * k * rise)))
        ) / math.sqrt(G * k)
        up = up * gap / lasts
    rise = np.log1p(k * up**2 / G) / (2 * k)
    down = np.sqrt(G / k * -np.expm1(-2 * k * rise))
    fall = (
        math.sqrt(G / k * -math.expm1(-2 * k * height / 1000)) if height else math.nan
    )
    return np.concatenate([[fall], down[:-1]]), up, rise


def _wrong_unit(
    gap: np.ndarray, e: np.ndarray, top: float, recording: Recording
) -> str:
    """Why times or heights cannot be in their units; "" where they can."""
    if gap.max() > LONGEST_S:
        return (
            f"an interval of {gap.max():.4g} s between impacts: t_s is to be in seconds"
            " (are these milliseconds?)"
        )
    height = recording.drop.height_mm
    if height and e[0] > 1.05:
        return (
            f"the first interval of {gap[0]:.4g} s is a rebound of {top:.4g} mm, higher"
            f" than the drop ([drop] height_mm = {height:g}): is height_mm in"
            " millimetres and t_s in seconds, or was an impact missed?"
        )
    return ""


def _missed_interval(e: np.ndarray) -> int | None:
    """The first interval too long for its neighbours, as when an impact was missed;
    None where all fit."""
    longer = np.flatnonzero(e > 1)
    known = np.isfinite(e[:-1])
    jump = np.abs(
        np.log(e[1:] / e[:-1], where=known, out=np.zeros(len(e) - 1))
    ) > math.log(JUMP)
    jumps = [int(k) if e[k] > e[k + 1] else int(k) + 1 for k in np.flatnonzero(jump)]
    return min([*map(int, longer), *jumps], default=None)


def _qualities(e: np.ndarray) -> list[str]:
    """Quality of each bounce: failed without a speed before it, doubtful for e ≥ 1 or
    far from the median of the others."""
    jump = np.zeros(len(e), bool)
    middle = np.nanmedian(e) if np.isfinite(e).any() else math.nan
    jump[np.isfinite(e)] = np.abs(np.log(e[np.isfinite(e)] / middle)) > math.log(JUMP)
    return [
        FAILED if not np.isfinite(value) else DOUBTFUL if value >= 1 or off else GOOD
        for value, off in zip(e, jump)
    ]


def estimate_time_sds(times: np.ndarray) -> np.ndarray:
    """(n,), all equal: estimated sd [s] of impact times without a stated one. Posterior
    mean from the scatter of ln Δt, in which errors of times and of e differ in
    correlation; at least the rounding."""
    least = _rounding(times) / math.sqrt(12)
    sigma = np.maximum(np.geomspace(2e-6, 2e-2, 41), least)
    log_weight = -0.5 * (np.log(sigma / PRIOR_SD_S) / math.log(PRIOR_FACTOR)) ** 2
    gap = np.diff(times)
    if len(gap) > 2:
        y = np.diff(np.log(gap))
        slope = np.zeros((len(y), len(times)))  # of y with the times
        for k in range(len(y)):
            slope[k, k : k + 3] = (
                1 / gap[k],
                -1 / gap[k] - 1 / gap[k + 1],
                1 / gap[k + 1],
            )
        centred = np.linalg.svd(np.ones((len(y), 1)))[0][:, 1:].T  # e itself is unknown
        values, shape = centred @ y, centred @ slope @ slope.T @ centred.T
        axes, turned = np.linalg.eigh(shape)
        power = (turned.T @ values) ** 2
        variance = (
            sigma[:, None, None] ** 2 * np.maximum(axes, 0)
            + np.geomspace(1e-3, 0.2, 15)[:, None] ** 2
        )
        each = -0.5 * (np.log(variance) + power / variance).sum(axis=2)
        log_weight = log_weight + np.logaddexp.reduce(each, axis=1)
    weight = np.exp(log_weight - log_weight.max())
    return np.full(
        len(times), max(np.exp(weight @ np.log(sigma) / weight.sum()), least)
    )


def _rounding(times: np.ndarray) -> float:
    """The step to which the times were rounded when written: 0.001 for 0.271, 0.522."""
    exact = (
        np.allclose(times, np.round(times, digits), rtol=0, atol=1e-9)
        for digits in range(7)
    )
    return next(
        (10.0**-digits for digits, is_exact in enumerate(exact) if is_exact), 0.0
    )
