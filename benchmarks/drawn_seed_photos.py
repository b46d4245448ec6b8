"""Photos of spread seeds drawn from analytic outlines, with their truth. Nothing of the
reader is used; a board is the page that is printed.

Outlines are polygons of 720 points; each pixel's cover is exact along its row and the
mean of 8 lines down its height. Lengths are mm in the plane of the paper; +x right, +y
down, as in the picture."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter

from benchtwin.vision.board.sheet import PX_PER_MM, SHEETS, draw_page

POINTS, ROWS = 720, 8
Array = np.ndarray


@dataclass(frozen=True)
class Scene:
    """What is drawn. Sizes [mm] are those of the family's outline before it is turned.

    groups: numbers of seeds that touch, an entry a cluster. distance_mm: of a camera
    above the middle of the picture (seeds are then ellipsoids of thickness_mm that lie
    on the paper); None: flat outlines seen squarely. shadow: darkness of the soft
    shadow beside each seed; texture: relative sd of blotches on seeds and ground; limb:
    how much darker a seed's rim is."""

    family: str
    groups: tuple[int, ...] = (1,) * 60
    length_mm: tuple[float, float] = (8.7, 0.45)  # mean, sd
    width_mm: tuple[float, float] = (6.8, 0.35)
    thickness_mm: tuple[float, float] = (6.0, 0.3)
    distance_mm: float | None = None
    mm_per_px: float = 0.1
    size_px: tuple[int, int] = (1600, 1200)
    seed_rgb: tuple[float, float, float] = (0.80, 0.66, 0.42)
    ground_rgb: tuple[float, float, float] = (0.10, 0.11, 0.13)
    shadow: float = 0.0
    texture: float = 0.03
    limb: float = 0.12
    light: float = 0.1
    blur_px: float = 1.0
    noise: float = 0.012
    board: str = ""  # size of the printed board's sheet, in the upper left corner


@dataclass(frozen=True)
class DrawnSeed:
    """outline_mm: its true outline seen from above (n, 2), where it lies; seen_mm: what
    the camera sees of it on the paper."""

    outline_mm: Array
    seen_mm: Array
    thickness_mm: float
    group: int
    kind: str = "whole"

    @property
    def sizes_mm(self) -> tuple[float, float]:
        return caliper(self.outline_mm)

    @property
    def centre_mm(self) -> Array:
        return self.outline_mm.mean(axis=0)


def superellipse(length: float, width: float, rng: np.random.Generator) -> Array:
    power = rng.uniform(2.2, 3.2)
    t = np.linspace(0, 2 * np.pi, POINTS, endpoint=False)
    c, s = np.cos(t), np.sin(t)
    return np.stack(
        [
            length / 2 * np.sign(c) * abs(c) ** (2 / power),
            width / 2 * np.sign(s) * abs(s) ** (2 / power),
        ],
        -1,
    )


def ellipse(length: float, width: float, rng: np.random.Generator) -> Array:
    t = np.linspace(0, 2 * np.pi, POINTS, endpoint=False)
    return np.stack([length / 2 * np.cos(t), width / 2 * np.sin(t)], -1)


def bean(length: float, width: float, rng: np.random.Generator) -> Array:
    """An ellipse bent along its length, with a shallow hollow on one side: a kidney."""
    x, y = ellipse(length, width, rng).T
    bend = rng.uniform(0.10, 0.16)
    return np.stack([x, y + bend * width * (2 * (2 * x / length) ** 2 - 1)], -1)


def wedge(length: float, width: float, rng: np.random.Generator) -> Array:
    """A maize kernel: broad and blunt at one end, narrow at the other."""
    taper = rng.uniform(0.25, 0.4)
    x, y = superellipse(length, width, rng).T
    return np.stack([x, y * (1 + taper * 2 * x / length)], -1)


FAMILIES: dict[str, Callable[[float, float, np.random.Generator], Array]] = {
    "ellipse": ellipse,
    "superellipse": superellipse,
    "bean": bean,
    "wedge": wedge,
}


def caliper(points: Array) -> tuple[float, float]:
    """Largest distance of two points, and least width between parallel jaws in 7200
    directions (within 1e-7 of itself)."""
    angle = np.linspace(0, np.pi, 7200, endpoint=False)
    width = np.ptp(points @ np.stack([np.cos(angle), np.sin(angle)]), axis=0)
    return float(width.max()), float(width.min())


def draw(scene: Scene, rng: np.random.Generator) -> tuple[Array, list[DrawnSeed]]:
    """The photo (h, w, 3), uint8 RGB, and its seeds. ValueError when they find no
    room."""
    seeds = place(scene, rng)
    return paint(scene, seeds, rng), seeds


