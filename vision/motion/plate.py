"""Straight things in the picture that a seed moves along: the tilting plate of a slide, the two legs of a roll."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from vision.evidence.frames import FrameSource
from vision.measurement import MeasurementError
from vision.motion.edge_line import Line, follow_lines
from vision.motion.follow import Followed, follow
from vision.motion.scene import learn_scene
from vision.motion.strip import PlateFrames, without_block
from vision.motion.track import Track
from vision.recording import Recording

CLEAR_BEND_DEG = 4.0  # a path whose bend is that far from the stated incline's is not the seed's alone
LEAST_TURN_DEG = 0.3  # a plate that tilts by less in the whole film is not tilting
UNPLUMBED_SD_DEG = 1.0  # of a camera whose level nobody stated
ASTRAY = 0.05  # of the seed's size: places further off its straight legs are not the centre of the seed alone
SHARP_PX = 0.3  # noise of a place, which the fit along the path allows for by itself
LEAST_SEEN = 0.5  # of the frames: an edge seen in fewer is not followed


@dataclass(frozen=True)
class Plate:
    """For the overlay: a picture (the last sampled, where the block has slid), the block's places in it (columns, rows), and
    plate lines as segments.
    """

    picture: np.ndarray
    places: tuple[np.ndarray, np.ndarray]
    lines: list


@dataclass(frozen=True)
class Path:
    """A roll's track with x along the path (0 at the junction, if seen), the legs in px (y up), what to say."""

    track: Track
    junction: tuple[float, float] | None
    legs: list
    notes: tuple[str, ...]
    doubt: str = ""  # what its legs contradict; "" where nothing

    def marks(self, stop: float | None) -> list:
        """The junction and the place of the stop, px, y up."""
        if not self.legs:
            return []
        start, end = (np.array(p) for p in self.legs[-1])
        places = [tuple(start)]
        if stop is not None:
            along = (end - start) / max(float(np.hypot(*(end - start))), 1e-9)
            shift = 0.0 if self.junction is None else self.junction[0]
            places.append(tuple(start + along * (stop - shift)))
        return places


def follow_slide(
    source: FrameSource, recording: Recording, progress: Callable[[float], None] | None = None
) -> tuple[Followed, Plate]:
    """The block's travel along the tilting plate [px] with the plate's angle, both from the picture.

    The plate's edge is followed through the film; its lines turn about one point, which gives the plate a frame of its own,
    and in that frame only the block moves. Angles are against the picture's horizontal, turned by `camera.plumb_deg`.
    """
    lines, shape, last = follow_lines(source)
    if lines is not None and len(lines) < LEAST_SEEN * source.count:
        source.note(f"the plate's edge is seen in {len(lines)} of {source.count} frames only and is not used")
        lines = None
    if lines is None:
        if recording.slide.tilt_rate_deg_s is None:
            text = "no tilting plate edge is seen in the picture, and [slide] start_deg and tilt_rate_deg_s are missing"
            raise MeasurementError(f"{recording.toml}: {text}")
        followed = follow(source, falling=False, progress=progress)
        return _along_own_line(followed)
    pivot = _pivot(lines)
    unit = shape[1] / 640
    ends = np.array([[line.along @ (line.at(s) - line.foot(pivot)) for s in line.extent] for line in lines.values()])
    reach = (int(ends.min() - 10), int(ends.max() + 10))
    strip = PlateFrames(source, lines, pivot, reach, above=round(110 * unit), below=round(14 * unit))
    followed = follow(strip, falling=False, progress=progress, scene=learn_scene(strip, still=without_block))
    plumb = recording.camera.plumb_deg or 0.0
    tilt = np.array([np.degrees(lines[int(f)].angle) for f in followed.track.frame]) - plumb
    flip = -1.0 if np.median(tilt) < 0 else 1.0
    own = float(np.median([line.angle_sd for line in lines.values()]))
    notes, level_sd = followed.track.notes, recording.camera.plumb_sd
    if recording.camera.plumb_deg is None and recording.camera.plumb_sd_deg is None:
        level_sd = UNPLUMBED_SD_DEG
        notes = (*notes, f"{recording.toml}: [camera] plumb_deg is missing: the plate's angle is known to ± {level_sd:g}° only")
    sd = float(np.hypot(level_sd, np.degrees(own)))
    track = replace(followed.track, tilt_deg=flip * tilt, tilt_sd_deg=sd, notes=notes)
    rows = strip.height - 1 - track.y
    strip_places = np.column_stack([track.x, rows, np.ones(len(track))])
    places = np.array([strip.matrix(int(f)) @ p for f, p in zip(track.frame, strip_places)])
    shown = [lines[min(lines)], lines[max(lines)]]
    segments = [(tuple(line.at(line.extent[0])), tuple(line.at(line.extent[1]))) for line in shown]
    return replace(followed, track=track), Plate(last, (places[:, 0], places[:, 1]), segments)


