"""Sound of drops → impacts, speeds and restitution, alone or combined with pictures of
the same drops. A recording may hold several: each is measured by itself, and the
quantities are means over them.

The clock of the sound may be shifted against that of the pictures: a film's tracks are
not exactly in step, sound takes 3 ms a metre, a separate file begins at any time. The
shift is estimated from the impacts and noted; intervals do not depend on it. Quantities
that both give are averaged, weighted by their variances; where they contradict each
other they are doubtful."""

import itertools
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from benchtwin.bench.numbers import plus_minus
from benchtwin.vision.evidence.sound import Sound, film_fps, has_sound
from benchtwin.vision.foreign.as_evidence import read_heard
from benchtwin.vision.measurement import (
    DOUBTFUL,
    FAILED,
    GOOD,
    MeasurementError,
    Observation,
    Quantity,
)
from benchtwin.vision.motion.impact_chain import Chain, correct_impacts, find_chain
from benchtwin.vision.motion.impacts import measure_impacts
from benchtwin.vision.motion.onsets import Onsets, find_onsets
from benchtwin.vision.motion.several_drops import each_drop, over_drops
from benchtwin.vision.overlay.sound import draw_sound
from benchtwin.vision.recording import Recording

LEAST_LOG_ODDS = 5.5  # of a chain of impacts that is not doubtful
CONTRADICTION_SDS = 3.0
MOST_RATE_DIFFERENCE = (
    0.03  # of a stated frame rate and the file's: a phone's is not even
)
MOST_SHIFT_S = 0.3  # of a film's own sound
SAME_IMPACT_S = (
    0.03  # within which, or three sds, an impact seen and one heard may be the same
)
NORMAL = "restitution_normal"
MOST_LISTED = 6  # rejected sounds in one note


@dataclass(frozen=True, eq=False)
class HeardDrop:
    """The impacts of one drop. times, sd [s] (m,): successive impacts without a gap, on
    the clock of the pictures; first: whether the first of them is the first after the
    release; doubt: "" where there is none."""

    times: np.ndarray
    sd: np.ndarray
    first: bool
    doubt: str


@dataclass(frozen=True, eq=False)
class SoundImpacts:
    """The impacts in a sound, of one drop or several; added: rows of the onsets that
    somebody added as impacts."""

    sound: Sound
    onsets: Onsets
    chain: Chain
    added: tuple[int, ...]
    drops: tuple[HeardDrop, ...]
    notes: tuple[str, ...]


def sound_of(recording: Recording) -> Path | None:
    """The file whose sound belongs to a recording; None where there is none."""
    if recording.sound is not None:
        return recording.sound
    if recording.evidence == "sound":
        return recording.files[0]
    return (
        recording.files[0]
        if recording.evidence == "video" and has_sound(recording.files[0])
        else None
    )


def impacts_in_sound(file: Path, recording: Recording) -> SoundImpacts:
    """Detect the impacts in a sound and apply the recording's corrections.
    MeasurementError for fewer than two impacts."""
    return find_impacts(*read_onsets(file, recording), recording)


def read_onsets(file: Path, recording: Recording) -> tuple[Sound, Onsets]:
    """Read a sound and find its onsets. MeasurementError where there is no sound, or
    the rig is no drop."""
    if recording.rig != "drop":
        raise MeasurementError(
            f"{file}: sound shows the impacts of a drop; a {recording.rig} needs"
            " pictures, a track or light gates"
        )
    film = recording.evidence == "video" and recording.sound is None
    stated, file_fps = recording.camera.fps, film_fps(file) if film else None
    if stated and file_fps and abs(stated / file_fps - 1) > MOST_RATE_DIFFERENCE:
        raise MeasurementError(
            f"{file}: [camera] fps = {stated:g}, but the file plays {file_fps:g} a"
            " second, and its sound with it: slow motion"
        )
    sound = read_heard(file)
    return sound, find_onsets(sound)


def find_impacts(sound: Sound, onsets: Onsets, recording: Recording) -> SoundImpacts:
    """Select the onsets that are impacts and apply the recording's corrections.
    MeasurementError for fewer than two impacts."""
    found = find_chain(onsets, sound.duration_s, recording.drop.height_mm)
    onsets, chain, added, corrections = correct_impacts(
        sound, onsets, found, recording.drop, str(recording.toml)
    )
    counts = np.bincount(chain.drop)
    if not (counts >= 2).any():
        raise MeasurementError(
            f"{sound.path}: {'; '.join(corrections) or _too_few(onsets)}"
        )
    drops, said = [], []
    for number in np.flatnonzero(counts >= 2):
        one, notes = _heard_drop(
            chain, onsets, int(number), recording, bool(corrections)
        )
        drops.append(one)
        said += [
            note if len(counts) == 1 else f"drop {len(drops)}: {note}" for note in notes
        ]
    alone = [
        f"the impact at {onsets.time_s[row]:.3f} s is alone and is not used"
        for row in chain.impacts[counts[chain.drop] == 1]
    ]
    count = [f"{len(drops)} drops heard"] if len(drops) > 1 else []
    first, *others = said
    rejected = _rejection_notes(chain, onsets)
    notes = [*sound.notes, *count, first, *corrections, *others, *alone, *rejected]
    return SoundImpacts(sound, onsets, chain, added, tuple(drops), tuple(notes))


