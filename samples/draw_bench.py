"""Draws samples/drawn-bench: a small bench folder with every rig and every kind of
evidence, its true answers in truth.csv.

    python samples/draw_bench.py [folder]

Nothing in it was filmed: it shows what a bench folder looks like, and what `benchtwin
measure` makes of one."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
from PIL import Image

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
from synthetic.film import Look, film, write_frames, write_video
from synthetic.motion import Motion, draw_drop, draw_roll, draw_slide, film_track
from synthetic.piles import PileScene, draw_pile
from synthetic.rigs_film import corner_mm, film_roll

from benchtwin.rigs.drop.keys import Drop
from benchtwin.rigs.roll.keys import Roll
from benchtwin.rigs.slide.keys import Slide
from benchtwin.vision.recording import Camera, Recording, Seed, write_recording

BENCH = """\
# A drawn bench: nothing here was filmed. True answers: truth.csv. \
Made by samples/draw_bench.py.
session = "drawn"
provenance = "simulated"

[seed]
length_mm = 8.72
width_mm = 6.84
thickness_mm = 5.98
density_kg_m3 = 1250
"""


def draw_bench(folder: Path, seed: int = 20260302) -> pd.DataFrame:
    """Draw all recordings into `folder`; returns the true answers (recording, quantity,
    value, unit)."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "bench.toml").write_text(BENCH, encoding="utf8")
    rows = []
    for n, (name, draw) in enumerate(RECORDINGS.items()):
        rng = np.random.default_rng([seed, n])
        rows += [
            (name, quantity, value, unit)
            for quantity, value, unit in draw(folder / name, rng)
        ]
    truth = pd.DataFrame(rows, columns=["recording", "quantity", "value", "unit"])
    truth.to_csv(folder / "truth.csv", index=False, float_format="%.6g")
    return truth


def _recording(path: Path, rig: str, evidence: str, **known) -> Recording:
    return Recording(
        id=path.name,
        path=path,
        rig=rig,
        evidence=evidence,
        files=(),
        provenance="simulated",
        **known,
    )


# ρ_air C_d A / 2m of a soybean: what bench.toml's seed and air come to (C_d 0.44)
DRAG_PER_M = 0.043


def _drop(**options) -> Motion:
    kicks = ((0.03, 12.0), (-0.02, -8.0), (0.01, 3.0))
    return draw_drop(
        height_mm=310,
        restitution=(0.54, 0.56, 0.57),
        kicks=kicks,
        max_bounces=3,
        drag_per_m=DRAG_PER_M,
        **options,
    )


def _drop_truth(motion: Motion):
    units = {
        "rebound_height": "mm",
        "restitution": "1",
        "impact_speed": "m/s",
        "rebound_speed": "m/s",
        "restitution_normal": "1",
    }
    return [(name, motion.truth[name], unit) for name, unit in units.items()]


def drop_frames(path: Path, rng: np.random.Generator):
    """High-speed frames before a cluttered wall, clamp in view, 400 fps."""
    motion = replace(_drop(), end_s=0.62)
    look = Look(
        width=176,
        height=704,
        mm_per_px=0.5,
        origin_px=(80.0, 680.0),
        plate_row=680.0,
        noise=1.0,
        shading=0.15,
        clutter=18.0,
        clamp=True,
        exposure_s=4e-4,
    )
    camera = Camera(
        fps=400.0,
        mm_per_px=0.5,
        mm_per_px_sd=0.0005,
        plumb_deg=0.0,
        plumb_sd_deg=0.05,
        exposure_s=4e-4,
    )
    recording = _recording(
        path, "drop", "frames", camera=camera, drop=Drop(height_mm=310.0)
    )
    write_frames(recording, film(motion, look, rng, fps=400.0), suffix=".jpg")
    return _drop_truth(motion)


def drop_phone(path: Path, rng: np.random.Generator):
    """A phone's video at 60 fps, uneven time stamps, colour, no scale stated: ratios
    only."""
    motion = replace(_drop(rest_s=0.15), end_s=1.2)
    look = Look(
        width=270,
        height=480,
        mm_per_px=0.8,
        origin_px=(120.0, 440.0),
        plate_row=440.0,
        noise=2.0,
        shading=0.1,
        clutter=15.0,
        colour=True,
        exposure_s=2e-3,
        hand=True,
    )
    times = np.arange(0, motion.end_s, 1 / 60) + rng.uniform(
        -1e-3, 1e-3, int(np.ceil(motion.end_s * 60))
    )
    times = np.maximum.accumulate(np.maximum(times - times[0], 0))
    write_video(
        _recording(path, "drop", "video"),
        film(motion, look, rng, fps=60.0, times=times),
        fps=60.0,
        times=times,
    )
    return [row for row in _drop_truth(motion) if row[0] == "restitution_normal"]


def drop_track(path: Path, rng: np.random.Generator):
    """A track from somebody else's tracker, 5200 fps, correlated noise."""
    motion = _drop()
    track = film_track(motion, rng, fps=5200.0, noise_mm=0.025, ar=0.9, until_s=0.75)
    camera = Camera(
        fps=5200.0,
        mm_per_px=0.25,
        mm_per_px_sd=0.0002,
        plumb_deg=0.0,
        plumb_sd_deg=0.05,
    )
    _write_track(
        _recording(
            path, "drop", "track.csv", camera=camera, drop=Drop(height_mm=310.0)
        ),
        track,
    )
    return _drop_truth(motion)


