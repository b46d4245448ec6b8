"""A picture → which board it shows, and where the board's corners are in it."""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from benchtwin.bench.language import tr
from benchtwin.vision.board.sheet import DICTIONARY, SHEETS, Sheet
from benchtwin.vision.measurement import MeasurementError, require

SMALLEST_PX = 32
LARGEST_PX = 2400  # longest side in which markers are looked for
FEWEST = 6  # corners that tell a camera's place
FEWEST_MARKERS = 2  # one alone may be a chance pattern


class NoBoard(MeasurementError):
    """The picture shows no board."""

    def __init__(self) -> None:
        super().__init__(
            tr("no printed board is in the picture (benchtwin board makes one)")
        )


@dataclass(frozen=True, eq=False)
class Corners:
    """Corners of one board. board_mm, picture_px: places (n, 2) on the board and in the
    picture (x to the right; y upward on the board, downward in the picture); mirrored:
    it reads only in a mirror; others: further boards in the picture."""

    sheet: Sheet
    board_mm: np.ndarray
    picture_px: np.ndarray
    shape: tuple[int, int]  # height and width of the picture
    mirrored: bool = False
    others: int = 0


def find_corners(image: np.ndarray) -> Corners:
    """The corners of the board that shows most of them.

    image: (h, w) or (h, w, 3), uint8 or uint16. MeasurementError where no board shows
    FEWEST corners."""
    grey = _grey(image)
    found = _corners_in(grey)
    if found is None or len(found.board_mm) < FEWEST:
        seen = _corners_in(grey[:, ::-1].copy())
        if seen is not None and len(seen.board_mm) >= FEWEST:
            picture = seen.picture_px * [-1, 1] + [grey.shape[1] - 1, 0]
            found = replace(seen, picture_px=picture, mirrored=True)
    if found is None:
        raise NoBoard
    about = found.board_mm - found.board_mm.mean(0) if len(found.board_mm) else []
    require(
        len(about) >= FEWEST and np.linalg.matrix_rank(about) >= 2,
        tr(
            "of the board in the picture {} corners are seen; {} in two rows tell its"
            " place: nearer, sharper or less covered",
            len(about),
            FEWEST,
        ),
    )
    return found


def _grey(image: np.ndarray) -> np.ndarray:
    if image.dtype == np.uint16:
        image = (image >> 8).astype(np.uint8)
    if image.dtype != np.uint8 or min(image.shape[:2]) < SMALLEST_PX:
        raise NoBoard
    if image.ndim == 3 and image.shape[2] == 3:
        return cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    return np.ascontiguousarray(image if image.ndim == 2 else image[..., 0])


def _corners_in(grey: np.ndarray) -> Corners | None:
    """Markers in a reduced picture, corners between them in the full one."""
    factor = min(1.0, LARGEST_PX / max(grey.shape))
    small = grey
    if factor < 1:
        size = [round(factor * side) for side in grey.shape[::-1]]
        small = cv2.resize(grey, size, interpolation=cv2.INTER_AREA)
    exact = cv2.aruco.DetectorParameters()
    exact.errorCorrectionRate = 0.0  # else a mirrored marker may pass for another
    quads, ids, _ = cv2.aruco.ArucoDetector(DICTIONARY, exact).detectMarkers(small)
    if ids is None:
        return None
    quads = [((q + 0.5) / factor - 0.5).astype(np.float32) for q in quads]
    ids = ids.ravel()
    shown = {name: np.isin(ids, s.board.getIds()) for name, s in SHEETS.items()}
    name = max(shown, key=lambda n: shown[n].sum())
    sheet, which = SHEETS[name], np.flatnonzero(shown[name])
    if len(which) < FEWEST_MARKERS:
        return None
    larger = sorted(which, key=lambda k: -cv2.contourArea(quads[k]))
    single = {int(ids[k]): k for k in reversed(larger)}  # the larger of two alike
    kept = list(single.values())
    others = sum(mask.sum() > 1 for n, mask in shown.items() if n != name)
    others += len(which) > len(kept)
    detector = cv2.aruco.CharucoDetector(sheet.board)
    corners, numbers, _, _ = detector.detectBoard(
        grey, markerCorners=[quads[k] for k in kept], markerIds=ids[kept][:, None]
    )
    numbers, corners = ([], []) if numbers is None else (numbers.ravel(), corners)
    board = sheet.corners_mm()[np.asarray(numbers, int)]
    picture = np.asarray(corners, float).reshape(-1, 2)
    return Corners(sheet, board, picture, grey.shape, others=int(others))
