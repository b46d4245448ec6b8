"""Impacts in a drop's sound: found, corrected by clicks, and drawn as a waveform."""

from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchtwin.bench.rigs import RIGS
from benchtwin.vision.evidence.sound import Sound
from benchtwin.vision.measurement import MeasurementError, Quantity
from benchtwin.vision.motion.drop_sound import find_impacts
from benchtwin.vision.motion.onsets import APART_S, Onsets
from benchtwin.vision.recording import Recording

DEEPEST_DB = 60.0  # below the loudest: drawn as nothing
COLUMNS = (100, 4000)  # of a drawn waveform
DIGITS = 4  # of a moment in s, as it is written into recording.toml

Changes = dict[tuple[str, str], list[float] | None]


@dataclass(frozen=True)
class SoundView:
    """Impacts, those of them that were added, what was struck out and what else is
    sudden [s]; the numbers. trouble: why none."""

    impacts: list[float]
    added: list[float]
    struck: list[float]
    others: list[float]
    quantities: tuple[Quantity, ...] = ()
    automatic: tuple[Quantity, ...] = ()
    notes: tuple[str, ...] = ()
    trouble: str = ""


def find_with_corrections(
    sound: Sound, onsets: Onsets, recording: Recording
) -> SoundView:
    """What is heard with the corrections of the recording, and without them."""
    drop, measured = recording.drop, RIGS["drop"].part("heard")
    uncorrected = {"impacts_added_s": None, "impacts_struck_s": None}
    plain = replace(recording, **{"drop": drop.model_copy(update=uncorrected)})
    struck = [float(t) for t in drop.impacts_struck_s or ()]
    sudden = [float(t) for t in onsets.time_s]
    automatic: tuple[Quantity, ...] = ()
    with suppress(
        MeasurementError
    ):  # then there is nothing to stand beside what was corrected
        automatic = measured(find_impacts(sound, onsets, plain), plain).quantities
    try:
        heard = find_impacts(sound, onsets, recording)
    except MeasurementError as error:
        added, why = list(drop.impacts_added_s or ()), str(error)
        return SoundView([], added, struck, sudden, (), automatic, (), why)
    seen = measured(heard, recording)
    found = heard.onsets
    impacts = found.time_s[found.drop >= 0].tolist()
    others = [t for t in sudden if not any(abs(t - i) < 1e-6 for i in impacts)]
    return SoundView(
        impacts,
        found.time_s[found.added].tolist(),
        struck,
        others,
        seen.quantities,
        automatic,
        seen.notes,
    )


def changes_of_click(at_s: float, reach_s: float, now: SoundView, drop: Any) -> Changes:
    """What a click means for the keys: an impact within reach is struck out, or no
    longer added; what was struck out comes back; elsewhere an impact is added, at the
    sudden sound within reach if there is one."""
    added, struck = list(drop.impacts_added_s or ()), list(drop.impacts_struck_s or ())
    if (impact := _near(now.impacts, at_s, reach_s)) is not None:
        if (by_hand := _near(added, impact, 2 * APART_S)) is not None and _near(
            now.added, impact, 1e-6
        ) is not None:
            added.remove(by_hand)
        else:
            struck.append(round(impact, DIGITS))
    elif (gone := _near(struck, at_s, reach_s)) is not None:
        struck.remove(gone)
    else:
        sudden = _near(now.others, at_s, reach_s)
        added.append(round(at_s if sudden is None else sudden, DIGITS))
    return {
        ("drop", "impacts_added_s"): sorted(added) or None,
        ("drop", "impacts_struck_s"): sorted(struck) or None,
    }


def _near(times: list[float], at_s: float, reach_s: float) -> float | None:
    best = min(times, key=lambda t: abs(t - at_s), default=None)
    return best if best is not None and abs(best - at_s) <= reach_s else None


def waveform(sound: Sound, begin_s: float, end_s: float, columns: int) -> list[float]:
    """(columns,) loudest sample of each stretch between two moments, in shares of
    DEEPEST_DB above nothing: 1 is the loudest."""
    columns = int(np.clip(columns, *COLUMNS))
    edges = (np.linspace(begin_s, end_s, columns + 1) - sound.start_s) * sound.rate_hz
    edges = np.clip(np.round(edges).astype(int), 0, len(sound.samples))
    first, last = edges[0], max(int(edges[-1]), int(edges[0]) + 1)
    part = np.append(np.abs(sound.samples[first:last]), 0.0)
    most = np.maximum.reduceat(part, np.minimum(edges[:-1] - first, len(part) - 1))
    top = max(float(np.abs(sound.samples).max()), 1e-9)
    db = 20 * np.log10(np.maximum(most / top, 1e-9))
    return [round(float(v), 3) for v in np.clip(1 + db / DEEPEST_DB, 0, 1)]
