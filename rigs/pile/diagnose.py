"""Heaps, from photos to a finding."""

from collections.abc import Iterator

import numpy as np

from benchtwin.bench import distributions as stats
from benchtwin.bench.language import tr
from benchtwin.bench.lines import one_a_reason
from benchtwin.infer import power_law
from benchtwin.infer.conditions import Contact, conditions_of
from benchtwin.infer.effect import separating_recordings
from benchtwin.infer.explanation import Alternative, Explanation
from benchtwin.infer.finding import Curve, Finding
from benchtwin.infer.inference import finding_of
from benchtwin.infer.power_law import Family, Law
from benchtwin.infer.problem import Fit
from benchtwin.infer.task import DiagnosisTask
from benchtwin.infer.unlisted import Bin, Windows
from benchtwin.rigs.pile.effects import EFFECTS
from benchtwin.rigs.pile.flanks import Photo, photos_of
from benchtwin.rigs.pile.problem import differing, problem_of, rows, seeds_high
from benchtwin.rigs.pile.scatter import scatter_of

ONE = "one photo: nothing can be held out, and nothing is named for certain"
ONE_FLANK = "one flank only: left and right cannot be compared"
COUNTED = {
    "plate": "no plumb_deg: angles count from the plate's own line",
    "rows": "no plumb_deg: angles count from the picture's rows",
}
NO_SCALE = (
    "no scale in {}: places are shares of the flank, and the toe is not compared with"
    " the size of a seed"
)
SAME = (
    "all photos show one kind of heap: friction, rolling, grain shape and walls all set"
    " its angle; no photo tells them apart"
)
AGAIN = "the same heap again, and a heap with two flanks"
REPOSE = Contact("repose_angle_deg", "repose", 1.0, "middle")
# sd by which repeats of one kind of heap differ, at most (real ones: 0.6 to 2°), and
# how rarely so much more is seen of one kind
ONE_KIND_DEG, ONE_KIND_P = 2.0, 1e-3
WIDTH = 0.2  # of a window, over the flank's way
BREAKS = {
    f"break at {at:.0%}": at for at in (0.35, 0.5, 0.65)
}  # of the flank's way, as where two kinds of grains lie over each other
SIDES = {-1: "left flank", 1: "right flank"}


def diagnose_pile(recordings, rng: np.random.Generator) -> Finding:
    """Finding of heaps (read.SeenPile); ValueError where no photo shows a
    flank."""
    photos, refused = photos_of(recordings)
    conditions, said = conditions_of(
        tuple(p.recording for p in photos),
        [{"conditions": p.conditions} for p in photos],
        [p.session for p in photos],
    )
    rising = [
        q
        for q, v in differing(photos).items()
        if (np.diff(v) >= 0).all() or (np.diff(v) <= 0).all()
    ]
    if rising:
        conditions = tuple(c for c in conditions if c.name != "order")
        said = (
            *said,
            (
                tr(
                    "{} goes with the order of the recordings: the two cannot be told"
                    " apart",
                    tr(" and ").join(rising),
                )
            ),
        )
    scatter = scatter_of(photos)
    # no plumb: a later tilt shows nothing
    orders = (False, True) if any(p.reference == "plumb" for p in photos) else (False,)
    problems = [problem_of(photos, scatter, after=after) for after in orders]
    alternatives = tuple(Alternative(p) for p in problems)
    notes = (*refused, *_notes(photos), *said)
    asked = DiagnosisTask(
        "pile",
        alternatives,
        windows_of,
        curves_of,
        {REPOSE.name: repose_deg},
        law_of,
        lambda names: separating_recordings(EFFECTS, names) or tr(AGAIN),
        notes,
        follows=(REPOSE, conditions),
    )
    return finding_of(asked, rng)


def repose_deg(e: Explanation) -> tuple[float, float]:
    """Mean angle of the heaps without what was found, and its sd."""
    return e.fit.problem.model.centre_deg + e.fit.by_name["repose"], e.fit.sd("repose")


