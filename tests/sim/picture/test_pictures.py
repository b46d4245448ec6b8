"""Photos and films: what stays untouched, what is refused, contexts that close, and
that the measuring code reads them."""

import multiprocessing
import os
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from picture_scenes import SOYBEAN, drop, heap, slide, still

from benchtwin.sim.picture import (
    Camera,
    Look,
    context,
    coverage,
    exposure,
    film,
    photo,
    project,
)
from benchtwin.sim.picture.camera import view
from benchtwin.vision.measurement import GOOD
from benchtwin.vision.pile.repose import measure_repose

SMALL = Camera(160, 120, mm_per_px=1.0, target_m=(0.0, 0.0, 0.04))
BESIDE = Camera(320, 200, mm_per_px=1.0, target_m=(0.0, 0.0, 0.09))

render = pytest.mark.usefixtures("egl")


@render
def test_nothing_changes_where_nothing_moves():
    """Every frame of a film equals the empty scene outside the seed's box, to the bit,
    and the photo of its moment inside."""
    motion, look = drop(4, fps=50.0), Look(grey=True, texture=6.0)
    gone = replace(
        motion,
        positions_m=motion.positions_m
        * np.array([[[np.nan]], [[1.0]], [[1.0]], [[1.0]]]),
    )
    frames = list(film(gone, BESIDE, look))
    empty = frames[0]
    assert empty.shape == (200, 320) and empty.dtype == np.uint8
    for frame in (1, 2, 3):
        column, row = project(BESIDE, motion.positions_m[frame])[0]
        rows, columns = np.indices(empty.shape)
        near = np.hypot(columns - column, rows - row) < 12
        assert (frames[frame] == empty)[~near].all()
        assert (frames[frame] != empty)[near].sum() > 20
        assert (
            np.abs(
                frames[frame].astype(int) - photo(motion, BESIDE, look, frame=frame)
            ).max()
            <= 1
        )


@render
def test_a_plate_that_moves_is_drawn_anew():
    motion = slide(3, fps=5.0)
    camera = Camera(320, 200, mm_per_px=1.0, target_m=(0.12, 0.0, 0.06))
    frames = list(film(motion, camera))
    for number, frame in enumerate(frames):
        assert (
            np.abs(frame.astype(int) - photo(motion, camera, frame=number)).max() <= 1
        )
    assert np.abs(frames[0].astype(int) - frames[2]).max() > 50


@render
def test_noise_comes_from_the_rng_alone_and_is_as_strong_as_stated():
    motion, look = heap(20), Look(noise=3.0, background=(90, 90, 90))
    with pytest.raises(ValueError, match="noise = 3 levels needs rng"):
        photo(motion, SMALL, look)
    one, same = (
        photo(motion, SMALL, look, rng=np.random.default_rng(5)) for _ in range(2)
    )
    assert (one == same).all()
    assert one[:20].std() == pytest.approx(3.0, rel=0.05)


@render
def test_tiles_leave_no_seams(monkeypatch):
    motion = heap(60)
    for camera in (SMALL, replace(SMALL, distortion=-0.05, roll_deg=3.0)):
        whole = photo(motion, camera)
        monkeypatch.setattr(exposure, "TILE_PX", 4 * 160 * 17)
        tiled = photo(motion, camera)
        monkeypatch.undo()
        assert np.abs(whole.astype(int) - tiled).max() <= 2


@render
def test_a_camera_that_sees_no_seed_is_told():
    with pytest.raises(
        ValueError,
        match="the camera does not see any of the 20 seeds: their middle is at column",
    ):
        photo(heap(20), replace(SMALL, target_m=(2.0, 0.0, 0.0)))
    with pytest.raises(ValueError, match="does not see any of the 1 seeds"):
        next(film(drop(3, start_s=0.18), replace(SMALL, target_m=(0.0, 0.0, -1.0))))
    with pytest.raises(ValueError, match="all have left the rig"):
        photo(still([np.nan] * 3, [1, 0, 0, 0]), SMALL)


