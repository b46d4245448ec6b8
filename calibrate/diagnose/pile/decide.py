"""The verdict on heaps: evidence as everywhere, and beyond it only what the photos' own differences can carry.

Tilts are asked first (the plate's line, left against right), then what changes the heap's shape, with the tilts held free. A
shape has a name for certain only where a stated condition of its law differs between photos: one kind of heap cannot tell
friction, rolling, grain shape and walls apart, nor what the gate did from what shook. A heap that was tilted after it was poured
is a rolled picture of itself: camera roll is always a class.
"""

import numpy as np

from calibrate.diagnose.decide import ALPHA, LN_BF_BASELINE, LN_BF_RIVAL, SATURATED_P, Candidate, Verdict
from calibrate.diagnose.effects.pile import EFFECTS, RIVALS
from calibrate.diagnose.linear import chance
from calibrate.diagnose.locate import Location, noise_doubt
from calibrate.diagnose.name import alarm, candidate
from calibrate.diagnose.pile.problem import differing
from calibrate.diagnose.problem import Fit, fit
from calibrate.diagnose.scores import explained

TILTS = (("base-tilt",), ("camera-roll",), ("base-tilt", "camera-roll"))
SHAPES = ("cohesion", "gate-speed", "base-vibration", "wall-friction", "particle-shape")
WRONG_SIGN, WRONG_SIGN_FIRST = 3.0, 1.0  # sd of a further parameter, and of an effect's first, on the wrong side
LAW_LOOSE = 0.15  # of the χ² that a shape explains may be left by its law's own form: no law of heaps is known better
TWO_PHOTOS = "a second photo of the same kind of heap, so that something can be held out"
CONTRASTS = {
    "cohesion": {"seed_mm", "rig_mm"}, "gate-speed": {"gate_speed_mm_s"}, "base-vibration": {"photo_s"},
    "wall-friction": {"width_mm"},
}  # fmt: skip


def decide(base: Fit, location: Location, rng: np.random.Generator) -> Verdict:
    """none | name | class | unknown, for a fitted baseline that has been located."""
    p = _alarm(base, location, rng)
    if p >= ALPHA:
        return Verdict("none", (), p, (), float("nan"), None)
    tilts = _tried(base, TILTS, (), rng)
    tilt = _best(tilts)
    held = tilt.names if tilt else ()
    shapes = _tried(base, tuple((n,) for n in (*SHAPES, *(n for n, e in RIVALS.items() if not e.group))), held, rng)
    before = tilt.ln_bayes if tilt else 0.0
    possible = [c for c in shapes if _possible(base, c, held)]
    shape = _best(possible, before)
    found = [part for part in (_tilt_part(base, tilt, tilts), _shape_part(base, shape, possible, held)) if part]
    tried = tuple(sorted((*tilts, *shapes), key=lambda c: -c.ln_bayes))
    advice = next((part.next_record for part in found if part.next_record), None)
    best = shape or tilt
    if best is None or _unexplained(base, best, shape, shapes, before) or any(part.verdict == "unknown" for part in found):
        return Verdict("unknown", (), p, tried, float("nan"), advice or "the same heap again, and a heap with two flanks")
    kind = "name" if all(part.verdict == "name" for part in found) else "class"
    runner_up = min(part.ln_bayes_runner_up for part in found)
    return Verdict(kind, tuple(n for part in found for n in part.names), p, tried, runner_up, advice)


def _alarm(base: Fit, location: Location, rng: np.random.Generator) -> float:
    """Global p: that of single scores and of the smooth excess, or of all that one shape does together (how its parts compare is
    hardly known); Bonferroni."""
    shapes = [n for n in SHAPES if n in base.problem.effects]
    doubt = noise_doubt(base, rng)
    together = min(chance(*explained(base, base.problem.columns_of(n)), doubt) for n in shapes)
    return min(1.0, 1.5 * alarm(base, location, rng)[0], 3 * len(shapes) * together)


def _unexplained(base: Fit, best: Candidate, shape: Candidate | None, shapes: list[Candidate], before: float) -> bool:
    """Whether what fits best of all goes against its own law, or too much is left; best: what the verdict rests on."""
    top = max(shapes, key=lambda c: c.ln_bayes)
    if top.ln_bayes > max(shape.ln_bayes if shape else -np.inf, before + 2.0) + LN_BF_RIVAL:
        return True
    return _left_over(base, best, before if shape else None)


