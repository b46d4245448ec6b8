"""A listed effect: a law with a reported parameter, its prior, sector and wording.

A rig calls the laws of whatever effects it finds in its folder; only its own file knows an effect.
"""

import importlib
import pkgutil
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Counterpart:
    """What stands for an effect in the simulation.

    what: in words, {value} in its unit; change(values by name) → settings of force laws by name
    ("laws"), of the air ("air"), of the rig ("rig").
    """

    what: str
    change: Callable[[dict[str, float]], dict] | None = None


@dataclass(frozen=True)
class Effect:
    """One effect, or a further parameter of one.

    unit: of the reported parameter. prior_sd about 0, low, high (physical range), source (of law
    and range): all of the fitted parameter. reported: from the fitted to the reported value.
    wording: (what is missing, what its number is); separating: the recording that separates it.
    group: the effect that this is a further parameter of. scaled_prior: whether its prior scales
    with the effect's size. nonlinear: the law is not linear about 0: fitted in full whatever its
    slope there. follows, level: the condition that a contact parameter follows, and its level.
    unlisted: it says when or how, not why. counterpart: in the simulation; not_simulated: why there
    is none. needs(session): whether these recordings can show it. summary(Explanation): reported
    value and sd, where they are not those of the first parameter.

    Laws, of which an effect has those that it needs:
    drops: acceleration(Motion, value), picture(places, View, value), clock(value),
    restitution(Hits, e, value), kick(Hits, value).
    slides: act(Laws, run, value), tilt(coefficients, value), read(angle, Read, value), rest(value).
    rolls: act(way, value, context), resist(speed, value, seed, all values).
    """

    name: str
    sector: str
    unit: str
    meaning: str
    prior_sd: float
    low: float
    high: float
    source: str
    wording: tuple[str, str] = ("", "")
    separating: str = ""
    reported: Callable[[float], float] | None = None
    group: str = ""
    scaled_prior: bool = True
    nonlinear: bool = False
    follows: str = ""
    level: str = ""
    unlisted: bool = False
    counterpart: Counterpart | None = None
    not_simulated: str = ""
    acceleration: Callable | None = None
    picture: Callable | None = None
    clock: Callable | None = None
    restitution: Callable | None = None
    kick: Callable | None = None
    act: Callable | None = None
    tilt: Callable | None = None
    read: Callable | None = None
    rest: Callable | None = None
    resist: Callable | None = None
    summary: Callable | None = None
    needs: Callable | None = None


def separating_recordings(effects: Mapping[str, Effect], names: tuple[str, ...]) -> str | None:
    """The recordings that would tell these effects apart, two at most."""
    said = dict.fromkeys(effects[n].separating for n in names if n in effects and effects[n].separating)
    return "; ".join(list(said)[:2]) or None


def discovered(package: str, path: Iterable[str]) -> dict[str, Effect]:
    """EFFECTS of every file of a folder, by name, in the order of files."""
    found: dict[str, Effect] = {}
    for module in sorted(pkgutil.iter_modules(path), key=lambda m: m.name):
        for effect in getattr(importlib.import_module(f"{package}.{module.name}"), "EFFECTS", ()):
            found[effect.name] = effect
    return found
