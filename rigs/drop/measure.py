"""One drop → heights, speeds and restitution, and a table of its bounces: the fit of
the rig's model to that recording, with nothing missing.

    rebound_height      of the centroid, from the first contact to the highest place
    restitution         √(H₂/H₁): H₂ that height, H₁ the fall, seen and as stated
    impact_speed        vertical, at the first contact; rebound_speed: after it
    restitution_normal  rebound_speed over impact_speed
    fall_acceleration   of a fall without impact, drag included

Films, tracks, few rows and light gates are evidence of the same model; a stated height
is evidence of the fall. Heights are those of the centroid above its height at contact:
the fall of a seed that does not turn is the clearance of its lowest point. A quantity
is good where its 95 % interval would still hold if the next likeliest explanation, an
effect of `effects/`, were true."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
import pandas as pd

from benchtwin.bench.air import Air, drag_at
from benchtwin.bench.constants import G_M_S2
from benchtwin.bench.distributions import t as student
from benchtwin.bench.language import tr
from benchtwin.bench.priors import UNKNOWN_DISTANCE_M, unstated_sd
from benchtwin.infer.noise import (
    Noise,
    about_slopes,
    estimate,
    frame_lag,
    spreads,
)
from benchtwin.infer.problem import Fit, fit
from benchtwin.infer.rivals import INSIDE_SDS, Rival, unless
from benchtwin.rigs.drop.flight_model import (
    FLAT,
    START,
    Model,
    build,
    contact_states,
    pictured,
    places,
    points_at,
    pushed,
    released,
    velocities,
)
from benchtwin.rigs.drop.nuisances import HEIGHT, LOCK, READOUT
from benchtwin.rigs.drop.read import SCALE_OF_GRAVITY_SD, SeenTrack, flights_of, flown
from benchtwin.rigs.drop.reduction import problem_of, slopes_at
from benchtwin.rigs.drop.session import Session, assemble
from benchtwin.rigs.drop.track_noise import TrackNoise, estimate_noise, floored
from benchtwin.rigs.one_recording import OneRecording
from benchtwin.vision.measurement import (
    DOUBTFUL,
    GOOD,
    MeasurementError,
    Quantity,
    all_failed,
    failed,
)
from benchtwin.vision.motion.flight import Flights
from benchtwin.vision.motion.least_squares import all_stated, variance_factor
from benchtwin.vision.motion.track import Track
from benchtwin.vision.recording import Recording

QUANTITIES = (
    ("rebound_height", "mm"),
    ("restitution", "1"),
    ("impact_speed", "m/s"),
    ("rebound_speed", "m/s"),
    ("restitution_normal", "1"),
)
WHITE = Noise(0.0, 0.0, 1.0)
CONTRADICTION_SDS = 3.0  # of what is stated
LEAST_FRAMES = 5  # of a flight whose speed is good
BELOW, ABOVE = 0.02, 1.0  # restitution of a free bounce
LAWS_FELT = ("scale", "air", "air-slope")  # globals on which lengths and speeds depend
SPEEDS = ("impact_speed", "rebound_speed", "lateral_before", "lateral_after")
SURE = 0.9  # share of a height's sd by which it may be off without a word
SLIPPED_SDS = 4.0  # off the fall, of each row before the impact
VAGUE = 0.1  # relative sd from which a number is doubtful
MANY = 5  # rows a parameter, with which effects are told from noise
CURVE_POINTS = 80
LENGTH = "length beside the scale"  # by which lengths are other, relative
DRIFT = "drift"  # of speeds across and up, by how far the optical axis is off


@dataclass(frozen=True)
class Rebound:
    """Result for a drop; `track` has its outliers marked; curves: (times, heights,
    sideways places) of each fitted flight from contact to contact, in the track's units
    and along gravity."""

    quantities: tuple[Quantity, ...]
    bounces: pd.DataFrame | None
    flights: Flights | None
    track: Track
    notes: tuple[str, ...] = ()
    curves: tuple[tuple[np.ndarray, np.ndarray, np.ndarray], ...] = ()
    readout_s: float = 0.0  # of a rolling shutter, with which it was measured


@dataclass(frozen=True, eq=False)
class Evidence:
    """A recording as it is fitted. track: without outliers; unit, clock: of its lengths
    [m] and times [s], where they are not believed a first guess; believed: whether
    scale and frame rate are stated and gravity does not contradict them; axis: where
    the optical axis passes, in the track's unit, or None; readout_sd [s]: of a rolling
    shutter's readout."""

    recording: Recording
    track: Track
    flights: Flights
    unit: float
    clock: float
    believed: bool
    axis: tuple[float, float] | None = None
    readout_sd: float = 0.0

    @cached_property
    def seen(self) -> SeenTrack:
        """The track in millimetres and seconds."""
        mm = 1e3 * self.unit
        seen = flown(self.track, self.recording, self.flights, mm, self.clock)
        seen = replace(seen, readout_sd_s=self.readout_sd)
        if not self.believed:
            camera = seen.description["camera"]
            pixel = mm if self.track.unit == "px" else camera.get("mm_per_px", 0.0)
            camera |= {"scale_sd": SCALE_OF_GRAVITY_SD, "mm_per_px": pixel}
        return seen

    @cached_property
    def of_length(self) -> tuple[float, float]:
        """Share of the fitted scale, which is that of lengths over gravity's, by which
        lengths are other than read, and their relative sd beside it."""
        scale, gravity = self.recording.scale_sd, unstated_sd("gravity")
        if not self.believed:  # lengths are as read
            return 0.0, scale if self.track.unit == "mm" else 0.0
        whole = math.hypot(scale, gravity)
        return (scale / whole) ** 2, scale * gravity / whole

    @cached_property
    def session(self) -> Session:
        """Its rows; no height is stated."""
        gates = self.recording.evidence == "gates.csv"  # no camera looks on
        away = math.inf if gates else UNKNOWN_DISTANCE_M
        made = assemble((self.seen,), away)
        made = replace(made, release=np.array([np.nan]))
        if self.axis is None:
            return made
        turn = math.radians(self.recording.camera.plumb_deg or 0.0)
        x, y = self.unit * np.array(self.axis)
        c, s = math.cos(turn), math.sin(turn)
        middle = np.array([x * c - y * s, x * s + y * c])
        return replace(made, view=replace(made.view, middle=middle))


