"""Heaps run again in the DEM, with the friction that gives the recorded angle, and an
effect.

The response to friction and effect is interpolated from a few heaps with equal
packings. Both are fitted to half of the recordings and compared with the other half.
"""

import shutil
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from benchtwin.diagnose.rerun import Comparison, Resimulation
from benchtwin.infer.finding import Finding
from benchtwin.rigs.pile.effects import EFFECTS
from benchtwin.rigs.pile.flanks import photo_of
from benchtwin.rigs.pile.heap_priors import PACKING_SD
from benchtwin.rigs.pile.read import SeenPile, read_piles
from benchtwin.rigs.pile.simulated_heaps import (
    AT,
    SOYBEAN_MM,
    HeapSettings,
    Shape,
    shape_of,
    simulate_heap,
    simulation_inputs,
)
from benchtwin.twin.paths import beside
from benchtwin.twin.run import simulate

FRICTIONS = (0.55, 0.25)  # the soybean paper's, and less
LEAST, MOST = 0.1, 1.0  # of friction
PACKINGS = 2
MOST_KINDS = 2  # of heaps with different stated quantities
HOW = (
    f"friction between seeds lets old and new twin fit as well as each can; {PACKINGS}"
    " packings each, their mean; surfaces are compared in shares of the flank's base,"
    " so that its steepness counts as well as its form"
)


@dataclass(frozen=True, eq=False)
class Kind:
    """Recordings with equal stated quantities; shapes simulated at FRICTIONS and at
    strengths."""

    recordings: tuple[SeenPile, ...]
    frictions: tuple[Shape, ...]
    strengths: tuple[Shape, ...]

    @property
    def plain(self) -> bool:
        """Whether their seeds are known not to show an effect."""
        return self.recordings[0].description.get("pile", {}).get("plain", False)

    def shape(
        self, friction: float, strength: float, levels: tuple[float, ...]
    ) -> Shape:
        """Interpolated linearly between the simulated heaps."""
        (one, two), (at_one, at_two) = self.frictions, FRICTIONS
        share = (friction - at_one) / (at_two - at_one)
        surface = one.surface + share * (two.surface - one.surface)
        angle = one.angle_deg + share * (two.angle_deg - one.angle_deg)
        steps = np.array([0.0, *levels])
        strength = 0.0 if self.plain else strength
        more = np.array([s.surface - self.strengths[0].surface for s in self.strengths])
        surface = surface + np.array(
            [np.interp(strength, steps, column) for column in more.T]
        )
        angles = [s.angle_deg - one.angle_deg for s in self.strengths]
        return Shape(surface, angle + float(np.interp(strength, steps, angles)))


def resimulate(
    finding: Finding, recordings: list[SeenPile], folder: Path, pictures: bool, say
) -> Resimulation:
    """Each half of the recordings beside heaps fitted to the other half."""
    if len(finding.modelled) > 1:
        raise ValueError("two effects at once are not put into a simulated heap")
    (effect,), used = finding.modelled, set(finding.recordings)
    seen = [
        r
        for r in recordings
        if {r.recording, r.recording.rpartition("/")[0]} & used and photo_of(r).flanks
    ]
    seeds = [r.description.get("seed", {}) for r in seen]
    seed_mm = float(np.mean([s.get("length_mm", SOYBEAN_MM[0]) for s in seeds]))
    groups: dict[tuple, list[SeenPile]] = {}
    for r in seen:
        groups.setdefault(photo_of(r).stated, []).append(r)
    chosen = sorted(groups.values(), key=len, reverse=True)[:MOST_KINDS]
    for group in chosen:  # refused before anything runs
        for strength in (0.0, *EFFECTS[effect].law.strengths):
            simulation_inputs(
                group[0].description,
                HeapSettings(FRICTIONS[0], effect, strength),
                seed_mm,
            )
    kinds = [
        _responses(group, effect, seed_mm, f"kind {k + 1} of {len(chosen)}", say)
        for k, group in enumerate(chosen)
    ]
    rows: list[Comparison] = []
    shown: list[tuple[tuple[SeenPile, ...], Shape, Shape, Path]] = []
    values: list[float] = []
    halves = (0, 1) if len(seen) > 1 else (0,)
    for half in halves:
        settings = [_fitted(kinds, half, effect, free) for free in (False, True)]
        values.append(settings[1].strength)
        for k, kind in enumerate(kinds):
            if not (mine := kind.recordings[half :: len(halves)]):
                continue
            say(
                f"pile: running the twin again, half {half + 1}, kind {k + 1} of"
                f" {len(kinds)}"
            )
            at = folder / f"half-{half + 1}-kind-{k + 1}"
            old, new = (
                _run(
                    kind,
                    setting_,
                    seed_mm,
                    at.with_name(f"{at.name}-{which}"),
                    pictures,
                )
                for which, setting_ in zip(("old", "new"), settings, strict=True)
            )
            rows += _compared(mine, old, new, "pictures" if pictures else "outline")
            shown.append((mine, old, new, at))
    counterpart = EFFECTS[effect].counterpart
    assert counterpart is not None  # checked by rerun.reason_not_simulated
    change = counterpart.what.format(value=f"{np.mean(values):.2g}")
    figure = _figure(*shown[0][:3])
    again = Resimulation(
        "pile", (effect,), change, HOW, tuple(rows), len(seen) > 1, figure=figure
    )
    return _pictured(again, shown[0][3]) if pictures else again


