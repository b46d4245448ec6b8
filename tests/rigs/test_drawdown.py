"""A box that empties through a slot: what is measured on photo, film and weights, how
often it jams; and the simulation against what must be."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from scipy import stats

from benchtwin.measure.observe import observe
from benchtwin.rigs.drawdown.flow import flow_of
from benchtwin.rigs.drawdown.jamming import half_width, jamming, share_interval
from benchtwin.sim.motion import Motion
from benchtwin.sim.rigs.drawdown import Drawdown, flow_time
from benchtwin.vision.evidence.frames import Frame
from benchtwin.vision.measurement import MeasurementError, Observation
from benchtwin.vision.recording import Recording, read_recording

# a drawn photo: a slope of SHEAR above the shelf, a heap of REPOSE below it
SHEAR, REPOSE, SEEDS, DARK = 32.0, 24.0, 205, 40
SHELF, TRAY = 300, 560  # rows
UPPER, LOWER = (30, 60, 420, 252), (150, 320, 600, 252)


def drawn(seed: int = 1) -> np.ndarray:
    """Grey levels (600, 800) with the sensor's noise."""
    x, y = np.meshgrid(np.arange(800), np.arange(600))
    slope = (
        (y < SHELF) & (x >= 40) & (SHELF - y < np.tan(np.radians(SHEAR)) * (360 - x))
    )
    heap = (y < TRAY) & (TRAY - y < 90 - np.tan(np.radians(REPOSE)) * abs(x - 440))
    rng = np.random.default_rng(seed)
    picture = np.where(slope | heap, SEEDS, DARK) + rng.normal(0, 3, x.shape)
    picture += np.where(slope | heap, rng.normal(0, 12, x.shape), 0)
    return np.clip(picture, 0, 255).astype(np.uint8)


def recorded(folder: Path, more: str = "", width_mm: float = 6.8) -> Recording:
    """The drawn photo as a recording with these keys more."""
    folder.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(folder / "photo.png"), drawn())
    (folder / "recording.toml").write_text(
        f'rig = "drawdown"\n[seed]\nlength_mm = 8.7\nwidth_mm = {width_mm}\n'
        "thickness_mm = 6.0\n[camera]\nplumb_deg = 0.0\n[drawdown]\n"
        f"upper_px = {list(UPPER)}\nlower_px = {list(LOWER)}\n"
        f"shelf_px = [40, {SHELF}, 360, {SHELF}]\n"
        f"tray_px = [160, {TRAY}, 740, {TRAY}]\n" + more
    )
    return read_recording(folder)


def by_name(found: Observation) -> dict:
    return {q.name: q for q in found.quantities}


def test_slope_above_and_heap_below_are_those_that_were_drawn(tmp_path):
    found = by_name(observe(recorded(tmp_path / "a")))
    for name, drawn_deg in (("shear_angle", SHEAR), ("heap_angle", REPOSE)):
        q = found[name]
        assert q.quality == "good", q
        assert abs(q.value - drawn_deg) < max(4 * q.sd, 0.3), q


def test_flow_and_masses_as_stated(tmp_path):
    stated = "filled_mass_g = 132\nretained_mass_g = 40\nflow_time_s = 0.46\n"
    found = by_name(observe(recorded(tmp_path / "a", stated)))
    assert found["flow_time"].value == 0.46
    assert found["mass_flow"].value == pytest.approx(0.8 * 92 / 0.46)


@pytest.mark.parametrize(
    ("more", "width_mm", "said"),
    [
        (
            "filled_mass_g = 132\nretained_mass_g = 40\ntray_mass_g = 70\n"
            "spilt_mass_g = 10\n",
            6.8,
            "12.0 g are missing: 132 g were filled in, 120 g were found again",
        ),
        ("slot_mm = 15\n", 6.8, "the slot is 2.2 seeds wide: such a slot jams"),
    ],
)
def test_what_speaks_against_a_run_is_said(tmp_path, more, width_mm, said):
    q = by_name(observe(recorded(tmp_path / "a", more, width_mm)))["shear_angle"]
    assert q.quality == "doubtful" and said in q.reason


def test_a_few_grams_that_a_kitchen_scale_loses_are_no_doubt(tmp_path):
    more = "filled_mass_g = 132\nretained_mass_g = 40\ntray_mass_g = 81\n"
    more += "spilt_mass_g = 10\nslot_mm = 25\n"
    assert by_name(observe(recorded(tmp_path / "a", more)))["shear_angle"].reason == ""


def test_a_jammed_run_and_a_photo_without_its_parts_say_so(tmp_path):
    with pytest.raises(MeasurementError, match="an arch over the slot ended the flow"):
        observe(recorded(tmp_path / "a", "jammed = true\n"))
    bare = recorded(tmp_path / "b")
    bare = replace(bare, drawdown=bare.drawdown.model_copy(update={"upper_px": None}))
    with pytest.raises(MeasurementError, match="upper_px and lower_px are missing"):
        observe(bare)


# a film: a filling that falls from TOP to BOTTOM rows, with times of a law t(share)
TOP, BOTTOM, FPS = 20, 120, 100.0


