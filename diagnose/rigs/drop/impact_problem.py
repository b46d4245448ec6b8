"""Impacts as a problem: rows of restitution and of sideways kicks about their baseline, a constant e and a level plate.

Two levels: what was measured badly, and the bounces' own scatter (scatter.py), which a seed's shape makes wide. What shape does
to the mean is left open as well: a seed that is dropped flat bounces otherwise the first time than later, when it turns.
"""

from dataclasses import dataclass, replace

import numpy as np

from diagnose.effects.drop import EFFECTS
from diagnose.effects.drop.hooks import Hits, tilted_kick, tilted_restitution
from diagnose.engine.linear import Reduced
from diagnose.rigs.drop.bounce import Bounces, bounces_of
from diagnose.rigs.drop.friction import KICK_FLOOR, NEARLY_ROUND, Friction, friction_of, sticking, stuck
from diagnose.rigs.drop.impacts import Impacts
from diagnose.rigs.drop.scatter import Scatter, scatter_of

E_FLOOR = 0.003  # bounces of the best balls scatter as much
E_FLOOR_LONG = 0.15  # times the squared elongation: half of what seeds show that are let go nearly flat
ASIDE_FLOOR, ASIDE_LONG = 0.008, 0.4  # of a radius: how far beside its centre a seed is touched; more if let go in any attitude
AGAIN = 0.7  # of that: where on a seed that does not turn
TURNING_M_S = 2.0  # times the elongation: how the speed scatters at which a seed leaves that is struck as it turns
STEP_LN_SPEED = 0.3
SLOW_M_S = 0.25  # below this speed what shape does to e grows no further
IN_IMPACTS = {n: e for n, e in EFFECTS.items() if e.restitution or e.kick}
NUISANCES = {
    "e": 0.3,
    "shape.later": 0.05,
    "shape.slow": 0.02,
    "stick": 0.5,
    "grip": 0.5,
    "turn.first": 1.0,
    "turn.later": 1.0,
    "upright": 1e-3,
}


@dataclass(frozen=True, eq=False)
class ImpactModel:
    """impacts with their bounces; e_rows, kick_rows: which impacts stand in which rows (e first), y (m,) and its roots: inverse
    Cholesky factor of each recording's rows; rows (m,) of recordings; middle: e about which "e" counts; level_sd: doubt of the scatter."""

    impacts: Impacts
    bounces: Bounces
    e_rows: np.ndarray
    kick_rows: np.ndarray
    y: np.ndarray
    blocks: tuple[tuple[np.ndarray, np.ndarray], ...]
    smooth: np.ndarray
    middle: float
    elongation: float
    spun: bool
    friction: Friction
    level_sd: float


def elongation_of(impacts: Impacts) -> float:
    """Median over the recordings of the seeds' elongation (a − c)/(a + c)."""
    return float(np.median(impacts.seeds.elongation))


def model_of(impacts: Impacts, elongation: float | None = None, follows: np.ndarray | None = None) -> ImpactModel | None:
    """None where too few impacts were seen to tell anything from their scatter. follows (R, C): what e may follow from recording to
    recording, which is no scatter."""
    long = elongation_of(impacts) if elongation is None else elongation
    seen = bounces_of(impacts, long)
    spun = bool(impacts.spin_seen.mean() > 0.5) if len(impacts) else False
    e_rows, kick_rows = np.flatnonzero(seen.e_usable), np.flatnonzero(np.isfinite(seen.kick))
    e_scatter = _scatter_of_e(e_rows, seen, impacts, long, follows)
    seen, kick_rows, push = sticking(seen, kick_rows, friction_of(long, spun), impacts, long)
    kick_scatter = _scatter_of_kicks(kick_rows, seen, impacts, push, long)
    found = [(rows, s) for rows, s in ((e_rows, e_scatter), (kick_rows, kick_scatter)) if s is not None]
    if not found:
        return None
    e_rows, kick_rows = (rows if s is not None else rows[:0] for rows, s in ((e_rows, e_scatter), (kick_rows, kick_scatter)))
    model = ImpactModel(
        impacts, seen, e_rows, kick_rows, np.concatenate([seen.e[e_rows], seen.kick[kick_rows]]),
        _blocks(impacts, found), _smooth(seen, impacts, e_rows, kick_rows),
        float(np.median(seen.e[e_rows])) if len(e_rows) else 0.5, long, spun, push, max(s.log_level_sd for _, s in found),
    )  # fmt: skip
    return model


