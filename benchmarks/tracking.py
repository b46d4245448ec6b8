"""Tracking: accuracy, honesty of the error bars, speed and memory on drawn films;
trackpy's locate on the same frames beside it.

python benchmarks/tracking.py \\
    [RECORDINGS [accuracy restitution coverage speed memory]]

RECORDINGS: for the coverage, 200 if not stated.
"""

import argparse
import math
import os
import re

os.environ.setdefault(
    "OPENBLAS_NUM_THREADS", "1"
)  # one core: what is stated is per core

import subprocess
import sys
import tempfile
import time
import warnings
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from scipy.integrate import solve_ivp
from synthetic.film import (
    Look,
    draw_frame,
    draw_scene,
    film,
    to_picture,
    write_frames,
    write_video,
)
from synthetic.motion import correlated_noise, draw_drop, film_track

from benchtwin.bench.air import SEED_DRAG, SHAPE_SD, air_of, drag_shape
from benchtwin.bench.constants import G_M_S2
from benchtwin.rigs.drop.keys import Drop
from benchtwin.rigs.drop.measure import measure_drop
from benchtwin.vision.evidence.frames import Frame, FrameSource, open_frames
from benchtwin.vision.motion.detect import find_silhouettes
from benchtwin.vision.motion.scene import grey, learn_scene
from benchtwin.vision.motion.track import make_track
from benchtwin.vision.motion.track_seed import track_seed
from benchtwin.vision.recording import Air, Camera, Recording, Seed

FRAMES_LONG = 5000
warnings.filterwarnings("ignore", message="Image contains no local maxima")


class InMemory(FrameSource):
    """Frames that are drawn already."""

    def __init__(self, frames):
        super().__init__(path=Path("drawn"), count=len(frames), fps=None)
        self.frames = frames

    def iterate(self):
        return (Frame(i, float("nan"), pixels) for i, pixels in enumerate(self.frames))


def recording(folder="drawn", **camera) -> Recording:
    return Recording(
        id="drawn",
        path=Path(folder),
        rig="drop",
        evidence="frames",
        files=(),
        camera=Camera(**camera),
        air=Air(density_kg_m3=0),
        drop=Drop(height_mm=310),
    )


def accuracy() -> None:
    """Centroids of a seed of 17 × 14 px that falls at random sub-pixel places, against
    where it was drawn."""
    print(
        f"{'frames':32s} {'rms px':>8s} {'lock px':>8s} {'claimed':>8s} {'trackpy':>8s}"
        f" {'ratio':>6s}"
    )
    looks = {
        "clean": Look(),
        "noise/signal 0.1": Look(noise=12.5),
        "graph paper, shading, noise 3": Look(
            graph_paper=True, ground_grey=110, shading=0.1, noise=3
        ),
        "dark seed on light graph paper": Look(
            seed_grey=60, ground_grey=190, graph_paper=True, noise=3
        ),
        "small seed (9 × 7 px), noise 3": Look(mm_per_px=1.0, noise=3),
        "16 bits, noise 2": Look(bits=16, noise=2),
    }
    motion = draw_drop(height_mm=150, lateral_m_s=0.05)
    for name, look in looks.items():
        rng = np.random.default_rng(1)
        times = np.sort(rng.uniform(0.03, 0.19, 120))
        frames = list(film(motion, look, rng, fps=1000, times=times))
        columns, rows = to_picture(look, *motion.path(times)[:2])
        scene = learn_scene(InMemory(frames))
        ours, theirs, sd = [], [], []
        for frame, column, row in zip(frames, columns, rows):
            seen = find_silhouettes(frame, scene)
            found = seen[np.argmin([np.hypot(s.x - column, s.y - row) for s in seen])]
            ours.append((found.x - column, found.y - row))
            sd.append(found.sd)
            theirs.append(located(frame, scene, column, row, look))
        off, peer = np.array(ours), np.array(theirs)
        phase = np.concatenate([columns % 1, rows % 1])
        rms, peers = np.sqrt((off**2).mean()), np.sqrt(np.nanmean(peer**2))
        print(
            f"{name:32s} {rms:8.4f} {lock(phase, off.T.ravel()):8.4f}"
            f" {np.mean(sd):8.4f} {peers:8.4f} {peers / rms:6.1f}"
        )