@dataclass(frozen=True, eq=False)
class Fitted:
    """Evidence and its fit."""

    told: Evidence
    fit: Fit

    @property
    def model(self) -> Model:
        return self.fit.problem.model

    @property
    def bounces(self) -> int:
        return len(self.model.session.joint)

    @cached_property
    def one(self) -> OneRecording:
        """The fit as quantities are read from it."""
        flights = range(len(self.fit.starts))
        own = tuple(f"{name} {f}" for f in flights for name in START)
        return OneRecording(self.fit, own, self.quantities_at, beside=self.beside)

    @cached_property
    def beside(self) -> dict[str, tuple[float, float]]:
        """What the fit leaves open, with its sd: lengths; and of each flight, where the
        place of the optical axis is unknown, anywhere in the view, the speeds [m/s] in
        the picture: off by a, a seed that comes nearer by v_y seems to go a
        v_y/distance faster."""
        out, s = {LENGTH: (0.0, self.told.of_length[1])}, self.model.session
        if self.told.axis is None:
            off = s.view.reach / math.sqrt(3) / s.away[0]
            sds = (off * np.sqrt(self.model.aside_square)).tolist()
            for f, sd in enumerate(sds):
                out |= {f"{DRIFT} {axis} {f}": (0.0, sd) for axis in "xz"}
        return out

    def quantities_at(self, at: Mapping[str, float]) -> dict[str, float]:
        """The quantities for some parameters; of each bounce, with its number, its
        time, height of contact, speeds before and after it, up and across, height of
        the rebound and restitution; in the track's units, speeds in m/s where these are
        known, lengths as true as they can be known."""
        model, told = self.model, self.told
        flights = range(len(self.fit.starts))
        starts = np.array([[at[f"{name} {f}"] for name in START] for f in flights])
        values = {n: at[n] for n in self.fit.names}
        drift = np.array(
            [[at.get(f"{DRIFT} {c} {f}", 0.0) for c in "xz"] for f in flights]
        )
        scale = 1 + values["scale"]
        push = pushed(model, starts, values)
        time, touch, speed = contact_states(model, starts, push)
        count, (before, after) = self.bounces, model.session.joint.T
        turn = time + speed[count:, 1] / G_M_S2
        top = points_at(model.session, after, turn)
        left = velocities(top, starts, push)[:, 1]  # less than air takes
        high = places(top, starts, push)[:, 1] + left**2 / (2 * G_M_S2)
        contact = touch[:count, 1]
        fall = released(model, starts, push, values)[0] - contact[0]
        into = speed[:count] + scale * drift[before]
        out = speed[count:] + scale * drift[after]
        # a drift of the speed moves the height by v dv/g
        high = high - contact + (out[:, 1] ** 2 - speed[count:, 1] ** 2) / (2 * G_M_S2)
        fall += (into[0, 1] ** 2 - speed[0, 1] ** 2) / (2 * G_M_S2)
        length = 1 + told.of_length[0] * values["scale"] + at[LENGTH]
        length /= scale * told.unit
        fast = length * told.clock * (1e-3 if told.track.physical else 1.0)
        middle = model.session.view.middle[1]
        found = {
            "t": time / told.clock,
            "contact": (middle + (contact - middle) / scale) / told.unit,
            "impact_speed": -fast * into[:, 1],
            "rebound_speed": fast * out[:, 1],
            "lateral_before": fast * into[:, 0],
            "lateral_after": fast * out[:, 0],
            "rebound_height": length * high,
            "restitution_normal": -out[:, 1] / into[:, 1],
        }
        ratio = math.sqrt(max(high[0], 0.0) / fall) if fall > 0 else math.nan
        return {"fall": length * fall, "restitution": ratio} | {
            of_bounce(name, k): float(value)
            for name, each in found.items()
            for k, value in enumerate(each)
        }

    @cached_property
    def rivals(self) -> list[Rival]:
        """Each effect that this recording may show, fitted in full."""
        return self.one.rivals()

    @cached_property
    def known(self) -> dict[str, Quantity]:
        """All quantities with their sds and what of these is common to a session,
        without doubts."""
        track = self.told.track
        speed = "m/s" if track.physical else f"{track.unit}/{track.time_unit}"
        kinds = {
            "t": track.time_unit,
            "contact": track.unit,
            "rebound_height": track.unit,
        }
        kinds |= dict.fromkeys(SPEEDS, speed) | {"restitution_normal": "1"}
        units = {
            of_bounce(name, k): unit
            for k in range(self.bounces)
            for name, unit in kinds.items()
        }
        units |= {"fall": track.unit, "restitution": "1"}
        return self.one.quantities(units, [*self.fit.names, LENGTH])


