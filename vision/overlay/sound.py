"""What was heard as a picture: loudness over time, its frequencies below, the impacts
with their sds, what was left out and why."""

import textwrap

import numpy as np

from benchtwin.vision.evidence.sound import Sound
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


def draw_sound(sound: Sound, onsets: Onsets, caption: str) -> np.ndarray:
    """uint8 RGB."""
    impacts, rejected = onsets[onsets.drop >= 0], onsets[onsets.why != ""]
    begin, end = _shown(sound, impacts)
    rejected = rejected[(rejected.time_s >= begin) & (rejected.time_s <= end)]
    kinds = list(dict.fromkeys(map(_kind, rejected.why)))[:MOST_REASONS]
    reasons = {reason: n for n, reason in enumerate(kinds, 1)}
    several = len(set(impacts.drop.tolist())) > 1
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
    for one in rejected:
        loud.axvline(one.time_s, color=REMOVED, linestyle=":")
        loud.text(one.time_s, -3, f" {reasons.get(_kind(one.why), '')}", color=REMOVED)
    labels: dict[float, str] = {}
    begins = np.diff(impacts.drop, prepend=-1) > 0
    for impact, is_first in zip(impacts, begins, strict=True):
        t = float(impact.time_s)
        for axes in (loud, pitch):
            axes.axvline(t, color=ADDED if impact.added else IMPACT)
        free = t - max(labels, default=-np.inf) > LEAST_APART * (end - begin)
        if free and (is_first or not several):
            sd = f"{1000 * impact.sd_s:.2g}"
            labels[t] = f"{impact.drop + 1}" if several else sd
    above = loud.secondary_xaxis("top")
    above.set_xticks(list(labels), list(labels.values()), rotation=90)
    what = "the number of the drop" if several else "the sd of each in ms"
    by_hand = "violet: added by hand; " if impacts.added.any() else ""
    said = [
        f"green: impacts, with {what}; {by_hand}red: no impact",
        *(f"{n}: {reason}" for reason, n in reasons.items()),
    ]
    figure.supxlabel(
        "\n".join(textwrap.fill(line, LETTERS) for line in said), x=0.01, ha="left"
    )
    figure.suptitle(caption, x=0.01, horizontalalignment="left", wrap=True)
    return as_pixels(figure)


def _shown(sound: Sound, impacts: Onsets) -> tuple[float, float]:
    """From a little before the first impact until a little after the last; all, where
    there is none."""
    whole = sound.start_s, sound.start_s + sound.duration_s
    if not len(impacts):
        return whole
    first, last = impacts.time_s[[0, -1]]
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
