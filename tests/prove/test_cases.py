"""Recording cases: read and measured by the measuring code, near the SNR that was asked
for, and the same from the same seed."""

from dataclasses import replace

import numpy as np
import pytest

from benchtwin.measure.batch import find_all
from benchtwin.prove.cases.bench import Request, write_bench
from benchtwin.prove.cases.pile import photograph
from benchtwin.prove.cases.record import FOLLOWS, field_of
from benchtwin.prove.cases.roll import travel
from benchtwin.prove.cases.snr import Visibility
from benchtwin.prove.make import MadeCase, sized
from benchtwin.prove.plan import Spec
from benchtwin.prove.rigs import RIGS
from benchtwin.vision.evidence.frames import open_frames
from benchtwin.vision.motion.track_seed import track_seed
from benchtwin.vision.recording import Recording

from .making import make


def spec(
    rig, *effects, kind="single", snr=15.0, separated=None, rendered=False
) -> Spec:
    return Spec(
        1,
        rig,
        kind if effects else "clean",
        effects,
        (snr,) * len(effects),
        separated,
        rendered,
    )


def test_the_vocabulary_is_the_one_that_is_planned_and_made():
    for rig, made in RIGS.items():
        planned = {
            *(*made.singles, *made.confounded, *made.separable, *made.unlisted),
            *((FOLLOWS,) if made.follows else ()),
            *(n for pair in made.pairs for n in pair),
        }
        assert planned <= set(made.effects) and made.rig == rig
        assert all(made.effects[n].least < made.effects[n].most for n in planned)
        unmade = set(made.effects) - planned
        assert unmade <= {
            "restitution-falls-with-speed",
            "angle-offset",
        }  # a class; and what friction hides


@pytest.mark.parametrize(
    ("rig", "effect", "separated"),
    [
        ("drop", "drag", None),
        ("drop", "camera-roll", None),
        ("drop", "plate-tilt", None),
        ("drop", "follows", None),
        ("slide", "follows", None),
        ("slide", "stepped-tilt", None),
        ("roll", "follows", None),
        ("roll", "order-drift", None),
        ("slide", "viscous-sliding", None),
        ("slide", "adhesion", True),
        ("roll", "slope", True),
        ("roll", "shape-barrier", None),
        ("pile", "camera-roll", None),
        ("pile", "base-vibration", None),
    ],
)
def test_an_effect_is_made_as_visible_as_was_asked_for(rig, effect, separated):
    _, key = make(spec(rig, effect, separated=separated, snr=10.0), 3)
    assert key.effects[0].snr == pytest.approx(10.0, rel=0.25)


def test_without_the_second_direction_a_slope_cannot_be_seen():
    """It is rolling friction then, but for the incline, where it does not act."""
    seen = []
    for separated in (True, False):
        scene = RIGS["roll"].draw(
            Request(("slope",), separated), np.random.default_rng(4)
        )
        seen.append(RIGS["roll"].visibility(scene.changed(slope=0.1), "slope").snr)
    assert seen[1] < 0.2 * seen[0]


def test_one_kind_of_heap_hardly_tells_of_its_gate():
    """Angle, size, crest and toe of a heap are its material's first; between photos of
    one heap only what goes on changes."""
    seen = {}
    for name, separated in (("gate-speed", False), ("base-vibration", None)):
        scene = RIGS["pile"].draw(Request((name,), separated), np.random.default_rng(1))
        key = field_of(name)
        seen[name] = [
            RIGS["pile"].visibility(scene.changed(**{key: mm}), key).snr
            for mm in (1.5, 6.0)
        ]
    assert max(seen["gate-speed"]) < 2.5 and min(seen["base-vibration"]) > 2.5


def test_photos_of_one_heap_show_one_skin_with_a_noise_of_their_own():
    scene = RIGS["pile"].draw(Request(), np.random.default_rng(2))
    one, other = (photograph(scene.worlds[0], k).astype(float) for k in (0, 1))
    assert (
        1.0 < (one - other).std() < 6.0
    )  # in grey levels: grains that lie elsewhere would differ by tens


def test_the_corner_is_met_exactly_so_that_an_snr_may_ask_for_slopes():
    """A hundredth of a millimetre more on the incline: L + S goes on in proportion to
    S."""
    scene = RIGS["roll"].draw(Request(("slope",), True), np.random.default_rng(4))
    world = scene.worlds[0]
    way = world.way_mm + world.start_off_mm
    end, later = (
        travel(world._replace(start_off_mm=world.start_off_mm + m))[1][-1]
        for m in (0.0, 0.01)
    )
    assert (later - end) / 0.01 == pytest.approx(end / way, rel=0.02)


def test_the_same_seed_makes_the_same_case():
    (one, key), (two, again) = (
        make(spec("drop", "drag"), 3),
        make(spec("drop", "drag"), 3),
    )
    assert key == again
    assert one.recordings[0].track.equals(two.recordings[0].track)


@pytest.mark.parametrize("rig", list(RIGS))
def test_benches_are_read_by_the_measuring_code(rig, tmp_path):
    bench, _ = make(spec(rig), 11)
    write_bench(bench, tmp_path / "case")
    found = find_all([tmp_path / "case"])
    assert len(found) >= len(bench.recordings)
    assert all(isinstance(r, Recording) and r.rig == rig for r in found), found


@pytest.mark.slow
def test_the_tracker_finds_the_drawn_seed(tmp_path):
    scene = RIGS["drop"].draw(Request(rendered=True), np.random.default_rng(12))
    scene = replace(scene, worlds=scene.worlds[:1])
    bench = MadeCase(scene, ()).bench(RIGS["drop"])
    write_bench(bench, tmp_path / "case")
    recording = find_all([tmp_path / "case"])[0]
    track = track_seed(open_frames(recording), falling=True).track
    assert len(track) > 0.95 * len(bench.recordings[0].pictures)
    flying = track.y[: len(track) // 8]
    third = np.diff(flying, 3)
    assert np.std(third) / np.sqrt(20) < 0.06  # px; SNRs of pictures are told for 0.03


def test_a_size_is_found_where_a_nuisance_hides_the_small_ones():
    """Of a corner that takes 0.024 by itself nothing is seen, then 1,000 for each
    more."""
    rig = replace(
        RIGS["roll"],
        visibility=lambda scene, name: Visibility(
            1000 * max(getattr(scene.worlds[0], name) - 0.024, 0.0)
        ),
    )
    rng = np.random.default_rng(0)
    scene = rig.draw(Request(), rng)
    scene, seen = sized(rig, scene, spec("roll", "corner-loss", snr=12.0), rng)
    assert seen[0].snr == pytest.approx(12.0, rel=0.08)
    assert scene.worlds[0].corner_loss == pytest.approx(0.036, rel=0.03)