def of_bounce(name: str, bounce: int) -> str:
    """Name of a quantity of a bounce; that of the first is the recording's."""
    return name if bounce == 0 else f"{name} {bounce + 1}"


def measure_drop(
    track: Track,
    recording: Recording,
    axis: tuple[float, float] | None = None,
) -> Rebound:
    """Measure a drop and its bounces; of a track from pictures, axis: where the optical
    axis passes. A readout that is not stated lies between 0 and a frame."""
    readouts, readout_sd = [recording.camera.readout_s or 0.0], 0.0
    if track.late is None or not track.timed:
        readouts = [0.0]
    elif recording.camera.readout_s is None:
        readouts = [share * track.step for share in (0.0, 0.5, 1.0)]
        readout_sd = track.step / math.sqrt(3)  # about an end of its range
    try:
        seen = [(flights_of(track.read_out(r), recording), r) for r in readouts]
        flights, readout = max(seen, key=lambda found: _told_rows(found[0]))
        told = _evidence(track.read_out(readout).used(), recording, flights)
        told = replace(told, axis=axis, readout_sd=readout_sd)
        bounces = len(flights.rows) > 1
        if flights.few and track.physical and bounces:  # too few to judge gravity by
            told = replace(told, unit=1e-3, believed=True)
        free = Fitted(told, _fitted(told))
    except ValueError as error:
        return Rebound(all_failed(QUANTITIES, str(error)), None, None, track)
    mask = track.outlier.copy()
    mask[np.flatnonzero(~track.outlier)[flights.outlier]] = True
    marked, notes = track.marked(mask), _said(told)
    doubt, found = _contradiction(free), free
    if told.track.physical and not doubt:
        told = replace(told, unit=1e-3, believed=True)
        found = Fitted(told, _again(free, told.session))
    if readout_sd:
        readout += found.fit.by_name[READOUT]
        sd = found.fit.sd(READOUT)
        best = f"{1e3 * readout:.2g} ± {1e3 * sd:.1g} ms"
        notes.append(
            tr(
                "[camera] readout_s is not stated; falling and rising parts agree best"
                " at {}, which the sds allow for",
                best,
            )
        )
    joint = found.model.session.joint
    if not len(joint) or joint[0, 0] != 0:
        fall = _fall_acceleration(free)
        quantities = (*all_failed(QUANTITIES, _no_bounce(told)), *fall)
        notes += [doubt] if doubt else [] if told.track.physical else _scale_note(found)
        said, curves = tuple(notes), _curves(found)
        return Rebound(quantities, None, flights, marked, said, curves, readout)
    notes += [] if doubt else _scale_note(found)
    found, (said, doubts) = _with_height(found)
    bounces = _bounce_table(found)
    if doubt:  # of all lengths and speeds
        bounces = bounces.assign(quality=DOUBTFUL)
    quantities, curves = _quantities(found, doubt, doubts), _curves(found)
    everything = tuple(notes + said)
    return Rebound(quantities, bounces, flights, marked, everything, curves, readout)


