"""Drops of one session as flat arrays: rows know their flight, flights their recording."""

from dataclasses import dataclass

import numpy as np

from diagnose.air import Air, air_of, stated_sizes_mm
from diagnose.effects.drop.hooks import View
from diagnose.rigs.drop.silhouette_spin import silhouette_rotation, spin_calibration

GUARD_FRAMES = 2.0  # rows nearer to a contact are left out
LEAST_ROWS = 8  # of a flight
FEW_ROWS = 16  # of a track of fewer each row counts, and gravity makes up for a flight's third
BLOCK_S = 1.5e-3  # over which rows are averaged
SMOOTH_DEGREE = 4  # of the smooth curve of places in pixels
ROUGH = 3.0  # times the usual roughness, beyond which a flight was not free
LEAST_ROCKING_M = 3e-4  # also of balls
HEIGHT_SD_M = 1e-3  # how well a release height is known


@dataclass(frozen=True, eq=False)
class Session:
    """R recordings, F flights, n rows; [m, s], x right, z up along the stated plumb line.

    middle, half (F,): of each flight; first, stop (F,): its rows.
    spin, spin_sd (F,) [rad/s]: of the silhouette (0 unseen), and sd of the seed's own beside it.
    own_spin, own_spin_sd (F,): spin about the line of sight given that, and its sd.
    flight (n,), tau (n,): time after the flight's middle, places (n, 2), frame (n,), angle (n,).
    joint (J, 2): flights before and after each contact, joint_time (J,).
    release (R,): stated fall, NaN where the release was not seen; release_sd (R,).
    away (R,): distance of the camera; uneven_m: shift of a turning outline's middle by perspective.
    elongation: (length − thickness)/(length + thickness) as stated, NaN if not.
    rocking_m: how far a seed may move aside between its first and last touch at one contact.
    """

    names: tuple[str, ...]
    recording: np.ndarray
    middle: np.ndarray
    half: np.ndarray
    spin: np.ndarray
    spin_sd: np.ndarray
    own_spin: np.ndarray
    own_spin_sd: np.ndarray
    first: np.ndarray
    stop: np.ndarray
    flight: np.ndarray
    tau: np.ndarray
    places: np.ndarray
    frame: np.ndarray
    angle: np.ndarray
    joint: np.ndarray
    joint_time: np.ndarray
    release: np.ndarray
    release_sd: np.ndarray
    frame_s: float
    away: np.ndarray
    uneven_m: float
    air: tuple[Air, ...]
    view: View
    spin_seen: bool
    scale_sd: float
    plumb_sd_deg: float
    elongation: float
    rocking_m: float
    notes: tuple[str, ...] = ()

    @property
    def spins(self) -> bool:
        """Whether the silhouettes were seen to turn."""
        return self.spin_seen and bool(np.any(self.spin))


