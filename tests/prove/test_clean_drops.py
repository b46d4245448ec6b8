"""Clean drops hold nothing beyond what a good bench leaves open: soft contact, shape
and camera must not pass for physics."""

from dataclasses import replace

import numpy as np

from benchtwin.prove.cases.bench import Request
from benchtwin.prove.cases.drop import Scene, SimulatedDrop, draw, fly_all
from benchtwin.prove.cases.drop_snr import _flights, _places, _pushed, _recording_change
from benchtwin.prove.cases.ellipsoid import G_M_S2
from benchtwin.prove.cases.snr import fitted

NUISANCES = ("scale_error", "roll_deg", "distortion", "perspective")


def beyond_the_textbook(scene: Scene) -> float:
    """SNR of all that tracks show beside gravity, the nominal drag, free bounces and
    the nuisances at their stated sds."""
    sds = np.r_[
        np.tile([scene.scale_sd, scene.plumb_sd_deg, 2e-4, 1e-3], len(scene.cameras)),
        0.15,
    ]
    return fitted(
        [_recording(scene, drop, sds) for drop in fly_all(scene, {})], sds, scene.noise
    ).snr


def _recording(scene: Scene, drop: SimulatedDrop, sds: np.ndarray):
    seen = _places(drop, drop.camera)
    stated, none = drop.law.copy(), drop.law.copy()
    stated[1], none[1] = scene.air.drag, 0.0
    air, fall, flight = (
        _pushed(drop, stated, none),
        np.zeros(len(drop.rows)),
        _flights(drop),
    )
    for k in range(flight.max() + 1):
        rows = flight == k
        fall[rows] = -0.5e3 * G_M_S2 * (drop.true_s[rows] - drop.true_s[rows][:1]) ** 2
    shared = [np.zeros((len(drop.rows), len(sds))) for _ in range(2)]
    for i, (key, sd) in enumerate(zip(NUISANCES, sds)):
        moved = _places(
            drop, replace(drop.camera, **{key: getattr(drop.camera, key) + sd})
        )
        for axis in range(2):
            shared[axis][:, 4 * drop.run.session + i] = (moved[axis] - seen[axis]) / sd
    for axis in range(2):
        shared[axis][:, -1] = air[axis]
    made = _recording_change(
        drop, [seen[0] - air[0], seen[1] - air[1] - fall], shared, 1.0
    )
    return replace(
        made, own_sd=np.full(len(made.own_sd), np.inf)
    )  # ways to and from the camera too


def test_clean_drops_are_textbook_drops():
    """Each nuisance that was drawn costs about 1; what is left beyond that would be
    seen as an effect of that SNR. From near by what a seed's way to the camera does is
    not linear any more."""
    found = []
    for seed in range(8):
        scene = draw(Request(), np.random.default_rng(seed))
        plumb = tuple(
            replace(camera, plumb_deg=0.0, distance_mm=2e4) for camera in scene.cameras
        )
        found.append(beyond_the_textbook(replace(scene, cameras=plumb)))
    assert np.median(found) < 3
    assert max(found) < 5