def _told_rows(flights: Flights) -> tuple[int, float]:
    """How many rows some flights explain, and how well."""
    return sum(map(len, flights.rows)), -flights.noise


def _evidence(track: Track, recording: Recording, flights: Flights) -> Evidence:
    """In metres and seconds by what gravity makes of the fall."""
    unit, clock, gamma = 1e-3, 1.0, flights.free
    if not gamma > 0:
        raise MeasurementError(tr("nothing in the track falls freely (is y upwards?)"))
    if not track.timed:
        if track.unit != "mm":
            begin, end = flights.apex_time(0), flights.time[flights.rows[0][-1]]
            fall = float(flights.height(0, begin) - flights.height(0, end))
            high = recording.drop.height_mm or unstated_sd("fall")
            unit = high / 1000 / max(fall, 1e-9)
        clock = math.sqrt(gamma * unit / G_M_S2)
    else:
        unit = G_M_S2 / gamma
    return Evidence(recording, track, flights, unit, clock, believed=False)


def _fitted(told: Evidence) -> Fit:
    """The flights of one recording, their noise estimated about the fit; of few rows
    with stated sds these, unless rows scatter more."""
    s, sd = told.session, told.track.sd
    model, white = build(s), estimate_noise(s, (WHITE, WHITE))
    stated = told.flights.few and all_stated(sd)
    if stated:
        known = np.full((1, 2), told.unit * float(np.median(sd)))
        white = replace(white, sigma=floored(s, known))
    first = fit(problem_of(model, white))
    freedom = max(len(s.tau) - 2 * len(s.middle) - (not told.believed), 1)
    if stated and variance_factor(first.chi2, freedom, stated)[0] == 1.0:
        return first
    return fit(problem_of(model, _noise_about(first)), start=first)


def _again(of: Fitted, session: Session) -> Fit:
    """The same rows with the same noise in another session."""
    reduce, before = of.fit.problem.reduce, of.model.session
    assert isinstance(reduce, partial)
    noise = reduce.args[1]
    times = np.ptp(session.places[:, 1]) / np.ptp(before.places[:, 1])
    made = problem_of(build(session), replace(noise, sigma=times * noise.sigma))
    near = times == 1.0
    return fit(replace(made, starts=of.fit.starts) if near else made)


