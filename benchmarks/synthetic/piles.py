"""Draws pile photos of known angle, with noise, uneven light, walls, mirror images and
other options."""

from dataclasses import dataclass, replace

import cv2
import numpy as np
from scipy.ndimage import gaussian_filter1d

Tone = float | tuple[float, float, float]


@dataclass(frozen=True)
class PileScene:
    """What to draw. Lengths in px, tones 0–255 (a number, or RGB), the true angle
    against the drawn horizontal.

    sides: "two" (a heap), "right" (a wall on the left, slope falling to the right) or
    "left" (its mirror). grain_px = 0 gives a smooth surface; roughness_px adds a
    correlated Gaussian surface, grain_px > 0 draws round grains. rounding: length over
    which crest and toe are rounded, in units of the pile's height. roll_deg turns the
    whole scene clockwise in the picture, as a camera turned anticlockwise would."""

    angle_deg: float = 30.0
    angle_right_deg: float | None = None  # the heap's right flank, when it differs
    sides: str = "two"
    size: tuple[int, int] = (1200, 800)  # width, height of the picture
    pile_height: float = 300.0
    rounding: float = 0.0
    roll_deg: float = 0.0
    pile_tone: Tone = 200.0
    ground_tone: Tone = 40.0
    plate_tone: Tone | None = 90.0  # None: no plate in the picture
    wall_tone: Tone | None = None  # None: no wall
    wall_height: float = 1.3  # of the pile's height
    mirror: float = 0.0  # strength of the pile's image in the plate, 0–1
    strays: int = 0
    roughness_px: float = 0.0  # sd of the surface
    roughness_length_px: float = 8.0  # its correlation length (Gaussian)
    grain_px: float = 0.0
    noise: float = 0.0  # sd of the grey level, in shares of 255
    salt: float = 0.0  # fraction of pixels set to black or white
    light: float = 0.0  # 0.15: light falls by ±15 % across the picture
    light_direction_deg: float = 0.0
    blur_px: float = 0.8
    dtype: str = "uint8"


def draw_pile(scene: PileScene, rng: np.random.Generator) -> np.ndarray:
    """The picture of `scene`: (height, width) or (height, width, 3) when a tone is
    coloured, of scene.dtype."""
    u, v = _plate_coordinates(scene)
    colour = any(
        isinstance(t, tuple)
        for t in (scene.pile_tone, scene.ground_tone, scene.plate_tone, scene.wall_tone)
    )
    picture = np.broadcast_to(
        _tone(scene.ground_tone, colour), (*u.shape, 3 if colour else 1)
    ).astype(np.float32)
    profile = _surface(scene, rng)
    inside = _coverage(profile(u) - v)
    if scene.plate_tone is not None:
        picture = _lay(picture, _coverage(-v), _tone(scene.plate_tone, colour))
        if scene.mirror > 0:
            picture = _lay(
                picture,
                scene.mirror * _coverage(profile(u) + v) * (v < 0),
                _tone(scene.pile_tone, colour),
            )
    if scene.wall_tone is not None:
        picture = _lay(picture, _wall(scene, u, v), _tone(scene.wall_tone, colour))
    if scene.grain_px > 0:
        picture = _grains(scene, picture, rng, colour)
    else:
        picture = _lay(picture, inside * (v > -0.5), _tone(scene.pile_tone, colour))
    picture = _strays(scene, picture, rng, colour)
    return _expose(scene, picture, rng)


def base_line(scene: PileScene) -> tuple[float, float]:
    """The plate's line in the picture: y_px at x = 0 and its slope dy/dx (y down)."""
    (cx, cy), slope = _origin(scene), np.tan(np.radians(scene.roll_deg))
    return cy - slope * cx, slope


def _origin(scene: PileScene) -> tuple[float, float]:
    """Where the middle of the pile's foot stands in the picture."""
    width, height = scene.size
    return (width - 1) / 2, height - 1 - 0.5 * (height - scene.pile_height) * 0.8


def _plate_coordinates(scene: PileScene) -> tuple[np.ndarray, np.ndarray]:
    """u along the plate, v up from it, for every pixel."""
    width, height = scene.size
    (cx, cy), roll = _origin(scene), np.radians(scene.roll_deg)
    x, y = np.meshgrid(
        np.arange(width, dtype=np.float32) - cx,
        np.arange(height, dtype=np.float32) - cy,
    )
    return x * np.cos(roll) + y * np.sin(roll), x * np.sin(roll) - y * np.cos(roll)


