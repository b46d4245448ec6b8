"""Path of a rolling seed in the picture: two straight legs, incline and level, and the
travel along them."""

from dataclasses import dataclass, replace

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.bench.priors import stated_sd
from benchtwin.vision.motion.track import Track
from benchtwin.vision.recording import Recording

# between the bend of the path and the stated incline: more means that the track is not
# the seed's alone
MOST_BEND_ERROR_DEG = 4.0
# of the seed's size: places farther off the legs are not the centre of the seed alone
MOST_RMS = 0.05
SHARP_PX = 0.3  # noise of a place, which the fit along the path allows for


# of a path by which a roll is told: rows; rms about its legs, of its length; angle of
# the incline against what it leads to; of the speed at its foot, that at the end
TOLD_BY_ROWS, EVEN, LEAST_SLOPE_DEG, SLOWS = 12, 0.02, 4.0, 0.7
LEAST_ROWS = 4
ENOUGH_ROWS = 30  # that tell by their times whether a seed still speeds up
LEAST_LATE = 10  # of them, in the second half of its path
SURE_SDS = 5.0


@dataclass(frozen=True)
class RollPath:
    """A roll's track with x along the path (0 where the legs meet), in px, y up.
    junction: (place, sd) along the path, None where it is not in the picture; legs:
    their end points; doubt: "" for none."""

    track: Track
    junction: tuple[float, float] | None
    legs: list
    notes: tuple[str, ...]
    doubt: str = ""

    def marks(self, stop: float | None) -> list:
        """Places of the junction and the stop in the picture [px, y up]."""
        if not self.legs:
            return []
        start, end = (np.array(p) for p in self.legs[-1])
        places = [tuple(start)]
        if stop is not None:
            along = (end - start) / max(float(np.hypot(*(end - start))), 1e-9)
            shift = 0.0 if self.junction is None else self.junction[0]
            places.append(tuple(start + along * (stop - shift)))
        return places


def roll_path(track: Track, size: float, recording: Recording) -> RollPath:
    """Fit two straight legs to the places of a rolling seed and give its travel along
    them [px]; size: its diameter [px]. The centroid turns r tan(Δ/2) beyond the
    junction of the plates (r: its height above the plate, Δ: the angle between the
    legs), so the junction lies that far before the point where the legs meet."""
    used = track.used()
    sign = 1.0 if used.x[-1] >= used.x[0] else -1.0
    u, y = sign * used.x, used.y
    two_legs, incline_deg = _fit_two_legs(u, y), recording.roll.incline_deg
    if two_legs is None:
        axes = np.linalg.svd(
            np.column_stack([u - u.mean(), y - y.mean()]), full_matrices=False
        )[2]
        direction = axes[0] * np.sign(axes[0][0])
        along = (sign * track.x - u.mean()) * direction[0] + (
            track.y - y.mean()
        ) * direction[1]
        note = tr("the picture shows one straight leg only: the junction is not seen")
        doubt = (
            ""
            if (incline_deg or 0.0) < MOST_BEND_ERROR_DEG
            else tr("[roll] incline_deg says {:g}°, {}", incline_deg, note)
        )
        return RollPath(
            replace(track, x=along, y=np.zeros(len(track))), None, [], (note,), doubt
        )
    at, height, slope_incline, slope_level, sd, rms = two_legs
    turn = abs(np.arctan(slope_incline) - np.arctan(slope_level))
    legs = [
        np.array([1, slope]) / np.hypot(1, slope)
        for slope in (slope_incline, slope_level)
    ]
    offset = np.column_stack([sign * track.x - at, track.y - height])
    along = np.where(offset[:, 0] < 0, offset @ legs[0], offset @ legs[1])
    corner_shift = size / 2 * np.tan(turn / 2)
    notes = [
        tr("the legs meet at an angle of {:.2f}° in the picture", np.degrees(turn))
    ]
    doubt = ""
    if incline_deg is not None and abs(np.degrees(turn) - incline_deg) > 1.5:
        notes.append(
            tr(
                "[roll] incline_deg says {:g}°: check it, or the camera's view",
                incline_deg,
            )
        )
        if abs(np.degrees(turn) - incline_deg) > MOST_BEND_ERROR_DEG:
            doubt = tr(
                "the legs of the path meet at {:.1f}°, [roll] incline_deg says {:g}°",
                np.degrees(turn),
                incline_deg,
            )
    start = (sign * u.min(), height + slope_incline * (u.min() - at))
    end = (sign * u.max(), height + slope_level * (u.max() - at))
    corner = (sign * at, height)
    path = replace(track, x=along, y=np.zeros(len(track)))
    rocks = _rocking_px(recording)
    if rms > MOST_RMS * size + rocks:
        text = tr(
            "the places lie {:.2g} px off the straight legs: a shadow or a mirror image"
            " is taken for a part of the seed",
            rms,
        )
        doubt = f"{doubt}; {text}" if doubt else text
    # Places are assumed to err along the legs as much as across them; the rocking of an
    # oblong seed is no error.
    sd = float(
        np.hypot(
            np.hypot(sd, 0.1 * corner_shift),
            max(rms - rocks - SHARP_PX, 0.0) * np.sqrt(2),
        )
    )
    return RollPath(
        path, (-corner_shift, sd), [(start, corner), (corner, end)], tuple(notes), doubt
    )


