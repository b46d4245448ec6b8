"""The tracker on drawn films: centroids, their claimed sds, and which of several moving
things is the seed."""

import numpy as np
import pytest
from drawn_frames import Drawn
from synthetic.film import Look, draw_frame, draw_scene, film, to_picture
from synthetic.motion import draw_drop

from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.motion.detect import find_silhouettes
from benchtwin.vision.motion.scene import learn_scene
from benchtwin.vision.motion.track_seed import _fall_height, track_seed

MOTION = draw_drop(
    height_mm=180, spin_rad_s=20, lateral_m_s=0.05, kicks=((0.02, -10),), end_s=0.75
)


def falling(look: Look, count=60, seed=1):
    """Frames at random sub-pixel places during a fall, and where the seed is in
    them."""
    rng = np.random.default_rng(seed)
    times = np.sort(rng.uniform(0.03, 0.2, count))
    columns, rows = to_picture(look, *MOTION.path(times)[:2])
    return (
        list(film(MOTION, look, rng, fps=1, times=times)),
        columns,
        rows,
        MOTION.path(times)[2],
    )


def errors(look: Look, **options):
    frames, columns, rows, angles = falling(look, **options)
    scene = learn_scene(Drawn(frames, fps=1000))
    found = [
        min(
            find_silhouettes(f, scene),
            key=lambda s, c=c, r=r: np.hypot(s.x - c, s.y - r),
        )
        for f, c, r in zip(frames, columns, rows)
    ]
    off = np.array([(s.x - c, s.y - r) for s, c, r in zip(found, columns, rows)])
    return off, np.array([s.sd for s in found]), found, (columns, rows, angles)


def rms(values) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


@pytest.mark.parametrize(
    ("look", "limit"),
    [
        (Look(), 0.05),
        (Look(noise=12.5), 0.10),  # noise/signal 0.1
        (Look(graph_paper=True, ground_grey=110, shading=0.1, noise=3), 0.05),
        (Look(seed_grey=60, ground_grey=190, graph_paper=True, noise=3), 0.05),
        (Look(bits=16, noise=2), 0.05),
        (Look(colour=True, noise=3), 0.05),
        (Look(mm_per_px=1.0, noise=3), 0.05),
        (Look(blur_px=1.5, noise=3), 0.05),
    ],
)
def test_centroids(look, limit):
    off, *_ = errors(look)
    assert rms(off) < limit
    assert np.abs(off.mean(axis=0)).max() < 0.5 * limit


def test_no_pixel_lock():
    """First harmonic of the error in the sub-pixel place below 0.02 px; whole-pixel
    centroids (control) show it."""
    off, _, _, (columns, rows, _) = errors(Look(noise=2), count=120)
    phase = np.concatenate([columns, rows]) % 1
    wave = np.column_stack(
        [np.cos(2 * np.pi * phase), np.sin(2 * np.pi * phase), np.ones(len(phase))]
    )

    def lock(error):
        return np.hypot(*np.linalg.lstsq(wave, error, rcond=None)[0][:2])

    assert lock(off.T.ravel()) < 0.02
    whole = np.concatenate([np.round(columns) - columns, np.round(rows) - rows])
    assert lock(whole) > 0.1


@pytest.mark.parametrize("noise", [4.0, 12.5])
def test_claimed_sds_are_honest(noise):
    off, sd, *_ = errors(Look(noise=noise), count=120)
    assert 0.75 < rms(off) / rms(sd) < 1.3


def test_a_raw_threshold_centroid_would_be_pulled_by_the_graph_paper():
    """Control for the coverage: brightness-weighted centroid over the same window,
    shaded seed before graph paper."""
    look = Look(graph_paper=True, ground_grey=110, shading=0.25, noise=2, seed_grey=170)
    frames, columns, rows, _ = falling(look)
    scene = learn_scene(Drawn(frames, fps=1000))
    plain = []
    for frame, column, row in zip(frames, columns, rows):
        x, y = round(column) - 15, round(row) - 15
        weight = np.abs(
            frame[y : y + 31, x : x + 31].astype(float)
            - scene.grey_background[y : y + 31, x : x + 31]
        )
        weight[weight < 15] = 0
        v, u = np.mgrid[:31, :31]
        plain.append(
            (
                (weight * u).sum() / weight.sum() + x - column,
                (weight * v).sum() / weight.sum() + y - row,
            )
        )
    off, *_ = errors(look)
    assert rms(plain) > 3 * rms(off)


def test_orientation_follows_the_spin():
    _, _, found, (_, _, angles) = errors(Look(noise=3))
    read = np.array(
        [0.5 * np.degrees(np.arctan2(-2 * s.xy, s.xx - s.yy)) for s in found]
    )
    off = (read - angles + 90) % 180 - 90
    sd = np.array([s.angle_sd_deg for s in found])
    assert rms(off) < 1.0 and 0.6 < rms(off) / rms(sd) < 1.6


HARD = {
    "clutter": 8.0,
    "graph_paper": True,
    "shading": 0.1,
    "noise": 4.0,
    "plate_row": 440.0,
    "mirror": 0.5,
    "shadow": 25.0,
    "clamp": True,
    "hand": True,
    "drift": 0.1,
    "ground_grey": 110.0,
}


@pytest.fixture(scope="module")
def hard():
    look = Look(**HARD)
    frames = list(film(MOTION, look, np.random.default_rng(1), fps=400))
    return look, track_seed(Drawn(frames, fps=400), falling=True)