@pytest.mark.parametrize(
    "wrong",
    [
        dict(noise=-1.0),
        dict(ambient=1.5),
        dict(seed=(300, 0, 0)),
        dict(light=(0, 0, 0)),
        dict(blur_px=np.nan),
    ],
)
def test_wrong_looks_are_named(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        Look(**wrong)


@render
def test_seeds_that_left_are_not_drawn():
    there = still([[0, 0, 0.02], [0.03, 0, 0.02]], [[1, 0, 0, 0]] * 2)
    left = replace(there, positions_m=there.positions_m * np.array([[[1.0], [np.nan]]]))
    assert coverage(left, SMALL).sum() == pytest.approx(
        coverage(there, SMALL).sum() / 2, rel=0.02
    )


@render
def test_contexts_close():
    """Neither memory nor files nor threads grow over many photos; measured 0.5 MB over
    40."""

    def held():
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        files, threads = (
            len(list(Path(f"/proc/self/{kind}").iterdir())) for kind in ("fd", "task")
        )
        return pages * os.sysconf("SC_PAGE_SIZE") / 1e6, files, threads

    motion = heap(20)
    for _ in range(5):
        photo(motion, SMALL)
    memory, files, threads = held()
    for _ in range(20):
        photo(motion, SMALL)
    later = held()
    assert later[0] - memory < 8.0  # one context holds about 10 MB of buffers
    assert later[1:] == (files, threads)
    assert not any(context._open.values())


def _photo_of(motion):
    return photo(motion, SMALL)


@render
def test_threads_processes_and_films_side_by_side():
    motion = heap(20)
    reference = photo(motion, SMALL)
    first, second = (
        film(drop(3, start_s=0.18), BESIDE),
        film(drop(3, start_s=0.18), BESIDE),
    )
    next(first), next(second)
    first.close()  # must not take the second's display away
    assert len(list(second)) == 2
    with ThreadPoolExecutor(3) as pool:
        assert all(
            (image == reference).all() for image in pool.map(_photo_of, [motion] * 6)
        )
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("fork")) as pool:
        assert all(
            (image == reference).all()
            for image in pool.map(_photo_of, [motion] * 2, timeout=60)
        )


def _refused(motion):
    try:
        photo(motion, SMALL)
    except context.RenderingUnavailable as error:
        return str(error)


@render
def test_a_process_forked_in_the_middle_of_a_film_is_told_instead_of_hanging():
    running = film(drop(3, start_s=0.18), BESIDE)
    next(running)
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("fork")) as pool:
        assert "was forked while process" in pool.submit(_refused, heap(20)).result(
            timeout=60
        )
    assert len(list(running)) == 2


def test_missing_egl_names_the_packages(monkeypatch):
    """The same packages as the script that installs them, in one sentence, whatever
    went wrong beneath."""

    def absent():
        raise ImportError("Unable to load EGL library")

    monkeypatch.setattr(context, "_pyrender", absent)
    with pytest.raises(
        context.RenderingUnavailable,
        match=f"no EGL .*Unable to load EGL.*{context.EGL_PACKAGES}",
    ):
        photo(heap(20), SMALL)
    script = Path(__file__).parents[3] / "scripts" / "system-packages.sh"
    assert f'packages="{context.EGL_PACKAGES}"' in script.read_text(encoding="utf8")


