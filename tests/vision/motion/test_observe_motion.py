"""Recordings on disk → Observation: frames, videos, tracks and impact times of drop,
slide and roll."""

from dataclasses import replace

import numpy as np
import pytest
from synthetic.film import Look, film, to_picture, write_frames, write_video
from synthetic.motion import draw_drop, draw_roll, draw_slide, film_track
from synthetic.rigs_film import corner_mm, film_roll, film_slide

from benchtwin.measure.observe import observe
from benchtwin.rigs.drop.keys import Drop
from benchtwin.rigs.roll.keys import Roll
from benchtwin.rigs.slide.keys import Slide as SlideKeys
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.overlay.plot import plot
from benchtwin.vision.overlay.track import BAD, CROSS, on_picture
from benchtwin.vision.recording import (
    Air,
    Camera,
    Recording,
    read_recording,
    write_recording,
)

DROP = draw_drop(
    height_mm=180, spin_rad_s=20, lateral_m_s=0.05, kicks=((0.02, -10),), end_s=0.6
)
FASTER = ((60, 0.004), (120, 0.0))  # frames/s, exposure [s]


def recording(folder, rig, **keys) -> Recording:
    keys.setdefault("air", Air(density_kg_m3=0))
    return Recording(
        f"drawn-{rig}", folder, rig, "frames", (), provenance="simulated", **keys
    )


def named(observation):
    return {q.name: q for q in observation.quantities}


def write_track(folder, track, rig, **keys) -> Recording:
    known = recording(folder, rig, **keys)
    write_recording(known)
    track.to_table().to_csv(folder / "track.csv", index=False)
    return read_recording(folder)


def test_a_drop_in_frames(tmp_path):
    known = recording(
        tmp_path,
        "drop",
        camera=Camera(fps=240, mm_per_px=0.5, mm_per_px_sd=5e-4),
        drop=Drop(height_mm=180),
    )
    look = Look(noise=4, clutter=6, clamp=True, plate_row=440, mirror=0.4)
    made = write_frames(known, film(DROP, look, np.random.default_rng(1), fps=240))
    shares = []
    seen = observe(read_recording(made.path), progress=shares.append)
    for name, q in named(seen).items():
        truth = 0.5 if name.startswith("restitution") else DROP.truth[name]
        assert abs(q.value - truth) < 3 * q.sd and q.quality == "good", name
    assert shares[-1] == 1.0 and np.all(np.diff(shares) >= 0)
    assert {"x_mm", "y_mm", "sd_mm", "t_s", "angle_deg", "outlier"} <= set(
        seen.track.columns
    )
    assert list(seen.bounces.bounce) == list(range(1, len(seen.bounces) + 1))
    assert next(iter(seen.pictures)) == "track"
    assert all(
        p.dtype == np.uint8 and p.ndim == 3 and p.shape[1] <= 1600
        for p in seen.pictures.values()
    )
    # Crosses sit on the seed: where the track says, drawn pixels of the cross' colour.
    columns, rows = to_picture(look, *DROP.path(np.array([0.1]))[:2])
    zoom = seen.pictures["track"].shape[1] / look.width
    row, column = int(rows[0] * zoom), int(columns[0] * zoom)
    around = seen.pictures["track"][
        row - 12 : row + 13, column - 8 : column + 9
    ].astype(int)
    assert (np.abs(around - np.array(CROSS)).max(axis=2) < 60).any()


@pytest.mark.parametrize(
    "fps, exposure",
    [(30, 0.002), *(pytest.param(*o, marks=pytest.mark.slow) for o in FASTER)],
)
def test_a_phone_video_of_a_drop(tmp_path, fps, exposure):
    look = Look(
        exposure_s=exposure, noise=3, plate_row=440, mirror=0.3, hand=True, colour=True
    )
    known = recording(
        tmp_path, "drop", camera=Camera(mm_per_px=0.5), drop=Drop(height_mm=180)
    )
    made = write_video(
        known, film(DROP, look, np.random.default_rng(2), fps=fps), fps=fps
    )
    found = named(observe(read_recording(made.path)))
    assert abs(found["restitution_normal"].value - 0.5) < max(
        3 * found["restitution_normal"].sd, 0.004
    )
    assert abs(found["rebound_height"].value - 45) < max(
        4 * found["rebound_height"].sd, 0.3
    )


