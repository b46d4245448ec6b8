"""Path-traced photos of heaps of seeds whose every grain is known: six backgrounds, two
camera heights, mirrors, box walls.

Ellipsoids are strewn inside a cone (a half cone where it leans on a box wall), pushed
apart until none overlaps, and pictured by mitsuba (scalar_rgb, one thread) with few
samples a pixel; blur, sensor noise and JPEG follow. Lengths in mm, x right, y away from
the camera, z up from the plate.

The true angle comes from the grains alone: seen from the side, level and from afar, the
highest point of any grain over each x is the outline; a line is fitted by least squares
through it where that line lies between 20 and 80 % of the crest's height, and both
flanks averaged. Perspective and a camera above the plate are therefore errors of the
reader, not of the truth."""

import io
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mitsuba_scene import (
    box,
    cloth,
    painted_surface,
    plain_surface,
    sphere_mesh,
    srgb,
    wood,
)
from PIL import Image
from scipy.ndimage import gaussian_filter
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from benchtwin.vision.board.sheet import SHEETS, Sheet, draw_page

Array = np.ndarray
BACKGROUNDS = ("dark", "white", "cloth", "wood", "horizon", "busy")
BEANS = {  # mean colour, scatter between grains, length : width : thickness
    "soybean": ((0.66, 0.50, 0.26), 0.04, (1.12, 1.0, 1.0)),
    "small bean": ((0.35, 0.26, 0.13), 0.05, (1.3, 1.0, 1.0)),
    "white bean": ((0.78, 0.74, 0.64), 0.03, (1.5, 1.0, 1.0)),
    "black bean": ((0.045, 0.04, 0.045), 0.01, (1.4, 1.0, 1.0)),
    "kidney bean": ((0.30, 0.07, 0.06), 0.04, (1.6, 1.0, 1.0)),
    "pea": ((0.38, 0.48, 0.16), 0.05, (1.0, 1.0, 1.0)),
}
GRAINS = {
    "rice": ((0.74, 0.71, 0.62), 0.02, (3.2, 1.0, 0.85)),
    "wheat": ((0.52, 0.36, 0.18), 0.05, (2.1, 1.0, 0.9)),
    "lentil": ((0.36, 0.25, 0.11), 0.05, (1.0, 1.0, 0.42)),
}
BEAN_MM, GRAIN_MM = (4.0, 8.0), (3.0, 4.5)  # diameter of a sphere of their volume
WINDOW = (0.2, 0.8)
TOE, FOOT = 0.02, 0.1  # of the crest's height: where a heap ends, where its centroid's
LOW_DEG = 22.0


@dataclass(frozen=True)
class Shot:
    """One photo to be made; `seed` fixes the rest (seeds' kind, sizes, colours, light,
    lens)."""

    background: str
    camera_deg: float  # above the plate
    mirror: bool
    wall: bool
    seed: int
    slope_deg: tuple[float, float] = (22.0, 36.0)  # of the cone the heap fills
    grain: str = ""  # of GRAINS; "": one of BEANS
    strewn: float = 0.0  # share of the plate about the heap that loose grains cover
    board: str = ""  # size of the printed board that stands to the left of the heap

    @property
    def name(self) -> str:
        marks = ("-mirror" if self.mirror else "") + ("-wall" if self.wall else "")
        marks += "-low" if self.slope_deg[1] < LOW_DEG else ""
        marks += f"-{self.grain}" if self.grain else ""
        marks += f"-strewn{100 * self.strewn:.0f}" if self.strewn else ""
        marks += f"-{self.board}" if self.board else ""
        return f"{self.background}-{self.camera_deg:.0f}deg{marks}-{self.seed}"


@dataclass(frozen=True)
class Grains:
    """centre (n, 3), semi-axes (n, 3) [mm], turn (n, 3, 3)."""

    centre: Array
    axes: Array
    turn: Array


