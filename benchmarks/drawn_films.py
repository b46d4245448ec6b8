"""Films as phones make them, drawn with known motion: a drop, a roll and a slide.

Nothing here is shared with the reader. Every pixel row has its own time (rolling
shutter), every picture is the mean of SUBSTEPS instants (blur), the camera is a pinhole
at 0.4 to 2 m, the seed drifts in depth between bounces, the plate mirrors and is
shaded, a hand lets go and stays, somebody walks behind."""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np

WIDE, HIGH = 480, 640  # px
SUBSTEPS = 16
G = 9806.65  # mm/s²
LOOKS = ("pale on pale", "dark on pale", "pale on busy")
RIGS = ("drop", "roll", "slide")

Place = Callable[
    [np.ndarray], tuple[np.ndarray, ...]
]  # t [s] → x, y (up) and depth beyond the plane [mm], turn [rad]


@dataclass
class Film:
    """One film: where its body is, what surrounds it, the keys of its recording and the
    true values."""

    rig: str
    place: Place
    lasts_s: float
    axes_mm: tuple[float, float]
    keys: dict[str, dict[str, float | str]]
    truth: dict[str, float]
    fps: float
    mm_per_px: float
    corner_px: tuple[float, float]  # column and row of the rig's origin (0, 0)
    ground: list[tuple[float, float]]  # the surface's line, mm
    tilt: Callable[[float], float] | None = None  # of a slide's plate, rad
    boxy: bool = False
    let_go_s: float = 0.0
    distance_mm: float = math.inf  # camera to the plane of the motion

    def surface(self, x: np.ndarray) -> np.ndarray:
        """Height of a still surface under x, mm."""
        return np.interp(x, *np.array(self.ground).T)


def drawn_drop(rng: np.random.Generator) -> Film:
    """A seed let go over a level plate; restitution differs from bounce to bounce, as
    do side speed, spin and depth."""
    scale, fps = rng.uniform(0.32, 0.42), float(rng.choice([60, 120, 240]))
    a, b = rng.uniform(3.8, 4.4), rng.uniform(3.4, 3.7)
    height, density = rng.uniform(120, 170), 1250.0
    held, step = rng.uniform(0.15, 0.3), 5e-5
    x, y, z, turn = rng.uniform(-15, 15), height + b, 0.0, 0.0
    u, v, w, spin = 0.0, 0.0, 0.0, 0.0
    rows, truth, bounce, top, lowest = (
        [(0.0, x, y, z, turn), (held, x, y, z, turn)],
        {},
        0,
        0.0,
        0.0,
    )
    time = held
    while time < held + 0.95:
        speed = math.hypot(u, v)
        reynolds = max(speed * 2e-3 * (a + b) / 2 * 1e-3 * 1.2 / 1.81e-5, 1e-3)
        coefficient = 24 / reynolds * (1 + 0.15 * reynolds**0.687)
        drag = (
            0.75 * 0.5 * coefficient * 1.2 / (density * (a + b) / 2)
        )  # 1/mm: ¾ C ρ/(ρₛ d)
        u, v = u - drag * speed * u * step, v - (G + drag * speed * v) * step
        x, y, z, turn, time = (
            x + u * step,
            y + v * step,
            z + w * step,
            turn + spin * step,
            time + step,
        )
        top = max(top, y)
        contact = math.hypot(a * math.sin(turn), b * math.cos(turn))
        if y <= contact and v < 0:
            if bounce == 1:
                truth["rebound_height"] = top - lowest
            bounce, top, lowest = bounce + 1, 0.0, contact
            e = float(np.clip(rng.normal(0.55, 0.05), 0.35, 0.75))
            truth |= (
                {
                    "restitution_normal"
                    if bounce == 1
                    else f"restitution_bounce_{bounce}": e
                }
                if bounce <= 4
                else {}
            )
            y, v = contact, -e * v
            u, w, spin = (
                u + rng.normal(0, 25),
                rng.normal(0, 25),
                spin + rng.normal(0, 6),
            )
        rows.append((time, x, y, z, turn))
    table = np.array(rows).T
    seed = {"length_mm": 2 * a, "width_mm": 2 * b, "density_kg_m3": density}
    keys: dict = {"drop": {"height_mm": height + rng.normal(0, 0.5)}, "seed": seed}
    origin = (WIDE / 2, HIGH - 70.0)
    return Film(
        "drop",
        _along(table),
        held + 0.9,
        (a, b),
        keys,
        truth,
        fps,
        scale,
        origin,
        [(-200, 0), (200, 0)],
        let_go_s=held,
    )


