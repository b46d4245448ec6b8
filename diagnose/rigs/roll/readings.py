"""Run-outs read by eye: only those in both directions tell a slope.

With rolling friction μ and slope θ rising along +x,  L₊ (μ + θ) = L₋ (μ − θ) = S (sin β − μ cos β).
"""

import math

import numpy as np
from scipy import stats

from diagnose.engine.alarm import ALARM_P as ALPHA
from diagnose.finding import Finding, Parameter, Sector
from diagnose.rigs.roll.problem import PRIORS

LEAST_READINGS = 3  # in either direction


def diagnose_readings(recordings) -> Finding:
    """Slope from both directions; ValueError where incline or length are not stated."""
    names = tuple(r.recording for r in recordings)
    ways = {s: [r for r in recordings if (r.description["roll"].get("direction") or "+x") == s] for s in ("+x", "-x")}
    values = {s: np.concatenate([r.run_out_mm for r in found] or [np.zeros(0)]) for s, found in ways.items()}
    if min(len(v) for v in values.values()) < LEAST_READINGS:
        note = f"run-outs alone tell nothing of what is missing; {LEAST_READINGS} readings in either direction would tell a slope"
        return _finding(names, 1.0, None, float("nan"), (note,), "the same plate run the other way, or a film of the roll")
    told = recordings[0].description["roll"]
    if not told.get("incline_deg") or not told.get("incline_length_mm"):
        raise ValueError("[roll] incline_deg and incline_length_mm are missing; without them run-outs do not give a slope")
    slope, sd, p, freedom = _slope(values, told)
    bayes = 0.5 * stats.chi2.isf(max(p, 1e-300), 1) - 0.5 * math.log1p((0.5 / sd) ** 2)
    half = sd * float(stats.t.isf(0.025, freedom))
    return _finding(names, p, Parameter("deg", slope, slope - half, slope + half), bayes, (), None)


def _slope(values: dict[str, np.ndarray], told: dict) -> tuple[float, float, float, float]:
    """Slope [deg], sd, p on a level plate, degrees of freedom (Welch)."""
    beta, way = math.radians(told["incline_deg"]), told["incline_length_mm"]
    plus, minus = (float(values[s].mean()) for s in ("+x", "-x"))
    share = {s: float(values[s].var(ddof=1)) / len(values[s]) for s in values}

    def solve(a: float, b: float) -> float:
        """θ of run-outs a, b: μ + θ = E/a, μ − θ = E/b, E = S (sin β − μ cos β)."""
        half = (1 / a + 1 / b) / 2
        mu = half * way * math.sin(beta) / (1 + half * way * math.cos(beta))
        energy = way * (math.sin(beta) - mu * math.cos(beta))
        return math.degrees(math.asin(float(np.clip(energy * (1 / a - 1 / b) / 2, -0.5, 0.5))))

    slope, step = solve(plus, minus), 1e-3
    by_plus, by_minus = (solve(plus + step, minus) - slope) / step, (solve(plus, minus + step) - slope) / step
    parts = by_plus**2 * share["+x"], by_minus**2 * share["-x"]
    sd = math.sqrt(sum(parts) + PRIORS["level"]**2)
    freedom = sum(parts) ** 2 / sum(v**2 / (len(values[s]) - 1) for v, s in zip(parts, ("+x", "-x"), strict=True))
    return slope, sd, float(2 * stats.t.sf(abs(slope) / sd, freedom)), freedom


def _finding(names, p: float, slope: Parameter | None, bayes: float, notes, advice: str | None) -> Finding:
    """A finding with a slope, or with none."""
    seen = slope if p < ALPHA else None
    alarm = seen is not None
    named = {"slope": seen} if seen and bayes > 5 and seen.low95 * seen.high95 > 0 else {}
    verdict = "name" if named else "class" if alarm else "none"
    sectors = (Sector("run-out", 1.0 if alarm else float("nan"), p),)
    return Finding(
        "roll", names, alarm, p, sectors, None, "", verdict, ("slope",) if alarm else (), bayes if alarm else float("nan"),
        bayes if alarm else float("nan"), named, None, None,
        advice if not alarm else None if named else "more run-outs in either direction, or a film of the roll",
        notes=tuple(notes),
    )  # fmt: skip
