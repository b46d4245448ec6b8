"""Unlisted physics of drops: forces in flight, a drifting clock, e and kicks; power
laws."""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from benchtwin.bench.air import speed_through_air
from benchtwin.bench.constants import G_M_S2
from benchtwin.bench.language import tr
from benchtwin.infer import power_law
from benchtwin.infer.power_law import (
    Family,
    Law,
    counterpart,
    raised,
    reference,
    risen,
)
from benchtwin.infer.problem import Fit
from benchtwin.infer.unlisted import Bin, Windows
from benchtwin.rigs.drop.effects.hooks import Hits, Motion
from benchtwin.rigs.drop.flight_model import pushed
from benchtwin.rigs.drop.joint_problem import JointModel, session_fits
from benchtwin.rigs.drop.trajectories import NODES, positions_at_nodes

BINS, IMPACT_BINS = 6, 4
FORCE_POWERS = tuple(np.arange(-1.0, 4.01, 0.25))
PLACE_POWERS = (0.5, 1.0, 1.5, 2.0, 3.0)
IMPACT_POWERS = tuple(np.arange(-2.0, 3.01, 0.25))
KICK_POWERS = tuple(p for p in IMPACT_POWERS if p)  # 0 is a tilt or a camera's roll
SPEED, COUNT = "speed of impact", "number of impacts before"
WAYS = {
    "along": ("along the motion", "against the motion"),
    "sideways": ("towards +x", "towards −x"),
    "upright": ("upwards", "downwards"),
}
FORCES = (
    ("v_m_s", "along", "speed", FORCE_POWERS),
    ("v_m_s", "sideways", "speed", FORCE_POWERS),
    ("v_m_s", "upright", "speed", FORCE_POWERS),
    ("z_mm", "sideways", "height", PLACE_POWERS),
    ("z_mm", "upright", "height", PLACE_POWERS),
    ("t_s", "sideways", "time", PLACE_POWERS),
    ("t_s", "upright", "time", PLACE_POWERS),
)


def windows_of(fit: Fit) -> Windows:
    """Unit accelerations in every bin; a drifting clock; changes of e and kick
    likewise."""
    joint: JointModel = fit.problem.model
    parts = session_fits(fit)
    about = [_axes(part) for part in parts]
    edges = (
        {axis: _edges([a[axis] for a, _, _ in about], axis) for axis in about[0][0]}
        if about
        else {}
    )
    bins: list[Bin] = []
    pushes: list[list[np.ndarray]] = [[] for _ in parts]
    for way in ("along", "aside", "upright"):
        for axis, found in edges.items():
            bins += [Bin(axis, low, high, way, "flight") for low, high in found]
            for k, (axes, _, speeds) in enumerate(about):
                ways = _direction(speeds, "sideways" if way == "aside" else way)
                pushes[k] += [
                    ((axes[axis] >= low) & (axes[axis] <= high))[..., None] * ways
                    for low, high in found
                ]
    if parts:
        bins.append(
            Bin(
                "t_s",
                0.0,
                float(max(a["t_s"].max() for a, _, _ in about)),
                tr("drift of the clock"),
                "measurement",
            )
        )
    for k, (axes, _, speeds) in enumerate(
        about
    ):  # t' = t + c t²: a seed seems pushed by 4 c t g upright less 2 c v
        pushes[k].append(
            4 * axes["t_s"][..., None] * G_M_S2 * np.array([0.0, 1.0]) - 2 * speeds
        )
    if joint.impacts is None:
        return Windows(([np.array(p) for p in pushes], None), tuple(bins))
    columns, struck = _impact_windows(joint.impacts_at(fit.starts, fit.values))
    return Windows(([np.array(p) for p in pushes], columns), (*bins, *struck))


def _axes(part: Fit) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray]:
    """Where the flights' nodes (F, POINTS) lie on each axis; places and velocities
    there."""
    s = part.problem.model.session
    places, speeds = positions_at_nodes(
        part.starts, s.half, pushed(part.problem.model, part.starts, part.by_name)
    )
    begun = np.array(
        [
            s.middle[s.recording == r].min() - s.half[s.recording == r].max()
            for r in s.recording
        ]
    )
    number = np.array(
        [int((s.recording[:f] == s.recording[f]).sum()) for f in range(len(s.middle))]
    )
    floor = np.array([places[s.recording == r, :, 1].min() for r in s.recording])
    axes = {
        "t_s": s.middle[:, None] + s.half[:, None] * NODES - begun[:, None],
        "z_mm": 1e3 * (places[..., 1] - floor[:, None]),
        "v_m_s": np.linalg.norm(speeds, axis=-1),
        "n_bounce": number[:, None] * np.ones_like(NODES),
    }
    return axes, places, speeds