def _heard_drop(
    chain: Chain, onsets: Onsets, number: int, recording: Recording, corrected: bool
) -> tuple[HeardDrop, list[str]]:
    """One drop of a chain, and notes; corrected: by hand."""
    own = chain.drop == number
    impacts, missed = chain.impacts[own], chain.missed[own]
    rows, first, notes = _longest_complete_run(impacts, missed, onsets)
    doubt = (
        ""
        if corrected or chain.log_odds[number] > LEAST_LOG_ODDS
        else "few impacts, and other sounds nearly as likely to be them"
    )
    if (
        len(rows) == 2
        and len(impacts) == 2
        and not recording.drop.height_mm
        and not corrected
    ):
        doubt = "two impacts, one interval: another impact may lie between them"
    times, sd = onsets.time_s[rows], onsets.sd_s[rows]
    listed = (
        f"{len(rows)} impacts heard, the first at {times[0]:.4f} s, to ±"
        f" {1000 * np.median(sd):.2g} ms each"
    )
    return HeardDrop(times, sd, first, doubt), [listed, *notes]


def _too_few(onsets: Onsets) -> str:
    message = (
        f"{len(onsets)} sudden sounds, but none whose intervals shrink as those of a"
        " bouncing body's impacts"
    )
    advice = (
        "lay the phone beside the plate, let nothing else sound, and record until all"
        " is still"
    )
    return f"{message if len(onsets) else 'no impact is heard'}; {advice}"


def _longest_complete_run(
    impacts: np.ndarray, missed: np.ndarray, onsets: Onsets
) -> tuple[np.ndarray, bool, list[str]]:
    """The longest run of impacts with none missing, whether it begins with the first of
    all, notes."""
    edges = [0, *np.flatnonzero(missed), len(impacts)]
    a, b = max(
        itertools.pairwise(edges), key=lambda part: (part[1] - part[0], -part[0])
    )
    notes = [
        f"an impact between {onsets.time_s[impacts[k - 1]]:.3f} and"
        f" {onsets.time_s[impacts[k]]:.3f} s was not heard"
        for k in np.flatnonzero(missed)
    ]
    if notes:
        notes.append(
            f"the {b - a} impacts that follow one another without a gap are used"
        )
    return impacts[a:b], a == 0, notes


def _rejection_notes(chain: Chain, onsets: Onsets) -> list[str]:
    """One note for each reason of rejection, with the times of the sounds."""
    by_reason: dict[str, list[str]] = {}
    for row, reason in chain.rejected.items():
        by_reason.setdefault(reason, []).append(f"{onsets.time_s[row]:.3f}")
    more = {
        reason: f" and {len(at) - MOST_LISTED} more" if len(at) > MOST_LISTED else ""
        for reason, at in by_reason.items()
    }
    return [
        f"no impact: the sound at {', '.join(at[:MOST_LISTED])} s{more[reason]}:"
        f" {reason}"
        for reason, at in by_reason.items()
    ]


def observe_sound(recording: Recording, file: Path) -> Observation:
    """Measure a drop by its sound alone."""
    heard = impacts_in_sound(file, recording)
    found = sound_observation(heard, recording)
    shown = [
        q for q in found.quantities if q.name.startswith("restitution") and q.value > 0
    ]
    caption = ", ".join(q.in_words for q in shown)
    return replace(
        found,
        pictures={
            "sound": draw_sound(
                heard.sound, heard.onsets, heard.chain, heard.added, caption
            )
        },
    )


def sound_observation(heard: SoundImpacts, recording: Recording) -> Observation:
    """Quantities of the drops in a sound, without an overlay."""
    drops = [_observe_drop(drop, recording) for drop in heard.drops]
    found = drops[0] if len(drops) == 1 else over_drops(drops)
    return replace(found, notes=tuple(dict.fromkeys((*heard.notes, *found.notes))))


def _observe_drop(drop: HeardDrop, recording: Recording) -> Observation:
    quantities, bounces, notes = measure_impacts(
        drop.times, drop.sd, recording, first=drop.first
    )
    if drop.doubt:
        quantities = tuple(
            (
                q
                if q.quality == FAILED or q.name == "impact_speed"
                else q.doubt(drop.doubt)
            )
            for q in quantities
        )
    return Observation(recording.id, "drop", quantities, tuple(notes), bounces=bounces)