def windows_of(fit: Fit) -> Windows:
    """Triangular windows along the flank, and flanks that break at BREAKS."""
    photos = fit.problem.model.photos
    flanks = [f for p in photos for f in p.flanks]
    scaled = all(p.unit == "mm" for p in photos)
    length = float(np.mean([f.length for f in flanks])) if scaled else 1.0
    middles = np.arange(WIDTH / 2, max(f.u[-1] for f in flanks), WIDTH / 2)

    def surface(u: np.ndarray) -> np.ndarray:
        hats = np.maximum(1 - np.abs(u[:, None] - middles) / (WIDTH / 2), 0)
        breaks = (np.interp(u, [0, at, 1], [0.0, 1.0, 0.0]) for at in BREAKS.values())
        return np.column_stack([hats, *breaks])

    kinds = [
        (m, "surface", "crest" if m < 1 / 3 else "middle" if m < 0.75 else "toe")
        for m in middles
    ]
    # each is a component of its own
    kinds += [(at, name, "middle") for name, at in BREAKS.items()]
    axis, half = "x_mm" if scaled else "x_share", WIDTH / 2
    bins = [
        Bin(axis, float(length * (m - half)), float(length * (m + half)), push, sector)
        for m, push, sector in kinds
    ]
    return Windows([rows(p, surface) for p in photos], tuple(bins))


def law_of(fit: Fit) -> Law:
    """Where a flank breaks."""
    windows = windows_of(fit)
    breaks = [k for k, b in enumerate(windows.bins) if b.push in BREAKS]
    families = [_breaking(windows.bins[k].push) for k in breaks]
    return power_law.law_of(fit, families, [rows[:, breaks] for rows in windows.extra])


def _breaking(push: str) -> Family:
    def say(rises: bool, power: str) -> str:
        where = tr("below") if rises else tr("above")
        return tr("flanks {} of their way, steeper {}", push, where)

    return Family(
        say,
        ("1", tr("of the height off a straight line")),
        "middle",
        not_simulated=tr("the twin pours one kind of grains"),
    )


def curves_of(before: Fit, after: Fit) -> tuple[Curve, ...]:
    """Height of each flank above the plate, from the crest outwards; residuals without
    locals."""
    out = []
    for r, photo in enumerate(before.problem.model.photos):
        left = [
            of.problem.model.predict(r, of.starts[r], of.by_name)
            for of in (before, after)
        ]
        row = 0
        for f in photo.flanks:
            here = slice(row, row := row + len(f.u))
            out.append(
                Curve(
                    photo.recording,
                    f"{SIDES[f.side]}'s height",
                    photo.unit,
                    f"x_{photo.unit}",
                    f.length * f.u,
                    f.height * f.v,
                    *(f.height * (f.v - of[here]) for of in left),
                )
            )
    return tuple(out)


def _notes(photos: tuple[Photo, ...]) -> tuple[str, ...]:
    said = [(p.recording, n) for p in photos for n in p.notes]
    said += [(p.recording, tr(ONE_FLANK)) for p in photos if len(p.flanks) == 1]
    said += [
        (p.recording, COUNTED[p.reference]) for p in photos if p.reference in COUNTED
    ]
    notes = [*one_a_reason(said), *(mixed := [*_mixed(photos)])]
    unscaled = [p.recording for p in photos if p.unit == "px"]
    notes += [tr(NO_SCALE, ", ".join(unscaled))] if unscaled else []
    low = [(p, high) for p in photos if (high := seeds_high(p)) < 5]
    notes += [
        tr(
            "{}: only {:.1f} seeds high: its surface is that of single seeds",
            p.recording,
            high,
        )
        for p, high in low
    ]
    notes += [tr(ONE)] if len(photos) == 1 else []
    alike = len({p.stated for p in photos}) == 1 and not mixed
    notes += [tr(SAME)] if alike else []
    return tuple(notes)


def _mixed(photos: tuple[Photo, ...]) -> Iterator[str]:
    """Of heaps that state the same, but are not of one kind."""
    for stated in dict.fromkeys(p.stated for p in photos):
        own = [p for p in photos if p.stated == stated]
        angles = np.array([np.mean([f.angle_deg for f in p.flanks]) for p in own])
        off = float(((angles - angles.mean()) ** 2).sum())
        if stats.chi2.sf(off / ONE_KIND_DEG**2, len(own) - 1) < ONE_KIND_P:
            ends = [
                f"{own[k].recording} ({angles[k]:.1f}°)"
                for k in (angles.argmin(), angles.argmax())
            ]
            sd = np.sqrt(off / (len(own) - 1))
            yield (
                tr(
                    "{} heaps that state the same differ by {:.1f}° (standard"
                    " deviation), repeats of one kind by up to {:g}°: something that"
                    " nobody states differs between them, from {}",
                    len(own),
                    sd,
                    ONE_KIND_DEG,
                    " to ".join(ends),
                )
            )
