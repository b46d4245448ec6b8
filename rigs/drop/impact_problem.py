"""Impacts as a problem: rows of restitution and kick about a constant e and a level
plate.

Rows have measuring errors and the bounces' own scatter (variance_components.py), which
grows with elongation. The mean effect of shape is a nuisance: a seed dropped flat
bounces differently at first."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from benchtwin.bench import distributions as stats
from benchtwin.bench.priors import unstated_sd
from benchtwin.infer.effect import Effect
from benchtwin.infer.linear import Reduced
from benchtwin.rigs.drop.effects import EFFECTS
from benchtwin.rigs.drop.effects.hooks import (
    Hits,
    fallen_deeper,
    slowed,
    tilted_kick,
    tilted_restitution,
)
from benchtwin.rigs.drop.first_bounce import first_flat_sd
from benchtwin.rigs.drop.impact_quantities import (
    KICK_FLOOR,
    KICK_PER_ELONGATION,
    KICK_ROUGH,
    NEARLY_ROUND,
    Friction,
    ImpactQuantities,
    friction_of,
    impact_quantities,
    sticking,
    stuck,
)
from benchtwin.rigs.drop.impacts import Impacts
from benchtwin.rigs.drop.nuisances import HEIGHT
from benchtwin.rigs.drop.variance_components import (
    LEAST_FREEDOM,
    Scatter,
    scatter_of,
)

E_FLOOR = unstated_sd("bounce-scatter")  # least scatter of restitution
E_FLOOR_LONG = 0.15  # times elongation²: half the scatter of seeds released nearly flat
ASIDE_FLOOR, ASIDE_LONG = (
    0.008,
    0.4,
)  # contact offset over the radius: floor, and times elongation
AGAIN = 0.7  # share of that which is common to one seed
TURNING_M_S = (
    2.0  # times the elongation: scatter of the rebound speed of a turning seed
)
STEP_LN_SPEED = 0.3
SLOW_M_S = 0.25  # below this speed the effect of shape on e is constant
AIR = "air"  # relative change of the stated drag, as in flights
IN_IMPACTS = {n: e for n, e in EFFECTS.items() if e.restitution or e.kick}
NUISANCES = {
    "e": unstated_sd("restitution"),
    "shape.later": 0.05,
    "shape.slow": 0.02,
    "stick": 0.5,
    "grip": 0.5,
    "turn.first": 1.0,
    "turn.later": 1.0,
    "upright": 1e-3,
    AIR: unstated_sd("drag-coefficient"),
}


@dataclass(frozen=True, eq=False)
class ImpactModel:
    """Impacts with their quantities."""

    impacts: Impacts
    bounces: ImpactQuantities
    e_rows: np.ndarray  # which impacts stand in which rows, e first
    kick_rows: np.ndarray
    y: np.ndarray  # (m,): those rows
    blocks: tuple[
        tuple[np.ndarray, np.ndarray], ...
    ]  # rows and inverse Cholesky factor
    smooth: np.ndarray  # (m, s)
    middle: float  # e about which "e" counts
    elongation: float
    spun: bool
    friction: Friction
    level_sd: float  # of the logarithm of the scatter
    height_sd_mm: dict[str, float]  # of the stated heights of each session, by name
    laws: dict[str, Effect] = field(default_factory=dict)  # found


def elongation_of(impacts: Impacts) -> float:
    """Median over the recordings of the seeds' elongation (a − c)/(a + c); where no
    size is stated at most what the scatter of their impacts lets it be."""
    known = float(np.median(impacts.seeds.elongation))
    if np.isfinite(impacts.seeds.radius).any():
        return known
    seen = impact_quantities(impacts, known)
    law = _e_designs(seen, impacts.number)[-1]
    e = _most_scatter(seen.e, seen.e_usable, law)
    sure = np.diag(seen.kick_error) < KICK_ROUGH**2  # across was seen
    kick = _most_scatter(seen.kick, sure, law[:, :1])
    shown = np.sqrt(e / (2 * E_FLOOR_LONG)), kick / KICK_PER_ELONGATION
    return float(np.nanmin([known, *shown]))


def _most_scatter(y: np.ndarray, rows: np.ndarray, law: np.ndarray) -> float:
    """The greatest sd of rows about a law that they leave at 95 %, NaN for too few."""
    freedom = int(rows.sum()) - law.shape[1]
    if freedom < LEAST_FREEDOM:
        return np.nan
    left = y[rows] - law[rows] @ np.linalg.lstsq(law[rows], y[rows], rcond=None)[0]
    return float(np.sqrt(left @ left / stats.chi2.ppf(0.05, freedom)))


def model_of(
    impacts: Impacts, elongation: float | None = None, follows: np.ndarray | None = None
) -> ImpactModel | None:
    """None where impacts are too few; follows (R, C): of recordings, which is no
    scatter."""
    long = elongation_of(impacts) if elongation is None else elongation
    seen = impact_quantities(impacts, long)
    spun = bool(impacts.spin_seen.mean() > 0.5) if len(impacts) else False
    e_rows, kick_rows = (
        np.flatnonzero(seen.e_usable),
        np.flatnonzero(np.isfinite(seen.kick)),
    )
    e_scatter = _scatter_of_e(e_rows, seen, impacts, long, follows)
    seen, kick_rows, push = sticking(
        seen, kick_rows, friction_of(long, spun), impacts, long
    )
    kick_scatter = _scatter_of_kicks(kick_rows, seen, impacts, push, long)
    found = [
        (rows, s)
        for rows, s in ((e_rows, e_scatter), (kick_rows, kick_scatter))
        if s is not None
    ]
    if not found:
        return None
    e_rows, kick_rows = (
        rows if s is not None else rows[:0]
        for rows, s in ((e_rows, e_scatter), (kick_rows, kick_scatter))
    )
    return ImpactModel(
        impacts,
        seen,
        e_rows,
        kick_rows,
        np.concatenate([seen.e[e_rows], seen.kick[kick_rows]]),
        _blocks(impacts, found),
        _smooth(seen, impacts, e_rows, kick_rows),
        float(np.median(seen.e[e_rows])) if len(e_rows) else 0.5,
        long,
        spun,
        push,
        max(s.log_level_sd for _, s in found),
        _height_sds(impacts),
    )


def _height_sds(impacts: Impacts) -> dict[str, float]:
    """sd [mm] of the stated heights of each session of which some impacts need them."""
    needing = impacts.recording[np.isfinite(impacts.fell)]
    return {height_name(impacts.sessions[r]): impacts.height_sd_mm[r] for r in needing}


def height_name(session: str) -> str:
    """The global by which that session's stated heights are too low."""
    return f"{HEIGHT}:{session}"


