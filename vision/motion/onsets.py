"""Onsets of sudden sounds in a recording: time with sd, strength, loudness, timbre.

The noise is whitened by an autoregressive filter, which is causal, so that no onset is
found too early. An exponentially decaying window, as a ring decays, is applied every
half millisecond: power in some frequencies above the noise and above what was there
just before is an onset. Its strength is measured by the peaks of the noise itself, as a
rate of false alarms.

The time of an onset is where the signal's variance changes most probably (Akaike's
criterion for two variances: Maeda 1985) or, in strong noise, where the window contains
most of the ring. Both give a likelihood over time, whose width is the sd."""

import itertools

import numpy as np
from scipy.fft import next_fast_len, rfft
from scipy.linalg import solve_toeplitz
from scipy.ndimage import maximum_filter1d, uniform_filter1d
from scipy.signal import oaconvolve, welch

from benchtwin.vision.evidence.sound import Sound

# of the window's amplitude; rings of 1 to 20 ms lose less than a third of their
# signal-to-noise ratio by it
DECAY_S = 4e-3
DECAYS = 3.0  # length of the window
HOP_S = 5e-4
BEFORE_S = 0.012  # over which the preceding power is averaged
STANDS_OUT = 6.0  # times the noise's power in one frequency: e^-6 of the noise does
MOST_OVER = 25.0  # times the noise's power that one frequency may contribute
FRESH_S = 7e-3  # an onset is louder than the sound this long before it
APART_S = 4e-3  # least distance of two onsets
# rate of noise peaks as strong as the weakest onset that is listed
NOISE_PEAKS_PER_S = 2.0
MOST_ONSETS, MOST_IN_ALL = 160, 1000  # in BLOCK_S; in a recording
BLOCK_S = 20.0
# at a recording's beginning and end: encoders begin and stop with a click
EDGE_S = 0.06
ORDER_S = 8e-4  # order of the autoregressive filter
BANDS_HZ = np.geomspace(200, 20_000, 25)
SEARCH_S = (
    6e-3,
    3e-3,
)  # before and after a frame that stands out, where its onset is sought
POINTED_S = 6e-3  # before and after a moment that somebody points at
# error of the time at which the window contains most of a ring of several tones
WINDOW_SD_S = 3e-4
# of the sound after the onset; a room's reverberation may be louder later
AHEAD_S = 3e-3
PRE_ECHO = 0.25  # of the amplitude that follows: an encoder's pre-echo is fainter
LOSSY_SD_S = 1e-4  # least sd of an onset in lossy sound
TIME_SD_S = 3e-5  # least sd of an onset: the contact itself lasts as long
# of the median power: less in some frequencies is a gap left by a codec
LEAST_NOISE = 0.1
CODEC_HZ = (500.0, 8000.0)  # where codecs leave no gaps
LEAST_DENSITY = 1e-7  # of the noise's power per hertz, relative to its maximum


# n onsets in the order of time, a record each. strength: −ln of the rate [1/s] of noise
# peaks as strong; level_db: power over the noise; rise_s: from the onset to half the
# greatest amplitude of the next 20 ms; lasting_db: the faintest 10 ms of the next 50
# ms, against the first 10 ms; timbre: unit vector of the amplitudes in BANDS_HZ. drop:
# of which it is an impact, from 0, −1 where of none; missed: whether an impact before
# it, of the same drop, was not heard; added: whether somebody added it as an impact;
# why: it is no impact, where it stands out
Onsets = np.recarray
HEARD = ("strength", "time_s", "sd_s", "level_db", "rise_s", "lasting_db", "timbre")
TIMBRE = (len(BANDS_HZ) - 1,)
ONSET = np.dtype(
    [
        *((name, float, TIMBRE if name == "timbre" else ()) for name in HEARD),
        *(("drop", int), ("missed", bool), ("added", bool), ("why", object)),
    ]
)
NO_IMPACT = (-1, False, False, "")


