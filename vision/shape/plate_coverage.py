"""Photo of a plate of seeds from above, filled by the plate → the share of it that
seeds cover."""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np
from skimage.filters import threshold_otsu

from benchtwin.bench.language import tr
from benchtwin.bench.section import COVERAGE_LIMITS
from benchtwin.vision.evidence.photo import read_photo
from benchtwin.vision.measurement import MeasurementError, require
from benchtwin.vision.overlay.canvas import Canvas
from benchtwin.vision.pile.surface import as_float
from benchtwin.vision.shape.silhouettes import LEAST_CONTRAST, discriminant

LARGEST_SIDE = 1500  # px of the reduced picture: seeds are tens of them wide
ROUNDS = 3  # of telling both levels by their colours
# shares of the step from board to seed between which their border lies: dark rims and
# shadows of the seeds themselves
FAINT, CLEAR = 0.25, 0.6
TILES = 4  # to either side: how evenly seeds lie
OBLIQUE = 0.007  # what seeds at the rim of a photo cover more, seen by 7° from the side


@dataclass(frozen=True, eq=False)
class Covered:
    """share of the picture that seeds cover, its sd, and where (h, w), bool, in
    `image`, the picture as it was reduced."""

    share: float
    sd: float
    seeds: np.ndarray
    image: np.ndarray

    def overlay(self) -> np.ndarray:
        """The picture with the borders of what was taken for seeds (uint8 RGB)."""
        canvas = Canvas(self.image)
        borders = cv2.findContours(
            self.seeds.astype(np.uint8), cv2.RETR_LIST, cv2.CHAIN_APPROX_SIMPLE
        )[0]
        for border in borders:
            canvas.polygon(border[:, 0].astype(float), (90, 220, 90), 1.0)
        said = tr("seeds cover {:.3f} ± {:.3f} of the plate", self.share, self.sd)
        canvas.legend([(said, (255, 255, 255))])
        return canvas.pixels


def measure_coverage(image: np.ndarray) -> Covered:
    """Share of a picture (h, w) or (h, w, 3), uint8 or uint16, that seeds of one layer
    cover, between which a board of another colour or brightness is seen.

    Two levels by Otsu's threshold along the direction of colour in which they stand
    apart most, from each channel and from colourfulness on; seeds are those of the two
    that have a middle: of their area more lies deeper than half of the greatest depth
    than of gaps between them. sd: where the border lies between both levels, and how
    evenly seeds lie. MeasurementError where no two levels stand apart, or no single
    layer covers as much."""
    step = max(1, int(np.ceil(max(image.shape[:2]) / LARGEST_SIDE)))
    size = image.shape[1] // step, image.shape[0] // step
    small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    pixels = as_float(cv2.GaussianBlur(small, (0, 0), 0.8))
    flat = pixels.reshape(-1, pixels.shape[2])
    tried = [_two_levels(flat, start) for start in (*flat.T, np.ptp(flat, axis=1))]
    within, levels = min(tried, key=lambda found: found[0])
    levels = levels.reshape(pixels.shape[:2])
    require(
        LEAST_CONTRAST * within <= 1,
        tr(
            "seeds do not stand out from the board between them: photograph the plate"
            " from above, with light from all sides, on a board of another colour"
        ),
    )
    seeds = levels > 0.5
    if _with_a_middle(~seeds) > _with_a_middle(seeds):
        levels = 1 - levels
        seeds = levels > 0.5
    share = float(seeds.mean())
    ends = [float((levels > level).mean()) for level in (FAINT, CLEAR)]
    tiles = [
        tile.mean()
        for rows in np.array_split(seeds, TILES)
        for tile in np.array_split(rows, TILES, axis=1)
    ]
    parts = (ends[0] - ends[1]) / 2, float(np.std(tiles)) / TILES, OBLIQUE
    least, most = COVERAGE_LIMITS
    require(
        least <= share <= most,
        tr(
            "seeds cover {:.2f} of the picture: one layer covers {:g} to {:g}; the"
            " plate must fill the picture",
            share,
            least,
            most,
        ),
    )
    return Covered(share, float(np.sqrt(np.sum(np.square(parts)))), seeds, small)


@lru_cache(maxsize=8)
def _of_file(file: Path, changed: int) -> Covered:
    return measure_coverage(read_photo(file))


def coverage_of(file: Path) -> Covered:
    """That of a photo; the same file is measured once."""
    try:
        return _of_file(file, file.stat().st_mtime_ns)
    except MeasurementError as error:
        raise MeasurementError(f"{file}: {error}") from error
    except OSError as error:
        raise MeasurementError(f"{file}: {error.strerror or error}") from error


def _two_levels(flat: np.ndarray, start: np.ndarray) -> tuple[float, np.ndarray]:
    """The colours (n, c) on a scale (n,) on which the two levels that they have are 0
    and 1, found from those of `start` (n,) on; and their sd within either."""
    levels = start
    for _ in range(ROUNDS):
        high = levels > threshold_otsu(levels)
        low = flat[~high].mean(axis=0)
        direction, _ = discriminant(flat[~high], flat[high], low)
        levels = (flat - low) @ direction
    return float(np.where(levels > 0.5, levels - 1, levels).std()), levels


def _with_a_middle(mask: np.ndarray) -> float:
    """Share of a mask that lies deeper in it than half of the greatest depth: a quarter
    of a disc, next to nothing of gaps between discs."""
    depth = cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 3)
    return float((depth > depth.max() / 2).sum() / max(mask.sum(), 1))