def combine_with_sound(
    seen: Observation, recording: Recording, file: Path
) -> Observation:
    """Combine what was measured on the pictures of a recording's drops with its
    sound."""
    try:
        heard = observe_sound(recording, file)
    except MeasurementError as error:
        return replace(seen, notes=(*seen.notes, f"its sound is not used: {error}"))
    pictures = {**seen.pictures, **heard.pictures}
    if all(q.quality == FAILED for q in seen.quantities):
        note = (
            f"nothing could be measured on the pictures ({seen.quantities[0].reason}):"
            " the quantities are from the sound"
        )
        return replace(
            heard,
            notes=tuple(dict.fromkeys((note, *seen.notes, *heard.notes))),
            pictures=pictures,
            track=seen.track,
        )
    if seen.bounces is None or "t_s" not in seen.bounces:
        note = (
            "the pictures have no clock ([camera] fps): the sound is not matched to"
            " them"
        )
        shift, agree = None, True
    else:
        shift, note, agree = _clock_shift(
            seen.bounces, heard.bounces, recording.sound is None
        )
    if shift is not None and (seen.repeats or heard.repeats):
        both = _combine_drops(seen, heard, shift)
    else:
        both = _combine_drop(seen, heard, shift)
    if not agree:
        both = replace(
            both,
            quantities=tuple(
                q if q.quality == FAILED else q.doubt(note) for q in both.quantities
            ),
        )
    notes = tuple(dict.fromkeys((*both.notes, *heard.notes, note)))
    return replace(both, notes=notes, pictures=pictures)


def _combine_drops(seen: Observation, heard: Observation, shift: float) -> Observation:
    """Several drops, each by both where one bounce of it is seen and heard, else by
    what there is of it; means over all."""
    drops = []
    others = {
        float(one.bounces.t_s.iloc[0]) - shift: one
        for one in each_drop(heard)
        if one.bounces is not None
    }
    for one in each_drop(seen):
        assert one.bounces is not None
        begin, end = one.bounces.t_s.min(), one.bounces.t_s.max()
        same = next(
            (
                (at, other)
                for at, other in others.items()
                if other.bounces is not None
                and at < end + SAME_IMPACT_S
                and begin < other.bounces.t_s.max() - shift + SAME_IMPACT_S
            ),
            None,
        )
        if same is not None:
            at, other = same
            del others[at]
            one = _combine_drop(one, other, shift)
        drops.append((begin, one))
    for at, other in others.items():
        assert other.bounces is not None
        bounces = other.bounces.assign(t_s=other.bounces.t_s - shift)
        drops.append((at, replace(other, bounces=bounces)))
    drops.sort(key=lambda drop: drop[0])
    found = over_drops([replace(drop, notes=()) for _, drop in drops])
    return replace(
        seen,
        **{name: getattr(found, name) for name in ("quantities", "repeats", "bounces")},
        notes=(*found.notes, *seen.notes),
    )


def _clock_shift(
    seen: pd.DataFrame, heard: pd.DataFrame, from_film: bool
) -> tuple[float | None, str, bool]:
    """Lag of the sound behind the pictures [s] (None: no impacts match), a note,
    whether both agree. own: sound of the film itself."""
    a, a_sd = seen.t_s.to_numpy(), seen.t_sd_s.to_numpy()
    b, b_sd = heard.t_s.to_numpy(), heard.t_sd_s.to_numpy()
    off = b[None] - a[:, None]
    sd = np.hypot(a_sd[:, None], b_sd[None])
    near = np.maximum(SAME_IMPACT_S, 3 * sd)
    tried = off[
        np.isfinite(off)
        & (~np.full(off.shape, from_film) | (np.abs(off) < MOST_SHIFT_S + near))
    ]
    if not tried.size:
        return (
            None,
            (
                "no impact heard is near one seen: sound and pictures are of different"
                " drops, or far out of step"
            ),
            False,
        )
    fits = [(np.abs(off - lag) < near) for lag in tried]
    best = max(
        range(len(tried)),
        key=lambda k: (fits[k].sum(), -np.abs(off - tried[k])[fits[k]].sum()),
    )
    pairs = fits[best]
    if pairs.sum() < min(2, len(a)):
        return (
            None,
            (
                "only one impact is both seen and heard: sound and pictures could not"
                " be matched"
            ),
            len(a) < 2,
        )
    weight = 1 / sd[pairs] ** 2
    lag = float(np.average(off[pairs], weights=weight))
    chi = float(np.sum(weight * (off[pairs] - lag) ** 2))
    spread = max(1.0, np.sqrt(chi / max(1, pairs.sum() - 1)))
    lag_sd = float(spread / np.sqrt(weight.sum()))
    amount = f"{1000 * lag:.1f} ± {1000 * lag_sd:.1f} ms"
    if not from_film:
        message = f"the sound's clock runs {amount} after that of the pictures"
    elif abs(lag) > 3 * lag_sd:
        message = (
            f"the sound is shifted by {amount} against the pictures; only its intervals"
            " are used"
        )
    else:
        message = f"sound and pictures are in step: {amount} apart"
    return lag, f"{message} (impacts both seen and heard: {int(pairs.sum())})", True