def _edges(values: list[np.ndarray], axis: str) -> list[tuple[float, float]]:
    """Bins of equal width; of the bounce count one a flight, none for a single
    flight."""
    top = max(float(v.max()) for v in values)
    if axis == "n_bounce":
        return [(k - 0.5, k + 0.5) for k in range(int(top) + 1)] if top >= 1 else []
    return [
        (float(a), float(b))
        for a, b in pairwise(
            np.linspace(min(float(v.min()) for v in values), top, BINS + 1)
        )
    ]


def _direction(speeds: np.ndarray, way: str) -> np.ndarray:
    """(F, POINTS, 2) unit vectors."""
    fixed = {"sideways": [1.0, 0.0], "upright": [0.0, 1.0]}
    if way in fixed:
        return np.broadcast_to(np.array(fixed[way]), speeds.shape)
    return speeds / np.maximum(np.linalg.norm(speeds, axis=-1, keepdims=True), 1e-9)


def _impact_windows(model) -> tuple[np.ndarray, tuple[Bin, ...]]:
    """Changes of e and kick in bins of speed and count; of e with spin and attitude."""
    speed, count, columns, bins = model.bounces.speed, model.impacts.number, [], []
    axes = {
        "v_m_s": (
            speed,
            list(
                pairwise(
                    np.unique(np.quantile(speed, np.linspace(0, 1, IMPACT_BINS + 1)))
                )
            ),
        ),
        "n_bounce": (
            np.minimum(count, 5),
            [(k - 0.5, k + 0.5) for k in np.unique(np.minimum(count, 5))],
        ),
    }
    for kind in ("e", "kick"):
        for axis, (values, found) in axes.items():
            for low, high in found:
                inside = ((values >= low) & (values <= high)).astype(float)
                if not inside.all():
                    columns.append(_on_rows(model, inside, kind))
                    bins.append(Bin(axis, float(low), float(high), kind, "impact"))
    for name, values in _singles(model).items():
        columns.append(_on_rows(model, values, "e"))
        bins.append(
            Bin("n_bounce", 0.5, float(count.max()) + 0.5, f"e by {name}", "impact")
        )
    return np.array(columns).reshape(-1, len(model.y)), tuple(bins)


def _singles(model) -> dict[str, np.ndarray]:
    """Linear regressors of e: spin over speed, and −cos 2α of the silhouette's long
    axis."""
    radius = np.nan_to_num(model.impacts.seeds.radius[model.impacts.recording])
    spin = (
        np.abs(np.nan_to_num(model.impacts.before[:, 2])) * radius / model.bounces.speed
    )
    found = {
        "spin": np.minimum(spin, 1.0),
        "attitude": np.nan_to_num(model.impacts.steep),
    }
    return {name: v - v.mean() for name, v in found.items() if np.ptp(v) > 0}


def _on_rows(model, values: np.ndarray, kind: str) -> np.ndarray:
    nil = np.zeros_like(values)
    e, kick = (values, nil) if kind == "e" else (nil, values)
    return np.concatenate([e[model.e_rows], kick[model.kick_rows]])


def law_of(fit: Fit) -> Law:
    """A force in flight, or restitution and kick, as powers; restitution by spin and
    attitude."""
    joint: JointModel = fit.problem.model
    parts = session_fits(fit)
    about = [_axes(part) for part in parts]
    pushes: list[list[np.ndarray]] = [[] for _ in parts]
    families: list[Family] = []
    for axis, way, quantity, powers in FORCES if parts else ():
        seen = np.concatenate([np.abs(a[axis]).ravel() for a, _, _ in about])
        most = reference(float(seen.max()))
        one = _force(axis, way, quantity, powers, most)
        families.append(replace(one, least=float(seen.min()) / most))
        for k, (axes, _, speeds) in enumerate(about):
            for p in powers:
                size = G_M_S2 * raised(np.abs(axes[axis]) / most, p)
                pushes[k].append(size[..., None] * _direction(speeds, way))
    struck = None
    if joint.impacts is not None:
        more, struck = _of_impacts(joint.impacts_at(fit.starts, fit.values))
        families += more
    return power_law.law_of(fit, families, ([np.array(p) for p in pushes], struck))


