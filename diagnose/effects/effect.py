"""What a listed effect is: a law with a reported parameter, its prior, where it acts, its words, and what of the twin stands for it.

A rig calls the hooks of whatever effects it finds in its folder: an effect's file is all that knows its name.
"""

import importlib
import pkgutil
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Counterpart:
    """What of the twin stands for an effect. what: in words, {value} in its unit; change(values of the effect's parameters by
    name) → settings of the twin: force laws by name ("laws"), of the rig ("rig"), of the camera ("camera")."""

    what: str
    change: Callable[[dict[str, float]], dict] | None = None


@dataclass(frozen=True)
class Effect:
    """One effect, or a further parameter of one.

    name, sector; unit, meaning: of the reported parameter; prior_sd about 0, low, high: physical range, all of the fitted
    parameter; source of law and range; says: (what is missing, what its number is) in a reader's words; separating: the
    recording that would tell it from others; reported: from the fitted value to the reported one (rising), where they differ.
    group: the effect that this is a further parameter of; sized: whether its prior scales with the effect's size (a shape's does
    not: it is knowledge of the law); bent: the law is not linear about nil, so that it is fitted whatever its slope there;
    follows: the stated condition that a contact parameter follows, level: of a condition in words the one that
    this parameter is of; unlisted: it says when, not why.
    counterpart: None where nothing in the twin stands for it, untwinned: why not.
    Hooks, of which an effect gives those that its law needs (each rig's model says how it calls them):
    acceleration(Motion, value), picture(places, View, value), clock(value), restitution(Hits, e, value), kick(Hits, value): drops;
    act(Laws, run, value), tilt(coefficients, value), read(angle, Read, value), rest(value): slides; act(way, value, context),
    resist(speed, value, seed, all values): rolls; summary(Explanation) → reported value and its sd, where they are not those of the
    first parameter;
    needs(session) → whether these recordings can show it.
    """

    name: str
    sector: str
    unit: str
    meaning: str
    prior_sd: float
    low: float
    high: float
    source: str
    says: tuple[str, str] = ("", "")
    separating: str = ""
    reported: Callable[[float], float] | None = None
    group: str = ""
    sized: bool = True
    bent: bool = False
    follows: str = ""
    level: str = ""
    unlisted: bool = False
    counterpart: Counterpart | None = None
    untwinned: str = ""
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
