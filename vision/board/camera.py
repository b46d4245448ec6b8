"""What a printed board in the picture tells of a recording's camera: what is not stated
is taken from it, what is stated is held against it."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from benchtwin.bench.keys import Camera
from benchtwin.bench.language import tr
from benchtwin.bench.numbers import plus_minus
from benchtwin.bench.priors import unstated_sd
from benchtwin.vision.board.corners import NoBoard
from benchtwin.vision.board.view import BoardView, read_board, without_sheet
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.recording import Recording, with_camera

DISAGREES = 3.0  # sds
KNOWN_DISTANCE = 0.05  # relative sd of a distance that is worth stating
KNOWN_PITCH_DEG = 3.0  # sd, above which a board does not say how it is looked at
TURNED_DEG = 5.0


@dataclass(frozen=True)
class Told:
    """A number of the camera that a board tells; sd_key: where its sd is stated."""

    key: str
    sd_key: str
    value: float
    sd: float
    unit: str


@dataclass(frozen=True)
class Completed:
    """A recording whose camera a board has told, and its picture without the board's
    sheet; doubt: of every number that is read off it, "" where there is none."""

    recording: Recording
    picture: np.ndarray
    notes: tuple[str, ...] = ()
    doubt: str = ""
    board: BoardView | None = None


def with_board(recording: Recording, picture: np.ndarray) -> Completed:
    """The recording with what the board in its picture (uint8 or uint16, grey or RGB)
    tells of the camera."""
    camera = recording.camera
    try:
        board = read_board(picture, camera.board_line_mm)
    except MeasurementError as error:
        expected = camera.board_line_mm is not None or not isinstance(error, NoBoard)
        return Completed(recording, picture, (str(error),) if expected else ())
    bare = without_sheet(picture, board)
    if board.doubts:
        note = tr("the printed board in the picture tells nothing: {}", board.doubts[0])
        return Completed(recording, bare, (note,), board=board)
    told = {t.key: t for t in told_by(board)}
    against = [
        _disagreement(t, camera)
        for t in told.values()
        if getattr(camera, t.key) is not None
    ]
    keys: dict[str, float] = {}
    for t in told.values():
        if getattr(camera, t.key) is None:
            keys |= {t.key: t.value} | ({t.sd_key: t.sd} if t.sd_key else {})
    doubt = "; ".join(words for words in against if words)
    completed = with_camera(recording, **keys)
    return Completed(completed, bare, (_in_words(board),), doubt, board)


def told_by(board: BoardView) -> Iterable[Told]:
    """What an upright board tells; its own foot's and back's errors are in the sds."""
    lean = unstated_sd("board-lean")
    angles = {
        name: (value, float(np.hypot(sd, lean)))
        for name, (value, sd) in board.attitude_deg().items()
    }
    yield Told("mm_per_px", "mm_per_px_sd", *board.mm_per_px(), tr("mm per px"))
    yield Told("plumb_deg", "plumb_sd_deg", *angles["plumb"], "deg")
    if angles["pitch"][1] < KNOWN_PITCH_DEG:
        yield Told("pitch_deg", "pitch_sd_deg", *angles["pitch"], "deg")
    distance, sd = board.distance_mm()
    if sd < KNOWN_DISTANCE * distance:
        yield Told("distance_mm", "", distance, sd, "mm")


def _disagreement(told: Told, camera: Camera) -> str:
    """What is to be said where a stated number and the board's differ, else ""."""
    stated = getattr(camera, told.key)
    sds = camera.used_sds | {"": KNOWN_DISTANCE * stated}
    apart = abs(stated - told.value) / np.hypot(told.sd, sds[told.sd_key])
    if apart < DISAGREES:
        return ""
    return tr(
        "[camera] {} = {:g} is stated, and the board in the picture says {} ({:.1f} sds"
        " apart)",
        told.key,
        stated,
        plus_minus(told.value, told.sd, told.unit),
        apart,
    )


def _in_words(board: BoardView) -> str:
    angles, (scale, sd) = board.attitude_deg(), board.mm_per_px()
    turned = abs(angles["yaw"][0])
    pitch, pitch_sd = angles["pitch"]
    down = tr("looking down by {:.1f}°, ", pitch) * (pitch_sd < KNOWN_PITCH_DEG)
    aside = tr("; it is turned by {:.0f}°", turned) if turned > TURNED_DEG else ""
    return tr(
        "a printed board ({}, {} corners) tells the camera: {}, {}gravity {:+.2f}° from"
        " straight down{}",
        board.sheet_name,
        len(board.corners.board_mm),
        plus_minus(scale, sd, "mm per px"),
        down,
        angles["plumb"][0],
        aside,
    )
