"""What overlays say can be read at the size at which pages show them."""

import cv2
import numpy as np
import pytest

from benchtwin.vision.overlay.canvas import SHOWN_PX, WHITE, Canvas, letters, wrapped
from benchtwin.vision.overlay.plot import plot

CAPITAL_PX = 8  # of letters of 12 px


def as_shown(picture: np.ndarray) -> np.ndarray:
    scale = SHOWN_PX / max(picture.shape[:2])
    return cv2.resize(
        picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA
    ).astype(int)


@pytest.mark.parametrize(
    "shape", [(60, 90), (700, 1900), (1900, 350), (900, 900), (3000, 4000)]
)
def test_a_legend_has_letters_of_twelve_pixels_on_a_picture_of_any_size(shape):
    canvas = Canvas(np.zeros((*shape, 3), np.uint8))
    canvas.legend([("HHH", WHITE)])
    rows = np.flatnonzero(as_shown(canvas.pixels).max(axis=(1, 2)) > 120)
    assert CAPITAL_PX <= np.ptp(rows) + 1 <= 2 * CAPITAL_PX


@pytest.mark.parametrize("size", [(960, 620), (1600, 1000)])
def test_a_plot_has_letters_of_twelve_pixels(size):
    """Its caption, which stands first."""
    picture = as_shown(
        plot(
            [0, 1], [0, 1], [False, False], labels=("t", "x"), caption="HHH", size=size
        )
    )
    rows = np.flatnonzero(picture.min(axis=(1, 2)) < 120)
    assert CAPITAL_PX <= np.flatnonzero(np.diff(rows) > 1)[0] + 1 <= 2 * CAPITAL_PX


def test_long_lines_are_wrapped_to_the_room_that_there_is():
    text = (
        "restitution 0.4927 ± 0.0008; the release is not in the track: [drop] height_mm"
        " is needed"
    )
    lines = wrapped(text, 500, 2.0)
    assert len(lines) > 2 and " ".join(line.strip() for line in lines) == text
    assert max(map(letters(2.0).getlength, lines)) < 1.15 * 500


def test_what_lies_far_outside_or_is_unknown_costs_no_picture():
    """A plate's line of a film held sideways may be upright: its ends lie 1e18 px
    away."""
    canvas = Canvas(np.zeros((300, 400, 3), np.uint8))
    canvas.curve([200 - 9, 200 + 9], [150 - 1e18, 150 + 1e18], WHITE)
    assert canvas.pixels[:, canvas.pixels.shape[1] // 2 - 3 :][:, :6].max() == 255
    plain = canvas.pixels.copy()
    canvas.curve([np.nan, 9], [0, 9], WHITE)
    canvas.ring(np.nan, 5, WHITE)
    canvas.ring(1e12, 5, WHITE)
    canvas.cross(5, np.inf, WHITE)
    canvas.polygon(np.array([[np.nan, 1], [1e15, 1e15], [1e15, 2e15]]), WHITE)
    canvas.curve(np.array([1e14, 2e14, np.nan]), np.array([0, 5, 9.0]), WHITE)
    assert (canvas.pixels == plain).all()


def test_a_plot_shows_its_points_and_leaves_outliers_where_they_are():
    """An outlier far away costs the others no room."""
    x = np.linspace(0, 1, 200)
    y = np.append(x[:-1] ** 2, 1e9)
    picture = plot(x, y, y > 2, labels=("t", "x"), curves=[(x, x**2)]).astype(int)
    blue = (picture[..., 2] - picture[..., 0] > 80) & (picture[..., 1] > 100)
    rows, columns = np.nonzero(blue)
    assert np.ptp(rows) > 0.6 * picture.shape[0]
    assert np.ptp(columns) > 0.7 * picture.shape[1]
