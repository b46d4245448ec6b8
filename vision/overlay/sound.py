"""What was heard as a picture: loudness over time, its frequencies below, the impacts with their sds, what was left out and why."""

from collections.abc import Collection

import cv2
import numpy as np
from scipy.signal import spectrogram

from vision.evidence.sound import Sound
from vision.motion.impact_chain import Chain
from vision.motion.onsets import Onsets
from vision.overlay.canvas import FONT, plain
from vision.overlay.plot import GRID, INK, ticks

WIDE, LOUDNESS, STRIP = 1500, 330, 200
LEFT, RIGHT, TOP, BETWEEN, BOTTOM = 80, 20, 64, 34, 156
WAVE, IMPACT, ADDED, REMOVED = (120, 150, 190), (0, 150, 40), (150, 0, 170), (220, 60, 40)
RANGE_DB = 80.0
MOST_REASONS = 7
MARGIN_S = 0.3
MOST_HZ = 20_000.0


def draw_sound(sound: Sound, onsets: Onsets, chain: Chain, added: Collection[int], caption: str) -> np.ndarray:
    """uint8 RGB; added: rows of the impacts that somebody added."""
    begin, end = _shown(sound, onsets, chain)
    high = TOP + LOUDNESS + BETWEEN + STRIP + BOTTOM
    image = np.full((high, WIDE, 3), 255, np.uint8)
    first, stop = (int(np.clip((t - sound.start_s) * sound.rate_hz, 0, len(sound.samples))) for t in (begin, end))
    part = sound.samples[first:stop]
    room = WIDE - LEFT - RIGHT

    def column(t: float) -> int:
        return LEFT + round((t - begin) / (end - begin) * room)

    for t in ticks(begin, end):
        cv2.line(image, (column(t), TOP), (column(t), TOP + LOUDNESS), GRID, 1)
        _text(image, f"{t:.4g}", (column(t) - 12, TOP + LOUDNESS + BETWEEN + STRIP + 18))
    _loudness(image, part, room)
    _frequencies(image, part, sound.rate_hz, room)
    reasons: dict[str, int] = {}
    for row, why in chain.rejected.items():
        if begin <= onsets.time_s[row] <= end:
            number = reasons.setdefault(_kind(why), len(reasons) + 1)
            _mark(image, column(onsets.time_s[row]), REMOVED, str(number), dashed=True)
    for k, row in enumerate(chain.impacts):
        colour = ADDED if row in added else IMPACT
        _mark(image, column(onsets.time_s[row]), colour, "", dashed=False)
        _text(image, f"{1000 * onsets.sd_s[row]:.2g}", (column(onsets.time_s[row]) - 10, TOP - 4 - 13 * (k % 2)), colour, 0.4)
    _text(image, caption, (10, 22), INK, 0.55)
    by_hand = "violet: added by hand; " if added else ""
    _text(image, f"loudness [dB]; green: impacts, with the sd of each in ms; {by_hand}red: no impact", (LEFT, TOP + LOUDNESS + 22), INK)
    _text(image, "t [s]", (WIDE // 2, TOP + LOUDNESS + BETWEEN + STRIP + 36), INK)
    for k, (why, number) in enumerate(list(reasons.items())[:MOST_REASONS]):
        _text(image, f"{number}: {why}", (LEFT, TOP + LOUDNESS + BETWEEN + STRIP + 54 + 16 * k), REMOVED)
    return image


def _shown(sound: Sound, onsets: Onsets, chain: Chain) -> tuple[float, float]:
    """From a little before the first impact until a little after the last; all, where there is none."""
    whole = sound.start_s, sound.start_s + sound.duration_s
    if not len(chain.impacts):
        return whole
    first, last = onsets.time_s[chain.impacts[[0, -1]]]
    margin = max(MARGIN_S, 0.4 * (last - first))
    return max(whole[0], first - margin), min(whole[1], last + margin)


def _loudness(image: np.ndarray, part: np.ndarray, room: int) -> None:
    """The greatest and the mean power of each column of the picture."""
    edges = np.linspace(0, len(part), room + 1).astype(int)
    square = np.square(part, dtype=float)
    sums = np.concatenate([[0.0], np.cumsum(square)])
    mean = (sums[edges[1:]] - sums[edges[:-1]]) / np.maximum(np.diff(edges), 1)
    most = np.maximum.reduceat(np.append(square, 0.0), np.minimum(edges[:-1], len(square)))
    top = max(float(most.max()), 1e-12)
    rows = [TOP + np.clip(-10 * np.log10(np.maximum(x / top, 1e-12)) / RANGE_DB, 0, 1) * LOUDNESS for x in (most, mean)]
    for k in range(room):
        cv2.line(image, (LEFT + k, round(rows[0][k])), (LEFT + k, TOP + LOUDNESS), (215, 222, 235), 1)
        cv2.line(image, (LEFT + k, round(rows[1][k])), (LEFT + k, TOP + LOUDNESS), WAVE, 1)
    for db in range(0, int(RANGE_DB), 20):
        _text(image, f"-{db}" if db else "0", (LEFT - 40, TOP + round(db / RANGE_DB * LOUDNESS) + 5), INK)
    cv2.rectangle(image, (LEFT, TOP), (LEFT + room, TOP + LOUDNESS), INK, 1)


def _frequencies(image: np.ndarray, part: np.ndarray, rate: float, room: int) -> None:
    size = 256
    if len(part) < 2 * size:
        return
    step = max(size // 4, len(part) // (2 * room))
    hertz, _, power = spectrogram(part, rate, nperseg=size, noverlap=max(0, size - step), mode="psd")
    power = power[hertz <= MOST_HZ]
    db = 10 * np.log10(np.maximum(power, 1e-20))
    low, high = np.percentile(db, [30, 99.9])
    grey = np.clip((db - low) / max(high - low, 1.0), 0, 1)[::-1]
    picture = cv2.applyColorMap((255 * cv2.resize(grey.astype(np.float32), (room, STRIP))).astype(np.uint8), cv2.COLORMAP_VIRIDIS)
    y = TOP + LOUDNESS + BETWEEN
    image[y : y + STRIP, LEFT : LEFT + room] = picture[..., ::-1]
    top = min(MOST_HZ, rate / 2)
    for khz in range(0, int(top / 1000) + 1, 5):
        _text(image, f"{khz} kHz", (LEFT - 62, y + STRIP - round(khz * 1000 / top * STRIP) + 5), INK)


def _mark(image: np.ndarray, x: int, colour: tuple[int, int, int], text: str, *, dashed: bool) -> None:
    for top, bottom in ((TOP, TOP + LOUDNESS), (TOP + LOUDNESS + BETWEEN, TOP + LOUDNESS + BETWEEN + 14)):
        for y in range(top, bottom, 10):
            cv2.line(image, (x, y), (x, min(y + (4 if dashed else 10), bottom)), colour, 1, cv2.LINE_AA)
    if text:
        _text(image, text, (x + 3, TOP + 14), colour, 0.4)


def _kind(why: str) -> str:
    """A reason without the delay, which differs from sound to sound."""
    return why.split(",")[0]


def _text(image: np.ndarray, text: str, at: tuple[int, int], colour: tuple[int, int, int] = INK, size: float = 0.45) -> None:
    cv2.putText(image, plain(text), at, FONT, size, colour, 1, cv2.LINE_AA)
