"""Impacts run again in the DEM: every impact at the speed and spin that the recording shows, the seed lying in several ways."""

from dataclasses import replace

import numpy as np

from diagnose.effects.drop import EFFECTS
from diagnose.finding import Finding
from diagnose.rerun import Again, Compared, beside_mean, secant, settings, values_by_recording
from diagnose.rigs.drop.diagnose import RESTITUTION
from diagnose.rigs.drop.impacts import Impacts, chosen, heard, impacts_of, joined, usable
from diagnose.rigs.drop.joint import Sitting, flown, parts_of
from twin.flights import strike
from twin.parameters import Parameters
from twin.restitution import viscoelastic, yielding

WAYS = 8  # in which a seed may lie at each impact
COLUMNS = {"kick": "sideways kick", "e": "restitution of a bounce"}
LIMITS = (0.02, 0.98)
NUMBERS_OF_FALL = {"restitution_viscoelastic": viscoelastic, "restitution_plastic": yielding}


def strikes_again(again: Again, finding: Finding, tracks: list, sittings: tuple[Sitting, ...]) -> Again:
    """`again` with the bounces of both twins beside the recorded ones."""
    seen, told = impacts_seen(tracks, sittings), next(t.description for t in tracks)
    names = [n for n in finding.modelled if n in EFFECTS and (EFFECTS[n].restitution or EFFECTS[n].kick)]
    own = {r: {n: v[n] for n in names} for r, v in values_by_recording(finding).items()}
    whole = {n: float(np.mean([v[n] for v in own.values()])) for n in names}
    more = beside_mean(RESTITUTION, finding, tracks)
    speeds = float(np.median(-seen.before[:, 1]))
    old, new = (calibrated(seen, told, speeds, values) for values in ({}, whole))
    before = outcome(seen, told, old, speeds, {})
    after = {key: values.copy() for key, values in before.items()}
    for r, name in enumerate(seen.names):
        mine = np.flatnonzero(seen.recording == r)
        if not len(mine):
            continue
        e = float(np.clip(new + more.get(name, 0.0), *LIMITS))
        for key, found in outcome(chosen(seen, mine), told, e, speeds, own.get(name, whole)).items():
            after[key][mine] = found
    key = "kick" if names and all(EFFECTS[n].kick for n in names) else "e"
    recorded = observed(seen)
    unit, off = "m/s" if key == "kick" else "1", [recorded[key] - twin[key] for twin in (before, after)]
    rows = tuple(
        Compared(name, COLUMNS[key], unit, _rms(off[0][mine]), _rms(off[1][mine]), "impacts")
        for r, name in enumerate(seen.names) if (mine := seen.recording == r).any()
    )  # fmt: skip
    how = (
        f"each impact was run by the DEM at its recorded speed and spin, {WAYS} ways of lying averaged; so that bounces are as "
        f"high as recorded on average, restitution at {speeds:.2g} m/s is {old:.3f} in the old and {new:.3f} in the new twin"
    )
    how = f"{again.how}; {how}" if again.how else how
    named = {"recorded": recorded, "old twin": before, "new twin": after}
    points = {n: (-seen.before[:, 1], values[key]) for n, values in named.items()}
    figure = {"x": "impact speed (m/s)", "y": COLUMNS[key] + ("" if unit == "1" else " (m/s)"), "points": points}
    return replace(again, compared=(*again.compared, *rows), how=how, figure=figure)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt((values**2).mean()))


def impacts_seen(tracks: list, sittings: tuple[Sitting, ...]) -> Impacts:
    """All impacts of the filmed and of the merely heard drops that are fast enough to tell something."""
    listened = [t for t in tracks if not len(t.frame)]
    parts = []
    if sittings:
        flights = parts_of(flown(sittings))
        parts = [impacts_of(part, s.noise, s.tracks) for part, s in zip(flights, sittings, strict=True)]
    if listened:
        parts.append(heard(listened))
    table = joined(parts)
    return chosen(table, usable(table))


def observed(seen: Impacts) -> dict[str, np.ndarray]:
    """Of each impact (n,): restitution, sideways kick [m/s]."""
    return {"e": -seen.after[:, 1] / seen.before[:, 1], "kick": seen.after[:, 0] - seen.before[:, 0]}


def outcome(seen: Impacts, told: dict, e: float, anchor: float, values: dict[str, float]) -> dict[str, np.ndarray]:
    """The same of the twin of restitution `e` at the anchor's speed [m/s], the mean over the ways of lying; the same ways whatever
    the laws; values: of effects, by name."""
    change = settings("drop", values)
    laws: dict[str, dict] = {"drag": {"factor": 0.0}}  # what a few mm of air do is nothing, and the kernels are one set
    for law, numbers in change.get("laws", {}).items():
        laws[law] = NUMBERS_OF_FALL[law](numbers["fall"], e, anchor) if "fall" in numbers else numbers
    tilt = (told.get("drop", {}).get("tilt_deg") or 0.0) + change.get("rig", {}).get("tilt_deg", 0.0)
    before = np.nan_to_num(seen.before)
    first, rng = seen.number == 1, np.random.default_rng(7)
    struck = strike(told, laws, Parameters(restitution=e), before, first, rng, tilt_deg=tilt, copies=WAYS)
    after = struck.after.mean(axis=1)
    return {"e": -after[:, 1] / before[:, 1], "kick": after[:, 0] - before[:, 0]}


def calibrated(seen: Impacts, told: dict, anchor: float, values: dict[str, float]) -> float:
    """The restitution with which the twin's bounces are on average as high as the recorded ones: a secant from that itself."""
    want = float(observed(seen)["e"].mean())

    def miss(e: float) -> float:
        return float(outcome(seen, told, e, anchor, values)["e"].mean()) - want

    low, high = np.clip(want, *LIMITS), np.clip(want + 0.05, *LIMITS)
    return secant(miss, low, high, LIMITS, iterations=2, close=1e-6)
