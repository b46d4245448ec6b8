"""One case judged: what the solver said beside what was concealed. A missing diagnosis is a failure wherever it counts."""

import math
from dataclasses import dataclass

from prove.effects import EFFECTS, RESTITUTION
from prove.make import Key
from prove.solve import Attempt

CLASS_NAME = RESTITUTION[0]
UNLISTED = "(unlisted)"


@dataclass(frozen=True)
class Judged:
    """alarm: something is said to be missing. right: the concealed effects, all and no others, named definitely. wrong_name:
    definite and not right. class_holds: a class that holds the truth. covers: per scored effect, whether the 95 % interval
    holds the value; stated: (SNR, value, (low, high)) of each that is, over the truth. removed: held-out fraction as stated.
    missing: there is no diagnosis. as_said: the verdict is true as its p is meant: nothing is missing, just these effects are,
    one of the class is, something unlisted is. p, p_truth: probabilities of the verdict and of the true set of effects, None
    where not stated. matters: whether it is said rightly; None: not told, not said, or nothing found."""

    key: Key
    missing: bool
    alarm: bool
    verdict: str
    names: tuple[str, ...]
    right: bool
    wrong_name: bool
    class_holds: bool
    unknown: bool
    sector: str
    sector_right: bool
    covers: tuple[bool, ...]
    stated: tuple[tuple[float, float, tuple[float, float]], ...]
    removed: float | None
    seconds: float
    as_said: bool = False
    p: float | None = None
    p_truth: float | None = None
    matters: bool | None = None


def judge(key: Key, diagnosis: dict | None, attempt: Attempt | None) -> Judged:
    """What a diagnosis.json (or its absence) is worth."""
    said = (diagnosis or {}).get("rigs", {}).get(key.rig)
    seconds = attempt.seconds if attempt else math.nan
    if not isinstance(said, dict):
        return Judged(key, True, False, "missing", (), False, False, False, False, "", False, (), (), None, seconds)
    verdict, names = str(said.get("verdict", "none")), tuple(str(n) for n in said.get("names") or ())
    truth = {e.name for e in key.effects}
    definite = verdict == "name" and bool(names)
    right = bool(truth) and ((definite and alike(set(names), truth)) or one_class(verdict, names, truth))
    held = verdict == "class" and len(truth) == 1 and truth <= set(names)
    sector = foremost(said.get("sectors") or [])
    alarm, matters = bool(said.get("alarm", verdict != "none")), said.get("matters")
    told = alarm and isinstance(matters, bool) and key.matters is not None
    covers, stated = covering(key, said) if right else ((), ())
    as_said = {"none": not truth, "unknown": unlisted(key), "class": bool(truth) and _within(truth, names)}.get(verdict, right)
    return Judged(
        key, False, alarm, verdict, names, right, definite and not right, held, verdict == "unknown", sector,
        sector in key.sectors, covers, stated, _number((said.get("held_out") or {}).get("removed_fraction")), seconds, as_said,
        _number(said.get("p_verdict")), of_truth(key, said.get("explanations")), matters == key.matters if told else None,
    )  # fmt: skip


def alike(names: set[str], truth: set[str]) -> bool:
    """The same effects; a law of restitution may be called by its class, never by another law's name."""
    if names == truth:
        return True
    laws = truth & set(RESTITUTION)
    return len(laws) == 1 and names == (truth - laws) | {CLASS_NAME}


def unlisted(key: Key) -> bool:
    """Whether the key holds an effect that the diagnosis does not list."""
    return any(e.name not in EFFECTS[key.rig] and "-follows-" not in e.name for e in key.effects)


def _within(truth: set[str], names: tuple[str, ...]) -> bool:
    return all(name in names or (name in RESTITUTION and CLASS_NAME in names) for name in truth)


def of_truth(key: Key, explanations: list[dict] | None) -> float | None:
    """The probability that the explanations give to the true set; what is not listed may be said to be in any sector where it
    shows. None where there are no explanations."""
    if not isinstance(explanations, list) or not explanations:
        return None
    truth = {e.name for e in key.effects}
    sets = [{f"{UNLISTED} {sector}"} for sector in key.sectors] if unlisted(key) else [truth]
    true = [one for one in explanations if any(alike(set(one.get("effects", ())), names) for names in sets)]
    return sum(_number(one.get("probability")) or 0.0 for one in true)


def one_class(verdict: str, names: tuple[str, ...], truth: set[str]) -> bool:
    """Laws of restitution that no drop tells apart: their class is the right answer."""
    return verdict == "class" and len(truth) == 1 and truth <= set(RESTITUTION) and truth <= set(names) <= set(RESTITUTION)


def foremost(sectors: list[dict]) -> str:
    """The sector that explains most."""
    valid = [s for s in sectors if isinstance(s, dict) and isinstance(s.get("explained"), int | float)]
    return str(max(valid, key=lambda s: s["explained"])["name"]) if valid else ""


def covering(key: Key, said: dict) -> tuple[tuple[bool, ...], tuple]:
    """Of a right name: whether each scored interval holds the truth, up to the sign where that is a matter of axes; and what is
    stated over the truth, with its SNR."""
    found, covers, stated = said.get("parameters") or {}, [], []
    for effect in key.effects:
        if not effect.scored:
            continue
        law = next((found[n] for n in RESTITUTION if n in found), None) if effect.name in RESTITUTION else None
        one = found.get(effect.name) or law or {}
        value, low, high = (_number(one.get(k)) for k in ("value", "low95", "high95"))
        if low is None or high is None:
            covers.append(False)
            continue
        covers.append(low <= effect.value <= high or (effect.either and low <= -effect.value <= high))
        if value is not None:
            sign = -1 if effect.either and value * effect.value < 0 else 1
            ends = sorted(sign * end / effect.value for end in (low, high))
            stated.append((effect.snr, sign * value / effect.value, (ends[0], ends[1])))
    return tuple(covers), tuple(stated)


def _number(value: object) -> float | None:
    """A finite number, or None."""
    return float(value) if isinstance(value, int | float) and math.isfinite(value) else None
