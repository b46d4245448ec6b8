"""The drop rig: a track or the times of its impacts → rebound height, speeds, restitution, every bounce with its sd.

Heights count from where the seed's centroid is at contact, so a fall is the way the centroid goes, which for a seed that
does not turn is the clearance of its lowest point, the `drop.height_mm` of the recording.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from vision.correlated import fit, frame_lag, propagate
from vision.flight import G_MM_S2, Flights, Gravity, fit_flights, lateral
from vision.measurement import MeasurementError, Quantity, failed
from vision.recording import Recording
from vision.track import Track

HEIGHT_SD_MM = 1.0  # how well a stated release height is known: a seed held by hand or clamp, read off a ruler
OTHER_SD = 1e-3  # perspective and lens over a fall, and local gravity, relative
UNKNOWN_AIR_SD = 0.01  # drag on a seed whose size and mass are not stated (a soybean over 310 mm: 1.4 % of g)
SHAPE_SD = 0.15  # drag coefficient of a seed beside that of a sphere, relative
QUANTITIES = (
    ("rebound_height", "mm"), ("restitution", ""), ("impact_speed", "m/s"), ("rebound_speed", "m/s"),
    ("restitution_normal", ""),
)  # fmt: skip


@dataclass(frozen=True)
class Rebound:
    """What a drop is read for. flights is None when nothing flew; `track` has its outliers marked."""

    quantities: tuple[Quantity, ...]
    bounces: pd.DataFrame | None
    flights: Flights | None
    track: Track
    notes: tuple[str, ...] = ()


def measure_rebound(track: Track, recording: Recording) -> Rebound:
    """Flights, impacts and restitution of a drop. Never raises for a track without a bounce: those quantities fail."""
    used = track.used()
    up, across = upright(used, recording)
    gravity, notes = _known_gravity(used, recording)
    try:
        if len(used) < 4:
            raise MeasurementError(f"{len(used)} usable frames; a flight needs at least 4")
        flights = fit_flights(used.time, used.frame, up, used.sd, gravity)
    except MeasurementError as error:
        return Rebound(all_failed(str(error)), None, None, track, tuple(notes))
    doubt = gravity_doubt(flights, used, recording, gravity)
    if doubt and gravity.value is not None:  # gravity and the scale contradict each other: neither may bend the fit
        loose = Gravity(None, gravity.scale_sd, gravity.other_sd, gravity.drag)
        flights = fit_flights(used.time, used.frame, up, used.sd, loose)
    mask = track.outlier.copy()
    mask[np.flatnonzero(~track.outlier)[flights.outlier]] = True
    if flights.outlier.any():
        notes.append(f"{int(flights.outlier.sum())} frames lie off their flight and were left out (marked as outliers)")
    if flights.rho > 0.3:
        notes.append(f"successive frames err together (AR(1) ρ = {flights.rho:.2f}); the standard deviations allow for it")
    marked = track.marked(mask & ~track.outlier)
    if len(flights.rows) < 2:
        reason = _no_bounce(flights, used, up)
        return Rebound(all_failed(reason), None, flights, marked, (*notes, *([doubt] if doubt else [])))
    values, cov = propagate(lambda p: _derived(flights, p), flights.params, flights.cov)
    bounces = _bounce_table(flights, used, across, values, cov, recording)
    quantities, more = _quantities(flights, used, values, cov, recording, doubt)
    quantities = tuple(replace(q, sd=float(bounces.restitution_sd[0])) if q.name == "restitution_normal" else q for q in quantities)
    notes += more + ([] if doubt else _scale_note(flights, used, gravity, recording))
    return Rebound(quantities, bounces, flights, marked, tuple(notes))


def upright(track: Track, recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    """Height and sideways place in axes along gravity (`camera.plumb_deg`, clockwise from straight down)."""
    turn = math.radians(recording.camera.plumb_deg or 0.0)
    return (
        track.x * math.sin(turn) + track.y * math.cos(turn),
        track.x * math.cos(turn) - track.y * math.sin(turn),
    )


def all_failed(reason: str) -> tuple[Quantity, ...]:
    return tuple(failed(name, unit, reason) for name, unit in QUANTITIES)


def drag_per_metre(recording: Recording, speed: float) -> float | None:
    """k [1/m] of a = −k v |v| for the recording's seed and air at `speed` [m/s]; None when the seed is not described.

    k = ρ_a C_d π d² / (8 m), d the diameter of the sphere of equal volume, C_d of Schiller & Naumann (1935) up to
    Re 1000 and 0.44 beyond (Re < 2e5). A seed's own C_d differs by about SHAPE_SD.
    """
    seed, air = recording.seed, recording.air
    if air.density_kg_m3 == 0:
        return 0.0
    sizes = [s for s in (seed.length_mm, seed.width_mm, seed.thickness_mm) if s]
    if not sizes or not (seed.mass_g or seed.density_kg_m3):
        return None
    diameter = float(np.prod(sizes)) ** (1 / len(sizes)) / 1000
    mass = seed.mass_g / 1000 if seed.mass_g else seed.density_kg_m3 * math.pi / 6 * diameter**3
    if air.viscosity_pa_s > 0:
        reynolds = max(air.density_kg_m3 * speed * diameter / air.viscosity_pa_s, 1e-3)
        coefficient = 24 / reynolds * (1 + 0.15 * reynolds**0.687) if reynolds < 1000 else 0.44
    else:
        coefficient = 0.44
    return air.density_kg_m3 * coefficient * math.pi * diameter**2 / (8 * mass)


def _known_gravity(track: Track, recording: Recording) -> tuple[Gravity, list[str]]:
    """How γ is to be held in the fit, and what to say about scale, time and air."""
    physical = track.unit == "mm" and track.timed
    if not physical:
        unknown = " and ".join(
            [] + (["scale"] if track.unit == "px" else []) + (["frame rate"] if not track.timed else []))
        return Gravity(None), [f"{unknown} unknown: lengths in {track.unit}, times in {track.time_unit}; ratios do not need them"]  # fmt: skip
    speed = math.sqrt(max(np.ptp(track.y), 1e-9) / 1000 * 2 * 9.80665)
    drag = drag_per_metre(recording, 0.75 * speed)
    if drag is None:
        text = "air drag is not allowed for: [seed] sizes and mass_g or density_kg_m3 are unknown"
        return Gravity(G_MM_S2, recording.camera.scale_sd, math.hypot(OTHER_SD, UNKNOWN_AIR_SD)), [text]
    share = drag * speed**2 / 9.80665
    notes = [f"air drag (up to {100 * share:.1f} % of the weight) is allowed for in the parabolas"] if drag else []
    other = math.hypot(OTHER_SD, SHAPE_SD * share / 2)
    return Gravity(G_MM_S2, recording.camera.scale_sd, other, drag / 1000), notes


def gravity_doubt(flights: Flights, track: Track, recording: Recording, gravity: Gravity) -> str:
    """Why the flights' own gravity cannot be true at the stated scale and frame rate; "" when it can."""
    if gravity.value is None:
        return ""
    ratio = flights.free / gravity.value
    allowed = math.sqrt((flights.free_sd / gravity.value) ** 2 + gravity.scale_sd**2 + gravity.other_sd**2)
    if abs(ratio - 1) < 3 * allowed or len(np.concatenate(flights.rows)) < 6:
        return ""
    text = f"free fall gives {flights.free / 1000:.3g} m/s² instead of 9.81"
    if ratio <= 0:
        return f"{text}: this is no free fall (is y upwards?)"
    rate = math.sqrt(ratio)
    fps = f"the frame rate is stated {max(rate, 1 / rate):.3g} × too {'high' if ratio > 1 else 'low'}"
    scale = f"the scale (mm_per_px) {max(ratio, 1 / ratio):.3g} × too {'large' if ratio > 1 else 'small'}"
    stated = recording.drop.height_mm
    if stated and len(flights.rows) > 1 and _release_seen(flights, track):
        fall = _derived(flights, flights.params)[-2]
        if abs(fall / stated - 1) < 0.03:
            return f"{text}: {fps} (the fall of {stated:g} mm is right, so the scale is)"
        if abs(fall / stated / ratio - 1) < 0.05:
            return f"{text}: {scale} (the fall reads {fall:.4g} mm instead of {stated:g})"
    if abs(ratio - 1) < 0.1 and gravity.other_sd > 0.9 * UNKNOWN_AIR_SD:
        return f"{text}: {fps}, or {scale}, or air drag counts (state [seed] sizes and mass_g)"
    return f"{text}: {fps}, or {scale}"


