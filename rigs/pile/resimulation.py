"""Heaps run again in the DEM, without and with an effect.

What nobody states of a heap (simulated_heaps.UNKNOWNS) and the effect's strength are
drawn together, a heap is simulated for each draw, and what it shows becomes a quadratic
of them (response.Quadratic). Settings without and with the effect are fitted to half of
the recordings, simulated, and compared with the other half.
"""

import shutil
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import islice
from pathlib import Path

import cv2
import numpy as np

from benchtwin.bench.language import tr
from benchtwin.diagnose.rerun import Comparison, Resimulation
from benchtwin.infer.finding import Finding
from benchtwin.rigs.pile.effects import EFFECTS
from benchtwin.rigs.pile.flanks import photo_of
from benchtwin.rigs.pile.heap_twin import (
    Added,
    Rig,
    added_to,
    between,
    fitted,
    is_plain,
    odds_over_friction,
    posterior,
    responding,
    spared,
)
from benchtwin.rigs.pile.read import SeenPile, read_piles
from benchtwin.rigs.pile.simulated_heaps import (
    AT,
    UNKNOWNS,
    HeapSettings,
    Shape,
    assumed,
    heap_job,
    heap_of,
    shape_of,
)
from benchtwin.sim.engine.step import Stopped
from benchtwin.sim.lammps.program import cores_here
from benchtwin.twin.job import Job
from benchtwin.twin.paths import beside

FRICTION = "seed-friction"
PACKINGS, TRIES = 2, 5  # of a heap; where some are stopped
HEAP = "heap"  # folder of its recording
MOST_RIGS = 2
CLOCK = (
    "simulated collapses take {} times as long as films say whose frame rate is not"
    " stated"
)
HOW = (
    "friction and rolling friction between seeds, friction on the plate and, if no"
    " film shows it, the gate's speed let old and new twin fit as well as each can;"
    f" {PACKINGS} packings each, their mean; surfaces are compared in shares of the"
    " flank's base, so that its steepness counts as well as its form"
)


def resimulate(
    finding: Finding, recordings: list[SeenPile], folder: Path, pictures: bool, say
) -> Resimulation:
    """Each half of the recordings beside heaps fitted to the other half."""
    if len(finding.modelled) > 1:
        raise ValueError(tr("two effects at once are not put into a simulated heap"))
    (effect,), used = finding.modelled, set(finding.recordings)
    seen = [
        r
        for r in recordings
        if {r.recording, r.recording.rpartition("/")[0]} & used and photo_of(r).flanks
    ]
    added = added_to(seen, effect)
    chosen = _of_one_rig(seen)[:MOST_RIGS]
    for group in chosen:  # refused before anything runs
        for corner in np.eye(len(UNKNOWNS) + 1)[[0, -1]]:
            heap_job(group[0].description, added.settings(corner), added.seed_mm, 0)
    rigs = [responding(tuple(group), added, folder / "heaps", say) for group in chosen]
    held_out = all(len(g) > 1 for rig in rigs for g in rig.groups(None))
    rows: list[Comparison] = []
    shown: list[tuple[tuple[SeenPile, ...], Shape, Shape, Path]] = []
    for half in (0, 1) if held_out else (None,):
        fitted_to = None if half is None else 1 - half
        settings = [fitted(rigs, fitted_to, added, free) for free in (False, True)]
        for rig in rigs:
            for group in rig.groups(half):
                own = [
                    replace(s, unknown=s.unknown | rig.gate_speed(group))
                    for s in settings
                ]
                say(tr("pile: running the twin again, {}", len(shown) + 1))
                at = folder / f"twin-{len(shown) + 1}"
                old, new = (
                    _run(group[0], s, added.seed_mm, Path(f"{at}-{which}"), pictures)
                    for which, s in zip(("old", "new"), own, strict=True)
                )
                rows += _compared(
                    group, old, new, "pictures" if pictures else "outline"
                )
                shown.append((group, old, new, at))
    counterpart = EFFECTS[effect].counterpart
    assert counterpart is not None  # checked by rerun.reason_not_simulated
    draws = posterior(rigs, added)
    strength = between(added.most * draws[:, -1]) if added.law.stepless else ""
    change = tr(counterpart.what).format(value=strength)
    clocks = [clock for rig in rigs if len(clock := rig.clock(draws))]
    notes = [tr(CLOCK, between(clock)) for clock in clocks]
    taken = {what for rig in rigs for what in assumed(rig.recordings[0].description)}
    notes += [tr("not stated, taken by the twin: {}", ", ".join(sorted(taken)))] * bool(
        taken
    )
    most_moved = max(shown, key=lambda s: abs(s[2].angle_deg - s[1].angle_deg))
    figure = _figure(*most_moved[:3])
    again = Resimulation(
        "pile",
        (effect,),
        change,
        tr(HOW),
        tuple(rows),
        held_out,
        notes=tuple(notes),
        figure=figure,
        repeats=_scatter([g for rig in rigs for g in rig.groups(None)]),
        rival=_rival(finding, rigs, added),
    )
    return _pictured(again, most_moved[3]) if pictures else again


