"""Parts of path-traced scenes: a sphere's mesh, boxes, plain and painted surfaces,
cloth and wood."""

import numpy as np
from scipy.ndimage import gaussian_filter

Array = np.ndarray


def sphere_mesh(rings: int = 10, spokes: int = 16) -> tuple[Array, Array]:
    """A unit sphere of latitudes and longitudes: vertices (v, 3), faces (f, 3)."""
    polar, turn = np.meshgrid(
        np.linspace(0, np.pi, rings + 1),
        2 * np.pi * np.arange(spokes) / spokes,
        indexing="ij",
    )
    points = np.stack(
        [np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar)], -1
    ).reshape(-1, 3)
    i, j = (
        a.ravel()
        for a in np.meshgrid(np.arange(rings), np.arange(spokes), indexing="ij")
    )
    a, b = i * spokes + j, i * spokes + (j + 1) % spokes
    return points, np.concatenate(
        [np.c_[a, a + spokes, b], np.c_[b, a + spokes, b + spokes]]
    )


def plain_surface(mi, colour) -> dict:
    return {
        "type": "diffuse",
        "reflectance": {
            "type": "rgb",
            "value": [float(c) for c in np.broadcast_to(colour, 3)],
        },
    }


def box(mi, middle, half, bsdf: dict) -> dict:
    to_world = (
        mi.ScalarTransform4f()
        .translate([float(v) for v in middle])
        .scale([float(v) for v in half])
    )
    return {"type": "cube", "to_world": to_world, "bsdf": bsdf}


def painted_surface(mi, pattern: Array) -> dict:
    return {
        "type": "diffuse",
        "reflectance": {
            "type": "bitmap",
            "bitmap": mi.Bitmap(pattern.astype(np.float32)),
            "raw": True,
        },
    }


def cloth(rng: np.random.Generator, n: int = 1024) -> Array:
    """A woven cloth with checks."""
    y, x = np.mgrid[0:n, 0:n] / n
    threads = float(rng.uniform(60, 160))
    weave = 0.8 + 0.2 * np.sin(2 * np.pi * threads * x) * np.sin(
        2 * np.pi * threads * y
    )
    colours = rng.uniform(0.1, 0.8, (3, 3))
    stripes = int(rng.integers(3, 12))
    across, along = (
        (x * stripes % 1 < 0.4)[..., None],
        (y * stripes % 1 < 0.4)[..., None],
    )
    cloth = np.where(
        across & along,
        colours[0],
        np.where(across | along, (colours[0] + colours[1]) / 2, colours[1]),
    )
    return np.clip(
        cloth * weave[..., None] * (1 + 0.05 * rng.normal(size=(n, n, 1))), 0.01, 0.95
    )


def wood(rng: np.random.Generator, n: int = 1024) -> Array:
    """Planks of streaked wood, the grain running sideways."""
    grain = gaussian_filter(rng.normal(size=(n, n)), (1.5, 60), mode="wrap") * 9
    bend = 75 * gaussian_filter(rng.normal(size=(n, n)), (20, 120), mode="wrap")
    rings = np.sin(2 * np.pi * (np.arange(n)[:, None] / n * 18 + bend))
    planks = (np.arange(n) % (n // int(rng.integers(4, 9))) < 4)[:, None]
    tone = np.clip(1 + 0.25 * grain + 0.12 * rings, 0.3, 1.6) * np.where(
        planks, 0.35, 1.0
    )
    return np.clip(
        tone[..., None] * rng.uniform(0.25, 0.6) * np.array([1.0, 0.72, 0.45]),
        0.01,
        0.95,
    )


def srgb(light: Array) -> Array:
    """The sRGB tone curve: linear light 0 … 1 to picture values 0 … 1."""
    return np.where(
        light < 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055
    )