def film(out: np.ndarray):
    """Frames of a box of which the shares `out` are out."""
    rng = np.random.default_rng(3)
    for k, share in enumerate(out):
        picture = np.full((140, 100), DARK, float)
        picture[round(TOP + share * (BOTTOM - TOP) * 0.7) : BOTTOM] = SEEDS
        noisy = picture + rng.normal(0, 3, picture.shape)
        yield Frame(k, k / FPS, np.clip(noisy, 0, 255).astype(np.uint8))


REGION = (0, 0, 100, 130)


def test_a_steady_flow_takes_eight_tenths_of_its_time():
    t = np.arange(100) / FPS
    found = flow_of(film(np.clip((t - 0.2) / 0.5, 0, 1)), REGION, "a")
    assert found.time_s == pytest.approx(0.8 * 0.5, abs=3 * found.sd_s)


def test_the_dribble_at_the_end_does_not_count():
    t = np.arange(300) / FPS
    out = 0.92 * np.clip((t - 0.2) / 0.46, 0, 1) + 0.08 * np.clip((t - 0.66) / 2, 0, 1)
    found = flow_of(film(out), REGION, "a")
    assert found.time_s == pytest.approx(0.8 * 0.5, abs=3 * found.sd_s)


@pytest.mark.parametrize(
    ("from_s", "to_s", "said"),
    [
        (0.35, 1.0, "begins when the flow runs already"),
        (0.0, 0.6, "ends before the flow does"),
        (0.8, 1.0, "nothing flows out of the box"),
    ],
)
def test_a_film_that_has_not_the_whole_flow_says_so(from_s, to_s, said):
    t = np.arange(from_s, to_s, 1 / FPS)
    out = np.clip((t - 0.2) / 0.5, 0, 1)
    with pytest.raises(MeasurementError, match=said):
        flow_of(film(out), REGION, "a")


def motion_of(heights_m: np.ndarray, seed) -> Motion:
    """Seeds (n) of one shape at heights (frames, n), one look every 10 ms."""
    frames, n = heights_m.shape
    at = np.zeros((frames, n, 3))
    at[:, :, 2] = heights_m
    turn = np.tile([1.0, 0, 0, 0], (frames, n, 1))
    still = np.zeros((frames, n, 3))
    t = 0.01 * np.arange(frames)
    return Motion(t, (seed,), np.zeros(n, int), at, turn, still, still)


def test_the_simulation_times_the_flow_by_the_same_rule():
    from benchtwin.sim.seed import Seed

    seed = Seed.from_dimensions(8e-3, 7e-3, 6e-3, spheres=1, density_kg_m3=1200.0)
    n, frames = 200, 120
    passes = np.linspace(20, 80, n)[:, None]  # frames at which each is through
    height = np.where(np.arange(frames) < passes, 0.01, -0.05).T
    assert flow_time(motion_of(height, seed)) == pytest.approx(0.8 * 0.6, abs=0.011)


def test_half_of_the_runs_jam_at_the_width_at_which_they_were_drawn_to():
    """95 % intervals of 100 benches of 5 widths, 10 runs each: chance moves a rate by
    2 %."""
    rng, held = np.random.default_rng(1), 0
    widths, runs = np.array([12.0, 16, 20, 24, 28]), np.full(5, 10)
    for _ in range(100):
        jams = rng.binomial(runs, 1 / (1 + np.exp((widths - 18) / 2)))
        found = half_width(widths, jams, runs)
        held += found is not None and found[1] <= 18 <= found[2]
    assert held >= 89


def test_runs_that_do_not_depend_on_the_width_have_no_such_width():
    widths, runs = np.array([12.0, 16, 20]), np.full(3, 10)
    assert half_width(widths, np.array([10, 10, 10]), runs) is None
    assert half_width(widths, np.array([5, 5, 5]), runs) is None


@pytest.mark.parametrize(("count", "n"), [(0, 5), (3, 10), (10, 10)])
def test_a_share_has_wilsons_interval(count, n):
    told = stats.binomtest(count, n).proportion_ci(method="wilson")
    assert share_interval(count, n) == pytest.approx((told.low, told.high), abs=1e-12)


def test_runs_of_several_slots_are_counted(tmp_path):
    some = []
    for slot, jammed in ((12, True), (12, True), (18, True), (18, False), (24, False)):
        more = f"slot_mm = {slot}\njammed = {str(jammed).lower()}\n"
        entry = recorded(tmp_path / f"{len(some)}", more)
        some.append((entry, Observation(entry.id, "drawdown", ())))
    found = jamming(some)
    shares = {
        o.recording: o.quantities[0].value for o in found if "slot " in o.recording
    }
    assert shares == {"slot 12 mm": 1.0, "slot 18 mm": 0.5, "slot 24 mm": 0.0}


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"fill_height_m": 0.2}, "the box is only 0.1 m high"),
        ({"slot_m": 0.2}, "the box is only 0.105 m long"),
        ({"fall_m": -0.1}, "must be above 0"),
    ],
)
def test_a_box_that_cannot_be_built_is_refused(keys, said):
    with pytest.raises(ValueError, match=said):
        Drawdown(**keys)