def _noise_about(base: Fit) -> TrackNoise:
    """Noise about the fit and its slopes, with sds so wide that ± 1.96 sd is a 95 %
    interval; effects' slopes too, where rows are many, so that what may be missing is
    not taken for noise."""
    model, axes, sigma = base.problem.model, [], np.zeros((1, 2))
    s, names = model.session, base.names
    found = slopes_at(model, base.starts, base.by_name)
    many, own = len(s.tau) > MANY * len(names), found.own.shape[2]
    shared = [own + k for k, n in enumerate(names) if many or n in LAWS_FELT]
    lag = np.concatenate(
        [frame_lag(s.frame[a:b]) for a, b in zip(s.first, s.stop, strict=True)]
    )
    each = (s.flight[:, None] == np.arange(len(base.starts)))[..., None]
    for axis in (0, 1):
        slopes = found.rows[:, axis]
        starts = (each * slopes[:, None, :FLAT]).reshape(len(lag), -1)
        design = s.weight[:, None] * np.hstack([starts, slopes[:, shared]])
        left = s.weight * (s.places - found.seen)[:, axis]
        about = [about_slopes(design, left, lag)]
        noise = estimate(about)
        spare = len(left) - about[0].design.shape[1]
        if noise.log_level_sd >= WHITE.log_level_sd:  # too few rows to tell
            noise = replace(noise, log_level_sd=math.sqrt(2 / max(spare, 1)))
        wider = student.ppf(0.975, 2 / noise.log_level_sd**2) / INSIDE_SDS
        sigma[0, axis] = wider * spreads(about, [0], 1, noise)[0]
        axes.append(noise)
    return TrackNoise((axes[0], axes[1]), floored(s, sigma))


def _contradiction(free: Fitted) -> str:
    """How the acceleration of the flights contradicts the stated scale and frame rate;
    "" where it does not, or nothing is stated."""
    told, recording = free.told, free.told.recording
    ratio = 1e-3 / (told.unit * (1 + free.fit.by_name["scale"]))
    known = (recording.scale_sd, unstated_sd("gravity"), free.fit.sd("scale"))
    certain = abs(ratio - 1) > CONTRADICTION_SDS * math.hypot(*known)
    if not told.track.physical or not certain:
        return ""
    text = tr("free fall gives {:.3g} m/s² instead of 9.81", ratio * G_M_S2)
    rate = math.sqrt(ratio)
    fps = tr(
        "the frame rate is stated {:.3g} × too {}",
        max(rate, 1 / rate),
        tr("high") if ratio > 1 else tr("low"),
    )
    scale = tr(
        "the scale (mm_per_px) {:.3g} × too {}",
        max(ratio, 1 / ratio),
        tr("large") if ratio > 1 else tr("small"),
    )
    stated = recording.drop.height_mm
    if stated and len(free.model.session.joint) and told.flights.release_seen():
        fall = free.one.at["fall"]
        if abs(fall / stated - 1) < 0.03:
            return tr(
                "{}: {} (the fall of {:g} mm is right, so the scale is)",
                text,
                fps,
                stated,
            )
        if abs(fall / stated / ratio - 1) < 0.05:
            return tr(
                "{}: {} (the fall reads {:.4g} mm instead of {:g})",
                text,
                scale,
                fall,
                stated,
            )
    return f"{text}: {fps}, or {scale}"


def _with_height(found: Fitted) -> tuple[Fitted, tuple[list[str], list[str]]]:
    """The fit with the stated height as evidence of the fall, unless it is
    contradicted; notes, and doubts of the restitution."""
    told = found.told
    stated, track = told.recording.drop.height_mm, told.track
    off_sd, both = told.recording.drop.height_sd, found
    if stated and told.believed:
        session = replace(told.session, release=np.array([stated / 1000]))
        both = Fitted(told, _again(found, session))
        if abs(both.fit.by_name[HEIGHT]) < SURE * off_sd:
            return both, ([], [])
    fall, fall_sd = found.known["fall"].value, found.known["fall"].sd
    if not stated or track.unit != "mm":
        said = tr("H1 is the fall seen, {:.5g} ± {:.2g} {}", fall, fall_sd, track.unit)
        return found, ([said] if told.flights.release_seen() else [], [])
    notes = []
    if abs(fall - stated) > off_sd + 2 * fall_sd:
        notes = [
            tr(
                "the fall seen is {:.4g} ± {:.2g} mm but [drop] height_mm says {:g}",
                fall,
                fall_sd,
                stated,
            )
        ]
    if not told.believed or not math.isfinite(fall):
        return found, (notes, notes)
    if abs(fall - stated) > max(3 * math.hypot(fall_sd, off_sd), 0.02 * stated):
        return found, (
            notes,
            [tr("{}: one of them is in a wrong unit or wrong", notes[0])],
        )
    return both, (notes, [])


