"""Several drops in one recording: each measured by itself, and the means over them."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pandas as pd

from benchtwin.bench.language import tr
from benchtwin.vision.measurement import FAILED, Observation
from benchtwin.vision.motion.split_flights import releases
from benchtwin.vision.motion.track import Track
from benchtwin.vision.recording import Recording
from benchtwin.vision.summary import mean_over_repeats


def drop_rows(track: Track, recording: Recording) -> list[slice]:
    """The rows of each drop in a track, in which the seed may be let go several times;
    light gates see one."""
    rows = np.flatnonzero(~track.outlier)
    if recording.evidence == "gates.csv" or not len(rows):
        return [slice(0, len(track))]
    height, _ = track.used().upright(recording.camera.plumb_deg)
    begins = [0, *(int(rows[part.start]) for part in releases(height)[1:])]
    return [slice(a, b) for a, b in pairwise([*begins, len(track)])]


def over_drops(drops: Sequence[Observation]) -> Observation:
    """One observation of all drops of a recording: means, all bounces with the number
    of their drop, the quantities of each drop as repeats; the notes say the scatter."""
    repeats = tuple(drop.quantities for drop in drops)
    means = mean_over_repeats(repeats)
    tables = [
        drop.bounces.assign(drop=number)
        for number, drop in enumerate(drops, 1)
        if drop.bounces is not None
    ]
    own = [
        f"drop {number}: {note}"
        for number, drop in enumerate(drops, 1)
        for note in drop.notes
        if not all(note in other.notes for other in drops)
    ]
    shared = [n for n in drops[0].notes if all(n in other.notes for other in drops)]
    return replace(
        drops[0],
        quantities=means,
        repeats=repeats,
        notes=(*_scatter(means, repeats), *shared, *own),
        bounces=pd.concat(tables, ignore_index=True) if tables else None,
    )


def each_drop(found: Observation) -> list[Observation]:
    """The drops of an observation one by one, with their own quantities and bounces;
    an observation of one drop itself."""
    if not found.repeats:
        return [found]
    table = found.bounces
    return [
        replace(
            found,
            quantities=quantities,
            repeats=(),
            notes=(),
            bounces=None if table is None else table[table["drop"] == number],
        )
        for number, quantities in enumerate(found.repeats, 1)
    ]


def _scatter(means, repeats) -> list[str]:
    """How far the drops differ, and how many gave each quantity."""
    parts = []
    for mean in means:
        values = [
            q.value
            for one in repeats
            for q in one
            if q.name == mean.name and q.quality != FAILED
        ]
        if len(values) > 1:
            unit = "" if mean.unit == "1" else f" {mean.unit}"
            parts.append(
                f"{mean.name} {np.std(values, ddof=1):.2g}{unit} (n = {len(values)})"
            )
    return [
        tr("means over {} drops; sd between drops: {}", len(repeats), ", ".join(parts))
    ]