def _to_picture(scene: PileScene, u, v) -> tuple[np.ndarray, np.ndarray]:
    (cx, cy), roll = _origin(scene), np.radians(scene.roll_deg)
    return cx + u * np.cos(roll) + v * np.sin(roll), cy + u * np.sin(roll) - v * np.cos(
        roll
    )


def _flanks(scene: PileScene) -> tuple[float, float, float]:
    """u of the crest, and the two slopes (tangents; inf at a wall)."""
    left = np.tan(np.radians(scene.angle_deg))
    right = np.tan(
        np.radians(
            scene.angle_right_deg
            if scene.angle_right_deg is not None
            else scene.angle_deg
        )
    )
    if scene.sides == "right":
        return -0.5 * scene.pile_height / right, np.inf, right
    if scene.sides == "left":
        return 0.5 * scene.pile_height / left, left, np.inf
    return 0.5 * scene.pile_height * (1 / left - 1 / right), left, right


def _surface(scene: PileScene, rng: np.random.Generator):
    """The height of the surface over u, as a function."""
    crest, left, right = _flanks(scene)
    height, soft = scene.pile_height, max(scene.rounding * scene.pile_height, 1e-9)
    half = 2 * max(scene.size)
    grid = np.arange(-half, half, dtype=float)
    rough = _rough(scene, rng, grid.size)

    def profile(u):
        tangent = np.where(u < crest, left, right)
        with np.errstate(invalid="ignore"):
            line = np.where(
                np.isinf(tangent),
                -1.0,
                height - np.abs(u - crest) * np.where(np.isinf(tangent), 0, tangent),
            )
        if (
            scene.rounding > 0
        ):  # soft minimum at the crest's plateau, soft maximum at the plate
            line = 0.93 * height - soft * np.logaddexp(0, (0.93 * height - line) / soft)
            line = np.where(line > -8 * soft, soft * np.logaddexp(0, line / soft), 0.0)
        bumps = np.interp(u, grid, rough) * np.clip(
            line / max(2 * scene.roughness_px, 1e-9), 0, 1
        )  # none on the bare plate
        return np.where((line > 1e-3) & np.isfinite(tangent), line + bumps, -1.0)

    return profile


def _rough(scene: PileScene, rng: np.random.Generator, n: int) -> np.ndarray:
    """A stationary Gaussian surface of sd roughness_px and correlation length
    roughness_length_px."""
    if scene.roughness_px <= 0:
        return np.zeros(n)
    smooth = gaussian_filter1d(
        rng.normal(size=n), scene.roughness_length_px / np.sqrt(2), mode="wrap"
    )
    return scene.roughness_px * smooth / smooth.std()


def _coverage(distance_px: np.ndarray) -> np.ndarray:
    """How much of a pixel lies inside, from the distance to the edge (positive
    inside)."""
    return np.clip(distance_px + 0.5, 0, 1)


def _tone(tone: Tone, colour: bool) -> np.ndarray:
    return np.broadcast_to(np.asarray(tone, dtype=np.float32), (3 if colour else 1,))


def _lay(picture: np.ndarray, coverage: np.ndarray, tone: np.ndarray) -> np.ndarray:
    return picture + coverage[..., None].astype(np.float32) * (tone - picture)