def asked_of(model: ImpactModel) -> tuple[dict, tuple[str, ...], dict[str, float]]:
    """The effects that these impacts can show, the names of all their globals, and the sd of each that every bench has."""
    effects = {n: e for n, e in IN_IMPACTS.items() if _rows_of(n, model)}
    return effects, (*effects, *NUISANCES), known_sd(model)


def refreshed(model: ImpactModel, impacts: Impacts) -> ImpactModel:
    """The same impacts as flights that were fitted otherwise have them; which rows count, and their scatter, stay."""
    seen = bounces_of(impacts, model.elongation)
    seen = stuck(seen, impacts) if model.friction.sticks else seen
    y = np.concatenate([seen.e[model.e_rows], seen.kick[model.kick_rows]])
    return replace(model, impacts=impacts, bounces=seen, y=np.where(np.isfinite(y), y, model.y))


def _rows_of(effect: str, model: ImpactModel) -> bool:
    return bool(len(model.kick_rows if IN_IMPACTS[effect].kick else model.e_rows))


def _scatter(rows, y, design, error, components, floor, **about) -> Scatter | None:
    """The scatter of some rows about a law."""
    here = np.ix_(rows, rows)
    return scatter_of(y[rows], design[rows], error[here], [np.eye(len(rows)), *(c[here] for c in components)], floor, **about)


def _scatter_of_e(
    rows: np.ndarray, seen: Bounces, impacts: Impacts, long: float, follows: np.ndarray | None
) -> Scatter | None:
    """About the law that the rows bear, by AICc, with how the seed lies if that is better still; e itself is nobody's news.

    A ball bounces later as it did first, however it turns.
    """
    floor, most = E_FLOOR + E_FLOOR_LONG * long**2, E_FLOOR + TURNING_M_S * long
    parts = [np.diag((impacts.number > 1) / seen.speed**2), _same_seed(impacts)]

    def about(law: np.ndarray) -> Scatter | None:
        return _scatter(rows, seen.e, law, seen.e_error, parts, floor, asked=1, most=most)

    laws = _e_designs(seen, impacts.number)
    for z in () if follows is None else follows[impacts.recording].T:
        laws.append(np.column_stack([laws[0], z]))
    found = [(scatter, law) for law in laws if (scatter := about(law))]
    if not found:
        return None
    best, law = min(found, key=lambda one: one[0].aicc)
    lying = about(np.column_stack([law, steep])) if (steep := np.nan_to_num(impacts.steep)).any() else None
    return lying if lying and lying.aicc < best.aicc else best


def _scatter_of_kicks(rows: np.ndarray, seen: Bounces, impacts: Impacts, push: Friction, long: float) -> Scatter | None:
    """Beside what friction is known to make of them, about as much of its doubt as their number bears.

    A seed that is nearly round hardly turns, and is touched beside its centre on the same side again."""
    later, sure = impacts.number > 1, push.turn_sd < 0.5
    aside = ASIDE_FLOOR + ASIDE_LONG * long
    usual = (aside, 0.0, AGAIN * aside * (long < NEARLY_ROUND)) if not push.sticks else ()
    beside = seen.kick - sure * np.nan_to_num(push.turn * seen.turn + push.stick * seen.slip)
    design = _kick_design(seen, later, push)
    while design.shape[1] > 1 and len(rows) < 4 * design.shape[1]:
        design = design[:, :-1]
    return _scatter(rows, beside, design, seen.kick_error, [np.diag(later * 1.0), _same_seed(impacts)], KICK_FLOOR, usual=usual)


def _same_seed(impacts: Impacts) -> np.ndarray:
    """(n, n): 1 where two impacts are of one recording, that is of one seed."""
    return (impacts.recording[:, None] == impacts.recording).astype(float)


def _e_designs(seen: Bounces, number: np.ndarray) -> list[np.ndarray]:
    """Laws about which e scatters, from none to one that bends with speed and count.

    The speed is in steps: within a step it is what scatter of the bounce before has made it. But few bounces that lie on a
    curve of the speed itself do not scatter.
    """
    ln = np.log(seen.speed)
    step = STEP_LN_SPEED * np.round(ln / STEP_LN_SPEED)
    one, later, slow, count = np.ones(len(step)), (number > 1) * 1.0, np.exp(-2 * step), np.minimum(number, 5)
    several = [one, step, later, slow, count]
    laws = ([one], [one, later], [one, step], [one, slow], [one, ln, np.exp(-2 * ln)], several)
    return [np.column_stack(law) for law in laws]