def globals_of(model: ImpactModel) -> tuple[dict, tuple[str, ...], dict[str, float]]:
    """Effects that these impacts can show, names of all globals, and the baseline's
    sds."""
    rows = {True: len(model.kick_rows), False: len(model.e_rows)}
    effects = {
        n: e
        for n, e in IN_IMPACTS.items()
        if rows[e.kick is not None] and (not e.needs or e.needs(model.impacts))
    }
    known = known_sd(model) | model.height_sd_mm
    return (
        effects,
        (*effects, *(n for n in NUISANCES if n in known), *model.height_sd_mm),
        known,
    )


def updated(model: ImpactModel, impacts: Impacts) -> ImpactModel:
    """The same rows and scatter with impacts from other fitted flights."""
    seen = impact_quantities(impacts, model.elongation)
    seen = stuck(seen, impacts) if model.friction.sticks else seen
    y = np.concatenate([seen.e[model.e_rows], seen.kick[model.kick_rows]])
    return replace(
        model, impacts=impacts, bounces=seen, y=np.where(np.isfinite(y), y, model.y)
    )


def _scatter(rows, y, design, error, components, floor, **about) -> Scatter | None:
    """The scatter of some rows about a law."""
    here = np.ix_(rows, rows)
    return scatter_of(
        y[rows],
        design[rows],
        error[here],
        [np.eye(len(rows)), *(c[here] for c in components)],
        floor,
        **about,
    )