def _of_one_rig(seen: list[SeenPile]) -> list[list[SeenPile]]:
    """Recordings by equal [seed] and [pile], plain or not; most recordings first."""
    rigs: list[tuple[tuple, list[SeenPile]]] = []
    for r in seen:
        pile = {k: v for k, v in r.description.get("pile", {}).items() if k != "plain"}
        own = (r.description.get("seed", {}), pile)
        same = next((group for stated, group in rigs if stated == own), None)
        if same is None:
            rigs.append((own, same := []))
        same.append(r)
    return sorted((group for _, group in rigs), key=len, reverse=True)


def _rival(finding: Finding, rigs: list[Rig], added: Added) -> tuple[str, float] | None:
    """Another friction between seeds, where it is as well possible and heaps of plain
    seeds could show it, with how many times as likely the effect is."""
    kinds = {is_plain(r) for rig in rigs for r in rig.recordings}
    if FRICTION not in finding.names or added.effect == FRICTION or len(kinds) < 2:
        return None
    return tr(EFFECTS[FRICTION].wording[0]), odds_over_friction(rigs, added)


def _run(
    like: SeenPile, settings: HeapSettings, seed_mm: float, out: Path, pictures: bool
) -> Shape:
    """Heaps as `like` by these settings, without the effect where it is spared."""
    if spared(like, settings.effect):
        settings = replace(settings, strength=0.0)

    def heap(p: int) -> SeenPile | None:
        job = heap_job(like.description, settings, seed_mm, p, rendered=pictures)
        return _heap(job, out / f"{p + 1}")

    with ThreadPoolExecutor(cores_here()) as pool:
        # pictures are drawn in one thread
        spread = map if pictures else pool.map
        heaps = [h for h in spread(heap, range(PACKINGS)) if h]
        more = filter(None, map(heap, range(PACKINGS, TRIES)))
        heaps += islice(more, PACKINGS - len(heaps))
    if not heaps:
        raise ValueError(
            tr("the engine stopped all of {} heaps: seeds too soft", TRIES)
        )
    return shape_of(heaps)


def _heap(job: Job, out: Path) -> SeenPile | None:
    """One heap, from its photo if that is drawn; None where the engine stopped."""
    try:
        if not job.rendered:
            return heap_of(job)
        if not job.is_done(out / HEAP):
            shutil.rmtree(out, ignore_errors=True)
        job.run(out / HEAP, threads=1)
    except Stopped:
        return None
    (seen,) = read_piles(out)
    if seen.trouble:
        raise ValueError(tr("the twin's photo cannot be measured: {}", seen.trouble))
    return seen


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
                r.recording, tr("surface over the flank's base"), "1", before, after, by
            )
        )
        before, after = (abs(t.angle_deg - own.angle_deg) for t in (old, new))
        rows.append(
            Comparison(r.recording, tr("angle of the flank"), "°", before, after, by)
        )
    return rows


def _scatter(groups: list[tuple[SeenPile, ...]]) -> float | None:
    """rms of each recording's surface about the mean of its repeats'; None without
    any."""
    off = []
    for group in groups:
        for k, own in enumerate(group if len(group) > 1 else ()):
            others = shape_of([*group[:k], *group[k + 1 :]])
            off.append(_over_base(shape_of([own])) - _over_base(others))
    return float(np.sqrt(np.mean([np.nanmean(o**2) for o in off]))) if off else None


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
        "x": tr("place on the flank (0: crest, 1: toe)"),
        "y": tr("surface above the plate (of the flank's base)"),
        "points": points,
    }


def _pictured(again: Resimulation, at: Path) -> Resimulation:
    """`again` with both simulations' photos side by side."""
    files = [
        at.with_name(f"{at.name}-{which}") / "1" / HEAP / "photo.png"
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
    caption = tr(
        "a heap of the old twin, and one of the new twin with {}",
        tr(" and ").join(again.effects),
    )
    return replace(
        again, picture=beside(small, ["old twin", "new twin"]), caption=caption
    )
