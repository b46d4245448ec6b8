"""How well one recording tells its quantities, and what else could be true of it.

Rows leave the fitted values open by their noise (linear, but for the onset, whose sd is
that of its profile). What the recording does not tell shifts them: by one prior sd each.
Rivals are the listed effects, each linear beside the fit, and the other modes; a rival
that has less than 5 % of the probability cannot make a 95 % interval fail."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from benchtwin.infer.noise import Noise, Stretch, estimate
from benchtwin.infer.posterior import LISTED_ODDS
from benchtwin.rigs.slide.modes import LETS_GO, MOVING, SET_OFF, STEPS, Found, shifted
from benchtwin.vision.measurement import Quantity

INSIDE_SDS = 1.96
CAN_BE_TRUE = 0.05  # probability from which a rival counts
WORDS = {
    LETS_GO: "the block rests at first",
    MOVING: "the block moves from the first row on",
    SET_OFF: "the block is set off within the recording",
}
SMALL = 0.05  # of a prior sd, for derivatives

Value = Callable[[dict[str, float]], float]  # a quantity of the values by name


@dataclass(frozen=True)
class Nuisance:
    """Something that this recording does not tell: its prior sd, and whether it is the
    same in all recordings of a session."""

    name: str
    sd: float
    common: bool


@dataclass(frozen=True, eq=False)
class Errors:
    """Of a fit; solve (k, n): from a change of the white rows to that of the values;
    shifts: the values' change (k,) by one sd of each nuisance."""

    found: Found
    nuisances: list[Nuisance]
    covariance: np.ndarray
    solve: np.ndarray
    shifts: dict[str, np.ndarray]

    def quantity(self, name: str, unit: str, of: Value) -> Quantity:
        """A function of the values, with its sd."""
        slope = self.slope(of)
        own, here = self.found.own, of(self.found.own)
        variance, common = float(slope @ self.covariance @ slope), 0.0
        for one in self.nuisances:
            if one.sd:
                direct = of(own | {one.name: one.sd}) - here
                part = float(direct + slope @ self.shifts[one.name]) ** 2
                variance += part
                common += part if one.common else 0.0
        sd, together = math.sqrt(variance), math.sqrt(common)
        return Quantity(name, float(here), sd, unit, sd_common=together)

    def slope(self, of: Value) -> np.ndarray:
        """Derivatives (k,) by the values."""
        own, out = self.found.own, []
        for name in self.found.names:
            step = STEPS[name]
            up, down = (of(own | {name: own[name] + d}) for d in (step, -step))
            out.append((up - down) / (2 * step))
        return np.array(out)


def errors_of(
    found: Found, variance: float, nuisances: list[Nuisance], onset_sd: float = 0.0
) -> Errors:
    """variance: of the white rows; onset_sd: by its profile, 0 where there is none."""
    motion, names = found.motion, found.names
    columns = motion.white(found.columns())
    held = np.zeros((0, len(names)))
    if onset_sd:  # with μ_k = μ_s no row shows a small change of the onset
        held = np.zeros((1, len(names)))
        held[0, names.index("onset")] = math.sqrt(variance) / onset_sd
    solve = np.linalg.pinv(np.vstack([columns, held]), rcond=1e-14)[:, : len(columns)]
    plain = np.linalg.pinv(columns, rcond=1e-14)
    covariance = variance * plain @ plain.T
    if onset_sd:
        at = names.index("onset")
        free = max(math.sqrt(covariance[at, at]), 1e-300)
        covariance[at] *= min(1.0, onset_sd / free)
        covariance[:, at] *= min(1.0, onset_sd / free)
        covariance[at, at] = onset_sd**2

    def shift(one: Nuisance) -> np.ndarray:
        if found.mode == LETS_GO:
            return shifted(found, one.name, one.sd)
        slope = found.slope(one.name, SMALL * one.sd)
        return -solve @ motion.white(one.sd * slope)

    shifts = {one.name: shift(one) for one in nuisances if one.sd}
    return Errors(found, nuisances, covariance, solve, shifts)


def noise_of(found: Found) -> Noise:
    """Noise about the fit and the slopes of all effects, so that what may be missing is
    not taken for noise."""
    motion = found.motion
    columns = np.column_stack([found.columns(), *effect_slopes(found).values()])
    rows, left = columns / motion.sigma[:, None], found.residual / motion.sigma
    return estimate([Stretch(rows, left, motion.lag)])


def effect_slopes(found: Found) -> dict[str, np.ndarray]:
    """Change of what is seen (n,) by one prior sd of each effect that acts."""
    motion, out = found.motion, {}
    here = motion.seen(found.mode, found.own)
    for name, effect in motion.model.effects.items():
        if effect.act and not effect.group:
            there = found.own | {name: SMALL * effect.prior_sd}
            change = motion.seen(found.mode, there) - here
            if change.any():
                out[name] = change / SMALL
    return out


@dataclass(frozen=True)
class Rival:
    """Another explanation: odds over the fit, and the value of a quantity if it holds,
    NaN where that is not shown then."""

    odds: float
    words: str
    value: Callable[[Quantity], float]


def rival_effects(
    errors: Errors, variance: float, values: dict[str, Value]
) -> list[Rival]:
    """Each effect, linear beside the fit."""
    found = errors.found
    motion = found.motion
    columns = motion.white(found.columns())
    left = motion.white(found.residual[:, None])[:, 0]
    out = []
    for name, slope in effect_slopes(found).items():
        effect = motion.model.effects[name]
        column = motion.white(slope)
        beside = column - columns @ (errors.solve @ column)
        information, right = (
            float(beside @ column) / variance,
            float(beside @ left) / variance,
        )
        size = right / (1 + information)  # [prior sds]
        if not effect.low <= size * effect.prior_sd <= effect.high:
            continue
        ln_bayes = (size * right - math.log1p(information)) / 2
        moved = -errors.solve @ column * size

        def value(q: Quantity, moved: np.ndarray = moved) -> float:
            return q.value + float(errors.slope(values[q.name]) @ moved)

        odds = LISTED_ODDS * math.exp(min(ln_bayes, 500.0))
        out.append(Rival(odds, effect.wording[0], value))
    return out


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


def unless(rivals: list[Rival], q: Quantity) -> list[str]:
    """Why the interval of a quantity would not hold if a rival were true."""
    whole, out = 1 + sum(r.odds for r in rivals), []
    for rival in rivals:
        share = rival.odds / whole
        value = rival.value(q)
        if share >= CAN_BE_TRUE and not abs(value - q.value) <= INSIDE_SDS * q.sd:
            other = f"is {value:.3g}" if math.isfinite(value) else "is not shown"
            out.append(f"it {other} if {rival.words} (probability {share:.2g})")
    return out
