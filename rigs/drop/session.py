"""Drops of one session as flat arrays: rows know their flight, flights their
recording."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import legendre

from benchtwin.bench.air import Air, air_of, stated_sizes_mm
from benchtwin.bench.ellipsoid import elongation
from benchtwin.bench.language import tr
from benchtwin.bench.priors import stated_sd, unstated_sd
from benchtwin.rigs.drop.effects.hooks import View
from benchtwin.rigs.drop.silhouette_spin import (
    silhouette_rotation,
    spin_calibration,
)
from benchtwin.vision.motion.flight import FEW_ROWS

LEAST_ROWS = 8  # of a flight that may be judged by itself
LEAST = 2  # of a flight
BLOCK_S = 1.5e-3  # over which rows are averaged
SMOOTH_DEGREE = 4  # of the smooth curve of places in pixels
AIR_KEYS = ("share", "reynolds_per_speed", "lift", "room", "buoyancy")
LEAST_ROCKING_M = 3e-4  # also of balls


@dataclass(frozen=True, eq=False)
class Session:
    """R recordings, F flights, n rows; [m, s], x right, z up along the stated plumb
    line."""

    names: tuple[str, ...]
    recording: np.ndarray  # (F,), as the next eight
    middle: np.ndarray
    half: np.ndarray
    spin: np.ndarray  # of the silhouette [rad/s], 0 unseen
    spin_sd: np.ndarray  # of the seed's own beside it
    own_spin: np.ndarray  # about the line of sight, given that
    own_spin_sd: np.ndarray
    first: np.ndarray  # row
    stop: np.ndarray
    flight: np.ndarray  # (n,), as the next six
    tau: np.ndarray  # time after the flight's middle
    places: np.ndarray  # (n, 2)
    frame: np.ndarray
    weight: np.ndarray  # 1 over the relative sd of its place
    late: np.ndarray  # share of the camera's readout, after which it was read
    angle: np.ndarray
    joint: np.ndarray  # (J, 2): flights before and after each contact
    joint_time: np.ndarray  # (J,)
    release: np.ndarray  # (R,): stated fall, NaN where the release was not seen
    release_sd: np.ndarray  # of one beside the others
    height_sd_mm: float  # of stated heights, common to all
    frame_s: float
    away: np.ndarray  # (R,): distance of the camera
    uneven_m2: np.ndarray  # (R,): over the distance, see uneven_m
    air: tuple[Air, ...]
    view: View
    spin_seen: bool
    scale_sd: float
    plumb_sd_deg: float
    elongation: float  # of the stated sizes
    rocking_m: float  # how far a seed may move aside at one contact
    readout_sd_s: float  # of that readout, 0 where it is known
    notes: tuple[str, ...] = ()

    @property
    def of_stated_height(self) -> bool:
        """Whether a fall is compared with its stated height."""
        return bool(np.isfinite(self.release).any())

    @property
    def flown(self) -> tuple[str, ...]:
        """The recordings of which some flight can be used."""
        return tuple(self.names[r] for r in np.unique(self.recording))

    @property
    def falls(self) -> np.ndarray:
        """(F,): whether a flight is the first one of its recording."""
        return np.diff(self.recording, prepend=-1) > 0

    @cached_property
    def air_of_flights(self) -> np.ndarray:
        """(5, F, 1): AIR_KEYS of each flight's air."""
        air = [self.air[r] for r in self.recording]
        return np.array([[[getattr(a, key)] for a in air] for key in AIR_KEYS])

    @property
    def uneven_m(self) -> float:
        """Shift of a turning outline's middle by perspective, rms."""
        return float(np.median(self.uneven_m2 / self.away))

    @property
    def spins(self) -> bool:
        """Whether the silhouettes were seen to turn."""
        return self.spin_seen and bool(np.any(self.spin))


