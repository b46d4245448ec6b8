"""Moving things in one frame: found on a coarse difference picture, measured on the full one, sub-pixel.

A silhouette is a coverage α between 0 and 1: 1 inside, 0 outside, and in the band along its edge (I − B)/(S − B), with B
the background and S the seed's own brightness just inside. Shading, highlights and graph paper thus do not pull the
centroid, and there is no pixel to lock on to.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from vision.motion.scene import Scene

MOVES_SD = 6.0  # a coarse pixel this many sds off the background moves; one in 5e8 by chance
FAINTEST = 0.03  # of the strongest difference in the frame: below it are codec errors and reflected light
MOST = 4  # things measured in a frame: seed, mirror image, shadow, clamp or hand
LARGEST = 0.10  # of the picture; beyond it is a hand, not a seed
BAND_PX = 1.7  # half width of the edge band for a sharp edge
FLOOR_PX = 0.008  # what the coverage model itself leaves, per axis


@dataclass(frozen=True)
class Silhouette:
    """One thing in one frame; x, y in pixels of the picture (x right, y DOWN from the centre of the top left pixel).

    xx, yy, xy: second moments about the centroid [px²]; contrast: signed, in grey levels. cut: it touches the picture's border.
    """

    x: float
    y: float
    sd: float
    area: float
    contrast: float
    xx: float
    yy: float
    xy: float
    angle_sd_deg: float
    cut: bool
    bottom: float


def find_silhouettes(pixels: np.ndarray, scene: Scene) -> list[Silhouette]:
    """What differs from the background in this frame, strongest first, at most MOST things."""
    difference, gain = scene.coarse_difference(pixels)
    size = np.abs(difference)
    threshold = max(MOVES_SD * scene.coarse_noise, 0.6, FAINTEST * float(size.max()))
    mask = (size > threshold).astype(np.uint8)
    if not mask.any():
        return []
    mask = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    count, labels, boxes, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    candidates = []
    for k in range(1, count):
        left, top, wide, high, area = boxes[k]
        if area < 2 or area > LARGEST * mask.size:
            continue
        here = labels[top : top + high, left : left + wide] == k
        candidates.append((float(size[top : top + high, left : left + wide][here].sum()), left, top, wide, high, here))
    candidates.sort(key=lambda c: -c[0])
    found: list[Silhouette | None] = []
    for strength, left, top, wide, high, here in candidates[:MOST]:
        if found and strength < 0.02 * candidates[0][0]:
            break
        found.append(_measure(pixels, scene, gain, left, top, wide, high, here))
    return [f for f in found if f is not None]


def _measure(pixels, scene: Scene, gain: float, left, top, wide, high, here) -> Silhouette | None:
    """Measure the thing whose coarse cells are `here`, in a window of the full picture around it."""
    f, (height, width) = scene.factor, scene.shape
    pad = 7 + f
    x0, y0 = max(int(left * f) - pad, 0), max(int(top * f) - pad, 0)
    x1, y1 = min(int((left + wide) * f) + pad, width), min(int((top + high) * f) + pad, height)
    image = scene.grey(pixels[y0:y1, x0:x1])
    ground = gain * scene.background[y0:y1, x0:x1]
    rough: np.ndarray = np.zeros(image.shape, np.uint8)
    cells = cv2.resize(here.astype(np.uint8), (wide * f, high * f), interpolation=cv2.INTER_NEAREST)
    oy, ox = int(top * f) - y0, int(left * f) - x0
    rough[oy : oy + high * f, ox : ox + wide * f] = cells[: rough.shape[0] - oy, : rough.shape[1] - ox]
    outline = _outline(image - ground, rough, scene.noise)
    if outline is None:
        return None
    mask, level = outline
    coverage, error = _coverage(image, ground, mask, level, scene)
    return _moments(coverage, error, mask, level, x0, y0, (height, width))


def _outline(difference: np.ndarray, rough: np.ndarray, noise: float) -> tuple[np.ndarray, float] | None:
    """Filled mask at about half contrast of the thing under `rough`, and its signed contrast."""
    smooth = cv2.GaussianBlur(difference, (0, 0), 1.0)
    inside = smooth[rough > 0]
    strong = inside[np.abs(inside) >= np.percentile(np.abs(inside), 60)]
    level = float(np.median(strong))
    # Of one sign: a dark shadow beside a light seed is another thing. Of both: a shaded seed before a grey wall.
    one_sided = (np.sign(strong) == np.sign(level)).mean() > 0.8
    signal = smooth * np.sign(level) if one_sided else np.abs(smooth)
    if not one_sided:
        level = float(np.sign(level) or 1.0) * float(np.median(np.abs(strong)))
    above = (signal > max(0.5 * abs(level), 4 * 0.29 * noise)).astype(np.uint8)
    count, labels = cv2.connectedComponents(above, connectivity=4)
    if count < 2:
        return None
    share = np.bincount(labels[(rough > 0) & (labels > 0)], minlength=count)
    if share.max() == 0:
        return None
    mask = (labels == int(np.argmax(share))).astype(np.uint8)
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    cv2.drawContours(mask, contours, -1, 1, cv2.FILLED)
    return mask, level


def _coverage(image, ground, mask, level: float, scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """α and its sd per pixel (0 where it is not measured but known)."""
    half = _band(image - ground, mask, level)
    depth = cv2.distanceTransform(mask, cv2.DIST_L2, 3)
    inner = (depth > half + 0.5).astype(np.uint8)
    outer = (cv2.distanceTransform(1 - mask, cv2.DIST_L2, 3) < half + 0.5).astype(np.uint8)
    if inner.sum() < 5:  # too small for an inside: what is brightest stands for it
        inner = ((np.abs(image - ground) * mask) > 0.8 * np.abs(level)).astype(np.uint8)
    band = (outer > 0) & (inner == 0)
    ring = (outer == 0) & (np.abs(image - ground) < 6 * scene.noise)
    if ring.sum() > 50:  # light that changed here only
        ground = ground * (float(image[ring].sum()) / max(float(ground[ring].sum()), 1e-6))
    own = _own_brightness(image, (inner > 0) & (depth < half + 3.5), half + 1.0, scene.noise, scene.white)
    contrast = own - ground
    poor = np.abs(contrast) < 0.3 * abs(level)
    alpha = np.clip((image - ground) / np.where(poor, np.float32(level), contrast), -0.35, 1.35)
    guess = cv2.GaussianBlur(mask.astype(np.float32), (0, 0), 0.8)
    alpha = np.where(poor, guess, alpha)
    coverage = np.where(band, alpha, inner.astype(np.float32))
    noise = scene.noise * np.sqrt(1.06 * scene.noise_spread)  # the background is a median of 25 frames, hence 6 %
    error = np.where(band, np.where(poor, 0.15, noise / np.maximum(np.abs(contrast), 1e-6)), 0.0)
    return coverage.astype(np.float64), error


def _own_brightness(image: np.ndarray, inner: np.ndarray, reach: float, noise: float, white: float) -> np.ndarray:
    """The seed's brightness carried outwards from its inside: a plane for the light's direction, the rest from nearby."""
    rows, columns = np.nonzero(inner)
    values = image[rows, columns].astype(float)
    if len(values) < 12:
        return np.full(image.shape, values.mean() if len(values) else 0.0)
    u, v = columns - columns.mean(), rows - rows.mean()
    uu, vv, uv, zu, zv = u @ u, v @ v, u @ v, u @ values, v @ values
    determinant = uu * vv - uv**2
    slope_u, slope_v = (
        ((zu * vv - zv * uv) / determinant, (zv * uu - zu * uv) / determinant) if determinant > 1e-6 else (0.0, 0.0)
    )
    if slope_u * zu + slope_v * zv < 18 * noise**2:  # light from a side that cannot be told from noise: leave it out
        slope_u = slope_v = 0.0
    plane = values.mean() + slope_u * (np.arange(image.shape[1]) - columns.mean())
    plane = (plane[None, :] + slope_v * (np.arange(image.shape[0]) - rows.mean())[:, None]).astype(np.float32)
    core = inner.astype(np.float32)
    weight = cv2.GaussianBlur(core, (0, 0), reach)
    rest = cv2.GaussianBlur((image - plane) * core, (0, 0), reach)
    return np.minimum(plane + np.where(weight > 1e-4, rest / np.maximum(weight, 1e-4), 0.0), white)


def _band(difference: np.ndarray, mask: np.ndarray, level: float) -> float:
    """Half width of the edge band: for a sharp edge BAND_PX, more where motion or focus blurs it.

    The pixels between 20 and 80 % coverage, per pixel of outline, measure the edge's softness.
    """
    share = cv2.GaussianBlur(difference, (0, 0), 0.7) / level
    near = cv2.dilate(mask, np.ones((15, 15), np.uint8)) > 0
    soft = float(((share > 0.2) & (share < 0.8) & near).sum())
    outline = float((mask - cv2.erode(mask, np.ones((3, 3), np.uint8), borderType=cv2.BORDER_CONSTANT)).sum())
    softness = soft / max(outline, 1.0)
    return BAND_PX + float(np.clip(0.9 * (softness - 1.6), 0.0, 12.0))


def _moments(coverage, error, mask, level: float, x0: int, y0: int, shape) -> Silhouette | None:
    """Centroid, second moments, and their sds from the pixels' own errors."""
    area = float(coverage.sum())
    if area < 4:
        return None
    rows, columns = coverage.shape
    u, v = np.arange(columns, dtype=float), np.arange(rows, dtype=float)
    across, down = coverage.sum(axis=0), coverage.sum(axis=1)
    x, y = float(across @ u / area), float(down @ v / area)
    du, dv = u - x, v - y
    xx, yy = float(across @ du**2 / area), float(down @ dv**2 / area)
    xy = float(dv @ coverage @ du / area)
    variance = error**2
    sd = np.sqrt((variance.sum(axis=0) @ du**2 + variance.sum(axis=1) @ dv**2) / 2) / area
    p, q = xx - yy, 2 * xy
    turn = (np.outer(dv, 2 * du) - q) * p - (du**2 - (dv**2)[:, None] - p) * q
    size = p**2 + q**2
    angle_sd = 0.5 * np.degrees(np.sqrt((variance * turn**2).sum()) / area / size) if size > 1e-9 else np.inf
    ys, xs = np.nonzero(mask.any(axis=1))[0], np.nonzero(mask.any(axis=0))[0]
    height, width = shape
    cut = bool(x0 + xs[0] <= 1 or y0 + ys[0] <= 1 or x0 + xs[-1] >= width - 2 or y0 + ys[-1] >= height - 2)
    bottom = y0 + float(ys[-1])
    return Silhouette(x0 + x, y0 + y, float(np.hypot(sd, FLOOR_PX)), area, level, xx, yy, xy, float(angle_sd), cut, bottom)