def _scatter_of_e(
    rows: np.ndarray,
    seen: ImpactQuantities,
    impacts: Impacts,
    long: float,
    follows: np.ndarray | None,
) -> Scatter | None:
    """About the law of least AICc, with the seed's attitude if that is better still."""
    floor, most = E_FLOOR + E_FLOOR_LONG * long**2, E_FLOOR + TURNING_M_S * long
    parts = [np.diag((impacts.number > 1) / seen.speed**2), _one_seed(impacts)]

    def about(law: np.ndarray) -> Scatter | None:
        return _scatter(
            rows, seen.e, law, seen.e_error, parts, floor, asked=1, most=most
        )

    laws = _e_designs(seen, impacts.number)
    if impacts.of_stated_height:
        laws.append(np.column_stack([laws[0], 1 / impacts.fell]))
    for z in () if follows is None else follows[impacts.recording].T:
        laws.append(np.column_stack([laws[0], z]))
    found = [(scatter, law) for law in laws if (scatter := about(law))]
    if not found:
        return None
    best, law = min(found, key=lambda one: one[0].aicc)
    lying = (
        about(np.column_stack([law, steep]))
        if (steep := np.nan_to_num(impacts.steep)).any()
        else None
    )
    return lying if lying and lying.aicc < best.aicc else best


def _scatter_of_kicks(
    rows: np.ndarray,
    seen: ImpactQuantities,
    impacts: Impacts,
    push: Friction,
    long: float,
) -> Scatter | None:
    """Beside what friction makes of them, and as much of its uncertainty as rows
    support."""
    later, sure = impacts.number > 1, push.turn_sd < 0.5
    aside = ASIDE_FLOOR + ASIDE_LONG * long
    usual = (
        (aside, 0.0, AGAIN * aside * (long < NEARLY_ROUND)) if not push.sticks else ()
    )
    beside = seen.kick - sure * np.nan_to_num(
        push.turn * seen.turn + push.stick * seen.slip
    )
    design = _kick_design(seen, later, push)
    while design.shape[1] > 1 and len(rows) < 4 * design.shape[1]:
        design = design[:, :-1]
    parts = [np.diag(later * 1.0), _one_seed(impacts)]
    return _scatter(
        rows, beside, design, seen.kick_error, parts, KICK_FLOOR, usual=usual
    )


def _one_seed(impacts: Impacts) -> np.ndarray:
    """(n, n): 1 where two impacts are of one recording."""
    return (impacts.recording[:, None] == impacts.recording).astype(float)


def _e_designs(seen: ImpactQuantities, number: np.ndarray) -> list[np.ndarray]:
    """Laws about which e scatters, from a constant to one in speed (in steps) and
    count."""
    ln = np.log(seen.speed)
    step = STEP_LN_SPEED * np.round(ln / STEP_LN_SPEED)
    one, later, slow, count = (
        np.ones(len(step)),
        (number > 1) * 1.0,
        np.exp(-2 * step),
        np.minimum(number, 5),
    )
    several = [one, step, later, slow, count]
    laws = (
        [one],
        [one, later],
        [one, step],
        [one, slow],
        [one, ln, np.exp(-2 * ln)],
        several,
    )
    return [np.column_stack(law) for law in laws]


def _kick_design(
    seen: ImpactQuantities, later: np.ndarray, push: Friction
) -> np.ndarray:
    """The unknown part of friction's effect on the kick."""
    one = np.ones(len(seen.kick))
    if push.turn_sd < 0.05:
        return one[:, None]
    turns = (
        [seen.turn] if push.turn_sd < 0.5 else [seen.turn * later, seen.turn * ~later]
    )
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


def _smooth(
    seen: ImpactQuantities, impacts: Impacts, e_rows: np.ndarray, kick_rows: np.ndarray
) -> np.ndarray:
    """(m, s): further smooth dependence of e and kick: powers of speed, count,
    attitude."""
    ln, count = np.log(seen.speed), np.minimum(impacts.number, 5) - 2.0
    e = np.column_stack(
        [ln, ln**2, seen.speed, count, count**2, np.nan_to_num(impacts.steep)]
    )[e_rows]
    kick = np.column_stack([-seen.share - 0.6, count, ln])[kick_rows]
    out = np.zeros((len(e) + len(kick), e.shape[1] + kick.shape[1]))
    out[: len(e), : e.shape[1]], out[len(e) :, e.shape[1] :] = e, np.nan_to_num(kick)
    return out


