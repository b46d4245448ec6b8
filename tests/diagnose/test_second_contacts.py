"""Seeds that are touched where no model has a contact, and rows that lie anywhere: left
out, or clean drops would alarm."""

from dataclasses import replace

import numpy as np
import pytest
from falling import Bench, tracks

from benchtwin.rigs.drop.diagnose import diagnose_drop
from benchtwin.rigs.drop.joint_problem import prepare_sessions

LONG = Bench(fps=2000.0, noise_mm=0.04, rho=0.0)


def touched_before(track, early_s: float = 0.003, slower_m_s: float = 0.25):
    """One end touches some ms before the contact that parabolas meet at: from there the
    centre falls more slowly."""
    up = track.y_mm.copy()
    for contact in track.contacts_s:
        late = track.time_s - (contact - early_s)
        up += np.where(
            (late > 0) & (track.time_s < contact), 1e3 * slower_m_s * late, 0.0
        )
    return replace(track, y_mm=up)


def touched_after(track, late_s: float = 0.004, slower_m_s: float = 0.1):
    """The other end touches some ms after the last contact, and only then its short hop
    begins."""
    late = track.time_s - track.contacts_s[-1]
    return replace(
        track,
        y_mm=track.y_mm
        + np.where(late > 0, 1e3 * slower_m_s * np.maximum(late_s - late, 0.0), 0.0),
    )


def rolling_away(track):
    """What was taken for its last flight was none: it goes up and down with a quarter
    of g."""
    last = track.flight == track.flight.max()
    late = track.time_s - track.contacts_s[-1]
    return replace(
        track,
        y_mm=np.where(last, track.y_mm + 0.75 * 9806.65 * late**2 / 2, track.y_mm),
    )


def aside_while_touching(track):
    """It goes on by 1 mm between the touches of its two ends."""
    return replace(
        track, x_mm=track.x_mm + 1.0 * np.searchsorted(track.contacts_s, track.time_s)
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "spoilt",
    [
        touched_before,
        pytest.param(rolling_away, marks=pytest.mark.slow),
        pytest.param(aside_while_touching, marks=pytest.mark.slow),
    ],
)
def test_second_contacts_raise_no_alarm(spoilt):
    drops = tracks(LONG, 4, np.random.default_rng(3))
    found = diagnose_drop([spoilt(t) for t in drops], np.random.default_rng(0))
    assert found.verdict == "none" and found.p_global > 0.01


@pytest.mark.parametrize("touched", [False, True])
def test_a_short_hop_that_was_touched_as_it_began_is_left_out(touched):
    """Too slow for air, it bends no further than a parabola: all four are found, of
    free ones none."""
    drops = tracks(LONG, 4, np.random.default_rng(3))
    (prepared,), _ = prepare_sessions(
        [touched_after(t) if touched else t for t in drops]
    )
    hops = [
        np.any(t.flight == t.flight.max()) and t.flight.max() == len(t.contacts_s)
        for t in prepared.tracks
    ]
    assert hops == [not touched] * 4
