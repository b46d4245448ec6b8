"""Poses of seeds and parts a little before or after a frame's moment, for the sub-frames of an exposure."""

import numpy as np
from scipy.spatial.transform import Rotation

from sim.motion import Motion

Array = np.ndarray


def poses_at(motion: Motion, frame: int, later_s: float) -> tuple[Array, Array]:
    """Positions (n, 3) [m] and unit quaternions (n, 4) of the seeds, then the parts, at t[frame] + later_s.

    Seeds: p + v τ and exp(ω τ/2) q, with the frame's velocities and spins. Parts: interpolated between neighbouring frames.
    """
    places, turns = [motion.positions_m[frame]], [motion.orientations[frame]]
    if later_s:
        places[0] = places[0] + later_s * motion.velocities_m_s[frame]
        turned = Rotation.from_rotvec(later_s * motion.spins_rad_s[frame]) * _rotation(turns[0])
        turns[0] = turned.as_quat()[:, [3, 0, 1, 2]]
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
    step = part.poses[last] - part.poses[first] * np.where(
        np.arange(7) < 3, 1.0, np.sign(part.poses[first][3:] @ part.poses[last][3:]) or 1.0
    )
    pose = pose + share * step  # over a fraction of a frame a turn is small: the chord will do
    return np.r_[pose[:3], pose[3:] / np.linalg.norm(pose[3:])]


def matrices(places_m: Array, turns: Array) -> Array:
    """Homogeneous matrices (n, 4, 4) of positions (n, 3) and unit quaternions (n, 4)."""
    out = np.zeros((len(turns), 4, 4))
    out[:, :3, :3], out[:, :3, 3], out[:, 3, 3] = _rotation(turns).as_matrix(), places_m, 1.0
    return out


def _rotation(quaternions: Array) -> Rotation:
    """Unit quaternions (n, 4), the scalar first, as SciPy's rotations."""
    return Rotation.from_quat(quaternions[:, [1, 2, 3, 0]])
