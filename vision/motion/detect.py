"""Moving things in one frame: detected on a coarse difference picture, measured
sub-pixel on the full one.

A silhouette is a coverage α: 1 inside, 0 outside, and in the band along its edge (I −
B)/(S − B), with B the background and S the seed's own brightness just inside. So
shading, highlights and graph paper do not bias the centroid, nor does the pixel grid.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from benchtwin.vision.motion.scene import (
    LEAST_SHADE,
    Scene,
    colours,
    dot,
    in_sds,
    weighted_product,
)

# off the background, at which a coarse pixel moves; one in 5e8 by chance
MOVES_SD = 6.0
# of the strongest difference in the frame: below it are codec errors and reflected
# light
FAINTEST = 0.03
MOST = 4  # things measured in a frame: seed, mirror image, shadow, clamp or hand
LEAST_POWER = 0.02  # of the strongest of them
LARGEST = 0.10  # of the picture: larger things are hands
# pixels between 20 and 80 % coverage per pixel of a sharp outline, in a picture
# smoothed by a pixel
SHARP = 2.1
BAND_PX = 1.7  # half width of the edge band for a sharp edge
FLOOR_PX = 0.008  # error of the coverage model, per axis
SHADOW = 0.10  # sd of the share of the background's brightness that a shadow removes
# relative brightness over the background within which a thing could be a shadow or its
# edge
LIKE_SHADOW = (
    -0.5,
    0.25,
)
# off every shadow of the background, at which colour separates a thing from them
CLEAR_SD = 6.0
SHADE_PX = 3.0  # over which the illumination changes


@dataclass(frozen=True)
class Patch:
    """Coverage of the pixels about one thing, (h, w), and its sd (infinite where it is
    unknown); x0, y0: column and row of the first."""

    coverage: np.ndarray
    error: np.ndarray
    x0: int
    y0: int


@dataclass(frozen=True)
class Silhouette:
    """One thing in one frame; x, y in px (x right, y DOWN from the centre of the top
    left pixel), sd of each.

    area [px]; xx, yy, xy: second moments about the centroid [px²]. colour,
    background_sds (c,): its colour and the background's, in sds of the noise; contrast:
    their distance, in which a change that a shadow makes has little weight. cut: it
    touches the picture's border. patch: the pixels about it."""

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
    colour: np.ndarray
    background_sds: np.ndarray
    patch: Patch

    def colour_distance(self, other: "Silhouette") -> float:
        """Distance of its colour from another's, as a share of the greater contrast."""
        off = self.colour - other.colour
        apart = weighted_product(
            off, off, (self.background_sds + other.background_sds) / 2, SHADOW
        )
        return float(np.sqrt(apart)) / max(self.contrast, other.contrast)


def find_silhouettes(pixels: np.ndarray, scene: Scene) -> list[Silhouette]:
    """At most MOST things that differ from the background in this frame, strongest
    first."""
    shift, background_sds, light = scene.coarse_difference(pixels)
    size = np.sqrt(dot(shift, shift))
    threshold = max(MOVES_SD, FAINTEST * float(size.max()))
    mask = (size > threshold).astype(np.uint8)
    if not mask.any():
        return []
    mask = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    _, labels, boxes, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    strength = np.sqrt(
        np.maximum(weighted_product(shift, shift, background_sds, SHADOW), 0)
    )
    candidates = []
    area = boxes[1:, cv2.CC_STAT_AREA]  # of all but the background
    for k in 1 + np.flatnonzero((area >= 2) & (area <= LARGEST * mask.size)):
        left, top, wide, high, _ = boxes[k]
        at = np.s_[top : top + high, left : left + wide]
        here = labels[at] == k
        power, gain = float(strength[at][here].sum()), float(light[at].mean())
        candidates.append((power, gain, left, top, wide, high, here))
    candidates = sorted(candidates, key=lambda c: -c[0])[:MOST]
    found = (
        _measure(pixels, scene, *thing)
        for power, *thing in candidates
        if power >= LEAST_POWER * candidates[0][0]
    )
    return [f for f in found if f is not None]


def _measure(
    pixels, scene: Scene, gain: float, left, top, wide, high, here
) -> Silhouette | None:
    """Measure the thing whose coarse cells are `here`, in a window of the full picture
    around it."""
    f, (height, width) = scene.factor, scene.shape
    pad = 7 + f
    x0, y0 = max(int(left * f) - pad, 0), max(int(top * f) - pad, 0)
    x1 = min(int((left + wide) * f) + pad, width)
    y1 = min(int((top + high) * f) + pad, height)
    image = colours(pixels[y0:y1, x0:x1])
    background = gain * scene.background[y0:y1, x0:x1]
    rough: np.ndarray = np.zeros(image.shape[:2], np.uint8)
    cells = cv2.resize(
        here.astype(np.uint8), (wide * f, high * f), interpolation=cv2.INTER_NEAREST
    )
    oy, ox = int(top * f) - y0, int(left * f) - x0
    rough[oy : oy + high * f, ox : ox + wide * f] = cells[
        : rough.shape[0] - oy, : rough.shape[1] - ox
    ]
    outline = _outline(image, background, rough, scene)
    if outline is None:
        return None
    coverage, error, patch = _coverage(image, background, outline, scene)
    return _moments(coverage, error, outline, Patch(*patch, x0, y0), (height, width))


