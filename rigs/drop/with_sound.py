"""Drops by their sound, alone or combined with pictures of the same drops. A recording
may hold several: each is measured by itself, and the quantities are means over them.

The clock of the sound may be shifted against that of the pictures: a film's tracks are
not exactly in step, sound takes 3 ms a metre, a separate file begins at any time. The
shift is estimated from the impacts and noted; intervals do not depend on it. Quantities
that both give are averaged, weighted by their variances; where they contradict each
other they are doubtful."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from benchtwin.bench.language import tr
from benchtwin.bench.numbers import plus_minus
from benchtwin.rigs.drop.heard import measure_impacts
from benchtwin.vision.measurement import (
    DOUBTFUL,
    FAILED,
    GOOD,
    MeasurementError,
    Observation,
    Quantity,
)
from benchtwin.vision.motion.drop_sound import HeardDrop, SoundImpacts, impacts_in_sound
from benchtwin.vision.motion.several_drops import each_drop, over_drops
from benchtwin.vision.overlay.sound import draw_sound
from benchtwin.vision.recording import Recording

CONTRADICTION_SDS = 3.0
MOST_SHIFT_S = 0.3  # of a film's own sound
SAME_IMPACT_S = (
    0.03  # within which, or three sds, an impact seen and one heard may be the same
)
NORMAL = "restitution_normal"


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
        pictures={"sound": draw_sound(heard.sound, heard.onsets, caption)},
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
        return replace(
            seen, notes=(*seen.notes, tr("its sound is not used: {}", error))
        )
    pictures = {**seen.pictures, **heard.pictures}
    if all(q.quality == FAILED for q in seen.quantities):
        note = tr(
            "nothing could be measured on the pictures ({}): the quantities are from"
            " the sound",
            seen.quantities[0].reason,
        )
        return replace(
            heard,
            notes=tuple(dict.fromkeys((note, *seen.notes, *heard.notes))),
            pictures=pictures,
            track=seen.track,
        )
    if seen.bounces is None or "t_s" not in seen.bounces:
        note = tr(
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
                tr(
                    "no impact heard is near one seen: sound and pictures are of"
                    " different drops, or far out of step"
                )
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
                tr(
                    "only one impact is both seen and heard: sound and pictures could"
                    " not be matched"
                )
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
        message = tr("the sound's clock runs {} after that of the pictures", amount)
    elif abs(lag) > 3 * lag_sd:
        message = tr(
            "the sound is shifted by {} against the pictures; only its intervals are"
            " used",
            amount,
        )
    else:
        message = tr("sound and pictures are in step: {} apart", amount)
    return (
        lag,
        tr("{} (impacts both seen and heard: {})", message, int(pairs.sum())),
        True,
    )


def _combine_quantities(q: Quantity, others: tuple[Quantity, ...]) -> Quantity:
    """The quantity from pictures and sound; that of the sound where the pictures have
    none or no scale."""
    o = next((o for o in others if o.name == q.name and o.quality != FAILED), None)
    if o is None or not o.sd > 0:
        return q
    if q.quality == FAILED or not q.sd > 0 or q.unit != o.unit:
        return o
    return _weighted(q, o)


def _weighted(q: Quantity, o: Quantity) -> Quantity:
    """The mean of a quantity from pictures and from sound; the better one where one is
    doubtful, with a doubt where they contradict each other."""
    if abs(q.value - o.value) > CONTRADICTION_SDS * np.hypot(q.sd, o.sd):
        better = min((q, o), key=lambda one: (one.quality != GOOD, one.sd))
        return better.doubt(
            tr(
                "the pictures give {}, the sound {}",
                plus_minus(q.value, q.sd, q.unit),
                plus_minus(o.value, o.sd, o.unit),
            )
        )
    if q.quality != o.quality:
        return q if q.quality == GOOD else o
    weight = np.array([q.sd**-2, o.sd**-2])
    value = float(np.average([q.value, o.value], weights=weight))
    return replace(q, value=value, sd=float(weight.sum() ** -0.5))


def _combine_drop(
    seen: Observation, heard: Observation, shift: float | None
) -> Observation:
    """One drop by both, by the sound alone where its first impact is the first that is
    heard. Where the sound tells nothing good of the first bounce, or contradicts it,
    its restitution is that of this bounce's row in both tables."""
    told = heard.quantities if shift is None or _same_first(seen, heard, shift) else ()
    quantities = [_combine_quantities(q, told) for q in seen.quantities]
    if shift is None:
        return replace(seen, quantities=tuple(quantities))
    bounces, doubt = _combine_bounces(seen.bounces, heard.bounces, shift)
    good = any(q.name == NORMAL and q.quality == GOOD for q in told)
    for k, q in enumerate(seen.quantities):
        if q.name == NORMAL and q.quality != FAILED and (doubt or not good):
            e, sd = bounces[["restitution", "restitution_sd"]].iloc[0].tolist()
            common = min(q.sd_common, sd)
            quantities[k] = replace(q, value=e, sd=sd, sd_common=common).doubt(doubt)
    return replace(seen, quantities=tuple(quantities), bounces=bounces)


def _same_first(seen: Observation, heard: Observation, shift: float) -> bool:
    """Whether the first impact that was seen is the first that was heard."""
    assert seen.bounces is not None and heard.bounces is not None
    one, other = seen.bounces.iloc[0], heard.bounces.iloc[0]
    off = abs(other.t_s - shift - one.t_s)
    return bool(off <= max(SAME_IMPACT_S, 3 * np.hypot(one.t_sd_s, other.t_sd_s)))


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
        told = (
            (row.restitution, row.restitution_sd),
            (
                heard.restitution[j],
                heard.restitution_sd[j],
            ),
        )
        if not np.isfinite(told).all():
            continue
        best = _weighted(*(Quantity(NORMAL, e, sd, "1") for e, sd in told))
        if best.reason:
            out.loc[k, "quality"] = DOUBTFUL
            doubt = best.reason if k == seen.index[0] else doubt
        out.loc[k, ["restitution", "restitution_sd"]] = best.value, best.sd
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
