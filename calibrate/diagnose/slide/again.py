"""Slides run again in the DEM: the same block on the same plate, let go at the recorded angle, with friction that changes."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from calibrate.diagnose.along import MOST, Twin, compared
from calibrate.diagnose.finding import Finding
from calibrate.diagnose.model import Again, change_in_words
from calibrate.twin.along import Path1D, gone, like
from calibrate.twin.parameters import Parameters

BEGUN_MM = 1.0  # of travel: from here clocks are compared
BEFORE_DEG = 1.5  # the twin's plate starts as much below the angle of onset
SETTLE_M_S = 1e-3
STRIBECK_M_S = 0.05  # about which stribeck.ln-speed counts


def slides_again(finding: Finding, recordings: list, folder: Path, pictures: bool, say) -> Again:
    """Each slide with the friction at rest that lets it go at the recorded angle."""
    seen = [r for r in recordings if len(r.x_mm)]
    if not seen:
        raise ValueError("only angles were read off: there is no track to run again")
    values = {r: {n: v[min(k, len(v) - 1)] for n, v in finding.left_out.items()} for k, r in enumerate(finding.recordings)}
    chosen = [r for r in seen if r.recording in values][:MOST]
    twins = []
    for k, r in enumerate(chosen):
        say(f"slide: finding the twin's friction for {r.recording} ({k + 1} of {len(chosen)})")
        path, angle = travelled(r), onset_deg(r)
        nil = values[r.recording] | dict.fromkeys(finding.modelled, 0.0)  # the same laws at nil: their kernels are one set
        made = [fitted(r, angle, v, k) for v in (nil, values[r.recording])]
        twins.append(Twin(r.recording, path, BEGUN_MM, *made))
    how = "friction at rest is such that the twin's block begins to move at the recorded angle, old and new alike"
    more = f"; the first {MOST} recordings" if len(seen) > MOST else ""
    again = Again("slide", finding.modelled, change_in_words("slide", finding), how + more, (), len(finding.recordings) > 1)
    return compared(again, twins, folder, pictures, say)


def travelled(r) -> Path1D:
    """Travel [mm] from rest, growing."""
    start = float(np.median(r.x_mm[: max(3, len(r.x_mm) // 50)]))
    way = r.x_mm - start
    return Path1D(r.time_s, way if way[-1] >= 0 else -way)


def tilt_of(r) -> np.ndarray:
    """The plate's angle [°] at every row."""
    if r.tilt_deg is not None:
        seen = np.isfinite(r.tilt_deg)
        return np.interp(r.time_s, r.time_s[seen], r.tilt_deg[seen])
    return r.description["slide"]["tilt_rate_deg_s"] * (r.time_s - r.time_s[0])


def onset_deg(r) -> float:
    """The angle at BEGUN_MM of travel."""
    path = travelled(r)
    return float(np.interp(path.reached(BEGUN_MM), r.time_s, tilt_of(r)))


def rate_of(r) -> float:
    """Tilt rate [°/s], stated or from the angles."""
    stated = r.description.get("slide", {}).get("tilt_rate_deg_s")
    return float(stated or np.polyfit(r.time_s, tilt_of(r), 1)[0])


def fitted(r, angle_deg: float, values: dict[str, float], number: int):
    """(recording to be like, parameters) with which the twin's block has gone BEGUN_MM at this angle: corrected twice."""
    mu = float(np.tan(np.radians(angle_deg - 0.3)))
    start = float(np.clip(angle_deg - BEFORE_DEG, 0.0, 79.0))
    about = {"start_deg": start, "tilt_rate_deg_s": float(np.clip(rate_of(r), 0.05, 90.0))}
    recording = like("slide", r.description, **about)
    if recording.camera.fps is None:
        rate = float(1 / np.median(np.diff(r.time_s)))
        recording = replace(recording, camera=recording.camera.model_copy(update={"fps": rate}))
    for _ in range(2):
        path = gone(recording, Parameters(static_friction=mu, laws=laws_of(values)), number)
        reached = float(np.interp(path.reached(BEGUN_MM), path.time, path.motion.series["tilt_deg"]))
        mu *= np.tan(np.radians(angle_deg)) / np.tan(np.radians(reached))
    return recording, Parameters(static_friction=mu, laws=laws_of(values))


def laws_of(values: dict[str, float]) -> dict[str, dict]:
    """What was named, as the DEM's laws of friction."""
    speed = STRIBECK_M_S * float(np.exp(np.clip(values.get("stribeck.ln-speed", 0.0), -6, 6)))
    make = {
        "kinetic-friction": lambda v: {"friction_kinetic": {"drop": v, "settle_speed": SETTLE_M_S}},
        "stribeck": lambda v: {"friction_stribeck": {"drop": v, "stribeck_speed": speed}},
        "viscous-sliding": lambda v: {"friction_viscous": {"slope": v}},
    }
    out: dict[str, dict] = {}
    for name in values.keys() & make.keys():
        out |= make[name](values[name])
    return out
