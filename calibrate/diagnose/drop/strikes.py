"""Impacts run again in the DEM: every impact at the speed and spin that the recording shows, the seed lying in several ways."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from calibrate.diagnose.air import air_of
from calibrate.diagnose.drop.impacts import Impacts, heard, impacts_of, joined
from calibrate.diagnose.drop.sessions import joint_problem, parts_of, sittings_of
from calibrate.diagnose.finding import Finding
from calibrate.diagnose.model import Again, Compared
from calibrate.diagnose.problem import fit
from calibrate.twin.flown import strike
from calibrate.twin.parameters import Parameters
from calibrate.twin.restitution import viscoelastic, yielding

WAYS = 8  # in which a seed may lie at each impact
COLUMNS = {"kick": "sideways kick", "e": "restitution of a bounce"}
LIMITS = (0.02, 0.98)


def strikes_again(again: Again, finding: Finding, tracks: list) -> Again:
    """`again` with the bounces of both twins beside the recorded ones."""
    seen, told = impacts_seen(tracks), next(t.description for t in tracks)
    names = {n: values for n, values in finding.left_out.items() if n in CHANGES}
    whole = {n: float(np.mean(values)) for n, values in names.items()}
    speeds = float(np.median(-seen.before[:, 1]))
    old = calibrated(seen, told, speeds, {})
    new = calibrated(seen, told, speeds, whole)
    before = outcome(seen, told, old, speeds, {})
    after = {key: values.copy() for key, values in before.items()}
    for r in range(len(seen.names)):
        mine = seen.recording == r
        value = {n: values[min(r, len(values) - 1)] for n, values in names.items()}
        for key, found in outcome(_only(seen, mine), told, new, speeds, value).items():
            after[key][mine] = found
    key = "kick" if set(names) == {"plate-tilt"} else "e"
    recorded = observed(seen)
    rows = tuple(_compared(seen, key, recorded[key], before[key], after[key]))
    how = (
        f"each impact was run by the DEM at its recorded speed and spin, {WAYS} ways of lying averaged; so that bounces are as "
        f"high as recorded on average, restitution at {speeds:.2g} m/s is {old:.3f} in the old and {new:.3f} in the new twin"
    )
    how = f"{again.how}; {how}" if again.how else how
    figure = drawn(seen, key, recorded[key], before[key], after[key])
    return replace(again, compared=(*again.compared, *rows), how=how, figure=figure)


def impacts_seen(tracks: list) -> Impacts:
    """All impacts of the filmed and of the merely heard drops."""
    filmed, listened = [t for t in tracks if len(t.frame)], [t for t in tracks if not len(t.frame)]
    parts = []
    if filmed:
        sittings, _ = sittings_of(filmed)
        flights = fit(joint_problem(tuple(s.problem for s in sittings)))
        parts = [impacts_of(part, s.noise, s.tracks) for part, s in zip(parts_of(flights), sittings, strict=True)]
    if listened:
        about = [t.description for t in listened]
        parts.append(
            heard(tuple(t.recording for t in listened), [t.contacts_s for t in listened], about, [air_of(d) for d in about])
        )
    return joined(parts) if len(parts) > 1 else parts[0]


def observed(seen: Impacts) -> dict[str, np.ndarray]:
    """Of each impact (n,): restitution, sideways kick [m/s]."""
    return {"e": -seen.after[:, 1] / seen.before[:, 1], "kick": seen.after[:, 0] - seen.before[:, 0]}


def outcome(seen: Impacts, told: dict, restitution: float, anchor: float, values: dict[str, float]) -> dict[str, np.ndarray]:
    """The same of the twin, the mean over the ways of lying; the same ways whatever the laws."""
    laws: dict[str, dict] = {"drag": {"factor": 0.0}}  # what a few mm of air do is nothing, and the kernels are one set
    tilt = (told.get("drop", {}).get("tilt_deg") or 0.0) + values.get("plate-tilt", 0.0)
    for name, value in values.items():
        laws |= CHANGES[name](value, restitution, anchor)
    before = np.nan_to_num(seen.before)
    struck = strike(
        told,
        laws,
        Parameters(restitution=restitution),
        before,
        seen.number == 1,
        np.random.default_rng(7),
        tilt_deg=tilt,
        copies=WAYS,
    )
    after = struck.after.mean(axis=1)
    return {"e": -after[:, 1] / before[:, 1], "kick": after[:, 0] - before[:, 0]}


def calibrated(seen: Impacts, told: dict, anchor: float, values: dict[str, float]) -> float:
    """The restitution with which the twin's bounces are on average as high as the recorded ones: a secant from that itself."""
    want = float(observed(seen)["e"].mean())

    def miss(e: float) -> float:
        return float(outcome(seen, told, e, anchor, values)["e"].mean()) - want

    low, high = np.clip(want, *LIMITS), np.clip(want + 0.05, *LIMITS)
    at_low, at_high = miss(low), miss(high)
    for _ in range(2):
        if abs(at_high - at_low) < 1e-6:
            break
        step = float(np.clip(high - at_high * (high - low) / (at_high - at_low), *LIMITS))
        low, at_low, high, at_high = high, at_high, step, miss(step)
    return float(high)


def _only(seen: Impacts, rows: np.ndarray) -> Impacts:
    keys = ("recording", "number", "before", "after", "flights", "time_sd")
    return replace(seen, **{key: getattr(seen, key)[rows] for key in keys})


def _compared(seen: Impacts, key: str, recorded, before, after):
    unit = "m/s" if key == "kick" else "1"
    for r, name in enumerate(seen.names):
        mine = seen.recording == r
        if mine.any():
            old, new = (float(np.sqrt(((recorded - twin)[mine] ** 2).mean())) for twin in (before, after))
            yield Compared(name, COLUMNS[key], unit, old, new, "impacts")


def drawn(seen: Impacts, key: str, recorded, before, after) -> dict:
    """Points over the impact speed."""
    speed = -seen.before[:, 1]
    unit = " (m/s)" if key == "kick" else ""
    points = {"recorded": (speed, recorded), "old twin": (speed, before), "new twin": (speed, after)}
    return {"x": "impact speed (m/s)", "y": COLUMNS[key] + unit, "points": points}


def _film(value: float, e: float, anchor: float) -> dict:
    return {"restitution_film": {"film_speed": max(value, 0.0)}}


def _viscoelastic(value: float, e: float, anchor: float) -> dict:
    return {"restitution_viscoelastic": viscoelastic(value, e, anchor)}


def _yielding(value: float, e: float, anchor: float) -> dict:
    return {"restitution_plastic": yielding(value, e, anchor)}


CHANGES: dict[str, Callable[[float, float, float], dict]] = {
    "restitution-falls-with-speed": _viscoelastic,
    "viscoelastic-restitution": _viscoelastic,
    "plastic-restitution": _yielding,
    "film-adhesion": _film,
    "plate-tilt": lambda value, e, anchor: {},
}