def known_sd(model: ImpactModel) -> dict[str, float]:
    """Baseline sds; the effect of shape grows as the square of the elongation."""
    square, push = model.elongation**2, model.friction
    known = {
        "e": NUISANCES["e"],
        "shape.later": first_flat_sd(model.elongation, spun=model.spun),
        "shape.slow": 5e-4 + 0.25 * square,
        "upright": model.impacts.plumb_sd,
    }
    timed = model.impacts.seeds.drag[model.impacts.recording[model.impacts.timed]]
    if timed.any():
        sd = model.impacts.seeds.drag_sd[model.impacts.recording[model.impacts.timed]]
        known[AIR] = float(np.median(sd[timed > 0] / timed[timed > 0]))
    return known | {
        "stick": push.stick_sd,
        "grip": push.grip_sd,
        "turn.first": push.turn_sd,
        "turn.later": push.turn_sd,
    }


def predict(model: ImpactModel, values: dict[str, float]) -> np.ndarray:
    """(m,): restitutions, then kicks."""
    seen, later = model.bounces, model.impacts.number > 1
    stick, turn = model.friction.stick + values["stick"], model.friction.turn
    hits = Hits(
        seen.speed,
        model.impacts.number,
        1 - (stick + values["grip"]) * seen.share,
        seen.drift,
        model.impacts.fell,
        model.impacts.timed,
    )
    shape = later * (
        values["shape.later"]
        + values["shape.slow"] / np.maximum(seen.speed, SLOW_M_S) ** 2
    )
    e = model.middle + values["e"] + shape
    tilt = model.impacts.seeds.tilt[model.impacts.recording]
    e = tilted_restitution(hits, e, tilt)
    if values.get(AIR):
        drag = model.impacts.seeds.drag[model.impacts.recording]
        e = slowed(hits, e, values[AIR] * drag)
    kick = (
        stick * np.nan_to_num(seen.slip)
        + values["upright"] * hits.lever
        + tilted_kick(hits, tilt)
    )
    kick = (
        kick
        + (turn + np.where(later, values["turn.later"], values["turn.first"]))
        * seen.turn
    )
    for name, effect in (IN_IMPACTS | model.laws).items():
        value = values.get(name, 0.0)
        if value and effect.restitution:
            e = effect.restitution(hits, e, value)
        if value and effect.kick:
            kick = kick + effect.kick(hits, value)
    whose = np.array([height_name(s) for s in model.impacts.sessions])
    for name in model.height_sd_mm:
        own = whose[model.impacts.recording] == name
        fallen = replace(hits, fell=np.where(own, hits.fell, np.inf))
        e = fallen_deeper(fallen, e, values[name])
    return np.concatenate([e[model.e_rows], kick[model.kick_rows]])


def reduce(
    model: ImpactModel,
    at: dict[str, float],
    extra: np.ndarray | None = None,
    felt: Sequence[tuple[float, np.ndarray]] = (),
) -> tuple[Reduced, ...]:
    """Each recording's rows, linearised; felt: values and columns (m,) of globals of
    the flights, behind the own ones; extra (K, m): further columns."""
    seen, columns = predict(model, at), []
    for name, value in at.items():
        usual = IN_IMPACTS[name].prior_sd if name in IN_IMPACTS else 1.0
        step = 1e-3 * NUISANCES.get(name, usual)
        columns.append((predict(model, at | {name: value + step}) - seen) / step)
    columns += [column for _, column in felt]
    a = np.column_stack([*columns, *([] if extra is None else extra)])
    b = model.y - seen
    b += a[:, : len(columns)] @ np.array([*at.values(), *(value for value, _ in felt)])
    return tuple(
        Reduced(root @ a[own], root @ model.smooth[own], root @ b[own])
        for own, root in model.blocks
    )
