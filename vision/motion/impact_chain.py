"""Selects the onsets that are the impacts of a bouncing body, in one drop or several.

Between two impacts a body flies freely, so intervals shrink by the restitution: e = Δt₂
/ Δt₁, in (0, 1), much the same from bounce to bounce. Impacts are sudden, have similar
timbres and become fainter with their speed. Of all chains of onsets the one with the
highest likelihood ratio is selected: impacts against noise, speech or handling, which
come at random at the rate of such sounds in this recording. Solved by dynamic
programming over pairs of onsets. Before and after the likeliest chain the next one is
sought in the same way: a recording holds as many drops as chains stand out."""

import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from benchtwin.bench.constants import G_MM_S2
from benchtwin.bench.language import tr
from benchtwin.bench.priors import unstated_sd
from benchtwin.vision.evidence.sound import Sound
from benchtwin.vision.measurement import MeasurementError, require
from benchtwin.vision.motion.onsets import APART_S, HEARD, Onsets, onset_near

G = G_MM_S2 / 1000  # m/s²
LEAST_E, MOST_E = 0.08, 1.0
# of ln e from bounce to bounce, by which a seed's shape and plate scatter it
E_SD = 0.12
# of ln e of the first bounce, from the stated height, which was read off a ruler
FIRST_E_SD = 0.5
LEVEL_POWER, LEVEL_SD_DB = 1.2, 6.0  # loudness against speed, and its scatter
# cosine of two timbres at which the likelihood ratio is 1; ln likelihood ratio per
# cosine
ALIKE, ALIKE_WEIGHT = (0.75, 5.0)
SUDDEN_S, LASTS_DB = 5e-3, -4.0
# ln likelihood ratio against an impact where a sound rises slowly or lasts
NOT_SUDDEN = 4.0
LEAST_INTERVAL_S = 0.02
LONGEST_S = (2.5, 1.2, 0.6, 0.3)  # of intervals, each a hypothesis
OTHERS = 0.3  # other sounds as loud that are expected in a recording without any
PASSES = 4
LEAST_LOG_ODDS = 3.0  # of a chain: noise alone seldom makes one of 4
PRIOR_LOG_ODDS = 4.0  # that a recording of a drop contains its impacts
# cost in ln likelihood of a rebound higher than the stated fall: a misread height, or a
# missed first impact
HIGHER = 6.0
UNKNOWN_FAINTER_DB = -6.0  # the second impact than the first, where no height is stated
MISSED = 6.0  # cost in ln likelihood of an impact that was not heard
COST = 2.0  # in ln likelihood, of each impact
# delay of echoes, its scatter, by how much they are fainter
ECHO_S = (3e-3, 0.065)
ECHO_SD_S = 4e-4
FAINTER_DB = 3.0
ECHO = 4.0  # ln likelihood ratio against an impact at the delay of an echo
BESIDE_S = (
    0.02,
    0.02,
)  # before and after an onset, where others are a part of its sound
LEAST_STRENGTH = 4.0  # of a sound that stands out from the noise
DOUBLE_S = 0.04  # within which the other end of a long seed hits the plate
STRUCK = "struck out by hand"
# ln odds of the chain of a further drop that is like the drop that stands out most: in
# drawn sound those of handling reach 4.0, those of drops are 5.5 and more
FURTHER_LOG_ODDS = 5.0
FIRST_INTERVAL_SD = 0.35  # of ln of the first intervals of a recording's drops
# between two drops at least, in which a seed is taken up and let go: seconds, and
# intervals of the bounces beside it
RELEASE_S, RELEASE_INTERVALS = 0.4, 2.2


PRIOR_SD_S, PRIOR_FACTOR = 2e-4, 2.0  # log-normal prior of the sd of an impact time


# Rows of the impacts of one drop, whether one before each was missed, ln odds.
_OneDrop = tuple[np.ndarray, np.ndarray, float]


def find_chain(
    onsets: Onsets, duration_s: float, height_mm: float | None
) -> tuple[Onsets, tuple[float, ...]]:
    """The onsets with the likeliest chain of impacts and those of further drops before
    and after it, of none where there are not two impacts, and ln odds of each drop;
    height_mm: of the fall, None where it is not stated.

    First impacts of several drops may look like a chain, too: drops of longer and of
    shorter intervals only are compared, by the evidence of all drops together."""
    lasts = 2 * math.sqrt(2 * height_mm / 1000 / G) if height_mm else None
    falls = [(lasts, longest) for longest in LONGEST_S]
    drops = max((_drops(onsets, duration_s, f) for f in falls), key=_evidence)
    found = onsets.copy()
    for number, (rows, missed, _) in enumerate(drops):
        found.drop[rows], found.missed[rows] = number, missed
    found.why = _rejections(found)
    return found, tuple(log_odds for *_, log_odds in drops)


