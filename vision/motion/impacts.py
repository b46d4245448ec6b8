"""Speeds and restitution of a drop from the times of its impacts.

A free flight that starts and ends on the plate lasts Δt = 2 v / g, so v = g Δt / 2, its
height is g Δt² / 8, and the restitution of the impact between two flights is e = Δt₂ /
Δt₁. The first impact's speed is √(2 g H) of the stated fall, which the later bounces
correct (first_bounce.py). Air drag is allowed for
where the seed is described (a = −g − k v |v|, in closed form); otherwise a soybean's
drag is part of the error. Unknown sds of the times are estimated from their rounding
and scatter: an error of a time changes two intervals in opposite ways, a scatter of the
restitution does not."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from benchtwin.bench.air import (
    SHAPE_SD,
    SLOWEST_M_S,
    UNKNOWN_DRAG_PER_M,
    air_of,
    drag_at,
    through_air,
)
from benchtwin.bench.constants import G_MM_S2
from benchtwin.bench.ellipsoid import elongation
from benchtwin.bench.priors import unstated_sd
from benchtwin.vision.measurement import (
    DOUBTFUL,
    FAILED,
    GOOD,
    Quantity,
    all_failed,
    failed,
    vague,
)
from benchtwin.vision.motion.first_bounce import first_bounce, first_flat_sd
from benchtwin.vision.recording import Recording

G = G_MM_S2 / 1000  # m/s²
PRIOR_SD_S, PRIOR_FACTOR = 2e-4, 2.0  # log-normal prior of the sd of an impact time
LONGEST_S = 20.0  # of an interval (490 m up): longer ones are times in another unit
NOT_FIRST = (
    "the impacts before were not all heard, so the speed of the first of these is"
    " unknown"
)
# share of a fall's energy lost to the air, above which √(H2/H1) is no restitution
MOST_LOST = 0.1
INSIDE_SDS = 1.96
JUMP = 2.0  # greatest factor between successive restitutions


@dataclass(frozen=True)
class _Flights:
    """What n intervals between n + 1 impacts tell, SI units. gap: they themselves;
    before (NaN where unknown), speed: speeds before and after each impact; rise; e:
    restitution, late (n, n + 1): how it changes with an sd of each time; e_air: with an
    sd of the drag; *_shared: what sds of the drag and of gravity make of each."""

    times: np.ndarray
    sd: np.ndarray
    gap: np.ndarray
    gap_sd: np.ndarray
    before: np.ndarray
    before_sd: np.ndarray
    speed: np.ndarray
    speed_shared: np.ndarray
    rise: np.ndarray
    rise_shared: np.ndarray
    e: np.ndarray
    e_sd: np.ndarray
    e_air: np.ndarray
    late: np.ndarray

    @classmethod
    def of(
        cls,
        times: np.ndarray,
        sd: np.ndarray,
        height_m: float | None,
        drag: float,
        drag_sd: float,
    ) -> "_Flights":
        """height_m: the first fall, None where it is unknown."""
        gap, gap_sd = np.diff(times), np.hypot(sd[:-1], sd[1:])
        before, speed, rise = through_air(gap, height_m, drag)
        air = through_air(gap, height_m, drag + drag_sd)
        e = speed / before
        e_air = air[1] / air[0] - e
        # Neighbouring intervals share the impact between them, so their errors are
        # opposite.
        late = np.zeros((len(gap), len(times)))
        rows = np.arange(len(gap))
        late[rows, rows + 1], late[rows, rows] = sd[1:] / gap, -sd[:-1] / gap
        late[1:] -= late[:-1].copy()
        late *= e[:, None]
        gravity = unstated_sd("gravity")
        shared = [
            np.hypot(windy - calm, gravity * calm)
            for windy, calm in zip(air, (before, speed, rise), strict=True)
        ]
        later_sd = np.hypot(G * gap_sd[:-1] / 2, shared[0][1:])
        return cls(
            times=times,
            sd=sd,
            gap=gap,
            gap_sd=gap_sd,
            before=before,
            before_sd=np.append(math.nan, later_sd),
            speed=speed,
            speed_shared=shared[1],
            rise=rise,
            rise_shared=shared[2],
            e=e,
            e_sd=np.hypot(np.sqrt((late**2).sum(axis=1)), e_air),
            e_air=e_air,
            late=late,
        )

    @property
    def top_mm(self) -> float:
        """How high the seed rises first."""
        return 1000 * float(self.rise[0])

    def table(self, recording_id: str) -> pd.DataFrame:
        """A row a bounce."""
        gap = self.gap
        height_sd = np.hypot(G * gap / 4 * self.gap_sd, self.rise_shared)
        return pd.DataFrame(
            {
                "recording": recording_id,
                "drop": 1,
                "bounce": np.arange(1, len(gap) + 1),
                "t_s": self.times[:-1],
                "t_sd_s": self.sd[:-1],
                "speed_before_m_s": self.before,
                "speed_before_sd_m_s": self.before_sd,
                "speed_after_m_s": self.speed,
                "speed_after_sd_m_s": np.hypot(G * self.gap_sd / 2, self.speed_shared),
                "height_mm": 1000 * self.rise,
                "height_sd_mm": 1000 * height_sd,
                "restitution": self.e,
                "restitution_sd": self.e_sd,
                "quality": _qualities(self.e),
            }
        )


@dataclass(frozen=True)
class _Fall:
    """The first impact by the stated fall and the later bounces. flights: with its
    restitution and speed; by_height: √(H2/H1) over that; lost: share of the fall's
    energy that the air takes; e_common: the part of its restitution's sd that all
    recordings share; doubt: about the stated height; too_high: whether that would be
    too high, as where the first impact was not heard."""

    flights: _Flights
    by_height: float
    lost: float
    e_common: float
    doubt: str
    too_high: bool

    @classmethod
    def of(cls, flights: _Flights, height: float, recording: Recording) -> "_Fall":
        """height [mm]: of the release."""
        f, height_sd = flights, recording.drop.height_sd
        off_sd = math.hypot(height_sd, unstated_sd("gravity") * height)  # alike to e
        told = first_bounce(
            f.e,
            f.late @ f.late.T + np.outer(f.e_air, f.e_air),
            f.before,
            height,
            off_sd,
            first_flat_sd(elongation(recording.seed.sizes_mm)),
        )
        before = f.speed[0] / told.value
        before_sd = before * math.hypot(told.sd / told.value, f.gap_sd[0] / f.gap[0])
        return cls(
            replace(
                f,
                e=np.append(told.value, f.e[1:]),
                e_sd=np.append(told.sd, f.e_sd[1:]),
                before=np.append(before, f.before[1:]),
                before_sd=np.append(before_sd, f.before_sd[1:]),
            ),
            by_height=math.sqrt(f.top_mm / height) / float(f.e[0]),
            lost=1 - f.before[0] ** 2 / (2 * G * height / 1000),
            e_common=math.hypot(f.e_air[0], told.by_height),
            doubt=told.doubt(height_sd),
            too_high=told.low_mm < 0,
        )


def measure_impacts(
    times: np.ndarray,
    sd: np.ndarray | None,
    recording: Recording,
    *,
    first: bool = True,
) -> tuple[tuple[Quantity, ...], pd.DataFrame, list[str]]:
    """Quantities, the table of bounces, notes; times, sd [s]; first: whether the first
    impact is that after the release."""
    given, notes = sd, []
    if sd is None:
        sd = estimate_time_sds(times)
        notes.append(
            "no sd_s is stated: each impact's time is taken to be known to"
            f" {1000 * sd[0]:.2g} ms, by rounding and scatter"
        )
    height = recording.drop.height_mm if first else None
    drag, drag_sd, drag_notes = _drag(recording, float(times[1] - times[0]), height)
    notes += drag_notes
    flights = _Flights.of(times, sd, height / 1000 if height else None, drag, drag_sd)
    if height:
        fall = _Fall.of(flights, height, recording)
        flights = fall.flights
        missed = _missed_interval(flights.e)
        if missed is not None and missed < 2:
            if len(flights.e) > 2 and _missed_interval(flights.e[1:]) is None:
                missed = None  # the bounces behind fit: it is the height's fault
            else:
                fall = replace(fall, doubt="")
        quantities, more = _with_fall(fall)
        notes += more
    else:
        missed = _missed_interval(flights.e)
        quantities = _without_fall(flights, recording, first)
    bounces, gap = flights.table(recording.id), flights.gap
    if gap.max() > LONGEST_S:
        wrong = (
            f"an interval of {gap.max():.4g} s between impacts: t_s is to be in seconds"
            " (are these milliseconds?)"
        )
        all_wrong = tuple(failed(q.name, q.unit, wrong) for q in quantities)
        return all_wrong, bounces, [*notes, wrong]
    if height and flights.top_mm > 1.1 * height + 3 * recording.drop.height_sd:
        why = _too_low(height, gap[0], flights.top_mm, flights.e)
        return _without_height(times, given, recording, why)
    what = _even(flights) or ("" if height else _too_far_up(flights))
    if missed is not None:
        what = (
            f"an impact seems to be missing: interval {missed + 1} ({gap[missed]:.4g}"
            " s) does not fit the others"
        )
        notes.append(what)
    if what and (missed is None or missed < 2):
        quantities = [
            q if q.quality == FAILED or q.name == "impact_speed" else q.doubt(what)
            for q in quantities
        ]
    return tuple(q.doubt(vague(q)) for q in quantities), bounces, notes


def _too_far_up(flights: _Flights) -> str:
    """A doubt where a rebound is higher than falls are believed to be; ""."""
    if flights.top_mm < INSIDE_SDS * unstated_sd("fall"):
        return ""
    return (
        f"a rebound of {flights.top_mm:.4g} mm, and no height is stated: are these the"
        " impacts of several drops?"
    )


def _even(flights: _Flights) -> str:
    """A doubt where no interval is known to be shorter than the one before, as of
    bounces; ""."""
    later, sd = flights.e[1:], flights.e_sd[1:]
    if not len(later) or (later + INSIDE_SDS * sd < 1).any():
        return ""
    return "the intervals do not shrink: are these the impacts of several drops?"


def _first_rebound(flights: _Flights) -> tuple[Quantity, Quantity]:
    """Its height and speed."""
    f = flights
    height_sd = 1000 * math.hypot(G * f.gap[0] / 4 * f.gap_sd[0], f.rise_shared[0])
    speed_sd = math.hypot(G * f.gap_sd[0] / 2, f.speed_shared[0])
    return (
        _quantity("rebound_height", f.top_mm, height_sd, "mm", 1000 * f.rise_shared[0]),
        _quantity("rebound_speed", f.speed[0], speed_sd, "m/s", f.speed_shared[0]),
    )


def _quantity(name: str, value: float, sd: float, unit: str, common: float) -> Quantity:
    """common: the part of the sd that all recordings share."""
    value, sd = float(value), float(sd)
    return Quantity(name, value, sd, unit, sd_common=min(float(common), sd))


def _with_fall(fall: _Fall) -> tuple[list[Quantity], list[str]]:
    """Quantities of the first bounce where the fall is stated, and notes."""
    f, notes, by_height = fall.flights, [], fall.by_height
    e, e_sd, before = float(f.e[0]), float(f.e_sd[0]), float(f.before[0])
    normal = Quantity(
        "restitution_normal",
        e,
        e_sd,
        "1",
        sd_common=fall.e_common,
        believed_sd=unstated_sd("restitution"),
    )
    normal = normal.doubt(fall.doubt)
    if fall.lost > MOST_LOST:
        notes.append(
            f"the air takes {100 * fall.lost:.0f} % of the fall: √(H2/H1) ="
            f" {by_height * e:.4g} is no restitution; the ratio of the speeds is given"
        )
        by_height = 1.0
    parts = ("value", "sd", "sd_common", "believed_sd")
    scaled = {part: by_height * getattr(normal, part) for part in parts}
    by_heights = replace(normal, name="restitution", **scaled)
    of_first = fall.doubt if fall.too_high else ""
    height, speed = (q.doubt(of_first) for q in _first_rebound(f))
    impact = _quantity(
        "impact_speed", before, f.before_sd[0], "m/s", before / e * fall.e_common
    )
    return [
        height,
        by_heights,
        impact.doubt(fall.doubt),
        speed,
        normal,
    ], notes


def _without_fall(
    flights: _Flights, recording: Recording, first: bool
) -> list[Quantity]:
    """Quantities where the first fall is unknown: the restitution is the second
    impact's."""
    text = (
        f"{recording.toml}: [drop] height_mm is missing; the first impact's speed is"
        " needed"
        if first
        else NOT_FIRST
    )
    height, speed = _first_rebound(flights)
    unknown = all_failed((("restitution", "1"), ("impact_speed", "m/s")), text)
    found = [height, *unknown, speed]
    if len(flights.gap) < 2:
        return [*found, failed("restitution_normal", "1", text)]
    e, e_sd, e_air = (
        float(v[1]) for v in (flights.e, flights.e_sd, np.abs(flights.e_air))
    )
    second = Quantity("restitution_normal", e, e_sd, "1", sd_common=e_air)
    reason = (
        "[drop] height_mm is missing, so the first one's speed is unknown"
        if first
        else NOT_FIRST
    )
    return [*found, second.doubt(f"of the second impact: {reason}")]