def _along_own_line(followed: Followed) -> tuple[Followed, Plate]:
    """Without a plate in the picture: the travel is along the straight line that the block itself follows."""
    track, height = followed.track, followed.scene.shape[0]
    centre = np.array([np.median(track.x), np.median(track.y)])
    offset = np.column_stack([track.x, track.y]) - centre
    _, _, directions = np.linalg.svd(offset, full_matrices=False)
    travel = offset @ directions[0]
    places = (track.x, height - 1 - track.y)
    return replace(followed, track=replace(track, x=travel, y=offset @ directions[1])), Plate(followed.scene.first, places, [])


def _pivot(lines: dict[int, Line]) -> np.ndarray:
    """The point about which the plate turns: n·P − d = c for every line (n its normal, c its offset, d constant)."""
    normals = np.array([line.across for line in lines.values()])
    offsets = np.array([line.offset for line in lines.values()])
    design = np.column_stack([normals, -np.ones(len(normals))])
    # A small turning tells d and P apart only weakly; hinges lie near their plate: d within about 600 × an edge's error.
    rows = np.vstack([design, [0.0, 0.0, 1 / 600]])
    return np.linalg.lstsq(rows, np.concatenate([offsets, [0.0]]), rcond=None)[0][:2]


def roll_path(track: Track, size: float, recording: Recording) -> Path:
    """Travel along the path of a rolling seed [px]: two straight legs, incline and level, fitted to where it went.

    The centroid goes round the corner r tan(Δ/2) beyond the plate's own junction (r its height above the plate, Δ the
    angle between the legs), so the plate's junction lies that much before the legs' meeting point.
    """
    used = track.used()
    sign = 1.0 if used.x[-1] >= used.x[0] else -1.0
    u, y = sign * used.x, used.y
    knee, stated = _knee(u, y), recording.roll.incline_deg
    if knee is None:
        centre, directions = (
            np.array([u.mean(), y.mean()]),
            np.linalg.svd(np.column_stack([u - u.mean(), y - y.mean()]), full_matrices=False)[2],
        )
        way = directions[0] * np.sign(directions[0][0])
        along = (sign * track.x - centre[0]) * way[0] + (track.y - centre[1]) * way[1]
        note = "the picture shows one straight leg only: the junction is not seen"
        doubt = "" if (stated or 0.0) < CLEAR_BEND_DEG else f"[roll] incline_deg says {stated:g}°, {note}"
        return Path(replace(track, x=along, y=np.zeros(len(track))), None, [], (note,), doubt)
    at, height, slope1, slope2, sd, astray = knee
    turn = abs(np.arctan(slope1) - np.arctan(slope2))
    legs = [np.array([1, slope1]) / np.hypot(1, slope1), np.array([1, slope2]) / np.hypot(1, slope2)]
    offset = np.column_stack([sign * track.x - at, track.y - height])
    along = np.where(offset[:, 0] < 0, offset @ legs[0], offset @ legs[1])
    early = size / 2 * np.tan(turn / 2)
    notes = [f"the legs meet at an angle of {np.degrees(turn):.2f}° in the picture"]
    doubt = ""
    if stated is not None and abs(np.degrees(turn) - stated) > 1.5:
        notes.append(f"[roll] incline_deg says {stated:g}°: check it, or the camera's view")
        if abs(np.degrees(turn) - stated) > CLEAR_BEND_DEG:
            doubt = f"the legs of the path meet at {np.degrees(turn):.1f}°, [roll] incline_deg says {stated:g}°"
    start, end = np.array([u.min(), height + slope1 * (u.min() - at)]), np.array([u.max(), height + slope2 * (u.max() - at)])
    corner = np.array([at, height])
    drawn = [tuple((p[0] * sign, p[1])) for p in (start, corner, end)]
    path = replace(track, x=along, y=np.zeros(len(track)))
    rocks = _rocking_px(recording)
    if astray > ASTRAY * size + rocks:
        text = f"the places lie {astray:.2g} px off the straight legs: a shadow or a mirror image is taken for a part of the seed"
        doubt = "; ".join(filter(None, (doubt, text)))
    # What a place errs across the legs it errs along them too, where the seed rests as well; an oblong seed's rocking is no error.
    sd = float(np.hypot(np.hypot(sd, 0.1 * early), max(astray - rocks - SHARP_PX, 0.0) * np.sqrt(2)))
    return Path(path, (-early, sd), [(drawn[0], drawn[1]), (drawn[1], drawn[2])], tuple(notes), doubt)


