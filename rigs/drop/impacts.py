"""Impacts: speeds before and after each contact, from fitted flights or from impact
times alone."""

import math
from dataclasses import dataclass, fields, replace

import numpy as np

from benchtwin.bench.air import air_of, drag_of_hops, stated_sizes_mm, through_air
from benchtwin.bench.constants import G_M_S2
from benchtwin.bench.ellipsoid import ONE_SIZE_LONG, UNKNOWN_LONG, elongation
from benchtwin.bench.priors import unstated_sd
from benchtwin.infer.problem import Fit
from benchtwin.rigs.drop.flight_model import (
    Model,
    contact_states,
    pushed,
)
from benchtwin.rigs.drop.reduction import slopes_at, whitened
from benchtwin.rigs.drop.session import height_sd_mm
from benchtwin.rigs.drop.track_noise import TrackNoise

SLOWEST_M_S = 0.15  # slower contacts are of a rolling or rocking seed
CONTACT_FRAMES, CONTACT_PLACE_M = (
    0.02,
    5e-5,
)  # sd of contact times: in frames; from place over change of speed


@dataclass(frozen=True, eq=False)
class Seeds:
    """Of each recording (R,), from the stated sizes."""

    radius: np.ndarray  # of the stated volume [m], NaN where no size is stated
    elongation: np.ndarray  # (a − c)/(a + c)
    reach: np.ndarray  # a − c of the half axes [m]
    gyration: np.ndarray  # gyration² I/m in the picture plane [m²]
    tilt: np.ndarray  # of the plate as stated [deg], falling towards +x
    drag: np.ndarray  # over weight at 2 m/s, as the air and the seed are stated
    drag_sd: np.ndarray


@dataclass(frozen=True, eq=False)
class Impacts:
    """n impacts of R recordings."""

    names: tuple[str, ...]
    recording: np.ndarray  # (n,)
    number: np.ndarray  # (n,): 1 for the first after release
    before: np.ndarray  # (n, 3): v_x, v_z [m/s], ω [rad/s, anticlockwise], NaN unseen
    after: np.ndarray
    flights: np.ndarray  # (n, 2): numbers of the flights before and after
    flight_sd: np.ndarray  # (F, 3): sd of v_x, v_z, ω
    time_sd: np.ndarray  # (n,) [s]: of the contact
    plumb_sd: float  # of the vertical once the flights are fitted [rad]
    seeds: Seeds
    steep: (
        np.ndarray
    )  # (n,): −cos 2α of the silhouette's long axis, −1 lying, NaN unseen
    fell: np.ndarray  # (n,) [m]: stated height that gave the speed before, or infinite
    sessions: tuple[str, ...]  # (R,)
    height_sd_mm: tuple[float, ...]  # (R,): of stated heights

    def __len__(self) -> int:
        return len(self.recording)

    @property
    def of_stated_height(self) -> bool:
        """Whether a speed follows from a stated height."""
        return bool(np.isfinite(self.fell).any())

    @property
    def timed(self) -> np.ndarray:
        """(n,): whether the speeds are those of times between impacts."""
        return np.isnan(self.before[:, 0])

    @property
    def spin_seen(self) -> np.ndarray:
        return np.isfinite(self.before[:, 2]) & np.isfinite(self.after[:, 2])


def impacts_of(fit: Fit, noise: TrackNoise, tracks) -> Impacts:
    """From fitted flights, slow ones included."""
    model, used = fit.problem.model, [t for t in tracks if not t.trouble]
    s = model.session
    before, after = speeds_at_contacts(model, fit.starts, fit.by_name)
    count = len(s.joint)
    recording = s.recording[s.joint[:, 0]] if count else np.zeros(0, dtype=int)
    number = [
        1 + int(np.argmin(np.abs(used[r].contacts_s - t)))
        for r, t in zip(recording, s.joint_time, strict=True)
    ]
    spin = np.where(np.isfinite(s.spin) & s.spin_seen, s.spin, np.nan)
    gain = np.abs(after[:, 1] - before[:, 1])
    turned = s.spin_seen & s.spin[s.joint].any(axis=1)
    ends = np.array(
        [s.stop[s.joint[:, 0]] - 1, s.first[s.joint[:, 1]]]
    )  # rows beside contacts
    return Impacts(
        names=s.names,
        recording=recording,
        number=np.array(number, dtype=int),
        flights=s.joint,
        before=np.column_stack([before, spin[s.joint[:, 0]]]),
        after=np.column_stack([after, spin[s.joint[:, 1]]]),
        flight_sd=np.column_stack([_flight_sds(fit, noise), s.spin_sd]),
        time_sd=np.hypot(CONTACT_FRAMES * s.frame_s, CONTACT_PLACE_M / gain),
        plumb_sd=math.radians(fit.sd("plumb")),
        seeds=seeds_of([t.description for t in used]),
        fell=np.full(count, np.inf),
        sessions=tuple(t.session for t in used),
        height_sd_mm=tuple(height_sd_mm(t.description) for t in used),
        steep=np.where(turned, -np.cos(2 * s.angle[ends]).mean(axis=0), np.nan),
    )


def speeds_at_contacts(
    model: Model, starts: np.ndarray, values: dict[str, float]
) -> np.ndarray:
    """(2, J, 2) [m/s]: before all contacts, and after them, where the flights meet in
    height."""
    push = pushed(model, starts, values)
    return contact_states(model, starts, push)[2].reshape(2, -1, 2)