def assemble(
    tracks,
    unstated_m: float = np.inf,
    block_s: float = BLOCK_S,
) -> Session:
    """A session from tracks; unstated_m: distance of a camera whose own is not
    stated."""
    tracks = [t for t in tracks if not t.trouble]
    parts, joints, fallen, notes = _kept_flights(tracks, block_s)
    if not parts:
        raise ValueError(
            tr("no flight with at least {} frames in any recording", LEAST)
        )
    sizes = np.array([len(p["frame"]) for p in parts])
    rows = {
        key: np.concatenate([p[key] for p in parts])
        for key in ("tau", "places", "frame", "weight", "late", "angle", "phase")
    }
    spin_seen = all(t.angle_deg is not None for t in tracks)
    about = [t.description for t in tracks]
    spin = np.array([p["turned"].rate for p in parts])
    trust, spin_sd = spin_calibration([p["turned"] for p in parts])
    release, release_sd = _releases(tracks)
    release = np.where(fallen, release, np.nan)
    return Session(
        names=tuple(t.recording for t in tracks),
        **{
            key: np.array([p[key] for p in parts])
            for key in ("recording", "middle", "half")
        },
        spin=spin,
        spin_sd=spin_sd,
        own_spin=trust * spin,
        own_spin_sd=np.sqrt(trust) * spin_sd,
        first=np.cumsum(sizes) - sizes,
        stop=np.cumsum(sizes),
        flight=np.repeat(np.arange(len(parts)), sizes),
        tau=rows["tau"],
        places=rows["places"],
        frame=rows["frame"],
        weight=rows["weight"],
        late=rows["late"],
        angle=rows["angle"],
        joint=np.array([j[:2] for j in joints], dtype=int).reshape(-1, 2),
        joint_time=np.array([j[2] for j in joints]),
        release=release,
        release_sd=release_sd,
        height_sd_mm=float(np.median([height_sd_mm(d) for d in about])),
        frame_s=float(np.median([_step(t) for t in tracks])),
        away=np.array(
            [1e-3 * (d["camera"].get("distance_mm") or 1e3 * unstated_m) for d in about]
        ),
        uneven_m2=np.array([_uneven_m2(d) for d in about]),
        air=tuple(air_of(d) for d in about),
        view=_view(parts, rows, about),
        spin_seen=spin_seen,
        scale_sd=float(np.median([d["camera"]["scale_sd"] for d in about])),
        plumb_sd_deg=float(np.median([d["camera"]["plumb_sd_deg"] for d in about])),
        elongation=float(np.median([elongation(stated_sizes_mm(d)) for d in about])),
        rocking_m=float(np.median([max(_shape_sd(d), LEAST_ROCKING_M) for d in about])),
        readout_sd_s=max(t.readout_sd_s for t in tracks),
        notes=tuple(notes),
    )


def _kept_flights(
    tracks: list, block_s: float
) -> tuple[list[dict], list[tuple[int, int, float]], list[bool], list[str]]:
    """The flights of all tracks; joints: a flight, the next one, the time of the impact
    between; of each track whether both fall and first rebound are kept; notes."""
    parts: list[dict] = []
    joints, fallen, notes = [], [], []
    for r, track in enumerate(tracks):
        found = _flights_of(track, r, block_s)
        if not found:
            notes.append(
                tr(
                    "{}: no flight with at least {} frames; it is left out",
                    track.recording,
                    LEAST,
                )
            )
        numbers = {k: len(parts) + i for i, (k, _) in enumerate(found)}
        fallen.append(0 in numbers and 1 in numbers)
        joints += [
            (numbers[k], numbers[k + 1], t)
            for k, t in enumerate(track.contacts_s)
            if k in numbers and k + 1 in numbers
        ]
        parts += [part for _, part in found]
    return parts, joints, fallen, notes


def _view(parts: list[dict], rows: dict[str, np.ndarray], about: list[dict]) -> View:
    """Where in the picture the flights are; rows: of all, about: each recording's
    description."""
    low, high = rows["places"].min(0), rows["places"].max(0)
    pixel = float(np.median([d["camera"].get("mm_per_px", 0.0) for d in about])) / 1000
    first = {part["recording"]: part for part in reversed(parts)}.values()  # of each
    middle = (low + high) / 2
    fall = np.median(np.concatenate([part["places"][:, 0] for part in first]))
    return View(
        middle,
        float(high[1] - low[1]) / 2,
        rows["angle"],
        rows["phase"],
        pixel,
        fall=float(fall - middle[0]),
    )


def block_of(track, block_s: float = BLOCK_S) -> int:
    """Frames averaged to one row."""
    return max(1, int(block_s / _step(track)))


def _step(track) -> float:
    return float(np.median(np.diff(track.time_s) / np.diff(track.frame)))


