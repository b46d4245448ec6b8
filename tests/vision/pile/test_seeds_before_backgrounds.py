"""Heaps of drawn seeds before cloth, wood, a horizon and clutter, drawn here by code of its own: each seed a shaded disc."""

import cv2
import numpy as np

from vision.pile.repose import PileOptions, measure_repose
from vision.recording import Camera

WIDTH, HEIGHT, FOOT, SEED = 900, 640, 470, 17.0  # px; SEED: a seed's diameter
BACKGROUNDS = ("plain", "cloth", "wood", "horizon", "clutter")


def behind(kind: str, rng: np.random.Generator) -> np.ndarray:
    """What stands behind the heap: (h, w, 3) float, 0–255."""
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH].astype(float)
    wall = np.full((HEIGHT, WIDTH, 3), (95.0, 120.0, 150.0))
    if kind == "cloth":
        check = ((x // 70 % 2) + (y // 70 % 2))[..., None]
        wall = (60 + 60 * check) * np.array([0.7, 0.9, 1.2]) * (1 + 0.12 * np.sin(x / 2.1) * np.sin(y / 2.1))[..., None]
    elif kind == "wood":
        streaks = cv2.GaussianBlur(rng.normal(size=(HEIGHT, WIDTH)), (0, 0), 60, sigmaY=2)
        wall = (110 * (1 + 1.8 * streaks / streaks.std() / 8))[..., None] * np.array([1.1, 0.8, 0.5])
    elif kind == "horizon":
        wall[FOOT - 70 :] = (170.0, 160.0, 150.0)  # the table's far edge, at half the heap's height
    elif kind == "clutter":
        for _ in range(14):
            a, b = rng.uniform(0, (WIDTH, FOOT - 20), 2), rng.uniform(40, 160, 2)
            cv2.rectangle(wall, a.astype(int).tolist(), (a + b).astype(int).tolist(), rng.uniform(20, 230, 3).tolist(), -1)
    return np.ascontiguousarray(wall)


def heap_of_seeds(
    kind: str, angle_deg: float, seed: int, half: bool = False, mirror: float = 0.0, centre: float = WIDTH / 2, roll_deg: float = 0.0
) -> np.ndarray:
    """A heap whose free surface, through the tops of its outermost seeds, is two straight lines at `angle_deg`."""
    rng = np.random.default_rng([seed, BACKGROUNDS.index(kind)])
    picture = behind(kind, rng)
    picture[FOOT:] = (185.0, 180.0, 172.0)
    slope, radius = np.tan(np.radians(angle_deg)), SEED / 2
    reach = 240.0
    drop = radius * (1 / np.cos(np.radians(angle_deg)) - 0.15)  # the seeds' tops lie on the line
    places = []
    for back in range(3):  # rows of seeds, those in front drawn last
        for row in range(40):
            z = radius + row * 0.82 * SEED
            wide = reach - (z + drop) / slope
            if wide < 0:
                break
            count = max(1, int(2 * wide / (0.92 * SEED)))
            at = np.linspace(-wide, wide, count) + rng.normal(0, 0.8, count)
            places += [(u, z - rng.uniform(0, 0.12 * SEED) * (back > 0)) for u in at if not half or u > 0]
    rng.shuffle(places)
    for u, z in places:
        body = np.array([205.0, 165.0, 95.0]) * rng.normal(1, 0.08)
        for sign, strength in ((1, 1.0), (-1, mirror)):
            spot = (int((centre + u) * 16), int((FOOT - sign * z) * 16))
            if strength:
                under = picture.copy() if strength < 1 else picture
                for share, tone in ((1.0, 0.45), (0.86, 0.8), (0.6, 1.0), (0.3, 1.15)):
                    lift = int(-16 * radius * 0.25 * (1 - share) * sign)
                    cv2.circle(under, (spot[0], spot[1] + lift), int(16 * radius * share), (tone * body).tolist(), -1, cv2.LINE_AA, 4)
                if strength < 1:
                    picture[FOOT:] = (1 - strength) * picture[FOOT:] + strength * under[FOOT:] if sign < 0 else picture[FOOT:]
    turn = cv2.getRotationMatrix2D((WIDTH / 2, HEIGHT / 2), -roll_deg, 1.0)
    picture = cv2.warpAffine(picture, turn, (WIDTH, HEIGHT), borderMode=cv2.BORDER_REPLICATE)
    picture = cv2.GaussianBlur(picture, (0, 0), 0.9) + rng.normal(0, 2, picture.shape)
    return np.clip(picture, 0, 255).astype(np.uint8)


def angle(image: np.ndarray, camera: Camera | None = None, **options):
    return measure_repose(image, camera, PileOptions(**options))