def lock(phase: np.ndarray, off: np.ndarray) -> float:
    """Amplitude of the error's dependence on the sub-pixel place: the first
    harmonic."""
    wave = np.column_stack(
        [np.cos(2 * np.pi * phase), np.sin(2 * np.pi * phase), np.ones(len(phase))]
    )
    return float(np.hypot(*np.linalg.lstsq(wave, off, rcond=None)[0][:2]))


def located(frame, scene, column, row, look) -> tuple[float, float]:
    """trackpy.locate on the same frame less the same background (it knows no
    background), nearest feature's error."""
    import trackpy

    size = int(look.axes_mm[0] / look.mm_per_px) // 2 * 2 + 5
    bright = np.abs(grey(frame) - scene.grey_background)
    found = trackpy.locate(bright, size, topn=1, characterize=False)
    return (
        (float(found.x.iloc[0] - column), float(found.y.iloc[0] - row))
        if len(found)
        else (np.nan, np.nan)
    )


def restitution(count=60) -> None:
    """310 mm, e 0.5, 0.1 px of 0.25 mm, 5200 fps."""
    values: dict[str, list] = {"white noise": [], "AR(1) 0.9": []}
    for seed in range(count):
        for name, ar in zip(values, (0.0, 0.9)):
            track = film_track(
                draw_drop(), np.random.default_rng(seed), ar=ar, noise_mm=0.025
            )
            found = measure_drop(
                track, recording(fps=5200, mm_per_px=0.25, mm_per_px_sd=0.0002)
            )
            values[name].append(
                [q.value for q in found.quantities if q.name.startswith("restitution")]
            )
    for name, rows in values.items():
        mean, sd = np.mean(rows, axis=0), np.std(rows, axis=0)
        text = f"Eq. 1 {mean[0]:.5f} ± {sd[0]:.5f}   normal {mean[1]:.5f} ± {sd[1]:.5f}"
        print(f"restitution, drawn 0.500, {name:12s} {text}  ({count} recordings)")


def coverage(count: int) -> None:
    """How often value ± 1.96 sd holds the truth; e, noise, its correlation, fps, scale,
    plumb, gravity, height all drawn."""
    inside: dict[str, list[bool]] = {}
    for seed in range(count):
        truth, track, known = drawn_drop(np.random.default_rng(seed))
        for q in measure_drop(track, known, (0.0, 155.0)).quantities:
            inside.setdefault(q.name, []).append(
                abs(q.value - truth[q.name]) < 1.96 * q.sd
            )
    for name, hits in inside.items():
        print(
            f"95 % interval of {name:20s} holds the truth in {100 * np.mean(hits):5.1f}"
            f" % of {len(hits)}"
        )


def drawn_drop(rng: np.random.Generator):
    """(truth, track, recording) of a soybean that falls and bounces before a pinhole
    camera: whatever is stated is off by its own sd, and what is not stated (air, local
    gravity, motion towards the camera) is drawn from its prior."""
    e, fps = rng.uniform(0.3, 0.75), float(rng.choice([240, 1000, 2400]))
    ar, noise = float(rng.choice([0, 0.5, 0.9])), rng.uniform(0.01, 0.1)
    scale_sd = float(rng.choice([2e-4, 2e-3, 1e-2]))
    away = float(np.exp(rng.uniform(np.log(0.5), np.log(5.0))))
    plumb_sd = float(rng.choice([0.05, 0.5]))
    soybean = Seed(length_mm=8.72, width_mm=6.84, thickness_mm=5.98, density_kg_m3=1250)
    camera = Camera(
        fps=fps,
        mm_per_px=0.25,
        mm_per_px_sd=0.25 * scale_sd,
        plumb_deg=0.0,
        plumb_sd_deg=plumb_sd,
        distance_mm=1000 * away,
    )
    known = replace(recording(), camera=camera, seed=soybean, air=Air())
    fall = 0.310 + 0.001 * rng.normal()
    pieces, truth = bounces(known, fall, e, rng)
    time = np.arange(0.0, pieces[-1].t_max, 1 / fps)
    starts = np.array([piece.t_min for piece in pieces])
    which = np.searchsorted(starts, time, side="right") - 1
    x, depth, y = np.array([pieces[k](t)[:3] for k, t in zip(which, time)]).T
    nearer = 1 / (1 - depth / away)
    middle = fall / 2
    x, y = nearer * x, middle + nearer * (y - middle)
    seen = [
        1000 * place + correlated_noise(len(time), noise, ar, rng) for place in (x, y)
    ]
    scale, turn = 1 + scale_sd * rng.normal(), np.radians(plumb_sd * rng.normal())
    x, y = (scale * place for place in seen)
    across = x * np.cos(turn) - y * np.sin(turn)
    up = x * np.sin(turn) + y * np.cos(turn)
    return truth, make_track(time, across, up, sd=noise), known


