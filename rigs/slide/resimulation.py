"""Slides run again in the DEM, let go at the recorded angle, or by their conditions."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.diagnose.path_comparison import (
    MOST,
    TwinPair,
    compared,
    way_from_rest,
    with_frame_rate,
)
from benchtwin.diagnose.rerun import (
    NO_LAWS,
    Comparison,
    Resimulation,
    change_in_words,
    condition_shifts,
    simulation_settings,
    values_by_recording,
)
from benchtwin.diagnose.words import followed_condition
from benchtwin.infer.effect import Effect
from benchtwin.infer.finding import Finding
from benchtwin.twin.parameters import Parameters
from benchtwin.twin.paths import Path1D, like, run_path

BEGUN_MM = 1.0  # of travel: from here clocks are compared
BEFORE_DEG = 1.5  # the twin's plate starts as much below the angle of onset


def resimulate(
    finding: Finding, recordings: list, folder: Path, pictures: bool, say
) -> Resimulation:
    """Ways of slides let go at the recorded angle; for conditions, the angles
    themselves."""
    values = values_by_recording(finding)
    seen = [r for r in recordings if len(r.x_mm) and r.recording in values]
    if not seen:
        raise ValueError(
            tr("only angles were read off: there is no track to run again")
        )
    seen = [r for r in seen if rate_of(r)]
    if not seen:
        raise ValueError(tr("the twin's plate is raised, that of these slides stands"))
    names = finding.modelled
    twins = []
    for k, r in enumerate(seen[:MOST]):
        say(
            tr(
                "slide: finding the twin's friction for {} ({} of {})",
                r.recording,
                k + 1,
                min(len(seen), MOST),
            )
        )
        # the same laws at 0: one set of compiled kernels
        nil = values[r.recording] | dict.fromkeys(names, 0.0)
        both = (nil, values[r.recording])
        made = [fitted(r, onset_deg(r), v, k, finding.laws) for v in both]
        twins.append(TwinPair(r.recording, travelled(r), BEGUN_MM, *made))
    more = tr("; the first {} recordings", MOST) if len(seen) > MOST else ""
    several, change = len(finding.recordings) > 1, change_in_words(finding)
    again = Resimulation("slide", names, change, "", (), several)
    if any(not followed_condition(n) for n in names):
        how = tr(
            "friction at rest is such that the twin's block begins to move at the"
            " recorded angle, old and new alike"
        )
        again = compared(replace(again, how=how + more), twins, folder, pictures, say)
    if any(followed_condition(n) for n in names):
        beside = condition_shifts(finding)
        again = _let_go(again, twins, beside, {r.recording: r for r in seen}, more)
    return again


def _let_go(
    again: Resimulation,
    twins: list[TwinPair],
    beside: dict[str, float],
    seen: dict,
    more: str,
) -> Resimulation:
    """`again` with simulated onset angles, for one friction and for each slide's
    own."""
    shift = np.array([beside[t.name] for t in twins])
    mean = float(np.mean([t.new[1].static_friction for t in twins] - shift))
    told = np.array([onset_deg(seen[t.name]) for t in twins])
    angles = np.array(
        [
            [
                let_go_deg(
                    seen[t.name], replace(t.new[1], static_friction=mean + own), k
                )[0]
                for own in (0.0, shift[k])
            ]
            for k, t in enumerate(twins)
        ]
    )
    rows = tuple(
        Comparison(
            t.name,
            tr("angle of onset"),
            "°",
            float(abs(old - angle)),
            float(abs(new - angle)),
            "track",
        )
        for t, (old, new), angle in zip(twins, angles, told)
    )
    how = tr(
        "the angle of onset is that of the twin with one friction at rest for all"
        " slides, and with each slide's own{}",
        more,
    )
    points = {
        "recorded": (shift, told),
        "old twin": (shift, angles[:, 0]),
        "new twin": (shift, angles[:, 1]),
    }
    figure = again.figure or {
        "x": tr("static friction beside its mean, by what is stated"),
        "y": tr("angle of onset (°)"),
        "points": points,
    }
    return replace(
        again,
        compared=(*again.compared, *rows),
        how="; ".join(filter(None, (again.how, how))),
        figure=figure,
    )


def travelled(r) -> Path1D:
    """Travel [mm] from rest."""
    way = way_from_rest(r, 50)
    return Path1D(r.time_s, way if way[-1] >= 0 else -way)


def tilt_of(r) -> np.ndarray:
    """The plate's angle [°] at every row."""
    if r.tilt_deg is not None:
        seen = np.isfinite(r.tilt_deg)
        return np.interp(r.time_s, r.time_s[seen], r.tilt_deg[seen])
    rate = r.description["slide"].get("tilt_rate_deg_s") or 0.0
    return rate * (r.time_s - r.time_s[0])


def onset_deg(r) -> float:
    """The angle at BEGUN_MM of travel."""
    path = travelled(r)
    return float(np.interp(path.reached(BEGUN_MM), r.time_s, tilt_of(r)))


def rate_of(r) -> float:
    """Tilt rate [°/s], stated or from the angles."""
    stated = r.description.get("slide", {}).get("tilt_rate_deg_s")
    return float(stated or np.polyfit(r.time_s, tilt_of(r), 1)[0])


def let_go_deg(r, parameters: Parameters, number: int):
    """Angle [°] at which the twin's block has gone BEGUN_MM; the recording it was
    like."""
    start = float(np.degrees(np.arctan(parameters.static_friction))) - BEFORE_DEG
    about = {
        "start_deg": float(np.clip(start, 0.0, 79.0)),
        "tilt_rate_deg_s": float(np.clip(rate_of(r), 0.05, 90.0)),
    }
    recording = with_frame_rate(like("slide", r.description, **about), r.time_s)
    path = run_path(recording, parameters, number)
    tilt = path.motion.series["tilt_deg"]
    return float(np.interp(path.reached(BEGUN_MM), path.time, tilt)), recording


def fitted(
    r,
    angle_deg: float,
    values: dict[str, float],
    number: int,
    found: Mapping[str, Effect] = NO_LAWS,
):
    """(recording to be like, parameters) that let go at this angle: corrected twice."""
    laws = simulation_settings("slide", values, found).get("laws", {})
    mu = float(np.tan(np.radians(angle_deg - 0.3)))
    for _ in range(2):
        reached, recording = let_go_deg(
            r, Parameters(static_friction=mu, laws=laws), number
        )
        mu *= np.tan(np.radians(angle_deg)) / np.tan(np.radians(reached))
    return recording, Parameters(static_friction=mu, laws=laws)