def _drag(
    recording: Recording, gap: float, height: float | None
) -> tuple[float, float, list[str]]:
    """k [1/m] of a = −k v |v|, its sd, and a note."""
    speed = math.sqrt(2 * G * height / 1000) if height else G * gap / 2
    drag = drag_per_metre(recording, 0.75 * speed)
    if drag is None:
        return (
            0.0,
            UNKNOWN_DRAG_PER_M,
            [
                "air drag is not allowed for: [seed] sizes and mass_g or density_kg_m3"
                " are unknown"
            ],
        )
    share = drag * speed**2 / G
    return (
        drag,
        SHAPE_SD * drag,
        (
            [f"air drag (up to {100 * share:.1f} % of the weight) is allowed for"]
            if drag
            else []
        ),
    )


def _too_low(height: float, gap: float, top: float, e: np.ndarray) -> str:
    """Why the stated height [mm] is not that of the drop, with the height that the
    second bounce makes likely."""
    said = (
        f"the first interval of {gap:.4g} s is a rebound of {top:.4g} mm, higher than"
        f" the drop ([drop] height_mm = {height:g}): is height_mm in millimetres and"
        " t_s in seconds, or was an impact missed?"
    )
    if len(e) > 1 and 0 < e[1] < 1:
        likely = float(f"{top / e[1] ** 2:.2g}")
        said += f" The bounces behind make {likely:g} mm likely"
    return said


