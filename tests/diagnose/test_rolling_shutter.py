"""Drops filmed by a rolling shutter, whose readout nobody states: it is one more
unknown of a session, on which places and restitution depend together."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from falling import PIXEL_MM, STATED, Bench, film

from benchtwin.bench.keys import Air, Camera, Seed
from benchtwin.rigs.drop.diagnose import diagnose_drop
from benchtwin.rigs.drop.keys import Drop
from benchtwin.rigs.drop.nuisances import READOUT
from benchtwin.rigs.drop.read import drops_of
from benchtwin.vision.motion.track import make_track
from benchtwin.vision.recording import Recording

READOUT_S, FINE, FPS, HIGH_MM = 2.5e-3, 4800.0, 240.0, 340.0
ROUND = Bench(axes=(3.5e-3,) * 3, fps=FINE, noise_mm=0.0, tip_deg=0.0)


def filmed(
    bench: Bench, count: int, seed: int, stated_s: float | None, true_s=READOUT_S
):
    """Drops of balls from two heights, each frame's places as the shutter read them,
    from the top of the picture down."""
    rng, out = np.random.default_rng(seed), []
    for k in range(count):
        here = replace(bench, height=(0.31, 0.15)[k % 2])
        t, x, z, *_ = film(here, rng)
        nominal = np.arange(0.02, t[-1] - true_s, 1 / FPS)
        read = nominal
        for _ in range(30):
            late = 1 - np.interp(read, t, z) / HIGH_MM
            read = nominal + true_s * late
        places = (
            np.interp(read, t, place) + 0.02 * rng.standard_normal(len(read))
            for place in (x, z)
        )
        camera = Camera(
            fps=FPS,
            mm_per_px=PIXEL_MM,
            mm_per_px_sd=0.0002,
            plumb_deg=0.0,
            plumb_sd_deg=0.05,
            distance_mm=20_000.0,
            readout_s=stated_s,
        )
        about = {
            "seed": Seed(**STATED | dict.fromkeys(list(STATED)[:3], 7.0)),
            "camera": camera,
            "air": Air(density_kg_m3=1.2),
            "drop": Drop(height_mm=1e3 * here.height),
        }
        told = Recording(f"drop-{k}", Path(), "drop", "frames", (), **about)
        frame = np.arange(len(nominal))
        out += drops_of(make_track(nominal, *places, frame=frame, late=late), told)
    return out


@pytest.mark.parametrize(
    ("stated_s", "true_s"), [(None, READOUT_S), (None, 0.2e-3), (0.0, READOUT_S)]
)
def test_a_readout_that_nobody_stated_is_no_missing_physics(stated_s, true_s):
    """2.5 of the 4.2 ms of a frame, and nearly none; as a control, a shutter that is
    stated to read all rows at once."""
    seen = filmed(ROUND, 6, 1, stated_s, true_s)
    found = diagnose_drop(seen, np.random.default_rng(0))
    assert found.alarm == (stated_s is not None)


def test_the_readout_is_found_and_with_it_restitution(monkeypatch):
    """To 3 sds, and .55 of every impact: where the flights meet, not at the times that
    the middle of the readout's range gave."""
    from benchtwin.rigs.drop import diagnose

    fits = []
    real = diagnose.finding_of
    monkeypatch.setattr(
        diagnose,
        "finding_of",
        lambda task, rng: fits.append(task) or real(task, rng),
    )
    found = diagnose_drop(filmed(ROUND, 6, 2, None), np.random.default_rng(0))
    assert not found.alarm
    base = diagnose.fit(fits[0].alternatives[0].problem)
    off = base.by_name[READOUT] + 0.5 / FPS - READOUT_S
    assert abs(off) < 3 * base.sd(READOUT) < 5e-4
    e = found.contact["restitution"].nothing_missing
    assert e.value == pytest.approx(0.55, abs=0.002)