@dataclass(frozen=True)
class _Outline:
    """mask (h, w): filled, at about half coverage; share (h, w): approximate coverage;
    level: median difference from the background."""

    mask: np.ndarray
    share: np.ndarray
    level: float
    contrast: float
    colour: np.ndarray
    background_sds: np.ndarray


def _outline(
    image: np.ndarray, background: np.ndarray, rough: np.ndarray, scene: Scene
) -> _Outline | None:
    """The thing under `rough`: where the colour is nearer to the thing's than to the
    background's; None where there is none."""
    smooth = np.atleast_3d(
        in_sds(cv2.GaussianBlur(image - background, (0, 0), 1.0), scene.matrix)
    )
    background_sds = np.atleast_3d(in_sds(background, scene.matrix))
    shade, inside = SHADOW, rough > 0
    strength = np.sqrt(
        np.maximum(weighted_product(smooth, smooth, background_sds, shade), 0)
    )
    strong = inside & (strength >= np.percentile(strength[inside], 60))
    brighter = (
        dot(smooth, background_sds)[strong]
        / dot(background_sds, background_sds)[strong]
    )
    if (
        np.percentile(strength[inside], 80) < CLEAR_SD
        or not LIKE_SHADOW[0] < np.median(brighter) < LIKE_SHADOW[1]
    ):
        # colour does not separate it from a shadow, or brightness alone does
        shade = 0.0
        strength = np.sqrt(weighted_product(smooth, smooth, background_sds, shade))
        strong = inside & (strength >= np.percentile(strength[inside], 60))
    level = float(np.median(strength[strong]))
    colour = np.median((smooth + background_sds)[strong], axis=0)
    back = background_sds[strong].mean(axis=0)
    off = colour - background_sds
    power = weighted_product(off, off, background_sds, shade)
    along = weighted_product(smooth, off, background_sds, shade)
    # of one colour: a dark shadow beside a light seed is not included
    if (along[strong] > 0).mean() > 0.8:
        share = along / np.maximum(power, (0.3 * level) ** 2)
        above = (share > 0.5) & (along > 4 * 0.29 * np.sqrt(np.maximum(power, 1e-9)))
    else:  # lighter and darker than the background: a shaded seed before a grey wall
        share = strength / level
        above = (share > 0.5) & (strength > 4 * 0.29)
    count, labels = cv2.connectedComponents(above.astype(np.uint8), connectivity=4)
    held = np.bincount(labels[(rough > 0) & (labels > 0)], minlength=count)
    if held.max() == 0:
        return None
    mask = (labels == int(np.argmax(held))).astype(np.uint8)
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    cv2.drawContours(mask, contours, -1, 1, cv2.FILLED)
    free = weighted_product(colour - back, colour - back, back, SHADOW)
    return _Outline(mask, share, level, float(np.sqrt(free)), colour, back)