def _without_height(
    times: np.ndarray, sd: np.ndarray | None, recording: Recording, why: str
) -> tuple[tuple[Quantity, ...], pd.DataFrame, list[str]]:
    """What the impacts tell by themselves, where the stated height cannot be."""
    unstated = {"drop": recording.drop.model_copy(update={"height_mm": None})}
    alone = replace(recording, **unstated)
    quantities, bounces, notes = measure_impacts(times, sd, alone)
    told = tuple(
        failed(q.name, q.unit, why)
        if q.quality == FAILED
        else replace(q, reason="").doubt(why)
        for q in quantities
    )
    return told, bounces, [*notes, why]


def _missed_interval(e: np.ndarray) -> int | None:
    """The first interval too long for its neighbours, as when an impact was missed;
    None where all fit."""
    longer = np.flatnonzero(e > 1)
    known = np.isfinite(e[:-1])
    jump = np.abs(
        np.log(e[1:] / e[:-1], where=known, out=np.zeros(len(e) - 1))
    ) > math.log(JUMP)
    jumps = [int(k) if e[k] > e[k + 1] else int(k) + 1 for k in np.flatnonzero(jump)]
    return min([*map(int, longer), *jumps], default=None)


def _qualities(e: np.ndarray) -> list[str]:
    """Quality of each bounce: failed without a speed before it, doubtful for e ≥ 1 or
    far from the median of the others."""
    jump = np.zeros(len(e), bool)
    middle = np.nanmedian(e) if np.isfinite(e).any() else math.nan
    jump[np.isfinite(e)] = np.abs(np.log(e[np.isfinite(e)] / middle)) > math.log(JUMP)
    return [
        FAILED if not np.isfinite(value) else DOUBTFUL if value >= 1 or off else GOOD
        for value, off in zip(e, jump)
    ]