def test_importing_pictures_does_not_import_pyrender():
    """Measuring and simulating must not pay for it, or need it."""
    code = (
        "import sys, benchtwin.sim.picture;"
        " print(any(m in sys.modules for m in ('pyrender', 'OpenGL')))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "False"


def true_surface(motion, camera):
    """The row of the highest ball over every column, from the balls' outlines (circles,
    so far away): (width,), NaN: none."""
    from benchtwin.sim.picture.pose import matrices

    pose = matrices(motion.positions_m[-1], motion.orientations[-1])
    balls = (
        np.einsum("nij,kj->nki", pose[:, :3, :3], SOYBEAN.centres_m)
        + pose[:, None, :3, 3]
    ).reshape(-1, 3)
    radii = (
        np.tile(SOYBEAN.radii_m, motion.seeds)
        * camera.focal_px
        / (camera.distance_m + view(camera, balls)[:, 2])
    )
    top = np.full(camera.width_px, np.nan)
    for (column, row), radius in zip(project(camera, balls), radii):
        x = np.arange(
            max(0, int(np.ceil(column - radius))),
            min(camera.width_px, int(column + radius) + 1),
        )
        top[x] = np.fmin(
            top[x], row - np.sqrt(np.maximum(radius**2 - (x - column) ** 2, 0.0))
        )
    return top


@render
@pytest.mark.parametrize(
    "look", [Look(noise=2.0), Look(noise=2.0, texture=3.0, background=(30, 62, 48))]
)
def test_a_heap_measures_as_what_it_is(look):
    """The measuring code calls the photo good, and its surface and angle are those of
    the balls.

    Measured: 0.20 to 0.22 px low (edges of seeds are darker than their middle), the
    angle within 0.03°."""
    motion = heap(3500, 30.0)
    camera = Camera(
        1100, 500, mm_per_px=0.24, target_m=(0.0, 0.0, 0.04), distance_m=5.0
    )
    found = measure_repose(photo(motion, camera, look, rng=np.random.default_rng(0)))
    angle = next(q for q in found.quantities if q.name == "repose_angle")
    assert angle.quality == GOOD, angle.reason
    truth = true_surface(motion, camera)
    for slope in found.slopes:
        x = np.arange(int(slope.line.x_low), int(slope.line.x_high) + 1)
        x = x[np.isfinite(found.surface[x])]
        assert x.size > 0.9 * (slope.line.x_high - slope.line.x_low)
        assert abs(np.median(found.surface[x] - truth[x])) < 0.4
        lines = [np.polyfit(x, rows[x], 1)[0] for rows in (found.surface, truth)]
        assert np.diff(np.degrees(np.arctan(lines)))[0] == pytest.approx(0.0, abs=0.1)


@render
def test_a_falling_seed_is_tracked_where_it_is(tmp_path):
    """The measuring code's centroids on a noisy film of a turning seed: measured 0.01
    px rms off the projected centre."""
    from synthetic.film import write_frames

    from benchtwin.measure.observe import observe
    from benchtwin.vision.recording import Camera as Stated
    from benchtwin.vision.recording import Recording

    camera = Camera(
        400, 560, mm_per_px=0.25, target_m=(0.0, 0.0, 0.09), exposure_s=2e-5
    )
    motion = drop(60, start_s=0.16)
    frames = film(
        motion, camera, Look(grey=True, noise=1.0), rng=np.random.default_rng(0)
    )
    track = observe(
        write_frames(
            Recording(
                "drop", tmp_path, "drop", "frames", (), camera=Stated(mm_per_px=0.25)
            ),
            frames,
        )
    ).track
    track = track[track.outlier == 0]
    assert len(track) > 30
    seen = project(camera, motion.positions_m[track.frame, 0])
    off = np.c_[track.x_mm / 0.25, (camera.height_px - 1) - track.y_mm / 0.25] - seen
    assert np.sqrt((off**2).mean(axis=0)).max() < 0.03


def test_a_seed_that_is_not_there_keeps_its_nan_and_moves_no_other():
    from benchtwin.sim.picture.pose import poses_at

    motion = still([[0, 0, 0.01], [np.nan] * 3], [[1, 0, 0, 0], [np.nan] * 4])
    places, turns = poses_at(motion, 0, 1e-3)
    assert np.isnan(places[1]).all() and np.isnan(turns[1]).all()
    assert np.array_equal(places[0], [0, 0, 0.01]) and np.array_equal(
        turns[0], [1, 0, 0, 0]
    )
