"""Drop rig: track → rebound height, speeds, restitution, and a table of all bounces
with sds.

Heights are those of the centroid above its height at contact. The fall of a seed that
does not turn is thus the clearance of its lowest point, `drop.height_mm` of the
recording."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pandas as pd
from benchtwin.bench.constants import G_MM_S2
from benchtwin.vision.measurement import (
    DOUBTFUL,
    GOOD,
    MeasurementError,
    Quantity,
    all_failed,
    failed,
)
from benchtwin.vision.motion.drop_few_rows import FEW_ROWS, fit_few_flights, is_few
from benchtwin.vision.motion.flight import Flights, fit_flights, fit_lateral
from benchtwin.vision.motion.gravity import (
    depth_drift_sd,
    depth_drift_shifts,
    drag_one_sd_off,
    gravity_doubt,
    known_gravity,
    release_seen,
    scale_note,
)
from benchtwin.vision.motion.least_squares import propagate
from benchtwin.vision.motion.track import Track
from benchtwin.vision.recording import Recording

QUANTITIES = (
    ("rebound_height", "mm"),
    ("restitution", "1"),
    ("impact_speed", "m/s"),
    ("rebound_speed", "m/s"),
    ("restitution_normal", "1"),
)


@dataclass(frozen=True)
class Rebound:
    """Result for a drop; `track` has its outliers marked; contradicted: gravity
    contradicts the stated scale or frame rate."""

    quantities: tuple[Quantity, ...]
    bounces: pd.DataFrame | None
    flights: Flights | None
    track: Track
    notes: tuple[str, ...] = ()
    contradicted: bool = False


def measure_rebound(
    track: Track, recording: Recording, axis: tuple[float, float] | None = None
) -> Rebound:
    """Fit the flights of a drop and measure its bounces; axis: where the optical axis
    passes, for a track from pictures."""
    used = track.used()
    up, across = gravity_axes(used, recording)
    gravity, notes = known_gravity(used, recording)
    try:
        if len(used) < 4:
            raise MeasurementError(
                f"{len(used)} usable frames; a flight needs at least 4"
            )
        gates = recording.evidence == "gates.csv"
        few = gates or len(used) < FEW_ROWS
        fit_all = partial(fit_few_flights, gates=gates) if few else fit_flights
        flights = fit_all(used.time, used.frame, up, across, used.sd, gravity)
        doubt = gravity_doubt(flights, used, recording, gravity)
        if doubt:  # then neither gravity nor the scale is a prior
            gravity = replace(gravity, value=None)
            flights = fit_all(used.time, used.frame, up, across, used.sd, gravity)
    except MeasurementError as error:
        return Rebound(
            all_failed(QUANTITIES, str(error)), None, None, track, tuple(notes)
        )
    mask = track.outlier.copy()
    mask[np.flatnonzero(~track.outlier)[flights.outlier]] = True
    if flights.outlier.any():
        notes.append(
            f"{int(flights.outlier.sum())} frames lie off their flight and were left"
            " out (marked as outliers)"
        )
    if flights.unused:
        began = f"{used.time[flights.rows[0][0]]:.4g} {used.time_unit}"
        notes.append(
            f"before {began} the place moves, but not in a free fall (a hand, or a"
            " slip of the tracker): these rows are not used"
        )
    if flights.rho > 0.3:
        notes.append(
            f"successive frames err together (AR(1) ρ = {flights.rho:.2f}); the"
            " standard deviations allow for it"
        )
    marked = track.marked(mask & ~track.outlier)
    if len(flights.rows) < 2:
        reason = _no_bounce(flights, used, up)
        quantities = (
            *all_failed(QUANTITIES, reason),
            *_fall_acceleration(flights, used, recording),
        )
        return Rebound(
            quantities, None, flights, marked, (*notes, *([doubt] if doubt else []))
        )
    values, cov = propagate(
        lambda p: np.append(_derived(flights, p), p[-1]), flights.params, flights.cov
    )
    values, cov, by_scale = values[:-1], cov[:-1, :-1], cov[:-1, -1]
    air = np.zeros_like(
        values
    )  # an error common to all flights, which residuals do not show
    if (drag := drag_one_sd_off(flights, used, gravity, recording)) is not None:
        other = replace(gravity, drag=drag)
        air = _change_of_refit(
            partial(fit_all, used.time, used.frame, up, across, used.sd, other), values
        )
    cov = cov + np.outer(air, air)
    if axis is not None and used.physical:
        turn = math.radians(recording.camera.plumb_deg or 0.0)
        level = axis[0] * math.sin(turn) + axis[1] * math.cos(turn)
        for shift in depth_drift_shifts(
            flights, used.time, up, across, level, recording.camera.distance_mm
        ):
            off = _change_of_refit(
                partial(
                    fit_all, used.time, used.frame, up + shift, across, used.sd, gravity
                ),
                values,
            )
            cov = cov + np.outer(off, off)
    # A session shares the prior error of the scale, of which cov(·, ε)/sd(ε) remains in
    # a fit with gravity.
    common = np.hypot(air, by_scale / gravity.scale_sd if gravity.scale_sd > 0 else 0.0)
    bounces = _bounce_table(flights, used, across, values, cov, recording, axis is None)
    quantities, more = _quantities(
        flights, used, bounces.iloc[0], values, cov, common, recording, doubt
    )
    notes += more + ([] if doubt else scale_note(flights, used, gravity))
    return Rebound(quantities, bounces, flights, marked, tuple(notes), bool(doubt))


def _fall_acceleration(
    flights: Flights, track: Track, recording: Recording
) -> tuple[Quantity, ...]:
    """Quantity fall_acceleration of a fall without impact, drag included; none without
    scale or clock."""
    if not track.physical or not flights.free > 0:
        return ()
    sd = math.hypot(flights.free_sd, recording.camera.scale_sd * flights.free)
    return (Quantity("fall_acceleration", flights.free / 1000, sd / 1000, "m/s²"),)


def gravity_axes(track: Track, recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    """Height and sideways place in axes along gravity (`camera.plumb_deg`, clockwise
    from straight down)."""
    turn = math.radians(recording.camera.plumb_deg or 0.0)
    return (
        track.x * math.sin(turn) + track.y * math.cos(turn),
        track.x * math.cos(turn) - track.y * math.sin(turn),
    )


def _no_bounce(flights: Flights, track: Track, up: np.ndarray) -> str:
    drop = up[flights.rows[0]].max() - up[flights.rows[0]].min()
    end = up[-max(3, len(up) // 50) :]
    if np.ptp(end) < 0.01 * drop and len(up) - flights.rows[0][-1] > 5:
        return f"no rebound: after falling {drop:.4g} {track.unit} the seed stays down"
    return (
        f"no impact in the track: one flight of {drop:.4g} {track.unit}, no bounce"
        " (does the recording end too early?)"
    )


def _derived(flights: Flights, p: np.ndarray) -> np.ndarray:
    """For each bounce: t, height at contact, speed before, after, rebound height, e (6
    values); then the fall and √(H₂/H₁). Lengths and speeds are divided by 1 + ε, ε the
    error of the scale."""
    out, scale = [], 1 + p[-1]
    for k in range(len(flights.rows) - 1):
        t = flights.contact_time(k, p)
        contact = flights.height(k, t, p)
        before, after = -flights.speed(k, t, p), flights.speed(k + 1, t, p)
        top = flights.height(k + 1, flights.apex_time(k + 1, p), p) - contact
        out += [
            t,
            contact / scale,
            before / scale,
            after / scale,
            top / scale,
            after / before,
        ]
    fall = flights.fall(p)
    by_height = math.sqrt(max(out[4] * scale, 0.0) / fall) if fall > 0 else math.nan
    return np.array([*out, fall / scale, by_height])


def _change_of_refit(
    fit_again: Callable[[], Flights], values: np.ndarray
) -> np.ndarray:
    """Change of the derived values in another fit; 0 where that fails or finds other
    bounces."""
    try:
        again = fit_again()
    except MeasurementError:
        return np.zeros_like(values)
    moved = _derived(again, again.params)
    return moved - values if len(moved) == len(values) else np.zeros_like(values)


def _bounce_table(
    flights, track: Track, across, values, cov, recording: Recording, plain_depth: bool
) -> pd.DataFrame:
    """A row for each bounce, numbers with sds; columns have the track's units.
    plain_depth: `cov` contains no motion in depth."""
    physical = track.physical
    length, time = track.unit, track.time_unit
    speed, factor = ("m_s", 1e-3) if physical else (f"{length}_{time}", 1.0)
    plumb = math.radians(recording.camera.plumb_sd)
    side, side_cov = fit_lateral(
        flights, track.time, track.frame, across, track.sd, plumb
    )
    sds = np.sqrt(np.maximum(np.diag(cov), 0))
    rows = []
    for k in range(len(flights.rows) - 1):
        t, contact, before, after, top, e = values[6 * k : 6 * k + 6]
        t_sd, contact_sd, before_sd, after_sd, top_sd, e_sd = sds[6 * k : 6 * k + 6]

        def sideways(p, k=k, t=t):
            return [p[2 * j + 1] + p[-1] * (t - flights.middle[j]) for j in (k, k + 1)]

        swing, swing_cov = propagate(sideways, side, side_cov)
        swing_sd = np.sqrt(np.diag(swing_cov))
        # A plumb line off by φ mixes φ times the sideways motion into the height, and
        # the reverse.
        e_sd = math.hypot(e_sd, plumb * (swing[1] + e * swing[0]) / before)
        if k > 0 and physical and plain_depth:
            lasts = np.array([t - values[6 * k - 6], 2 * after / G_MM_S2])
            e_sd = math.hypot(
                e_sd,
                e
                * depth_drift_sd(
                    np.abs(swing), lasts, before, recording.camera.distance_mm
                ),
            )
        before_sd, after_sd = (
            math.hypot(before_sd, plumb * swing[0]),
            math.hypot(after_sd, plumb * swing[1]),
        )
        top_sd = math.hypot(top_sd, plumb * swing[1] * (flights.apex_time(k + 1) - t))
        tilt_sd = np.hypot(swing_sd, plumb * np.array([before, after]))
        row = {
            "recording": recording.id,
            "drop": 1,
            "bounce": k + 1,
            f"t_{time}": t,
            f"t_sd_{time}": t_sd,
        }
        numbers = {
            f"speed_before_{speed}": (before, before_sd),
            f"speed_after_{speed}": (after, after_sd),
            f"lateral_before_{speed}": (swing[0], tilt_sd[0]),
            f"lateral_after_{speed}": (swing[1], tilt_sd[1]),
        }
        for name, (value, sd) in numbers.items():
            row[name], row[name.replace(f"_{speed}", f"_sd_{speed}")] = (
                value * factor,
                sd * factor,
            )
        for name, flight in (("spin_before", k), ("spin_after", k + 1)):
            row[f"{name}_rad_{time}"], row[f"{name}_sd_rad_{time}"] = track.spin(
                flights.rows[flight]
            )
        row |= {f"contact_{length}": contact, f"contact_sd_{length}": contact_sd}
        row |= {
            f"height_{length}": top,
            f"height_sd_{length}": top_sd,
            "restitution": e,
            "restitution_sd": e_sd,
        }
        few = min(len(flights.rows[k]), len(flights.rows[k + 1])) < 5
        cut = track.time[flights.rows[k + 1][-1]] < flights.apex_time(k + 1)
        row["quality"] = (
            DOUBTFUL if few or cut or not 0.02 < e < 1 or e_sd > 0.1 * e else GOOD
        )
        rows.append(row)
    return pd.DataFrame(rows)


def _quantities(
    flights: Flights,
    track: Track,
    bounce: pd.Series,
    values,
    cov,
    common,
    recording: Recording,
    doubt: str,
):
    """The five quantities of the first bounce, and notes; common: sds of `values` that
    all recordings of a session share."""
    physical = track.physical
    unit, suffix = (
        ("m/s", "m_s")
        if physical
        else (f"{track.unit}/{track.time_unit}", f"{track.unit}_{track.time_unit}")
    )
    sds = np.sqrt(np.maximum(np.diag(cov), 0))
    fall, fall_sd, top = values[-2], sds[-2], float(bounce[f"height_{track.unit}"])

    def quantity(
        name: str, column: str, unit: str, suffix: str, shared: float
    ) -> Quantity:
        sd = float(bounce[f"{column}_sd{suffix}"])
        return Quantity(
            name,
            float(bounce[f"{column}{suffix}"]),
            sd,
            unit,
            sd_common=min(float(shared), sd),
        )

    factor = 1e-3 if physical else 1.0
    height = quantity(
        "rebound_height", "height", track.unit, f"_{track.unit}", common[4]
    )
    impact = quantity(
        "impact_speed", "speed_before", unit, f"_{suffix}", factor * common[2]
    )
    rebound = quantity(
        "rebound_speed", "speed_after", unit, f"_{suffix}", factor * common[3]
    )
    normal = quantity("restitution_normal", "restitution", "1", "", common[5])
    notes = []
    stated, seen = recording.drop.height_mm, release_seen(flights, track)
    turned = max(height.sd**2 - sds[4] ** 2, 0.0) ** 0.5  # by the plumb, beside `cov`
    turned = turned / top if top > 0 else math.nan
    by_fall = float(values[-1]), math.hypot(sds[-1], values[-1] * turned / 2)
    if stated and track.unit == "mm" and top > 0:
        off_sd = recording.drop.height_sd
        e = math.sqrt(top / stated)
        e_sd, e_common = (
            e / 2 * math.hypot(sd / top, off_sd / stated)
            for sd in (height.sd, height.sd_common)
        )
        both = e / top / 2 * (cov[-1, 4] + by_fall[0] * turned**2 * top / 2)
        restitution = _likeliest(
            (e, e_sd, e_common), (*by_fall, float(common[-1])), float(both)
        )
        if abs(fall - stated) > off_sd + 2 * fall_sd:
            text = (
                f"the fall seen is {fall:.4g} ± {fall_sd:.2g} mm but [drop] height_mm"
                f" says {stated:g}"
            )
            if abs(fall - stated) > max(3 * math.hypot(fall_sd, off_sd), 0.02 * stated):
                text += ": one of them is in a wrong unit or wrong"
                restitution = restitution.doubt(text)
            notes = [text]
    elif seen:
        restitution = Quantity(
            "restitution", *by_fall, "1", sd_common=min(float(common[-1]), by_fall[1])
        )
        notes.append(f"H1 is the fall seen, {fall:.5g} ± {fall_sd:.2g} {track.unit}")
    else:
        missing = (
            "[camera] mm_per_px is missing, which height_mm"
            if stated
            else "[drop] height_mm"
        )  # stated, and a track in px
        text = (
            f"the release is not in the track; {recording.toml}: {missing}"
            f" {'needs' if stated else 'is needed'}"
        )
        restitution = failed("restitution", "1", text)
    quantities = [height, restitution, impact, rebound, normal]
    if doubt:
        quantities = [
            q if q is normal or (q is restitution and not stated) else q.doubt(doubt)
            for q in quantities
        ]
    return tuple(_doubtful(q, flights, track, normal.value) for q in quantities), notes


def _likeliest(
    one: tuple[float, float, float], other: tuple[float, float, float], both: float
) -> Quantity:
    """Restitution of least variance from two estimates (value, sd, common sd) with the
    covariance `both`, the other one perhaps NaN; what is common is of different
    causes."""
    values, sds, common = np.array([one, other]).T
    cov = np.array([[sds[0] ** 2, both], [both, sds[1] ** 2]])
    apart = sds[0] ** 2 + sds[1] ** 2 - 2 * both
    share = 0.0
    if np.isfinite(other[:2]).all() and apart > 0:
        share = float(np.clip((sds[0] ** 2 - both) / apart, 0.0, 1.0))
    kept = np.array([1 - share, share]) > 0
    weight = np.array([1 - share, share])[kept]
    sd = math.sqrt(weight @ cov[np.ix_(kept, kept)] @ weight)
    shared = min(float(np.linalg.norm(weight * common[kept])), sd)
    value = float(weight @ values[kept])
    return Quantity("restitution", value, sd, "1", sd_common=shared)


def _doubtful(quantity: Quantity, flights: Flights, track: Track, e: float) -> Quantity:
    """The quantity with the doubts that apply to it."""
    first, second = flights.rows[0], flights.rows[1]
    if is_few(flights):
        if quantity.name != "impact_speed" and not 0.02 < e < 1:
            quantity = quantity.doubt(
                f"restitution {e:.3g} is not that of a free bounce"
            )
        return quantity
    if quantity.name != "impact_speed":
        if len(second) < 5:
            quantity = quantity.doubt(f"only {len(second)} frames of the first rebound")
        if track.time[second[-1]] < flights.apex_time(1):
            low, top = (
                flights.height(1, t)
                for t in (flights.contact_time(0), flights.apex_time(1))
            )
            last = flights.height(1, track.time[second[-1]])
            share = float(
                (last - low) / max(top - low, 1e-12)
            )  # of the rise that is seen
            if quantity.name in ("rebound_height", "restitution") and (
                len(second) < 8 or share < 0.6
            ):
                text = (
                    "the recording stops before the rebound's highest point"
                    f" ({len(second)} frames, {100 * share:.0f} % of it)"
                )
                return failed(
                    quantity.name,
                    quantity.unit,
                    quantity.reason if quantity.quality == "failed" else text,
                )
            quantity = quantity.doubt(
                "the track ends before the rebound's highest place, which is"
                " extrapolated"
            )
        if not 0.02 < e < 1:
            quantity = quantity.doubt(
                f"restitution {e:.3g} is not that of a free bounce"
            )
    if len(first) < 5:  # they determine the height at contact
        quantity = quantity.doubt(f"only {len(first)} frames before the first impact")
    if quantity.value and quantity.sd > 0.1 * abs(quantity.value):
        quantity = quantity.doubt("known no better than 10 %")
    sd = np.median(track.sd)
    if (
        np.isfinite(sd)
        and flights.noise > 5 * sd
        and flights.noise > 0.003 * np.ptp(track.y)
    ):
        text = (
            f"places scatter {flights.noise:.2g} {track.unit} about the parabolas,"
            f" their stated sd is {sd:.2g}"
        )
        quantity = quantity.doubt(text)
    return quantity
