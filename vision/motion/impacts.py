"""Speeds and restitution of a drop from the times of its impacts.

A free flight that starts and ends on the plate lasts Δt = 2 v / g, so v = g Δt / 2, its
height is g Δt² / 8, and the restitution of the impact between two flights is e = Δt₂ /
Δt₁. The first impact's speed is √(2 g H) of the stated fall, which the later bounces
correct (first_bounce.py). Air drag is allowed for
where the seed is described (a = −g − k v |v|, in closed form); otherwise a soybean's
drag is part of the error. Unknown sds of the times are estimated from their rounding
and scatter: an error of a time changes two intervals in opposite ways, a scatter of the
restitution does not."""

import math
from dataclasses import replace

import numpy as np
import pandas as pd
from benchtwin.bench.air import (
    SHAPE_SD,
    SLOWEST_M_S,
    UNKNOWN_DRAG_PER_M,
    air_of,
    drag_at,
    through_air,
)
from benchtwin.bench.constants import G_MM_S2
from benchtwin.bench.ellipsoid import elongation
from benchtwin.vision.measurement import (
    DOUBTFUL,
    FAILED,
    GOOD,
    Quantity,
    all_failed,
    failed,
)
from benchtwin.vision.motion.first_bounce import first_bounce, first_flat_sd
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
    gap, given, notes = np.diff(times), sd, []
    if sd is None:
        sd = estimate_time_sds(times)
        notes.append(
            "no sd_s is stated: each impact's time is taken to be known to"
            f" {1000 * sd[0]:.2g} ms, by rounding and scatter"
        )
    gap_sd = np.hypot(sd[:-1], sd[1:])
    height = recording.drop.height_mm if first else None
    height_m = height / 1000 if height else None
    drag, drag_sd, drag_notes = _drag(recording, float(gap[0]), height)
    notes += drag_notes
    before, speed, rise = through_air(gap, height_m, drag)
    air = through_air(gap, height_m, drag + drag_sd)
    e, e_air = speed / before, air[1] / air[0] - speed / before
    # Neighbouring intervals share the impact between them, so their errors are
    # opposite.
    late = np.zeros((len(gap), len(times)))  # of e with the times, which are late by sd
    rows = np.arange(len(gap))
    late[rows, rows + 1], late[rows, rows] = sd[1:] / gap, -sd[:-1] / gap
    late[1:] -= late[:-1].copy()
    late *= e[:, None]
    e_sd = np.hypot(np.sqrt((late**2).sum(axis=1)), e_air)
    speed_sd = np.hypot(G * gap_sd / 2, air[1] - speed)
    before_sd = np.append(
        math.nan, np.hypot(G * gap_sd[:-1] / 2, (air[0] - before)[1:])
    )
    doubt, e_common = "", np.abs(e_air)
    by_height = math.sqrt(1000 * rise[0] / height) / e[0] if height else math.nan
    if height:
        lost = 1 - before[0] ** 2 / (2 * G * height / 1000)
        told = first_bounce(
            e,
            late @ late.T + np.outer(e_air, e_air),
            before,
            height,
            recording.drop.height_sd,
            first_flat_sd(elongation(recording.seed.sizes_mm)),
        )
        e[0], e_sd[0] = told.value, told.sd
        doubt = told.doubt(recording.drop.height_sd)
        e_common[0] = math.hypot(e_air[0], told.by_height)
        before[0] = speed[0] / e[0]
        before_sd[0] = before[0] * math.hypot(e_sd[0] / e[0], gap_sd[0] / gap[0])
    at = _missed_interval(e)
    if at is not None and at < 2:  # said below: it is not the height's fault
        doubt = ""
    rise_air = air[2] - rise
    bounces = pd.DataFrame(
        {
            "recording": recording.id,
            "drop": 1,
            "bounce": np.arange(1, len(gap) + 1),
            "t_s": times[:-1],
            "t_sd_s": sd[:-1],
            "speed_before_m_s": before,
            "speed_before_sd_m_s": before_sd,
            "speed_after_m_s": speed,
            "speed_after_sd_m_s": speed_sd,
            "height_mm": 1000 * rise,
            "height_sd_mm": 1000 * np.hypot(G * gap / 4 * gap_sd, rise_air),
            "restitution": e,
            "restitution_sd": e_sd,
            "quality": _qualities(e),
        }
    )

    def quantity(name: str, column: str, unit: str, common: float, row: int = 0):
        value, sd = (
            float(bounces[c][row]) for c in (column, column.replace("_m", "_sd_m"))
        )
        return Quantity(name, value, sd, unit, sd_common=min(abs(common), sd))

    top = 1000 * float(rise[0])
    quantities = [
        quantity("rebound_height", "height_mm", "mm", 1000 * rise_air[0]),
        quantity("rebound_speed", "speed_after_m_s", "m/s", (air[1] - speed)[0]),
    ]
    if height:
        e1 = float(e[0])
        normal = Quantity(
            "restitution_normal", e1, float(e_sd[0]), "1", sd_common=float(e_common[0])
        ).doubt(doubt)
        if lost > MOST_LOST:
            text = (
                f"the air takes {100 * lost:.0f} % of the fall: √(H2/H1) ="
                f" {by_height * e1:.4g} is no restitution"
            )
            notes.append(f"{text}; the ratio of the speeds is given")
            by_height = 1.0
        scaled = (by_height * v for v in (normal.value, normal.sd, normal.sd_common))
        value, value_sd, common = scaled
        quantities[1:1] = [
            replace(
                normal, name="restitution", value=value, sd=value_sd, sd_common=common
            ),
            quantity(
                "impact_speed", "speed_before_m_s", "m/s", before[0] / e1 * e_common[0]
            ).doubt(doubt),
        ]
        quantities.append(normal)
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
            second = Quantity(
                "restitution_normal",
                float(e[1]),
                float(e_sd[1]),
                "1",
                sd_common=float(e_common[1]),
            )
            reason = (
                "[drop] height_mm is missing, so the first one's speed is unknown"
                if first
                else NOT_FIRST
            )
            quantities.append(second.doubt(f"of the second impact: {reason}"))
        else:
            quantities.append(failed("restitution_normal", "1", text))
    if gap.max() > LONGEST_S:
        wrong = (
            f"an interval of {gap.max():.4g} s between impacts: t_s is to be in seconds"
            " (are these milliseconds?)"
        )
        all_wrong = tuple(failed(q.name, q.unit, wrong) for q in quantities)
        return all_wrong, bounces, [*notes, wrong]
    if height and top > 1.1 * height + 3 * recording.drop.height_sd:
        return _without_height(
            times, given, recording, _too_low(height, gap[0], top, e)
        )
    if at is not None:
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