def find_onsets(sound: Sound) -> Onsets:
    """All onsets, down to faint ones; times on the clock of the pictures."""
    rate, white = sound.rate_hz, whitened(sound.samples, sound.rate_hz)
    ends = round(EDGE_S * rate)
    white[:ends], white[len(white) - ends :] = 0, 0
    edges = np.linspace(
        0, len(white), int(np.ceil(sound.duration_s / BLOCK_S)) + 1
    ).astype(int)
    margin = round((BEFORE_S + 2 * DECAYS * DECAY_S) * rate)
    parts = []
    for first, stop in itertools.pairwise(edges):
        begin = max(0, first - margin)
        found = _in_block(white[begin : stop + margin], rate, sound.lossy)
        found.time_s += begin / rate
        inside = (found.time_s >= first / rate) & (found.time_s < stop / rate)
        parts.append(found[inside])
    whole = np.concatenate(parts).view(Onsets)
    whole.time_s += sound.start_s
    strongest = np.argsort(-whole.strength, kind="stable")[:MOST_IN_ALL]
    return whole[np.sort(strongest)]


def onset_near(sound: Sound, time_s: float) -> tuple[float, float]:
    """Time and sd [s] of the onset near `time_s`, both on the clock of the pictures."""
    rate = sound.rate_hz
    at = round((time_s - sound.start_s) * rate)
    begin = max(0, at - round(rate))
    white = whitened(sound.samples[begin : at + round(rate)], rate)
    reach = round(POINTED_S * rate)
    near = (at - begin) / rate
    time, sd = _variance_change(
        white, rate, at - begin - reach, at - begin + reach, near, POINTED_S / 2
    )
    return begin / rate + time + sound.start_s, float(
        np.hypot(sd, LOSSY_SD_S if sound.lossy else TIME_SD_S)
    )