def assemble(tracks, unstated_m: float = np.inf, block_s: float = BLOCK_S) -> Session:
    """A session from tracks (twin.tracks.SeenTrack); ValueError where no flight is left.

    unstated_m: distance of a camera whose own is not stated; block_s: over which rows are averaged.
    """
    tracks = [t for t in tracks if not t.trouble]
    parts, notes, joints, fallen = [], [], [], []
    count = 0
    flights = [_flights_of(track, r, block_s) for r, track in enumerate(tracks)]
    usual = float(np.median([_roughness(part) for found in flights for _, part in found if len(part["tau"]) >= LEAST_ROWS] or [0.0]))
    for track, found in zip(tracks, flights, strict=True):
        kept = [(k, free) for k, part in found if (free := _free_part(part, usual)) is not None]
        if len(kept) < len(found):
            notes.append(f"{track.recording}: {len(found) - len(kept)} flights left out, touched again in mid-flight")
        if not found:
            notes.append(f"{track.recording}: no flight with at least {LEAST_ROWS} frames; it is left out")
        numbers = {k: count + i for i, (k, _) in enumerate(kept)}
        fallen.append(0 in numbers and 1 in numbers)  # both fall and first rebound are kept
        joints += [(numbers[k], numbers[k + 1], t) for k, t in enumerate(track.contacts_s) if k in numbers and k + 1 in numbers]
        parts += [part for _, part in kept]
        count += len(kept)
    if not parts:
        raise ValueError(f"no flight with at least {LEAST_ROWS} frames in any recording")
    sizes = np.array([len(p["frame"]) for p in parts])
    rows = {key: np.concatenate([p[key] for p in parts]) for key in ("tau", "places", "frame", "angle", "phase")}
    spin_seen = all(t.angle_deg is not None for t in tracks)
    low, high = rows["places"].min(0), rows["places"].max(0)
    about = [t.description for t in tracks]
    pixel = float(np.median([d["camera"].get("mm_per_px", 0.0) for d in about])) / 1000
    middle, fall = (low + high) / 2, np.median(np.concatenate([part["places"][:, 0] for part in _first_of(parts)]))
    view = View(middle, float(high[1] - low[1]) / 2, rows["angle"], rows["phase"], pixel, fall=float(fall - middle[0]))
    spin = np.array([p["turned"].rate for p in parts])
    trust, spin_sd = spin_calibration([p["turned"] for p in parts])
    release, release_sd = _releases(tracks)
    release = np.where(fallen, release, np.nan)
    return Session(
        names=tuple(t.recording for t in tracks),
        **{key: np.array([p[key] for p in parts]) for key in ("recording", "middle", "half")},
        spin=spin, spin_sd=spin_sd, own_spin=trust * spin, own_spin_sd=np.sqrt(trust) * spin_sd,
        first=np.cumsum(sizes) - sizes, stop=np.cumsum(sizes), flight=np.repeat(np.arange(len(parts)), sizes),
        tau=rows["tau"], places=rows["places"], frame=rows["frame"], angle=rows["angle"],
        joint=np.array([j[:2] for j in joints], dtype=int).reshape(-1, 2), joint_time=np.array([j[2] for j in joints]),
        release=release, release_sd=release_sd, frame_s=float(np.median([_step(t) for t in tracks])),
        away=(away := np.array([1e-3 * (d["camera"].get("distance_mm") or 1e3 * unstated_m) for d in about])),
        uneven_m=float(np.median([_uneven(d, m) for d, m in zip(about, away, strict=True)])),
        air=tuple(air_of(d) for d in about), view=view, spin_seen=spin_seen,
        scale_sd=float(np.median([d["camera"]["scale_sd"] for d in about])),
        plumb_sd_deg=float(np.median([d["camera"]["plumb_sd_deg"] for d in about])),
        elongation=float(np.median([_elongation(d) for d in about])), rocking_m=float(np.median([_rocking(d) for d in about])),
        notes=tuple(notes),
    )  # fmt: skip


def _first_of(parts: list[dict]) -> list[dict]:
    """Each recording's first flight."""
    return list({part["recording"]: part for part in reversed(parts)}.values())


def block_of(track, block_s: float = BLOCK_S) -> int:
    """Frames averaged to one row."""
    return max(1, int(block_s / _step(track)))


def _step(track) -> float:
    return float(np.median(np.diff(track.time_s) / np.diff(track.frame)))


def _flights_of(track, recording: int, block_s: float) -> list[tuple[int, dict]]:
    """The flights of one track that have enough rows, with their number in it."""
    turn = np.radians(track.description["camera"].get("plumb_deg", 0.0) or 0.0)
    x, y = track.x_mm / 1000, track.y_mm / 1000
    places = np.column_stack([x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn)])
    pixel = track.description["camera"].get("mm_per_px") or 0.0
    phase = 2 * np.pi * np.column_stack([track.x_mm, track.y_mm]) / pixel if pixel else np.zeros_like(places)
    block = block_of(track, block_s)
    near = np.zeros(len(x), dtype=bool)
    few = len(x) < FEW_ROWS
    least = 2 if few else LEAST_ROWS
    for contact in () if few else track.contacts_s:
        near |= np.abs(track.time_s - contact) <= GUARD_FRAMES * _step(track)
    found = []
    for k in range(int(track.flight.max(initial=-1)) + 1):
        rows = np.flatnonzero((track.flight == k) & ~near)
        if len(rows) < least:
            continue
        if k and k == len(track.contacts_s) and not few:
            rows = _before_landing(rows, places[rows, 1], track.description)
            if len(rows) < least:
                continue
        turned = silhouette_rotation(track.angle_deg, rows, track.time_s[rows])
        time, own, frame, angle, waves = _means(
            track.frame[rows], block, track.time_s[rows], places[rows], track.frame[rows], turned.angle, phase[rows]
        )
        if len(time) < least:
            continue
        middle, half = (time[0] + time[-1]) / 2, (time[-1] - time[0]) / 2
        found.append((k, {
            "recording": recording, "middle": middle, "half": half, "turned": turned, "tau": time - middle, "places": own,
            "frame": frame / block, "angle": angle, "phase": waves,
        }))  # fmt: skip
    return found