def _wall(scene: PileScene, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """A box wall behind the slope's upper end, 4 % of the picture thick."""
    crest, left, _ = _flanks(scene)
    thick = 0.04 * scene.size[0]
    side = -1 if np.isinf(left) else 1
    across = _coverage(side * (u - crest)) * _coverage(thick - side * (u - crest))
    return across * _coverage(scene.wall_height * scene.pile_height - v) * _coverage(v)


def _grains(
    scene: PileScene, picture: np.ndarray, rng: np.random.Generator, colour: bool
) -> np.ndarray:
    """The pile as round grains, each of its own brightness, over a darker inside; their
    tops reach the true surface."""
    smooth = _surface(replace(scene, roughness_px=0.0), rng)
    radius = scene.grain_px / 2
    crest, left, right = _flanks(scene)
    reach = scene.pile_height / min(t for t in (left, right) if np.isfinite(t))
    spacing = scene.grain_px * 0.8
    u = np.arange(crest - reach - radius, crest + reach + radius, spacing)
    v = np.arange(radius, scene.pile_height + radius, spacing * 0.87)
    uu, vv = np.meshgrid(u, v)
    uu = (
        uu
        + (np.arange(v.size)[:, None] % 2) * spacing / 2
        + rng.uniform(-0.25, 0.25, uu.shape) * spacing
    )
    vv = np.maximum(vv + rng.uniform(-0.25, 0.25, uu.shape) * spacing, radius)
    tangent = np.where(
        uu < crest,
        np.where(np.isinf(left), right, left),
        np.where(np.isinf(right), left, right),
    )
    inside = smooth(uu) - vv > radius / np.cos(
        np.arctan(tangent)
    )  # the disc touches the surface from below
    wall = (
        (uu - crest < radius)
        if np.isinf(left)
        else (crest - uu < radius)
        if np.isinf(right)
        else np.zeros_like(inside)
    )
    across, up = _plate_coordinates(scene)
    shaded = _coverage(smooth(across) - up - 1.5 * scene.grain_px) * (up > 0)
    canvas = np.ascontiguousarray(
        _lay(picture, shaded, 0.5 * _tone(scene.pile_tone, colour))
    )
    order = rng.permutation(int((inside & ~wall).sum()))
    x, y = _to_picture(scene, uu[inside & ~wall][order], vv[inside & ~wall][order])
    sizes = radius * rng.uniform(0.85, 1.0, x.size)
    bright = rng.uniform(0.85, 1.1, x.size)
    for shade, scale in ((0.75, 1.0), (1.0, 0.8)):  # a darker rim, a lighter face
        for xi, yi, ri, bi in zip(x, y, sizes, bright):
            tone = [
                float(t)
                for t in np.clip(_tone(scene.pile_tone, colour) * bi * shade, 0, 255)
            ]
            cv2.circle(
                canvas,
                (round(xi * 16), round(yi * 16)),
                round(ri * scale * 16),
                tone,
                -1,
                cv2.LINE_AA,
                4,
            )
    return canvas.reshape(picture.shape)


def _strays(
    scene: PileScene, picture: np.ndarray, rng: np.random.Generator, colour: bool
) -> np.ndarray:
    """Single seeds lying on the plate beside the pile."""
    if not scene.strays:
        return picture
    crest, left, right = _flanks(scene)
    ends = [
        s * scene.pile_height / t for s, t in ((-1, left), (1, right)) if np.isfinite(t)
    ]
    canvas = np.ascontiguousarray(picture)
    radius = max(scene.grain_px, 0.06 * scene.pile_height) / 2
    for _ in range(scene.strays):
        end = ends[rng.integers(len(ends))]
        u = crest + end + np.sign(end) * rng.uniform(1.2 * radius, 0.2 * scene.size[0])
        x, y = _to_picture(scene, u, radius)
        tone = [float(t) for t in _tone(scene.pile_tone, colour)]
        cv2.circle(
            canvas,
            (round(float(x) * 16), round(float(y) * 16)),
            round(radius * 16),
            tone,
            -1,
            cv2.LINE_AA,
            4,
        )
    return canvas.reshape(picture.shape)


def _expose(
    scene: PileScene, picture: np.ndarray, rng: np.random.Generator
) -> np.ndarray:
    """Light, lens, noise and quantisation."""
    if scene.light:
        height, width = picture.shape[:2]
        x, y = np.meshgrid(np.linspace(-1, 1, width), np.linspace(-1, 1, height))
        turn = np.radians(scene.light_direction_deg)
        picture = (
            picture
            * (1 + scene.light * (x * np.cos(turn) + y * np.sin(turn)))[..., None]
        )
    if scene.blur_px > 0:
        picture = cv2.GaussianBlur(picture, (0, 0), scene.blur_px).reshape(
            picture.shape
        )
    if scene.noise:
        picture = picture + rng.normal(0, 255 * scene.noise, picture.shape)
    if scene.salt:
        hit = rng.random(picture.shape[:2])
        picture = np.where(
            (hit < scene.salt)[..., None],
            np.where((hit < scene.salt / 2)[..., None], 0, 255),
            picture,
        )
    deep = np.iinfo(scene.dtype).max
    levels = np.clip(np.rint(picture * (deep / 255)), 0, deep).astype(scene.dtype)
    return levels[..., 0] if levels.shape[2] == 1 else levels
