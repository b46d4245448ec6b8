"""One case judged: what the solver said beside what was concealed. A missing diagnosis is a failure wherever it counts."""

import math
from dataclasses import dataclass

from prove.effects import RESTITUTION
from prove.make import Key
from prove.solve import Attempt

CLASS_NAME = RESTITUTION[0]


@dataclass(frozen=True)
class Judged:
    """alarm: something is said to be missing. right: the concealed effects, all and no others, named definitely. wrong_name:
    definite and not right. class_holds: a class that holds the truth. covers: per scored effect, whether the 95 % interval
    holds the value. removed: held-out fraction as stated. missing: there is no diagnosis."""

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
    removed: float | None
    seconds: float


def judge(key: Key, diagnosis: dict | None, attempt: Attempt | None) -> Judged:
    """What a diagnosis.json (or its absence) is worth."""
    said = (diagnosis or {}).get("rigs", {}).get(key.rig)
    seconds = attempt.seconds if attempt else math.nan
    if not isinstance(said, dict):
        return Judged(key, True, False, "missing", (), False, False, False, False, "", False, (), None, seconds)
    verdict, names = str(said.get("verdict", "none")), tuple(str(n) for n in said.get("names") or ())
    truth = {e.name for e in key.effects}
    definite = verdict == "name" and bool(names)
    right = bool(truth) and ((definite and alike(set(names), truth)) or one_class(verdict, names, truth))
    held = verdict == "class" and len(truth) == 1 and truth <= set(names)
    sector = foremost(said.get("sectors") or [])
    return Judged(
        key, False, bool(said.get("alarm", verdict != "none")), verdict, names, right, definite and not right, held,
        verdict == "unknown", sector, sector in key.sectors, covering(key, said, right), _removed(said), seconds,
    )  # fmt: skip


def alike(names: set[str], truth: set[str]) -> bool:
    """The same effects; a law of restitution may be called by its class, never by another law's name."""
    if names == truth:
        return True
    laws = truth & set(RESTITUTION)
    return len(laws) == 1 and names == (truth - laws) | {CLASS_NAME}


def one_class(verdict: str, names: tuple[str, ...], truth: set[str]) -> bool:
    """Laws of restitution that no drop tells apart: their class is the right answer."""
    return verdict == "class" and len(truth) == 1 and truth <= set(RESTITUTION) and truth <= set(names) <= set(RESTITUTION)


def foremost(sectors: list[dict]) -> str:
    """The sector that explains most."""
    valid = [s for s in sectors if isinstance(s, dict) and isinstance(s.get("explained"), int | float)]
    return str(max(valid, key=lambda s: s["explained"])["name"]) if valid else ""


def covering(key: Key, said: dict, right: bool) -> tuple[bool, ...]:
    """For a right name: whether each scored interval holds the truth, up to the sign where that is a matter of axes."""
    if not right:
        return ()
    found, out = said.get("parameters") or {}, []
    for effect in key.effects:
        law = effect.name in RESTITUTION
        stated = found.get(effect.name) or (next((found[n] for n in RESTITUTION if n in found), None) if law else None)
        if not effect.scored:
            continue
        if not isinstance(stated, dict) or not _numbers(stated):
            out.append(False)
            continue
        low, high = stated["low95"], stated["high95"]
        inside = low <= effect.value <= high
        out.append(inside or (effect.either and low <= -effect.value <= high))
    return tuple(out)


def _numbers(stated: dict) -> bool:
    return all(isinstance(stated.get(k), int | float) and math.isfinite(stated[k]) for k in ("low95", "high95"))


def _removed(said: dict) -> float | None:
    value = (said.get("held_out") or {}).get("removed_fraction")
    return float(value) if isinstance(value, int | float) and math.isfinite(value) else None