def rolls(time: np.ndarray, x: np.ndarray, y: np.ndarray) -> str:
    """Why a motion, y up, is a roll's: down an incline, and slower on what follows; ""
    where it is none's."""
    if len(time) < TOLD_BY_ROWS or np.ptp(x) < np.ptp(y):
        return ""
    u = x if x[-1] >= x[0] else -x
    if (legs := _fit_two_legs(u, y)) is None:
        return ""
    corner, _, *slopes, _, rms = legs
    down = -np.degrees(np.arctan(slopes))
    if rms > EVEN * np.hypot(np.ptp(x), np.ptp(y)) or -np.diff(down) < LEAST_SLOPE_DEG:
        return ""
    speed = np.hypot(np.gradient(x, time), np.gradient(y, time))
    at, reach = int(np.argmax(u >= corner)), max(3, len(time) // 20)
    slows = np.median(speed[-reach:]) < SLOWS * np.median(speed[at : at + reach])
    steep = f"{down[0] - down[1]:.0f}°"
    return tr("it comes down an incline of {} and slows", steep) if slows else ""


def _rocking_px(recording: Recording) -> float:
    """rms height by which the centre of an oblong seed rises and falls as it rolls
    [px]; 0 where axes or scale are not stated."""
    axes = recording.seed.sizes_mm
    if not recording.camera.mm_per_px or not axes:
        return 0.0
    return (max(axes) - min(axes)) / 2 / 2 / np.sqrt(2) / recording.camera.mm_per_px


def _variance_inflation(left: np.ndarray) -> float:
    """Factor of a fit's variance due to correlated residuals: (1 + ρ)/(1 − ρ), ρ the
    correlation of successive places."""
    rho = float(
        np.clip((left[1:] @ left[:-1]) / max(float(left @ left), 1e-12), 0.0, 0.95)
    )
    return (1 + rho) / (1 - rho)


def _fit_two_legs(
    u: np.ndarray, y: np.ndarray
) -> tuple[float, float, float, float, float, float] | None:
    """Least squares of two legs that meet: x, y of the corner, both slopes, sd of x,
    rms of the residuals. None where a single line fits about as well."""
    order = np.argsort(u)
    u, y = u[order], y[order]
    spaced = np.searchsorted(
        u, np.linspace(u[0], u[-1], 400)
    )  # rows at rest count once
    rows = np.unique(spaced.clip(0, len(u) - 1))
    u, y = u[rows], y[rows]
    if len(u) < 8:
        return None

    def design(at):
        return np.column_stack(
            [np.ones(len(u)), np.minimum(u - at, 0), np.maximum(u - at, 0)]
        )

    def misfit(at):
        columns = design(at)
        return float(
            ((y - columns @ np.linalg.lstsq(columns, y, rcond=None)[0]) ** 2).sum()
        )

    grid = np.linspace(u[2], u[-3], 300)
    costs = [misfit(g) for g in grid]
    best = int(np.argmin(costs))
    fine = np.linspace(grid[max(best - 1, 0)], grid[min(best + 1, 299)], 41)
    at = float(fine[int(np.argmin([misfit(g) for g in fine]))])
    columns = design(at)
    height, slope_incline, slope_level = np.linalg.lstsq(columns, y, rcond=None)[0]
    noise = np.sqrt(misfit(at) / max(len(u) - 4, 1))
    bend = abs(np.arctan(slope_incline) - np.arctan(slope_level))
    line = np.polyfit(u, y, 1)
    straight = np.sqrt(np.mean((y - np.polyval(line, u)) ** 2))
    if bend < np.radians(2) or straight < 3 * noise:
        return None
    slope = np.where(u < at, -slope_incline, -slope_level)
    jacobian = np.column_stack([columns, slope])
    variance = max(noise, 0.02) ** 2 * _variance_inflation(
        y - columns @ [height, slope_incline, slope_level]
    )
    cov = np.linalg.pinv(jacobian.T @ jacobian) * variance
    return (
        at,
        float(height),
        float(slope_incline),
        float(slope_level),
        float(np.sqrt(cov[3, 3])),
        float(noise),
    )


def stays_on_incline(track: Track, recording: Recording) -> bool:
    """Whether all rows of a roll are on its incline: as stated or, where only its
    length is stated, or nothing, by the rows."""
    if recording.roll.level is not None:
        return not recording.roll.level
    length = recording.roll.incline_length_mm
    if not track.physical or len(track) < LEAST_ROWS:
        return False
    if length is None:
        return len(track) >= ENOUGH_ROWS and _speeds_up_to_its_end(track)
    if len(track) >= ENOUGH_ROWS:
        return ends_on_incline(track.t_s, track.x, length)
    along = np.abs(track.x - track.x[0])
    return bool(
        along.max() <= length + stated_sd("way-on-incline")
        and np.polyfit(track.t_s - track.t_s[0], along, 2)[0] > 0
    )


def _speeds_up_to_its_end(track: Track) -> bool:
    """Whether a seed accelerates over the second half of its path, SURE_SDS beyond what
    its rows' noise would feign: on a level plate it slows down there."""
    along = np.abs(track.x - track.x[0])
    late = along > along.max() / 2
    if late.sum() < LEAST_LATE or not ends_on_incline(track.t_s, track.x, np.inf):
        return False
    time = track.t_s[late] - track.t_s[late].mean()
    columns = np.vander(time, 3)
    fitted = np.linalg.lstsq(columns, along[late], rcond=None)[0]
    left = along[late] - columns @ fitted
    variance = left @ left / (len(left) - 3) * _variance_inflation(left)
    sd = np.sqrt(variance * np.linalg.inv(columns.T @ columns)[0, 0])
    return bool(fitted[0] > SURE_SDS * sd)


def ends_on_incline(time: np.ndarray, x: np.ndarray, incline_length_mm: float) -> bool:
    """Whether a seed did not leave the incline: its path, time [s] and x [mm] (n,), is
    no longer, and it was still accelerating. That is, the last quarter of the path took
    less time than the quarter before."""
    length_mm = np.maximum.accumulate(np.abs(x - x[0]))
    if not 0 < length_mm[-1] <= incline_length_mm + stated_sd("way-on-incline"):
        return False
    # of each place, when it was there first
    first = np.unique(length_mm, return_index=True)[1]
    half, later, last = np.interp(
        np.array([0.5, 0.75, 1.0]) * length_mm[-1], length_mm[first], time[first]
    )
    return bool(last - later < later - half)
