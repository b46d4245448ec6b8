"""Speeds and restitution of a drop from the times of its impacts.

A hop that starts and ends on the plate lasts Δt = 2 v / g, so v = g Δt / 2, its height
is g Δt² / 8, and the restitution of the impact between two hops is e = Δt₂ / Δt₁. The
first impact's speed is √(2 g H) of the stated fall, which the later bounces correct
(first_bounce.py). Drag is that of the stated seed, or of a usual one, at three quarters
of the first speed (a = −g − k v |v|, in closed form). Errors of times, of drag and of
gravity are carried on to first order; those of drag and gravity are common to all
recordings."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from benchtwin.bench.air import air_of, drag_of_hops, through_air
from benchtwin.bench.constants import G_M_S2
from benchtwin.bench.ellipsoid import elongation
from benchtwin.bench.language import tr
from benchtwin.bench.priors import unstated_sd
from benchtwin.rigs.drop.first_bounce import first_bounce, first_flat_sd
from benchtwin.rigs.drop.measure import QUANTITIES, air_in_words
from benchtwin.rigs.drop.read import describe
from benchtwin.vision.measurement import (
    DOUBTFUL,
    FAILED,
    GOOD,
    Quantity,
    all_failed,
    failed,
    vague,
)
from benchtwin.vision.motion.impact_chain import estimate_time_sds
from benchtwin.vision.motion.least_squares import slopes
from benchtwin.vision.recording import Recording

LONGEST_S = 20.0  # of an interval (490 m up): longer ones are times in another unit
NOT_FIRST = (
    "the impacts before were not all heard, so the speed of the first of these is"
    " unknown"
)
# share of a fall's energy lost to the air, above which √(H2/H1) is no restitution
MOST_LOST = 0.1
INSIDE_SDS = 1.96
JUMP = 2.0  # greatest factor between successive restitutions
UNITS = {"before": "m/s", "after": "m/s", "rise": "mm", "e": "1"}


@dataclass(frozen=True, eq=False)
class Bounces:
    """Of n impacts, each before a hop, by name (UNITS): speed before (NaN where it is
    unknown) and after, height of the hop, restitution; moved (n, n + 3) [the same
    unit]: by one sd of each time, of drag and of gravity."""

    times: np.ndarray
    sd: np.ndarray
    value: dict[str, np.ndarray]
    moved: dict[str, np.ndarray]

    @classmethod
    def of(
        cls,
        times: np.ndarray,
        sd: np.ndarray,
        height_mm: float | None,
        drag: float,
        drag_sd: float,
    ) -> "Bounces":
        """height_mm: the first fall, None where it is unknown; drag: k [1/m]."""
        count = len(times) - 1
        height_m = height_mm / 1000 if height_mm else None

        def found(x: np.ndarray) -> np.ndarray:
            before, after, rise = through_air(np.diff(x[:-2]), height_m, x[-2])
            gravity = np.where(np.arange(count), 1 + x[-1], math.sqrt(1 + x[-1]))
            before, after = before * gravity, after * (1 + x[-1])
            return np.stack([before, after, 1000 * rise * (1 + x[-1]), after / before])

        x, sds = np.append(times, [drag, 0.0]), [*sd, drag_sd, unstated_sd("gravity")]
        moved = slopes(lambda x: found(x).ravel(), x, np.array(sds)) * sds
        moved = moved.reshape(len(UNITS), count, -1)
        return cls(
            times,
            sd,
            dict(zip(UNITS, found(x), strict=True)),
            dict(zip(UNITS, moved, strict=True)),
        )

    def quantity(self, column: str, name: str, k: int = 0) -> Quantity:
        """Of impact k."""
        sd, common = (
            float(np.linalg.norm(part[k]))
            for part in (self.moved[column], self.moved[column][:, -2:])
        )
        value = float(self.value[column][k])
        return Quantity(name, value, sd, UNITS[column], sd_common=common)

    def with_fall(self, height_mm: float, recording: Recording) -> "Fall":
        """The first impact by the stated fall and the later bounces."""
        height_sd = recording.drop.height_sd
        e, by_rest = self.value["e"], self.moved["e"][:, :-1]
        told = first_bounce(
            e,
            by_rest @ by_rest.T,
            self.value["before"],
            height_mm,
            math.hypot(height_sd, unstated_sd("gravity") * height_mm),  # alike to e
            first_flat_sd(elongation(recording.seed.sizes_mm)),
        )
        common = math.hypot(by_rest[0, -1], told.by_height)
        lost = 1 - self.value["before"][0] ** 2 / (2e-3 * G_M_S2 * height_mm)
        by_height = math.sqrt(self.value["rise"][0] / height_mm) / float(e[0])
        normal = Quantity(
            "restitution_normal",
            told.value,
            told.sd,
            "1",
            sd_common=common,
            believed_sd=unstated_sd("restitution"),
        )
        after = self.quantity("after", "rebound_speed")
        own = math.sqrt(max(after.sd**2 - after.sd_common**2, 0.0)) / after.value
        value = after.value / told.value
        impact = Quantity(
            "impact_speed",
            value,
            value * math.hypot(told.sd / told.value, own),
            "m/s",
            sd_common=value / told.value * common,
        )
        doubt = told.doubt(height_sd)
        return Fall(normal, impact, by_height, lost, doubt, told.low_mm < 0)


@dataclass(frozen=True)
class Fall:
    """The first impact where its fall is stated. by_height: √(H2/H1) over its
    restitution; lost: share of the fall's energy that the air takes; doubt: about the
    stated height; too_high: whether that would be too high, as where the first impact
    was not heard."""

    normal: Quantity
    impact: Quantity
    by_height: float
    lost: float
    doubt: str
    too_high: bool


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
            tr(
                "no sd_s is stated: each impact's time is taken to be known to {:.2g}"
                " ms, by rounding and scatter",
                1000 * sd[0],
            )
        )
    height = recording.drop.height_mm if first else None
    gap = np.diff(times)
    air, height_m = air_of(describe(recording)), height / 1000 if height else None
    drag, fast = drag_of_hops(air, height_m, float(gap[0]))
    drag_sd = drag * air.sd / air.share if air.share else 0.0
    bounces = Bounces.of(times, sd, height, drag, drag_sd)
    fall = bounces.with_fall(height, recording) if height else None
    table, notes = (
        _table(bounces, fall, recording.id),
        [*notes, *air_in_words(air, fast)],
    )
    e = table.restitution.to_numpy()
    missed, top = _missed_interval(e), float(bounces.value["rise"][0])
    if fall is not None and missed is not None and missed < 2:
        if len(e) > 2 and _missed_interval(e[1:]) is None:
            missed = None  # the bounces behind fit: it is the height's fault
        else:
            fall = replace(fall, doubt="")
    rebound = [
        bounces.quantity("rise", "rebound_height"),
        bounces.quantity("after", "rebound_speed"),
    ]
    if fall is None:
        found = [*rebound, *_without_fall(bounces, recording, first)]
    else:
        of_first, more = _of_fall(fall)
        found = [q.doubt(fall.doubt if fall.too_high else "") for q in rebound]
        found, notes = [*found, *of_first], [*notes, *more]
    by_name = {q.name: q for q in found}
    quantities = [by_name[name] for name, _ in QUANTITIES]
    if gap.max() > LONGEST_S:
        wrong = tr(
            "an interval of {:.4g} s between impacts: t_s is to be in seconds (are"
            " these milliseconds?)",
            gap.max(),
        )
        all_wrong = tuple(failed(q.name, q.unit, wrong) for q in quantities)
        return all_wrong, table, [*notes, wrong]
    if height and top > 1.1 * height + 3 * recording.drop.height_sd:
        why = _too_low(height, gap[0], top, e)
        return _without_height(times, given, recording, why)
    what = _even(table) or ("" if height else _too_far_up(top))
    if missed is not None:
        what = tr(
            "an impact seems to be missing: interval {} ({:.4g} s) does not fit the"
            " others",
            missed + 1,
            gap[missed],
        )
        notes.append(what)
    if what and (missed is None or missed < 2):
        quantities = [
            q if q.quality == FAILED or q.name == "impact_speed" else q.doubt(what)
            for q in quantities
        ]
    return tuple(q.doubt(vague(q)) for q in quantities), table, notes


def _table(bounces: Bounces, fall: Fall | None, recording_id: str) -> pd.DataFrame:
    """A row a bounce."""
    columns = {
        "speed_before{}_m_s": "before",
        "speed_after{}_m_s": "after",
        "height{}_mm": "rise",
        "restitution{}": "e",
    }
    rows: dict[str, np.ndarray] = {}
    for name, column in columns.items():
        rows[name.format("")] = bounces.value[column].copy()
        rows[name.format("_sd")] = np.linalg.norm(bounces.moved[column], axis=1)
    of_first = (("speed_before{}_m_s", "impact"), ("restitution{}", "normal"))
    for name, own in of_first if fall else ():
        q = getattr(fall, own)
        rows[name.format("")][0], rows[name.format("_sd")][0] = q.value, q.sd
    about = {"recording": recording_id, "drop": 1}
    about |= {"bounce": np.arange(1, len(bounces.times))}
    about |= {"t_s": bounces.times[:-1], "t_sd_s": bounces.sd[:-1]}
    return pd.DataFrame(about | rows | {"quality": _qualities(rows["restitution"])})


def _of_fall(fall: Fall) -> tuple[list[Quantity], list[str]]:
    """Quantities of the first impact, and notes."""
    notes, by_height, normal = [], fall.by_height, fall.normal.doubt(fall.doubt)
    if fall.lost > MOST_LOST:
        notes.append(
            tr(
                "the air takes {:.0f} % of the fall: √(H2/H1) = {:.4g} is no"
                " restitution; the ratio of the speeds is given",
                100 * fall.lost,
                by_height * normal.value,
            )
        )
        by_height = 1.0
    parts = ("value", "sd", "sd_common", "believed_sd")
    scaled = {part: by_height * getattr(normal, part) for part in parts}
    by_heights = replace(normal, name="restitution", **scaled)
    return [by_heights, fall.impact.doubt(fall.doubt), normal], notes


def _without_fall(
    bounces: Bounces, recording: Recording, first: bool
) -> list[Quantity]:
    """The same where the first fall is unknown: the restitution is the second
    impact's."""
    text, reason = tr(NOT_FIRST), tr(NOT_FIRST)
    if first:
        text = tr(
            "{}: [drop] height_mm is missing; the first impact's speed is needed",
            recording.toml,
        )
        reason = tr("[drop] height_mm is missing, so the first one's speed is unknown")
    unknown = all_failed((("restitution", "1"), ("impact_speed", "m/s")), text)
    if len(bounces.times) < 3:
        return [*unknown, failed("restitution_normal", "1", text)]
    second = bounces.quantity("e", "restitution_normal", 1)
    return [*unknown, second.doubt(tr("of the second impact: {}", reason))]