def _release_seen(flights: Flights, track: Track) -> bool:
    """Whether the first flight's apex lies inside the track (a seed let go, not one that flies in)."""
    first, fall_time = flights.apex_time(0), track.time[flights.rows[0][-1]] - flights.apex_time(0)
    return first >= track.time[0] - max(0.03 * fall_time, 1.5 * track.step)


def _no_bounce(flights: Flights, track: Track, up: np.ndarray) -> str:
    drop = up[flights.rows[0]].max() - up[flights.rows[0]].min()
    end = up[-max(3, len(up) // 50) :]
    if np.ptp(end) < 0.01 * drop and len(up) - flights.rows[0][-1] > 5:
        return f"no rebound: after falling {drop:.4g} {track.unit} the seed stays down"
    return f"no impact in the track: one flight of {drop:.4g} {track.unit}, no bounce (does the recording end too early?)"


def _derived(flights: Flights, p: np.ndarray) -> np.ndarray:
    """Of each bounce: t, height at contact, speed before, after, rebound height, e (6 each); then the fall and √(H₂/H₁).

    Lengths and speeds are divided by 1 + ε, the scale's error.
    """
    out = []
    for k in range(len(flights.rows) - 1):
        t = flights.meeting(k, p)
        contact = flights.height(k, t, p)
        before, after = -flights.speed(k, t, p), flights.speed(k + 1, t, p)
        top = flights.height(k + 1, flights.apex_time(k + 1, p), p) - contact
        out += [t, contact / (1 + p[-1]), before / (1 + p[-1]), after / (1 + p[-1]), top / (1 + p[-1]), after / before]
        if k == 0:
            fall = flights.height(0, flights.apex_time(0, p), p) - contact
            first_top = top
    return np.array([*out, fall / (1 + p[-1]), math.sqrt(max(first_top, 0.0) / fall) if fall > 0 else math.nan])


def _spin(flights: Flights, track: Track, flight: int) -> tuple[float, float]:
    """rad per time unit, anticlockwise, and its sd; NaN where the orientation was not seen in at least 5 frames."""
    rows = flights.rows[flight]
    if track.angle_deg is None:
        return math.nan, math.nan
    rows = rows[np.isfinite(track.angle_deg[rows])]
    if len(rows) < 5:
        return math.nan, math.nan
    weight = None
    if track.angle_sd_deg is not None and np.isfinite(track.angle_sd_deg[rows]).all():
        weight = np.median(track.angle_sd_deg[rows]) / np.maximum(track.angle_sd_deg[rows], 1e-3)
    design = np.column_stack([np.ones(len(rows)), track.time[rows] - track.time[rows].mean()])
    found = fit(design, np.radians(track.angle_deg[rows]), frame_lag(track.frame[rows]), weight=weight)
    return float(found.params[1]), float(math.sqrt(found.cov[1, 1]))


def _bounce_table(flights, track: Track, across, values, cov, recording: Recording) -> pd.DataFrame:
    """One row a bounce, every number with its sd; columns carry the units that the track has."""
    physical = track.unit == "mm" and track.timed
    length, time = track.unit, track.time_unit
    speed, factor = ("m_s", 1e-3) if physical else (f"{length}_{time}", 1.0)
    plumb = math.radians(recording.camera.plumb_sd)
    side, side_cov = lateral(flights, track.time, track.frame, across, track.sd, plumb)
    sds = np.sqrt(np.maximum(np.diag(cov), 0))
    rows = []
    for k in range(len(flights.rows) - 1):
        t, contact, before, after, top, e = values[6 * k : 6 * k + 6]
        t_sd, contact_sd, before_sd, after_sd, top_sd, e_sd = sds[6 * k : 6 * k + 6]

        def sideways(p, k=k, t=t):
            return [p[2 * j + 1] + p[-1] * (t - flights.middle[j]) for j in (k, k + 1)]

        swing, swing_cov = propagate(sideways, side, side_cov)
        swing_sd = np.sqrt(np.diag(swing_cov))
        # A plumb line off by φ turns the speeds: what is sideways reads φ times the other.
        e_sd = math.hypot(e_sd, plumb * (swing[1] + e * swing[0]) / before)
        tilt_sd = np.hypot(swing_sd, plumb * np.array([before, after]))
        row = {"recording": recording.id, "bounce": k + 1, f"t_{time}": t, f"t_sd_{time}": t_sd}
        numbers = {
            f"speed_before_{speed}": (before, before_sd), f"speed_after_{speed}": (after, after_sd),
            f"lateral_before_{speed}": (swing[0], tilt_sd[0]), f"lateral_after_{speed}": (swing[1], tilt_sd[1]),
        }  # fmt: skip
        for name, (value, sd) in numbers.items():
            row[name], row[name.replace(f"_{speed}", f"_sd_{speed}")] = value * factor, sd * factor
        for name, flight in (("spin_before", k), ("spin_after", k + 1)):
            row[f"{name}_rad_{time}"], row[f"{name}_sd_rad_{time}"] = _spin(flights, track, flight)
        row |= {f"contact_{length}": contact, f"contact_sd_{length}": contact_sd}
        row |= {f"height_{length}": top, f"height_sd_{length}": top_sd, "restitution": e, "restitution_sd": e_sd}
        rows.append(row)
    return pd.DataFrame(rows)


def _quantities(flights: Flights, track: Track, values, cov, recording: Recording, doubt: str):
    """The five quantities of the first bounce, and notes."""
    physical = track.unit == "mm" and track.timed
    speed_unit, factor = ("m/s", 1e-3) if physical else (f"{track.unit}/{track.time_unit}", 1.0)
    sds = np.sqrt(np.maximum(np.diag(cov), 0))
    _, _, before, after, top, e = values[:6]
    fall, fall_sd = values[-2], sds[-2]
    height = Quantity("rebound_height", top, sds[4], track.unit)
    impact = Quantity("impact_speed", before * factor, sds[2] * factor, speed_unit)
    rebound = Quantity("rebound_speed", after * factor, sds[3] * factor, speed_unit)
    normal = Quantity("restitution_normal", e, sds[5], "")
    notes = []
    stated, seen = recording.drop.height_mm, _release_seen(flights, track)
    if stated and track.unit == "mm":
        relative = math.hypot(sds[4] / top, HEIGHT_SD_MM / stated) if top > 0 else math.nan
        restitution = Quantity("restitution", math.sqrt(max(top, 0) / stated), math.sqrt(max(top, 0) / stated) * relative / 2, "")
        if seen and abs(fall - stated) > max(3 * math.hypot(fall_sd, HEIGHT_SD_MM), 0.02 * stated):
            text = f"the fall seen is {fall:.4g} mm but [drop] height_mm says {stated:g}: one of them is in a wrong unit or wrong"
            restitution, notes = restitution.doubt(text), [text]
    elif seen:
        restitution = Quantity("restitution", values[-1], sds[-1], "")
        notes.append(f"H1 is the fall seen, {fall:.5g} ± {fall_sd:.2g} {track.unit}")
    else:
        text = f"the release is not in the track; {recording.toml}: [drop] height_mm is needed"
        restitution = failed("restitution", "", text)
    quantities = [height, restitution, impact, rebound, normal]
    if doubt:
        quantities = [q if q is normal or (q is restitution and not stated) else q.doubt(doubt) for q in quantities]
    return tuple(_doubtful(q, flights, track, e) for q in quantities), notes


def _doubtful(quantity: Quantity, flights: Flights, track: Track, e: float) -> Quantity:
    """What makes any of the five less than good."""
    first, second = flights.rows[0], flights.rows[1]
    if quantity.name != "impact_speed":
        if len(second) < 5:
            quantity = quantity.doubt(f"only {len(second)} frames of the first rebound")
        if track.time[second[-1]] < flights.apex_time(1):
            quantity = quantity.doubt("the track ends before the rebound's highest place, which is extrapolated")
        if not 0.02 < e < 1:
            quantity = quantity.doubt(f"restitution {e:.3g} is not that of a free bounce")
    if quantity.name not in ("rebound_height", "rebound_speed", "restitution") and len(first) < 5:
        quantity = quantity.doubt(f"only {len(first)} frames before the first impact")
    if quantity.value and quantity.sd > 0.1 * abs(quantity.value):
        quantity = quantity.doubt("known no better than 10 %")
    sd = np.median(track.sd)
    if np.isfinite(sd) and flights.noise > 5 * sd and flights.noise > 0.003 * np.ptp(track.y):
        text = f"places scatter {flights.noise:.2g} {track.unit} about the parabolas, their stated sd is {sd:.2g}"
        quantity = quantity.doubt(text)
    return quantity


def _scale_note(flights: Flights, track: Track, gravity: Gravity, recording: Recording) -> list[str]:
    """What the parabolas say about scale or frame rate that nobody stated, or stated loosely."""
    gamma, relative = flights.free, flights.free_sd / flights.free
    if gamma <= 0:
        return []
    if track.unit == "px" and track.timed:
        return [f"gravity makes it {G_MM_S2 / gamma:.5g} ± {G_MM_S2 / gamma * relative:.2g} mm per px (if the frame rate is right)"]
    if track.unit == "mm" and not track.timed:
        rate = math.sqrt(G_MM_S2 / gamma)
        return [f"gravity makes it {rate:.5g} ± {rate * relative / 2:.2g} frames per second (if the scale is right)"]
    if gravity.value is not None and abs(flights.params[-1]) > 2e-3:
        return [f"gravity corrects the scale by {-100 * flights.params[-1]:.2f} % within its stated sd"]
    return []
