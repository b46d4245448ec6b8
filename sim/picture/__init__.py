"""Motion → pictures, as a camera at the bench would take them.

photo(motion, camera, look, frame=-1, rng=rng) → uint8 (rows, columns, 3), or (rows,
columns) with Look(grey=True); film(motion, camera, look, rng=rng) → the same, one a
frame; coverage(motion, camera, frame=-1) → float32, share covered, 0 to 1;
project(camera, points_m) → where points are seen. camera.roll_deg is a recording's
plumb_deg, camera.mm_per_px its mm_per_px."""

from benchtwin.sim.picture.camera import Camera, project
from benchtwin.sim.picture.context import RenderingUnavailable, renderer_name
from benchtwin.sim.picture.exposure import coverage, film, photo
from benchtwin.sim.picture.look import Look

__all__ = [
    "Camera",
    "Look",
    "RenderingUnavailable",
    "coverage",
    "film",
    "photo",
    "project",
    "renderer_name",
]
