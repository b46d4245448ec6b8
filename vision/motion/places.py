"""Places of the seed that somebody set by hand, frame by frame, where the tracker fails
or errs."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from benchtwin.bench.keys import Tracking
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.motion.track import Track, make_track

LEAST_PLACES = 4  # that make a track of their own: a parabola and one to check it
# sd of a click on the middle of a seed, each way; fits that scale their errors by what
# is left over find the true one
PLACE_SD_PX = 1.0

Places = Mapping[int, tuple[float, float]]  # frame → x, y [px]


def places_of(stated: Tracking) -> Places:
    """The places that a recording states [y down]; MeasurementError for two of one
    frame."""
    places = {int(frame): (x, y) for frame, x, y in stated.places_px or ()}
    if len(places) < len(stated.places_px or ()):
        raise MeasurementError("[track] places_px: two places of one frame; keep one")
    return places


def with_places(track: Track, places: Places, times: Mapping[int, float]) -> Track:
    """The track with the places instead of what was found in their frames;
    without orientation there. times: of every frame of the film. y counts up from the
    bottom row in both."""
    kept = track.take(~np.isin(track.frame, [*places]))
    hand = track_of_places(places, times)
    blank = np.full(len(hand), np.nan)
    order = np.argsort(np.concatenate([kept.frame, hand.frame]), kind="stable")
    columns = ("frame", "t_s", "x", "y", "sd", "outlier")
    joined: dict[str, Any] = {
        c: np.concatenate([getattr(kept, c), getattr(hand, c)])[order] for c in columns
    }
    joined |= {
        c: np.concatenate([values, blank])[order]
        for c in ("angle_deg", "angle_sd_deg")
        if (values := getattr(kept, c)) is not None
    }
    return replace(track, notes=(*track.notes, *hand.notes), **joined)


def upside_down(places: Places, height: int) -> Places:
    """The same with y counted from the other end of a picture `height` px high."""
    return {frame: (x, height - 1 - y) for frame, (x, y) in places.items()}


def track_of_places(places: Places, times: Mapping[int, float]) -> Track:
    """The places alone as a track [px, y up]. MeasurementError for a frame that the
    film has not."""
    if missing := sorted(places.keys() - times.keys()):
        raise MeasurementError(
            f"[track] places_px: the film has no frame {missing[0]}; it has"
            f" {min(times, default=0)} to {max(times, default=0)}"
        )
    frames = sorted(places)
    x, y = np.array([places[f] for f in frames]).T
    n = len(frames)
    return make_track(
        [times[f] for f in frames],
        x,
        y,
        unit="px",
        frame=np.array(frames),
        sd=PLACE_SD_PX,
        notes=(f"{n} place{'' if n == 1 else 's'} set by hand",),
    )
