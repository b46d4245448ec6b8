"""The sound of a seed that bounces, drawn with known impacts: decaying tones, noise,
speech and filters.

Nothing of the reader is used. A loudness in dB is the rms of a ring over its first 5 ms
above the rms of the noise in the whole band (of hum: of its hiss). A scene's loudness
is that of the first impact; every later one is fainter by its speed to the power 1.2,
and scatters by 2 dB."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.signal import butter, lfilter, sosfilt

G = 9.80665


@dataclass(frozen=True)
class Scene:
    """What one row of the table is made of. db: loudness of the first impact, a range;
    e: a range; codec: "" or "aac 64000"."""

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
    Scene("white"),
    Scene("white, 10 dB", (10, 10)),
    Scene("white, 0 dB", (0, 0)),
    Scene("white, -10 dB", (-10, -10)),
    Scene("pink", noise="pink"),
    Scene("hum", noise="hum"),
    Scene("pink, 10 dB", (10, 10), "pink"),
    Scene("lively (e .8-.95)", e=(0.8, 0.95)),
    Scene("dead (e .2-.4)", (25, 40), e=(0.2, 0.4)),
    Scene("scatter of e .06", e_scatter=0.06),
    Scene("echoes 5-60 ms", noise="pink", echoes=2),
    Scene("handling", noise="pink", thumps=True),
    Scene("speech, faint", noise="pink", speech=0.05),
    Scene("speech, loud", (25, 40), "pink", speech=0.4),
    Scene("clipped", (25, 40), clip=True),
    Scene("aac 64 kbit/s", noise="pink", codec="aac 64000"),
    Scene("mp3 96 kbit/s", noise="pink", codec="libmp3lame 96000"),
    Scene(
        "all of it, aac",
        (20, 40),
        "pink",
        speech=0.1,
        thumps=True,
        echoes=2,
        codec="aac 96000",
        clip=True,
    ),
    Scene(
        "all of it, height unknown",
        (20, 40),
        "pink",
        speech=0.1,
        thumps=True,
        echoes=2,
        stated=False,
    ),
)


@dataclass(frozen=True, eq=False)
class Drawn:
    """samples (n,), rate, the true times [s], restitutions (first one from the fall),
    dB of each impact, the height fallen."""

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
    speeds, each = [fall], list[float]()
    while len(speeds) < 12 and 2 * speeds[-1] * mean / G > 0.03:
        each.append(
            float(np.clip(mean + scene.e_scatter * rng.standard_normal(), 0.05, 0.98))
        )
        speeds.append(speeds[-1] * each[-1])
    times = rng.uniform(0.7, 1.5) + np.concatenate(
        [[0.0], np.cumsum(2 * np.array(speeds[1:]) / G)]
    )
    e = np.array(each)
    count = int((times[-1] + rng.uniform(0.5, 1.0)) * rate)
    db = (
        rng.uniform(*scene.db)
        + 24 * np.log10(np.array(speeds[: len(times)]) / fall)
        + 2.0 * rng.standard_normal(len(times))
    )
    db[0] = max(db[0], scene.db[0])
    out = np.sum(
        [
            _placed(ring, t, rate, count)
            for ring, t in zip(_rings(scene, rate, db, rng), times)
        ],
        axis=0,
    )
    for _ in range(scene.echoes):
        out = out + _echo(out, rate, rng)
    loud = np.abs(out).max()
    if scene.speech:
        out = out + scene.speech * loud * _speech(count, rate, rng)
    if scene.thumps:
        out = out + _thumps(count, rate, times, rng) * loud * rng.uniform(0.1, 1.0)
    out = out + _noise(scene.noise, count, rate, rng)
    scale = (rng.uniform(1.5, 4.0) if scene.clip else rng.uniform(0.2, 0.9)) / np.abs(
        out
    ).max()
    return Drawn(
        np.clip(out * scale, -1, 1).astype(np.float32), rate, times, e, db, height
    )


def _rings(
    scene: Scene, rate: int, db: np.ndarray, rng: np.random.Generator
) -> list[np.ndarray]:
    """The sound of each impact: the same tones, struck otherwise each time."""
    tones = rng.uniform(2000, 8000, int(rng.integers(2, 6)))
    decay = (
        np.exp(
            rng.uniform(
                np.log(scene.decay_ms[0]), np.log(scene.decay_ms[1]), len(tones)
            )
        )
        / 1000
    )
    t = np.arange(int(0.1 * rate)) / rate
    usual = rng.uniform(0.3, 1.0, len(tones))
    touch = np.hanning(
        max(3, int(rng.uniform(3e-5, 1e-4) * rate) | 1) + 2
    )  # the contact's own length
    out = []
    for loudness in db:
        size = usual * np.exp(0.3 * rng.standard_normal(len(tones)))
        phase = rng.uniform(0, 2 * np.pi, len(tones))
        ring = sum(
            a * np.exp(-t / d) * np.sin(2 * np.pi * f * t + p)
            for a, d, f, p in zip(size, decay, tones, phase)
        )
        ring = np.convolve(ring, touch / touch.sum())[: len(t)]
        out.append(
            ring
            * 10 ** (loudness / 20)
            / np.sqrt(np.mean(ring[: int(0.005 * rate)] ** 2))
        )
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
        return 0.3 * white + sum(
            3.0 / k * np.sin(2 * np.pi * 50 * k * t + rng.uniform(0, 7))
            for k in (1, 2, 3, 5, 7)
        )
    if kind == "pink":
        spectrum = np.fft.rfft(white)
        spectrum /= np.sqrt(np.maximum(np.fft.rfftfreq(count, 1 / rate), 20.0))
        pink = np.fft.irfft(spectrum, count)
        return pink / pink.std()
    return white


def _speech(count: int, rate: int, rng: np.random.Generator) -> np.ndarray:
    """Syllables: a burst of a plosive, pulses of a voice through three formants,
    hissing; peak 1."""
    out, at = np.zeros(count), int(rng.uniform(0, 0.4) * rate)
    while at < count - rate // 2:
        long = int(rng.uniform(0.08, 0.3) * rate)
        t = np.arange(long) / rate
        rise, fall = rng.uniform(0.015, 0.05), rng.uniform(0.03, 0.08)
        shape = np.minimum(1, t / rise) * np.minimum(1, (long / rate - t) / fall)
        kind = rng.choice(["vowel", "vowel", "hiss", "burst"])
        if kind == "hiss":
            part = (
                0.3
                * shape
                * sosfilt(
                    butter(2, [3500, 8000], "band", fs=rate, output="sos"),
                    rng.standard_normal(long),
                )
            )
        else:
            pitch = rng.uniform(90, 220) * (1 + 0.1 * np.sin(2 * np.pi * 3 * t))
            pulses = np.diff(np.floor(np.cumsum(pitch) / rate), prepend=0) * 20
            part = np.zeros(long)
            for centre, width in (
                (rng.uniform(300, 800), 80),
                (rng.uniform(900, 2200), 120),
                (rng.uniform(2300, 3200), 200),
            ):
                r = np.exp(-np.pi * width / rate)
                part += lfilter(
                    [1 - r],
                    [1, -2 * r * np.cos(2 * np.pi * centre / rate), r * r],
                    pulses,
                )
            part *= shape
            if kind == "burst":
                short = int(rng.uniform(0.005, 0.02) * rate)
                count_up = np.arange(short)
                hiss = (
                    rng.standard_normal(short)
                    * np.exp(-count_up / (0.4 * short))
                    * np.minimum(1, count_up / (1e-3 * rate))
                )
                part = np.concatenate([0.25 * hiss, np.zeros(int(0.02 * rate)), part])
        part /= max(np.abs(part).max(), 1e-9)
        part *= rng.uniform(0.3, 1.0)
        stop = min(count, at + len(part))
        out[at:stop] += part[: stop - at]
        at = stop + int(rng.uniform(0.02, 0.25) * rate)
    return out / max(np.abs(out).max(), 1e-9)


def _thumps(
    count: int, rate: int, times: np.ndarray, rng: np.random.Generator
) -> np.ndarray:
    """A table that is touched, a sleeve that rubs: dull, and slow to rise; before the
    first impact and after the last."""
    out = np.zeros(count)
    places = [rng.uniform(0.05, times[0] - 0.05) for _ in range(2)] + [
        rng.uniform(times[-1] + 0.1, count / rate - 0.1) for _ in range(2)
    ]
    _lay_thumps(out, places, rate, rng)
    return out


def _lay_thumps(
    out: np.ndarray, places: list[float], rate: int, rng: np.random.Generator
) -> None:
    for at in places:
        t = np.arange(int(0.15 * rate)) / rate
        rise = rng.uniform(0.003, 0.01)
        thump = (
            (1 - np.exp(-t / rise))
            * np.exp(-t / rng.uniform(0.01, 0.04))
            * np.sin(2 * np.pi * rng.uniform(60, 250) * t)
        )
        rub = (
            lfilter(
                *butter(2, [800, 4000], "band", fs=rate), rng.standard_normal(len(t))
            )
            * np.sin(np.pi * t / t[-1]) ** 2
        )
        whole = thump / np.abs(thump).max() + rng.uniform(0, 0.1) * rub
        first = int(at * rate)
        stop = min(len(out), first + len(whole))
        out[first:stop] += whole[: stop - first]


def draw_session(
    scene: Scene,
    e_first: np.ndarray,
    height_mm: float,
    rng: np.random.Generator,
    handling: int = 3,
    pauses: np.ndarray | None = None,
) -> list[Drawn]:
    """Several drops of one seed on one plate in one sound, the same samples in each
    `Drawn`: silence and `handling` thumps between one and the next. e_first: the first
    restitution of each; those of later bounces scatter by scene.e_scatter about it;
    pauses: from each first impact to the next one [s]."""
    rate, fall = 48_000, np.sqrt(2 * G * height_mm / 1000)
    at, drops, gaps = rng.uniform(0.7, 1.5), [], []
    for k, first in enumerate(e_first):
        speeds, each = [fall], list[float]()
        while len(speeds) < 12 and 2 * speeds[-1] * first / G > 0.03:
            off = scene.e_scatter * rng.standard_normal() if each else 0.0
            each.append(float(np.clip(first + off, 0.05, 0.98)))
            speeds.append(speeds[-1] * each[-1])
        later = np.cumsum(2 * np.array(speeds[1:]) / G)
        times = at + np.concatenate([[0.0], later])
        db = rng.uniform(*scene.db) + 24 * np.log10(np.array(speeds) / fall)
        drops.append((times, np.array(each), db[: len(times)]))
        drawn = times[-1] + rng.uniform(1.5, 4.0)
        at = drawn if pauses is None else times[0] + pauses[k]
        gaps.append((times[-1] + 0.15, at - 0.2))
    count = int((drops[-1][0][-1] + 1.0) * rate)
    out = np.zeros(count)
    rings = _rings(scene, rate, np.concatenate([db for *_, db in drops]), rng)
    for ring, t in zip(rings, np.concatenate([times for times, *_ in drops])):
        first = int(t * rate)
        part = out[first : first + len(ring) + 1]
        part += _placed(ring, t - first / rate, rate, len(part))
    thumps = np.zeros(count)
    places = [rng.uniform(*gap) for gap in gaps[:-1] for _ in range(handling)]
    _lay_thumps(thumps, places, rate, rng)
    out += thumps * np.abs(out).max() * rng.uniform(0.1, 1.0)
    out += _noise(scene.noise, count, rate, rng)
    out *= rng.uniform(0.2, 0.9) / np.abs(out).max()
    samples = out.astype(np.float32)
    return [Drawn(samples, rate, t, e, db, height_mm) for t, e, db in drops]


def write(drawn: Drawn, codec: str, folder: Path, name: str) -> Path:
    """A file: 16-bit FLAC, or what `codec` ("aac 64000") makes of it."""
    import av

    kind, _, bits = (codec or "flac").partition(" ")
    endings = {
        "flac": "flac",
        "aac": "m4a",
        "libmp3lame": "mp3",
        "libvorbis": "ogg",
        "libopus": "ogg",
    }
    file = folder / f"{name}.{endings[kind]}"
    with av.open(str(file), "w") as container:
        stream: Any = container.add_stream(kind, rate=drawn.rate, layout="mono")
        if bits:
            stream.bit_rate = int(bits)
        whole = np.round(np.clip(drawn.samples, -1, 1) * 32767).astype(np.int16)[None]
        frame = av.AudioFrame.from_ndarray(whole, format="s16", layout="mono")
        frame.sample_rate, frame.pts = drawn.rate, 0
        cut = av.AudioResampler(
            format=stream.format,
            layout="mono",
            rate=drawn.rate,
            frame_size=stream.frame_size or 4096,
        )
        for part in [*cut.resample(frame), *cut.resample(None)]:
            container.mux(stream.encode(part))
        container.mux(stream.encode(None))
    return file
