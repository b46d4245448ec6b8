"""Slope of the table from rolls in both directions on an incline: the rolls of a
session fitted together, with the slope free.

Errors that both directions share (the incline's angle, the gates' places, the scale)
are parameters that they have in common."""

import math
from collections.abc import Iterable
from contextlib import suppress

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.bench.numbers import plus_minus
from benchtwin.infer.problem import fit
from benchtwin.rigs.roll.diagnose import baseline, scales_of
from benchtwin.rigs.roll.effects.slope import SLOPE
from benchtwin.rigs.roll.read import SeenRoll, roll_of
from benchtwin.rigs.roll.session import assemble
from benchtwin.vision.measurement import FAILED, MeasurementError, Observation, Quantity
from benchtwin.vision.motion.track import track_from_table
from benchtwin.vision.overlay.plot import plot
from benchtwin.vision.recording import Recording


def plate_slopes(
    measured: Iterable[tuple[Recording, Observation]],
) -> list[Observation]:
    """An observation of the quantity `slope` [deg] for the rolls of every session and
    seed that stay on their incline, in both directions."""
    kinds: dict[tuple, list[SeenRoll]] = {}
    speeding: dict[str, float] = {}  # acceleration by recording
    for recording, found in measured:
        usable = {q.name: q.value for q in found.quantities if q.quality != FAILED}
        if {
            "acceleration",
            "rolling_resistance",
        } <= usable.keys() and found.track is not None:
            track = track_from_table(found.track, recording.camera)
            kind = recording.session or "", recording.seed
            speeding[recording.id] = usable["acceleration"]
            with suppress(MeasurementError):  # it tells its own numbers, and no slope
                kinds.setdefault(kind, []).append(roll_of(track, recording))
    names = [f"{session or 'roll'} both ways" for session, _ in kinds]
    numbered = [
        name if names.count(name) == 1 else f"{name} {k + 1}"
        for k, name in enumerate(names)
    ]
    each = zip(numbered, kinds.values(), strict=True)
    return [one for name, rolls in each if (one := _slope(name, rolls, speeding))]


def _slope(
    name: str, rolls: list[SeenRoll], speeding: dict[str, float]
) -> Observation | None:
    """None for one direction; speeding: acceleration [m/s²] by recording."""
    try:
        runs, seed, left_out = assemble(rolls)
    except ValueError:
        return None
    counts = [sum(run.sign == sign for run in runs) for sign in (1.0, -1.0)]
    if not all(counts):
        return None
    problem, base, _ = baseline(runs, seed, scales_of(rolls), np.random.default_rng(1))
    found = fit(problem, free=(SLOPE,), start=base)
    whole = np.isin(found.names, (SLOPE, "level")).astype(float)
    slope, sd = float(whole @ found.values), math.sqrt(whole @ found.covariance @ whole)
    notes = (
        tr(
            "slope, falling towards +x, from {} runs towards +x and {} towards -x,"
            " fitted together",
            counts[0],
            counts[1],
        ),
        tr("each direction's rolling friction contains the slope, their mean does not"),
        *left_out,
    )
    each = [
        np.array([speeding[run.recording] for run in runs if run.sign == sign])
        for sign in (1.0, -1.0)
    ]
    number = np.concatenate([1.0 + np.arange(len(one)) for one in each])
    picture = plot(
        number,
        np.concatenate(each),
        np.zeros(len(number), bool),
        labels=("run of its direction", "acceleration [m/s²]"),
        curves=[(np.array([0.5, len(a) + 0.5]), np.full(2, a.mean())) for a in each],
        caption=f"{name}: slope {plus_minus(slope, sd, 'deg')} falling towards +x;"
        " lines: means of either direction",
    )
    quantity = Quantity("slope", slope, sd, "deg")
    return Observation(name, "roll", (quantity,), notes, {"slope": picture})