def _force(axis: str, way: str, quantity: str, powers, most: float) -> Family:
    along = way == "along"
    unit = {"v_m_s": "m/s", "z_mm": "mm", "t_s": "s"}[axis]

    def say(rises: bool, power: str) -> str:
        where = tr(WAYS[way][0 if rises else 1])
        return tr(
            "a force {} that goes as {} {}, in flight only", where, tr(quantity), power
        )

    def acts(name: str, power: float) -> dict:
        def acceleration(motion: Motion, value: float) -> np.ndarray:
            speed = speed_through_air(motion.velocity, motion.aside_square)
            size = value * motion.g * raised(speed / most, power)
            return size * motion.velocity / speed

        return {
            "acceleration": acceleration,
            "counterpart": counterpart(
                tr("a force along the motion over the weight is"),
                "push_power",
                "weights",
                name,
                most,
                power,
            ),
        }

    return Family(
        say,
        ("1", tr("of the weight at {:g} {}", most, unit)),
        "flight",
        powers,
        quantity,
        acts if along and axis == "v_m_s" else None,
        tr(
            "the twin's air knows no force {} that goes with {}",
            tr(WAYS[way][0]),
            tr(quantity),
        ),
    )


def _of_impacts(model) -> tuple[list[Family], np.ndarray]:
    """Restitution and kick as powers of speed and count; restitution by spin and
    attitude; and their columns."""
    before, speed = model.impacts.number - 1.0, model.bounces.speed
    usual, most = reference(float(np.median(speed))), max(float(before.max()), 1.0)
    families, columns = [], []
    for kind, quantity, over, about, form, powers in (
        ("e", SPEED, speed, usual, risen, IMPACT_POWERS),
        ("e", COUNT, before, most, raised, PLACE_POWERS),
        ("kick", SPEED, speed, usual, raised, KICK_POWERS),
        ("kick", COUNT, before, most, raised, PLACE_POWERS),
    ):
        if np.ptp(over) > 0:
            families.append(_struck(kind, quantity, about, powers))
            columns += [_on_rows(model, form(over / about, p), kind) for p in powers]
    for name, values in _singles(model).items():
        families.append(_single(name))
        columns.append(_on_rows(model, values, "e"))
    return families, np.array(columns).reshape(-1, len(model.y))


def _struck(kind: str, quantity: str, about: float, powers) -> Family:
    by_speed = quantity == SPEED
    where = tr("at {:g} m/s", about) if by_speed else tr("after {:g} impacts", about)
    if kind == "e" and by_speed:
        where = tr("for each factor e of speed {}", where)

    def say(rises: bool, power: str) -> str:
        if kind == "e":
            how = tr("rises") if rises else tr("falls")
            return tr(
                "the restitution {} with {} {}, in impacts only",
                how,
                tr(quantity),
                power,
            )
        return tr(
            "a sideways kick over the change of speed towards {} that goes as {} {}, in"
            " impacts only",
            "+x" if rises else "−x",
            tr(quantity),
            power,
        )

    def acts(name: str, power: float) -> dict:
        def restitution(hits: Hits, e: np.ndarray, value: float) -> np.ndarray:
            return e + value * risen(hits.speed / about, power)

        return {
            "restitution": restitution,
            "counterpart": counterpart(
                tr("restitution changes with the logarithm of impact speed v by"),
                "restitution_power",
                "slope",
                name,
                about,
                power,
            ),
        }

    return Family(
        say,
        ("1", where),
        "impact",
        powers,
        quantity,
        acts if kind == "e" and by_speed else None,
        (
            tr("the twin's impacts know no such kick")
            if by_speed
            else tr("the twin's seeds do not remember their impacts")
        ),
    )


def _single(name: str) -> Family:
    words = {
        "spin": tr("with spin over speed"),
        "attitude": tr("from a seed that lies to one on end"),
    }[name]

    def say(rises: bool, power: str) -> str:
        return tr(
            "the restitution {} {}, in impacts only",
            tr("rises") if rises else tr("falls"),
            words,
        )

    return Family(
        say,
        ("1", tr("in all")),
        "impact",
        not_simulated=tr("the twin's restitution does not change {}", words),
    )