def _means(frame: np.ndarray, block: int, *columns: np.ndarray) -> list[np.ndarray]:
    """Means of columns (n,) or (n, 2) over blocks of so many frames."""
    _, inverse, count = np.unique((frame - frame[0]) // block, return_inverse=True, return_counts=True)
    out = []
    for column in columns:
        wide = column.reshape(len(column), -1)
        sums = [np.bincount(inverse, weights=wide[:, k] - wide[0, k]) / count + wide[0, k] for k in range(wide.shape[1])]
        out.append(np.column_stack(sums).reshape((-1, *column.shape[1:])))
    return out


def _before_landing(rows: np.ndarray, up: np.ndarray, description: dict) -> np.ndarray:
    """Rows of the last flight down to the height at which a turned seed may touch."""
    sizes = stated_sizes_mm(description)
    margin = (max(sizes) - min(sizes)) / 2000 if len(sizes) > 1 else 1.5e-3
    apex = int(np.argmax(up))
    low = np.flatnonzero(up[apex:] < up[0] + margin)
    return rows[: apex + int(low[0])] if len(low) else rows


def _roughness(part: dict) -> float:
    """rms [m] of a flight about a curve of degree 6."""
    degree = min(6, len(part["tau"]) // 4)
    basis = np.column_stack([np.polynomial.legendre.legvander(part["tau"] / part["half"], degree), *_twice(part["angle"])])
    left = part["places"] - basis @ np.linalg.lstsq(basis, part["places"], rcond=None)[0]
    return float(np.sqrt((left**2).mean()))


def _twice(angle: np.ndarray):
    return (np.cos(2 * angle), np.sin(2 * angle)) if len(angle) > 30 and np.ptp(angle) > 0 else ()


def _free_part(part: dict, usual: float) -> dict | None:
    """The flight without first rows that are too rough; None where all of it is."""
    if len(part["tau"]) < LEAST_ROWS:  # too few to tell
        return part | {"phase": np.full_like(part["phase"], part["phase"].mean())}
    for share in (0.0, 0.1, 0.25):
        rows = slice(int(share * len(part["tau"])), None)
        time = part["middle"] + part["tau"][rows]
        if len(time) < LEAST_ROWS:
            return None
        middle, half = (time[0] + time[-1]) / 2, (time[-1] - time[0]) / 2
        cut = part | {key: part[key][rows] for key in ("places", "frame", "angle", "phase")}
        cut |= {"middle": middle, "half": half, "tau": time - middle, "phase": _smooth(cut["phase"], (time - middle) / half)}
        if _roughness(cut) < ROUGH * max(usual, 1e-7):
            return cut
    return None


def _smooth(phase: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Smooth place among the pixels: a row's own reading would explain its own noise."""
    basis = np.polynomial.legendre.legvander(at, min(SMOOTH_DEGREE, len(at) // 4))
    return basis @ np.linalg.lstsq(basis, phase, rcond=None)[0]


def _elongation(description: dict) -> float:
    sizes = stated_sizes_mm(description)
    return (max(sizes) - min(sizes)) / (max(sizes) + min(sizes)) if len(sizes) > 1 else float("nan")


def _rocking(description: dict) -> float:
    """Half of what the centre may sink by while the other end comes down [m]."""
    return max(_shape_sd(description), LEAST_ROCKING_M)


def _shape_sd(description: dict) -> float:
    """(longest − shortest)/4 [m]; HEIGHT_SD_M where no sizes are stated."""
    sizes = stated_sizes_mm(description)
    return (max(sizes) - min(sizes)) / 4000 if len(sizes) > 1 else 0.0 if sizes else HEIGHT_SD_M


def _uneven(description: dict, away_m: float) -> float:
    """A third of (l² − s²)/8d [m] for sizes l, s and distance d.

    By so much a leaning outline's middle is off, its near end being larger, rms over a flight.
    """
    sizes = stated_sizes_mm(description) or (8.0, 6.0)
    return float(1e-6 * (max(sizes) ** 2 - min(sizes) ** 2) / 8 / away_m / 3)


def _releases(tracks) -> tuple[np.ndarray, np.ndarray]:
    """Stated falls and sds; a turning seed lands on another radius than it was released at."""
    falls, sds = [], []
    for t in tracks:
        stated = t.description.get("drop", {}).get("height_mm")
        usable = bool(stated) and t.release_seen and len(t.contacts_s) > 0
        falls.append(stated / 1000 if usable else np.nan)
        sds.append(float(np.hypot(HEIGHT_SD_M, _shape_sd(t.description))))
    return np.array(falls), np.array(sds)
