"""How far a seed rises again from the seeds that it falls on."""

from dataclasses import dataclass, field

import numpy as np

from benchtwin.bench.constants import G_M_S2
from benchtwin.sim.engine.state import State
from benchtwin.sim.engine.world import World

# touches closer than this (one seed below, then the next) are one impact
ONE_IMPACT_S = 0.02
LOOK_S = 2e-4


@dataclass
class Rise:
    """An observer that ends the run when the seed `which` has come to its highest place
    after the first impact, or, `reckoned`, when the impact is over: air takes next to
    nothing of a rise. rise_m: from its lowest place in that impact to the highest.

    A falling seed only gets faster, downwards; when it first does not, it touches."""

    which: int
    reckoned: bool = False
    touched_s: float | None = None
    low_m: float = np.inf
    high_m: float = -np.inf
    _before: float = field(default=0.0, repr=False)

    @property
    def rise_m(self) -> float:
        """0 where it never rose, or never fell on anything."""
        return max(self.high_m - self.low_m, 0.0) if self.high_m > -np.inf else 0.0

    def __call__(self, world: World, state: State) -> bool:
        # rows of the state are in the order of the seeds; none is lost
        height = float(state.positions[self.which, 2])
        speed = float(state.velocities[self.which, 2])
        if self.touched_s is None:
            if speed > self._before:
                self.touched_s = state.time_s
            self._before = speed
        if self.touched_s is None:
            return False
        since = state.time_s - self.touched_s
        if height < self.low_m and since < ONE_IMPACT_S:
            self.low_m = self.high_m = height
        self.high_m = max(self.high_m, height)
        if since < ONE_IMPACT_S:
            return False
        if self.reckoned:
            self.high_m = max(self.high_m, height + max(speed, 0.0) ** 2 / (2 * G_M_S2))
        return self.reckoned or speed <= 0
