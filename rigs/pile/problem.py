"""Heaps as a problem: flanks' surfaces, their angles and the plate's line, all linear.

surface   v(u) = max(1 − u, 0) + usual(u) + material (global) + packing (local)
          + effects
angle     θ = θ₀ + side · (turn of the heap in the picture) + packing + effects
plate     inclination against the stated plumb = base tilt + camera roll
creep     flattening from first to last photo = settling + base vibration
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from benchtwin.infer.effect import Effect
from benchtwin.infer.evidence import UnknownScatter
from benchtwin.infer.linear import Reduced, stacked
from benchtwin.infer.problem import Problem
from benchtwin.infer.series import Locals, Series
from benchtwin.infer.series import problem_of as series_problem
from benchtwin.rigs.pile import heap_priors
from benchtwin.rigs.pile.effects import EFFECTS
from benchtwin.rigs.pile.effects.shapes import HeapEffect
from benchtwin.rigs.pile.flanks import Photo
from benchtwin.rigs.pile.heap_priors import NATURAL, PARTS, PRIORS
from benchtwin.rigs.pile.scatter import ANGLE_SD_DEG, WAVES, Scatter, cosines

PLATE_FLOOR_DEG = 0.05
FREE = 0.5  # sd of a flank's own level and slope, over its height
REPEATS = 2  # from which the scatter of equal heaps is estimated from them
DIFFERS = 1.1  # times another's: a stated quantity that differs


@dataclass(frozen=True, eq=False)
class Model:
    """All linear: base + own @ locals + columns @ globals."""

    photos: tuple[Photo, ...]
    scatter: Scatter
    centre_deg: float  # mean angle
    names: tuple[str, ...]  # (G,) of the globals
    base: tuple[np.ndarray, ...]  # (R): what the usual heap shows
    columns: tuple[np.ndarray, ...]  # (R): (n_r, G)
    own: tuple[np.ndarray, ...]  # (R): (n_r, L) of packings

    def predict(self, r: int, own: np.ndarray, values: dict[str, float]) -> np.ndarray:
        """What photo r shows."""
        return (
            self.base[r]
            + self.own[r] @ own
            + self.columns[r] @ np.array([values[n] for n in self.names])
        )


def problem_of(photos: tuple[Photo, ...], scatter: Scatter, *, after: bool) -> Problem:
    """after: whether a tilted plate was tilted after its heap was poured."""
    nuisances = _nuisances(photos)
    acted = {n: _acted(photos, e, after) for n, e in EFFECTS.items()}
    acted = {
        n: columns for n, columns in acted.items() if any(c.any() for c in columns)
    }
    model = _model(
        photos, scatter, acted | {n: columns for n, (_, columns) in nuisances.items()}
    )
    series = tuple(_series(p, r, scatter) for r, p in enumerate(photos))
    held = np.array([FREE] * 4 + [*scatter.even.values(), *scatter.odd.values()])
    own = Locals(np.zeros((len(photos), len(held))), np.full(len(held), 1e-3), held)
    known = {n: sd for n, (sd, _) in nuisances.items()}
    stated = {n: sd_of(photos) for n in acted if (sd_of := EFFECTS[n].law.known_deg)}
    effects: dict[str, Effect] = {n: EFFECTS[n] for n in acted}
    made = series_problem(
        "pile",
        series,
        own,
        model.predict,
        effects,
        known,
        known | stated,
        model,
        max_iterations=2,
    )
    repeats = len(photos) - len({p.stated for p in photos})

    def unknown_scatter(
        problem: Problem, reduced: tuple[Reduced, ...]
    ) -> UnknownScatter:
        """Rows' change by one sd of a packing's angle."""
        steeper = stacked(reduced)[0][:, problem.names.index("repose")]
        return UnknownScatter(steeper * scatter.even["angle"])

    return replace(
        made, unknown_scatter=None if repeats >= REPEATS else unknown_scatter
    )


def differing(photos: tuple[Photo, ...]) -> dict[str, np.ndarray]:
    """Stated quantities (R,) that differ between photos."""
    values = {q: np.array([getattr(p, q) for p in photos]) for q in NATURAL}
    return {
        q: v
        for q, v in values.items()
        if np.isfinite(v).all() and v.max() > DIFFERS * v.min()
    }


def _nuisances(photos: tuple[Photo, ...]) -> dict[str, tuple[float, list[np.ndarray]]]:
    """sd of each nuisance, and its columns, one a photo.

    repose: all flanks steeper; lopsided: one steeper, one flatter; shape-n-k: the
    material's own shape, of heaps with n flanks; settling: all flatter with time;
    quantity:part: usual variation with a stated quantity."""
    found = {
        "repose": [rows(p, _steeper(p), lambda side: 1.0) for p in photos],
        "lopsided": [rows(p, angle=float) for p in photos],
        "settling": [rows(p, creep=1.0) for p in photos],
    }
    out = {n: (PRIORS[n], columns) for n, columns in found.items()}
    for count in sorted({len(p.flanks) for p in photos}):
        usual = heap_priors.usual(count)
        material = [
            (len(p.flanks) == count)
            * rows(p, partial(usual.columns, seeds_high=seeds_high(p)))
            for p in photos
        ]
        out |= {
            f"shape-{count}-{k}": (1.0, [m[:, k] for m in material])
            for k in range(material[0].shape[1])
        }
    for quantity, stated in differing(photos).items():
        log = np.log(stated) - np.log(stated).mean()
        for part, sd in zip(("crest", "toe", "angle"), NATURAL[quantity], strict=True):
            laws = (PARTS[part], None) if part in PARTS else (None, lambda side: 1.0)
            out[f"{quantity}:{part}"] = (
                sd,
                [x * rows(p, *laws) for x, p in zip(log, photos)],
            )
    return out


def _model(
    photos: tuple[Photo, ...], scatter: Scatter, acted: dict[str, list[np.ndarray]]
) -> Model:
    centre = float(np.mean([f.angle_deg for p in photos for f in p.flanks]))
    base = [
        rows(
            p,
            lambda u, p=p: (
                heap_priors.straight(u)
                + heap_priors.usual(len(p.flanks)).mean(u, seeds_high(p), centre)
            ),
            lambda side: centre,
        )
        for p in photos
    ]
    columns = [np.column_stack(own) for own in zip(*acted.values(), strict=True)]
    return Model(
        photos,
        scatter,
        centre,
        tuple(acted),
        tuple(base),
        tuple(columns),
        tuple(_own(p) for p in photos),
    )


def _acted(
    photos: tuple[Photo, ...], effect: HeapEffect, after: bool
) -> list[np.ndarray]:
    """What one unit of an effect does to each photo: where it is of seeds, nothing to
    plain ones."""
    law, of_seeds = effect.law, EFFECTS[effect.group or effect.name].of_seeds
    turns = law.turn_deg | (law.turn_after_deg if after else {})
    out = []
    for weight, photo in zip(law.weight(photos), photos, strict=True):
        weight = 0.0 if photo.plain and of_seeds else weight
        turn = turns.get(photo.reference, 0.0)
        angle = lambda side, turn=turn: law.angle_deg + side * turn  # noqa: E731
        out.append(
            weight * rows(photo, law.surface, angle, law.plate_deg, law.creep_deg)
            + weight * law.angle_deg * rows(photo, _steeper(photo))
        )
    return out


def _steeper(photo: Photo) -> Callable[[np.ndarray], np.ndarray]:
    """What a surface is like where its heap is steeper by a degree."""
    return heap_priors.usual(len(photo.flanks)).steeper


def rows(
    photo: Photo, surface=None, angle=None, plate: float = 0.0, creep: float = 0.0
) -> np.ndarray:
    """Rows (n_r,) or (n_r, k) from surface(u), angle(side), the plate's line and
    creep."""
    parts = [surface(f.u) if surface else np.zeros(len(f.u)) for f in photo.flanks]
    last = [angle(f.side) if angle else 0.0 for f in photo.flanks]
    last += [plate] * int(np.isfinite(photo.plate_deg)) + [creep] * int(
        np.isfinite(photo.creep_deg)
    )
    across = parts[0].shape[1:]
    column = np.reshape(last, (-1,) + (1,) * len(across))
    return np.concatenate([*parts, np.broadcast_to(column, (len(last), *across))])


def seeds_high(photo: Photo) -> float:
    """The heap's height over a seed's length, NaN if unknown."""
    if photo.unit == "mm":
        return float(np.mean([f.height for f in photo.flanks])) / photo.seed_mm
    return float("nan")


def _own(photo: Photo) -> np.ndarray:
    """(n_r, 12): level and slope of each flank; crest, toe, bow, angle of both, and
    opposed."""
    out = np.zeros((len(rows(photo)), 12))
    first, lines = 0, sum(len(f.u) for f in photo.flanks)
    for k, f in enumerate(photo.flanks):
        here = slice(first, first := first + len(f.u))
        out[here, 2 * k : 2 * k + 2] = np.column_stack([np.ones(len(f.u)), f.u - 0.5])
        parts = np.column_stack([part(f.u) for part in PARTS.values()])
        out[here, 4:7], out[here, 8:11] = parts, f.side * parts
        out[lines + k, [7, 11]] = 1.0, f.side
    return out


def _series(photo: Photo, r: int, scatter: Scatter) -> Series:
    """Surface, angles, plate's line and creep of one photo; smooth: cosines along all
    flanks."""
    plate_sd = float(np.hypot(photo.plate_sd_deg, PLATE_FLOOR_DEG))
    last = [x for x in (photo.plate_deg, photo.creep_deg) if np.isfinite(x)]
    data = np.concatenate(
        [*(f.v for f in photo.flanks), [f.angle_deg for f in photo.flanks], last]
    )
    sd = rows(
        photo,
        lambda u: np.full(len(u), scatter.sigma[r]),
        lambda side: ANGLE_SD_DEG,
        plate_sd,
        scatter.creep_deg,
    )
    lag = np.full(len(data), np.inf)
    lag[: sum(len(f.u) for f in photo.flanks)] = np.concatenate(
        [scatter.lags[r, k] for k in range(len(photo.flanks))]
    )
    smooth = rows(photo, lambda u: cosines(u, range(2, WAVES + 2)))
    return Series(photo.recording, data, sd, lag, scatter.noise, smooth)
