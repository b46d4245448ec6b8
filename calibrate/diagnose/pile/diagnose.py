"""Heaps, from photos to a finding."""

from dataclasses import replace

import numpy as np

from calibrate.diagnose.decide import Verdict
from calibrate.diagnose.effects.pile import RIVALS
from calibrate.diagnose.finding import Finding, finding_of, parameters_of
from calibrate.diagnose.locate import locate
from calibrate.diagnose.pile.curves import curves_of
from calibrate.diagnose.pile.decide import SHAPES, decide
from calibrate.diagnose.pile.flanks import Photo, photos_of
from calibrate.diagnose.pile.problem import problem_of, seeds_high
from calibrate.diagnose.pile.windows import windows_of
from calibrate.diagnose.problem import Fit, fit

ONE = "one photo: nothing can be held out, and nothing is named for certain"
NO_SCALE = "no scale in {}: places are shares of the flank, and the toe is not compared with the size of a seed"
SAME = "all photos show one kind of heap: friction, rolling, grain shape and walls all set its angle; no photo tells them apart"


def diagnose_pile(recordings, rng: np.random.Generator) -> Finding:
    """Finding of one bench's heaps (calibrate.twin.piles.SeenPile); ValueError where no photo shows a flank."""
    photos, refused = photos_of(recordings)
    base = fit(problem_of(photos))
    where = locate(base, windows_of(base), rng)
    found = decide(base, where, rng)
    notes = (*refused, *_notes(photos))
    return _reported(base, finding_of(base, where, found, law=_law(base, found), notes=notes, draw=curves_of))


def _notes(photos: tuple[Photo, ...]) -> tuple[str, ...]:
    notes = [f"{p.recording}: {n}" for p in photos for n in p.notes]
    notes += [f"{p.recording}: one flank only: left cannot be held against right" for p in photos if len(p.flanks) == 1]
    for p in photos:
        if p.reference != "plumb":
            from_what = "the plate's own line" if p.reference == "plate" else "the picture's rows"
            notes.append(f"{p.recording}: no plumb_deg: angles count from {from_what}")
    unscaled = [p.recording for p in photos if p.unit == "px"]
    notes += [NO_SCALE.format(", ".join(unscaled))] if unscaled else []
    notes += [
        f"{p.recording}: only {high:.1f} seeds high: its surface is that of single seeds"
        for p, high in _heights(photos)
        if high < 5
    ]
    notes += [ONE] if len(photos) == 1 else []
    notes += [SAME] if len({p.stated for p in photos}) == 1 else []
    return tuple(notes)


def _heights(photos: tuple[Photo, ...]) -> list[tuple[Photo, float]]:
    """Heights in seeds, NaN where unknown."""
    return [(p, float(np.mean([seeds_high(p, f) for f in p.flanks]))) for p in photos]


def _law(base: Fit, found: Verdict) -> str | None:
    """What an unknown shape looks like, where the rival that explains it best says it."""
    best = next((c for c in found.candidates if set(c.names) & set(RIVALS)), None)
    if found.verdict != "unknown" or best is None or best is not found.candidates[0]:
        return None
    own = next(n for n in best.names if n in RIVALS)
    value = best.value[best.names.index(own)]
    at, steeper = float(own.removeprefix("kink-")), "below" if value > 0 else "above"
    return f"the flank breaks at {at:.0%} of its way: {abs(value):.1%} of the height off a straight line, steeper {steeper}"


def _reported(base: Fit, finding: Finding) -> Finding:
    """Shapes have no one number: theirs stand as name.crest, name.toe, name.angle, name.bow and name.creep."""
    shape = next((n for n in finding.names if n in SHAPES), None)
    if finding.verdict != "name" or shape is None:
        return finding
    model = fit(base.problem, free=finding.names, start=base)
    columns = base.problem.columns_of(shape)
    every = parameters_of(model, (*(n for n in finding.names if n != shape), *columns))
    of = base.problem.effects[shape]
    first = "bow" if of.sector == "middle" else "creep" if of.unit == "deg" else "crest"
    return replace(finding, parameters={f"{n}.{first}" if n == shape else n: p for n, p in every.items()})
