"""What a run leaves behind: where everything was, at the moments asked for. Rigs make
it, pictures show it."""

from dataclasses import dataclass, field

import numpy as np

from benchtwin.sim.seed import Seed
from benchtwin.sim.seed.surface import Mesh


@dataclass(frozen=True, eq=False)
class Part:
    """A piece of the rig as a camera sees it.

    mesh: its surface in its own frame [m]. finish: "steel" (bright, plain), "board"
    (dark, matt) or "seed". poses: (1, 7) if it stands still, else (frames, 7): position
    [m] and unit quaternion (w, x, y, z) at each moment."""

    name: str
    mesh: Mesh
    finish: str = "steel"
    poses: np.ndarray = field(
        default_factory=lambda: np.array([[0.0, 0, 0, 1, 0, 0, 0]])
    )

    def pose(self, frame: int) -> np.ndarray:
        """Position and quaternion (7,) at a frame."""
        return self.poses[frame if len(self.poses) > 1 else 0]


@dataclass(frozen=True, eq=False)
class Motion:
    """Seeds and parts at `frames` moments.

    t_s (frames,). shapes: the seeds' forms, shape_of (seeds,) which is whose.
    positions_m (frames, seeds, 3) of the centres of mass; orientations (frames, seeds,
    4) unit quaternions (w, x, y, z) from the principal frame; velocities_m_s and
    spins_rad_s (frames, seeds, 3), world axes, from which the blur of an exposure
    follows. A seed that has left the rig has NaN. x to the right in the picture, y away
    from the camera, z up. truth: what the simulation knows of the quantities that the
    rig is read for, in their bench units; readings: what somebody would have read off,
    one value a repeat, by column of readings.csv. series: further columns, one value a
    frame (tilt_deg …)."""

    t_s: np.ndarray
    shapes: tuple[Seed, ...]
    shape_of: np.ndarray
    positions_m: np.ndarray
    orientations: np.ndarray
    velocities_m_s: np.ndarray
    spins_rad_s: np.ndarray
    parts: tuple[Part, ...] = ()
    truth: dict[str, float] = field(default_factory=dict)
    series: dict[str, np.ndarray] = field(default_factory=dict)
    readings: dict[str, list[float]] = field(default_factory=dict)

    @property
    def frames(self) -> int:
        return len(self.t_s)

    @property
    def seeds(self) -> int:
        return len(self.shape_of)
