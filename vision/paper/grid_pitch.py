"""Decides by their strengths whether lines are 1, 5 or 10 mm apart: every fifth and
tenth line of the paper is heavier."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from benchtwin.bench.robust import robust_sd
from benchtwin.vision.paper.grid_find import Level
from benchtwin.vision.paper.grid_follow import Fit, GridMap

# A strong wave may be any harmonic of the 10-mm period; the finest lines lie at these
# multiples of the wave's length.
RATIOS = (
    0.1,
    0.2,
    0.3,
    0.4,
    0.5,
    0.6,
    0.7,
    0.8,
    0.9,
    1.0,
    1.2,
    1.4,
    1.6,
    1.8,
    2.0,
    3.0,
    4.0,
    5.0,
)
BINS = 16  # per line
# of the heaviest line's strength: fainter ones are due to blur or compression
FAINTEST = 0.04
SAMPLES = 60_000
_CLASSES = {  # pattern: class of each of ten lines, rising with strength
    "equal": (0,) * 10,
    "second": (1, 0) * 5,
    "fifth": (1, 0, 0, 0, 0) * 2,
    "tenth": (1,) + (0,) * 9,
    "fifth and tenth": (2, 0, 0, 0, 0, 1, 0, 0, 0, 0),
}
_MEANING = {  # pattern: possible distances of the finest lines [mm], description
    "fifth and tenth": ((1.0,), ""),
    "tenth": ((1.0,), ""),
    "fifth": ((1.0, 2.0), "every fifth one heavier, none heaviest"),
    "second": (
        (5.0,),
        (
            "every second one heavier: 5-mm and 10-mm lines whose 1-mm lines cannot be"
            " seen"
        ),
    ),
    "equal": ((1.0, 5.0, 10.0), "all equally strong"),
}


@dataclass(frozen=True)
class Strengths:
    """Strength of ten successive lines of one family and its sd; NaN where too little
    of a line is seen. dark_lines: how many of the ten are darker than half a line
    beside them."""

    value: np.ndarray
    sd: np.ndarray
    dark_lines: int = 10

    @property
    def complete(self) -> bool:
        """Whether all visible lines have a strength."""
        return bool(
            np.isfinite(self.value).sum() >= 6
            and self.missing == 0
            and self.dark_lines >= 6
        )

    @property
    def heaviest(self) -> int:
        """Index of the heaviest line; 0 where none is seen."""
        return int(np.argmax(np.nan_to_num(self.value)))

    @property
    def missing(self) -> int:
        """How many lines are not there, of those that could be seen."""
        value = self.value[np.isfinite(self.value)]
        sd = self.sd[np.isfinite(self.value)]
        return int(
            (value <= np.maximum(2.5 * sd, FAINTEST * value.max(initial=0))).sum()
        )


@dataclass(frozen=True)
class Pitch:
    """The finest lines' distance: `ratio` waves, which are `mm`; None where papers of
    several kinds have their pattern of strengths. may_be: the distances [mm] that the
    pattern allows; pattern: in words, "" where all lines of the paper are seen."""

    ratio: float
    mm: float | None
    may_be: tuple[float, ...]
    pattern: str
    shift: tuple[int, int] = (
        0,
        0,
    )  # lines by which the heaviest of ten lies off the origin


def find_pitch(fit: Fit, levels: list[Level], rng: np.random.Generator) -> Pitch | None:
    """The finest comb whose lines are all there, and what its pattern of strengths says
    it is. None: no comb is there."""
    for ratio in RATIOS:
        grid = fit.grid.with_density(1 / ratio)
        pitch_px = 1 / np.sqrt(
            abs(
                np.linalg.det(grid.jacobian(fit.windows.x.mean(), fit.windows.y.mean()))
            )
        )
        if not 2.2 < pitch_px < 400:
            continue
        both = [
            line_strengths(fit, grid, levels, pitch_px, family, rng)
            for family in (0, 1)
        ]
        complete = [s for s in both if s.complete]
        # One family is enough (a narrow strip shows few lines of the other), unless the
        # other says that lines are missing.
        if complete and max(s.missing for s in both) <= 2:
            return _best_pattern(ratio, both)
    return None


def line_strengths(
    fit: Fit,
    grid: GridMap,
    levels: list[Level],
    pitch_px: float,
    family: int,
    rng: np.random.Generator,
) -> Strengths:
    """Fold the darkness over ten lines and fit ten bells (one width) on a slowly
    changing ground, where the fit saw the grid."""
    level = levels[
        int(np.clip(np.floor(np.log2(max(pitch_px, 1) / 6)), 0, len(levels) - 1))
    ]
    # where the windows' weight lies
    half = 0.32 * fit.windows.h.shape[1] * fit.windows.fx
    pick = rng.integers(len(fit.windows.x), size=SAMPLES)
    full = [
        c[pick] + rng.uniform(-half, half, SAMPLES)
        for c in (fit.windows.x, fit.windows.y)
    ]
    # Between the pixels, lest a pitch of whole pixels leave gaps in the fold.
    dark = ndimage.map_coordinates(
        level.lines, level.reduced(*full)[::-1], order=1, mode="reflect"
    ).astype(float)
    # Paper that is not flat would smear the fold: each sample is put right by what its
    # own window saw.
    window_residual = fit.residual[pick, family] * float(grid.p[0] / fit.grid.p[0])
    place = grid.uv(*full)[family] - window_residual
    index = np.floor(np.mod(place, 10) * BINS).astype(int) % (10 * BINS)
    count = np.bincount(index, minlength=10 * BINS)
    order = np.lexsort((dark, index))
    # a bin's median: crossing lines, seeds and edges do not move it
    middle = np.cumsum(count) - (count + 1) // 2
    typical = dark[order][np.clip(middle, 0, len(dark) - 1)]
    noise = 1.25 * robust_sd(dark - typical[index]) / np.sqrt(np.maximum(count, 1))
    return _fit_bells(typical, noise + 1e-6, count > 0.05 * SAMPLES / (10 * BINS))


def _fit_bells(mean: np.ndarray, noise: np.ndarray, known: np.ndarray) -> Strengths:
    place = (np.arange(10 * BINS) + 0.5) / BINS
    # distance to each line [lines], around the period
    near = np.abs(np.mod(place[:, None] - np.arange(10) + 5, 10) - 5)
    seen = np.array([known[near[:, j] < 0.5].mean() > 0.9 for j in range(10)])
    nothing = Strengths(np.full(10, np.nan), np.full(10, np.nan))
    if seen.sum() < 6:
        return nothing
    waves = [
        np.ones_like(place),
        *(f(2 * np.pi * k * place / 10) for k in (1, 2) for f in (np.cos, np.sin)),
    ]
    ground = np.stack(waves if known.all() else waves[:1], -1)
    fits = []
    for width in (0.06, 0.09, 0.13, 0.18, 0.24, 0.32, 0.42):
        lines = np.exp(-0.5 * (near[:, seen] / width) ** 2)
        design = np.concatenate([lines, ground], 1)[known] / noise[known, None]
        answer, *_ = np.linalg.lstsq(design, mean[known] / noise[known], rcond=1e-9)
        left = design @ answer - mean[known] / noise[known]
        fits.append((float((left**2).sum()), design, answer))
    misfit, design, answer = min(fits, key=lambda f: f[0])
    unit = max(1.0, misfit / max(1, known.sum() - design.shape[1]))
    spread = np.sqrt(np.diag(np.linalg.pinv(design.T @ design)) * unit)
    value, sd = nothing.value.copy(), nothing.sd.copy()
    value[seen], sd[seen] = answer[: seen.sum()], spread[: seen.sum()]
    # A comb twice too fine has a valley where it wants its every second line, however
    # broad the lines are.
    smooth = ndimage.uniform_filter1d(mean, 3, mode="wrap").reshape(10, BINS)
    on_line = (smooth[:, 0] + np.roll(smooth[:, -1], 1)) / 2
    between = (smooth[:, BINS // 2 - 1] + smooth[:, BINS // 2]) / 2
    dark_lines = int(
        (on_line > (between + np.roll(between, 1)) / 2)[seen].sum() + 10 - seen.sum()
    )
    return Strengths(value, sd, dark_lines)


def _best_pattern(ratio: float, both: list[Strengths]) -> Pitch:
    """The pattern that fits the strengths of both families best, with a penalty for
    each class and each choice of the origin."""
    scores = {}
    for pattern, classes in _CLASSES.items():
        fits = [
            (
                min((_misfit(s, np.roll(classes, o)), o) for o in range(10))
                if s.complete
                else (0.0, s.heaviest)
            )
            for s in both
        ]
        choices = len({tuple(np.roll(classes, o)) for o in range(10)})
        price = 8 * max(classes) + 2 * np.log(choices)
        scores_of_families = [f[0] + price for f, s in zip(fits, both) if s.complete]
        scores[pattern] = (sum(scores_of_families), (fits[0][1], fits[1][1]))
    pattern = min(scores, key=lambda k: scores[k][0])
    apart, pattern_seen = _MEANING[pattern]
    shift = scores[pattern][1]
    return Pitch(
        ratio, apart[0] if len(apart) == 1 else None, apart, pattern_seen, shift
    )


def _misfit(strengths: Strengths, classes: np.ndarray) -> float:
    """χ² of the lines about the means of their classes; infinite where a higher class
    is not clearly stronger."""
    seen = np.isfinite(strengths.value)
    value, classes = strengths.value[seen], classes[seen]
    # A line drawn by a pen or printed on a raster varies by some 8 % of its kind.
    weight = 1 / (strengths.sd[seen] ** 2 + (0.08 * np.median(value)) ** 2)
    total, before = 0.0, -np.inf
    for kind in range(classes.max() + 1):
        members = classes == kind
        if not members.any():
            return np.inf
        mean = float(np.average(value[members], weights=weight[members]))
        if kind and mean < 1.15 * before:
            return np.inf
        total += float((weight[members] * (value[members] - mean) ** 2).sum())
        before = mean
    return total