def _too_low(height: float, gap: float, top: float, e: np.ndarray) -> str:
    """Why the stated height [mm] is not that of the drop, with the height that the
    second bounce makes likely."""
    said = (
        f"the first interval of {gap:.4g} s is a rebound of {top:.4g} mm, higher than"
        f" the drop ([drop] height_mm = {height:g}): is height_mm in millimetres and"
        " t_s in seconds, or was an impact missed?"
    )
    if len(e) > 1 and 0 < e[1] < 1:
        likely = float(f"{top / e[1] ** 2:.2g}")
        said += f" The bounces behind make {likely:g} mm likely"
    return said


def _without_height(
    times: np.ndarray, sd: np.ndarray | None, recording: Recording, why: str
) -> tuple[tuple[Quantity, ...], pd.DataFrame, list[str]]:
    """What the impacts tell by themselves, where the stated height cannot be."""
    unstated = {"drop": recording.drop.model_copy(update={"height_mm": None})}
    alone = replace(recording, **unstated)
    quantities, bounces, notes = measure_impacts(times, sd, alone)
    told = tuple(
        failed(q.name, q.unit, why)
        if q.quality == FAILED
        else replace(q, reason="").doubt(why)
        for q in quantities
    )
    return told, bounces, [*notes, why]


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


def drag_per_metre(recording: Recording, speed: float) -> float | None:
    """k [1/m] of a = −k v |v| for the recording's seed and air at `speed` [m/s], as of
    a sphere of equal volume (bench.air); None where the seed is not described."""
    seed = recording.seed
    if not recording.air.density_kg_m3:
        return 0.0
    if not seed.sizes_mm or not (seed.mass_g or seed.density_kg_m3):
        return None
    about = {
        "seed": seed.model_dump(exclude_none=True),
        "air": recording.air.model_dump(exclude_none=True),
    }
    return drag_at(air_of(about), max(speed, SLOWEST_M_S))