@dataclass(frozen=True)
class Photo:
    """The picture (uint8 RGB), the true angles by quantity, the pile's frame (roi: x,
    y, w, h) and foot (baseline: x1, y1, x2, y2) in px; mm_per_px: in the plane of the
    heap's middle, which is the board's."""

    pixels: Array
    truth: dict[str, float]
    roi: tuple[int, int, int, int]
    baseline: tuple[float, float, float, float]
    mm_per_px: float


def heap(
    angle_deg: float,
    radius: float,
    size: float,
    form: tuple[float, float, float],
    half: bool,
    rng: np.random.Generator,
) -> Grains:
    """Grains of mean diameter `size`, none overlapping by more than a few hundredths,
    that fill a cone of that foot radius; form: their axes' proportions."""
    slope = np.tan(np.radians(angle_deg))
    count = int(0.60 * radius**3 * slope * np.pi / 3 / (np.pi / 6 * size**3))
    at = rng.uniform(-1, 1, (40 * count, 3)) * radius
    at[:, 2] = np.abs(at[:, 2])
    at = at[np.hypot(at[:, 0], at[:, 1]) * slope + at[:, 2] < radius * slope][:count]
    diameter = size * rng.normal(1, 0.05, len(at))
    for _ in range(150):
        near = cKDTree(at).query_pairs(1.2 * size, output_type="ndarray")
        off = at[near[:, 0]] - at[near[:, 1]]
        apart = np.linalg.norm(off, axis=1) + 1e-9
        lap = np.clip(
            (diameter[near[:, 0]] + diameter[near[:, 1]]) / 2 - apart, 0, None
        )
        push = 0.4 * off * (lap / apart)[:, None]
        np.add.at(at, near[:, 0], push)
        np.add.at(at, near[:, 1], -push)
        out = np.hypot(at[:, 0], at[:, 1])
        above = np.clip(
            (at[:, 2] + out * slope - (radius - 0.5 * size) * slope) / (1 + slope**2),
            0,
            None,
        )[:, None]
        at -= (
            0.6
            * above
            * np.c_[
                at[:, :2] / np.maximum(out, 1e-9)[:, None] * slope, np.ones(len(at))
            ]
        )
        at[:, 2] = np.maximum(at[:, 2] - 0.01 * size, diameter / 2)
    stray = int(rng.integers(0, 6))
    far = rng.uniform(1.1, 1.4, stray) * radius
    where = rng.uniform(0, 2 * np.pi, stray)
    at = np.r_[
        at, np.c_[far * np.cos(where), far * np.sin(where), np.full(stray, size / 2)]
    ]
    diameter = np.r_[diameter, np.full(stray, size)]
    if half:
        keep = at[:, 0] > diameter / 2
        at, diameter = at[keep], diameter[keep]
    axes = diameter[:, None] / 2 * np.array(form) / np.prod(form) ** (1 / 3)
    return Grains(
        at, axes, Rotation.random(len(at), random_state=rng.integers(2**31)).as_matrix()
    )


def strewn_about(
    body: Grains, radius: float, size: float, share: float, rng: np.random.Generator
) -> Grains:
    """The heap's grains with single ones lying flat about it, on `share` of the plate
    out to half a radius from its foot."""
    axes = np.median(body.axes, axis=0)
    step = np.sqrt(np.pi * axes[0] * axes[1] / share)
    x, y = np.meshgrid(*[np.arange(-1.5 * radius, 1.5 * radius, step)] * 2)
    at = np.c_[x.ravel(), y.ravel()] + rng.uniform(-0.4, 0.4, (x.size, 2)) * step
    out = np.hypot(*at.T)
    at = at[(out > radius) & (out < rng.uniform(1.2, 1.5) * radius)]
    own = axes * rng.normal(1, 0.05, (len(at), 1))
    angle = rng.uniform(0, 2 * np.pi, (len(at), 1))
    turn = Rotation.from_euler("z", angle).as_matrix()
    return Grains(
        np.r_[body.centre, np.c_[at, own[:, 2]]],
        np.r_[body.axes, own],
        np.r_[body.turn, turn],
    )