def test_a_slide_in_frames(tmp_path):
    motion = draw_slide(start_deg=17.5, travel_mm=70)
    known = recording(
        tmp_path,
        "slide",
        camera=Camera(fps=60, mm_per_px=0.4, mm_per_px_sd=4e-4, plumb_sd_deg=0.03),
    )
    made = write_frames(
        known,
        film_slide(
            motion,
            Look(mm_per_px=0.4, noise=3, clutter=3),
            np.random.default_rng(2),
            fps=60,
        ),
    )
    for name, q in named(observe(read_recording(made.path))).items():
        assert abs(q.value - motion.truth[name]) < 4 * q.sd, name
        assert q.quality == "good" and q.sd < 0.01 * max(q.value, 5), name
    unplumbed = replace(
        read_recording(made.path),
        camera=Camera(fps=60, mm_per_px=0.4, mm_per_px_sd=4e-4),
    )
    seen = observe(unplumbed)
    assert named(seen)["slide_angle"].sd > 0.9 and any(
        "plumb_deg is missing" in note for note in seen.notes
    )


@pytest.mark.parametrize(
    "seed_grey, plate_grey, noise",
    [pytest.param(170, 104, 0.0, marks=pytest.mark.slow), (104, 150, 2.0)],
)
def test_a_slide_of_beans_filmed_from_the_level_on(
    tmp_path, seed_grey, plate_grey, noise
):
    """A clean dark ground, a plate seen a little from above, a block whose light
    changes, which rests for 95 % of the film."""
    motion = draw_slide(
        start_deg=0.0, tilt_rate_deg_s=3.0, static=0.36, kinetic=0.26, travel_mm=80
    )
    known = recording(
        tmp_path,
        "slide",
        camera=Camera(fps=20, mm_per_px=0.5, mm_per_px_sd=5e-4, plumb_sd_deg=0.03),
    )
    look = Look(
        width=480,
        height=260,
        mm_per_px=0.5,
        ground_grey=37,
        seed_grey=seed_grey,
        noise=noise,
    )
    film = film_slide(
        motion,
        look,
        np.random.default_rng(4),
        fps=20,
        pivot_px=(30.0, 225.0),
        plate_grey=plate_grey,
        block_mm=(17.4, 6.8),
        beans=True,
        from_above_deg=0.6,
        fades=0.5,
    )
    seen = observe(read_recording(write_frames(known, film).path))
    frames = int(np.ceil(motion.end_s * 20))
    assert len(seen.track) - seen.track.outlier.sum() > 0.97 * frames
    assert np.abs(seen.track.tilt_deg - motion.tilt(seen.track.t_s)).max() < 0.1
    for name, q in named(seen).items():
        assert abs(q.value - motion.truth[name]) < 4 * q.sd and q.quality == "good", (
            name
        )
    assert abs(named(seen)["slide_angle"].value - motion.truth["slide_angle"]) < 0.1


def test_a_roll_in_frames(tmp_path):
    look = Look(
        mm_per_px=0.4,
        width=800,
        height=300,
        noise=3,
        origin_px=(110.0, 240.0),
        clutter=4,
    )
    motion = draw_roll(incline_mm=30, rolling=0.06, end_rest_s=0.5)
    known = recording(
        tmp_path,
        "roll",
        camera=Camera(fps=60, mm_per_px=0.4, mm_per_px_sd=4e-4),
        roll=Roll(incline_deg=15, incline_length_mm=30),
    )
    made = write_frames(
        known, film_roll(motion, look, np.random.default_rng(2), fps=60)
    )
    seen = observe(read_recording(made.path))
    found = named(seen)
    assert (
        abs(found["run_out"].value - motion.truth["run_out"] - corner_mm(look))
        < 3 * found["run_out"].sd
        < 2
    )
    assert found["rolling_friction"].value == pytest.approx(0.06, rel=0.02)
    assert any("legs meet at an angle of 1" in note for note in seen.notes)


def test_pictures_without_a_scale_give_ratios_in_pixels(tmp_path):
    made = write_frames(
        recording(tmp_path, "drop"),
        film(DROP, Look(noise=3), np.random.default_rng(1), fps=200),
    )
    found = named(observe(read_recording(made.path)))
    assert (
        found["rebound_height"].unit == "px"
        and found["impact_speed"].unit == "px/frame"
    )
    assert found["restitution"].value == pytest.approx(0.5, abs=0.002)


