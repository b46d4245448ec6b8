"""Corners of a printed board → scale, distance and attitude of the camera that saw it.

A point of the board at (X, Y) mm, on a sheet that bends by (c X² + d Y²) / 2, lies at
R (X, Y, bend) + t before the camera (x to the right, y down, z forward) and is seen at

    principal point + f (1 + k r²) (x/z, y/z),   r = f √(x² + y²)/z over half a diagonal

All of it is fitted by least squares with priors, since one picture leaves some of it
open (a board seen straight on does not tell f, only z/f); every number's sd follows
from the fit's covariance (Zhang 2000, IEEE TPAMI 22, 1330, of one view)."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from benchtwin.bench.language import tr
from benchtwin.bench.priors import unstated_sd
from benchtwin.vision.board.corners import Corners, find_corners
from benchtwin.vision.motion.least_squares import slopes

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult

UPRIGHT = np.diag([1.0, -1.0, -1.0])  # of a board that is looked at straight on
USUAL_FOCAL = 0.75  # over the diagonal: 32 mm on a full frame
CORNER_PX = 0.03  # least error of a corner
SHEET_EDGE_MM = 1.0  # beside a sheet: its shadow
LOOSE_SD = 3.0  # beyond it a corner's weight falls
DOUBTFUL_SD = 0.03  # relative, of a scale
MOST_EVALUATIONS = 50  # of one least squares
BENT_CHI2 = 15.0  # by which a bent sheet fits better; of a flat one 5e-4 by chance
PARAMETERS = (
    *("ln_focal", "turn_x", "turn_y", "turn_z", "x", "y", "ln_distance"),
    *("distortion", "centre_x", "centre_y", "bend_x", "bend_y"),
)


@dataclass(frozen=True, eq=False)
class BoardView:
    """What a board tells of the picture that shows it; sds hold the corners' scatter,
    what one view leaves open, and the print's own error.

    fitted: values by name of PARAMETERS (lengths in units of the board's width or, in
    the picture, of half its diagonal); covariance: of these, in their order."""

    corners: Corners
    fitted: np.ndarray
    covariance: np.ndarray
    print_sd: float  # relative, of the printed lengths
    print_scale: float  # true length over nominal
    bent: bool  # its corners lie on no flat sheet

    @property
    def sheet_name(self) -> str:
        """A4, A5 or A6."""
        return self.corners.sheet.name

    def page_px(self, beyond_mm: float = 0.0) -> np.ndarray:
        """Where the sheet's corners are seen (4, 2), each moved outward by so much."""
        around = self.corners.sheet.page_mm_about_board(beyond_mm)
        return _project(self.fitted, around, self.corners)

    def mm_per_px(self) -> tuple[float, float]:
        """Scale at the picture's centre and its sd, of what stands or moves in an
        upright plane through the board: midway between the board's own plane and the
        one that faces the camera; half of what these differ by counts to the sd."""
        middle, sd = self.scale_of_fit()
        apart = float(np.ptp(self._scales(self.fitted))) / 2
        return middle, float(np.sqrt(sd**2 + apart**2 + (middle * self.print_sd) ** 2))

    def scale_of_fit(self) -> tuple[float, float]:
        """The same scale, and the sd of the fit alone."""
        middle, sd = self._with_sd(lambda p: self._scales(p).mean(keepdims=True))
        return float(middle[0]), float(sd[0])

    def distance_mm(self) -> tuple[float, float]:
        """Of the camera from the board along its axis, and its sd."""
        value, sd = self._with_sd(
            lambda p: _before_camera(p, np.zeros((1, 2)), self.corners)[0, 2:]
        )
        value = value * self.print_scale
        return float(value[0]), float(np.hypot(sd[0], value[0] * self.print_sd))

    def attitude_deg(self) -> dict[str, tuple[float, float]]:
        """Angles of the camera beside an upright board, with the fit's sds: `pitch`, by
        how much it looks down; `plumb`, direction of gravity in the picture, clockwise
        from straight down; `yaw`, by how much the board is turned about its upright."""
        values, sds = self._with_sd(_attitude)
        return {
            name: (float(v), float(s))
            for name, v, s in zip(("pitch", "plumb", "yaw"), values, sds, strict=True)
        }

    def at(self, x_px: ArrayLike, y_px: ArrayLike) -> np.ndarray:
        """mm per px of the board's plane at places of the picture: the geometric mean
        of all directions, √|det ∂(mm)/∂(px)|."""
        x, y = np.broadcast_arrays(np.asarray(x_px, float), np.asarray(y_px, float))
        return self._local_scale(self.fitted, x, y) * self.print_scale

    def sd_at(self, x_px: float, y_px: float) -> float:
        """One standard deviation of `at` [mm per px]."""
        x, y = np.array([x_px], float), np.array([y_px], float)
        value, sd = self._with_sd(lambda p: self._local_scale(p, x, y))
        return float(np.hypot(sd[0] * self.print_scale, value[0] * self.print_sd))

    def to_mm(self, x_px: ArrayLike, y_px: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Places on the board's plane [mm] of points of the picture [px]."""
        x, y = np.broadcast_arrays(np.asarray(x_px, float), np.asarray(y_px, float))
        u, v = _to_board(self.fitted, x, y, self.corners)
        return u * self.print_scale, v * self.print_scale

    @property
    def doubts(self) -> tuple[str, ...]:
        """What makes the scale doubtful."""
        value, sd = self.mm_per_px()
        share = f"{100 * sd / value:.0f} %"
        told = (
            (sd > DOUBTFUL_SD * value, tr("it tells the scale only to ± {}", share)),
            (self.bent, tr("it is bent: glue it to something flat")),
            (self.corners.mirrored, tr("the picture is a mirror image")),
            (
                self.corners.others,
                tr("there are several boards; the one that shows most is read"),
            ),
        )
        return tuple(why for holds, why in told if holds)

    def _scales(self, fitted: np.ndarray) -> np.ndarray:
        """mm per px at the picture's centre: in the board's plane, and in the one that
        has the same upright and faces the camera."""
        turned = Rotation.from_rotvec(fitted[1:4]).as_matrix() @ UPRIGHT
        middle = _before_camera(fitted, np.zeros((1, 2)), self.corners)[0]
        upright, forward = turned[:, 1], np.array([0.0, 0.0, 1.0])
        normals = np.stack([turned[:, 2], forward - upright[2] * upright])
        depth_mm = (normals @ middle) / (normals @ forward)
        f = np.exp(fitted[0]) * _half_diagonal(self.corners)
        return self.print_scale * depth_mm / f

    def _local_scale(self, fitted: np.ndarray, x: np.ndarray, y: np.ndarray):
        step = 0.5
        right, left, down, up = (
            np.stack(_to_board(fitted, x + dx, y + dy, self.corners))
            for dx, dy in ((step, 0), (-step, 0), (0, step), (0, -step))
        )
        (a, c), (b, d) = right - left, down - up
        return np.sqrt(np.abs(a * d - b * c))

    def _with_sd(
        self, value: Callable[[np.ndarray], np.ndarray]
    ) -> tuple[np.ndarray, np.ndarray]:
        """A function (m,) of the fitted parameters and its sds."""
        moved = slopes(value, self.fitted, np.sqrt(np.diag(self.covariance)))
        variance = np.einsum("ij,jk,ik->i", moved, self.covariance, moved)
        return value(self.fitted), np.sqrt(variance)


def read_board(image: np.ndarray, line_mm: float | None = None) -> BoardView:
    """Find the printed board in a picture and fit the camera that saw it.

    image: (h, w) or (h, w, 3), uint8 or uint16. line_mm: length of the sheet's line as
    measured on the print; None: a printer's usual error. MeasurementError where no
    board, or too little of it, is seen."""
    corners = find_corners(image)
    scale, sd = 1.0, unstated_sd("board-print")
    if line_mm is not None:
        scale = line_mm / corners.sheet.line_mm
        sd = unstated_sd("board-line") / corners.sheet.line_mm
    bent, error_px = _fits(corners, unstated_sd("board-bent"), _starts(corners))
    sides = [found.x for found in bent]
    flat, _ = _fits(corners, unstated_sd("board-bend"), sides, error_px)
    is_bent = 2 * (flat[0].cost - bent[0].cost) > BENT_CHI2
    best, other = bent if is_bent else flat
    # to the better fit's covariance the other adds as much as it is probable
    share = 1 / (1 + np.exp(min(other.cost - best.cost, 500.0)))
    apart = np.outer(other.x - best.x, other.x - best.x)
    covariance = np.linalg.inv(best.jac.T @ best.jac) + share * apart
    return BoardView(corners, best.x, covariance, sd, scale, is_bent)


def _fits(
    corners: Corners,
    bend_sd: float,
    starts: list[np.ndarray],
    error_px: float | None = None,
) -> "tuple[list[OptimizeResult], float]":
    """The better fit, and the one on the other side (a distant board that leans towards
    the camera looks as one that leans away by as much); the error of a corner."""
    fits = [_fit(corners, bend_sd, start, error_px) for start in starts]
    error_px = min(px for _, px in fits)
    again = [_fit(corners, bend_sd, f.x, error_px)[0] for f, _ in fits]
    return sorted(again, key=lambda found: found.cost), error_px


def _fit(
    corners: Corners,
    bend_sd: float,
    start: np.ndarray,
    error_px: float | None = None,
) -> "tuple[OptimizeResult, float]":
    """The fitted parameters, and the error of a corner, which is read off what the fit
    leaves where it is not given."""
    from scipy.optimize import least_squares  # loads for .3 s

    believed = {
        "ln_focal": (np.log(2 * USUAL_FOCAL), unstated_sd("focal-length")),
        "distortion": (0.0, unstated_sd("board-lens")),
        "centre_x": (0.0, unstated_sd("principal-point")),
        "centre_y": (0.0, unstated_sd("principal-point")),
        # a sheet that bends by b widths in its middle has a curvature of 8 b over that
        "bend_x": (0.0, 8 * bend_sd),
        "bend_y": (0.0, 8 * bend_sd),
    }
    held = [PARAMETERS.index(name) for name in believed]
    centre, sd = np.array(list(believed.values())).T

    def off(p: np.ndarray, error_px: float) -> np.ndarray:
        rows = (_project(p, corners.board_mm, corners) - corners.picture_px) / error_px
        weight = np.sqrt(np.minimum(1, LOOSE_SD / np.hypot(*rows.T).clip(1e-9)))
        return np.append((weight[:, None] * rows).ravel(), (p[held] - centre) / sd)

    given = error_px
    error_px = given or CORNER_PX
    for _ in range(1 if given else 3):
        found = least_squares(
            off, start, x_scale="jac", max_nfev=MOST_EVALUATIONS, args=(error_px,)
        )
        start = found.x
        if not given:
            left = _project(start, corners.board_mm, corners) - corners.picture_px
            freedom = max(left.size - len(PARAMETERS) + len(held), 1)
            error_px = float(np.hypot(CORNER_PX, np.sqrt((left**2).sum() / freedom)))
    return found, error_px


def _starts(corners: Corners) -> list[np.ndarray]:
    """Both attitudes of a flat board before a camera of a usual focal length (Collins &
    Bartoli 2014, Int. J. Comput. Vis. 109, 252)."""
    half, width = _half_diagonal(corners), corners.sheet.size_mm[0]
    focal, (high, wide) = 2 * USUAL_FOCAL, corners.shape
    camera = [[focal * half, 0, (wide - 1) / 2], [0, focal * half, (high - 1) / 2]]
    flat = np.column_stack([corners.board_mm / width, np.zeros(len(corners.board_mm))])
    _, turns, places, _ = cv2.solvePnPGeneric(
        flat,
        corners.picture_px,
        np.array([*camera, [0, 0, 1]]),
        None,
        flags=cv2.SOLVEPNP_IPPE,
    )
    starts = []
    for seen, place in zip(turns, places, strict=True):
        turned = Rotation.from_matrix(cv2.Rodrigues(seen)[0] @ UPRIGHT)
        x, y, z = np.ravel(place)
        attitude = [np.log(focal), *turned.as_rotvec(), x, y, np.log(max(z, 1e-6))]
        starts.append(np.append(attitude, np.zeros(len(PARAMETERS) - len(attitude))))
    return starts


def _half_diagonal(corners: Corners) -> float:
    return float(np.hypot(*corners.shape) / 2)


def _before_camera(p: np.ndarray, board_mm: np.ndarray, corners: Corners) -> np.ndarray:
    """Points (n, 3) before the camera [mm]."""
    width = corners.sheet.size_mm[0]
    flat = board_mm / width
    bend = (flat**2 @ p[10:12]) / 2
    turned = Rotation.from_rotvec(p[1:4]).as_matrix() @ UPRIGHT
    place = np.array([p[4], p[5], np.exp(p[6])])
    return width * (np.column_stack([flat, bend]) @ turned.T + place)


def _project(p: np.ndarray, board_mm: np.ndarray, corners: Corners) -> np.ndarray:
    """Where points of the board are seen (n, 2) [px]."""
    x, y, z = _before_camera(p, board_mm, corners).T
    seen = np.exp(p[0]) * np.column_stack([x, y]) / z.clip(1e-6)[:, None]
    seen = seen * (1 + p[7] * (seen**2).sum(1))[:, None] + p[8:10]
    return seen * _half_diagonal(corners) + (np.array(corners.shape[::-1]) - 1) / 2


def _to_board(
    p: np.ndarray, x_px: np.ndarray, y_px: np.ndarray, corners: Corners
) -> tuple[np.ndarray, np.ndarray]:
    """Places on the flat board [mm] that are seen at places of the picture."""
    height, width = corners.shape
    half = _half_diagonal(corners)
    u = (x_px - (width - 1) / 2) / half - p[8]
    v = (y_px - (height - 1) / 2) / half - p[9]
    straight = 1.0
    for _ in range(4):
        straight = 1 + p[7] * (u * u + v * v) / straight**2
    rays = np.stack([u / straight, v / straight, np.full_like(u, np.exp(p[0]))])
    turned = Rotation.from_rotvec(p[1:4]).as_matrix() @ UPRIGHT
    place = np.array([p[4], p[5], np.exp(p[6])])
    along = turned.T @ rays.reshape(3, -1)
    origin = turned.T @ place
    hit = along * (origin[2] / along[2]) - origin[:, None]
    side = corners.sheet.size_mm[0]
    return side * hit[0].reshape(u.shape), side * hit[1].reshape(u.shape)


def _attitude(p: np.ndarray) -> np.ndarray:
    """Pitch, plumb, yaw [deg]."""
    turned = Rotation.from_rotvec(p[1:4]).as_matrix() @ UPRIGHT
    down = -turned[:, 1]
    facing = turned[:, 2]  # out of the board, towards who looks at it
    return np.degrees(
        [
            np.arcsin(np.clip(down[2], -1, 1)),
            np.arctan2(-down[0], down[1]),
            np.arctan2(facing[0], -facing[2]),
        ]
    )


def sheet_mask(shape: tuple[int, ...], board: BoardView) -> np.ndarray:
    """Where the board's sheet is in a picture of this shape, and a little around it."""
    around = np.rint(board.page_px(beyond_mm=SHEET_EDGE_MM)).astype(np.int32)
    return cv2.fillConvexPoly(np.zeros(shape, np.uint8), around, 1) > 0


def without_sheet(image: np.ndarray, board: BoardView) -> np.ndarray:
    """The picture with the board's sheet taken out: each row goes on from what lies on
    one side of it to what lies on the other."""
    mask = sheet_mask(image.shape[:2], board)
    bare, width = image.copy(), image.shape[1]
    for row in np.flatnonzero(mask.any(1)):
        inside = np.flatnonzero(mask[row])
        left, right = inside[0] - 1, inside[-1] + 1
        left, right = (left, right) if left >= 0 else (right, right)
        right = right if right < width else left
        if not 0 <= left < width:
            continue  # the sheet fills the row
        share = (inside - left) / max(right - left, 1)
        ends = image[row, [left, right]].astype(float)
        mixed = np.multiply.outer(1 - share, ends[0]) + np.multiply.outer(
            share, ends[1]
        )
        bare[row, inside] = mixed.astype(image.dtype)
    return bare