def place(scene: Scene, rng: np.random.Generator) -> list[DrawnSeed]:
    wide, high = (n * scene.mm_per_px for n in scene.size_px)
    sheet = SHEETS[scene.board].page_mm[0] if scene.board else 0.0
    low, top = np.array([sheet + 4.0, 4.0]), np.array([wide - 2.0, high - 2.0])
    seeds: list[DrawnSeed] = []
    for group, count in enumerate(scene.groups):
        for _ in range(4000):
            cluster = _cluster(scene, rng.uniform(low, top), count, group, rng)
            points = np.concatenate([s.seen_mm for s in cluster])
            apart = all(
                _apart(a.seen_mm, b.seen_mm, 1.0) for a in cluster for b in seeds
            )
            if (points > low).all() and (points < top).all() and apart:
                seeds += cluster
                break
        else:
            raise ValueError(f"no room for {sum(scene.groups)} seeds")
    return seeds


def _cluster(
    scene: Scene, middle: Array, count: int, group: int, rng: np.random.Generator
) -> list[DrawnSeed]:
    cluster = [_one(scene, middle, group, rng)]
    while len(cluster) < count:
        first, direction = (
            cluster[int(rng.integers(len(cluster)))],
            rng.uniform(0, 2 * np.pi),
        )
        along = np.array([np.cos(direction), np.sin(direction)])
        state = rng.bit_generator.state  # the same seed at every distance that is tried
        near, far = 0.0, 3 * scene.length_mm[0]
        for _ in range(22):
            rng.bit_generator.state = state
            tried = _one(scene, first.centre_mm + (near + far) / 2 * along, group, rng)
            near, far = (
                (near, (near + far) / 2)
                if _apart(first.seen_mm, tried.seen_mm, 0.0)
                else ((near + far) / 2, far)
            )
        if all(_apart(tried.seen_mm, s.seen_mm, -0.02) for s in cluster):
            cluster.append(tried)
    return cluster


def _one(
    scene: Scene, middle: Array, group: int, rng: np.random.Generator
) -> DrawnSeed:
    length, width, thick = (
        m + s * rng.standard_normal()
        for m, s in (scene.length_mm, scene.width_mm, scene.thickness_mm)
    )
    width = min(width, 0.96 * length)
    turn = rng.uniform(0, 2 * np.pi)
    c, s = np.cos(turn), np.sin(turn)
    turned = np.array([[c, -s], [s, c]])
    outline = FAMILIES[scene.family](length, width, rng) @ turned.T + middle
    if scene.distance_mm is None:
        return DrawnSeed(outline, outline, thick, group)
    centre = np.array([n * scene.mm_per_px / 2 for n in scene.size_px])
    seen = (
        silhouette(length, width, thick, turned, middle - centre, scene.distance_mm)
        + centre
    )
    return DrawnSeed(outline, seen, thick, group)


def silhouette(
    length: float, width: float, thick: float, turned: Array, at: Array, distance: float
) -> Array:
    """Shadow on the paper of an ellipsoid that lies on it, of a light where the camera
    is: exact, by the dual conic."""
    half = np.diag([length, width, thick]) / 2
    turn = np.eye(3)
    turn[:2, :2] = turned
    middle = np.array([*at, thick / 2])
    dual = np.zeros((4, 4))
    dual[:3, :3] = turn @ half**2 @ turn.T - np.outer(middle, middle)
    dual[:3, 3] = dual[3, :3] = -middle
    dual[3, 3] = -1.0
    camera = np.array(
        [[distance, 0, 0, 0], [0, distance, 0, 0], [0, 0, -1, distance]], float
    )
    conic = camera @ dual @ camera.T
    centre = conic[:2, 2] / conic[2, 2]
    spread = np.outer(centre, centre) - conic[:2, :2] / conic[2, 2]
    t = np.linspace(0, 2 * np.pi, POINTS, endpoint=False)
    values, vectors = np.linalg.eigh(spread)
    return centre + np.stack([np.cos(t), np.sin(t)], -1) * np.sqrt(values) @ vectors.T