def _kick_design(seen: Bounces, later: np.ndarray, push: Friction) -> np.ndarray:
    """What friction makes of the kick, as far as it is not known."""
    one = np.ones(len(seen.kick))
    if push.turn_sd < 0.05:
        return one[:, None]
    turns = [seen.turn] if push.turn_sd < 0.5 else [seen.turn * later, seen.turn * ~later]
    return np.nan_to_num(np.column_stack([one, *turns, seen.slip]))


def _blocks(impacts: Impacts, found) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
    """(rows, inverse Cholesky factor of their covariance) of each recording."""
    size = sum(len(rows) for rows, _ in found)
    whole, recording, at = np.zeros((size, size)), np.zeros(size, dtype=int), 0
    for rows, scatter in found:
        here = slice(at, at + len(rows))
        whole[here, here], recording[here] = scatter.covariance, impacts.recording[rows]
        at += len(rows)
    out = []
    for r in range(len(impacts.names)):
        own = np.flatnonzero(recording == r)
        out.append((own, np.linalg.inv(np.linalg.cholesky(whole[np.ix_(own, own)]))))
    return tuple(out)


def _smooth(seen: Bounces, impacts: Impacts, e_rows: np.ndarray, kick_rows: np.ndarray) -> np.ndarray:
    """(m, s): what e and the kick may depend on beyond every candidate: powers of the speed, the count, how the seed lies."""
    ln, count = np.log(seen.speed), np.minimum(impacts.number, 5) - 2.0
    e = np.column_stack([ln, ln**2, seen.speed, count, count**2, np.nan_to_num(impacts.steep)])[e_rows]
    kick = np.column_stack([-seen.share - 0.6, count, ln])[kick_rows]
    out = np.zeros((len(e) + len(kick), e.shape[1] + kick.shape[1]))
    out[: len(e), : e.shape[1]], out[len(e) :, e.shape[1] :] = e, np.nan_to_num(kick)
    return out


def known_sd(model: ImpactModel) -> dict[str, float]:
    """What shape does to the mean grows as the square of the elongation; more of it is left where the spin is not seen."""
    square, push = model.elongation**2, model.friction
    later = 0.002 + (0.55 if model.spun else 0.8) * square
    known = {"e": NUISANCES["e"], "shape.later": later, "shape.slow": 5e-4 + 0.25 * square, "upright": model.impacts.plumb_sd}
    return known | {"stick": push.stick_sd, "grip": push.grip_sd, "turn.first": push.turn_sd, "turn.later": push.turn_sd}


def predict(model: ImpactModel, values: dict[str, float]) -> np.ndarray:
    """(m,): restitutions, then kicks."""
    seen, later = model.bounces, model.impacts.number > 1
    stick, turn = model.friction.stick + values["stick"], model.friction.turn
    hits = Hits(seen.speed, model.impacts.number, 1 - (stick + values["grip"]) * seen.share, seen.drift)
    shape = later * (values["shape.later"] + values["shape.slow"] / np.maximum(seen.speed, SLOW_M_S) ** 2)
    e = model.middle + values["e"] + shape
    tilt = model.impacts.seeds.tilt[model.impacts.recording]
    e = tilted_restitution(hits, e, tilt)
    kick = stick * np.nan_to_num(seen.slip) + values["upright"] * hits.lever + tilted_kick(hits, tilt)
    kick = kick + (turn + np.where(later, values["turn.later"], values["turn.first"])) * seen.turn
    for name, effect in IN_IMPACTS.items():
        value = values.get(name, 0.0)
        if value and effect.restitution:
            e = effect.restitution(hits, e, value)
        if value and effect.kick:
            kick = kick + effect.kick(hits, value)
    return np.concatenate([e[model.e_rows], kick[model.kick_rows]])


def reduce(model: ImpactModel, names: tuple[str, ...], starts: np.ndarray, values: np.ndarray, extra: np.ndarray | None = None):
    """See Problem.reduce; nothing is a recording's own; extra (K, m)."""
    at = dict(zip(names, values, strict=True))
    seen = predict(model, at)
    columns = []
    for name, value in at.items():
        step = 1e-3 * (IN_IMPACTS[name].prior_sd if name in IN_IMPACTS else NUISANCES[name])
        columns.append((predict(model, at | {name: value + step}) - seen) / step)
    a = np.column_stack([*columns, *([] if extra is None else extra)])
    b = model.y - seen + a[:, : len(values)] @ values
    made = tuple(Reduced(root @ a[own], root @ model.smooth[own], root @ b[own]) for own, root in model.blocks)
    return made, lambda moved: np.zeros(0)