# how long a rebound to the height of the fall would last, None where that is not
# stated; the longest interval [s]
_Fall = tuple[float | None, float]


def _first(
    lasts_s: float | None, gap_s: float, change_db: float
) -> tuple[float, float]:
    """ln likelihood of a first interval and of the change of loudness over it, and the
    restitution, NaN where the fall is not stated."""
    if lasts_s is None:
        rise_mm = 1000 * G * gap_s**2 / 8
        ln = _log_likelihood_of_level(change_db, UNKNOWN_FAINTER_DB)
        return ln - (rise_mm / unstated_sd("fall")) ** 2 / 2, math.nan
    e = gap_s / lasts_s
    fainter = 20 * LEVEL_POWER * math.log10(min(e, 1.0))
    ln = _log_likelihood_of_level(change_db, fainter)
    return ln - HIGHER * (e > MOST_E), e


def _evidence(drops: Sequence[_OneDrop]) -> float:
    """ln odds of several drops, each further one at its own cost; 0 of none."""
    return sum(log_odds - FURTHER_LOG_ODDS for *_, log_odds in drops) + (
        FURTHER_LOG_ODDS if drops else 0.0
    )


def _drops(onsets: Onsets, duration_s: float, fall: _Fall) -> list[_OneDrop]:
    """The likeliest chain and those before and after it, in the order of time."""
    drops: list[_OneDrop] = []
    for further in (False, True) if len(onsets) > 1 else ():
        for _ in range(PASSES if drops or not further else 0):
            known = _rows(drops)
            likelihoods = _log_likelihoods(onsets, duration_s, known)
            alone = further and len(drops) == 1
            first = drops[0] if alone else _likeliest_chain(onsets, likelihoods, fall)
            drops = [first] if len(first[0]) else []
            if further:
                drops = _further(onsets, likelihoods, fall, first)
            if np.array_equal(_rows(drops), known):
                break
    return drops


def _rows(drops: Sequence[_OneDrop]) -> np.ndarray:
    return np.concatenate([np.zeros(0, int), *(rows for rows, _, _ in drops)])


def _further(
    o: Onsets, log_likelihood: np.ndarray, fall: _Fall, first: _OneDrop
) -> list[_OneDrop]:
    """All drops in the order of time, `first` among them: the likeliest chain of what
    comes before those found and after them, again and again."""
    drops, gaps = [first], [(-1, first[0][0]), (first[0][-1], len(o))]
    while gaps:
        begin, end = gaps.pop()
        inside = np.arange(begin + 1, end)
        if len(inside) < 2:
            continue
        rows, missed, log_odds = _likeliest_chain(
            o[inside], log_likelihood[inside], fall
        )
        rows = inside[rows]
        if len(rows) and log_odds + _alike(o, first[0], rows) > FURTHER_LOG_ODDS:
            drops.append((rows, missed, log_odds))
            gaps += [(begin, rows[0]), (rows[-1], end)]
    drops.sort(key=lambda drop: drop[0][0])
    whole = drops[:1]
    for drop in drops[1:]:
        if _released_between(o, whole[-1][0], drop[0]):
            whole.append(drop)
        else:
            whole[-1] = _joined(whole[-1], drop)
    return whole


def _released_between(o: Onsets, one: np.ndarray, other: np.ndarray) -> bool:
    """Whether the silence between two chains is long enough for another release."""
    beside = max(np.diff(o.time_s[one[-2:]])[0], np.diff(o.time_s[other[:2]])[0])
    silence = o.time_s[other[0]] - o.time_s[one[-1]]
    return bool(silence > max(RELEASE_S, RELEASE_INTERVALS * beside))


def _joined(one: _OneDrop, other: _OneDrop) -> _OneDrop:
    """Both chains as one drop, with impacts between them that were not heard."""
    rows, missed = (np.concatenate([one[k], other[k]]) for k in (0, 1))
    missed[len(one[0])] = True
    return rows, missed, max(one[2], other[2])


def _alike(o: Onsets, one: np.ndarray, other: np.ndarray) -> float:
    """ln likelihood ratio of two drops of one seed, plate and height, by the sound of
    their first two impacts and the interval between these."""
    ring = (o.timbre[one[:2]] * o.timbre[other[:2]]).sum(axis=1)
    apart = math.log(np.diff(o.time_s[other[:2]])[0] / np.diff(o.time_s[one[:2]])[0])
    return (
        ALIKE_WEIGHT * float((ring - ALIKE).sum())
        - (apart / FIRST_INTERVAL_SD) ** 2 / 2
    )