def drawn_roll(rng: np.random.Generator) -> Film:
    """A round seed rolls down an incline and out on the level, slowed by one constant
    resistance; the corner costs nothing."""
    scale, fps = rng.uniform(0.42, 0.5), float(rng.choice([30, 60, 120]))
    radius, slope, way = (
        rng.uniform(3.4, 4.2),
        math.radians(rng.uniform(10, 16)),
        rng.uniform(30, 45),
    )
    run = rng.uniform(70, 110)
    mu = way * math.sin(slope) / (run + way * math.cos(slope))
    inertia = 1 / 1.4
    down, slow = (
        inertia * G * (math.sin(slope) - mu * math.cos(slope)),
        inertia * G * mu,
    )
    speed = math.sqrt(2 * down * way)
    held, fast = rng.uniform(0.2, 0.4), math.sqrt(2 * way / down)
    time = np.arange(0, held + fast + speed / slow + 0.7, 1e-3)
    late = np.clip(time - held, 0, None)
    path = np.where(late < fast, down * late**2 / 2 - way, 0.0)
    after = np.clip(late - fast, 0, speed / slow)
    path = np.where(late < fast, path, speed * after - slow * after**2 / 2)
    x, y = (
        np.where(path < 0, path * math.cos(slope), path),
        radius - np.where(path < 0, path * math.sin(slope), 0),
    )
    early = radius * math.tan(
        slope / 2
    )  # the surfaces meet that much before the centre's two lines do
    ground = [
        (-early - 70 * math.cos(slope), 70 * math.sin(slope)),
        (-early, 0.0),
        (400.0, 0.0),
    ]
    keys: dict = {
        "roll": {
            "incline_deg": math.degrees(slope),
            "incline_length_mm": way + early,
            "direction": "+x",
        },
        "seed": {"length_mm": 2.04 * radius, "width_mm": 2 * radius},
    }
    table = np.array([time, x, y, np.zeros_like(x), -path / radius])
    return Film(
        "roll",
        _along(table),
        time[-1] - 0.05,
        (1.02 * radius, radius),
        keys,
        {"run_out": run + early},
        fps,
        scale,
        (65 / scale, HIGH * 0.6),
        ground,
    )


def drawn_slide(rng: np.random.Generator) -> Film:
    """A block on a plate that is raised about its left end; it lets go where tan θ is
    the static friction."""
    scale, fps = rng.uniform(0.42, 0.5), float(rng.choice([30, 60]))
    onset, start, rate = rng.uniform(18, 30), rng.uniform(10, 14), rng.uniform(3, 5)
    kinetic, held = (
        rng.uniform(0.75, 0.9) * math.tan(math.radians(onset)),
        (onset - start) / rate,
    )
    turn, step, first = math.radians(rate), 2e-4, rng.uniform(95, 125)
    way, v, rows, time = first, 0.0, [(0.0, first), (held, first)], held
    while way > 40 and time < held + 1.5:
        angle = math.radians(start) + turn * time
        v += (
            G * math.sin(angle) - kinetic * max(G * math.cos(angle) - 2 * turn * v, 0.0)
        ) * step
        way, time = way - v * step, time + step
        rows.append((time, way))
    lasts = time + 0.4
    times, ways = np.array(rows).T
    half = (rng.uniform(6, 8), rng.uniform(3.2, 4.0))

    def place(t: np.ndarray) -> tuple[np.ndarray, ...]:
        angle, along = np.radians(start) + turn * t, np.interp(t, times, ways)
        x, y = (
            along * np.cos(angle) - half[1] * np.sin(angle),
            along * np.sin(angle) + half[1] * np.cos(angle),
        )
        return x, y, np.zeros_like(t), angle

    keys: dict = {
        "slide": {"tilt_rate_deg_s": rate, "start_deg": start},
        "seed": {"length_mm": 2 * half[0], "width_mm": 2 * half[1]},
    }
    return Film(
        "slide",
        place,
        lasts,
        half,
        keys,
        {"slide_angle": onset},
        fps,
        scale,
        (40.0, HIGH - 120.0),
        [(0, 0), (150, 0)],
        lambda t: math.radians(start) + turn * t,
        boxy=True,
    )


