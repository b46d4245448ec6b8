"""What a silhouette's turning says of a seed's spin, against free ellipsoids in three
dimensions."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchtwin.rigs.drop.silhouette_spin import (
    silhouette_rotation,
    smoothed,
    spin_calibration,
)

FRAMES = 120


def tumbling(axes, spin_sd, spans, rng):
    """Angle [rad] (n, FRAMES) of free ellipsoids' silhouettes, let go in any attitude,
    and their mean spin about the line of sight (y); small steps of Euler's equations,
    the spin kept in the body's axes."""
    axes = np.array(axes)
    moment = (axes**2).sum() - axes**2
    turned, spin = (
        Rotation.random(len(spans), random_state=rng),
        rng.normal(0, spin_sd, (len(spans), 3)),
    )
    angles, about, fine = [], [], 4
    for k in range(fine * FRAMES):
        matrix = turned.as_matrix()
        if k % fine == 0:
            spread = np.einsum("nia,a,nja->nij", matrix, axes**2, matrix)
            angles.append(
                0.5 * np.arctan2(2 * spread[:, 0, 2], spread[:, 0, 0] - spread[:, 2, 2])
            )
        about.append(-np.einsum("na,na->n", matrix[:, 1], spin))
        step = (spans / (fine * (FRAMES - 1)))[:, None]
        change = np.cross(moment * spin, spin) / moment
        turned, spin = (
            turned * Rotation.from_rotvec(step * (spin + step * change / 2)),
            spin + step * change,
        )
    return np.unwrap(2 * np.array(angles), axis=0).T / 2, np.mean(about, axis=0)


def flights(angles, spans, noise, rng):
    seen = angles + rng.normal(0, noise, angles.shape)
    every = np.arange(FRAMES)
    return [
        silhouette_rotation(np.degrees(a), every, np.linspace(0, span, FRAMES))
        for a, span in zip(seen, spans, strict=True)
    ]


def test_angles_are_smoothed_only_where_rotation_is_even():
    rng, row = np.random.default_rng(1), np.arange(400)
    even = 0.002 * row
    whirl = (
        even + np.pi / 2 * (1 + np.tanh((row - 200) / 2)) / 2
    )  # a seed's end that passes the line of sight
    for true, most in ((even, 0.03), (whirl, 0.06)):
        assert (
            np.sqrt(np.mean((smoothed(true + rng.normal(0, 0.15, 400)) - true) ** 2))
            < most
        )
    there = slice(190, 210)
    assert (
        np.sqrt(
            np.mean((smoothed(whirl + rng.normal(0, 0.15, 400)) - whirl)[there] ** 2)
        )
        < 0.2
    )
    assert np.array_equal(smoothed(even), even)  # without noise nothing is lost


def test_rotation_about_the_line_of_sight_is_trusted_in_full():
    rng, spans = np.random.default_rng(2), np.tile([0.22, 0.3, 0.12, 0.05], 5)
    spin = rng.normal(0, 20, 20)
    found = flights(
        spin[:, None] * np.linspace(0, 1, FRAMES) * spans[:, None], spans, 0.05, rng
    )
    trust, sd = spin_calibration(found)
    assert trust.min() > 0.95 and np.median(sd) < 1.0  # of 20 rad/s
    assert (np.abs(np.array([t.rate for t in found]) - spin) < 4 * sd).all()


@pytest.mark.slow
def test_spin_of_tumbling_seeds_is_unbiased():
    """The spin's regression on the whole rate is 0.5 to 0.8, by shape, on the trusted
    part 1; and its sd is of the right size."""
    spans = np.tile([0.22, 0.3, 0.2, 0.12, 0.08], 6)
    for axes in ((1, 0.995, 0.987), (1, 0.84, 0.73), (1, 0.5, 0.45)):
        plain, careful, off = [], [], []
        for seed in range(30):
            rng = np.random.default_rng(seed)
            angles, spin = tumbling(axes, 15.0, spans, rng)
            found = flights(angles, spans, 0.02, rng)
            rate, (trust, sd) = (
                np.array([t.rate for t in found]),
                spin_calibration(found),
            )
            plain.append((spin @ rate) / (rate @ rate))
            weight = 1 / (trust * sd**2)
            careful.append(
                (weight * spin * trust * rate).sum()
                / (weight * (trust * rate) ** 2).sum()
            )
            off.append(np.mean((spin - trust * rate) ** 2 / (trust * sd**2)))
        assert np.median(plain) < 0.85
        assert 0.85 < np.median(careful) < 1.15
        assert 0.5 < np.median(off) < 2.0


def test_no_angles_no_rotation():
    seen = silhouette_rotation(None, np.arange(50), np.linspace(0, 0.1, 50))
    assert seen.rate == 0 and not seen.angle.any()
    trust, sd = spin_calibration([seen, seen])
    assert trust.tolist() == [0, 0] and sd.tolist() == [0, 0]