def _log_likelihoods(o: Onsets, duration: float, known: np.ndarray) -> np.ndarray:
    """(n,): ln likelihood ratio of each onset being an impact, expected within a
    second, against another sound as loud. known: rows of the impacts found so far,
    which do not count among the others."""
    sudden = (o.rise_s <= SUDDEN_S) & (o.lasting_db <= LASTS_DB)
    other = np.ones(len(o), bool)
    other[known] = False
    louder = (
        (o.level_db[None] >= o.level_db[:, None])
        & other[None]
        & (sudden[None] | ~sudden[:, None])
    )
    np.fill_diagonal(louder, False)
    others = (louder.sum(axis=1) + OTHERS) / duration
    return (
        -np.log(np.exp(-o.strength) + others)
        - NOT_SUDDEN * ~sudden
        - ECHO * (echo_lags(o) > 0)
        - _beside_stronger(o)
        - COST
    )


def _beside_stronger(o: Onsets) -> np.ndarray:
    """(n,): ln likelihood ratio against onsets just before or after a much stronger
    one: pre-echoes, swelling rings."""
    lag = o.time_s[:, None] - o.time_s[None]
    near = (lag > -BESIDE_S[0]) & (lag < BESIDE_S[1]) & (lag != 0)
    strength = np.maximum(o.strength, 1.0)
    most = np.where(near, strength[None], 1.0).max(axis=1)
    return np.clip(np.log(most / strength) - math.log(2), 0, ECHO)


def echo_lags(o: Onsets) -> np.ndarray:
    """(n,) [s]: delay of each onset after a louder one of similar timbre, if another
    pair has the same delay; else 0."""
    lag = o.time_s[:, None] - o.time_s[None]
    heard = o.strength > LEAST_STRENGTH
    pair = (
        (lag > ECHO_S[0])
        & (lag < ECHO_S[1])
        & (o.level_db[:, None] < o.level_db[None] - FAINTER_DB)
        & heard[:, None]
        & heard[None]
    )
    late, early = np.nonzero(pair & (o.timbre @ o.timbre.T > ALIKE))
    out = np.zeros(len(o))
    for i, j in zip(late, early):
        alike = np.abs(lag[late, early] - lag[i, j]) < ECHO_SD_S
        same = (alike) & (late != i) & (early != j) & (late != j) & (early != i)
        if same.any():
            out[i] = lag[i, j]
    return out


def _likeliest_chain(o: Onsets, log_likelihood: np.ndarray, fall: _Fall) -> _OneDrop:
    """Rows of the likeliest chain, whether an impact before each was missed, ln odds.
    State: the pair (j, k) of successive impacts; `score` is the ln likelihood ratio of
    the best chain that ends with it."""
    (lasts_s, longest_s), n, t = fall, len(o), o.time_s
    alike = o.timbre @ o.timbre.T
    audible = np.clip((o.level_db + 3) / 10, 0, 1)  # how well a timbre is heard at all
    score = np.full((n, n), -np.inf)
    interval = np.zeros((n, n))
    e = np.full((n, n), np.nan)
    previous = np.full((n, n), -1)
    skipped = np.zeros((n, n), bool)
    for k in range(n):
        for j in range(k - 1, -1, -1):
            gap = t[k] - t[j]
            if gap > longest_s:
                break
            if gap < LEAST_INTERVAL_S:
                continue
            pair = (
                ALIKE_WEIGHT * (alike[j, k] - ALIKE) * min(audible[j], audible[k])
                + log_likelihood[k]
            )
            begin = log_likelihood[j] + pair - math.log(gap + 0.1) + PRIOR_LOG_ODDS
            due, first_e = _first(lasts_s, gap, o.level_db[k] - o.level_db[j])
            score[j, k], interval[j, k], e[j, k] = begin + due, gap, first_e
            before = np.flatnonzero(np.isfinite(score[:j, j]))
            if not len(before):
                continue
            for lost in (False, True):
                q = gap / interval[before, j]
                now = (np.sqrt(1 + 4 * q) - 1) / 2 if lost else q
                fits = (now > LEAST_E) & (now <= MOST_E)
                old = e[before, j]
                prior_sd = np.where(previous[before, j] < 0, FIRST_E_SD, E_SD)
                wide_tails = -1.5 * np.log1p((np.log(now / old) / prior_sd) ** 2 / 2)
                like = np.where(np.isfinite(old), wide_tails, -1.0)
                due = -np.log(0.3 * gap)
                fainter = _log_likelihood_of_level(
                    o.level_db[k] - o.level_db[j],
                    20 * LEVEL_POWER * np.log10(now) * (1 + lost),
                )
                total = score[before, j] + pair + like + due + fainter
                whole = np.where(fits, total - MISSED * lost, -np.inf)
                best = int(np.argmax(whole))
                if whole[best] > score[j, k]:
                    score[j, k] = whole[best]
                    previous[j, k] = before[best]
                    e[j, k] = now[best]
                    skipped[j, k] = lost
                    interval[j, k] = gap * now[best] / (1 + now[best]) if lost else gap
    return _backtrack(score, previous, skipped)