def _quantities(found: Fitted, doubt: str, doubts: list[str]) -> tuple[Quantity, ...]:
    """With their doubts; doubt: why scale and clock are not believed; doubts: of the
    stated height."""
    told, known = found.told, {name: found.known[name] for name, _ in QUANTITIES}
    stated, track = told.recording.drop.height_mm, told.track
    if not told.flights.release_seen() and (not stated or track.unit == "px"):
        missing = (
            tr("[camera] mm_per_px is missing, which height_mm needs")
            if stated
            else tr("[drop] height_mm is needed")
        )
        text = tr(
            "the release is not in the track; {}: {}", told.recording.toml, missing
        )
        known["restitution"] = failed("restitution", "1", text)
    known["restitution"] = known["restitution"].doubt(*doubts)
    if doubt:
        ratios = {"restitution_normal", *(() if stated else ("restitution",))}
        rolls = told.track.late is not None and not told.readout_sd
        ratios = set() if rolls else ratios  # the readout that is stated may be wrong
        ratios &= _alike_by_clock(found)
        known = {n: q if n in ratios else q.doubt(doubt) for n, q in known.items()}
    e = known["restitution_normal"].value
    return tuple(_doubtful(q, found, e) for q in known.values())


def _alike_by_clock(found: Fitted) -> set[str]:
    """The quantities that are the same if the scale is right and the clock wrong: air
    takes another share then."""
    told = found.told
    clock = math.sqrt(1e-3 * told.flights.free / G_M_S2)
    slow = replace(told, unit=1e-3, clock=clock)
    other = Fitted(slow, _fitted(slow)).one.at
    return {
        n
        for n, _ in QUANTITIES
        if abs(found.known[n].value - other[n]) < INSIDE_SDS * found.known[n].sd
    }


def _doubtful(quantity: Quantity, found: Fitted, e: float) -> Quantity:
    """The quantity with the doubts that apply to it."""
    told, flights = found.told, found.told.flights
    first, second = flights.rows[0], flights.rows[1]
    if quantity.name != "impact_speed" and not BELOW < e < ABOVE:
        quantity = quantity.doubt(
            tr("restitution {:.3g} is not that of a free bounce", e)
        )
    if not flights.few:
        if quantity.name != "impact_speed":
            quantity = _rebound_cut(quantity, flights)
            if len(second) < LEAST_FRAMES:
                quantity = quantity.doubt(
                    tr("only {} frames of the first rebound", len(second))
                )
        if len(first) < LEAST_FRAMES:  # they determine the height at contact
            quantity = quantity.doubt(
                tr("only {} frames before the first impact", len(first))
            )
    if quantity.value and quantity.sd > VAGUE * abs(quantity.value):
        quantity = quantity.doubt(tr("known no better than 10 %"))
    quantity = quantity.doubt(_slipped(told))
    sd = float(np.median(told.track.sd))
    noise, reach = flights.noise, float(np.ptp(told.track.y))
    if math.isfinite(sd) and noise > 5 * sd and noise > 0.003 * reach:
        quantity = quantity.doubt(
            tr(
                "places scatter {:.2g} {} about the parabolas, their stated sd is"
                " {:.2g}",
                noise,
                told.track.unit,
                sd,
            )
        )
    return (
        quantity.doubt(*unless(found.rivals, quantity)) if told.believed else quantity
    )


def _slipped(told: Evidence) -> str:
    """A doubt where the last rows before the impact, used or not, lie off the fall on
    one side: the tracker may hold another point of the seed from there on."""
    flights, track = told.flights, told.track
    up, _ = track.upright(told.recording.camera.plumb_deg)
    meets = flights.contact_time(0) - float(np.median(np.diff(track.time)))
    rows = slice(flights.rows[0][0], int(np.searchsorted(track.time, meets)))
    off = (up[rows] - flights.height(0, track.time[rows]))[::-1]
    far = np.sign(off) * (np.abs(off) > SLIPPED_SDS * flights.noise)
    count = int(
        np.argmin(np.append(far != 0, False) & np.append(far == far[:1], False))
    )
    leap = np.abs(np.diff(off[count - 1 : count + 1]))  # drag bends, and leaps nowhere
    if count < 2 or not (leap > SLIPPED_SDS * flights.noise).all():
        return ""
    return tr(
        "the last {} rows before the impact lie {:.2g} {} off the fall: did the tracker"
        " slip?",
        count,
        abs(np.median(off[:count])),
        track.unit,
    )


