"""Heaps drawn for tests: outlines from arcs, hyperbolas and discs; nothing here knows
how a diagnosis describes them.

A heap stands on a plate: flanks at the angle of repose to gravity, crest rounded by an
arc or a hyperbola, an apron at the toe, and a surface of round grains (the upper rim of
discs) or a rough line. Then a camera: rolled, with a stated plumb."""

from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from scipy.ndimage import gaussian_filter1d

from benchtwin.rigs.pile.read import SeenPile

PX_MM = 0.2


@dataclass(frozen=True)
class Heap:
    """One material on one bench. crest, toe: how much is cut off the top, and how high
    the apron is at the flank's foot, over the height; bow: sagitta; break_: sagitta of
    a kink half way; steep: how much the upper quarter stands above the flank's line;
    tilt_deg of the plate and roll_deg of the picture, clockwise."""

    two: bool = True
    angle_deg: float = 28.0
    height_mm: float = 60.0
    crest: float = 0.05
    toe: float = 0.03
    round_by: str = "arc"
    bow: float = 0.0
    break_: float = 0.0
    steep: float = 0.0
    grain_mm: float = 4.0
    discs: bool = True
    tilt_deg: float = 0.0
    roll_deg: float = 0.0
    angle_sd_deg: float = 0.7
    plumb: bool = True
    plumb_sd_deg: float = 0.1
    plate: bool = True
    scale: bool = True


def clean_bench(rng: np.random.Generator) -> Heap:
    """A bench with everything that may differ between sound ones drawn at random; its
    camera within what it states."""
    plumb_sd = rng.choice([0.05, 0.2, 0.5])
    return Heap(
        two=bool(rng.random() < 0.6),
        angle_deg=rng.uniform(18, 38),
        height_mm=rng.uniform(40, 120),
        crest=rng.uniform(0, 0.1),
        toe=rng.uniform(0.0, 0.1),
        round_by=str(rng.choice(["arc", "hyperbola"])),
        grain_mm=rng.uniform(1.5, 6.0),
        discs=bool(rng.random() < 0.5),
        tilt_deg=0.1 * rng.normal(),
        roll_deg=plumb_sd * rng.normal(),
        angle_sd_deg=rng.uniform(0.2, 1.2),
        plumb=bool(rng.random() < 0.7),
        plumb_sd_deg=plumb_sd,
        plate=bool(rng.random() < 0.8),
        scale=bool(rng.random() < 0.7),
    )


