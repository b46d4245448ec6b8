"""Rolls run again in the DEM on a sloped level, or with a law of
resistance."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from benchtwin.bench.air import air_of, drag_shape
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
    Resimulation,
    change_in_words,
    secant,
    simulation_settings,
    values_by_recording,
)
from benchtwin.infer.effect import Effect
from benchtwin.infer.finding import Finding
from benchtwin.rigs.roll.effects import EFFECTS
from benchtwin.rigs.roll.effects.resistance import REFERENCE_SPEED_M_S as DRAG_M_S
from benchtwin.rigs.roll.session import FEW_ROWS, stays
from benchtwin.twin.lone_seed import drag_factor
from benchtwin.twin.parameters import Parameters
from benchtwin.twin.paths import Path1D, Recording, like, run_path

LENGTH_MM, MOST_MU = 10.0, 0.2
Change = tuple[float, dict[str, dict]]  # [roll] slope_deg and laws


def resimulate(
    finding: Finding, recordings: list, folder: Path, pictures: bool, say
) -> Resimulation:
    """Each roll, with the rolling friction at which all run out as far as recorded on
    average."""
    seen = [
        r for r in recordings if len(r.x_mm) >= FEW_ROWS and not stays(r.description)
    ]
    if not seen:
        raise ValueError(
            tr(
                "no track from the release to the stop is there to run again: the"
                " twin's rolls go from end to end"
            )
        )
    values = values_by_recording(finding)
    chosen = [r for r in seen if r.recording in values][:MOST]
    paths = [Path1D(r.time_s, way_from_rest(r, 100)) for r in chosen]
    own = [values[r.recording] for r in chosen]
    # the same laws at 0: one set of compiled kernels
    nil, whole = (
        [change_of(r.description, v, finding.laws) for r, v in zip(chosen, every)]
        for every in ([dict.fromkeys(v, 0.0) for v in own], own)
    )
    say(tr("roll: finding the twin's rolling friction"))
    old = friction(chosen, paths, nil)
    new = friction(chosen, paths, whole)
    twins = [
        TwinPair(
            r.recording,
            path,
            length_mm(r),
            _made(r, old, before),
            _made(r, new, after),
        )
        for r, path, before, after in zip(chosen, paths, nil, whole, strict=True)
    ]
    how = tr(
        "rolling friction {:.4g} in the old and {:.4g} in the new twin, so that they"
        " run out as far as recorded on average",
        old,
        new,
    )
    more = tr("; the first {} recordings", MOST) if len(seen) > MOST else ""
    again = Resimulation(
        "roll",
        finding.modelled,
        change_in_words(finding),
        how + more,
        (),
        len(finding.recordings) > 1,
    )
    return compared(again, twins, folder, pictures, say)


def length_mm(r) -> float:
    """Way on the incline."""
    return r.description.get("roll", {}).get("incline_length_mm", LENGTH_MM)


def _made(r, mu: float, change: Change) -> tuple[Recording, Parameters]:
    """(recording to be like, parameters) with what was named."""
    slope, laws = change
    about: dict[str, Any] = {"slope_deg": float(np.clip(slope, -4.9, 4.9))}
    about["direction"] = r.description.get("roll", {}).get(
        "direction"
    ) or r.description["roll"].get("seen_direction", "+x")
    recording = with_frame_rate(like("roll", r.description, **about), r.time_s)
    return recording, Parameters(rolling_friction=mu, laws=laws)


def change_of(
    description: dict, values: dict[str, float], found: Mapping[str, Effect]
) -> Change:
    """What was named or found, in the twin."""
    key = EFFECTS["slope"].key
    assert key is not None
    slope = key.both(key.stated(description), values.get("slope", 0.0))
    return slope, laws_of(description, values, found)


def laws_of(
    description: dict,
    values: dict[str, float],
    found: Mapping[str, Effect] = NO_LAWS,
) -> dict[str, dict]:
    """What was named or found as the DEM's laws; drag beside the stated air's."""
    laws = simulation_settings("roll", values, found).get("laws", {})
    if "drag" in values:
        air = air_of(description)
        stated = (
            air.share * float(drag_shape(DRAG_M_S, air.reynolds_per_speed)) * DRAG_M_S
        )
        laws["drag"] = drag_factor(
            description, max(stated + values["drag"], 0.0), DRAG_M_S
        )
    return laws


def friction(chosen: list, paths: list[Path1D], changes: list[Change]) -> float:
    """μ_r at which simulated final places equal the recorded ones on average."""
    lengths = np.array([length_mm(r) for r in chosen])
    beta = np.radians(
        [r.description.get("roll", {}).get("incline_deg", 15.0) for r in chosen]
    )
    ends = np.array([path.way[-1] for path in paths])
    start = float(
        np.mean(
            lengths
            * np.sin(beta)
            / (lengths * np.cos(beta) + np.maximum(ends - lengths, 1.0))
        )
    )

    def miss(mu: float) -> float:
        ran = [
            run_path(*_made(r, mu, change), k)
            for k, (r, change) in enumerate(zip(chosen, changes, strict=True))
        ]
        return float(
            np.mean([_end(path, own) for path, own in zip(paths, ran, strict=True)])
            - ends.mean()
        )

    limits = (0.3 * start, min(3 * start, MOST_MU))
    return secant(
        miss,
        start,
        0.93 * start,
        limits,
        iterations=3,
        close=0.002 * float(ends.mean()),
    )


def _end(path: Path1D, own: Path1D) -> float:
    """The simulated place when the recording ends."""
    return float(own.at(np.array([own.time[0] + path.time[-1] - path.time[0]]))[0])