def bounces(known: Recording, fall_m: float, e: float, rng: np.random.Generator):
    """Solutions of fall and rebounds over time, (x, towards the camera, z, speeds)
    [m, s], through air with buoyancy and added mass; and the truth of the first."""
    air = air_of(
        {
            "seed": known.seed.model_dump(exclude_none=True),
            "air": known.air.model_dump(),
        }
    )
    share = air.share * (1 + SHAPE_SD * rng.normal()) * (1 + SEED_DRAG * rng.normal())
    slope, g = 0.15 * rng.normal(), G_M_S2 * (1 + 8e-4 * rng.normal())

    def rate(_, state):
        velocity = state[3:]
        speed = np.array([np.linalg.norm(velocity)])
        drag = share * g * drag_shape(speed, air.reynolds_per_speed, slope) * velocity
        pull = np.array([0.0, 0.0, -g * (1 - air.buoyancy)]) - drag
        return np.concatenate([velocity, pull / (1 + air.buoyancy / 2)])

    def ground(t, state):
        return state[2] if state[5] < 0 else 1.0

    ground.terminal = True  # type: ignore[attr-defined]
    state = np.array([0.0, 0.0, fall_m, 0.02 * rng.normal(), 0.02 * rng.normal(), 0.0])
    pieces, times, table = [], [0.0], []
    for _ in range(4):
        begin = times[-1]
        found = solve_ivp(
            rate,
            (begin, begin + 2),
            state,
            events=ground,
            rtol=1e-10,
            atol=1e-12,
            dense_output=True,
        )
        pieces.append(found.sol)
        times.append(float(found.t[-1]))
        state = found.y[:, -1].copy()
        before = -state[5]
        row = {"t_s": times[-1], "before": before, "after": e * before, "e": e}
        row["lateral_before"] = float(state[3])
        state[2], state[5] = 1e-12, e * before
        state[3:5] += 0.1 * rng.normal(size=2)
        table.append(row | {"lateral_after": float(state[3])})
    rise = np.linspace(times[1], times[2], 4001)
    top = 1000 * float(pieces[1](rise)[2].max())
    first = table[0]
    truth = {
        "rebound_height": top,
        "restitution": math.sqrt(top / (1000 * fall_m)),
        "impact_speed": first["before"],
        "rebound_speed": first["after"],
        "restitution_normal": e,
        "bounces": table,
    }
    return pieces, truth


def large_frames(count: int, step_s: float):
    """1280 × 800, graph paper and noise; the noise is one of 16 fields, so that drawing
    them takes seconds."""
    look = Look(
        width=1280,
        height=800,
        mm_per_px=0.45,
        origin_px=(640, 780),
        graph_paper=True,
        ground_grey=110,
        noise=0.0,
    )
    rng = np.random.default_rng(3)
    motion, scene = draw_drop(height_mm=310), draw_scene(look, rng)
    fields = [
        (3 * rng.standard_normal(scene.shape)).astype(np.int16) for _ in range(16)
    ]
    for n in range(count):
        frame = draw_frame(motion, look, rng, scene, n * step_s, 0.0)
        yield np.clip(frame.astype(np.int16) + fields[n % 16], 0, 255).astype(np.uint8)


