"""A bench that was only heard, samples/heard-drop: three drops of a soybean on a steel
plate, a phone lying beside it.

    .venv/bin/python samples/heard_drop.py FOLDER      # make it anew (seconds)

Nothing here was recorded: flights through air step by step, rings of a few tones, a
room's noise, a voice, an echo, what three encoders make of them. Of the reader nothing
is used. True answers: truth.csv."""

import sys
from pathlib import Path

import av
import numpy as np
import pandas as pd
from scipy.signal import butter, lfilter

SEED = 2071
GRAVITY, DRAG_PER_M = 9.80665, 0.05  # m/s², of a soybean in room air
RATE = 48_000
DROPS = {  # height [mm], restitution and its scatter, where the sound goes
    "drop-01": (310.0, 0.56, 0.015, "sound.ogg", "libopus", 64_000),
    "drop-02": (200.0, 0.58, 0.015, "sound.mp3", "libmp3lame", 96_000),
    "drop-03": (100.0, 0.61, 0.015, "sound.m4a", "aac", 160_000),
}
TONES_HZ, DECAYS_S = (2350.0, 4120.0, 6730.0), (9e-3, 5e-3, 2e-3)  # of the plate
SHORTEST_S = 0.04  # a flight; shorter ones are not drawn
BENCH = """\
# Drawn, not recorded. True answers: truth.csv. Made by samples/heard_drop.py.
rig = "drop"
session = "heard"
provenance = "simulated"

[seed]
length_mm = 8.72
width_mm = 6.84
thickness_mm = 5.98
density_kg_m3 = 1250
"""


def make(folder: Path) -> pd.DataFrame:
    """All recordings, bench.toml and truth.csv; returns the truth."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "bench.toml").write_text(BENCH, encoding="utf8")
    rows = []
    for k, (name, (height, e, scatter, file, codec, bits)) in enumerate(DROPS.items()):
        rng = np.random.default_rng([SEED, k])
        times, restitutions, speed = fall(height / 1000, e, scatter, 0.9 + 0.2 * k, rng)
        (folder / name).mkdir(exist_ok=True)
        (folder / name / "recording.toml").write_text(
            f"[drop]\nheight_mm = {height:g}\n", encoding="utf8"
        )
        encode(folder / name / file, heard(times, restitutions, rng), codec, bits)
        rows += [
            (name, "impact_speed", speed, "m/s"),
            (name, "restitution_normal", restitutions[0], "1"),
        ]
        rows += [(name, f"t_{n + 1}", t, "s") for n, t in enumerate(times)]
    truth = pd.DataFrame(rows, columns=["recording", "quantity", "value", "unit"])
    truth.to_csv(folder / "truth.csv", index=False, float_format="%.6g")
    return truth


def fall(
    height_m: float, e: float, scatter: float, begin_s: float, rng: np.random.Generator
):
    """Times [s] of the impacts, restitution of each but the last, speed [m/s] of the
    first."""
    _, speed = flight(height_m, 0.0)
    times, restitutions, first = [begin_s], [], speed
    while True:
        one = e + scatter * float(rng.standard_normal())
        lasts, landing = flight(0.0, one * speed)
        if lasts < SHORTEST_S:
            return np.array(times), restitutions, first
        restitutions.append(one)
        times.append(times[-1] + lasts)
        speed = landing


def flight(z: float, v: float, step: float = 1e-5) -> tuple[float, float]:
    """How long [s] from height z at speed v upwards to the plate, and the speed
    there."""
    t = 0.0
    while True:
        a = -GRAVITY - DRAG_PER_M * v * abs(v)
        lower = z + v * step + a * step**2 / 2
        if lower <= 0 and v < 0:
            part = z / (z - lower)
            return t + part * step, -(v + part * a * step)
        z, v, t = lower, v + a * step, t + step


def heard(
    times: np.ndarray, restitutions: list[float], rng: np.random.Generator
) -> np.ndarray:
    """What a phone records of it: samples of full scale 1."""
    t = np.arange(int((times[-1] + 0.7) * RATE)) / RATE
    loud = 0.4 * np.concatenate([[1.0], np.cumprod(restitutions)]) ** 1.2
    sound = np.zeros(len(t))
    for at, size in zip(times, loud):
        after = np.maximum(t - at, 0)
        for hertz, decay in zip(TONES_HZ, DECAYS_S):
            phase, part = rng.uniform(0, 2 * np.pi), rng.uniform(0.3, 1.0)
            sound += (
                (t >= at)
                * size
                * part
                * np.exp(-after / decay)
                * np.sin(2 * np.pi * hertz * after + phase)
            )
    late = int(0.0213 * RATE)
    sound[late:] += 0.2 * lfilter(
        *butter(1, 4000, fs=RATE), sound[:-late]
    )  # a wall, 3.6 m off
    room = np.cumsum(rng.standard_normal(len(t)))
    room = lfilter(*butter(1, 60, "highpass", fs=RATE), room)
    sound += 0.004 * room / room.std() + 0.0008 * rng.standard_normal(len(t))
    voice = (
        np.sin(2 * np.pi * 140 * t)
        + 0.6 * np.sin(2 * np.pi * 700 * t)
        + 0.3 * np.sin(2 * np.pi * 2450 * t)
    )
    said = np.exp(-(((t - 0.3) / 0.12) ** 2)) + np.exp(
        -(((t - times[-1] - 0.5) / 0.1) ** 2)
    )
    return np.clip(sound + 0.03 * voice * said, -1, 1)


def encode(file: Path, sound: np.ndarray, codec: str, bits: int) -> None:
    with av.open(str(file), "w") as container:
        stream = container.add_stream(codec, rate=RATE, layout="mono")
        stream.bit_rate = bits
        frame = av.AudioFrame.from_ndarray(
            np.round(32767 * sound).astype(np.int16)[None], format="s16", layout="mono"
        )
        frame.sample_rate, frame.pts = RATE, 0
        cut = av.AudioResampler(
            format=stream.format, layout="mono", rate=RATE, frame_size=stream.frame_size
        )
        for part in [*cut.resample(frame), *cut.resample(None)]:
            container.mux(stream.encode(part))
        container.mux(stream.encode(None))


if __name__ == "__main__":
    make(Path(sys.argv[1]))
