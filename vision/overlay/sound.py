"""What was heard as a picture: loudness over time, its frequencies below, the impacts
with their sds, what was left out and why."""

from collections.abc import Collection

import cv2
import numpy as np
from scipy.signal import spectrogram

from benchtwin.vision.evidence.sound import Sound
from benchtwin.vision.motion.impact_chain import Chain
from benchtwin.vision.motion.onsets import Onsets
from benchtwin.vision.overlay.canvas import (
    LINE_PX,
    SHOWN_PX,
    Colour,
    text_width,
    wrapped,
    write,
)
from benchtwin.vision.overlay.plot import GRID, INK, ticks

WIDE, LOUDNESS, STRIP = 1200, 360, 220
SHOWN = WIDE / SHOWN_PX
LINE, GAP = round(LINE_PX * SHOWN), round(6 * SHOWN)
LEFT, RIGHT = 9 * GAP, 2 * GAP
WAVE = (120, 150, 190)
IMPACT = (0, 150, 40)
ADDED = (150, 0, 170)
REMOVED = (220, 60, 40)
RANGE_DB = 80.0
MOST_REASONS = 7
MARGIN_S = 0.3
MOST_HZ = 20_000.0


def draw_sound(
    sound: Sound, onsets: Onsets, chain: Chain, added: Collection[int], caption: str
) -> np.ndarray:
    """uint8 RGB; added: rows of the impacts that somebody added."""
    begin, end = _shown(sound, onsets, chain)
    reasons = _reasons(onsets, chain, begin, end)
    caption_lines = wrapped(caption, WIDE - 2 * GAP, SHOWN)
    by_hand = "violet: added by hand; " if added else ""
    several = len(set(chain.drop.tolist())) > 1
    what = "the number of the drop" if several else "the sd of each in ms"
    key = wrapped(
        f"green: impacts, with {what}; {by_hand}red: no impact",
        WIDE - LEFT,
        SHOWN,
    )
    below = [
        line
        for n, reason in enumerate(reasons, 1)
        for line in wrapped(f"{n}: {reason}", WIDE - LEFT, SHOWN)
    ]
    top = (len(caption_lines) + 3) * LINE + GAP  # caption, axis, two lines of sds
    strip = top + LOUDNESS + 2 * GAP
    foot = strip + STRIP
    image = np.full(
        (foot + (2 + len(key) + len(below)) * LINE + GAP, WIDE, 3), 255, np.uint8
    )
    first, stop = (
        int(np.clip((t - sound.start_s) * sound.rate_hz, 0, len(sound.samples)))
        for t in (begin, end)
    )
    part = sound.samples[first:stop]
    room = WIDE - LEFT - RIGHT

    def column(t: float) -> int:
        return LEFT + round((t - begin) / (end - begin) * room)

    for t in ticks(begin, end):
        cv2.line(image, (column(t), top), (column(t), top + LOUDNESS), GRID, 2)
        _text(image, f"{t:.4g}", column(t), foot + LINE, anchor=0.5)
    _loudness(image, part, room, top)
    _frequencies(image, part, sound.rate_hz, room, strip)
    for row, reason in chain.rejected.items():
        if begin <= onsets.time_s[row] <= end:
            at = column(onsets.time_s[row])
            why = str(reasons.get(_kind(reason), ""))
            _mark(image, at, top, strip, REMOVED, why, dashed=True)
    for row in chain.impacts:
        colour = ADDED if row in added else IMPACT
        _mark(image, column(onsets.time_s[row]), top, strip, colour, "", dashed=False)
    begins = np.diff(chain.drop, prepend=-1) > 0
    impacts = [
        (
            column(onsets.time_s[row]),
            f"{drop + 1}" if several else f"{1000 * onsets.sd_s[row]:.2g}",
            ADDED if row in added else IMPACT,
        )
        for row, drop, first in zip(chain.impacts, chain.drop, begins)
        if first or not several
    ]
    _labels(image, impacts, top)
    for k, line in enumerate(caption_lines):
        _text(image, line, GAP, (k + 0.8) * LINE)
    _text(image, "loudness [dB]", GAP, (len(caption_lines) + 0.8) * LINE)
    _text(image, "t [s]", LEFT + room / 2, foot + 1.9 * LINE, anchor=0.5)
    for k, line in enumerate((*key, *below)):
        _text(
            image, line, LEFT, foot + (k + 2.8) * LINE, INK if k < len(key) else REMOVED
        )
    return image


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


