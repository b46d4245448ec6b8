"""Impacts heard in drawn sound whose truth is known: how many are found, how many invented, how exact times and e are.

The sound is drawn here, from decaying tones, noise and filters alone: nothing of the reader is used. A loudness in dB is the rms of
a ring over its first 5 ms above the rms of the noise in the whole band (of hum: of its hiss); a row's loudness is that of the first
impact, and every later one is fainter by its speed to the power 1.2, and scatters by 2 dB. Times of compressed sound are compared
after their common shift is taken off, which encoders may put in.
"""

import argparse
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from scipy.signal import butter, lfilter, sosfilt

G = 9.80665
CLEAR_DB = 0.0  # an impact as loud as that is counted by itself as well
MATCH_S = 3e-3  # a time found this near to a true one is that one


@dataclass(frozen=True)
class Scene:
    """What one row of the table is made of. db: loudness of the first impact, a range; e: a range; codec: "" or "aac 64000"."""

    name: str
    db: tuple[float, float] = (10.0, 40.0)
    noise: str = "white"
    e: tuple[float, float] = (0.4, 0.85)
    e_scatter: float = 0.02
    speech: float = 0.0
    thumps: bool = False
    echoes: int = 0
    codec: str = ""
    clip: bool = False
    decay_ms: tuple[float, float] = (1.0, 20.0)
    stated: bool = True


