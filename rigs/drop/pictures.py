"""One drop as recorded and as both simulations fly it: in one picture, and filmed and
tracked."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from benchtwin.bench.air import stated_sizes_mm
from benchtwin.bench.language import tr
from benchtwin.diagnose.rerun import Comparison, Resimulation, differences
from benchtwin.rigs.drop.filmed import Seed, camera_for, followed, moments
from benchtwin.twin.paths import beside

MOMENTS = 11  # in one picture
FRAMES = 160  # of a film, at most
# a recorded place is the mean of what is left within as much of it, about the new
# twin's path
SMOOTH_S = 4e-3


def with_pictures(
    again: Resimulation,
    flown,
    old: np.ndarray,
    new: np.ndarray,
    folder: Path,
    pictures: bool,
    say,
) -> Resimulation:
    """`again` with a picture of the most improved recording, and optionally tracked
    films."""
    s = flown.session
    better = ((s.places - old) ** 2 - (s.places - new) ** 2).sum(axis=1)
    gain = [
        (
            float(better[own].sum())
            if (own := s.recording[s.flight] == r).any()
            else -np.inf
        )
        for r in range(len(s.names))
    ]
    r = int(np.argmax(gain))
    rows = np.flatnonzero(s.recording[s.flight] == r)
    rows = rows[np.argsort(s.middle[s.flight[rows]] + s.tau[rows])]
    seen = {
        "recording": smoothed(s, rows, new),
        "old twin": old[rows],
        "new twin": new[rows],
    }
    say(tr("drop: drawing {}", s.names[r]))
    caption = tr(
        "{} at {} moments: where it was recorded, where the old twin is, and the new"
        " twin with {}; right: what differs between recording and twin, brightened",
        s.names[r],
        MOMENTS,
        tr(" and ").join(again.effects),
    )
    drawn = replace(again, picture=strobe(flown, r, rows, seen), caption=caption)
    if not pictures:
        return drawn
    filmed = tuple(_filmed(flown, r, rows, seen, folder, say))
    how = tr(
        "{}; the old and the new twin of {} were also rendered, and followed by the"
        " code that measures films",
        again.how,
        s.names[r],
    )
    return replace(drawn, compared=(*again.compared, *filmed), how=how)


def smoothed(s, rows: np.ndarray, new: np.ndarray) -> np.ndarray:
    """Recorded places (m, 2), frame-to-frame noise averaged out flight by flight."""
    out = np.empty((len(rows), 2))
    time, left = s.middle[s.flight[rows]] + s.tau[rows], (s.places - new)[rows]
    for f in np.unique(s.flight[rows]):
        own = np.flatnonzero(s.flight[rows] == f)
        near = np.abs(time[own][:, None] - time[own][None, :]) <= SMOOTH_S
        out[own] = new[rows][own] + (near @ left[own]) / near.sum(1, keepdims=True)
    return out


def _seed(flown, r: int, rows: np.ndarray, places: np.ndarray) -> Seed:
    s = flown.session
    time = s.middle[s.flight[rows]] + s.tau[rows]
    half = [size / 2000 for size in stated_sizes_mm(flown.tracks[r].description)]
    plate = float(s.places[rows, 1].min()) - (float(np.median(half)) if half else 3e-3)
    return Seed(
        flown.tracks[r].description, time - time[0], places, s.angle[rows], plate
    )


def strobe(flown, r: int, rows: np.ndarray, seen: dict[str, np.ndarray]) -> bytes:
    """Recording, both simulations and differences at moments of the longest flight."""
    s = flown.session
    longest = max(
        np.unique(s.flight[rows]),
        key=lambda f: np.ptp(s.places[rows][s.flight[rows] == f, 1]),
    )
    own = np.flatnonzero(s.flight[rows] == longest)
    height = s.places[rows[own], 1]
    steps = np.linspace(height.max(), height.min(), MOMENTS)
    falling = (
        own[np.argmax(height) :]
        if np.argmax(height) < len(own) // 2
        else own[: np.argmax(height) + 1]
    )
    picked = np.unique(
        [
            falling[np.argmin(np.abs(s.places[rows[falling], 1] - step))]
            for step in steps
        ]
    )
    camera = camera_for(
        s.places[rows[picked]], _seed(flown, r, rows, seen["recording"]).plate_z
    )
    drawn = [
        moments(_seed(flown, r, rows[picked], places[picked]), camera)
        for places in seen.values()
    ]
    return beside(
        [*drawn, *differences(drawn, 40)], [*seen, "recording - old", "recording - new"]
    )


def _filmed(
    flown, r: int, rows: np.ndarray, seen: dict[str, np.ndarray], folder: Path, say
):
    """Both simulations filmed and tracked; distances from the recording."""
    s = flown.session
    time = s.middle[s.flight[rows]] + s.tau[rows]
    step = max(1, -(-round(np.ptp(time) / s.frame_s) // FRAMES))
    frames = np.arange(0, np.ptp(time), step * s.frame_s)
    nearest = np.unique([int(np.argmin(np.abs(time - time[0] - t))) for t in frames])
    left = {}
    for which in ("old twin", "new twin"):
        place = np.column_stack(
            [np.interp(frames, time - time[0], seen[which][:, k]) for k in (0, 1)]
        )
        angle = np.interp(frames, time - time[0], s.angle[rows])
        seed = replace(
            _seed(flown, r, rows, seen[which]), time=frames, places=place, angle=angle
        )
        name = f"{s.names[r].replace('/', '-')}-{which.split()[0]}"
        at, found = followed(
            seed,
            1 / (step * s.frame_s),
            folder / name,
            lambda text: say(f"drop: {text}"),
        )
        recorded = np.column_stack(
            [np.interp(at, time - time[0], seen["recording"][:, k]) for k in (0, 1)]
        )
        touch = (
            np.array([np.abs(time[nearest] - time[0] - t).min() for t in at])
            > 0.6 * step * s.frame_s
        )
        left[which] = 1e3 * float(np.sqrt(((found - recorded)[~touch] ** 2).mean()))
    yield Comparison(
        s.names[r],
        tr("place in flight"),
        "mm",
        left["old twin"],
        left["new twin"],
        "pictures",
    )