def drop_heard(path: Path, rng: np.random.Generator):
    """What a microphone heard: the times of the impacts."""
    motion = draw_drop(
        height_mm=310, restitution=0.55, max_bounces=6, drag_per_m=DRAG_PER_M
    )
    path.mkdir(parents=True, exist_ok=True)
    times = np.array([b["t_s"] for b in motion.truth["bounces"]]) + rng.normal(
        0, 5e-5, len(motion.truth["bounces"])
    )
    pd.DataFrame({"t_s": times}).to_csv(
        path / "impacts.csv", index=False, float_format="%.6f"
    )
    write_recording(_recording(path, "drop", "impacts.csv", drop=Drop(height_mm=310.0)))
    return [
        row
        for row in _drop_truth(motion)
        if row[0] in ("restitution_normal", "impact_speed")
    ]


def slide_track(path: Path, rng: np.random.Generator):
    """Four taped seeds on a tilting plate, with the plate's angle."""
    motion = draw_slide(static=0.34, kinetic=0.30, tilt_rate_deg_s=2.0, start_deg=12.0)
    track = film_track(
        motion, rng, fps=240.0, noise_mm=0.05, ar=0.5, tilt_noise_deg=0.02
    )
    slide = Slide(tilt_rate_deg_s=2.0, travel_mm=80.0)
    camera = Camera(fps=240.0, mm_per_px=0.3, mm_per_px_sd=0.0003)
    _write_track(
        _recording(
            path, "slide", "track.csv", camera=camera, slide=slide, seed=Seed(count=4)
        ),
        track,
    )
    units = {"slide_angle": "deg", "static_friction": "1", "kinetic_friction": "1"}
    return [(name, motion.truth[name], unit) for name, unit in units.items()]


def roll_video(path: Path, rng: np.random.Generator):
    """One seed that rolls off a 15° incline and runs out, filmed at 120 fps."""
    motion = draw_roll(rolling=0.0115)
    look = Look(
        width=640,
        height=120,
        mm_per_px=0.5,
        origin_px=(60.0, 80.0),
        noise=1.0,
        shading=0.1,
        axes_mm=(7.4, 6.8),
    )
    camera = Camera(fps=120.0, mm_per_px=0.5, mm_per_px_sd=0.0005)
    roll = Roll(incline_deg=15.0, incline_length_mm=10.0, direction="+x")
    write_video(
        _recording(path, "roll", "video", camera=camera, roll=roll),
        film_roll(motion, look, rng, fps=120.0),
        fps=30.0,
    )
    run_out = motion.truth["run_out"] + corner_mm(look)
    return [("run_out", run_out, "mm")]


def pile_box(path: Path, rng: np.random.Generator):
    """Box extraction: one slope against the box wall, polished plate, stray seeds."""
    scene = PileScene(
        angle_deg=31,
        sides="right",
        size=(1800, 1200),
        pile_height=560,
        grain_px=26,
        wall_tone=(120, 124, 128),
        mirror=0.35,
        strays=5,
        pile_tone=(200, 172, 108),
        ground_tone=(34, 40, 52),
        plate_tone=(92, 95, 100),
        light=0.1,
        noise=0.01,
        roll_deg=0.6,
    )
    return _photo(path, scene, rng)


def pile_heap(path: Path, rng: np.random.Generator):
    """A lifted-cylinder heap, dark seeds before a light wall."""
    scene = PileScene(
        angle_deg=27,
        size=(1800, 1100),
        pile_height=360,
        grain_px=18,
        pile_tone=(92, 62, 40),
        ground_tone=(214, 216, 210),
        plate_tone=(150, 150, 148),
        light=0.12,
        light_direction_deg=70,
        noise=0.01,
        roll_deg=-0.9,
    )
    return _photo(path, scene, rng)


def _photo(path: Path, scene: PileScene, rng: np.random.Generator):
    path.mkdir(parents=True, exist_ok=True)
    Image.fromarray(draw_pile(scene, rng)).save(path / "photo.jpg", quality=88)
    write_recording(_recording(path, "pile", "photos"))
    return [("repose_angle", scene.angle_deg, "deg")]


def _write_track(recording: Recording, track) -> None:
    recording.path.mkdir(parents=True, exist_ok=True)
    table = track.to_table()
    columns = [
        c
        for c in ("t_s", "x_mm", "y_mm", "angle_deg", "sd_mm", "tilt_deg")
        if c in table and table[c].notna().any()
    ]
    table[columns].to_csv(
        recording.path / "track.csv", index=False, float_format="%.6g"
    )
    write_recording(recording)


RECORDINGS = {
    "drop-frames": drop_frames,
    "drop-phone": drop_phone,
    "drop-track": drop_track,
    "drop-heard": drop_heard,
    "slide-track": slide_track,
    "roll-video": roll_video,
    "pile-box": pile_box,
    "pile-heap": pile_heap,
}

if __name__ == "__main__":
    target = (
        Path(sys.argv[1])
        if len(sys.argv) > 1
        else Path(__file__).parent / "drawn-bench"
    )
    print(draw_bench(target).to_string(index=False))
