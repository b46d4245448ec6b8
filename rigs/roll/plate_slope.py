"""Slope of the table from rolls in both directions on an incline: half the difference
of their accelerations.

    s = (a₊ − a₋)(1 + I/(m r²)) / (2 g (cos β + μ_r sin β)),  falling towards +x

Errors that both directions share (the incline's angle, the gates' places, the scale)
cancel. The mean of the rolling frictions over both directions is free of s."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from benchtwin.bench.constants import G_MM_S2
from benchtwin.bench.distributions import t as student
from benchtwin.bench.numbers import plus_minus
from benchtwin.rigs.roll.inertia import inertia_of_recording
from benchtwin.vision.measurement import FAILED, MeasurementError, Observation, Quantity
from benchtwin.vision.overlay.plot import plot
from benchtwin.vision.recording import Recording


@dataclass(frozen=True)
class InclineRun:
    """One roll on an incline: direction +1 or −1, acceleration and sd [mm/s²],
    friction, inertia 1 + I/(m r²), incline [rad]."""

    direction: int
    acceleration: float
    sd: float
    friction: float
    inertia: float
    incline: float


def plate_slopes(
    measured: Iterable[tuple[Recording, Observation]],
) -> list[Observation]:
    """An observation of the quantity `slope` [deg] for every session and incline with
    rolls in both directions."""
    kinds: dict[tuple, list[InclineRun]] = {}
    for recording, observation in measured:
        if (run := _run(recording, observation)) is not None:
            kinds.setdefault(
                (recording.session or "", recording.roll.incline_deg, recording.seed),
                [],
            ).append(run)
    both = [
        (key, runs)
        for key, runs in kinds.items()
        if {run.direction for run in runs} == {1, -1}
    ]
    names = [f"{key[0] or 'roll'} both ways" for key, _ in both]
    numbered = [
        name if names.count(name) == 1 else f"{name} {k + 1}"
        for k, name in enumerate(names)
    ]
    return [_slope(name, runs) for name, (_, runs) in zip(numbered, both, strict=True)]


def _run(recording: Recording, observation: Observation) -> InclineRun | None:
    found = {q.name: q for q in observation.quantities if q.quality != FAILED}
    roll, path = recording.roll, observation.track
    if (
        not {"acceleration", "rolling_resistance"} <= found.keys()
        or roll.incline_deg is None
        or path is None
    ):
        return None
    forwards = path.x_mm.iloc[-1] >= path.x_mm.iloc[0]
    direction = 1 if (roll.direction == "+x" if roll.direction else forwards) else -1
    try:
        inertia = inertia_of_recording(recording).factor
    except MeasurementError:
        return None
    a = found["acceleration"]
    friction = float(np.clip(found["rolling_resistance"].value, 0.0, 0.5))
    return InclineRun(
        direction,
        1000 * a.value,
        1000 * a.sd,
        friction,
        inertia,
        math.radians(roll.incline_deg),
    )


def _slope(name: str, runs: list[InclineRun]) -> Observation:
    values = {
        s: np.array([r.acceleration for r in runs if r.direction == s]) for s in (1, -1)
    }
    per = np.mean(
        [
            r.inertia
            / (2 * G_MM_S2 * (math.cos(r.incline) + r.friction * math.sin(r.incline)))
            for r in runs
        ]
    )
    run_variance = sum(
        np.mean([r.sd**2 for r in runs if r.direction == s]) / len(v)
        for s, v in values.items()
    )
    variance, source = float(run_variance), "each run's own sd"
    if (
        min(len(v) for v in values.values()) > 1
    ):  # the scatter does not contain shared errors
        shares = [(v.var(ddof=1) / len(v), len(v) - 1) for v in values.values()]
        total = sum(share for share, _ in shares)
        freedom = total**2 / max(sum(share**2 / free for share, free in shares), 1e-300)
        scatter = total * (student.ppf(0.975, max(freedom, 1.0)) / 1.96) ** 2
        variance, source = float(scatter), "the scatter of the runs"
    slope = math.degrees(float(values[1].mean() - values[-1].mean()) * float(per))
    sd = math.degrees(math.sqrt(variance) * float(per))
    counts = f"{len(values[1])} runs towards +x and {len(values[-1])} towards -x"
    notes = (
        (
            "slope, falling towards +x, from half the difference of the accelerations"
            f" of {counts}; its sd is from {source}"
        ),
        "each direction's rolling friction contains the slope, their mean does not",
    )
    number = np.concatenate([np.arange(1, len(v) + 1) for v in values.values()]).astype(
        float
    )
    height = np.concatenate(list(values.values())) / 1000
    levels = [
        (np.array([0.5, len(v) + 0.5]), np.full(2, v.mean() / 1000))
        for v in values.values()
    ]
    picture = plot(
        number,
        height,
        np.zeros(len(number), bool),
        labels=("run of its direction", "acceleration [m/s²]"),
        curves=levels,
        caption=f"{name}: slope {plus_minus(slope, sd, 'deg')} falling towards +x",
    )
    return Observation(
        name, "roll", (Quantity("slope", slope, sd, "deg"),), notes, {"slope": picture}
    )
