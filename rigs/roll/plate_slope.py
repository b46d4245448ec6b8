"""Slope of the table from rolls in both directions on an incline: the rolls of a
session fitted together, with the slope free.

Errors that both directions share (the incline's angle, the gates' places, the scale)
are parameters that they have in common."""

import math
from collections.abc import Iterable
from contextlib import suppress

import numpy as np

from benchtwin.bench.numbers import plus_minus
from benchtwin.infer.problem import fit
from benchtwin.rigs.roll.diagnose import baseline, scales_of
from benchtwin.rigs.roll.effects.slope import SLOPE
from benchtwin.rigs.roll.model import run_motion
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
    for recording, found in measured:
        usable = {q.name for q in found.quantities if q.quality != FAILED}
        if {"acceleration", "rolling_resistance"} <= usable and found.track is not None:
            track = track_from_table(found.track, recording.camera)
            kind = recording.session or "", recording.seed
            with suppress(MeasurementError):  # it tells its own numbers, and no slope
                kinds.setdefault(kind, []).append(roll_of(track, recording))
    names = [f"{session or 'roll'} both ways" for session, _ in kinds]
    numbered = [
        name if names.count(name) == 1 else f"{name} {k + 1}"
        for k, name in enumerate(names)
    ]
    each = zip(numbered, kinds.values(), strict=True)
    return [one for name, rolls in each if (one := _slope(name, rolls))]


def _slope(name: str, rolls: list[SeenRoll]) -> Observation | None:
    """None for one direction."""
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
        f"slope, falling towards +x, from {counts[0]} runs towards +x and {counts[1]}"
        " towards -x, fitted together",
        "each direction's rolling friction contains the slope, their mean does not",
        *left_out,
    )
    left = [
        1e3 * (run.x - run_motion(of.problem.model, r, of.starts[r], of.by_name)[0])
        for of in (base, found)
        for r, run in enumerate(runs)
    ]
    time = [run.time_s - found.starts[r][0] for r, run in enumerate(runs)]
    level, tilted = left[: len(runs)], left[len(runs) :]
    picture = plot(
        np.concatenate(time),
        np.concatenate(tilted),
        np.zeros(sum(map(len, time)), bool),
        labels=("time since release [s]", "recorded less fitted way [mm]"),
        curves=list(zip(time, level, strict=True)),
        caption=f"{name}: slope {plus_minus(slope, sd, 'deg')} falling towards +x;"
        " lines: without it",
    )
    quantity = Quantity("slope", slope, sd, "deg")
    return Observation(name, "roll", (quantity,), notes, {"slope": picture})