def _combine_quantities(q: Quantity, others: tuple[Quantity, ...]) -> Quantity:
    """The quantity from pictures and sound; that of the sound where the pictures have
    none or no scale."""
    o = next((o for o in others if o.name == q.name and o.quality != FAILED), None)
    if o is None or not o.sd > 0:
        return q
    if q.quality == FAILED or not q.sd > 0 or q.unit != o.unit:
        return o
    if abs(q.value - o.value) > CONTRADICTION_SDS * np.hypot(q.sd, o.sd):
        better = min((q, o), key=lambda one: (one.quality != GOOD, one.sd))
        return better.doubt(
            f"the pictures give {plus_minus(q.value, q.sd, q.unit)}, the sound"
            f" {plus_minus(o.value, o.sd, o.unit)}"
        )
    if q.quality != o.quality:
        return q if q.quality == GOOD else o
    weight = np.array([q.sd**-2, o.sd**-2])
    value = float(np.average([q.value, o.value], weights=weight))
    return replace(q, value=value, sd=float(weight.sum() ** -0.5))


def _combine_drop(
    seen: Observation, heard: Observation, shift: float | None
) -> Observation:
    """One drop by both. Where the sound tells nothing good of the first bounce, or
    contradicts it, its restitution is that of this bounce's row in both tables."""
    quantities = [_combine_quantities(q, heard.quantities) for q in seen.quantities]
    if shift is None:
        return replace(seen, quantities=tuple(quantities))
    bounces, doubt = _combine_bounces(seen.bounces, heard.bounces, shift)
    told = any(q.name == NORMAL and q.quality == GOOD for q in heard.quantities)
    for k, q in enumerate(seen.quantities):
        if q.name == NORMAL and q.quality != FAILED and (doubt or not told):
            e, sd = bounces[["restitution", "restitution_sd"]].iloc[0].tolist()
            common = min(q.sd_common, sd)
            quantities[k] = replace(q, value=e, sd=sd, sd_common=common).doubt(doubt)
    return replace(seen, quantities=tuple(quantities), bounces=bounces)


def _combine_bounces(
    seen: pd.DataFrame, heard: pd.DataFrame, shift: float
) -> tuple[pd.DataFrame, str]:
    """The bounces seen, with the impact times of the sound and the weighted means of
    both restitutions, of those that contradict each other the one of less sd; behind
    them those that were only heard. And what contradicts the first bounce, or ""."""
    out, heard, doubt = seen.copy(), heard.reset_index(drop=True), ""
    last = None
    for k, row in seen.iterrows():
        off = np.abs(heard.t_s - shift - row.t_s)
        j = int(off.argmin())
        if off[j] > max(SAME_IMPACT_S, 3 * row.t_sd_s):
            continue
        last = j
        out.loc[k, ["t_s", "t_sd_s"]] = heard.t_s[j] - shift, heard.t_sd_s[j]
        one, two = (
            (row.restitution, row.restitution_sd),
            (heard.restitution[j], heard.restitution_sd[j]),
        )
        if not np.isfinite([*one, *two]).all():
            continue
        weight = np.array([one[1] ** -2, two[1] ** -2])
        best = np.average([one[0], two[0]], weights=weight), weight.sum() ** -0.5
        if abs(one[0] - two[0]) > CONTRADICTION_SDS * np.hypot(one[1], two[1]):
            best = min(one, two, key=lambda e: e[1])
            out.loc[k, "quality"] = DOUBTFUL
            if k == seen.index[0]:
                told = plus_minus(*one, "1"), plus_minus(*two, "1")
                doubt = f"the pictures give {told[0]}, the sound {told[1]}"
        out.loc[k, ["restitution", "restitution_sd"]] = best
    if last is not None:
        more = heard.iloc[last + 1 :].assign(
            t_s=heard.t_s - shift,
            drop=out["drop"].iloc[-1],
            bounce=heard.bounce - heard.bounce[last] + out.bounce.iloc[-1],
        )
        more = more[more.t_s > out.t_s.iloc[-1]]
        if len(more):
            out = pd.concat([out, more[[c for c in more if c in out]]])
    return out.reset_index(drop=True), doubt
