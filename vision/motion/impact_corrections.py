"""Impacts that a person added or removed, applied to those found in a sound.

A stated moment means the onset near it; where there is none, the time at which the power changes most within a few milliseconds.
"""

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vision.evidence.keys import Drop
from vision.evidence.sound import Sound
from vision.measurement import MeasurementError
from vision.motion.impact_chain import Chain
from vision.motion.onsets import APART_S, Onsets, onset_near

STRUCK = "struck out by hand"


def correct_impacts(
    sound: Sound, onsets: Onsets, chain: Chain, drop: Drop, where: str
) -> tuple[Onsets, Chain, tuple[int, ...], list[str]]:
    """(onsets, chain, rows of the added impacts, notes) after the corrections in `drop`; unchanged where it has none.

    where: the file that states them. MeasurementError for a moment outside the sound, or one both added and removed.
    """
    if not (drop.impacts_added_s or drop.impacts_struck_s):
        return onsets, chain, (), []
    for name in ("impacts_added_s", "impacts_struck_s"):
        for at in getattr(drop, name) or ():
            if not sound.start_s <= at <= sound.start_s + sound.duration_s:
                until = sound.start_s + sound.duration_s
                raise MeasurementError(f"{where}: [drop] {name}: {at:g} s is not in this sound, {sound.start_s:.3g} to {until:.4g} s")
    onsets, chain, added = _with_added(sound, onsets, chain, drop.impacts_added_s or ())
    struck, notes = set(), []
    for at in drop.impacts_struck_s or ():
        row = _nearest(onsets.time_s, at)
        if row in added:
            raise MeasurementError(f"{where}: [drop] impacts_added_s and impacts_struck_s both name the impact at {at:g} s")
        if row is None or row not in chain.impacts:
            notes.append(f"{at:g} s is struck out by hand, but no impact was found there")
        else:
            struck.add(row)
    impacts = np.array(sorted((set(chain.impacts.tolist()) | set(added)) - struck), int)
    rejected = {row: why for row, why in chain.rejected.items() if row not in added} | dict.fromkeys(struck, STRUCK)
    notes.insert(0, f"impacts set by hand: {len(set(added))} added, {len(struck)} struck out")
    return onsets, replace(chain, impacts=impacts, missed=_missed(chain, impacts), rejected=rejected), tuple(added), notes


def _with_added(
    sound: Sound, onsets: Onsets, chain: Chain, moments: Sequence[float]
) -> tuple[Onsets, Chain, list[int]]:
    """Onsets with the added ones, the chain with rows renumbered accordingly, the rows of all added impacts."""
    new = [onset_near(sound, at) for at in moments if _nearest(onsets.time_s, at) is None]
    times, sds = np.array(new).reshape(-1, 2).T
    unknown = {"time_s": times, "sd_s": sds, "timbre": np.full((len(new), onsets.timbre.shape[1]), np.nan)}
    fields = Onsets.__dataclass_fields__
    grown = Onsets(*(np.concatenate([getattr(onsets, f), unknown.get(f, np.full(len(new), np.nan))]) for f in fields))
    order = np.argsort(grown.time_s, kind="stable")
    row_of = np.argsort(order)
    grown = grown.take(order)
    rejected = {int(row_of[row]): why for row, why in chain.rejected.items()}
    added = [int(np.abs(grown.time_s - at).argmin()) for at in moments]
    return grown, replace(chain, impacts=row_of[chain.impacts], rejected=rejected), added


def _nearest(times: np.ndarray, at: float) -> int | None:
    """Row of the onset nearest to a moment, None where none is within APART_S."""
    if not len(times):
        return None
    row = int(np.abs(times - at).argmin())
    return row if abs(times[row] - at) <= APART_S else None


def _missed(chain: Chain, impacts: np.ndarray) -> np.ndarray:
    """(m,): whether an impact is still missing between each impact and the one before."""
    gaps = [(chain.impacts[k - 1], chain.impacts[k]) for k in np.flatnonzero(chain.missed)]
    inside = [any(a <= first and last <= b for first, last in gaps) for a, b in itertools.pairwise(impacts)]
    return np.array([False, *inside][: len(impacts)], bool)