def with_speeds(impacts: Impacts, speeds: np.ndarray) -> Impacts:
    """The same impacts, the first J of them, which were filmed, at other speeds (2, J,
    2)."""
    before, after = impacts.before.copy(), impacts.after.copy()
    for both, own in zip((before, after), speeds, strict=True):
        both[: len(own), :2] = own
    return replace(impacts, before=before, after=after)


def _flight_sds(fit: Fit, noise: TrackNoise) -> np.ndarray:
    """(F, 2): sd of v_x and v_z in the middle of each flight, from its own rows."""
    model = fit.problem.model
    rows = slopes_at(model, fit.starts, fit.by_name).rows
    own = [white[:, :4] for white in whitened(model, noise, rows)]
    return np.array([np.sqrt(np.diag(np.linalg.inv(w.T @ w))[2:]) for w in own])


def seeds_of(descriptions: list[dict]) -> Seeds:
    """From the stated sizes of each recording."""
    rows = []
    for about in descriptions:
        seed, tilt = about.get("seed", {}), about.get("drop", {}).get("tilt_deg") or 0.0
        half, air = np.array(stated_sizes_mm(about)) / 2000, air_of(about)
        beside = tilt, air.share, air.sd
        if not len(half):
            rows.append((np.nan, UNKNOWN_LONG, np.nan, np.nan, *beside))
            continue
        radius = float(np.prod(half)) ** (1 / len(half))
        long = elongation(half.tolist())
        reach = (
            float(half.max() - half.min())
            if len(half) > 1
            else 2 * ONE_SIZE_LONG * radius
        )
        rows.append(
            (
                radius,
                long,
                reach,
                seed.get("inertia_factor", 0.4) * float((half**2).mean()),
                *beside,
            )
        )
    return Seeds(*np.array(rows).reshape(-1, len(fields(Seeds))).T)


def usable_rows(impacts: Impacts) -> np.ndarray:
    """Impacts that are fast enough, and after which the seed rose."""
    return np.flatnonzero(
        (impacts.before[:, 1] < -SLOWEST_M_S) & (impacts.after[:, 1] > 0)
    )


def subset(impacts: Impacts, rows: np.ndarray) -> Impacts:
    """Some of the impacts."""
    cut = {
        key: getattr(impacts, key)[rows]
        for key in (
            "recording",
            "number",
            "fell",
            "before",
            "after",
            "flights",
            "time_sd",
            "steep",
        )
    }
    return replace(impacts, **cut)


def impacts_from_times(tracks) -> Impacts:
    """From times of successive impacts, and the stated heights."""
    rows, flights = [], []
    sds: list[float] = []
    for r, track in enumerate(tracks):
        hop, sd, air = (
            np.diff(track.contacts_s),
            track.contacts_sd_s,
            air_of(track.description),
        )
        height = track.description.get("drop", {}).get("height_mm")
        height_m = height / 1000 if height else None
        drag, _ = drag_of_hops(air, height_m, hop[0])
        arrivals, up, _ = through_air(hop, height_m, drag)
        fall = arrivals[0]
        first = len(sds)
        sds += [
            G_M_S2 * 1e-3 * unstated_sd("release-scatter") / fall if height else 1.0,
            *(G_M_S2 / 2 * np.hypot(sd[:-1], sd[1:])),
        ]
        for k in range(len(hop)):
            if np.isfinite(arrivals[k]):
                fell = np.inf if k else height_m
                rows.append((r, k + 1, arrivals[k], up[k], fell))
                flights.append((first + k, first + k + 1))
    found = np.array(rows).reshape(-1, 5)
    unseen = np.full(len(found), np.nan)
    table = Impacts(
        tuple(t.recording for t in tracks),
        found[:, 0].astype(int),
        found[:, 1].astype(int),
        np.column_stack([unseen, -found[:, 2], unseen]),
        np.column_stack([unseen, found[:, 3], unseen]),
        np.array(flights, dtype=int).reshape(-1, 2),
        np.column_stack([np.full(len(sds), np.nan), sds, np.zeros(len(sds))]),
        np.zeros(len(found)),
        0.0,
        seeds_of([t.description for t in tracks]),
        unseen,
        found[:, 4],
        tuple(t.session for t in tracks),
        tuple(height_sd_mm(t.description) for t in tracks),
    )
    return subset(table, usable_rows(table))


def concatenated(parts: list[Impacts]) -> Impacts:
    """Impacts of several sessions as one table."""
    recordings = np.cumsum([0, *(len(p.names) for p in parts)])[:-1]
    flights = np.cumsum([0, *(len(p.flight_sd) for p in parts)])[:-1]
    arrays = ("number", "fell", "before", "after", "flight_sd", "time_sd", "steep")
    return Impacts(
        names=sum((p.names for p in parts), ()),
        sessions=sum((p.sessions for p in parts), ()),
        height_sd_mm=sum((p.height_sd_mm for p in parts), ()),
        **{key: np.concatenate([getattr(p, key) for p in parts]) for key in arrays},
        recording=np.concatenate(
            [p.recording + n for p, n in zip(parts, recordings, strict=True)]
        ),
        flights=np.concatenate(
            [p.flights + n for p, n in zip(parts, flights, strict=True)]
        ),
        plumb_sd=max(p.plumb_sd for p in parts),
        seeds=Seeds(
            *(
                np.concatenate([getattr(p.seeds, k.name) for p in parts])
                for k in fields(Seeds)
            )
        ),
    )
