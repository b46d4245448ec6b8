"""What a usual heap is: heaps that collapse in a channel, simulated, are."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchtwin.rigs.pile import heap_priors
from benchtwin.rigs.pile.diagnose import diagnose_pile
from benchtwin.rigs.pile.flanks import photo_of
from benchtwin.rigs.pile.heap_outline import outlined
from benchtwin.twin.job import Job
from benchtwin.twin.parameters import Parameters
from benchtwin.twin.run import run

CHANNEL = {
    "seed": {n: 8.0 for n in ("length_mm", "width_mm", "thickness_mm")},
    "pile": {
        "box_mm": [70.0, 30.0, 120.0],
        "gate_mm": [30.0, 120.0],
        "plate_mm": [400.0, 30.0],
        "channel_mm": [400.0, 30.0],
        "fill_height_mm": 80.0,
        "gate_speed_mm_s": 1000.0,
    },
}


def collapsed(rolling_friction: float) -> list:
    """Four packings of one collapse."""
    parameters = Parameters(
        seed_static_friction=0.5, seed_rolling_friction=rolling_friction
    )
    heaps = []
    for packing in range(4):
        job = Job("pile", parameters, CHANNEL, (31, packing), rendered=False)
        recording, rng = job.recording(Path("heap")), np.random.default_rng([*job.rng])
        motion, _ = run(recording, parameters, rng=rng, threads=1)
        name = f"heap-{rolling_friction}-{packing}"
        heaps.append(replace(outlined(motion, recording), recording=name))
    return heaps


@pytest.fixture(scope="module")
def collapses():
    return collapsed(0.02)


def plain(heap):
    """The same heap, its seeds known to be as usual."""
    told = heap.description["pile"] | {"plain": True}
    return replace(heap, description=heap.description | {"pile": told})


def test_collapses_are_usual_and_others_beside_plain_ones_are_of_other_seeds(collapses):
    rng = np.random.default_rng(1)
    assert not diagnose_pile(collapses, rng).alarm
    known = [plain(heap) for heap in collapses[:2]]
    assert not diagnose_pile([*known, *collapses[2:]], rng).alarm
    known = [plain(heap) for heap in collapses]
    found = diagnose_pile([*known, *collapsed(0.3)], rng)
    assert found.alarm and {"seed-friction", "cohesion"} <= {*found.names}


def test_rows_that_a_layer_hides_are_not_held_against_anything(collapses):
    heap = collapses[0]
    (flank,) = photo_of(heap).flanks
    far = heap.x > flank.start + 0.7 * flank.length
    (cut,) = photo_of(replace(heap, hidden=far)).flanks
    assert cut.u[-1] < 0.72 < flank.u[-1]
    assert (cut.angle_deg, cut.length) == (flank.angle_deg, flank.length)


def test_the_table_holds_the_means_slopes_and_components_of_one_flank():
    table = pd.read_csv(heap_priors.TABLE)
    assert (np.diff(table.u) > 0).all() and np.isfinite(table.to_numpy()).all()
    usual = heap_priors.usual(1)
    u = table.u.to_numpy()
    # a concave flank: above the line at the wall and at the toe, below it between
    mean = usual.mean(u, 10.0, 20.0)
    assert mean[0] > 0 > mean[10] and mean[20] > 0
    assert (usual.spread(u, np.nan) > usual.spread(u, 10.0)).all()
    assert usual.mean(u, 10.0, 21.0) - mean == pytest.approx(usual.steeper(u))
