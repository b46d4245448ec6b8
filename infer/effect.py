"""A listed effect: a law with a reported parameter, its prior, sector and wording."""

import importlib
import math
import pkgutil
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TypeVar

from benchtwin.bench.language import tr

# where an effect acts: of drops, slides, rolls, heaps, and what recordings say wrongly
SECTORS = (
    *("flight", "impact", "onset", "sliding", "run-out"),
    *("crest", "middle", "toe", "measurement"),
)


@dataclass(frozen=True)
class Counterpart:
    """What stands for an effect in the simulation; change(values) → settings by
    part."""

    what: str  # in words, {value} in its unit
    # see rerun.simulation_settings
    change: Callable[[dict[str, float]], dict] | None = None


@dataclass(frozen=True)
class Key:
    """The key of recording.toml that states an effect; both have one sign."""

    section: str
    name: str
    # (stated, value beside it) → what states both
    both: Callable[[float, float], float] = lambda stated, value: stated + value
    absent: float = math.nan  # what an absent key stands for; NaN: for nothing
    # whether the effect's number is told with what is stated, not beside it
    whole: bool = False
    overruled_by: str = ""  # column of a table beside which the key counts for nothing

    def __str__(self) -> str:
        return f"[{self.section}] {self.name}"

    def stated(self, sections: Mapping[str, Mapping]) -> float:
        """What a recording's sections state, or what an absent key stands for."""
        told = sections.get(self.section, {}).get(self.name)
        return self.absent if told is None else told


def in_proportion(stated: float, share: float) -> float:
    """What states `share` more than is stated."""
    return stated * (1 + share)


SCALE = Key("camera", "mm_per_px", in_proportion, overruled_by="x_mm")
FRAME_RATE = Key("camera", "fps", in_proportion, overruled_by="t_s")


@dataclass(frozen=True)
class Effect:
    """One effect, or a further parameter of one, with the laws through which it
    acts."""

    name: str
    sector: str
    unit: str  # this and `meaning`: of the reported parameter
    meaning: str
    prior_sd: float  # about 0; this and the physical range: of the fitted parameter
    low: float
    high: float
    source: str  # of law and range
    wording: tuple[str, str] = ("", "")  # (what is missing, what its number is)
    separating: str = ""  # the recording that separates it
    # from the fitted to the reported value
    reported: Callable[[float], float] | None = None
    group: str = ""  # the effect that this is a further parameter of
    scaled_prior: bool = True  # whether its prior scales with the effect's size
    # not linear about 0: fitted in full whatever its slope there
    nonlinear: bool = False
    unlisted: bool = False  # it says when or how, not why
    key: Key | None = None  # that states it
    counterpart: Counterpart | None = None
    not_simulated: str = ""  # why there is no counterpart
    acceleration: Callable | None = None  # (Motion, value): drops
    picture: Callable | None = None  # (places, View, value)
    clock: Callable | None = None  # (value)
    release: Callable | None = None  # (value) → stated heights too low by that [m]
    restitution: Callable | None = None  # (Hits, e, value)
    kick: Callable | None = None  # (Hits, value)
    # (Laws, run, value): slides; (way, value, context): rolls
    act: Callable | None = None
    tilt: Callable | None = None  # (coefficients, Tilt, value): slides
    read: Callable | None = None  # (angle, Read, value)
    rest: Callable | None = None  # (value)
    # (speed, value, seed or run, all values) → friction: rolls, slides
    resist: Callable | None = None
    along: Callable | None = None  # (way [m], value) → friction: rolls, slides
    summary: Callable | None = None  # (Explanation) → reported value and sd
    needs: Callable | None = None  # (session) → whether these recordings can show it


E = TypeVar("E", bound=Effect)


def separating_recordings(
    effects: Mapping[str, Effect], names: tuple[str, ...]
) -> str | None:
    """The recordings that would tell these effects apart, two at most."""
    said = dict.fromkeys(
        tr(effects[n].separating)
        for n in names
        if n in effects and effects[n].separating
    )
    return "; ".join(list(said)[:2]) or None


def discovered(
    package: str,
    path: Iterable[str],
    kind: type[E] = Effect,  # type: ignore[assignment]
) -> dict[str, E]:
    """EFFECTS of every file of a folder, by name, in the order of files; ValueError for
    one that cannot be weighed, two of one name, or a group that is not there."""
    found: dict[str, E] = {}
    for module in sorted(pkgutil.iter_modules(path), key=lambda m: m.name):
        loaded = importlib.import_module(f"{package}.{module.name}")
        for effect in getattr(loaded, "EFFECTS", ()):
            if not isinstance(effect, kind):
                raise ValueError(
                    tr(
                        "{}.{}: {!r} is no {}",
                        package,
                        module.name,
                        effect,
                        kind.__name__,
                    )
                )
            if effect.name in found:
                raise ValueError(
                    tr(
                        "{}.{}: there is another effect {!r}; each needs a name of its"
                        " own",
                        package,
                        module.name,
                        effect.name,
                    )
                )
            if why := _wrong(effect):
                raise ValueError(
                    f"{package}.{module.name}: effect {effect.name!r}: {why}"
                )
            found[effect.name] = effect
    if lost := sorted({e.group for e in found.values() if e.group} - set(found)):
        raise ValueError(
            tr("{}: there is no effect {!r}, a group's name", package, lost[0])
        )
    return found


def _wrong(effect: Effect) -> str:
    """Why an effect cannot be weighed, "": it can."""
    e = effect
    if not e.name or e.sector not in SECTORS:
        return tr("sector = {!r}: must be one of {}", e.sector, ", ".join(SECTORS))
    if not (e.low < e.high and e.low <= 0 <= e.high):
        return tr(
            "low = {}, high = {}: low must be below high, and 0, no effect, between"
            " them",
            e.low,
            e.high,
        )
    if not 0 < e.prior_sd < math.inf:
        return tr("prior_sd = {}: must be above 0 and finite", e.prior_sd)
    return ""
