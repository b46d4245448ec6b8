"""From parameters to the travel that a camera reads of each run.

A run's own: time and place of release [s, m], way on the incline beside the stated one [m], its incline [deg] and rolling
friction (relative) beside the common ones, and its seed's drag (relative) beside that of the sizes stated of it. Globals by
name, each 0 at the baseline's centre; mu is relative to where the fit began.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from calibrate.diagnose.effects.roll import corner_loss, drag, initial_slip, slope, viscous_rolling
from calibrate.diagnose.roll.motion import NOTHING, Table, Way, travel
from calibrate.diagnose.roll.session import Run, Seed, weight_over_inertia

SPEEDS = 240  # points of the table of resistance over speed
REMEMBERED = 600  # predictions kept: a fit asks for the same point several times
OWN = ("release_s", "place_m", "length_m", "incline_deg", "mu", "drag")


@dataclass(frozen=True, eq=False)
class Model:
    """runs and seed; mu: the baseline's to begin with; incline [rad], length [m] (R,): stated, or as the motion has them;
    turn (R,) [1/m], phase (R,): the ripple's argument; names: of the globals; top: greatest speed [m/s]."""

    runs: tuple[Run, ...]
    seed: Seed
    mu: float
    incline: np.ndarray
    length: np.ndarray
    turn: np.ndarray
    phase: np.ndarray
    names: tuple[str, ...]
    top: float
    seen: dict = field(default_factory=dict)

    def usual_loss(self, r: int, rank: float) -> float:
        """Share of the speed that the corner takes of run r by itself; rank: the nuisance `corner`."""
        return corner_loss.usual(corner_loss.most(self.incline[r], self.seed.inertia, self.mu), rank)

    def relevant(self, r: int) -> tuple[str, ...]:
        """Globals on which run r depends."""
        ripple = ("shape-barrier", f"shape-barrier.cos.{r}", f"shape-barrier.sin.{r}")
        scale = f"scale.{self.runs[r].session}"
        return tuple(
            n for n in self.names
            if (not n.startswith("shape-barrier") or n in ripple) and (not n.startswith("scale.") or n == scale)
        )  # fmt: skip


def way_of(model: Model, r: int, own: np.ndarray, at: dict[str, float]) -> Way:
    """Run r's way for its own numbers and the globals."""
    seed, get = model.seed, at.get
    f = weight_over_inertia(seed) * (1 + get("inertia", 0.0))
    beta = model.incline[r] + math.radians(own[3] + get("incline", 0.0))
    mu = max(model.mu * (1 + get("mu", 0.0)) * (1 + own[4]), 0.0)
    length = max(model.length[r] + own[2], 1e-4)
    more = {}
    if get("initial-slip", 0.0):
        u, speed = at["initial-slip"], math.sqrt(max(2 * f * (math.sin(beta) - mu * math.cos(beta)) * length, 1e-6))
        more = {
            "gain": initial_slip.incline_gain(u, get("initial-slip.incline", 0.0), speed, seed.inertia),
            "slip_loss": initial_slip.speed_lost(u, seed.inertia),
            "slip_time": initial_slip.duration(get("initial-slip.duration", 0.0)),
        }
    if "oval" in at:  # ln (1 + I/(m h²)) falls by 2 (1 − 1/c) δh/r; half of it, with sd the other half: seeds are no ellipses
        more["oval"] = 0.5 * (1 + at["oval"]) * (1 - 1 / seed.inertia) / seed.radius
    usual = model.usual_loss(r, get("corner", 0.0))
    ripple = (get(f"shape-barrier.cos.{r}", 0.0) / 1000, get(f"shape-barrier.sin.{r}", 0.0) / 1000)
    return Way(
        own[0], own[1], own[1] + length, f, math.sin(beta), math.cos(beta), mu,
        level=slope.drive(get("slope", 0.0) + get("level", 0.0), model.runs[r].sign),
        keep=corner_loss.kept(get("corner-loss", 0.0), usual), ripple=ripple, turn=model.turn[r],
        phase=model.phase[r], **more,
    )  # fmt: skip


def resistance_of(model: Model, r: int, own: np.ndarray, at: dict[str, float]) -> Table:
    """Resistance over weight of run r that depends on speed."""
    k, air = at.get("viscous-rolling", 0.0), (model.seed.drag + at.get("drag", 0.0)) * model.runs[r].drag * (1 + own[5])
    power = at.get("drag.exponent", 0.0)
    if not k and not air:
        return NOTHING
    speed = np.linspace(0, model.top, SPEEDS)
    values = viscous_rolling.resistance(speed, k) + drag.resistance(speed, air, model.seed.reynolds_per_speed, power)
    return Table(0.0, float(speed[1]), values)


def predict(model: Model, r: int, own: np.ndarray, at: dict[str, float]) -> np.ndarray:
    """Travel (n,) [m] that the camera reads of run r."""
    key = (r, *own, *(at[n] for n in model.relevant(r)))
    if key not in model.seen:
        if len(model.seen) >= REMEMBERED:
            model.seen.clear()
        model.seen[key] = moved(model, r, own, at)[0]
    return model.seen[key]


def moved(model: Model, r: int, own: np.ndarray, at: dict[str, float], more: Table | None = None, place: Table = NOTHING,
          time: Table = NOTHING, way: Way | None = None) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Travel as read (n,) [m] and true speed (n,) [m/s]; more: a further resistance over speed; place, time: pushes over weight
    along travel and time since release; way: instead of `way_of`."""
    by_speed = resistance_of(model, r, own, at)
    if more is not None:
        grid = more.low + more.step * np.arange(len(more.values))
        known = np.arange(len(by_speed.values)) * by_speed.step + by_speed.low
        by_speed = Table(more.low, more.step, more.values + np.interp(grid, known, by_speed.values))
    # Rows are means: those at one sd before and after the mean time have the same mean, up to the third power of the block.
    run = model.runs[r]
    times = np.column_stack([run.time_s - run.spread_s, run.time_s + run.spread_s])
    x, v = (
        both.reshape(-1, 2).mean(1) for both in travel(times.ravel(), way or way_of(model, r, own, at), by_speed, place, time)
    )
    return x / (1 + at.get(f"scale.{model.runs[r].session}", 0.0)), v
