"""What a camera that looks down on a heap sees of its angles.

A cone of slope tan α and foot radius 1, seen from afar at a pitch p, has its apex
c = tan α cos p above the middle of its foot, which is an ellipse of half height
b = sin p. Its outline is the two tangents from the apex to that ellipse,

    tan²α′ = tan²α cos²p − sin²p,

down to where they touch it (b²/c above the middle), and the ellipse below. Every angle
is read off this outline by its own definition. A slab between walls that are seen edge
on is only less high: tan α′ = tan α cos p."""

from functools import cache

import numpy as np

CONE, SLAB = "cone", "slab"
ANGLES_DEG = np.arange(1.0, 66.0, 1.0)
COLUMNS = 400  # of the outline


def level_angle(
    name: str, seen_deg: float, pitch_deg: float, form: str, window: tuple[float, float]
) -> tuple[float, float]:
    """The angle [deg] as a level camera would see it, and how far off it may be.

    name: of the quantity; form: CONE, SLAB, or "" where it is not known: then midway
    between what a slab and a cone would be, ± half of what they differ by. A cone's is
    ± half of what it is off: the seeds along its foot hide some of that (0.4 to 1 of it
    is right for cones of 7 to 14 seeds' radius)."""
    p = round(pitch_deg, 1)
    slab = np.degrees(np.arctan(np.tan(np.radians(seen_deg)) / np.cos(np.radians(p))))
    cones = ANGLES_DEG[p < ANGLES_DEG]  # the foot's far half hides flatter ones
    cone = np.interp(seen_deg, _seen(name, p, window)[-cones.size :], cones)
    if form == SLAB:
        return float(slab), 0.0
    if form == CONE:
        return float(cone), float(abs(cone - seen_deg)) / 2
    return float(slab + cone) / 2, float(abs(cone - slab)) / 2


@cache
def _seen(name: str, pitch_deg: float, window: tuple[float, float]) -> np.ndarray:
    """The angle of that name [deg] of cones of ANGLES_DEG."""
    return np.array([_seen_of(name, a, pitch_deg, window) for a in ANGLES_DEG])


def _seen_of(name: str, angle_deg: float, pitch_deg: float, window) -> float:
    x = (np.arange(COLUMNS) + 0.5) / COLUMNS
    top = np.tan(np.radians(angle_deg)) * np.cos(np.radians(pitch_deg))
    low = np.sin(np.radians(pitch_deg))
    touches = np.sqrt(max(1 - (low / top) ** 2, 0.0))
    slope = np.sqrt(max(top**2 - low**2, 0.0))
    height = np.where(x < touches, top - slope * x, low * np.sqrt(1 - x**2))
    crest = float(height.max())
    if name.startswith("centroid"):
        body = np.clip(height - 0.1 * crest, 0, None)
        seen = (body**2).sum() / 2 / (x * body).sum()
    elif name.startswith("height"):
        seen = crest
    else:
        inside = (height > window[0] * crest) & (height < window[1] * crest)
        seen = -np.polyfit(x[inside], height[inside], 1)[0]
    return float(np.degrees(np.arctan(seen)))
