"""What a term without a name may look like in drops: forces in flight, laws of restitution and of the sideways kick."""

import numpy as np

from calibrate.diagnose.drop.sessions import parts_of
from calibrate.diagnose.drop.windows import axes_of, flown
from calibrate.diagnose.law import Family, Law, law_of
from calibrate.diagnose.problem import Fit

FORCE_POWERS = tuple(np.arange(-1.0, 4.01, 0.25))
PLACE_POWERS = (0.5, 1.0, 1.5, 2.0, 3.0)
IMPACT_POWERS = tuple(np.arange(-2.0, 3.01, 0.25))
COUNT_POWERS = (0.5, 1.0, 1.5, 2.0, 3.0)


def law_of_flights(base: Fit) -> Law | None:
    """Forces along and across the motion, along the fall line and sideways, as powers of speed, height and time."""
    return law_of(base, tuple(_force(base, *kind) for kind in (
        ("v_m_s", "along", "speed", FORCE_POWERS), ("v_m_s", "across", "speed", FORCE_POWERS),
        ("v_m_s", "sideways", "speed", FORCE_POWERS), ("z_mm", "along", "height", PLACE_POWERS),
        ("z_mm", "sideways", "height", PLACE_POWERS), ("z_mm", "upright", "height", PLACE_POWERS),
        ("t_s", "sideways", "time", PLACE_POWERS), ("t_s", "upright", "time", PLACE_POWERS),
    )))  # fmt: skip


WAYS = {
    "along": ("along the motion", "against the motion"),
    "across": ("to the left of the motion", "to the right of the motion"),
    "sideways": ("towards +x", "towards −x"),
    "upright": ("upwards", "downwards"),
}


def _force(base: Fit, axis: str, way: str, quantity: str, powers: tuple[float, ...]) -> Family:
    def columns(exponents: np.ndarray):
        found = []
        for part in parts_of(base):
            values = np.abs(axes_of(part)[axis])
            size = values / max(float(np.median(values)), 1e-9)
            push = np.maximum(size, 0.02)[None] ** exponents[:, None, None]
            found.append(push[..., None] * _direction(part, way)[None])
        return found if len(found) > 1 else found[0]

    def say(rises: bool, power: str) -> str:
        return f"a force {WAYS[way][0 if rises else 1]} that goes as {quantity}{power}, in flight only"

    return Family(f"{way} {quantity}", say, columns, powers)


def _direction(part: Fit, way: str) -> np.ndarray:
    """(F, POINTS, 2) unit vectors."""
    speeds = flown(part)[1]
    along = speeds / np.maximum(np.linalg.norm(speeds, axis=-1, keepdims=True), 1e-9)
    fixed = {"sideways": [1.0, 0.0], "upright": [0.0, 1.0]}
    if way in fixed:
        return np.broadcast_to(np.array(fixed[way]), along.shape)
    return along if way == "along" else np.stack([-along[..., 1], along[..., 0]], axis=-1)


def law_of_impacts(base: Fit) -> Law | None:
    """Restitution and kick as powers of the speed of impact, and of how many impacts there have been; restitution by how the
    silhouette lies."""
    model = base.problem.model
    speed, before = model.bounces.speed, model.impacts.number - 1.0
    turned = np.abs(np.nan_to_num(model.impacts.before[:, 2])) * np.nan_to_num(
        model.impacts.seeds.radius[model.impacts.recording]
    )
    families = []
    for kind, what in (("e", "the restitution"), ("kick", "a sideways kick over the change of speed")):
        for quantity, values, powers in (
            ("speed of impact", speed, IMPACT_POWERS), ("number of impacts before", before, COUNT_POWERS),
            ("spin over speed", turned / speed, COUNT_POWERS),
        ):  # fmt: skip
            if np.ptp(values) > 0:
                families.append(_impact(model, kind, what, quantity, values, powers))
    if np.isfinite(model.impacts.steep[model.e_rows]).any():
        families.append(_lying(model))
    return law_of(base, tuple(families))


def _lying(model) -> Family:
    """−cos 2α, α of the silhouette's long axis."""
    steep = np.nan_to_num(model.impacts.steep)[model.e_rows]

    def columns(exponents: np.ndarray) -> np.ndarray:
        return np.concatenate([steep, np.zeros(len(model.kick_rows))]) * np.ones((len(exponents), 1))

    def say(rises: bool, power: str) -> str:
        more = "greater" if rises else "less"
        return f"the restitution is {more} for a silhouette on end than for one that lies, in impacts only"

    return Family("e steepness", say, columns, (1.0,))


def _impact(model, kind: str, what: str, quantity: str, values: np.ndarray, powers: tuple[float, ...]) -> Family:
    usual = float(np.median(values[values > 0]))

    def columns(exponents: np.ndarray) -> np.ndarray:
        size = values[None] / usual
        change = np.where(size > 0, np.maximum(size, 1e-9) ** exponents[:, None], 0.0)
        # a power of nil is a constant, which the baseline has: its neighbour, the logarithm, stands for it
        flat = np.where(size > 0, np.log(np.maximum(size, 1e-9)), 0.0) * np.ones_like(change)
        change = np.where(np.abs(exponents[:, None]) < 1e-9, flat, change * np.sign(exponents[:, None] + 1e-12))
        nil = np.zeros_like(change)
        e, kick = (change, nil) if kind == "e" else (nil, change)
        return np.hstack([e[:, model.e_rows], kick[:, model.kick_rows]])

    def say(rises: bool, power: str) -> str:
        if kind == "e":
            return f"the restitution {'rises' if rises else 'falls'} with {quantity}{power}, in impacts only"
        return f"{what} towards {'+x' if rises else '−x'} that goes as {quantity}{power}, in impacts only"

    return Family(f"{kind} {quantity}", say, columns, powers)