def estimate_time_sds(times: np.ndarray) -> np.ndarray:
    """(n,), all equal: estimated sd [s] of impact times without a stated one. Posterior
    mean from the scatter of ln Δt, in which errors of times and of e differ in
    correlation; at least the rounding."""
    least = _rounding(times) / math.sqrt(12)
    sigma = np.maximum(np.geomspace(2e-6, 2e-2, 41), least)
    log_weight = -0.5 * (np.log(sigma / PRIOR_SD_S) / math.log(PRIOR_FACTOR)) ** 2
    gap = np.diff(times)
    if len(gap) > 2:
        y = np.diff(np.log(gap))
        slope = np.zeros((len(y), len(times)))  # of y with the times
        for k in range(len(y)):
            slope[k, k : k + 3] = (
                1 / gap[k],
                -1 / gap[k] - 1 / gap[k + 1],
                1 / gap[k + 1],
            )
        centred = np.linalg.svd(np.ones((len(y), 1)))[0][:, 1:].T  # e itself is unknown
        values, shape = centred @ y, centred @ slope @ slope.T @ centred.T
        axes, turned = np.linalg.eigh(shape)
        power = (turned.T @ values) ** 2
        variance = (
            sigma[:, None, None] ** 2 * np.maximum(axes, 0)
            + np.geomspace(1e-3, 0.2, 15)[:, None] ** 2
        )
        each = -0.5 * (np.log(variance) + power / variance).sum(axis=2)
        log_weight = log_weight + np.logaddexp.reduce(each, axis=1)
    weight = np.exp(log_weight - log_weight.max())
    return np.full(
        len(times), max(np.exp(weight @ np.log(sigma) / weight.sum()), least)
    )


def _rounding(times: np.ndarray) -> float:
    """The step to which the times were rounded when written: 0.001 for 0.271, 0.522."""
    exact = (
        np.allclose(times, np.round(times, digits), rtol=0, atol=1e-9)
        for digits in range(7)
    )
    return next(
        (10.0**-digits for digits, is_exact in enumerate(exact) if is_exact), 0.0
    )


def drag_per_metre(recording: Recording, speed: float) -> float | None:
    """k [1/m] of a = −k v |v| for the recording's seed and air at `speed` [m/s], as of
    a sphere of equal volume (bench.air); None where the seed is not described."""
    seed = recording.seed
    if not recording.air.density_kg_m3:
        return 0.0
    if not seed.sizes_mm or not (seed.mass_g or seed.density_kg_m3):
        return None
    about = {
        "seed": seed.model_dump(exclude_none=True),
        "air": recording.air.model_dump(exclude_none=True),
    }
    return drag_at(air_of(about), max(speed, SLOWEST_M_S))