def outline(grains: Grains, x: Array) -> Array:
    """The highest z of any grain over each x, seen along y from afar; 0 where there is
    none."""
    top = np.zeros(x.size)
    form = np.einsum(
        "nij,nj,nkj->nik", grains.turn, grains.axes**2, grains.turn
    )  # the dual quadric: its x, z block is the shadow
    for (cx, _, cz), s in zip(grains.centre, form):
        lean, width = s[0, 2] / s[0, 0], np.sqrt(s[0, 0])
        height = np.sqrt(s[2, 2] - s[0, 2] * lean)
        a, b = np.searchsorted(x, (cx - width, cx + width))
        u = (x[a:b] - cx) / width
        top[a:b] = np.maximum(
            top[a:b],
            cz + lean * (x[a:b] - cx) + height * np.sqrt(np.clip(1 - u**2, 0, None)),
        )
    return top


def true_angles(grains: Grains, radius: float, half: bool) -> dict[str, float]:
    """Every angle that the reader gives, by name [deg], of the outline as defined at
    the head of this file."""
    x = np.arange(grains.centre[:, 0].min() - 10, grains.centre[:, 0].max() + 10, 0.05)
    z = outline(grains, x)
    z[np.abs(x) > 1.05 * radius] = 0.0  # strays
    crest, tall = float(x[z.argmax()]), float(z.max())
    toes = x[z > TOE * tall][[0, -1]]
    sides: dict[str, float] = {}
    for name, side in (("left", -1), ("right", 1))[half:]:
        flank = side * (x - crest) > 0
        line = np.polyfit(x[flank & (z > 0.3 * tall)], z[flank & (z > 0.3 * tall)], 1)
        for _ in range(30):
            height = np.polyval(line, x)
            inside = flank & (height > WINDOW[0] * tall) & (height < WINDOW[1] * tall)
            line = np.polyfit(x[inside], z[inside], 1)
        sides[f"repose_angle_{name}"] = np.degrees(np.arctan(-side * line[0]))
    reach = toes[1] - crest if half else (toes[1] - toes[0]) / 2
    body = np.clip(z - FOOT * tall, 0, None)
    axis = 0.0 if half else float((x * body).sum() / body.sum())
    rise, out = (body**2).sum() / 2, (np.abs(x - axis) * body).sum()
    return {
        "repose_angle": float(np.mean(list(sides.values()))),
        **{name: float(angle) for name, angle in sides.items()},
        "height_over_radius_angle": float(
            np.degrees(np.arctan2((1 - TOE) * tall, reach))
        ),
        "centroid_angle": float(np.degrees(np.arctan2(rise, out))),
    }