def _rebound_cut(quantity: Quantity, flights: Flights) -> Quantity:
    """The quantity where the track ends before the rebound's highest place."""
    second, top = flights.rows[1], flights.apex_time(1)
    last = flights.time[second[-1]]
    if last >= top:
        return quantity
    low, high, end = (
        flights.height(1, t) for t in (flights.contact_time(0), top, last)
    )
    share = float((end - low) / max(high - low, 1e-12))  # of the rise that is seen
    of_height = quantity.name in ("rebound_height", "restitution")
    if of_height and (len(second) < 8 or share < 0.6):
        text = tr(
            "the recording stops before the rebound's highest point ({} frames, {:.0f}"
            " % of it)",
            len(second),
            100 * share,
        )
        text = quantity.reason if quantity.quality == "failed" else text
        return failed(quantity.name, quantity.unit, text)
    return quantity.doubt(
        tr("the track ends before the rebound's highest place, which is extrapolated")
    )


def _bounce_table(found: Fitted) -> pd.DataFrame:
    """A row for each bounce, numbers with sds; columns have the track's units."""
    told, flights = found.told, found.told.flights
    track, recording = told.track, told.recording
    length, time = track.unit, track.time_unit
    speed = "m_s" if track.physical else f"{length}_{time}"
    columns = {
        "t": ("t", f"_{time}"),
        "contact": ("contact", f"_{length}"),
        "speed_before": ("impact_speed", f"_{speed}"),
        "speed_after": ("rebound_speed", f"_{speed}"),
        "lateral_before": ("lateral_before", f"_{speed}"),
        "lateral_after": ("lateral_after", f"_{speed}"),
        "height": ("rebound_height", f"_{length}"),
        "restitution": ("restitution_normal", ""),
    }
    rows, session = [], found.model.session
    turned = np.column_stack([session.spin, session.spin_sd])
    spin = told.clock * np.where(session.spin[:, None] == 0, np.nan, turned)
    for k, (before, after) in enumerate(session.joint):
        row = {"recording": recording.id, "drop": 1, "bounce": k + 1}
        for column, (name, unit) in columns.items():
            q = found.known[of_bounce(name, k)]
            row |= {f"{column}{unit}": q.value, f"{column}_sd{unit}": q.sd}
        for column, flight in (("spin_before", before), ("spin_after", after)):
            row[f"{column}_rad_{time}"], row[f"{column}_sd_rad_{time}"] = spin[flight]
        few = min(len(flights.rows[before]), len(flights.rows[after])) < LEAST_FRAMES
        cut = flights.time[flights.rows[after][-1]] < flights.apex_time(after)
        e = found.known[of_bounce("restitution_normal", k)]
        free = BELOW < e.value < ABOVE and e.sd <= VAGUE * e.value
        unsure = told.believed and unless(found.rivals, e)
        row["quality"] = DOUBTFUL if few or cut or not free or unsure else GOOD
        rows.append(row)
    order = ["recording", "drop", "bounce", f"t_{time}", f"t_sd_{time}"]
    table = pd.DataFrame(rows)
    if not np.ptp(track.x):  # places across were not measured
        table.loc[:, [c for c in table if c.startswith("lateral")]] = np.nan
    kinds = ("speed", "lateral", "spin", "contact", "height", "restitution", "quality")
    order += [c for kind in kinds for c in table if c.startswith(kind)]
    return table[order]


def _fall_acceleration(free: Fitted) -> tuple[Quantity, ...]:
    """Quantity fall_acceleration of a fall without impact, drag included; none without
    scale or clock."""
    told = free.told
    if not told.track.physical:
        return ()
    value, stated = told.flights.free / 1000, told.recording.scale_sd
    sd, believed = (
        value * math.hypot(of, stated)
        for of in (free.fit.sd("scale"), free.fit.problem.known_sd["scale"])
    )
    return (Quantity("fall_acceleration", value, sd, "m/s²", believed_sd=believed),)