def test_the_seed_is_told_from_hand_clamp_shadow_and_mirror_image(hard):
    look, followed = hard
    track = followed.track
    columns, rows = to_picture(look, *MOTION.path(track.t_s)[:2])
    good = ~track.outlier
    assert good.sum() > 250
    assert np.abs(track.x - columns)[good].max() < 1.5
    assert (
        rms((track.x - columns)[good]) < 0.15
        and rms((track.y - (look.height - 1 - rows))[good]) < 0.15
    )


def test_the_spin_comes_through_the_bounce(hard):
    _, followed = hard
    track = followed.track
    truth = MOTION.path(track.t_s)[2]
    flying = (
        (track.t_s > 0.05)
        & (track.t_s < 0.4)
        & np.isfinite(track.angle_deg)
        & ~track.outlier
    )
    assert np.median(np.abs(track.angle_deg - truth)[flying]) < 3


def test_a_seed_half_out_of_the_picture_is_marked():
    look = Look(origin_px=(320.0, 500.0), noise=2)  # the plate lies below the picture
    frames = list(film(MOTION, look, np.random.default_rng(1), fps=200))
    track = track_seed(Drawn(frames, fps=200), falling=True).track
    rows = to_picture(look, *MOTION.path(track.t_s)[:2])[1]
    outside = rows > look.height - 6
    assert outside.any() and track.outlier[outside].all()
    inside = rows < look.height - 12
    assert track.outlier[inside].mean() < 0.05


def test_frames_without_a_seed_are_left_out():
    look = Look(noise=2)
    frames = list(film(MOTION, look, np.random.default_rng(1), fps=200))
    lost = [30, 31, 60]
    empty = np.median(np.stack(frames[10:60:5]), axis=0).astype(np.uint8)
    for n in lost:
        frames[n] = empty
    track = track_seed(Drawn(frames, fps=200), falling=True).track
    assert not set(lost) & set(track.frame)
    assert len(track) >= len(frames) - len(lost) - 5
    assert any("found in" in note for note in track.notes)


def behind_shelves(shelves: list[tuple[int, int]], count: int = 170):
    """A dark drop before a light wall, not to be seen before shelves as dark, at 120
    frames a second; frames, and where the seed is in them."""
    look = Look(seed_grey=45, ground_grey=150, noise=2.0, plate_row=447)
    motion = draw_drop(
        height_mm=180, restitution=0.8, rest_s=0.2, end_s=1.5, lateral_m_s=0.05
    )
    rng, times = np.random.default_rng(0), np.arange(count) / 120
    scene = draw_scene(look, rng)
    for top, bottom in shelves:
        scene[top:bottom] = look.seed_grey
    frames = [
        draw_frame(motion, look, rng, scene, float(t), n / count)
        for n, t in enumerate(times)
    ]
    return frames, *to_picture(look, *motion.path(times)[:2])


def test_a_seed_that_is_lost_before_a_dark_shelf_is_found_again():
    """The gaps hold bounces; the frames named are those around the longest ones."""
    frames, columns, rows = behind_shelves([(230, 300)])
    track = track_seed(Drawn(frames, fps=120), falling=True).track
    gaps = np.flatnonzero(np.diff(track.frame) > 7)
    assert len(gaps) and track.frame[-1] > 160
    used = track.used()
    off = (used.x - columns[used.frame], 479 - used.y - rows[used.frame])
    assert np.hypot(*off).max() < 2
    (said,) = [n for n in track.notes if "found in" in n]
    for k in gaps:
        lost, again = track.frame[k] + 1, track.frame[k + 1]
        assert f"lost at frame {lost}, found again at {again}" in said


def test_a_seed_that_is_lost_for_good_is_said_to_be():
    frames, _, rows = behind_shelves([(300, 447)])
    last = int(np.flatnonzero(rows < 290)[-1])
    frames = [*frames[: last + 1], *[frames[-1]] * 40]
    track = track_seed(Drawn(frames, fps=120), falling=True).track
    assert abs(track.frame[-1] - last) < 3
    said = f"lost at frame {track.frame[-1] + 1} and not found again"
    assert any(said in n for n in track.notes)


def test_a_picture_in_which_nothing_moves_is_an_error():
    rng = np.random.default_rng(0)
    frames = [
        np.clip(90 + 4 * rng.standard_normal((240, 320)), 0, 255).astype(np.uint8)
        for _ in range(20)
    ]
    with pytest.raises(MeasurementError, match="nothing moves like a seed"):
        track_seed(Drawn(frames, fps=100), falling=True)


def test_a_seed_that_rests_for_most_of_the_film_is_not_background():
    look = Look(noise=2)
    times = np.concatenate(
        [np.zeros(50), np.arange(0.02, 0.5, 0.01), np.full(115, 0.75)]
    )
    frames = list(film(MOTION, look, np.random.default_rng(1), fps=1, times=times))
    scene = learn_scene(Drawn(frames, times=np.arange(len(times)) / 200))
    for time in (0.0, 0.75):
        column, row = (
            int(v[0]) for v in to_picture(look, *MOTION.path(np.array([time]))[:2])
        )
        assert scene.grey_background[row, column] == pytest.approx(
            look.ground_grey, abs=6
        )
    assert (
        np.median(np.stack(frames), axis=0)[row, column] > 150
    )  # control: the plain median shows the seed


def test_a_seed_at_rest_to_the_sub_pixel_falls_no_way():
    frames, y = np.arange(40.0), np.full(40, 200.0)
    y[20:] = 200 - 2.0 * np.arange(20)
    assert _fall_height(frames[:20], y[:20]) == 0.0
    assert _fall_height(frames, y) >= 0.0