def _tried(base: Fit, sets, held: tuple[str, ...], rng: np.random.Generator) -> list[Candidate]:
    here = [s for s in sets if all(n in base.problem.effects for n in s)]
    return [candidate(base, (*held, *s), rng) for s in here]


def _best(found: list[Candidate], before: float = 0.0) -> Candidate | None:
    """The greatest evidence, where it beats the model without it."""
    top = max(found, key=lambda c: c.ln_bayes, default=None)
    return top if top is not None and top.ln_bayes >= before + LN_BF_BASELINE else None


def _possible(base: Fit, tried: Candidate, held: tuple[str, ...]) -> bool:
    """Whether all that an effect does goes the way of its law, within the noise."""
    model = fit(base.problem, free=tried.names, start=base)
    own = [n for name in tried.names if name not in held for n in base.problem.columns_of(name)]
    for n in own:
        e, sd = base.problem.effects[n], model.sd(n) * (WRONG_SIGN if base.problem.effects[n].group else WRONG_SIGN_FIRST)
        if not e.low - sd <= model.by_name[n] <= e.high + sd:
            return False
    return True


def _left_over(base: Fit, best: Candidate, before: float | None) -> bool:
    """Whether more is left than noise, and than a shape's law may leave; before: evidence without the shape, None: no shape."""
    if best.left_p > SATURATED_P:
        return False
    fall, freedom = explained(fit(base.problem, free=best.names, start=base), (), smooth=True)
    return before is None or fall - freedom > LAW_LOOSE * 2 * (best.ln_bayes - before)


def _lasting(best: Candidate) -> list[str]:
    """Rules that it breaks, but for what is left over, which `_left_over` judges."""
    return [flaw for flaw in best.flaws if not flaw.startswith("something else")]


def _tilt_part(base: Fit, best: Candidate | None, tried: list[Candidate]) -> Verdict | None:
    """Definite only for a plate that leans under a heap whose two flanks do not."""
    if best is None:
        return None
    photos = base.problem.model.photos
    upright = all(p.reference == "plumb" and len(p.flanks) == 2 and np.isfinite(p.plate_deg) for p in photos)
    rivals = [c.ln_bayes for c in tried if not set(best.names) <= set(c.names)]
    clear = best.ln_bayes - max(rivals, default=0.0)
    sure = best.names == ("base-tilt",) and upright and clear >= LN_BF_RIVAL and not _lasting(best)
    if sure:
        return Verdict("name", best.names, 0.0, (), clear, None)
    return Verdict("class", ("base-tilt", "camera-roll"), 0.0, (), clear, _advice(photos, EFFECTS["base-tilt"].separating))


def _shape_part(base: Fit, best: Candidate | None, possible: list[Candidate], held: tuple[str, ...]) -> Verdict | None:
    if best is None:
        return None
    photos = base.problem.model.photos
    own = next(n for n in best.names if n not in held)
    if own in RIVALS:
        return Verdict(
            "unknown", (), 0.0, (), float("nan"), "a photo of the same heap through glass, or a slice of it: is it layered?"
        )
    close = [c for c in possible if c.ln_bayes > best.ln_bayes - LN_BF_RIVAL and c is not best]
    members = [own, *(n for c in sorted(close, key=lambda c: -c.ln_bayes) for n in c.names if n not in held and n not in RIVALS)]
    clear = best.ln_bayes - max((c.ln_bayes for c in possible if c is not best), default=0.0)
    contrast = _contrasted(own, photos)
    if not close and contrast and not _lasting(best):
        return Verdict("name", (own,), 0.0, (), clear, None)
    open_ones = [n for n in members if not _contrasted(n, photos)] or members
    return Verdict("class", tuple(dict.fromkeys(members)), 0.0, (), clear, _advice(photos, EFFECTS[open_ones[0]].separating))


def _contrasted(effect: str, photos) -> bool:
    """Whether a stated condition of its law differs between photos, or heaps were photographed in turn: what goes on is told."""
    in_turn = effect == "base-vibration" and any(np.isfinite(p.creep_deg) for p in photos)
    return in_turn or bool(CONTRASTS.get(effect, set()) & set(differing(photos)))


def _advice(photos, separating: str) -> str:
    return f"{TWO_PHOTOS}; {separating}" if len(photos) == 1 else separating