def _no_bounce(told: Evidence) -> str:
    up, _ = told.track.upright(told.recording.camera.plumb_deg)
    rows = told.flights.rows[0]
    drop = np.ptp(up[rows])
    end = up[-max(3, len(up) // 50) :]
    if np.ptp(end) < 0.01 * drop and len(up) - rows[-1] > 5:
        return tr(
            "no rebound: after falling {:.4g} {} the seed stays down",
            drop,
            told.track.unit,
        )
    return tr(
        "no impact in the track: one flight of {:.4g} {}, no bounce (does the recording"
        " end too early?)",
        drop,
        told.track.unit,
    )


def _curves(found: Fitted) -> tuple[tuple[np.ndarray, np.ndarray, np.ndarray], ...]:
    """See Rebound."""
    told, model, of = found.told, found.model, found.fit
    push = pushed(model, of.starts, of.by_name)
    s = model.session
    times = contact_states(model, of.starts, push)[0]
    ends = {int(f): t for (f, _), t in zip(s.joint, times, strict=True)}
    begins = {int(f): t for (_, f), t in zip(s.joint, times, strict=True)}
    # what depends on the seed's turn, or on the pixels, is not drawn
    smooth = {n: v for n, v in of.by_name.items() if not n.startswith((LOCK, "wobble"))}
    out = []
    for f in range(len(s.middle)):
        low = begins.get(f, s.middle[f] - s.half[f])
        high = ends.get(f, s.middle[f] + s.half[f])
        time = np.linspace(low, high, CURVE_POINTS)
        at = points_at(s, np.full(len(time), f), time)
        seen = pictured(places(at, of.starts, push), s.view, smooth) / told.unit
        out.append((time / told.clock, seen[:, 1], seen[:, 0]))
    return tuple(out)


def _scale_note(found: Fitted) -> list[str]:
    """Notes on a scale or frame rate that is not stated, as gravity gives it."""
    told, scale, sd = found.told, found.fit.by_name["scale"], found.fit.sd("scale")
    if told.believed:
        text = tr(
            "gravity corrects the scale by {:.2f} % within its stated sd", 100 * scale
        )
        return [text] if abs(scale) > 2e-3 else []
    if told.track.timed:
        mm, relative = 1e3 * told.unit * (1 + scale), sd / (1 + scale)
        return [
            tr(
                "gravity makes it {:.5g} ± {:.2g} mm per px (if the frame rate is"
                " right)",
                mm,
                mm * relative,
            )
        ]
    if told.track.unit == "mm":
        rate, relative = math.sqrt(1 + scale) / told.clock, sd / 2 / (1 + scale)
        return [
            tr(
                "gravity makes it {:.5g} ± {:.2g} frames per second (if the scale is"
                " right)",
                rate,
                rate * relative,
            )
        ]
    return []


def air_in_words(air: Air, fastest_m_s: float) -> list[str]:
    """A note on the air, none without any."""
    if not air.share:
        return []
    if air.sd >= air.share:
        missing = tr("[seed] sizes and mass_g or density_kg_m3 are unknown")
        return [tr("air drag is a usual seed's, ± 100 %: {}", missing)]
    most = drag_at(air, fastest_m_s) * fastest_m_s**2 / G_M_S2
    return [tr("air drag (up to {:.1f} % of the weight) is allowed for", 100 * most)]


def _said(told: Evidence) -> list[str]:
    """What the numbers are based on."""
    track, flights, notes = told.track, told.flights, []
    if not track.physical:
        unknown = (["scale"] if track.unit == "px" else []) + (
            [] if track.timed else [tr("frame rate")]
        )
        notes.append(
            tr(
                "{} unknown: lengths in {}, times in {}; ratios do not need them",
                tr(" and ").join(unknown),
                track.unit,
                track.time_unit,
            )
        )
    air = told.session.air[0]
    speed = abs(float(flights.speed(0, flights.time[flights.rows[0][-1]])))
    speed *= told.unit / told.clock
    notes += air_in_words(air, speed)
    if flights.outlier.any():
        notes.append(
            tr(
                "{} frames lie off their flight and were left out (marked as outliers)",
                int(flights.outlier.sum()),
            )
        )
    if flights.unused:
        began = f"{flights.time[flights.rows[0][0]]:.4g} {track.time_unit}"
        notes.append(
            tr(
                "before {} the place moves, but not in a free fall (a hand, or a slip"
                " of the tracker): these rows are not used",
                began,
            )
        )
    return notes