def _responses(
    group: list[SeenPile], effect: str, seed_mm: float, which: str, say
) -> Kind:
    """Shapes of heaps with less friction and with the effect, all of the same
    packings."""

    def ran(friction: float, strength: float) -> Shape:
        say(
            f"pile: what friction and {effect} do, {which}: friction {friction:g},"
            f" strength {strength:g}"
        )
        settings = HeapSettings(friction, effect, strength)
        told = group[0].description
        heaps = [simulate_heap(told, settings, seed_mm, p) for p in range(PACKINGS)]
        return shape_of(heaps)

    usual = ran(FRICTIONS[0], 0.0)
    strengths = tuple(ran(FRICTIONS[0], s) for s in EFFECTS[effect].law.strengths)
    return Kind(tuple(group), (usual, ran(FRICTIONS[1], 0.0)), (usual, *strengths))


def _fitted(kinds: list[Kind], left_out: int, effect: str, free: bool) -> HeapSettings:
    """Friction, and with `free` the strength, that fit the recordings of the other half
    best."""
    levels = EFFECTS[effect].law.strengths
    many = sum(len(kind.recordings) for kind in kinds) > 1
    targets = [
        (kind, shape_of(list(part)))
        for kind in kinds
        if (part := kind.recordings[1 - left_out :: 2] if many else kind.recordings)
    ]
    strengths = (
        np.linspace(0.0, levels[-1], 31) if len(levels) > 1 else np.array([levels[-1]])
    )
    best = (np.inf, FRICTIONS[0], 0.0)
    for strength in strengths if free else (0.0,):
        for friction in np.linspace(LEAST, MOST, 37):
            off = sum(
                _misfit(kind.shape(friction, strength, levels), target)
                for kind, target in targets
            )
            best = min(best, (off, float(friction), float(strength)))
    return HeapSettings(best[1], effect, best[2])


def _misfit(twin: Shape, target: Shape) -> float:
    """Mean square over the surface plus that of the angle, in sds of packings."""
    gap = (twin.surface - target.surface) / PACKING_SD["crest"]
    return (
        float(np.nanmean(gap**2))
        + ((twin.angle_deg - target.angle_deg) / PACKING_SD["angle"]) ** 2
    )


def _run(
    kind: Kind, settings: HeapSettings, seed_mm: float, out: Path, pictures: bool
) -> Shape:
    description = kind.recordings[0].description
    settings = replace(settings, strength=0.0) if kind.plain else settings
    if not pictures:
        packings = range(PACKINGS, 2 * PACKINGS)
        heaps = [simulate_heap(description, settings, seed_mm, p) for p in packings]
        return shape_of(heaps)
    shutil.rmtree(out, ignore_errors=True)
    recording, parameters = simulation_inputs(description, settings, seed_mm)
    for p in range(PACKINGS):
        at = out / f"pile-{p + 1}"
        at.parent.mkdir(parents=True, exist_ok=True)
        simulate(
            "pile",
            parameters,
            rng=np.random.default_rng([5, PACKINGS + p]),
            out=at,
            like=recording,
            threads=1,
        )
    seen = read_piles(out)
    if trouble := [s.trouble for s in seen if s.trouble]:
        raise ValueError(f"the twin's photo cannot be measured: {trouble[0]}")
    return shape_of(seen)


def _compared(recordings, old: Shape, new: Shape, by: str) -> list[Comparison]:
    rows = []
    for r in recordings:
        own = shape_of([r])
        before, after = (
            float(np.sqrt(np.nanmean((_over_base(t) - _over_base(own)) ** 2)))
            for t in (old, new)
        )
        rows.append(
            Comparison(
                r.recording, "surface over the flank's base", "1", before, after, by
            )
        )
        before, after = (abs(t.angle_deg - own.angle_deg) for t in (old, new))
        rows.append(
            Comparison(r.recording, "angle of the flank", "°", before, after, by)
        )
    return rows


def _over_base(shape: Shape) -> np.ndarray:
    """(n,) heights at AT over the flank's base."""
    return shape.surface * np.tan(np.radians(shape.angle_deg))


def _figure(recordings, old: Shape, new: Shape) -> dict:
    """The three profiles."""
    points = {}
    for name, shape in (
        ("recorded", shape_of(list(recordings))),
        ("old twin", old),
        ("new twin", new),
    ):
        there = np.isfinite(shape.surface)
        points[name] = (AT[there], _over_base(shape)[there])
    return {
        "x": "place on the flank (0: crest, 1: toe)",
        "y": "surface above the plate (of the flank's base)",
        "points": points,
    }


def _pictured(again: Resimulation, at: Path) -> Resimulation:
    """`again` with both simulations' photos side by side."""
    files = [
        at.with_name(f"{at.name}-{which}") / "pile-1" / "photo.png"
        for which in ("old", "new")
    ]
    photos = [
        photo for file in files if (photo := cv2.imread(str(file), 0)) is not None
    ]
    if len(photos) < len(files):
        return again
    wide = 700
    small = [
        cv2.resize(
            p, (wide, int(p.shape[0] * wide / p.shape[1])), interpolation=cv2.INTER_AREA
        )
        for p in photos
    ]
    caption = (
        "a heap of the old twin, and one of the new twin with"
        f" {' and '.join(again.effects)}"
    )
    return replace(
        again, picture=beside(small, ["old twin", "new twin"]), caption=caption
    )