def _coverage(
    image: np.ndarray, background: np.ndarray, outline: _Outline, scene: Scene
) -> tuple[np.ndarray, np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """α of each pixel and its sd (0 where α is known), and both by the pixel alone (sd
    infinite where it shows nothing)."""
    mask = outline.mask
    half = _band(outline.share, mask)
    depth = cv2.distanceTransform(mask, cv2.DIST_L2, 3)
    inner = (depth > half + 0.5).astype(np.uint8)
    outer = (cv2.distanceTransform(1 - mask, cv2.DIST_L2, 3) < half + 0.5).astype(
        np.uint8
    )
    if inner.sum() < 5:  # too small for an inside: use what differs most
        inner = (outline.share * mask > 0.8).astype(np.uint8)
    band = (outer > 0) & (inner == 0)
    background = _shaded(image, background, outer == 0, scene)
    noise = float(1 / scene.matrix[0, 0] / np.sqrt(len(scene.matrix)))
    inside, depth_px = (inner > 0) & (depth < half + 3.5), half + 1.0
    colour = _own_colour(image, inside, depth_px, noise, scene.white)
    shift, background_sds, off = (
        np.atleast_3d(in_sds(v, scene.matrix))
        for v in (image - background, background, colour - background)
    )
    power = weighted_product(off, off, background_sds, LEAST_SHADE)
    poor = power < (0.3 * outline.level) ** 2
    share = weighted_product(shift, off, background_sds, LEAST_SHADE)
    alpha = np.clip(share / np.maximum(power, 1e-9), -0.35, 1.35)
    # the background is a median of 25 frames
    noise_share = np.sqrt(1.06 * scene.noise_spread) / np.sqrt(np.maximum(power, 1e-9))
    by_pixel = (
        alpha.astype(np.float16),
        np.where(poor, np.inf, noise_share).astype(np.float16),
    )
    guess = cv2.GaussianBlur(mask.astype(np.float32), (0, 0), 0.8)
    alpha = np.where(poor, guess, alpha)
    coverage = np.where(band, alpha, inner.astype(np.float32))
    error = np.where(band, np.where(poor, 0.15, noise_share), 0.0)
    return coverage.astype(np.float64), error, by_pixel


def _shaded(
    image: np.ndarray, background: np.ndarray, outside: np.ndarray, scene: Scene
) -> np.ndarray:
    """The background under this frame's illumination, extrapolated from the pixels
    outside to the thing's edge."""
    light = dot(image, background) / np.maximum(dot(background, background), 1e-6)
    off = np.atleast_3d(in_sds(image - light[..., None] * background, scene.matrix))
    lit = outside & (dot(off, off) < 16 + 20) & (light > 0.3) & (light < 1.3)
    if lit.sum() < 50:
        return background
    typical = float(np.median(light[lit]))
    weight = cv2.GaussianBlur(lit.astype(np.float32), (0, 0), SHADE_PX)
    local = cv2.GaussianBlur(
        np.where(lit, light - typical, 0).astype(np.float32), (0, 0), SHADE_PX
    ) / np.maximum(weight, 1e-3)
    clear = (np.abs(local) > LEAST_SHADE) & (weight > 0.02)
    return background * (typical + np.where(clear, local, 0.0))[..., None].astype(
        np.float32
    )


def _own_colour(
    image: np.ndarray, inner: np.ndarray, reach: float, noise: float, white: float
) -> np.ndarray:
    """The seed's colour extrapolated from its inside: a plane a channel for the light's
    direction, plus the local mean of the rest."""
    rows, columns = np.nonzero(inner)
    values = image[rows, columns].astype(float)
    if len(values) < 12:
        mean = values.mean(axis=0) if len(values) else np.zeros(image.shape[2])
        return np.broadcast_to(mean, image.shape)
    places = np.stack([columns - columns.mean(), rows - rows.mean()])
    along = places @ values
    slope = np.linalg.pinv(places @ places.T) @ along
    slope *= (slope * along).sum(axis=0) >= 18 * noise**2  # else within the noise
    across = np.arange(image.shape[1]) - columns.mean()
    down = np.arange(image.shape[0]) - rows.mean()
    plane = (values.mean(axis=0) + np.outer(across, slope[0])).astype(np.float32)
    plane = plane + np.outer(down, slope[1]).astype(np.float32)[:, None]
    core = inner.astype(np.float32)
    weight = cv2.GaussianBlur(core, (0, 0), reach)[..., None]
    rest = np.atleast_3d(
        cv2.GaussianBlur((image - plane) * core[..., None], (0, 0), reach)
    )
    local = np.where(weight > 1e-4, rest / np.maximum(weight, 1e-4), 0.0)
    return np.minimum(plane + local, white)


def _band(share: np.ndarray, mask: np.ndarray) -> float:
    """Half width of the edge band: BAND_PX for a sharp edge, more where motion or focus
    blurs it. Blur is measured by the number of pixels between 20 and 80 % coverage, per
    pixel of outline."""
    near = cv2.dilate(mask, np.ones((15, 15), np.uint8)) > 0
    soft = float(((share > 0.2) & (share < 0.8) & near).sum())
    square, kept = np.ones((3, 3), np.uint8), cv2.BORDER_CONSTANT
    outline = float((mask - cv2.erode(mask, square, borderType=kept)).sum())
    softness = soft / max(outline, 1.0)
    return BAND_PX + float(np.clip(0.9 * (softness - SHARP), 0.0, 12.0))


def _moments(
    coverage, error, outline: _Outline, patch: Patch, shape
) -> Silhouette | None:
    """Centroid, second moments, and their sds by error propagation from the pixels;
    None below 4 px."""
    moments = cv2.moments(coverage)
    area = moments["m00"]
    if area < 4:
        return None
    order = ("m10", "m01", "mu20", "mu02", "mu11")
    x, y, xx, yy, xy = (moments[k] / area for k in order)
    du, dv = (np.arange(n) - at for n, at in zip(coverage.shape[::-1], (x, y)))
    variance = error**2
    sd = (
        np.sqrt((variance.sum(axis=0) @ du**2 + variance.sum(axis=1) @ dv**2) / 2)
        / area
    )
    p, q = xx - yy, 2 * xy
    turn = (np.outer(dv, 2 * du) - q) * p - (du**2 - (dv**2)[:, None] - p) * q
    size = p**2 + q**2
    power = np.sqrt((variance * turn**2).sum())
    angle_sd = 0.5 * np.degrees(power / area / size) if size > 1e-9 else np.inf
    left, top, wide, high = cv2.boundingRect(outline.mask)
    left, top = left + patch.x0, top + patch.y0
    inside = left + wide < shape[1] - 1 and top + high < shape[0] - 1
    return Silhouette(
        patch.x0 + x,
        patch.y0 + y,
        float(np.hypot(sd, FLOOR_PX)),
        area,
        outline.contrast,
        xx,
        yy,
        xy,
        float(angle_sd),
        not (min(left, top) > 1 and inside),
        outline.colour,
        outline.background_sds,
        patch,
    )
