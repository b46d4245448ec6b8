"""Selects the onsets that are the impacts of one bouncing body.

Between two impacts a body flies freely, so intervals shrink by the restitution: e = Δt₂
/ Δt₁, in (0, 1), much the same from bounce to bounce. Impacts are sudden, have similar
timbres and become fainter with their speed. Of all chains of onsets the one with the
highest likelihood ratio is selected: impacts against noise, speech or handling, which
come at random at the rate of such sounds in this recording. Solved by dynamic
programming over pairs of onsets."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from benchtwin.bench.constants import G_MM_S2
from benchtwin.bench.keys import Drop
from benchtwin.vision.evidence.sound import Sound
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.motion.onsets import APART_S, Onsets, onset_near

G = G_MM_S2 / 1000  # m/s²
LEAST_E, MOST_E = 0.08, 1.0
E_SD = (
    0.12  # of ln e from bounce to bounce, by which a seed's shape and plate scatter it
)
# of ln e of the first bounce, from the stated height, which was read off a ruler
FIRST_E_SD = 0.5
LEVEL_POWER, LEVEL_SD_DB = 1.2, 6.0  # loudness against speed, and its scatter
# cosine of two timbres at which the likelihood ratio is 1; ln likelihood ratio per
# cosine
ALIKE, ALIKE_WEIGHT = (0.75, 5.0)
SUDDEN_S, LASTS_DB = 5e-3, -4.0
NOT_SUDDEN = (
    4.0  # ln likelihood ratio against an impact where a sound rises slowly or lasts
)
LEAST_INTERVAL_S, LONGEST_S = 0.02, 2.5
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
ECHO_S, ECHO_SD_S, FAINTER_DB = (
    (3e-3, 0.065),
    4e-4,
    3.0,
)  # delay of echoes, its scatter, by how much they are fainter
ECHO = 4.0  # ln likelihood ratio against an impact at the delay of an echo
BESIDE_S = (
    0.02,
    0.02,
)  # before and after an onset, where others are a part of its sound
LEAST_STRENGTH = 4.0  # of a sound that stands out from the noise
DOUBLE_S = 0.04  # within which the other end of a long seed hits the plate
STRUCK = "struck out by hand"


@dataclass(frozen=True, eq=False)
class Chain:
    """impacts (m,): rows of the onsets, in order; missed (m,): whether an impact before
    this one was not heard. rejected: {row: reason} of the other onsets that stand out;
    log_odds: ln likelihood ratio of the whole chain."""

    impacts: np.ndarray
    missed: np.ndarray
    rejected: dict[int, str]
    log_odds: float


def find_chain(onsets: Onsets, duration_s: float, height_mm: float | None) -> Chain:
    """The likeliest chain of impacts, empty where there are not two; height_mm: of the
    fall, None where it is not stated."""
    impacts, missed, log_odds = np.zeros(0, int), np.zeros(0, bool), -math.inf
    for _ in range(PASSES if len(onsets) > 1 else 0):
        known = impacts
        impacts, missed, log_odds = _likeliest_chain(
            onsets, _log_likelihoods(onsets, duration_s, known), height_mm
        )
        if np.array_equal(impacts, known):
            break
    return Chain(impacts, missed, _rejections(onsets, impacts), log_odds)


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
        same = (
            (np.abs(lag[late, early] - lag[i, j]) < ECHO_SD_S)
            & (late != i)
            & (early != j)
            & (late != j)
            & (early != i)
        )
        if same.any():
            out[i] = lag[i, j]
    return out


def _likeliest_chain(
    o: Onsets, log_likelihood: np.ndarray, height_mm: float | None
) -> tuple[np.ndarray, np.ndarray, float]:
    """Rows of the likeliest chain, whether an impact before each was missed, ln odds.
    State: the pair (j, k) of successive impacts; `score` is the ln likelihood ratio of
    the best chain that ends with it."""
    n, t = len(o), o.time_s
    fall = 2 * math.sqrt(2 * height_mm / 1000 / G) if height_mm else None
    alike = o.timbre @ o.timbre.T
    audible = np.clip((o.level_db + 3) / 10, 0, 1)  # how well a timbre is heard at all
    score = np.full((n, n), -np.inf)
    interval, e, previous = (
        np.zeros((n, n)),
        np.full((n, n), np.nan),
        np.full((n, n), -1),
    )
    skipped = np.zeros((n, n), bool)
    for k in range(n):
        for j in range(k - 1, -1, -1):
            gap = t[k] - t[j]
            if gap > LONGEST_S:
                break
            if gap < LEAST_INTERVAL_S:
                continue
            pair = (
                ALIKE_WEIGHT * (alike[j, k] - ALIKE) * min(audible[j], audible[k])
                + log_likelihood[k]
            )
            begin = log_likelihood[j] + pair - math.log(gap + 0.1) + PRIOR_LOG_ODDS
            first_e = gap / fall if fall else math.nan
            fainter = (
                20 * LEVEL_POWER * math.log10(min(first_e, 1.0))
                if fall
                else UNKNOWN_FAINTER_DB
            )
            begin += _log_likelihood_of_level(o.level_db[k] - o.level_db[j], fainter)
            if fall and first_e > MOST_E:
                begin -= HIGHER
            score[j, k], interval[j, k], e[j, k] = begin, gap, first_e
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
                whole = np.where(
                    fits,
                    score[before, j] + pair + like + due + fainter - MISSED * lost,
                    -np.inf,
                )
                best = int(np.argmax(whole))
                if whole[best] > score[j, k]:
                    score[j, k], previous[j, k], e[j, k], skipped[j, k] = (
                        whole[best],
                        before[best],
                        now[best],
                        lost,
                    )
                    interval[j, k] = gap * now[best] / (1 + now[best]) if lost else gap
    return _backtrack(score, previous, skipped)


def _backtrack(
    score: np.ndarray, previous: np.ndarray, skipped: np.ndarray
) -> tuple[np.ndarray, np.ndarray, float]:
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


def _rejections(o: Onsets, impacts: np.ndarray) -> dict[int, str]:
    """Why each onset that stands out from the noise is no impact, by row."""
    members = set(impacts.tolist())
    lags = echo_lags(o)
    out = {}
    for i in (
        int(i) for i in np.flatnonzero(o.strength > LEAST_STRENGTH) if i not in members
    ):
        after = o.time_s[i] - o.time_s[impacts]
        after = after[(after > 0) & (after < DOUBLE_S)]
        if lags[i]:
            out[i] = (
                f"an echo, {1000 * lags[i]:.1f} ms after a louder sound as after others"
            )
        elif len(after):
            out[i] = (
                f"a second hit or an echo, {1000 * after.min():.1f} ms after an impact"
            )
        elif o.rise_s[i] > SUDDEN_S:
            out[i] = "it rises slowly, as speech and handling do"
        elif o.lasting_db[i] > LASTS_DB:
            out[i] = "it lasts, as speech does"
        elif len(impacts) and o.time_s[i] < o.time_s[impacts[0]]:
            out[i] = "it comes before the first impact and does not fit the intervals"
        elif len(impacts) and o.time_s[i] > o.time_s[impacts[-1]]:
            out[i] = "it comes after the last impact that was found"
        else:
            out[i] = "it does not fit the shrinking intervals"
    return out


def correct_impacts(
    sound: Sound, onsets: Onsets, chain: Chain, drop: Drop, where: str
) -> tuple[Onsets, Chain, tuple[int, ...], list[str]]:
    """(onsets, chain, rows of the added impacts, notes) after the corrections in
    `drop`, which the file `where` states."""
    if not (drop.impacts_added_s or drop.impacts_struck_s):
        return onsets, chain, (), []
    for name in ("impacts_added_s", "impacts_struck_s"):
        for at in getattr(drop, name) or ():
            if not sound.start_s <= at <= sound.start_s + sound.duration_s:
                until = sound.start_s + sound.duration_s
                raise MeasurementError(
                    f"{where}: [drop] {name}: {at:g} s is not in this sound,"
                    f" {sound.start_s:.3g} to {until:.4g} s"
                )
    onsets, chain, added = _with_added(sound, onsets, chain, drop.impacts_added_s or ())
    struck, notes = set(), []
    for at in drop.impacts_struck_s or ():
        row = _nearest(onsets.time_s, at)
        if row in added:
            raise MeasurementError(
                f"{where}: [drop] impacts_added_s and impacts_struck_s both name the"
                f" impact at {at:g} s"
            )
        if row is None or row not in chain.impacts:
            notes.append(
                f"{at:g} s is struck out by hand, but no impact was found there"
            )
        else:
            struck.add(row)
    impacts = np.array(sorted((set(chain.impacts.tolist()) | set(added)) - struck), int)
    rejected = {
        row: reason for row, reason in chain.rejected.items() if row not in added
    } | dict.fromkeys(struck, STRUCK)
    notes.insert(
        0, f"impacts set by hand: {len(set(added))} added, {len(struck)} struck out"
    )
    return (
        onsets,
        replace(
            chain, impacts=impacts, missed=_missed(chain, impacts), rejected=rejected
        ),
        tuple(added),
        notes,
    )


def _with_added(
    sound: Sound, onsets: Onsets, chain: Chain, moments: Sequence[float]
) -> tuple[Onsets, Chain, list[int]]:
    """Onsets with the added ones, the chain with rows renumbered accordingly, the rows
    of all added impacts."""
    new = [
        onset_near(sound, at) for at in moments if _nearest(onsets.time_s, at) is None
    ]
    times, sds = np.array(new).reshape(-1, 2).T
    unknown = {
        "time_s": times,
        "sd_s": sds,
        "timbre": np.full((len(new), onsets.timbre.shape[1]), np.nan),
    }
    fields = Onsets.__dataclass_fields__
    grown = Onsets(
        *(
            np.concatenate(
                [getattr(onsets, f), unknown.get(f, np.full(len(new), np.nan))]
            )
            for f in fields
        )
    )
    order = np.argsort(grown.time_s, kind="stable")
    row_of = np.argsort(order)
    grown = grown.take(order)
    rejected = {int(row_of[row]): reason for row, reason in chain.rejected.items()}
    added = [int(np.abs(grown.time_s - at).argmin()) for at in moments]
    return (
        grown,
        replace(chain, impacts=row_of[chain.impacts], rejected=rejected),
        added,
    )


def _nearest(times: np.ndarray, at: float) -> int | None:
    """Row of the onset nearest to a moment, None where none is within APART_S."""
    if not len(times):
        return None
    row = int(np.abs(times - at).argmin())
    return row if abs(times[row] - at) <= APART_S else None


def _missed(chain: Chain, impacts: np.ndarray) -> np.ndarray:
    """(m,): whether an impact is still missing between each impact and the one
    before."""
    gaps = [
        (chain.impacts[k - 1], chain.impacts[k]) for k in np.flatnonzero(chain.missed)
    ]
    inside = [
        any(a <= first and last <= b for first, last in gaps)
        for a, b in itertools.pairwise(impacts)
    ]
    return np.array([False, *inside][: len(impacts)], bool)
