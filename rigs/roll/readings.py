"""Run-outs read off with a ruler, as a problem: each recording from its own keys.

A seed that rolls down the way S of an incline β runs out by

    L = S (sin β − μ cos β) (1 − c)² / (μ + s sin θ)

μ rolling friction, c the share of the speed that the corner takes, s = ± 1 the
direction, θ the slope of the plate. The data are ln L; what a reading scatters by is
estimated within the recordings."""

import math
from dataclasses import dataclass, replace

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.bench.run_out import rolling_friction
from benchtwin.infer.finding import Curve
from benchtwin.infer.noise import Noise
from benchtwin.infer.problem import Fit, Problem
from benchtwin.infer.series import Locals, Series, problem_of
from benchtwin.infer.unlisted import Windows
from benchtwin.rigs.roll.effects import EFFECTS
from benchtwin.rigs.roll.effects.corner import usual_loss
from benchtwin.rigs.roll.effects.slope import SLOPE, drive
from benchtwin.rigs.roll.problem import (
    LENGTH_SD_M,
    MU_SD,
    PRIORS,
    level_sd_deg,
    unknown_scatter,
)
from benchtwin.rigs.roll.session import stated_slope_deg

LEAST_READINGS = 3  # in either direction, for a slope
BALL = 1.4  # 1 + I/mr², for what the corner may take at most
USUAL_FREEDOM = 2  # degrees of freedom that the usual scatter is worth
SIGNS = {"+x": 1.0, "-x": -1.0}


@dataclass(frozen=True)
class Ruler:
    """The readings of one recording, with its own keys."""

    recording: str
    session: str
    description: dict
    run_out_m: np.ndarray
    incline: float  # [rad]
    length_m: float
    sign: float
    slope_deg: float  # stated, falling towards +x; NaN

    def friction(self) -> float:
        """Rolling friction on a level plate of the mean run-out."""
        mean, incline_deg = self.run_out_m.mean(), math.degrees(self.incline)
        return rolling_friction(self.length_m, incline_deg, mean)[0]


@dataclass(frozen=True)
class RulerModel:
    """All recordings, and what does not change in a fit."""

    rulers: tuple[Ruler, ...]
    mu: float

    def run_out_m(self, r: int, own: np.ndarray, at: dict[str, float]) -> float:
        """Run-out of recording r for its locals (friction, incline) and the globals."""
        one = self.rulers[r]
        beta = one.incline + math.radians(own[1] + at["incline"])
        mu = self.mu * (1 + at["mu"]) * (1 + own[0])
        way = (one.length_m + at["length"]) * (math.sin(beta) - mu * math.cos(beta))
        keep = 1 - usual_loss(beta, BALL, mu, at["corner"])
        stated = 0.0 if math.isnan(one.slope_deg) else one.slope_deg
        along = drive(stated + at["level"] + at.get(SLOPE, 0.0), one.sign)
        return max(way, 1e-6) * keep**2 / max(mu - along, 1e-6)


def rulers_of(recordings) -> tuple[tuple[Ruler, ...], tuple[str, ...]]:
    """Readings with the keys that they need, and notes on those without; ValueError
    where none has them."""
    found, notes = [], []
    for r in recordings:
        told = r.description["roll"]
        lengths = r.run_out_mm[r.run_out_mm > 0] / 1000
        absent = [k for k in ("incline_deg", "incline_length_mm") if not told.get(k)]
        if absent or not len(lengths):
            why = (
                tr("[roll] {} missing", tr(" and ").join(absent))
                if absent
                else tr("no run-out")
            )
            notes.append(
                tr("{}: {}: its readings cannot be compared", r.recording, why)
            )
            continue
        found.append(
            Ruler(
                r.recording,
                r.session,
                r.description,
                lengths,
                math.radians(told["incline_deg"]),
                told["incline_length_mm"] / 1000,
                SIGNS[told.get("direction") or "+x"],
                stated_slope_deg(told),
            )
        )
    if not found:
        raise ValueError(
            tr(
                "[roll] incline_deg and incline_length_mm are missing; without them"
                " run-outs do not give a slope"
            )
        )
    return tuple(found), tuple(notes)


def tells_a_slope(rulers: tuple[Ruler, ...]) -> bool:
    """Whether both directions have LEAST_READINGS."""
    count = {s: 0 for s in SIGNS.values()}
    for one in rulers:
        count[one.sign] += len(one.run_out_m)
    return min(count.values()) >= LEAST_READINGS


def ruler_problem(rulers: tuple[Ruler, ...]) -> Problem:
    """Nuisances and their priors are those of a roll that is filmed."""
    model = RulerModel(rulers, float(np.median([one.friction() for one in rulers])))
    data = [np.log(one.run_out_m) for one in rulers]
    freedom = USUAL_FREEDOM + sum(len(y) - 1 for y in data)
    power = USUAL_FREEDOM * MU_SD**2 + sum(float(y.var() * len(y)) for y in data)
    sd, noise = math.sqrt(power / freedom), Noise(0.0, 0.0, math.sqrt(2 / freedom))
    series = tuple(
        Series(
            one.recording,
            y,
            sd,
            np.full(len(y), np.inf),
            noise,
            np.zeros((len(y), 0)),
        )
        for one, y in zip(rulers, data, strict=True)
    )
    own = Locals(
        np.zeros((len(rulers), 2)),
        np.array([1e-6, 1e-5]),
        np.array([MU_SD, PRIORS["incline"]]),
    )
    both_ways = tells_a_slope(rulers)
    effects = {SLOPE: EFFECTS[SLOPE]} if both_ways else {}
    stated = all(math.isfinite(r.slope_deg) for r in rulers)
    level = level_sd_deg(stated, both_ways)
    sizes = {"mu": 0.1, "incline": 0.1, "level": level, "corner": 1.0}
    known = PRIORS | {"level": level}

    def predict(r: int, own: np.ndarray, at: dict[str, float]) -> np.ndarray:
        ln = math.log(model.run_out_m(r, own, at))
        return np.full(len(rulers[r].run_out_m), ln)

    made = problem_of(
        "roll",
        series,
        own,
        predict,
        effects,
        sizes | {"length": LENGTH_SD_M},
        known | {"length": LENGTH_SD_M},
        model,
    )
    return replace(made, unknown_scatter=unknown_scatter)


def no_windows(fit: Fit) -> Windows:
    """Run-outs show no motion in which unlisted physics would have a place."""
    return Windows(None, ())


def curves_of(base: Fit, model: Fit) -> tuple[Curve, ...]:
    """The readings of each recording one after another."""
    out = []
    for r, one in enumerate(base.problem.model.rulers):
        left = [
            1e3
            * (one.run_out_m - of.problem.model.run_out_m(r, of.starts[r], of.by_name))
            for of in (base, model)
        ]
        number, seen = np.arange(1.0, 1 + len(one.run_out_m)), 1e3 * one.run_out_m
        out.append(
            Curve(one.recording, "run-out", "mm", "reading", number, seen, *left)
        )
    return tuple(out)