def test_tracks_of_all_rigs(tmp_path):
    rng = np.random.default_rng(0)
    camera = Camera(fps=1000, mm_per_px=0.25, mm_per_px_sd=2e-4)
    slide = draw_slide()
    cases = {
        "drop": (DROP, film_track(DROP, rng, fps=1000), {"drop": Drop(height_mm=180)}),
        "slide": (slide, film_track(slide, rng, fps=100, start_s=1.0), {}),
        "roll": (
            draw_roll(),
            film_track(draw_roll(), rng, fps=200),
            {"roll": Roll(incline_deg=15, incline_length_mm=10)},
        ),
    }
    for rig, (motion, track, keys) in cases.items():
        folder = tmp_path / rig
        folder.mkdir()
        seen = observe(write_track(folder, track, rig, camera=camera, **keys))
        for name, q in named(seen).items():
            truth = 0.5 if name == "restitution" else motion.truth[name]
            assert abs(q.value - truth) < 4 * q.sd, (rig, name)
        assert len(seen.track) == len(track) and seen.pictures


def test_impacts(tmp_path):
    write_recording(recording(tmp_path, "drop", drop=Drop(height_mm=310)))
    (tmp_path / "impacts.csv").write_text("t_s\n0.2514\n0.5029\n0.6286\n0.6915\n")
    seen = observe(read_recording(tmp_path))
    assert named(seen)["restitution"].value == pytest.approx(0.5, abs=0.002)
    assert seen.track is None and len(seen.bounces) == 3


@pytest.mark.parametrize(
    ("rig", "content", "says"),
    [
        ("drop", "t_s,x_mm,y_mm\n0,0,0\n1,1,one\n2,2,2\n", "'one' in row 3"),
        ("drop", "", "empty"),
    ],
)
def test_bad_tracks_name_the_file(tmp_path, rig, content, says):
    write_recording(recording(tmp_path, rig))
    (tmp_path / "track.csv").write_text(content)
    with pytest.raises(MeasurementError, match=says):
        observe(read_recording(tmp_path))


@pytest.mark.parametrize("rig", ["drop", "slide", "roll"])
def test_a_track_in_which_nothing_happens_fails_in_words(tmp_path, rig):
    rows = "\n".join(f"{n / 100},5,5" for n in range(50))
    write_recording(recording(tmp_path, rig, slide=SlideKeys(tilt_rate_deg_s=2)))
    (tmp_path / "track.csv").write_text(f"t_s,x_mm,y_mm\n{rows}\n")
    seen = observe(read_recording(tmp_path))
    assert all(q.quality == "failed" and q.reason for q in seen.quantities)
    assert seen.pictures


def test_a_damaged_frame_costs_one_row(tmp_path):
    known = recording(tmp_path, "drop", camera=Camera(fps=200, mm_per_px=0.5))
    made = write_frames(
        known, film(DROP, Look(noise=3), np.random.default_rng(1), fps=200)
    )
    made.files[30].write_bytes(made.files[30].read_bytes()[:500])
    seen = observe(read_recording(tmp_path))
    assert 30 not in set(seen.track.frame) and any(
        "frame 30 skipped" in note for note in seen.notes
    )
    assert named(seen)["restitution_normal"].value == pytest.approx(0.5, abs=0.003)


def test_impact_times_of_a_slide_are_refused(tmp_path):
    write_recording(replace(recording(tmp_path, "slide")))
    (tmp_path / "impacts.csv").write_text("t_s\n0.2\n0.5\n")
    with pytest.raises(MeasurementError, match="belong to a drop"):
        observe(read_recording(tmp_path))


def test_overlays_draw_where_they_are_told():
    picture = np.full((300, 800), 90, np.uint8)
    drawn = on_picture(
        picture,
        np.array([400.0, 200.0]),
        np.array([150.0, 100.0]),
        np.array([False, True]),
    )
    assert np.abs(drawn[150, 400].astype(int) - CROSS).max() < 60
    assert np.abs(drawn[100, 200].astype(int) - BAD).max() < 60
    assert (drawn[200:, 500:] == 90).all()
    image = plot(
        np.arange(10),
        np.arange(10) ** 2,
        np.zeros(10, bool),
        labels=("t [s]", "h [mm]"),
        caption="é ± °",
    )
    assert image.shape == (620, 960, 3) and (image < 200).any()