def outline(h: Heap, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """x [mm] along gravity's horizontal and height [mm] above the plate's line."""
    left, right = np.tan(np.radians(h.angle_deg + h.angle_sd_deg * rng.normal(size=2)))
    lean = np.tan(np.radians(h.tilt_deg))  # the plate falls to the right
    reach = 1.8 * h.height_mm / min(left, right)
    x = np.arange(-reach if h.two else 0.0, reach, PX_MM / 2)
    cut = h.crest * h.height_mm * rng.uniform(0.8, 1.2)
    slope = np.where(x < 0, left, right)
    away = np.abs(x)
    if h.round_by == "hyperbola":
        width = cut / np.sqrt(left * right) if cut > 0 else 1e-9
        z = h.height_mm - slope * np.sqrt(away**2 + width**2)
    else:  # a circle that touches the flank
        angle = np.arctan(slope)
        radius = cut / (1 / np.cos(angle) - 1)
        inside = away < radius * np.sin(angle)
        cap = (
            h.height_mm
            - radius / np.cos(angle)
            + np.sqrt(np.maximum(radius**2 - away**2, 0))
        )
        z = np.where(inside, cap, h.height_mm - slope * away)
    share = np.clip(away * slope / h.height_mm, 0, 1)
    z = z + h.height_mm * (
        h.bow * 4 * share * (1 - share) + h.break_ * 2 * np.minimum(share, 1 - share)
    )
    z = z + h.height_mm * h.steep * np.maximum(1 - share / 0.25, 0.0)
    z = z + lean * x
    apron = 2 * h.toe * h.height_mm * rng.uniform(0.8, 1.2)
    z = (
        np.where(z > 0, z, 0.0)
        if apron < 1e-6
        else 0.5 * (z + np.sqrt(z**2 + apron**2)) - apron**2 / (4 * h.height_mm)
    )
    z = np.maximum(z, 0.0)
    return x, np.where(z > 0.02 * h.height_mm, _grained(h, x, z, rng), 0.0)


def _grained(
    h: Heap, x: np.ndarray, z: np.ndarray, rng: np.random.Generator
) -> np.ndarray:
    """The rim of discs that lie under the line about as deep as they are large, or the
    line roughened by a third of a grain."""
    radius = h.grain_mm / 2
    if not h.discs:
        rough = gaussian_filter1d(rng.normal(size=len(x)), h.grain_mm / 2 / (PX_MM / 2))
        return np.maximum(z + 0.12 * h.grain_mm * rough / rough.std(), 0.0)
    out = np.zeros(len(x))
    at = x[0]
    while at < x[-1]:
        at += h.grain_mm * rng.uniform(0.5, 1.1)
        top = np.interp(at, x, z)
        if top <= 0.02 * h.height_mm:
            continue
        low, high = np.searchsorted(x, [at - radius, at + radius])
        centre = top - radius + 0.2 * h.grain_mm * rng.normal()
        rim = centre + np.sqrt(np.maximum(radius**2 - (x[low:high] - at) ** 2, 0.0))
        out[low:high] = np.maximum(out[low:high], rim)
    return np.maximum(out, 0.8 * z - 0.3 * radius)


def picture(
    h: Heap, rng: np.random.Generator, name: str = "heap-01", **stated
) -> SeenPile:
    """The outline as a camera shows it; `stated`: of [pile] and [seed]
    (gate_speed_mm_s, photo_s, width_mm, seed_mm)."""
    x, z = outline(h, rng)
    height = (
        z - np.tan(np.radians(h.tilt_deg)) * x
    )  # against gravity's horizontal through the plate's middle
    c, s = np.cos(np.radians(h.roll_deg)), np.sin(np.radians(h.roll_deg))
    across, up = x * c + height * s, height * c - x * s
    columns = np.arange(np.ceil(across.min()), across.max(), PX_MM)
    order = np.argsort(across)
    surface = np.interp(columns, across[order], up[order])
    base = h.tilt_deg + h.roll_deg
    there = np.flatnonzero(z > 0)
    above = np.flatnonzero(
        surface + np.tan(np.radians(base)) * columns > 0.02 * h.height_mm
    )
    crest = across[there[np.argmax(gaussian_filter1d(z, 20)[there])]]
    toes = (columns[above[0]] if h.two else None, columns[above[-1]])
    unit = 1.0 if h.scale else 1 / PX_MM
    box = (
        {}
        if "width_mm" not in stated
        else {"box_mm": [100.0, stated["width_mm"], 200.0]}
    )
    plumb = {"plumb_deg": 0.0} if h.plumb else {}
    description = {
        "camera": {"plumb_sd_deg": h.plumb_sd_deg if h.plumb else 0.5} | plumb,
        "pile": box
        | {k: v for k, v in stated.items() if k in ("gate_speed_mm_s", "photo_s")},
        "seed": {"length_mm": stated.get("seed_mm", h.grain_mm)},
    }
    seen = base + 0.02 * rng.normal() if h.plate else 0.0
    return SeenPile(
        name,
        "s",
        unit * columns,
        unit * surface,
        "mm" if h.scale else "px",
        0.0,
        seen,
        0.02 if h.plate else 0.5,
        "plate" if h.plate else "toe",
        unit * crest,
        tuple(t if t is None else unit * t for t in toes),
        description,
    )


def repeats(h: Heap, rng: np.random.Generator, count: int, **stated) -> list[SeenPile]:
    """`count` heaps of one bench."""
    return [picture(h, rng, f"heap-{k + 1:02d}", **stated) for k in range(count)]


def changed(h: Heap, **more) -> Heap:
    """The same bench with something else."""
    return replace(h, **more)


def photograph(
    h: Heap,
    rng: np.random.Generator,
    folder: Path,
    mm_per_px: float = 0.25,
    cut: float = 0.0,
    **stated,
) -> Path:
    """The heap as a picture in a recording's folder: light seeds and a grey plate
    before a dark ground; cut: share of the heap's half width that lies beyond the right
    edge."""
    x, z = outline(h, rng)
    reach = 1.15 * h.height_mm / np.tan(np.radians(h.angle_deg))
    width = int(((2.4 if h.two else 1.5) - 1.1 * cut) * reach / mm_per_px)
    height = int((1.4 * h.height_mm + 0.1 * reach) / mm_per_px)
    middle = np.array(
        [
            (1.2 if h.two else 0.12) * reach / mm_per_px,
            height - 0.15 * h.height_mm / mm_per_px - 20,
        ]
    )
    lean = np.tan(np.radians(h.tilt_deg))
    far = 3 * reach
    ground = np.array(
        [[-far, lean * far], [far, -lean * far], [far, -far], [-far, -far]]
    )
    heap = np.vstack(
        [
            np.column_stack([x, z - lean * x]),
            [[x[-1], -lean * x[-1]], [x[0], -lean * x[0]]],
        ]
    )
    c, s = np.cos(np.radians(h.roll_deg)), np.sin(np.radians(h.roll_deg))
    image = np.full((height, width), 35, np.uint8)
    for tone, polygon in ((90, ground), (200, heap)):
        across, up = (
            polygon[:, 0] * c + polygon[:, 1] * s,
            polygon[:, 1] * c - polygon[:, 0] * s,
        )
        places = middle + np.column_stack([across, -up]) / mm_per_px
        cv2.fillPoly(
            image, [np.rint(places * 256).astype(np.int32)], tone, cv2.LINE_AA, 8
        )
    image = cv2.GaussianBlur(image, (0, 0), 0.8) + rng.normal(0, 4, image.shape)
    folder.mkdir(parents=True)
    cv2.imwrite(
        str(folder / "photo.png"), np.clip(np.rint(image), 0, 255).astype(np.uint8)
    )
    (folder / "recording.toml").write_text(_toml(h, mm_per_px, stated), encoding="utf8")
    return folder


def _toml(h: Heap, mm_per_px: float, stated: dict) -> str:
    camera = [f"mm_per_px = {mm_per_px}"] if h.scale else []
    camera += ["plumb_deg = 0.0", f"plumb_sd_deg = {h.plumb_sd_deg}"] if h.plumb else []
    pile = [
        f"{k} = {float(v)}"
        for k, v in stated.items()
        if k in ("gate_speed_mm_s", "photo_s")
    ]
    return "\n".join(
        [
            'rig = "pile"',
            "[camera]",
            *camera,
            "[pile]",
            *pile,
            "[seed]",
            f"length_mm = {h.grain_mm}",
            "",
        ]
    )
