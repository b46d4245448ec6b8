"""Which way a seed falls in a picture, found from its flights."""

from dataclasses import replace

import numpy as np
import pytest
from drawn_frames import Drawn
from drops import drop, named
from synthetic.film import Look, film
from synthetic.motion import draw_drop, film_track

from benchtwin.rigs.drop.measure import measure_drop
from benchtwin.rigs.drop.observe import observe_drop
from benchtwin.rigs.drop.read import drops_of
from benchtwin.vision.motion.down import direction_of_fall, upright
from benchtwin.vision.motion.track import Track, make_track
from benchtwin.vision.motion.track_seed import track_seed


def turned(deg: float, noise_mm: float = 0.1, seed: int = 0) -> Track:
    """A drop from 400 mm, e 0.7, in a picture turned anticlockwise."""
    motion = draw_drop(
        height_mm=400, restitution=0.7, rest_s=0.2, end_s=1.4, lateral_m_s=0.05
    )
    track = film_track(motion, np.random.default_rng(seed), fps=240, noise_mm=noise_mm)
    c, s = np.cos(np.radians(deg)), np.sin(np.radians(deg))
    return replace(track, x=track.x * c - track.y * s, y=track.x * s + track.y * c)


def known():
    return drop(None, fps=240, mm_per_px=0.5)


@pytest.mark.parametrize("deg", [-90.0, -20.0, 0.0, 7.0, 90.0, 180.0])
@pytest.mark.parametrize("noise_mm", [0.1, 2.0])
def test_the_direction_is_that_of_the_flights(deg, noise_mm):
    track = turned(deg, noise_mm)
    fall = direction_of_fall(track.time, track.x, track.y)
    assert fall is not None
    assert abs((fall[0] + deg + 180) % 360 - 180) < 0.1 + noise_mm / 2


@pytest.mark.parametrize("deg", [90.0, -25.0, 180.0])
def test_a_turned_picture_is_said_and_measured(tmp_path, deg):
    track = turned(deg)
    rows = {"frame": track.frame, "x_px": 2 * track.x, "y_px": 2 * track.y}
    lines = [",".join(f"{v:.6g}" for v in row) for row in zip(*rows.values())]
    (tmp_path / "track.csv").write_text("\n".join([",".join(rows), *lines]))
    made = replace(known(), path=tmp_path, files=(tmp_path / "track.csv",))
    found = observe_drop(made)
    normal = named(found)["restitution_normal"]
    assert abs(normal.value - 0.7) < 3 * normal.sd < 0.01
    (said,) = [n for n in found.notes if "straight down in the picture" in n]
    assert f"falls {abs(deg):.1f}°" in said
    (seen,) = drops_of(track, known())  # a diagnosis reads it so, too
    assert said in seen.notes
    assert abs((seen.description["camera"]["plumb_deg"] + deg + 180) % 360 - 180) < 0.3


@pytest.mark.parametrize(
    "turns", [1, *(pytest.param(n, marks=pytest.mark.slow) for n in (2, 3))]
)
def test_a_film_that_lies_on_a_side_is_followed_and_measured(turns):
    motion = draw_drop(height_mm=180, restitution=0.7, rest_s=0.1, end_s=0.9)
    look = Look(seed_grey=205, noise=2.0, plate_row=447)
    frames = film(motion, look, np.random.default_rng(0), fps=240)
    turned = [np.ascontiguousarray(np.rot90(f, turns)) for f in frames]
    tracked = track_seed(Drawn(turned, fps=240), falling=True)
    stated = drop(None, fps=240, mm_per_px=0.5)
    recording, (said,) = upright(tracked.track, stated)
    assert f"falls {180 if turns == 2 else 90}.0°" in said
    found = measure_drop(tracked.track.in_mm(0.5), recording)
    normal = named(found)["restitution_normal"]
    assert abs(normal.value - 0.7) < 3 * normal.sd < 0.02


def test_what_a_fit_allows_for_and_what_is_stated_stays(tmp_path):
    assert upright(turned(8.0), known()) == (known(), ())
    stated = drop(None, fps=240, mm_per_px=0.5, plumb_deg=0.0)
    kept, (said,) = upright(turned(15.0), stated)
    assert kept == stated and "15.0° anticlockwise" in said
    assert "plumb_deg = 0 is used" in said
    right = drop(None, fps=240, mm_per_px=0.5, plumb_deg=-15.0)
    assert upright(turned(15.0), right) == (right, ())


def test_what_does_not_fly_tells_no_direction():
    rng = np.random.default_rng(0)
    time = np.arange(300) / 100
    assert direction_of_fall(time, 10 * time, 0 * time) is None
    assert direction_of_fall(time, *rng.normal(0, 1, (2, 300))) is None


def thrown(across_m_s: float, slowed_m_s2: float) -> Track:
    """A ball that rises and falls by 200 mm while air pulls it across, 140 rows a
    second."""
    t = np.arange(56) / 140
    x = 1e3 * (across_m_s * t + slowed_m_s2 * t**2 / 2)
    y = 1e3 * (1.96 * t - 9.81 * t**2 / 2)
    noise = 0.3 * np.random.default_rng(0).standard_normal((2, len(t)))
    return make_track(t, x + noise[0], y + noise[1], frame=np.arange(len(t)))


@pytest.mark.parametrize("way", [-1.0, 1.0])
def test_air_that_slows_what_is_thrown_across_turns_no_picture(way):
    """All of such a flight is read, its rise included; as a control one that falls the
    way it flies, as in a picture that is turned."""
    slowed = thrown(6.0 * way, -7.0 * way)
    told, said = upright(slowed, known())
    assert told.camera.plumb_deg is None and not said
    (seen,) = drops_of(slowed, known())
    assert not seen.trouble and (seen.flight == 0).sum() >= 50
    assert upright(thrown(1.0 * way, 7.0 * way), known())[1]
