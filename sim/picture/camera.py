"""A pinhole camera with a stated scale, turn, lens distortion and exposure: where it
sees a point."""

from dataclasses import dataclass

import numpy as np

Array = np.ndarray

RANGES = {
    "width_px": (8, 16384, "px"),
    "height_px": (8, 16384, "px"),
    "mm_per_px": (1e-4, 100.0, "mm/px"),
    "distance_m": (1e-2, 1e4, "m"),
    "azimuth_deg": (-360.0, 360.0, "°"),
    "elevation_deg": (-89.0, 89.0, "°"),
    "roll_deg": (-180.0, 180.0, "°"),
    "distortion": (-0.1, 0.1, "of the corner's distance from the centre"),
    "exposure_s": (0.0, 10.0, "s"),
    "subframes": (1, 1000, ""),
}


@dataclass(frozen=True)
class Camera:
    """How a picture is taken. It knows no frame rate: the moments of a film are those
    of the Motion.

    width_px, height_px; mm_per_px: scale in the object plane, which goes through
    target_m at right angles to the view. target_m: world point seen at the picture's
    centre. distance_m: pinhole to object plane; what stands nearer looks larger.
    azimuth_deg: 0 looks along +y with +x to the right; positive walks round the target
    anticlockwise, seen from above (90 stands at +x). elevation_deg: positive stands
    above and looks down. roll_deg: gravity's direction in the picture, clockwise from
    straight down: `camera.plumb_deg` of a recording. distortion k: a point at r from
    the centre is seen at r (1 + k r²/R²), R being the corner's distance: k is the
    corner's relative displacement, positive outwards (pincushion). exposure_s: the
    shutter is open over t ± exposure/2; subframes: moments averaged over it, at most;
    less where what moves goes less than half a pixel between them. Raises ValueError
    naming the parameter and its range."""

    width_px: int = 1280
    height_px: int = 800
    mm_per_px: float = 0.25
    target_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    distance_m: float = 2.0
    azimuth_deg: float = 0.0
    elevation_deg: float = 0.0
    roll_deg: float = 0.0
    distortion: float = 0.0
    exposure_s: float = 0.0
    subframes: int = 8

    def __post_init__(self):
        for name, (low, high, unit) in RANGES.items():
            value = getattr(self, name)
            if not low <= value <= high:  # also refuses NaN
                raise ValueError(
                    f"{name} = {value:g}: must be {low:g} to {high:g} {unit}".rstrip()
                )
        for name in ("width_px", "height_px", "subframes"):
            if getattr(self, name) != int(getattr(self, name)):
                raise ValueError(
                    f"{name} = {getattr(self, name)}: must be a whole number"
                )
        target = np.asarray(self.target_m, dtype=float)
        if target.shape != (3,) or not np.isfinite(target).all():
            raise ValueError(
                f"target_m = {self.target_m}: must be three finite numbers, x, y, z"
                " in m"
            )

    @property
    def focal_px(self) -> float:
        """Focal length in pixels: distance over the size of a pixel in the object
        plane."""
        return self.distance_m / (1e-3 * self.mm_per_px)

    @property
    def centre_px(self) -> Array:
        """The picture's centre (2,), column and row; pixel centres are at whole
        numbers."""
        return np.array([(self.width_px - 1) / 2, (self.height_px - 1) / 2])

    @property
    def corner_px(self) -> float:
        """The corner's distance from the centre, R of the distortion."""
        return float(np.hypot(self.width_px, self.height_px)) / 2


def axes(camera: Camera) -> Array:
    """World directions (3, 3) of the picture's right, the picture's down, and away from
    the camera, as rows."""
    azimuth, elevation, roll = np.radians(
        [camera.azimuth_deg, camera.elevation_deg, camera.roll_deg]
    )
    right = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    level = np.cos(elevation)
    away = np.array(
        [-np.sin(azimuth) * level, np.cos(azimuth) * level, -np.sin(elevation)]
    )
    up = np.cross(right, away)
    # What the picture shows turns clockwise by roll when the camera turns
    # anticlockwise.
    across = np.cos(roll) * right + np.sin(roll) * up
    down = np.sin(roll) * right - np.cos(roll) * up
    return np.array([across, down, away])


def view(camera: Camera, points_m: Array) -> Array:
    """Points (n, 3) [m] in the camera's axes about the target: right, down, away (n, 3)
    [m]."""
    return (
        np.asarray(points_m, dtype=float).reshape(-1, 3) - np.asarray(camera.target_m)
    ) @ axes(camera).T


def project(camera: Camera, points_m: Array) -> Array:
    """Where points (n, 3) [m] are seen: columns and rows (n, 2) [px], distortion
    included; NaN behind the pinhole.

    u = f X / (D + Z), then the distortion; pixel centres at whole numbers, y down.
    """
    seen = view(camera, points_m)
    depth = camera.distance_m + seen[:, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        far = np.where(depth > 0.0, depth, np.nan)[:, None]
        flat = camera.focal_px * seen[:, :2] / far
    return camera.centre_px + distort(camera, flat)


def distort(camera: Camera, offset_px: Array) -> Array:
    """Offsets from the centre (n, 2) [px] after the lens: o (1 + k |o|²/R²), for k < 0
    as far as that grows with |o|."""
    k = camera.distortion
    ratio = (offset_px**2).sum(axis=-1, keepdims=True) / camera.corner_px**2
    # beyond its maximum, well outside the picture, the formula would fold things back
    # into it
    if k < 0.0:
        ratio = np.minimum(ratio, -1.0 / (3.0 * k))
    return offset_px * (1.0 + k * ratio)


def undistort(camera: Camera, offset_px: Array) -> Array:
    """The inverse of `distort`: g solves g (1 + k g² |o|²/R²) = 1; from a table up to
    |o| = 1.2 R, exact to 1e-6."""
    if camera.distortion == 0.0:
        return offset_px
    square = np.linspace(0.0, 1.44, 4097)
    g = np.ones_like(square)
    for _ in range(50):
        g -= (g * (1.0 + camera.distortion * g**2 * square) - 1.0) / (
            1.0 + 3.0 * camera.distortion * g**2 * square
        )
    ratio = (offset_px**2).sum(axis=-1) / camera.corner_px**2
    return offset_px * np.interp(ratio, square, g)[..., None]