def take(shot: Shot, width: int = 1400, samples: int = 24) -> Photo:
    """Render and spoil one photo, `width` px wide, as the same `shot` always gives
    it."""
    rng = np.random.default_rng(
        [
            sum(map(ord, shot.background)),
            round(shot.camera_deg),
            shot.mirror,
            shot.wall,
            shot.seed,
            sum(map(ord, shot.grain)),
            round(100 * shot.strewn),
        ]
    )
    radius = float(rng.uniform(50, 75))
    size = float(rng.uniform(*(GRAIN_MM if shot.grain else BEAN_MM)))
    plain = PLAIN.get(shot.background, 9.0)
    unlike = [k for k in BEANS if np.ptp([np.mean(BEANS[k][0]), plain]) > 0.2]
    kind = shot.grain or str(rng.choice(unlike))
    colour, scatter, form = (BEANS | GRAINS)[kind]
    grains = heap(
        float(rng.uniform(*shot.slope_deg)), radius, size, form, shot.wall, rng
    )
    if shot.strewn:
        grains = strewn_about(grains, radius, size, shot.strewn, rng)
    tall = float((grains.centre[:, 2] + grains.axes.min(axis=1)).max())
    middle = 0.5 * radius if shot.wall else 0.0
    distance, lens = float(rng.uniform(450, 800)), float(rng.uniform(2.9, 3.6) * radius)
    if shot.board:  # it and the heap side by side in the picture
        sheet = SHEETS[shot.board].page_mm[0]
        middle, lens = -sheet / 2, 1.15 * (2.3 * radius + sheet)
    up = np.radians(shot.camera_deg)
    aim = np.array([middle, 0.0, 0.55 * tall])
    eye = np.array(
        [
            middle,
            -distance * np.cos(up),
            distance * np.sin(up) + (aim[2] if shot.camera_deg else 0.1 * tall),
        ]
    )
    if not shot.camera_deg:
        aim[2] = eye[2]
    height = int(0.66 * width)
    focal = width * distance / lens
    shift = (
        0.0 if shot.camera_deg else 0.22 * height
    )  # a level camera whose sensor looks up a little
    picture = _render(
        shot,
        grains,
        (colour, scatter),
        eye,
        aim,
        focal,
        (width, height),
        shift,
        tall,
        radius,
        samples,
        rng,
    )
    look = (aim - eye) / np.linalg.norm(aim - eye)
    right = np.array([1.0, 0, 0])
    over = np.cross(right, look)

    def seen(points: Array) -> Array:
        off = points - eye
        return np.c_[off @ right, -(off @ over)] / (off @ look)[:, None] * focal + [
            (width - 1) / 2,
            (height - 1) / 2 + shift,
        ]

    body = grains.centre[np.hypot(*grains.centre[:, :2].T) < 1.05 * radius]
    frame = seen(body)
    margin = 2.5 * size * focal / distance
    x0, y0 = (
        int(v) for v in np.maximum(frame.min(axis=0) - np.array([2.0, 1.5]) * margin, 0)
    )
    x1, y1 = (
        int(v) for v in np.minimum(frame.max(axis=0) + 2 * margin, [width, height])
    )
    if shot.wall:
        x0 = int(
            seen(np.array([[0.06 * radius, 0, 0]]))[0, 0]
        )  # right of all of the wall
    foot = seen(np.array([[-radius, 0.0, 0.0], [radius, 0.0, 0.0]]))
    (left, left_y), (end, right_y) = foot.tolist()
    return Photo(
        _spoil(picture, rng),
        true_angles(grains, radius, shot.wall),
        (x0, y0, x1 - x0, y1 - y0),
        (left, left_y, end, right_y),
        float(np.linalg.norm(aim - eye) / focal),
    )


PLAIN = {
    "dark": 0.03,
    "white": 0.75,
}  # mean reflectance: seeds of the same would be no photo that anybody takes


def _spoil(linear: Array, rng: np.random.Generator) -> Array:
    """Lens blur, photon and sensor noise, the sRGB curve, JPEG."""
    sigma = float(rng.uniform(0.6, 1.3))
    light = gaussian_filter(
        linear / np.percentile(linear, 98) * 0.85, (sigma, sigma, 0)
    )
    light = np.clip(
        light
        + rng.normal(0, 1, light.shape)
        * np.sqrt(2e-4 * np.clip(light, 0, None) + 4e-6),
        0,
        1,
    )
    file = io.BytesIO()
    Image.fromarray((255 * srgb(light) + 0.5).astype(np.uint8)).save(
        file, "jpeg", quality=int(rng.integers(75, 93))
    )
    return np.asarray(Image.open(file))