def _too_far_up(top_mm: float) -> str:
    """A doubt where a rebound is higher than falls are believed to be; ""."""
    if top_mm < INSIDE_SDS * unstated_sd("fall"):
        return ""
    return tr(
        "a rebound of {:.4g} mm, and no height is stated: are these the impacts of"
        " several drops?",
        top_mm,
    )


def _even(table: pd.DataFrame) -> str:
    """A doubt where no interval is known to be shorter than the one before, as of
    bounces; ""."""
    later, sd = table.restitution[1:], table.restitution_sd[1:]
    if not len(later) or (later + INSIDE_SDS * sd < 1).any():
        return ""
    return tr("the intervals do not shrink: are these the impacts of several drops?")


def _too_low(height: float, gap: float, top: float, e: np.ndarray) -> str:
    """Why the stated height [mm] is not that of the drop, with the height that the
    second bounce makes likely."""
    said = tr(
        "the first interval of {:.4g} s is a rebound of {:.4g} mm, higher than the drop"
        " ([drop] height_mm = {:g}): is height_mm in millimetres and t_s in seconds, or"
        " was an impact missed?",
        gap,
        top,
        height,
    )
    if len(e) > 1 and 0 < e[1] < 1:
        likely = float(f"{top / e[1] ** 2:.2g}")
        said += tr(" The bounces behind make {:g} mm likely", likely)
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
