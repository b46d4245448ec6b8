"""Pictures of a printed board, drawn by code that shares nothing with its reader: a
pinhole camera with a lens, blur, uneven light, noise; part of the board may be covered.

    python benchmarks/drawn_board.py [--count 200] [--rng 1]

prints how well scale, pitch and roll are read from boards at 3 to 40 % of the picture's
width, pitched by -5 to 25°, turned by up to 20°, rolled by up to 4°, a third of them
half covered."""

import argparse
import time
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
import pandas as pd

from benchtwin.vision.board.sheet import PX_PER_MM, SHEETS, draw_page
from benchtwin.vision.board.view import read_board
from benchtwin.vision.measurement import MeasurementError

FINE = 2  # samples a pixel, each way


@dataclass(frozen=True)
class Shot:
    """One picture. pitch, yaw, roll: of the camera beside the board [deg]; place: of
    the board's middle in the picture, in shares of it."""

    sheet: str = "A5"
    size_px: tuple[int, int] = (1600, 1200)
    focal: float = 0.75  # over the diagonal
    distance_mm: float = 700.0
    pitch_deg: float = 0.0
    yaw_deg: float = 0.0
    roll_deg: float = 0.0
    place: tuple[float, float] = (0.3, 0.5)
    distortion: float = 0.0  # share at the corner
    blur_px: float = 0.8
    noise: float = 0.01
    covered: float = 0.0  # share of the board, from below
    print_scale: float = 1.0
    bend_mm: float = 0.0  # of the middle, across


def turned(shot: Shot) -> np.ndarray:
    """Camera axes (rows: right, down, forward) in the board's (right, up, towards the
    camera)."""
    a, b, c = np.radians([shot.pitch_deg, shot.yaw_deg, shot.roll_deg])
    straight = np.array([[1, 0, 0], [0, -1, 0], [0, 0, -1]], float)
    yaw = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    pitch = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    roll = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    return roll @ pitch @ straight @ yaw


def truth(shot: Shot) -> dict[str, float]:
    """What the reader is asked for."""
    axes, place, f = turned(shot), _place(shot), _focal_px(shot)
    down, forward = -axes[:, 1], np.array([0.0, 0.0, 1.0])
    planes = axes[:, 2], forward - (forward @ down) * down
    depths = [(normal @ place) / (normal @ forward) for normal in planes]
    return {
        "mm_per_px": np.mean(depths) / f,
        "pitch": np.degrees(np.arcsin(down[2])),
        "plumb": np.degrees(np.arctan2(-down[0], down[1])),
        "distance_mm": place[2],
    }


def _focal_px(shot: Shot) -> float:
    return shot.focal * float(np.hypot(*shot.size_px))


def _place(shot: Shot) -> np.ndarray:
    """The board's middle before the camera [mm]."""
    offset = (np.array(shot.place) - 0.5) * shot.size_px / _focal_px(shot)
    return shot.distance_mm * np.array([*offset, 1.0])


@lru_cache
def page_of(sheet: str) -> np.ndarray:
    """The page (n, m) in grey, at a quarter of its resolution."""
    whole = np.asarray(draw_page(SHEETS[sheet]).convert("L"), np.float32)
    return cv2.resize(whole, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)