SCENES = (
    Scene("white"), Scene("white, 10 dB", (10, 10)), Scene("white, 0 dB", (0, 0)), Scene("white, -10 dB", (-10, -10)),
    Scene("pink", noise="pink"), Scene("hum", noise="hum"), Scene("pink, 10 dB", (10, 10), "pink"),
    Scene("lively (e .8-.95)", e=(0.8, 0.95)),
    Scene("dead (e .2-.4)", (25, 40), e=(0.2, 0.4)), Scene("scatter of e .06", e_scatter=0.06),
    Scene("echoes 5-60 ms", noise="pink", echoes=2), Scene("handling", noise="pink", thumps=True),
    Scene("speech, faint", noise="pink", speech=0.05), Scene("speech, loud", (25, 40), "pink", speech=0.4),
    Scene("clipped", (25, 40), clip=True), Scene("aac 64 kbit/s", noise="pink", codec="aac 64000"),
    Scene("mp3 96 kbit/s", noise="pink", codec="libmp3lame 96000"), Scene("all of it, aac", (20, 40), "pink", speech=0.1, thumps=True,
                                                                          echoes=2, codec="aac 96000", clip=True),
    Scene("all of it, height unknown", (20, 40), "pink", speech=0.1, thumps=True, echoes=2, stated=False),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Drawn:
    """samples (n,), rate, the true times [s], restitutions (first one from the fall), dB of each impact, the height fallen."""

    samples: np.ndarray
    rate: int
    times: np.ndarray
    e: np.ndarray
    db: np.ndarray
    height_mm: float


def draw(scene: Scene, rng: np.random.Generator) -> Drawn:
    """One drop, heard."""
    rate = int(rng.choice([44_100, 48_000]))
    height = float(rng.uniform(100, 600))
    mean = rng.uniform(*scene.e)
    fall = np.sqrt(2 * G * height / 1000)
    speeds, each = [fall], []
    while len(speeds) < 12 and 2 * speeds[-1] * mean / G > 0.03:
        each.append(float(np.clip(mean + scene.e_scatter * rng.standard_normal(), 0.05, 0.98)))
        speeds.append(speeds[-1] * each[-1])
    times = rng.uniform(0.7, 1.5) + np.concatenate([[0.0], np.cumsum(2 * np.array(speeds[1:]) / G)])
    e = np.array(each)
    count = int((times[-1] + rng.uniform(0.5, 1.0)) * rate)
    db = rng.uniform(*scene.db) + 24 * np.log10(np.array(speeds[: len(times)]) / fall) + 2.0 * rng.standard_normal(len(times))
    db[0] = max(db[0], scene.db[0])
    out = np.sum([_placed(ring, t, rate, count) for ring, t in zip(_rings(scene, rate, db, rng), times)], axis=0)
    for _ in range(scene.echoes):
        out = out + _echo(out, rate, rng)
    loud = np.abs(out).max()
    if scene.speech:
        out = out + scene.speech * loud * _speech(count, rate, rng)
    if scene.thumps:
        out = out + _thumps(count, rate, times, rng) * loud * rng.uniform(0.1, 1.0)
    out = out + _noise(scene.noise, count, rate, rng)
    scale = (rng.uniform(1.5, 4.0) if scene.clip else rng.uniform(0.2, 0.9)) / np.abs(out).max()
    return Drawn(np.clip(out * scale, -1, 1).astype(np.float32), rate, times, e, db, height)


def _rings(scene: Scene, rate: int, db: np.ndarray, rng: np.random.Generator) -> list[np.ndarray]:
    """The sound of each impact: the same tones, struck otherwise each time."""
    tones = rng.uniform(2000, 8000, int(rng.integers(2, 6)))
    decay = np.exp(rng.uniform(np.log(scene.decay_ms[0]), np.log(scene.decay_ms[1]), len(tones))) / 1000
    t = np.arange(int(0.1 * rate)) / rate
    usual = rng.uniform(0.3, 1.0, len(tones))
    touch = np.hanning(max(3, int(rng.uniform(3e-5, 1e-4) * rate) | 1) + 2)  # the contact's own length
    out = []
    for loudness in db:
        size = usual * np.exp(0.3 * rng.standard_normal(len(tones)))
        phase = rng.uniform(0, 2 * np.pi, len(tones))
        ring = sum(a * np.exp(-t / d) * np.sin(2 * np.pi * f * t + p) for a, d, f, p in zip(size, decay, tones, phase))
        ring = np.convolve(ring, touch / touch.sum())[: len(t)]
        out.append(ring * 10 ** (loudness / 20) / np.sqrt(np.mean(ring[: int(0.005 * rate)] ** 2)))
    return out


def _placed(ring: np.ndarray, at: float, rate: int, count: int) -> np.ndarray:
    """A ring that begins at a time between two samples."""
    first = int(np.floor(at * rate))
    part = at * rate - first
    moved = (1 - part) * np.append(ring, 0) + part * np.append(0, ring)
    out = np.zeros(count)
    stop = min(count, first + len(moved))
    out[first:stop] = moved[: stop - first]
    return out


def _echo(sound: np.ndarray, rate: int, rng: np.random.Generator) -> np.ndarray:
    lag = int(rng.uniform(0.005, 0.06) * rate)
    dull = lfilter(*butter(1, rng.uniform(3000, 8000), fs=rate), sound)
    return rng.uniform(0.15, 0.5) * np.concatenate([np.zeros(lag), dull[:-lag]])


def _noise(kind: str, count: int, rate: int, rng: np.random.Generator) -> np.ndarray:
    white = rng.standard_normal(count)
    if kind == "hum":
        t = np.arange(count) / rate
        return 0.3 * white + sum(3.0 / k * np.sin(2 * np.pi * 50 * k * t + rng.uniform(0, 7)) for k in (1, 2, 3, 5, 7))
    if kind == "pink":
        spectrum = np.fft.rfft(white)
        spectrum /= np.sqrt(np.maximum(np.fft.rfftfreq(count, 1 / rate), 20.0))
        pink = np.fft.irfft(spectrum, count)
        return pink / pink.std()
    return white


def _speech(count: int, rate: int, rng: np.random.Generator) -> np.ndarray:
    """Syllables: a burst of a plosive, pulses of a voice through three formants, hissing; peak 1."""
    out, at = np.zeros(count), int(rng.uniform(0, 0.4) * rate)
    while at < count - rate // 2:
        long = int(rng.uniform(0.08, 0.3) * rate)
        t = np.arange(long) / rate
        rise, fall = rng.uniform(0.015, 0.05), rng.uniform(0.03, 0.08)
        shape = np.minimum(1, t / rise) * np.minimum(1, (long / rate - t) / fall)
        kind = rng.choice(["vowel", "vowel", "hiss", "burst"])
        if kind == "hiss":
            part = 0.3 * shape * sosfilt(butter(2, [3500, 8000], "band", fs=rate, output="sos"), rng.standard_normal(long))
        else:
            pitch = rng.uniform(90, 220) * (1 + 0.1 * np.sin(2 * np.pi * 3 * t))
            pulses = np.diff(np.floor(np.cumsum(pitch) / rate), prepend=0) * 20
            part = np.zeros(long)
            for centre, width in ((rng.uniform(300, 800), 80), (rng.uniform(900, 2200), 120), (rng.uniform(2300, 3200), 200)):
                r = np.exp(-np.pi * width / rate)
                part += lfilter([1 - r], [1, -2 * r * np.cos(2 * np.pi * centre / rate), r * r], pulses)
            part *= shape
            if kind == "burst":
                short = int(rng.uniform(0.005, 0.02) * rate)
                count_up = np.arange(short)
                hiss = rng.standard_normal(short) * np.exp(-count_up / (0.4 * short)) * np.minimum(1, count_up / (1e-3 * rate))
                part = np.concatenate([0.25 * hiss, np.zeros(int(0.02 * rate)), part])
        part /= max(np.abs(part).max(), 1e-9)
        part *= rng.uniform(0.3, 1.0)
        stop = min(count, at + len(part))
        out[at:stop] += part[: stop - at]
        at = stop + int(rng.uniform(0.02, 0.25) * rate)
    return out / max(np.abs(out).max(), 1e-9)


def _thumps(count: int, rate: int, times: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A table that is touched, a sleeve that rubs: dull, and slow to rise; before the first impact and after the last."""
    out = np.zeros(count)
    places = [rng.uniform(0.05, times[0] - 0.05) for _ in range(2)] + [rng.uniform(times[-1] + 0.1, count / rate - 0.1) for _ in range(2)]
    for at in places:
        t = np.arange(int(0.15 * rate)) / rate
        rise = rng.uniform(0.003, 0.01)
        thump = (1 - np.exp(-t / rise)) * np.exp(-t / rng.uniform(0.01, 0.04)) * np.sin(2 * np.pi * rng.uniform(60, 250) * t)
        rub = lfilter(*butter(2, [800, 4000], "band", fs=rate), rng.standard_normal(len(t))) * np.sin(np.pi * t / t[-1]) ** 2
        whole = thump / np.abs(thump).max() + rng.uniform(0, 0.1) * rub
        first = int(at * rate)
        stop = min(count, first + len(whole))
        out[first:stop] += whole[: stop - first]
    return out


def write(drawn: Drawn, codec: str, folder: Path, name: str) -> Path:
    """A file: 16-bit FLAC, or what `codec` ("aac 64000") makes of it."""
    import av

    kind, _, bits = (codec or "flac").partition(" ")
    file = folder / f"{name}.{ {'flac': 'flac', 'aac': 'm4a', 'libmp3lame': 'mp3', 'libvorbis': 'ogg', 'libopus': 'ogg'}[kind] }"
    with av.open(str(file), "w") as container:
        stream: Any = container.add_stream(kind, rate=drawn.rate, layout="mono")
        if bits:
            stream.bit_rate = int(bits)
        whole = np.round(np.clip(drawn.samples, -1, 1) * 32767).astype(np.int16)[None]
        frame = av.AudioFrame.from_ndarray(whole, format="s16", layout="mono")
        frame.sample_rate, frame.pts = drawn.rate, 0
        cut = av.AudioResampler(format=stream.format, layout="mono", rate=drawn.rate, frame_size=stream.frame_size or 4096)
        for part in [*cut.resample(frame), *cut.resample(None)]:
            container.mux(stream.encode(part))
        container.mux(stream.encode(None))
    return file


def heard(file: Path, height_mm: float | None) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] of the impacts that the reader finds, and their sds."""
    from vision.evidence.sound import read_sound
    from vision.motion.impact_chain import find_chain
    from vision.motion.onsets import find_onsets

    sound = read_sound(file)
    onsets = find_onsets(sound)
    chain = find_chain(onsets, sound.duration_s, height_mm)
    return onsets.time_s[chain.impacts], onsets.sd_s[chain.impacts]


@dataclass(eq=False)
class Score:
    """Counts and errors of many drops: the first four impacts and those of them that are clear, found ones, all that were said and
    those that are none, seconds of work and of sound; errors of times with sd and loudness, errors of e."""

    due: int = 0
    found: int = 0
    clear: int = 0
    clear_found: int = 0
    said: int = 0
    invented: int = 0
    seconds: float = 0.0
    listened: float = 0.0
    times: list = field(default_factory=list)
    e: list = field(default_factory=list)

    def add(self, drawn: Drawn, times: np.ndarray, sds: np.ndarray, compressed: bool) -> None:
        near = np.abs(times[:, None] - drawn.times[None]) if len(times) else np.zeros((0, len(drawn.times)))
        own = near.argmin(axis=1) if len(times) else np.zeros(0, int)
        right = near.min(axis=1) < MATCH_S if len(times) else np.zeros(0, bool)
        four = set(range(min(4, len(drawn.times))))
        clear = {k for k in four if drawn.db[k] >= CLEAR_DB}
        heard = set(own[right].tolist())
        self.due, self.found = self.due + len(four), self.found + len(four & heard)
        self.clear, self.clear_found = self.clear + len(clear), self.clear_found + len(clear & heard)
        self.said += len(times)
        self.invented += int((~right).sum())
        off = times[right] - drawn.times[own[right]]
        if compressed and len(off):
            off = off - np.median(off)
        self.times += list(zip(off, sds[right], drawn.db[own[right]]))
        at = dict(zip(own[right], times[right]))
        for k in range(1, min(len(drawn.e), 3)):  # the second and third bounce
            if {k - 1, k, k + 1} <= at.keys():
                self.e.append((at[k + 1] - at[k]) / (at[k] - at[k - 1]) - drawn.e[k])


def study(scene: Scene, drops: int, seed: int) -> Score:
    """A row of the table."""
    score = Score()
    with tempfile.TemporaryDirectory() as folder:
        for k in range(drops):
            drawn = draw(scene, np.random.default_rng([seed, k]))
            file = write(drawn, scene.codec, Path(folder), f"{k}")
            begin = time.process_time()
            times, sds = heard(file, drawn.height_mm if scene.stated else None)
            score.seconds += time.process_time() - begin
            score.listened += len(drawn.samples) / drawn.rate
            score.add(drawn, times, sds, bool(scene.codec))
            file.unlink()
    return score


HEAD = (
    f"{'scene':28} {'found':>7} {'of 0 dB':>7} {'invented':>8} {'rms ms':>7} {'>= 10 dB':>8} {'in 2 sd':>7} {'e < .005':>8} {'s / 10 s':>8}"
)


def row(name: str, score: Score) -> str:
    off, sd, db = np.array(score.times).reshape(-1, 3).T
    loud = db >= 10
    e = np.abs(score.e)
    rms = [1000 * np.sqrt(np.mean(np.square(x))) if len(x) else np.nan for x in (off, off[loud])]
    inside = np.mean(np.abs(off) < 1.96 * sd) if len(off) else np.nan
    shares = (score.found / score.due, score.clear_found / max(score.clear, 1), score.invented / max(score.said, 1))
    found, clear, invented = (100 * share for share in shares)
    good = 100 * np.mean(e < 0.005) if len(e) else np.nan
    return (
        f"{name:28} {found:6.1f}% {clear:6.1f}% {invented:7.1f}% {rms[0]:7.3f} {rms[1]:8.3f}"
        f" {100 * inside:6.1f}% {good:7.1f}% {10 * score.seconds / score.listened:8.2f}"
    )


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("drops", type=int, nargs="?", default=50, help="a row")
    options.add_argument("rows", nargs="*", help="only rows in whose names one of these words is")
    asked = options.parse_args()
    drops, wanted = asked.drops, asked.rows
    print(HEAD, flush=True)
    for k, scene in enumerate(SCENES):
        if not wanted or any(w in scene.name for w in wanted):
            print(row(scene.name, study(scene, drops, k)), flush=True)


if __name__ == "__main__":
    main()
