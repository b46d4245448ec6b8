"""What was heard as a picture: loudness over time, its frequencies below, the impacts
with their sds, what was left out and why."""

import textwrap
from collections.abc import Collection

import numpy as np

from benchtwin.vision.evidence.sound import Sound
from benchtwin.vision.motion.impact_chain import Chain
from benchtwin.vision.motion.onsets import Onsets
from benchtwin.vision.overlay.plot import as_pixels, new_figure

SIZE = 1200, 960
COLUMNS, WINDOW = 1000, 256  # of the loudness; samples of a spectrum
SILENT = 1e-9  # of full scale
WAVE, LOUDEST = "#7896be", "#d7deeb"
IMPACT, ADDED, REMOVED = "#009628", "#9600aa", "#dc3c28"
RANGE_DB = 80.0
MOST_REASONS = 7
MARGIN_S = 0.3
MOST_HZ = 20_000.0
LETTERS = 72  # of a line
LEAST_APART = 0.025  # of the width, between two labels


def draw_sound(
    sound: Sound, onsets: Onsets, chain: Chain, added: Collection[int], caption: str
) -> np.ndarray:
    """uint8 RGB; added: rows of the impacts that somebody added."""
    begin, end = _shown(sound, onsets, chain)
    reasons = _reasons(onsets, chain, begin, end)
    several = len(set(chain.drop.tolist())) > 1
    figure = new_figure(SIZE)
    loud, pitch = figure.subplots(2, sharex=True, height_ratios=(3, 2))
    first, stop = (
        int(np.clip((t - sound.start_s) * sound.rate_hz, 0, len(sound.samples)))
        for t in (begin, end)
    )
    part = sound.samples[first:stop]
    _loudness(loud, part, begin, end)
    if len(part) >= 2 * WINDOW:
        step = max(WINDOW // 4, len(part) // (2 * COLUMNS))
        pitch.specgram(
            part + SILENT,
            NFFT=WINDOW,
            Fs=sound.rate_hz,
            noverlap=max(0, WINDOW - step),
            xextent=(begin, end),
        )
    pitch.set(xlim=(begin, end), ylim=(0, min(MOST_HZ, sound.rate_hz / 2)), ylabel="Hz")
    pitch.set_xlabel("t [s]")
    for row, reason in chain.rejected.items():
        if begin <= (t := onsets.time_s[row]) <= end:
            loud.axvline(t, color=REMOVED, linestyle=":")
            loud.text(t, -3, f" {reasons.get(_kind(reason), '')}", color=REMOVED)
    labels: dict[float, str] = {}
    begins = np.diff(chain.drop, prepend=-1) > 0
    for row, drop, is_first in zip(chain.impacts, chain.drop, begins):
        t = float(onsets.time_s[row])
        for axes in (loud, pitch):
            axes.axvline(t, color=ADDED if row in added else IMPACT)
        free = t - max(labels, default=-np.inf) > LEAST_APART * (end - begin)
        if free and (is_first or not several):
            number = f"{drop + 1}" if several else f"{1000 * onsets.sd_s[row]:.2g}"
            labels[t] = number
    above = loud.secondary_xaxis("top")
    above.set_xticks(list(labels), list(labels.values()), rotation=90)
    what = "the number of the drop" if several else "the sd of each in ms"
    by_hand = "violet: added by hand; " if added else ""
    said = [
        f"green: impacts, with {what}; {by_hand}red: no impact",
        *(f"{n}: {reason}" for reason, n in reasons.items()),
    ]
    figure.supxlabel(
        "\n".join(textwrap.fill(line, LETTERS) for line in said), x=0.01, ha="left"
    )
    figure.suptitle(caption, x=0.01, horizontalalignment="left", wrap=True)
    return as_pixels(figure)


def _reasons(onsets: Onsets, chain: Chain, begin: float, end: float) -> dict[str, int]:
    """The kinds of reasons for which onsets in the picture are no impacts, numbered;
    MOST_REASONS of them."""
    inside = (
        reason
        for row, reason in chain.rejected.items()
        if begin <= onsets.time_s[row] <= end
    )
    kinds = list(dict.fromkeys(_kind(reason) for reason in inside))
    return {reason: n for n, reason in enumerate(kinds[:MOST_REASONS], 1)}


def _shown(sound: Sound, onsets: Onsets, chain: Chain) -> tuple[float, float]:
    """From a little before the first impact until a little after the last; all, where
    there is none."""
    whole = sound.start_s, sound.start_s + sound.duration_s
    if not len(chain.impacts):
        return whole
    first, last = onsets.time_s[chain.impacts[[0, -1]]]
    margin = max(MARGIN_S, 0.4 * (last - first))
    return max(whole[0], first - margin), min(whole[1], last + margin)


def _loudness(axes, part: np.ndarray, begin: float, end: float) -> None:
    """The greatest and the mean power [dB] of each column of the picture."""
    columns = np.array_split(np.square(part, dtype=float), COLUMNS)
    times = np.linspace(begin, end, COLUMNS)
    most, mean = (
        np.array([of(c) if c.size else 0.0 for c in columns])
        for of in (np.max, np.mean)
    )
    loudest = max(float(most.max()), 1e-12)
    for power, colour in ((most, LOUDEST), (mean, WAVE)):
        db = 10 * np.log10(np.maximum(power / loudest, 1e-12))
        axes.fill_between(times, db, -RANGE_DB, color=colour)
    axes.set(ylim=(-RANGE_DB, 0), ylabel="loudness [dB]")


def _kind(reason: str) -> str:
    """A reason without the delay, which differs from sound to sound."""
    return reason.split(",")[0]