def inside(points: Array, polygon: Array) -> Array:
    """Which of points (n, 2) lie in the polygon, by counting crossings."""
    a, b = polygon, np.roll(polygon, -1, 0)
    x, y = points[:, :1], points[:, 1:]
    crosses = (a[:, 1] > y) != (b[:, 1] > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        at = a[:, 0] + (y - a[:, 1]) * (b[:, 0] - a[:, 0]) / (b[:, 1] - a[:, 1])
    return (crosses & (x < at)).sum(axis=1) % 2 == 1


def _apart(a: Array, b: Array, gap: float) -> bool:
    """Whether two outlines keep `gap` mm between them (every sixth point; negative:
    they may overlap by so much)."""
    ca, cb = a.mean(0), b.mean(0)
    reach = np.hypot(*(a - ca).T).max() + np.hypot(*(b - cb).T).max()
    if np.hypot(*(ca - cb)) > reach + gap:
        return True
    if gap > 0:
        away = a[::6, None] - b[None, ::6]
        return (
            bool(np.hypot(away[..., 0], away[..., 1]).min() > gap)
            and not inside(a[:1], b)[0]
            and not inside(b[:1], a)[0]
        )
    shrink = 1 + gap / np.hypot(*(b - cb).T).min()
    inner = cb + shrink * (b - cb)
    return not inside(a[::6], inner).any() and not inside(inner[::6], a).any()


def cover(
    polygon_px: Array, shape: tuple[int, int]
) -> tuple[Array, tuple[slice, slice]]:
    """Share of each pixel inside the polygon, in its bounding box, and where the box
    is. Pixel centres are integers."""
    low = np.maximum(np.floor(polygon_px.min(0)).astype(int) - 1, 0)
    high = np.minimum(np.ceil(polygon_px.max(0)).astype(int) + 2, [shape[1], shape[0]])
    wide, tall = np.maximum(high - low, 0)
    share = np.zeros((tall, wide))
    a, b = polygon_px, np.roll(polygon_px, -1, 0)
    left = np.arange(wide) + low[0] - 0.5
    for row in range(tall):
        for k in range(ROWS):
            y = low[1] + row - 0.5 + (k + 0.5) / ROWS
            hit = (a[:, 1] > y) != (b[:, 1] > y)
            at = np.sort(
                a[hit, 0]
                + (y - a[hit, 1]) * (b[hit, 0] - a[hit, 0]) / (b[hit, 1] - a[hit, 1])
            )
            for x0, x1 in zip(at[::2], at[1::2]):
                share[row] += np.clip(x1 - left, 0, 1) - np.clip(x0 - left, 0, 1)
    return share / ROWS, (slice(low[1], high[1]), slice(low[0], high[0]))


def paint(scene: Scene, seeds: list[DrawnSeed], rng: np.random.Generator) -> Array:
    wide, high = scene.size_px
    picture = np.ones((high, wide, 3)) * scene.ground_rgb
    picture *= 1 + scene.texture * _blotches((high, wide), 2.5, rng)[..., None]
    if scene.board:
        sheet = _sheet(scene)[:high]
        picture[: len(sheet), : sheet.shape[1]] = sheet
    covers = [cover(s.seen_mm / scene.mm_per_px - 0.5, (high, wide)) for s in seeds]
    if scene.shadow:
        shade = np.zeros((high, wide))
        for seed in seeds:
            moved = cover(
                (seed.seen_mm + 0.05 * seed.thickness_mm) / scene.mm_per_px - 0.5,
                (high, wide),
            )
            shade[moved[1]] = np.maximum(shade[moved[1]], moved[0])
        shade = gaussian_filter(shade, 0.6 / scene.mm_per_px)
        picture *= (1 - scene.shadow * shade)[..., None]
    blotch = _blotches((high, wide), 5.0, rng)
    for (share, box), seed in zip(covers, seeds):
        middle = seed.seen_mm.mean(0) / scene.mm_per_px - 0.5
        y, x = np.mgrid[box]
        reach = np.sqrt((seed.seen_mm.var(axis=0).sum()) * 1.0) / scene.mm_per_px
        rim = (
            np.clip(np.hypot(x - middle[0], y - middle[1]) / (1.45 * reach), 0, 1) ** 4
        )
        tint = np.array(scene.seed_rgb) * (0.55 if seed.kind == "husk" else 1.0)
        bright = (1 - scene.limb * rim) * (1 + scene.texture * 1.5 * blotch[box])
        picture[box] += share[..., None] * (bright[..., None] * tint - picture[box])
    picture *= (1 + scene.light * np.linspace(-0.5, 0.5, wide))[None, :, None]
    picture = gaussian_filter(picture, (scene.blur_px, scene.blur_px, 0))
    picture += scene.noise * rng.standard_normal(picture.shape)
    return np.clip(np.rint(255 * picture), 0, 255).astype(np.uint8)


def _blotches(
    shape: tuple[int, int], size_px: float, rng: np.random.Generator
) -> Array:
    noise = gaussian_filter(rng.standard_normal(shape), size_px)
    return noise / noise.std()


def _sheet(scene: Scene) -> Array:
    """The board's sheet, white paper and black ink; mm_per_px a multiple of that of the
    printed page."""
    page = np.asarray(draw_page(SHEETS[scene.board]).convert("L"), float) / 255
    step = round(PX_PER_MM * scene.mm_per_px)
    high, wide = (n // step for n in page.shape)
    cells = page[: high * step, : wide * step].reshape(high, step, wide, step)
    return (0.06 + 0.86 * cells.mean((1, 3)))[..., None] * [1.0, 0.99, 0.97]