def _flights_of(track, recording: int, block_s: float) -> list[tuple[int, dict]]:
    """The flights of one track that have enough rows, with their number in it."""
    camera, block = track.description["camera"], block_of(track, block_s)
    turn, pixel = (
        np.radians(camera.get("plumb_deg") or 0.0),
        camera.get("mm_per_px") or 0.0,
    )
    seen = np.column_stack([track.x_mm, track.y_mm])
    c, s = np.cos(turn), np.sin(turn)
    places = seen / 1000 @ np.array([[c, s], [-s, c]])
    phase = 2 * np.pi * seen / pixel if pixel else np.zeros_like(places)
    few, found = len(seen) < FEW_ROWS, []
    for k in range(int(track.flight.max(initial=-1)) + 1):
        rows = np.flatnonzero(track.flight == k)
        if len(rows) >= LEAST and k and k == len(track.contacts_s) and not few:
            rows = _before_landing(rows, places[rows, 1], track.description)
        if len(rows) < LEAST:
            continue
        turned = silhouette_rotation(track.angle_deg, rows, track.time_s[rows])
        late = track.late[rows] if len(track.late) else np.zeros(len(rows))
        time, own, frame, weight, late, angle, waves = _means(
            track.frame[rows],
            block,
            track.time_s[rows],
            places[rows],
            track.frame[rows],
            track.weight[rows],
            late,
            turned.angle,
            phase[rows],
        )
        if len(time) < LEAST:
            continue
        middle, half = (time[0] + time[-1]) / 2, (time[-1] - time[0]) / 2
        # smooth place among the pixels: a row's own reading would explain its own noise
        degree = min(SMOOTH_DEGREE, len(time) // 4) if len(time) >= LEAST_ROWS else 0
        basis = legendre.legvander((time - middle) / half, degree)
        waves = basis @ np.linalg.lstsq(basis, waves, rcond=None)[0]
        found.append(
            (
                k,
                {
                    "recording": recording,
                    "middle": middle,
                    "half": half,
                    "turned": turned,
                    "tau": time - middle,
                    "places": own,
                    "frame": frame / block,
                    "weight": weight,
                    "late": late,
                    "angle": angle,
                    "phase": waves,
                },
            )
        )
    return found


def _means(frame: np.ndarray, block: int, *columns: np.ndarray) -> list[np.ndarray]:
    """Means of columns (n,) or (n, 2) over blocks of so many frames."""
    _, inverse, count = np.unique(
        (frame - frame[0]) // block, return_inverse=True, return_counts=True
    )
    out = []
    for column in columns:
        wide = column.reshape(len(column), -1)
        sums = [
            np.bincount(inverse, weights=wide[:, k] - wide[0, k]) / count + wide[0, k]
            for k in range(wide.shape[1])
        ]
        out.append(np.column_stack(sums).reshape((-1, *column.shape[1:])))
    return out


def _before_landing(rows: np.ndarray, up: np.ndarray, description: dict) -> np.ndarray:
    """Rows of the last flight down to the height at which a turned seed may touch;
    all of them where few would be left."""
    sizes = stated_sizes_mm(description)
    margin = (max(sizes) - min(sizes)) / 2000 if len(sizes) > 1 else 1.5e-3
    apex = int(np.argmax(up))
    low = np.flatnonzero(up[apex:] < up[0] + margin)
    cut = rows[: apex + int(low[0])] if len(low) else rows
    return cut if len(cut) >= LEAST_ROWS else rows


def height_sd_mm(description: dict) -> float:
    """sd of the stated height, as stated or as of heights that people state."""
    stated = description.get("drop", {}).get("height_sd_mm")
    return stated_sd("release-height") if stated is None else stated


def _shape_sd(description: dict) -> float:
    """(longest − shortest)/4 [m], half of what a centre may sink by; else
    that of releases."""
    sizes = stated_sizes_mm(description)
    return (
        (max(sizes) - min(sizes)) / 4000
        if len(sizes) > 1
        else 0.0
        if sizes
        else 1e-3 * unstated_sd("release-scatter")
    )


def _uneven_m2(description: dict) -> float:
    """(l² − s²)/24: over the distance, by how much a leaning outline's middle is off,
    rms."""
    sizes = stated_sizes_mm(description) or (8.0, 6.0)
    return float(1e-6 * (max(sizes) ** 2 - min(sizes) ** 2) / 8 / 3)


def _releases(tracks) -> tuple[np.ndarray, np.ndarray]:
    """Stated falls and sds; a turning seed lands on another radius than it was released
    at."""
    stated = [t.description.get("drop", {}).get("height_mm") or np.nan for t in tracks]
    seen = [t.release_seen and len(t.contacts_s) > 0 for t in tracks]
    sds = np.hypot(
        1e-3 * unstated_sd("release-scatter"),
        [_shape_sd(t.description) for t in tracks],
    )
    return np.where(seen, np.array(stated) / 1000, np.nan), sds
