"""Dumps read back: axes named anew after a restart, a stopped part's surplus frames, a
line cut off, a seed that has left."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchtwin.sim.lammps.follow import read_way


def text_of(step: int, rows: np.ndarray) -> str:
    """One frame of `dump local`: mol, place, quaternion (w first), velocity, spin."""
    head = (
        f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ENTRIES\n{len(rows)}\nITEM: BOX"
        " BOUNDS ff ff ff\n0 1\n0 1\n0 1\n"
    )
    lines = [
        " ".join([str(int(row[0])), *(f"{v:.14g}" for v in row[1:])]) for row in rows
    ]
    return head + "ITEM: ENTRIES c_bodies[*]\n" + "".join(line + "\n" for line in lines)


def wxyz(turn: Rotation) -> np.ndarray:
    return np.roll(turn.as_quat(), 1, axis=-1)


def frames_of(
    turns: list[Rotation], naming: Rotation, seeds=(1, 2)
) -> list[np.ndarray]:
    """Two seeds at x = step/1000 and turned alike; `naming`: how LAMMPS's axes lie in
    ours."""
    return [
        np.array(
            [
                [k, 0.001 * step * k, 0.0, 0.0, *wxyz(turn * naming), *np.zeros(6)]
                for k in seeds
            ]
        )
        for step, turn in enumerate(turns)
    ]


def test_parts_join_once_and_keep_our_axes(tmp_path):
    turns = [Rotation.from_rotvec([0.1 * k, 0.05, -0.2 * k]) for k in range(8)]
    names = (
        Rotation.from_euler("xyz", [90, 0, 180], degrees=True),
        Rotation.from_euler("xyz", [0, 90, 90], degrees=True),
    )
    one, two = (frames_of(turns, name) for name in names)
    (tmp_path / "pile.1.bodies.dump").write_text(
        "".join(text_of(k, one[k]) for k in range(6)) + text_of(6, one[6])[:-40]
    )
    (tmp_path / "pile.2.bodies.dump").write_text(
        "".join(text_of(k, two[k]) for k in range(4, 8))
    )
    way = read_way(tmp_path, "pile", np.tile(wxyz(turns[0]), (2, 1)))
    assert list(way.steps) == list(range(8))
    assert way.rows[:, 1, 0] == pytest.approx(0.002 * np.arange(8))
    same = np.abs(
        [wxyz(turn) @ q for turn, q in zip(turns, way.rows[:, 0, 3:7])]
    )  # q and −q are one turn
    assert same == pytest.approx(1.0, abs=1e-12)


def test_parts_come_in_the_order_of_their_numbers(tmp_path):
    turns = [Rotation.identity()] * 12
    for part in range(1, 12):
        two = "".join(
            text_of(k, frames_of(turns, turns[0])[k]) for k in (part - 1, part)
        )
        (tmp_path / f"pile.{part}.bodies.dump").write_text(two)
    assert list(
        read_way(tmp_path, "pile", np.tile([1.0, 0, 0, 0], (2, 1))).steps
    ) == list(range(12))


def test_a_seed_that_has_left_is_unknown(tmp_path):
    turns = [Rotation.identity()] * 2
    rows = frames_of(turns, turns[0])[0], frames_of(turns, turns[0], seeds=(2,))[1]
    (tmp_path / "pile.1.bodies.dump").write_text(
        text_of(0, rows[0]) + text_of(1, rows[1])
    )
    way = read_way(tmp_path, "pile", np.tile([1.0, 0, 0, 0], (2, 1)))
    assert np.isnan(way.rows[1, 0]).all() and np.isfinite(way.rows[1, 1]).all()


def test_no_frame_is_said(tmp_path):
    with pytest.raises(RuntimeError, match="no frame of pile"):
        read_way(tmp_path, "pile", np.tile([1.0, 0, 0, 0], (2, 1)))