def whitened(samples: np.ndarray, rate_hz: float) -> np.ndarray:
    """(n,) float32: the samples less their prediction from the noise's past; of
    variance 1 where there is only noise."""
    size = min(len(samples), next_fast_len(round(0.04 * rate_hz)))
    hertz, density = welch(
        samples, rate_hz, nperseg=size, average="median", detrend="constant"
    )
    density = density.astype(float)
    typical = float(np.median(density[(hertz >= CODEC_HZ[0]) & (hertz <= CODEC_HZ[1])]))
    power = float(np.mean(np.square(samples, dtype=float)))
    floor = max(
        LEAST_DENSITY * density.max(),
        LEAST_NOISE * typical,
        2.0**-32 / 3 / rate_hz,
        1e-14 * power / rate_hz,
    )
    memory = np.fft.irfft(density + floor)
    order = min(max(8, round(ORDER_S * rate_hz)), len(memory) // 2 - 1)
    past = solve_toeplitz(memory[:order], memory[1 : order + 1])
    left = float(memory[0] - past @ memory[1 : order + 1])
    filtered = oaconvolve(samples, np.concatenate([[1.0], -past]).astype(np.float32))[
        : len(samples)
    ]
    return filtered / np.float32(np.sqrt(max(left, 1e-12 * memory[0]) * rate_hz / 2))


def _in_block(white: np.ndarray, rate: float, lossy: bool) -> Onsets:
    window, hop = _window(rate), max(1, round(HOP_S * rate))
    power = _spectra(white, np.arange(0, max(1, len(white) - len(window)), hop), window)
    hops = rate / hop
    # from the median or, where a codec leaves gaps, from the 85th percentile
    some = power[:: max(1, len(power) // 4000)]
    middle, high = np.quantile(some, [0.5, 0.85], axis=0)
    level = np.maximum(middle / np.log(2), high / -np.log(0.15) / 2)
    level = np.maximum(level, LEAST_NOISE * np.median(level) + 1e-9).astype(np.float32)
    # the mean power before each window, at least that of the noise
    nothing = np.zeros((1, power.shape[1]), np.float32)
    total = np.cumsum(np.concatenate([nothing, power]), axis=0, dtype=np.float64)
    stop = np.maximum(np.arange(len(power)) - round(DECAYS * DECAY_S * hops) + 1, 0)
    start = np.maximum(stop - round(BEFORE_S * hops), 0)
    mean_before = (total[stop] - total[start]) / np.maximum(stop - start, 1)[:, None]
    before = np.maximum(mean_before, level).astype(np.float32)
    over = power / before
    loud = np.log(np.maximum(over, STANDS_OUT) / STANDS_OUT).sum(axis=1)
    lag = round(FRESH_S * hops)
    earlier = np.maximum(before[lag:], power[: len(power) - lag])
    # a ring that goes on is not a new one
    fresh = np.concatenate([over[:lag], power[lag:] / earlier])
    score = np.clip(fresh - STANDS_OUT, 0, MOST_OVER).sum(axis=1)
    at, strength = _peaks(loud, score, hops)
    noise = float(level.sum())
    rows = [
        (
            strong,
            *_describe_onset(
                white, rate, lossy, window, k * hop, power[k], before[k], noise
            ),
            *NO_IMPACT,
        )
        for k, strong in zip(at, strength, strict=True)
    ]
    found = np.array(rows, ONSET).view(Onsets)
    return found[np.argsort(found.time_s, kind="stable")]


def _window(rate: float) -> np.ndarray:
    t = np.arange(next_fast_len(round(DECAYS * DECAY_S * rate))) / rate
    return np.exp(-t / DECAY_S).astype(np.float32)


def _spectra(white: np.ndarray, at: np.ndarray, window: np.ndarray) -> np.ndarray:
    """(frames, frequencies) float32: power in the window that begins at each of
    `at`."""
    views = np.lib.stride_tricks.sliding_window_view(
        np.pad(white, (0, len(window))), len(window)
    )
    out = np.empty((len(at), len(window) // 2 + 1), np.float32)
    for k in range(0, len(at), 2000):
        found = rfft(views[at[k : k + 2000]] * window, axis=1)
        out[k : k + 2000] = found.real**2 + found.imag**2
    return out


def _peaks(
    loud: np.ndarray, score: np.ndarray, hops: float
) -> tuple[np.ndarray, np.ndarray]:
    """Frames of the local maxima of `loud`, and their strengths, measured by the peaks
    of the noise."""
    wide = max(1, round(APART_S * hops))
    top = np.flatnonzero((loud == maximum_filter1d(loud, 2 * wide + 1)) & (loud > 0))
    top = top[np.diff(top, prepend=-wide - 1) > wide]
    if not len(top):
        return top, np.zeros(0)
    found = score[top]
    # intervals without a peak
    silent = max(0, round(len(loud) / (2 * wide)) - len(top))
    low, high = np.quantile(np.concatenate([np.zeros(silent), found]), [0.4, 0.8])
    scale = max((high - low) / np.log(0.6 / 0.2), 1.0)
    per_s = len(loud) / (2 * wide) / (len(loud) / hops)
    strength = (found - low) / scale - np.log(0.6 * per_s)
    strong = np.flatnonzero(strength > -np.log(NOISE_PEAKS_PER_S))
    strong = np.sort(strong[np.argsort(-strength[strong], kind="stable")[:MOST_ONSETS]])
    return top[strong], strength[strong]


def _describe_onset(
    white,
    rate: float,
    lossy: bool,
    window,
    near: int,
    power: np.ndarray,
    before: np.ndarray,
    noise: float,
) -> tuple:
    """Time, sd [s], level [dB], rise [s], lasting [dB], timbre of one onset."""
    over = power / before
    loud = over > min(STANDS_OUT, float(over.max())) - 1e-9
    caught, caught_sd = _window_maximum(white, rate, window, near, loud, before)
    first, stop = near - round(SEARCH_S[0] * rate), near + round(SEARCH_S[1] * rate)
    time, sd = _variance_change(
        white, rate, first, stop, caught, float(np.hypot(caught_sd, WINDOW_SD_S))
    )
    if lossy:  # an encoder spreads a click to earlier times
        time = max(time, _past_pre_echo(white, rate, round(time * rate)))
    sd = float(np.hypot(sd, LOSSY_SD_S if lossy else TIME_SD_S))
    begin = round(time * rate)
    frequency = np.fft.rfftfreq(len(window), 1 / rate)
    extra = np.where(loud, power - before, 0.0)
    band = np.digitize(frequency, BANDS_HZ) - 1
    inside = (band >= 0) & (band < len(BANDS_HZ) - 1)
    shares = np.sqrt(
        np.bincount(band[inside], np.maximum(extra[inside], 0), len(BANDS_HZ) - 1)
    )
    rise, lasting = _rise_and_decay(white, rate, begin)
    level = 10 * np.log10(max(extra.sum() / noise, 1e-9))
    length = max(np.linalg.norm(shares), 1e-30)
    return (time, sd, level, rise, lasting, shares / length)


def _rise_and_decay(white: np.ndarray, rate: float, begin: int) -> tuple[float, float]:
    """Rise [s] and lasting [dB] of the sound that begins at a sample."""
    here = np.square(white[begin : begin + round(0.06 * rate)], dtype=float)
    if len(here) < 0.03 * rate:
        return 0.0, -np.inf
    ten = round(0.01 * rate)
    smooth = uniform_filter1d(here[: 2 * ten], max(1, round(1e-3 * rate)))
    first = max(here[:ten].mean() - 1, 1e-6)
    # of every hundredth of a second after the first
    later = np.diff(np.cumsum(here)[ten::ten]) / ten - 1
    lasting = 10 * np.log10(max(float(later.min()), 1e-3 * first) / first)
    return float(np.argmax(smooth > 0.25 * smooth.max()) / rate), float(lasting)


def _past_pre_echo(white, rate: float, begin: int) -> float:
    """Time [s] at which the sound that begins at a sample exceeds PRE_ECHO of its
    greatest amplitude; 0 where it does at once."""
    wide = max(3, round(1e-4 * rate))
    ahead = white[max(0, begin - wide) : begin + round(AHEAD_S * rate)]
    if len(ahead) <= 2 * wide:
        return 0.0
    # of the samples from each one on
    loud = np.convolve(np.square(ahead, dtype=float), np.ones(wide), "valid")
    at = begin - wide + int(np.argmax(loud >= PRE_ECHO**2 * loud.max()))
    return (at + wide) / rate if at > begin + wide else 0.0


def _variance_change(
    white, rate: float, first: int, stop: int, near: float, near_sd: float
) -> tuple[float, float]:
    """Time and sd [s] of the likeliest rise of the variance between two samples, with a
    prior at `near`."""
    first, stop = max(0, first), min(len(white), stop)
    square = np.square(white[first:stop], dtype=float)
    n = len(square)
    if n < 16:
        return near, 1e-2
    k = np.arange(4, n - 4)
    sums = np.cumsum(square)
    one = np.maximum(sums[k - 1] / k, 1e-12)
    two = np.maximum((sums[-1] - sums[k - 1]) / (n - k), 1e-12)
    at = (first + k) / rate
    # with wide tails: beating tones are loudest some time after they begin
    far = 1.5 * np.log1p(((at - near) / near_sd) ** 2)
    jump = -0.5 * (k * np.log(one) + (n - k) * np.log(two))
    none = -0.5 * n * np.log(max(sums[-1] / n, 1e-12))  # a falling variance is no onset
    return _posterior_mean(at, np.where(two > one, jump, none) - far)


def _window_maximum(
    white, rate: float, window, near: int, seen, before
) -> tuple[float, float]:
    """Time and sd [s] at which the window contains most of the ring."""
    step = max(1, round(4e-5 * rate))
    at = np.arange(max(0, near - round(3e-3 * rate)), near + round(3e-3 * rate), step)
    at = at[at < len(white)]
    power = _spectra(white[at[0] : at[-1] + 2 * len(window)], at - at[0], window)[
        :, seen
    ]
    # how many of them are one independent number
    bins_apart = rate / len(window) * 2 * DECAY_S
    return _posterior_mean(
        at / rate, (power / before[seen]).sum(axis=1) * min(1.0, bins_apart)
    )


def _posterior_mean(
    time: np.ndarray, log_likelihood: np.ndarray
) -> tuple[float, float]:
    """Mean and sd of a time from its ln likelihood on a grid."""
    weight = np.exp(log_likelihood - log_likelihood.max())
    weight /= weight.sum()
    mean = float(weight @ time)
    return mean, float(np.sqrt(weight @ (time - mean) ** 2))