def _backtrack(
    score: np.ndarray, previous: np.ndarray, skipped: np.ndarray
) -> _OneDrop:
    none = np.zeros(0, int), np.zeros(0, bool), -math.inf
    if not np.isfinite(score).any() or score.max() < LEAST_LOG_ODDS:
        return none
    j, k = np.unravel_index(int(np.argmax(score)), score.shape)
    log_odds, chain, lost = float(score[j, k]), [int(k)], []
    while j >= 0:
        lost.append(bool(skipped[j, k]))
        chain.append(int(j))
        j, k = previous[j, k], j
    return np.array(chain[::-1]), np.array([False, *lost[::-1]]), log_odds


def _log_likelihood_of_level(change_db, due_db):
    return -0.5 * np.minimum(((change_db - due_db) / LEVEL_SD_DB) ** 2, 8.0)


def _rejections(o: Onsets) -> np.ndarray:
    """Why each onset that stands out from the noise is no impact, else ""."""
    impacts = np.flatnonzero(o.drop >= 0)
    lags, times = echo_lags(o), o.time_s[impacts]
    first, last = (times[0], times[-1]) if len(times) else (-np.inf, np.inf)
    out = o.why.copy()
    heard = np.flatnonzero(o.strength > LEAST_STRENGTH)
    for i in np.setdiff1d(heard, impacts).tolist():
        after = o.time_s[i] - times
        after_ms = 1000 * after[after > 0].min(initial=np.inf)
        lag = tr(
            "an echo, {:.1f} ms after a louder sound as after others", 1000 * lags[i]
        )
        reasons = (
            (lags[i], lag),
            (
                after_ms < 1000 * DOUBLE_S,
                tr("a second hit or an echo, {:.1f} ms after an impact", after_ms),
            ),
            (o.rise_s[i] > SUDDEN_S, tr("it rises slowly, as speech and handling do")),
            (o.lasting_db[i] > LASTS_DB, tr("it lasts, as speech does")),
            (
                o.time_s[i] < first,
                tr("it comes before the first impact and does not fit the intervals"),
            ),
            (o.time_s[i] > last, tr("it comes after the last impact that was found")),
            (True, tr("it does not fit the shrinking intervals")),
        )
        out[i] = next(why for holds, why in reasons if holds)
    return out


def correct_impacts(
    sound: Sound, onsets: Onsets, drop: Any, where: str
) -> tuple[Onsets, list[str]]:
    """The onsets, and notes, after the corrections in `drop`, which the file `where`
    states."""
    if not (drop.impacts_added_s or drop.impacts_struck_s):
        return onsets, []
    for name in ("impacts_added_s", "impacts_struck_s"):
        for at in getattr(drop, name) or ():
            if not sound.start_s <= at <= sound.start_s + sound.duration_s:
                until = sound.start_s + sound.duration_s
                raise MeasurementError(
                    tr(
                        "{}: [drop] {}: {:g} s is not in this sound, {:.3g} to {:.4g}"
                        " s",
                        where,
                        name,
                        at,
                        sound.start_s,
                        until,
                    )
                )
    found = _with_added(sound, onsets, drop.impacts_added_s or ())
    before, notes = found[found.drop >= 0], []
    for at in drop.impacts_struck_s or ():
        row = _nearest(found.time_s, at)
        require(
            row is None or not found.added[row],
            tr(
                "{}: [drop] impacts_added_s and impacts_struck_s both name the impact"
                " at {:g} s",
                where,
                at,
            ),
        )
        if row is None or found.time_s[row] not in before.time_s:
            notes.append(
                tr("{:g} s is struck out by hand, but no impact was found there", at)
            )
        else:
            found.drop[row], found.why[row] = -1, STRUCK
    rows = np.flatnonzero((found.drop >= 0) | found.added)
    times = found.time_s[rows]
    found.drop[rows] = _numbered(times, found.drop[rows])
    found.missed[rows] = _missed(before, times, found.drop[rows])
    added, struck = found.added.sum(), (found.why == STRUCK).sum()
    notes.insert(0, tr("impacts set by hand: {} added, {} struck out", added, struck))
    return found, notes