def _loudness(image: np.ndarray, part: np.ndarray, room: int, top: int) -> None:
    """The greatest and the mean power of each column of the picture."""
    edges = np.linspace(0, len(part), room + 1).astype(int)
    square = np.square(part, dtype=float)
    sums = np.concatenate([[0.0], np.cumsum(square)])
    mean = (sums[edges[1:]] - sums[edges[:-1]]) / np.maximum(np.diff(edges), 1)
    most = np.maximum.reduceat(
        np.append(square, 0.0), np.minimum(edges[:-1], len(square))
    )
    loudest = max(float(most.max()), 1e-12)
    rows = [
        top
        + np.clip(-10 * np.log10(np.maximum(x / loudest, 1e-12)) / RANGE_DB, 0, 1)
        * LOUDNESS
        for x in (most, mean)
    ]
    for k in range(room):
        cv2.line(
            image,
            (LEFT + k, round(rows[0][k])),
            (LEFT + k, top + LOUDNESS),
            (215, 222, 235),
            1,
        )
        cv2.line(
            image, (LEFT + k, round(rows[1][k])), (LEFT + k, top + LOUDNESS), WAVE, 1
        )
    for db in range(0, int(RANGE_DB), 20):
        at = top + db / RANGE_DB * LOUDNESS + 0.3 * LINE
        _text(image, f"-{db}" if db else "0", LEFT - GAP, at, anchor=1.0)
    cv2.rectangle(image, (LEFT, top), (LEFT + room, top + LOUDNESS), INK, 1)


def _frequencies(
    image: np.ndarray, part: np.ndarray, rate: float, room: int, y: int
) -> None:
    size = 256
    if len(part) < 2 * size:
        return
    step = max(size // 4, len(part) // (2 * room))
    hertz, _, power = spectrogram(
        part, rate, nperseg=size, noverlap=max(0, size - step), mode="psd"
    )
    power = power[hertz <= MOST_HZ]
    db = 10 * np.log10(np.maximum(power, 1e-20))
    low, high = np.percentile(db, [30, 99.9])
    grey = np.clip((db - low) / max(high - low, 1.0), 0, 1)[::-1]
    picture = cv2.applyColorMap(
        (255 * cv2.resize(grey.astype(np.float32), (room, STRIP))).astype(np.uint8),
        cv2.COLORMAP_VIRIDIS,
    )
    image[y : y + STRIP, LEFT : LEFT + room] = picture[..., ::-1]
    highest = min(MOST_HZ, rate / 2)
    for khz in range(0, int(highest / 1000) + 1, 10):
        unit = " kHz" if khz + 10 > highest / 1000 else ""
        at = y + STRIP - khz * 1000 / highest * STRIP + 0.3 * LINE
        _text(image, f"{khz}{unit}", LEFT - GAP, at, anchor=1.0)


def _mark(
    image: np.ndarray,
    x: int,
    top: int,
    strip: int,
    colour: Colour,
    text: str,
    *,
    dashed: bool,
) -> None:
    """A line through the loudness, and a short one where the frequencies begin; text
    beside it."""
    for high, low in ((top, top + LOUDNESS), (strip, strip + 3 * GAP)):
        for y in range(high, low, 12):
            end = min(y + (5 if dashed else 12), low)
            cv2.line(image, (x, y), (x, end), colour, round(0.8 * SHOWN), cv2.LINE_AA)
    _text(image, text, x + GAP / 2, top + LINE, colour)


def _labels(
    image: np.ndarray, impacts: list[tuple[int, str, Colour]], top: int
) -> None:
    """Above each impact (column, text, colour) its text, in two lines in turn; left out
    where there is no room."""
    free = [0.0, 0.0]  # where each line ends so far
    for k, (x, text, colour) in enumerate(impacts):
        half = text_width(text, SHOWN) / 2
        if free[k % 2] < x - half:
            _text(image, text, x, top - GAP - LINE * (k % 2), colour, anchor=0.5)
            free[k % 2] = x + half + GAP


def _kind(reason: str) -> str:
    """A reason without the delay, which differs from sound to sound."""
    return reason.split(",")[0]


def _text(
    image, text: str, x: float, y: float, colour: Colour = INK, anchor: float = 0.0
) -> None:
    write(image, text, x, y, colour, SHOWN, anchor=anchor)