def _render(
    shot, grains, colours, eye, aim, focal, size, shift, tall, radius, samples, rng
) -> Array:
    import drjit
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    drjit.set_thread_count(1)
    place = mi.ScalarTransform4f
    width, height = size
    camera = {
        "type": "perspective",
        "fov": float(np.degrees(2 * np.arctan(width / 2 / focal))),
        "fov_axis": "x",
        "principal_point_offset_y": float(-shift / height),
        "near_clip": 10.0,
        "far_clip": 1e5,
        "to_world": place().look_at(
            origin=eye.tolist(), target=aim.tolist(), up=[0, 0, 1]
        ),
        "film": {
            "type": "hdrfilm",
            "width": width,
            "height": height,
            "rfilter": {"type": "box"},
            "pixel_format": "rgb",
        },
        "sampler": {
            "type": "independent",
            "sample_count": samples,
            "seed": int(rng.integers(2**31)),
        },
    }
    lamp = [
        float(rng.uniform(-400, 400)),
        float(rng.uniform(-700, -100)),
        float(rng.uniform(350, 700)),
    ]
    side = float(rng.uniform(60, 220))
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 5},
        "camera": camera,
        "sky": {"type": "constant", "radiance": float(rng.uniform(0.25, 0.6))},
        "lamp": {
            "type": "rectangle",
            "to_world": place()
            .look_at(origin=lamp, target=[0, 0, 0], up=[0, 1, 0.1])
            .scale([side, side, 1]),
            "emitter": {
                "type": "area",
                "radiance": float(3e5 / side**2 * rng.uniform(0.6, 1.4)),
            },
        },
        "seeds": _seeds(mi, grains, colours, rng),
        **_plate(mi, shot, eye, tall, radius, rng),
        **_behind(mi, shot, eye, tall, rng),
    }
    if shot.board:
        scene["board"] = _board(mi, SHEETS[shot.board], radius)
    if shot.wall:
        scene["wall"] = box(
            mi,
            [-6, 0, 0.65 * tall],
            [6, radius, 0.65 * tall],
            plain_surface(mi, rng.uniform(0.15, 0.7, 3)),
        )
    return np.array(mi.render(mi.load_dict(scene)))[..., :3].astype(float)


def _board(mi, sheet: Sheet, radius: float) -> dict:
    """The printed sheet, upright in the plane of the heap's middle, on the plate."""
    # a texture's first row is its lowest
    page = np.asarray(draw_page(sheet).convert("L").reduce(4), float)[::-1] / 255
    wide, high = sheet.page_mm
    place = mi.ScalarTransform4f()
    return {
        "type": "rectangle",
        "to_world": place.translate([-1.15 * radius - wide / 2, 0, high / 2])
        .rotate([1, 0, 0], 90)
        .scale([wide / 2, high / 2, 1]),
        "bsdf": painted_surface(mi, np.repeat(0.04 + 0.8 * page[..., None], 3, 2)),
    }


def _seeds(mi, grains: Grains, colours, rng) -> object:
    """All grains as one mesh, each with a colour of its own."""
    ball, faces = sphere_mesh()
    normals = ball[None] / grains.axes[:, None]
    points = (
        np.einsum("nij,nvj->nvi", grains.turn, ball[None] * grains.axes[:, None])
        + grains.centre[:, None]
    )
    normals = np.einsum(
        "nij,nvj->nvi",
        grains.turn,
        normals / np.linalg.norm(normals, axis=2, keepdims=True),
    )
    each = np.array(colours[0]) * rng.normal(1, 0.1, (len(points), 1)) + rng.normal(
        0, colours[1] / 3, (len(points), 3)
    )
    each = np.clip(each, 0.01, 0.95)
    bsdf = mi.load_dict(
        {
            "type": "principled",
            "roughness": float(rng.uniform(0.25, 0.6)),
            "specular": 0.5,
            "base_color": {"type": "mesh_attribute", "name": "vertex_color"},
        }
    )
    props = mi.Properties()
    props["bsdf"] = bsdf
    mesh = mi.Mesh(
        "seeds",
        len(points) * len(ball),
        len(points) * len(faces),
        has_vertex_normals=True,
        props=props,
    )
    mesh.add_attribute(
        "vertex_color", 3, np.repeat(each, len(ball), axis=0).ravel().astype(np.float32)
    )
    values = mi.traverse(mesh)
    values["vertex_positions"] = points.ravel().astype(np.float32)
    values["vertex_normals"] = normals.ravel().astype(np.float32)
    values["faces"] = (
        (faces[None] + len(ball) * np.arange(len(points))[:, None, None])
        .ravel()
        .astype(np.uint32)
    )
    values.update()
    return mesh