def draw(shot: Shot, rng: np.random.Generator) -> np.ndarray:
    """The picture, uint8 RGB."""
    width, height = shot.size_px
    sheet = SHEETS[shot.sheet]
    page, fine = page_of(shot.sheet), PX_PER_MM / 4
    axes, place = turned(shot), _place(shot)
    across = (np.arange(width * FINE) + 0.5) / FINE - 0.5
    downward = (np.arange(height * FINE) + 0.5) / FINE - 0.5
    x, y = np.meshgrid(across - (width - 1) / 2, downward - (height - 1) / 2)
    half = np.hypot(width, height) / 2
    u, v = x / half, y / half
    straight = np.ones_like(u)
    for _ in range(6 if shot.distortion else 0):
        straight = 1 + shot.distortion * (u * u + v * v) / straight**2
    rays = np.stack([x / straight, y / straight, np.full_like(x, _focal_px(shot))])
    along = np.tensordot(axes.T, rays, 1)
    origin = axes.T @ place
    hit_z = np.zeros_like(x)
    for _ in range(4 if shot.bend_mm else 1):
        scale = (origin[2] + hit_z) / along[2]
        bx, by = along[0] * scale - origin[0], along[1] * scale - origin[1]
        wide = sheet.size_mm[0] / 2
        hit_z = shot.bend_mm * ((bx / wide) ** 2 - 1) * (np.abs(bx) < 2 * wide)
    bx, by = bx / shot.print_scale, by / shot.print_scale
    # middle of the chessboard on the page
    middle_x = sheet.page_mm[0] / 2
    middle_y = 6.0 + sheet.size_mm[1] / 2
    px, py = (bx + middle_x) * fine - 0.5, (middle_y - by) * fine - 0.5
    grey = cv2.remap(
        page,
        px.astype(np.float32),
        py.astype(np.float32),
        cv2.INTER_LINEAR,
        borderValue=90,
    )
    covered = by < (shot.covered - 0.5) * sheet.size_mm[1]
    grey[covered] = 120
    grey = cv2.resize(grey, (width, height), interpolation=cv2.INTER_AREA) / 255
    light = 0.15 + 0.7 * grey * (1 + 0.2 * (np.linspace(-1, 1, width)[None]))
    seen = cv2.GaussianBlur(light, (0, 0), max(shot.blur_px, 0.1))
    seen = seen[..., None] + shot.noise * rng.normal(size=(height, width, 3))
    return (255 * seen.clip(0, 1)).astype(np.uint8)


def some(rng: np.random.Generator) -> Shot:
    """A shot as people take them."""
    sheet = rng.choice(["A4", "A5", "A6"])
    width = SHEETS[sheet].size_mm[0]
    focal, share = rng.uniform(0.6, 1.4), rng.uniform(0.12, 0.35)
    size = [(1600, 1200), (1920, 1080), (2400, 1800)][rng.integers(3)]
    distance = width * focal * np.hypot(*size) / (share * size[0])
    return Shot(
        sheet=str(sheet),
        size_px=size,
        focal=focal,
        distance_mm=distance,
        pitch_deg=rng.uniform(-5, 25),
        yaw_deg=rng.uniform(-20, 20),
        roll_deg=rng.uniform(-4, 4),
        place=(rng.uniform(0.25, 0.75), rng.uniform(0.4, 0.6)),
        distortion=rng.uniform(-0.03, 0.03),
        blur_px=rng.uniform(0.5, 2.0),
        noise=rng.uniform(0.005, 0.03),
        covered=0.5 * (rng.random() < 1 / 3),
        bend_mm=rng.normal(0, 0.003 * width),
    )


def main() -> None:
    """Print a table of errors."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--rng", type=int, default=1)
    asked = parser.parse_args()
    rng = np.random.default_rng(asked.rng)
    rows: list[dict[str, float | str]] = []
    for _ in range(asked.count):
        shot = some(rng)
        picture, right = draw(shot, rng), truth(shot)
        began = time.process_time()
        try:
            view = read_board(picture)
        except MeasurementError as error:
            rows.append({"read": 0.0, "why": str(error)})
            continue
        row: dict[str, float | str] = {
            "read": 1.0,
            "seconds": time.process_time() - began,
        }
        scale, _ = view.mm_per_px()
        _, fit_sd = view.scale_of_fit()
        row["scale_pct"] = 100 * (scale / right["mm_per_px"] - 1)
        row["scale_z"] = (scale - right["mm_per_px"]) / fit_sd
        for name, (value, sd) in view.attitude_deg().items():
            if name in right:
                row[f"{name}_deg"] = value - right[name]
                row[f"{name}_z"] = (value - right[name]) / sd
        far, far_sd = view.distance_mm()
        row["distance_pct"] = 100 * (far / right["distance_mm"] - 1)
        row["distance_z"] = (far - right["distance_mm"]) / far_sd
        row["doubted"] = float(bool(view.doubts))
        rows.append(row)
    table = pd.DataFrame(rows)
    trusted = table[table["doubted"] == 0]
    print(f"{len(table)} drawn, {len(trusted)} read without a doubt; of these:")
    numbers = trusted.drop(columns=["read", "doubted"]).select_dtypes("number")
    print(
        numbers.describe(percentiles=[0.01, 0.05, 0.5, 0.95, 0.99]).T.to_string(
            float_format="%.3f"
        )
    )
    for name in ("scale_z", "pitch_z", "plumb_z", "distance_z"):
        print(name, "within 1.96:", f"{(trusted[name].abs() < 1.96).mean():.3f}")


if __name__ == "__main__":
    main()