def _rocking_px(recording: Recording) -> float:
    """How far the centre of an oblong seed goes up and down as it rolls, rms; 0 where its axes or the scale are not stated."""
    seed = recording.seed
    axes = [a for a in (seed.length_mm, seed.width_mm, seed.thickness_mm) if a]
    if not recording.camera.mm_per_px or not axes:
        return 0.0
    return (max(axes) - min(axes)) / 2 / 2 / np.sqrt(2) / recording.camera.mm_per_px


def _neighbourly(left: np.ndarray) -> float:
    """By how much errors that neighbouring places share enlarge the variance of a fit: (1 + ρ)/(1 − ρ), ρ that of one place to the next."""
    rho = float(np.clip((left[1:] @ left[:-1]) / max(float(left @ left), 1e-12), 0.0, 0.95))
    return (1 + rho) / (1 - rho)


def _knee(u: np.ndarray, y: np.ndarray) -> tuple[float, float, float, float, float, float] | None:
    """Two straight legs that meet: place, height there, both slopes, sd of the place, rms of what lies off them; None when one line
    does as well."""
    order = np.argsort(u)
    u, y = u[order], y[order]
    spaced = np.searchsorted(u, np.linspace(u[0], u[-1], 400))  # a rest of a thousand frames counts as one place
    rows = np.unique(spaced.clip(0, len(u) - 1))
    u, y = u[rows], y[rows]
    if len(u) < 8:
        return None

    def design(at):
        return np.column_stack([np.ones(len(u)), np.minimum(u - at, 0), np.maximum(u - at, 0)])

    def misfit(at):
        columns = design(at)
        return float(((y - columns @ np.linalg.lstsq(columns, y, rcond=None)[0]) ** 2).sum())

    grid = np.linspace(u[2], u[-3], 300)
    costs = [misfit(g) for g in grid]
    best = int(np.argmin(costs))
    fine = np.linspace(grid[max(best - 1, 0)], grid[min(best + 1, 299)], 41)
    at = float(fine[int(np.argmin([misfit(g) for g in fine]))])
    columns = design(at)
    height, slope1, slope2 = np.linalg.lstsq(columns, y, rcond=None)[0]
    noise = np.sqrt(misfit(at) / max(len(u) - 4, 1))
    bend = abs(np.arctan(slope1) - np.arctan(slope2))
    line = np.polyfit(u, y, 1)
    straight = np.sqrt(np.mean((y - np.polyval(line, u)) ** 2))
    if bend < np.radians(2) or straight < 3 * noise:
        return None
    slope = np.where(u < at, -slope1, -slope2)
    jacobian = np.column_stack([columns, slope])
    cov = np.linalg.pinv(jacobian.T @ jacobian) * max(noise, 0.02) ** 2 * _neighbourly(y - columns @ [height, slope1, slope2])
    return at, float(height), float(slope1), float(slope2), float(np.sqrt(cov[3, 3])), float(noise)