def _with_added(sound: Sound, onsets: Onsets, moments: Sequence[float]) -> Onsets:
    """Onsets with the added ones, which are marked."""
    new = [
        onset_near(sound, at) for at in moments if _nearest(onsets.time_s, at) is None
    ]
    unheard = np.zeros(len(new), onsets.dtype)
    for name in HEARD:
        unheard[name] = np.nan
    unheard["time_s"], unheard["sd_s"] = np.reshape(new, (-1, 2)).T
    unheard["drop"], unheard["why"] = -1, ""
    grown = np.concatenate([onsets, unheard]).view(Onsets)
    grown = grown[np.argsort(grown.time_s, kind="stable")]
    rows = [int(np.abs(grown.time_s - at).argmin()) for at in moments]
    grown.added[rows], grown.why[rows] = True, ""
    return grown


def _nearest(times: np.ndarray, at: float) -> int | None:
    """Row of the onset nearest to a moment, None where none is within APART_S."""
    if not len(times):
        return None
    row = int(np.abs(times - at).argmin())
    return row if abs(times[row] - at) <= APART_S else None


def _numbered(times: np.ndarray, drop: np.ndarray) -> np.ndarray:
    """(m,): the drop that each impact is of, numbered anew; drop: −1 where it was added
    by hand. Between two drops the longest silence parts them; an added impact farther
    than the longest flight from its neighbour is of another drop."""
    gap, known = np.diff(times), np.flatnonzero(drop >= 0)
    begins = np.zeros(len(times), bool)
    begins[1:] = (gap > LONGEST_S[0]) & ((drop[1:] < 0) | (drop[:-1] < 0))
    for a, b in itertools.pairwise(known):
        if drop[a] != drop[b]:
            begins[a + 1 + np.argmax(gap[a:b])] = True
    return np.cumsum(begins)


def _missed(before: Onsets, times: np.ndarray, drop: np.ndarray) -> np.ndarray:
    """(m,): whether an impact of the same drop is still missing between each impact and
    the one before; before: the impacts as they were found."""
    gaps = [before.time_s[[k - 1, k]] for k in np.flatnonzero(before.missed)]
    inside = [
        any(a <= first and last <= b for first, last in gaps)
        for a, b in itertools.pairwise(times)
    ]
    same = np.diff(drop, prepend=-1) == 0
    return np.array([False, *inside][: len(times)], bool) & same


def estimate_time_sds(times: np.ndarray) -> np.ndarray:
    """(n,), all equal: estimated sd [s] of impact times without a stated one, by their
    rounding and scatter: an error of a time changes two intervals in opposite ways, a
    scatter of the restitution does not. Posterior
    mean from the scatter of ln Δt, in which errors of times and of e differ in
    correlation; at least the rounding."""
    least = _rounding(times) / math.sqrt(12)
    sigma = np.maximum(np.geomspace(2e-6, 2e-2, 41), least)
    log_weight = -0.5 * (np.log(sigma / PRIOR_SD_S) / math.log(PRIOR_FACTOR)) ** 2
    gap = np.diff(times)
    if len(gap) > 2:
        y = np.diff(np.log(gap))
        apart = np.diff(np.eye(len(times)), axis=0)  # of gap with the times
        slope = np.diff(apart / gap[:, None], axis=0)  # of y
        centred = np.linalg.svd(np.ones((len(y), 1)))[0][:, 1:].T  # e itself is unknown
        values, shape = centred @ y, centred @ slope @ slope.T @ centred.T
        axes, turned = np.linalg.eigh(shape)
        power = (turned.T @ values) ** 2
        variance = (
            sigma[:, None, None] ** 2 * np.maximum(axes, 0)
            + np.geomspace(1e-3, 0.2, 15)[:, None] ** 2
        )
        each = -0.5 * (np.log(variance) + power / variance).sum(axis=2)
        log_weight = log_weight + np.logaddexp.reduce(each, axis=1)
    weight = np.exp(log_weight - log_weight.max())
    return np.full(
        len(times), max(np.exp(weight @ np.log(sigma) / weight.sum()), least)
    )


def _rounding(times: np.ndarray) -> float:
    """The step to which the times were rounded when written: 0.001 for 0.271, 0.522."""
    exact = (
        np.allclose(times, np.round(times, digits), rtol=0, atol=1e-9)
        for digits in range(7)
    )
    return next(
        (10.0**-digits for digits, is_exact in enumerate(exact) if is_exact), 0.0
    )
