"""Impacts run again in the DEM at recorded speed and spin, averaged over attitudes of
the seed."""

from dataclasses import replace

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.diagnose.rerun import (
    Comparison,
    Resimulation,
    condition_shifts,
    secant,
    simulation_settings,
    values_by_recording,
)
from benchtwin.infer.finding import Finding
from benchtwin.rigs.drop.effects import EFFECTS
from benchtwin.rigs.drop.fall_laws import viscoelastic, yielding
from benchtwin.rigs.drop.flown import strike
from benchtwin.rigs.drop.impacts import (
    Impacts,
    concatenated,
    impacts_from_times,
    impacts_of,
    subset,
    usable_rows,
)
from benchtwin.rigs.drop.joint_problem import (
    PreparedSession,
    fit_flights,
    session_fits,
)
from benchtwin.twin.parameters import Parameters

WAYS = 8  # attitudes at each impact
COLUMNS = {"kick": "sideways kick", "e": "restitution of a bounce"}
LIMITS = (0.02, 0.98)
NUMBERS_OF_FALL = {
    "restitution_viscoelastic": viscoelastic,
    "restitution_plastic": yielding,
}


def at_anchor(
    law: str, numbers: dict[str, float], e: float, anchor: float
) -> dict[str, float]:
    """Numbers of a law whose restitution is `e` at `anchor` [m/s]."""
    if "fall" in numbers:
        return NUMBERS_OF_FALL[law](numbers["fall"], e, anchor)
    if "slope" in numbers:  # of a power of speed, which is the same about any speed
        steeper = (anchor / numbers["speed"]) ** numbers["power"]
        own = {"slope": numbers["slope"] * steeper, "speed": anchor}
        return numbers | own
    return numbers


def strikes_again(
    again: Resimulation,
    finding: Finding,
    tracks: list,
    sessions: tuple[PreparedSession, ...],
) -> Resimulation:
    """`again` with the bounces of both simulations beside the recorded ones."""
    seen, told = impacts_seen(tracks, sessions), next(t.description for t in tracks)
    laws = EFFECTS | finding.laws
    names = [
        n
        for n in finding.modelled
        if n in laws and (laws[n].restitution or laws[n].kick)
    ]
    own = {r: {n: v[n] for n in names} for r, v in values_by_recording(finding).items()}
    whole = {n: float(np.mean([v[n] for v in own.values()])) for n in names}
    more = condition_shifts(finding)
    speeds = float(np.median(-seen.before[:, 1]))
    unchanged: dict[str, dict] = {}
    changes = (unchanged, simulation_settings("drop", whole, finding.laws))
    old, new = (calibrated(seen, told, speeds, change) for change in changes)
    before = outcome(seen, told, old, speeds, {})
    after = {key: values.copy() for key, values in before.items()}
    for r, name in enumerate(seen.names):
        mine = np.flatnonzero(seen.recording == r)
        if not len(mine):
            continue
        e = float(np.clip(new + more.get(name, 0.0), *LIMITS))
        change = simulation_settings("drop", own.get(name, whole), finding.laws)
        ours = outcome(subset(seen, mine), told, e, speeds, change)
        for key, found in ours.items():
            after[key][mine] = found
    key = "kick" if names and all(laws[n].kick for n in names) else "e"
    recorded = observed(seen)
    unit, off = (
        "m/s" if key == "kick" else "1",
        [recorded[key] - twin[key] for twin in (before, after)],
    )
    rows = []
    for r, name in enumerate(seen.names):
        if (mine := seen.recording == r).any():
            old_rms, new_rms = (
                float(np.sqrt((values[mine] ** 2).mean())) for values in off
            )
            rows.append(
                Comparison(name, COLUMNS[key], unit, old_rms, new_rms, "impacts")
            )
    how = tr(
        "each impact was run by the DEM at its recorded speed and spin, {} ways of"
        " lying averaged; so that bounces are as high as recorded on average,"
        " restitution at {:.2g} m/s is {:.3f} in the old and {:.3f} in the new twin",
        WAYS,
        speeds,
        old,
        new,
    )
    how = f"{again.how}; {how}" if again.how else how
    named = {"recorded": recorded, "old twin": before, "new twin": after}
    points = {n: (-seen.before[:, 1], values[key]) for n, values in named.items()}
    figure = {
        "x": tr("impact speed (m/s)"),
        "y": COLUMNS[key] + ("" if unit == "1" else " (m/s)"),
        "points": points,
    }
    return replace(again, compared=(*again.compared, *rows), how=how, figure=figure)


def impacts_seen(tracks: list, sessions: tuple[PreparedSession, ...]) -> Impacts:
    """All impacts, filmed or heard, that are fast enough to be used."""
    listened = [t for t in tracks if not len(t.frame)]
    parts = []
    if sessions:
        flights = session_fits(fit_flights(sessions))
        parts = [
            impacts_of(part, s.noise, s.tracks)
            for part, s in zip(flights, sessions, strict=True)
        ]
    if listened:
        parts.append(impacts_from_times(listened))
    table = concatenated(parts)
    return subset(table, usable_rows(table))


def observed(seen: Impacts) -> dict[str, np.ndarray]:
    """Restitution (n,) and sideways kick [m/s] of each impact."""
    return {
        "e": -seen.after[:, 1] / seen.before[:, 1],
        "kick": seen.after[:, 0] - seen.before[:, 0],
    }


def outcome(
    seen: Impacts, told: dict, e: float, anchor: float, change: dict[str, dict]
) -> dict[str, np.ndarray]:
    """The same simulated with restitution `e` at `anchor` [m/s], averaged over
    attitudes; change: see simulation_settings."""
    laws: dict[str, dict] = {
        "drag": {"factor": 0.0}
    }  # no air, but the same compiled kernels
    for law, numbers in change.get("laws", {}).items():
        laws[law] = at_anchor(law, numbers, e, anchor)
    tilt = (told.get("drop", {}).get("tilt_deg") or 0.0) + change.get("rig", {}).get(
        "tilt_deg", 0.0
    )
    before = np.nan_to_num(seen.before)
    first, rng = seen.number == 1, np.random.default_rng(7)
    struck = strike(
        told,
        laws,
        Parameters(restitution=e),
        before,
        first,
        rng,
        tilt_deg=tilt,
        copies=WAYS,
    )
    after = struck.after.mean(axis=1)
    return {"e": -after[:, 1] / before[:, 1], "kick": after[:, 0] - before[:, 0]}


def calibrated(
    seen: Impacts, told: dict, anchor: float, change: dict[str, dict]
) -> float:
    """The restitution at which the simulated mean restitution equals the recorded
    one."""
    want = float(observed(seen)["e"].mean())

    def miss(e: float) -> float:
        return float(outcome(seen, told, e, anchor, change)["e"].mean()) - want

    low, high = np.clip(want, *LIMITS), np.clip(want + 0.05, *LIMITS)
    return secant(miss, low, high, LIMITS, iterations=2, close=1e-6)
