"""Compares one diagnosis with what the case conceals. A missing diagnosis is a failure
wherever it counts."""

import math
from dataclasses import dataclass

import pandas as pd

from benchtwin.prove.make import Key
from benchtwin.prove.rigs import RIGS

# the class of the laws of restitution that no drop tells apart, and these
RESTITUTION = (
    "restitution-falls-with-speed",
    "viscoelastic-restitution",
    "plastic-restitution",
    "plate-compliance",
)
CLASS_NAME = RESTITUTION[0]
UNLISTED = "(unlisted)"


@dataclass(frozen=True)
class Judged:
    """One case compared with its key."""

    key: Key
    alarm: bool = False  # the diagnosis says that something is missing
    verdict: str = "missing"  # there is no diagnosis
    names: tuple[str, ...] = ()
    right: bool = False  # names the concealed effects, all of them and no others
    wrong_name: bool = False  # names effects definitely, and not the right ones
    class_holds: bool = False  # a class that holds the truth
    sector: str = ""
    sector_right: bool = False
    # of each scored effect: whether the 95 % interval holds its value
    covers: tuple[bool, ...] = ()
    # of each: (SNR, value, low, high), the last three over the truth
    stated: tuple[tuple[float, float, float, float], ...] = ()
    removed: float | None = None  # held-out fraction as stated
    seconds: float = math.nan
    as_said: bool = False  # the verdict is true in the sense of its probability
    p: float | None = None  # probability of the verdict; None: not stated
    # probability of the true set of effects; None: not stated
    p_truth: float | None = None
    # "matters" is right; None: not known, not stated, or nothing found
    matters: bool | None = None


def judge(key: Key, diagnosis: dict | None, seconds: float = math.nan) -> Judged:
    """Compare a diagnosis.json, or its absence, with the key; seconds: it took."""
    answer = (diagnosis or {}).get("rigs", {}).get(key.rig)
    if not isinstance(answer, dict):
        return Judged(key, seconds=seconds)
    verdict = str(answer.get("verdict", "none"))
    names = tuple(str(n) for n in answer.get("names") or ())
    truth = {e.name for e in key.effects}
    definite = verdict == "name" and bool(names)
    right = bool(truth) and (
        (definite and same_effects(set(names), truth))
        or one_class(verdict, names, truth)
    )
    held = verdict == "class" and len(truth) == 1 and truth <= set(names)
    sector = main_sector(answer.get("sectors") or [])
    alarm, matters = bool(answer.get("alarm", verdict != "none")), answer.get("matters")
    if alarm and isinstance(matters, bool) and key.matters is not None:
        matters_right = matters == key.matters
    else:
        matters_right = None
    covers, stated = interval_coverage(key, answer) if right else ((), ())
    within = all(
        n in names or (n in RESTITUTION and CLASS_NAME in names) for n in truth
    )
    said = {
        "none": not truth,
        "unknown": unlisted(key),
        "class": bool(truth) and within,
    }
    as_said = said.get(verdict, right)
    return Judged(
        key,
        alarm=alarm,
        verdict=verdict,
        names=names,
        right=right,
        wrong_name=definite and not right,
        class_holds=held,
        sector=sector,
        sector_right=sector in key.sectors,
        covers=covers,
        stated=stated,
        removed=_number((answer.get("held_out") or {}).get("removed_fraction")),
        seconds=seconds,
        as_said=as_said,
        p=_number(answer.get("p_verdict")),
        p_truth=probability_of_truth(key, answer.get("explanations")),
        matters=matters_right,
    )


def cases_table(judged: list[Judged]) -> pd.DataFrame:
    """One row a case: what was concealed, what was diagnosed, and how it compares."""
    return pd.DataFrame(
        [
            {
                "case": j.key.case,
                "rig": j.key.rig,
                "kind": j.key.kind,
                "rendered": j.key.rendered,
                "concealed": " + ".join(e.name for e in j.key.effects),
                "values": " ".join(f"{e.value:.4g}" for e in j.key.effects),
                "snr": j.key.snr,
                "separated": j.key.separated,
                "verdict": j.verdict,
                "names": " + ".join(j.names),
                "alarm": j.alarm,
                "right": j.right,
                "wrong_name": j.wrong_name,
                "class_holds": j.class_holds,
                "sector": j.sector,
                "sector_right": j.sector_right,
                "covers": " ".join(str(c) for c in j.covers),
                "removed_fraction": j.removed,
                "seconds": j.seconds,
                "p_verdict": j.p,
                "as_said": j.as_said,
                "p_truth": j.p_truth,
                "truly_matters": j.key.matters,
                "matters_right": j.matters,
                "conditions": " ".join(j.key.conditions),
                "absent": " ".join(j.key.absent),
            }
            for j in judged
        ]
    )


def same_effects(names: set[str], truth: set[str]) -> bool:
    """The same effects; a law of restitution may be called by its class, never by
    another law's name."""
    if names == truth:
        return True
    laws = truth & set(RESTITUTION)
    return len(laws) == 1 and names == (truth - laws) | {CLASS_NAME}


def unlisted(key: Key) -> bool:
    """Whether the key holds an effect that the diagnosis does not list."""
    listed = {n for n, e in RIGS[key.rig].effects.items() if e.listed}
    names = {e.name for e in key.effects if "-follows-" not in e.name}
    return not names <= listed


def probability_of_truth(key: Key, explanations: list[dict] | None) -> float | None:
    """What the explanations give to the true set, unlisted physics in any true
    sector."""
    if not isinstance(explanations, list) or not explanations:
        return None
    truth = {e.name for e in key.effects}
    if unlisted(key):
        sets = [{f"{UNLISTED} {sector}"} for sector in key.sectors]
    else:
        sets = [truth]
    true = [
        one
        for one in explanations
        if any(same_effects(set(one.get("effects", ())), names) for names in sets)
    ]
    return sum(_number(one.get("probability")) or 0.0 for one in true)


def one_class(verdict: str, names: tuple[str, ...], truth: set[str]) -> bool:
    """Laws of restitution that no drop tells apart: their class is the right answer."""
    return (
        verdict == "class"
        and len(truth) == 1
        and truth <= set(RESTITUTION)
        and truth <= set(names) <= set(RESTITUTION)
    )


def main_sector(sectors: list[dict]) -> str:
    """The sector that explains most."""
    valid = [
        s
        for s in sectors
        if isinstance(s, dict) and isinstance(s.get("explained"), int | float)
    ]
    return str(max(valid, key=lambda s: s["explained"])["name"]) if valid else ""


def interval_coverage(key: Key, answer: dict) -> tuple[tuple[bool, ...], tuple]:
    """Whether each interval holds the truth; (SNR, value, low, high) over the truth."""
    found, covers, stated = answer.get("parameters") or {}, [], []
    for effect in (e for e in key.effects if e.scored):
        names = (effect.name, *(RESTITUTION if effect.name in RESTITUTION else ()))
        one: dict = next((found[name] for name in names if name in found), {})
        value, low, high = (_number(one.get(k)) for k in ("value", "low95", "high95"))
        truths = (effect.value, -effect.value) if effect.either else (effect.value,)
        if low is None or high is None:
            covers.append(False)
            continue
        covers.append(any(low <= true <= high for true in truths))
        if value is not None:
            true = min(truths, key=lambda true: abs(true - value))
            stated.append(
                (effect.snr, value / true, *sorted((low / true, high / true)))
            )
    return tuple(covers), tuple(stated)


def _number(value: object) -> float | None:
    """A finite number, or None."""
    if isinstance(value, int | float) and math.isfinite(value):
        return float(value)
    return None