def speed(count=300) -> None:
    """Processor time a frame, decoding apart, one thread (a busy machine's wall clock
    says little); trackpy beside it."""
    import trackpy

    cv2.setNumThreads(1)
    with tempfile.TemporaryDirectory() as folder:
        known = recording(folder, fps=count / 0.9)
        for name, write in (("png frames", write_frames), ("h264 video", write_video)):
            made = write(
                replace(known, path=Path(folder) / name[:4]),
                large_frames(count, 0.9 / count),
            )
            start = time.process_time()
            for _ in open_frames(made).iterate():
                pass
            decoding = (time.process_time() - start) / count
            frames = [f.pixels for f in open_frames(made).iterate()]
            source = InMemory(frames)
            start = time.process_time()
            scene = learn_scene(source)
            learning = (time.process_time() - start) / count
            start = time.process_time()
            for pixels in frames:
                find_silhouettes(pixels, scene)
            finding = (time.process_time() - start) / count
            start = time.process_time()
            track_seed(open_frames(made), falling=True)
            whole = (time.process_time() - start) / count
            print(
                f"1280 × 800, {name}: decoding {1e3 * decoding:.2f} ms, finding the"
                f" seed {1e3 * finding:.2f} ms, learning the scene"
                f" {1e3 * learning * count:.0f} ms once, whole run {1e3 * whole:.2f} ms"
                " a frame"
            )
        start = time.process_time()
        for pixels in frames[:20]:
            trackpy.locate(
                np.abs(grey(pixels) - scene.grey_background),
                21,
                topn=1,
                characterize=False,
            )
        peer = (time.process_time() - start) / 20
        ratio = peer / finding
        print(
            f"trackpy.locate on the same frames: {1e3 * peer:.1f} ms a frame,"
            f" {ratio:.1f} × as long as finding the seed here"
        )


def memory() -> None:
    """Peak memory of a fresh process that tracks FRAMES_LONG frames of 1280 × 800 from
    a video."""
    with tempfile.TemporaryDirectory() as folder:
        made = write_video(
            recording(folder, fps=5200), large_frames(FRAMES_LONG, 1 / 5200)
        )
        start = time.perf_counter()
        out = subprocess.run(
            [sys.executable, __file__, "--track", str(made.path)],
            capture_output=True,
            text=True,
            check=True,
        )
        print(
            f"{FRAMES_LONG} frames of 1280 × 800 from a video: {out.stdout.strip()},"
            f" {time.perf_counter() - start:.0f} s"
        )


def track_alone(folder: str) -> None:
    from benchtwin.measure.observe import observe
    from benchtwin.vision.recording import read_recording

    found = observe(read_recording(Path(folder)))
    assert found.track is not None
    # ru_maxrss would hand on what the parent held when it forked; VmHWM is this
    # program's own.
    status = Path("/proc/self/status")
    peak_line = (
        re.search(r"VmHWM:\s+(\d+)", status.read_text()) if status.exists() else None
    )
    peak = int(peak_line[1]) / 1024 if peak_line else float("nan")
    print(f"peak memory {peak:.0f} MB, {len(found.track)} frames with the seed")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--track"]:
        track_alone(sys.argv[2])
    else:
        parser = argparse.ArgumentParser(
            description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
        )
        parser.add_argument("recordings", type=int, nargs="?", default=200)
        parser.add_argument("studies", nargs="*", metavar="study")
        arguments = parser.parse_args()
        studies = {
            "accuracy": accuracy,
            "restitution": restitution,
            "coverage": lambda: coverage(arguments.recordings),
            "speed": speed,
            "memory": memory,
        }
        if unknown := set(arguments.studies) - set(studies):
            parser.error(
                f"no such study: {', '.join(sorted(unknown))}; there are"
                f" {', '.join(studies)}"
            )
        for study in arguments.studies or studies:
            studies[study]()
