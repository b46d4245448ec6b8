"""How well one recording tells its quantities, and what else could be true of it.

Rows leave the fitted values open by their noise, linear but for the onset, whose sd is
that of its profile. Rivals are the listed effects and another rate of tilting, each
fitted in addition, and the other modes; one that has less than 5 % of the probability
cannot make a 95 % interval fail."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.optimize import minimize_scalar

from benchtwin.infer.noise import Noise, Stretch, estimate
from benchtwin.infer.posterior import LISTED_ODDS
from benchtwin.infer.rivals import CAN_BE_TRUE, Measured, Rival
from benchtwin.rigs.slide.modes import (
    KEEPS,
    LETS_GO,
    MOVING,
    SET_OFF,
    SMALL,
    Found,
    Motion,
    Nuisance,
    descent,
    raised_at,
)
from benchtwin.vision.measurement import Quantity
from benchtwin.vision.motion.least_squares import believed_sds

ROUNDING = 1e-9  # share of a column that is left by rounding
WIDE = 1e8  # steps for derivatives: beyond any value
MISSTATED = 100.0  # times too fast or too slow, a rate that is not as stated
TINY = 1e-4  # of an effect's prior sd, which may bend much within one
WORDS = {
    LETS_GO: "the block rests at first",
    KEEPS: "the block rests at first",
    MOVING: "the block moves from the first row on",
    SET_OFF: "the block is set off within the recording",
}

Value = Callable[[dict[str, float]], float]  # a quantity of the values by name


@dataclass(frozen=True, eq=False)
class Errors:
    """Of a fit; solve (k, n): from a change of the white rows to that of the values;
    covariance (k, k)."""

    found: Found
    covariance: np.ndarray
    solve: np.ndarray

    def quantity(self, name: str, unit: str, of: Value) -> Quantity:
        """A function of the values, with its sd."""
        slope, names = self.slope(of), self.found.names
        variance, common = float(slope @ self.covariance @ slope), 0.0
        prior = np.full(len(names), math.inf)
        for one in self.found.motion.nuisances:
            at = names.index(one.name)
            prior[at] = one.sd
            if one.common:
                common += (
                    float(slope @ self.covariance[:, at]) ** 2
                    / (self.covariance[at, at])
                )
        sd = math.sqrt(variance)
        together = math.sqrt(min(common, variance))
        believed, value = float(believed_sds(slope[None], prior)[0]), of(self.found.own)
        return Quantity(
            name, float(value), sd, unit, sd_common=together, believed_sd=believed
        )

    def slope(self, of: Value) -> np.ndarray:
        """Derivatives (k,) by the values."""
        own, out = self.found.own, []
        for name in self.found.names:
            step = self.found.step(name)
            up, down = (of(own | {name: own[name] + d}) for d in (step, -step))
            out.append((up - down) / (2 * step))
        return np.array(out)


def errors_of(found: Found, widen: float, onset_sd: float = 0.0) -> Errors:
    """widen: of the rows' variance; onset_sd: by its profile, 0 where there is none."""
    motion, names = found.motion, found.names
    columns = motion.white(found.columns()) / (motion.level * math.sqrt(widen))
    # of a value that the rows do not show the sd is wide, not 0
    prior = np.array([1 / (WIDE * found.step(n)) for n in names])
    for one in motion.nuisances:
        prior[names.index(one.name)] = 1 / one.sd
    if onset_sd:  # with μ_k = μ_s no row shows a small change of the onset
        prior[names.index("onset")] = 1 / onset_sd
    inverse = np.linalg.pinv(np.vstack([columns, np.diag(prior)]), rcond=1e-14)
    covariance = inverse @ inverse.T
    if onset_sd:  # as its profile says, whatever the rows say to first order
        at = names.index("onset")
        longer = onset_sd / math.sqrt(covariance[at, at])
        covariance[at] *= longer
        covariance[:, at] *= longer
    solve = inverse[:, : len(columns)] / (motion.level * math.sqrt(widen))
    return Errors(found, covariance, solve)


def noise_of(found: Found, nuisances: list[Nuisance]) -> Noise:
    """Noise about the fit and the slopes of nuisances and effects, so that what may be
    missing is not taken for noise."""
    motion = found.motion
    slopes = [found.slope(n.name, SMALL * n.sd) for n in nuisances if n.sd]
    effects = effect_slopes(found).values()
    columns = np.column_stack([found.columns(), *slopes, *effects])
    rows, left = columns / motion.sigma[:, None], found.residual / motion.sigma
    return estimate([Stretch(rows, left, motion.lag)])


def effect_slopes(found: Found) -> dict[str, np.ndarray]:
    """Change of what is seen (n,) by one prior sd of each effect that acts."""
    motion, out = found.motion, {}
    here = motion.seen(found.mode, found.own)
    for name, effect in motion.model.effects.items():
        if effect.act and not effect.group:
            there = found.own | {name: TINY * effect.prior_sd}
            change = motion.seen(found.mode, there) - here
            if change.any():
                out[name] = change / TINY
    return out


