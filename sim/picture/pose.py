"""Poses of seeds and parts a little before or after a frame's moment, for the
sub-frames of an exposure.

A seed that is not there has NaN for its pose, which SciPy's rotations refuse."""

import numpy as np

from benchtwin.sim.motion import Motion
from benchtwin.sim.rotation import product

Array = np.ndarray


def poses_at(motion: Motion, frame: int, later_s: float) -> tuple[Array, Array]:
    """Positions (n, 3) [m] and unit quaternions (n, 4) of the seeds, then the parts, at
    t[frame] + later_s.

    Seeds: p + v τ and exp(ω τ/2) q, with the frame's velocities and spins. Parts:
    interpolated between neighbouring frames."""
    places, turns = [motion.positions_m[frame]], [motion.orientations[frame]]
    if later_s:
        places[0] = places[0] + later_s * motion.velocities_m_s[frame]
        turns[0] = product(
            from_rotation_vector(later_s * motion.spins_rad_s[frame]), turns[0]
        )
    for part in motion.parts:
        pose = _part_pose(motion, part, frame, later_s)
        places.append(pose[None, :3])
        turns.append(pose[None, 3:])
    return np.vstack(places), np.vstack(turns)


def _part_pose(motion: Motion, part, frame: int, later_s: float) -> Array:
    frames = len(part.poses)
    pose = part.pose(frame)
    if not later_s or frames < 2:
        return pose
    at = range(frames)[frame]
    first, last = max(at - 1, 0), min(at + 1, frames - 1)
    if motion.t_s[last] <= motion.t_s[first]:
        return pose
    share = later_s / (motion.t_s[last] - motion.t_s[first])
    same_turn = np.sign(part.poses[first][3:] @ part.poses[last][3:]) or 1.0
    step = part.poses[last] - part.poses[first] * np.where(
        np.arange(7) < 3, 1.0, same_turn
    )
    # over a fraction of a frame a turn is small: the chord will do
    pose = pose + share * step
    return np.r_[pose[:3], pose[3:] / np.linalg.norm(pose[3:])]


def from_rotation_vector(angles_rad: Array) -> Array:
    """Unit quaternions (n, 4) of rotation vectors (n, 3) [rad]."""
    half = 0.5 * np.linalg.norm(angles_rad, axis=1, keepdims=True)
    return np.hstack([np.cos(half), 0.5 * angles_rad * np.sinc(half / np.pi)])


def matrices(places_m: Array, turns: Array) -> Array:
    """Homogeneous matrices (n, 4, 4) of positions (n, 3) and unit quaternions (n,
    4)."""
    w, x, y, z = turns.T
    out = np.zeros((len(turns), 4, 4))
    out[:, 0, :3] = np.stack(
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], axis=1
    )
    out[:, 1, :3] = np.stack(
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], axis=1
    )
    out[:, 2, :3] = np.stack(
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=1
    )
    out[:, :3, 3], out[:, 3, 3] = places_m, 1.0
    return out