def _along(table: np.ndarray) -> Place:
    """Places interpolated in a table (5, n) of time, x, y, depth and turn."""
    return lambda t: tuple(np.interp(t, table[0], row) for row in table[1:])


DRAWN = {"drop": drawn_drop, "roll": drawn_roll, "slide": drawn_slide}


def texture(rng: np.random.Generator, roughness: float) -> np.ndarray:
    """Noise of several sizes (HIGH, WIDE), sd about `roughness`."""
    out: np.ndarray = np.zeros((HIGH, WIDE), np.float32)
    for size in (2, 6, 20, 60):
        blurred = cv2.GaussianBlur(
            rng.standard_normal((HIGH, WIDE)).astype(np.float32), (0, 0), size
        )
        out += blurred / blurred.std()
    return roughness * out / 2


def backdrop(
    film: Film, look: str, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """The picture without body (HIGH, WIDE, 3), and the seed's colour."""
    busy = look.endswith("busy")
    wall = np.array([205, 200, 190]) if not busy else rng.uniform(70, 130, 3)
    picture = wall + texture(rng, 22.0 if busy else 2.0)[..., None] * np.array(
        [1.0, 0.95, 0.85]
    )
    for _ in range(25 if busy else 2):
        corner = rng.integers(0, (WIDE, HIGH))
        box = cv2.boxPoints(
            (
                (float(corner[0]), float(corner[1])),
                tuple(rng.uniform(20, 150, 2)),
                float(rng.uniform(0, 180)),
            )
        )
        shade = rng.uniform(-45, 45, 3) if busy else rng.uniform(-12, 6, 3)
        patch: np.ndarray = np.zeros((HIGH, WIDE), np.float32)
        cv2.fillConvexPoly(patch, box.astype(np.int32), 1.0, cv2.LINE_AA)
        picture += cv2.GaussianBlur(patch, (0, 0), 1.2)[..., None] * shade
    columns, rows = np.meshgrid(np.linspace(-1, 1, WIDE), np.linspace(-1, 1, HIGH))
    picture *= (
        1 + rng.uniform(-0.12, 0.12) * columns + rng.uniform(-0.12, 0.12) * rows
    )[..., None]
    colour = {
        "pale on pale": [232, 218, 172],
        "dark on pale": [78, 52, 36],
        "pale on busy": [226, 206, 158],
    }[look]
    return picture.astype(np.float32), np.array(colour, np.float32) + rng.normal(
        0, 4, 3
    ).astype(np.float32)


def lay_plate(picture: np.ndarray, film: Film, t: float, shade: np.ndarray) -> None:
    """Draw the surface into the picture: from a little behind the line of contact
    downwards; a tilting one as a board."""
    points = np.array(film.ground)
    if film.tilt is not None:
        c, s = math.cos(film.tilt(t)), math.sin(film.tilt(t))
        points = points @ np.array([[c, s], [-s, c]])
    line = np.column_stack(
        [
            film.corner_px[0] + points[:, 0] / film.mm_per_px,
            film.corner_px[1] - points[:, 1] / film.mm_per_px,
        ]
    )
    thick = 14 if film.tilt is not None else HIGH
    back = 0 if film.tilt is not None else 9  # the camera looks down on it a little
    outline = np.vstack([line - [0, back], line[::-1] + np.array([0, thick])])
    patch: np.ndarray = np.zeros((HIGH, WIDE), np.float32)
    cv2.fillPoly(patch, [np.round(outline * 16).astype(np.int32)], 1.0, cv2.LINE_AA, 4)
    patch = cv2.GaussianBlur(patch, (0, 0), 0.7)[..., None]
    picture *= 1 - patch
    picture += patch * shade


def coverage(
    film: Film,
    columns: np.ndarray,
    rows: np.ndarray,
    at,
    grow: float = 0.0,
    flip: bool = False,
):
    """Share of each pixel that the body covers, and light on it, at (x, y, z, turn) of
    each row: arrays broadcast to one shape."""
    x, y, z, turn = at
    size = film.distance_mm / (film.distance_mm + z)
    centre_row = HIGH / 2
    level = (
        film.corner_px[1] - centre_row
    ) * film.mm_per_px  # height of the optical axis over the origin
    sideways = (WIDE / 2 - film.corner_px[0]) * film.mm_per_px
    u = (columns - WIDE / 2) * film.mm_per_px - (x - sideways) * size
    v = (centre_row - rows) * film.mm_per_px - (
        (2 * film.surface(x) - y if flip else y) - level
    ) * size
    sense = -1.0 if flip else 1.0
    c, s = np.cos(sense * turn), np.sin(sense * turn)
    along, across = (u * c + v * s) / size, (v * c - u * s) / size
    a, b = film.axes_mm[0] + grow, film.axes_mm[1] + grow
    if film.boxy:
        away = np.maximum(np.abs(along) - a, np.abs(across) - b)
    else:
        g = np.hypot(along / a, across / b)
        away = g * (g - 1) / np.maximum(np.hypot(along / a**2, across / b**2), 1e-6)
    light = 0.86 + 0.14 * np.clip((0.4 * u + 0.9 * v) / film.axes_mm[1], -1, 1)
    return np.clip(0.5 - away / film.mm_per_px, 0, 1), light


def draw(film: Film, look: str, rng: np.random.Generator, path: Path) -> None:
    """Write the film as H.264."""
    back, colour = backdrop(film, look, rng)
    plate = (
        np.array([196, 190, 180]) * rng.uniform(0.85, 1.1)
        + texture(rng, 2.0)[..., None]
    )
    if film.tilt is None:
        lay_plate(back, film, 0.0, plate)
    mirror, shadow = rng.uniform(0.03, 0.25), rng.uniform(0.05, 0.25)
    readout, exposure = (
        rng.uniform(0.002, min(0.015, 0.95 / film.fps)),
        rng.uniform(0.1, 1.0) / film.fps,
    )
    walks, walk = rng.random() < 0.4, (rng.uniform(-60, 60), rng.uniform(0, WIDE))

    def frames() -> Iterator[np.ndarray]:
        for n in range(int(film.lasts_s * film.fps)):
            t = n / film.fps
            picture = back.copy()
            if walks:
                _blob(
                    picture,
                    walk[1] + walk[0] * t,
                    HIGH * 0.3,
                    70,
                    190,
                    np.array([90, 80, 95]),
                    12.0,
                    0.5,
                )
            if film.tilt is not None:
                lay_plate(picture, film, t + exposure / 2, plate)
            _lay_body(picture, film, colour, t, readout, exposure, mirror, shadow)
            if film.rig == "drop":
                _lay_hand(picture, film, t)
            noise = np.sqrt(
                1.0 + 0.02 * np.clip(picture, 0, 255)
            ) * rng.standard_normal(picture.shape).astype(np.float32)
            yield np.clip(picture + noise, 0, 255).astype(np.uint8)

    write_h264(path, film.fps, int(rng.integers(18, 27)), frames())


def write_h264(
    path: Path, fps: float, quality: int, frames: Iterable[np.ndarray]
) -> None:
    """Write RGB frames (HIGH, WIDE, 3) as H.264; quality: the codec's constant rate
    factor, lower is better."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream(
            "libx264", rate=Fraction(fps).limit_denominator(1000)
        )
        assert isinstance(stream, av.VideoStream)
        stream.width, stream.height, stream.pix_fmt = WIDE, HIGH, "yuv420p"
        stream.options = {"crf": str(quality), "preset": "veryfast", "threads": "1"}
        for frame in frames:
            container.mux(
                stream.encode(av.VideoFrame.from_ndarray(frame, format="rgb24"))
            )
        container.mux(stream.encode())


def _blob(picture, column, row, wide, high, colour, soft, share) -> None:
    """A soft ellipse."""
    patch: np.ndarray = np.zeros(picture.shape[:2], np.float32)
    cv2.ellipse(
        patch,
        (round(column), round(row)),
        (int(wide), int(high)),
        0,
        0,
        360,
        1.0,
        -1,
        cv2.LINE_AA,
    )
    patch = share * cv2.GaussianBlur(patch, (0, 0), soft)[..., None]
    picture *= 1 - patch
    picture += patch * colour


def _lay_hand(picture, film: Film, t: float) -> None:
    """Two fingers that open when they let go, and stay."""
    x, y, *_ = (float(v[0]) for v in film.place(np.zeros(1)))
    column, row = (
        film.corner_px[0] + x / film.mm_per_px,
        film.corner_px[1] - y / film.mm_per_px,
    )
    opening = (
        film.axes_mm[0] + 12 * min(max(t - film.let_go_s + 0.01, 0) / 0.06, 1)
    ) / film.mm_per_px
    for side in (-1, 1):
        _blob(
            picture,
            column + side * (opening + 8),
            row - 22,
            9,
            30,
            np.array([205, 150, 125]),
            1.5,
            1.0,
        )


def _lay_body(
    picture, film: Film, colour, t, readout, exposure, mirror, shadow
) -> None:
    """Shadow, mirror image and body, each the mean over the exposure, each row at its
    own time."""
    ends = film.place(np.linspace(t, t + readout + exposure, 9))
    reach = 1.6 * max(film.axes_mm) / film.mm_per_px + 4
    column, row = (
        film.corner_px[0] + ends[0] / film.mm_per_px,
        film.corner_px[1] - ends[1] / film.mm_per_px,
    )
    x0, x1 = (
        int(np.clip(v, 0, WIDE)) for v in (column.min() - reach, column.max() + reach)
    )
    flat = film.tilt is None
    lowest = max(row.max(), (2 * film.corner_px[1] - row).max() if flat else 0.0)
    y0, y1 = (int(np.clip(v, 0, HIGH)) for v in (row.min() - reach, lowest + reach))
    if x1 <= x0 or y1 <= y0:
        return
    columns, rows = np.arange(x0, x1)[None, :], np.arange(y0, y1)[:, None]
    window = picture[y0:y1, x0:x1]
    line = (
        film.corner_px[1]
        - film.surface((columns - film.corner_px[0]) * film.mm_per_px) / film.mm_per_px
    )
    body, lit, image, under = (np.zeros((y1 - y0, x1 - x0)) for _ in range(4))
    for share in (np.arange(SUBSTEPS) + 0.5) / SUBSTEPS:
        times = t + readout * rows[:, 0] / HIGH + exposure * share
        at = tuple(v[:, None] for v in film.place(times))
        covered, light = coverage(film, columns, rows, at)
        body += covered / SUBSTEPS
        lit += covered * light / SUBSTEPS
        if flat:
            height = np.maximum(at[1] - film.surface(at[0]), 0)
            image += coverage(film, columns, rows, at, flip=True)[0] / SUBSTEPS
            beside = np.hypot(
                (columns - film.corner_px[0]) * film.mm_per_px - at[0],
                4 * (rows - line - 3) * film.mm_per_px,
            )
            under += (
                np.exp(-((beside / (film.axes_mm[0] + 0.3 * height)) ** 2))
                / (1 + height / 10)
                / SUBSTEPS
            )
    if flat:
        window *= (1 - shadow * under)[..., None]
        image = (
            mirror
            * cv2.GaussianBlur(image, (0, 0), 2.0)[..., None]
            * (rows > line)[..., None]
        )
        window += image * (colour - window)
    window *= (1 - body)[..., None]
    window += lit[..., None] * colour