def rival_effects(errors: Errors, values: dict[str, Value]) -> list[Rival]:
    """Each effect that may be true by its slope beside the fit, fitted with it."""
    found = errors.found
    motion = found.motion
    columns = motion.white(found.columns())
    left = motion.white(found.residual[:, None])[:, 0]
    out = []
    for name, slope in effect_slopes(found).items():
        effect = motion.model.effects[name]
        column = motion.white(slope)
        beside = column - columns @ (errors.solve @ column)
        power = float(beside @ column)
        if power < ROUNDING * float(column @ column):  # the fit says the same
            continue
        information = power / motion.level**2
        right = float(beside @ left) / motion.level**2
        size = right / (1 + information)  # [prior sds]
        ln_odds = math.log(LISTED_ODDS) - math.log1p(information) / 2
        if ln_odds + size * right / 2 < math.log(CAN_BE_TRUE):
            continue
        other = _with(found, name, size * effect.prior_sd)
        if not effect.low <= other.own[name] <= effect.high:
            continue
        fall = (found.misfit - other.misfit) / motion.level**2

        def value(q: Measured, own: dict[str, float] = other.own) -> float:
            return q.value + values[q.name](own) - values[q.name](found.own)

        odds = math.exp(min(ln_odds + fall / 2, 500.0))
        out.append(Rival(odds, effect.wording[0], value))
    return out


def _with(found: Found, name: str, size: float) -> Found:
    """The same mode fitted again with an effect, from `size` of it on."""
    effect = found.motion.model.effects[name]
    more = Nuisance(name, effect.prior_sd, True)
    motion = replace(found.motion, nuisances=(*found.motion.nuisances, more))
    return descent(motion, found.mode, found.own | {name: size})


def rival_rate(
    errors: Errors, values: Callable[[Motion], dict[str, Value]]
) -> list[Rival]:
    """That the plate is raised at another rate than stated, of which the slide tells:
    its pull grows by g cos θ dθ/dt. The rate's logarithm is uniform a priori between
    1/MISSTATED and MISSTATED times the stated one. values: functions that give each
    quantity of a motion."""
    found = errors.found
    motion, tilt = found.motion, found.motion.run.tilt
    rate = float(tilt.coefficients[1])
    if not rate or tilt.sensor:
        return []
    # of what is seen, by the rate's logarithm: it turns the plate, and has turned it
    slope = rate * (
        found.slope("rate", SMALL) / tilt.rate_sd
        + tilt.origin * found.slope("level", SMALL) / tilt.level_sd
    )
    columns, column = motion.white(found.columns()), motion.white(slope)
    left = motion.white(found.residual[:, None])[:, 0]
    moved = errors.solve @ column  # what is fitted gives way by that
    beside = column - columns @ moved
    power = float(beside @ column)
    if power < ROUNDING * float(column @ column):  # the fit says the same
        return []
    right = float(beside @ left) / motion.level**2 + sum(
        found.own[one.name] / one.sd**2 * moved[found.names.index(one.name)]
        for one in motion.nuisances
    )
    sd = motion.level / math.sqrt(power)  # of the logarithm
    prior = math.log(min(math.sqrt(2 * math.pi) * sd / (2 * math.log(MISSTATED)), 1.0))
    if right**2 * sd**2 / 2 + prior + math.log(LISTED_ODDS) < math.log(CAN_BE_TRUE):
        return []
    farthest = math.copysign(math.log(MISSTATED), right)
    best = minimize_scalar(
        lambda ln: raised_at(found, math.exp(ln)).misfit,
        bounds=sorted((0.0, farthest)),
        method="bounded",
        options={"xatol": 1e-3},
    )
    factor = math.exp(best.x)
    other = raised_at(found, factor)
    ln_bayes = (found.misfit - other.misfit) / 2 / motion.level**2 + prior
    told, stated = (math.degrees(r) for r in (factor * rate, rate))
    words = f"the plate is raised at {told:.3g}°/s, not at the stated {stated:.3g}°/s"
    there = values(other.motion)
    return [
        Rival(
            LISTED_ODDS * math.exp(min(ln_bayes, 500.0)),
            words,
            lambda q: there[q.name](other.own),
        )
    ]


def share_of_loss(two: Found, one: Found, loss_sd: float) -> float:
    """Probability that a block loses friction when it lets go (`two`, the loss free)
    beside that it keeps it (`one`): seeds do either, so the odds are even, and a loss
    has the prior of the effect, positive (Laplace's approximation)."""
    prior = two.motion.model.effects["kinetic-friction"].prior_sd
    fall = (one.misfit - two.misfit) / two.motion.level**2
    ln_bayes = fall / 2 + math.log(2 * min(loss_sd, prior) / prior)
    return 1 / (1 + math.exp(-min(max(ln_bayes, -500.0), 500.0)))


def mixed(one: Quantity, other: Quantity, share: float) -> Quantity:
    """Mean and sd of a quantity that is `other` with some probability."""
    value = (1 - share) * one.value + share * other.value
    parts = ((1 - share, one), (share, other))
    variance = sum(p * (q.sd**2 + (q.value - value) ** 2) for p, q in parts)
    common = sum(p * q.sd_common**2 for p, q in parts)
    return replace(
        one, value=value, sd=math.sqrt(variance), sd_common=math.sqrt(common)
    )


def rival_modes(best: Found, others: list[tuple[Found, float]]) -> list[Rival]:
    """Other modes, each with the ln of its evidence over that of the best."""

    def value_in(found: Found, q: Quantity) -> float:
        return found.own["friction"] if q.name == "kinetic_friction" else math.nan

    return [
        Rival(
            math.exp(min(ln_odds, 500.0)), WORDS[found.mode], partial(value_in, found)
        )
        for found, ln_odds in others
        if found.mode != best.mode
    ]