def _plate(mi, shot: Shot, eye, tall, radius, rng) -> dict:
    """The plate that the heap stands on: its upper face is z = 0, its far edge behind
    the heap."""
    tone = float(
        {"dark": rng.uniform(0.03, 0.3), "white": rng.uniform(0.5, 0.8)}.get(
            shot.background, rng.uniform(0.05, 0.7)
        )
    )
    body = plain_surface(mi, tone * rng.normal(1, 0.05, 3))
    if shot.background in ("cloth", "wood") and rng.random() < 0.5:
        body = painted_surface(mi, (cloth if shot.background == "cloth" else wood)(rng))
    if shot.mirror:
        shine = {
            "type": "roughconductor",
            "alpha": 0.02,
            "specular_reflectance": {"type": "rgb", "value": [0.9, 0.9, 0.9]},
        }
        body = {
            "type": "blendbsdf",
            "weight": float(rng.uniform(0.4, 0.9)),
            "a": body,
            "b": shine,
        }
    reach = float(rng.uniform(90, 160))
    if (
        shot.background == "horizon" and shot.camera_deg
    ):  # the far edge is seen at half the heap's height
        reach = float(
            np.clip((tall / 2 * -eye[1]) / (eye[2] - tall / 2), 100, 5000)
        ) * float(rng.uniform(0.8, 1.1))
    wide = (
        1e4
        if shot.background in ("horizon", "busy") or rng.random() < 0.5 or shot.board
        else float(rng.uniform(2.2, 3.0) * radius)
    )
    thick = float(rng.uniform(5, 60))
    return {
        "plate": box(
            mi,
            [0, (reach - 200) / 2, -thick / 2],
            [wide, (reach + 200) / 2, thick / 2],
            body,
        )
    }


def _behind(mi, shot: Shot, eye, tall, rng) -> dict:
    """What stands behind the heap."""
    far = float(rng.uniform(250, 500)) if shot.background != "horizon" else 6000.0
    span = 0.9 * (far - eye[1])
    paint = {
        "dark": lambda: plain_surface(mi, rng.uniform(0.01, 0.05)),
        "white": lambda: plain_surface(mi, rng.uniform(0.7, 0.85)),
        "cloth": lambda: painted_surface(mi, cloth(rng)),
        "wood": lambda: painted_surface(mi, wood(rng)),
    }
    bsdf = paint.get(
        shot.background, lambda: plain_surface(mi, rng.uniform(0.15, 0.8, 3))
    )()
    things = {"backdrop": box(mi, [0, far + 5, 0], [span, 5, span], bsdf)}
    if (
        shot.background == "horizon" and not shot.camera_deg
    ):  # another table, its far edge above this plate
        edge = tall * float(rng.uniform(0.4, 0.6))
        things["table"] = box(
            mi,
            [0, 800, edge - 100],
            [1e4, 400, 100],
            plain_surface(mi, rng.uniform(0.1, 0.7, 3)),
        )
    if shot.background == "busy":
        for i in range(12):
            half = rng.uniform(8, 40, 3)
            middle = [
                rng.uniform(-200, 200),
                rng.uniform(190, far),
                rng.uniform(-10, 120),
            ]
            things[f"thing{i}"] = box(
                mi, middle, half, plain_surface(mi, rng.uniform(0.02, 0.85, 3))
            )
        board = float(rng.uniform(0.2, 1.4) * tall)
        things["board"] = box(
            mi,
            [0, 210, board],
            [1e4, 15, 4],
            plain_surface(mi, rng.uniform(0.1, 0.8, 3)),
        )
    return things


def save(photo: Photo, file: Path) -> None:
    """The picture as PNG, the truth beside it."""
    Image.fromarray(photo.pixels).save(file)
    known: dict[str, object] = {"truth": photo.truth, "roi": photo.roi}
    known["baseline"] = photo.baseline
    known["mm_per_px"] = photo.mm_per_px
    file.with_suffix(".json").write_text(json.dumps(known) + "\n", encoding="utf8")


def load(file: Path) -> Photo:
    """What `save` has written."""
    known = json.loads(file.with_suffix(".json").read_text(encoding="utf8"))
    x, y, w, h = known["roi"]
    left, left_y, right, right_y = known["baseline"]
    pixels = np.asarray(Image.open(file))
    foot = left, left_y, right, right_y
    return Photo(pixels, known["truth"], (x, y, w, h), foot, known["mm_per_px"])
