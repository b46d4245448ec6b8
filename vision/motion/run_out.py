"""Roll rig: track from the release to the stop → run-out and rolling friction.

    μ_r = S sin β / (S cos β + L)

Eq. 3 of the soybean paper; energy balance, for any moment of inertia.
S is the distance rolled on the incline, L the run-out from the junction to the stop. On
each leg friction and slope are constant, so the path is two parabolas and a rest; at
the junction acceleration turns into deceleration."""

import math
from dataclasses import dataclass, replace

import numpy as np
from benchtwin.bench.robust import difference_noise
from benchtwin.vision.measurement import (
    FAILED,
    MeasurementError,
    Quantity,
    all_failed,
    failed,
)
from benchtwin.vision.motion.least_squares import (
    correlated_mean,
    estimate_rho,
    fit,
    frame_lag,
    whiten,
)
from benchtwin.vision.motion.outliers import single_spikes
from benchtwin.vision.motion.rolling_resistance import fit_resistance, resistance_notes
from benchtwin.vision.motion.track import Track
from benchtwin.vision.recording import Recording
from scipy.optimize import minimize_scalar

INCLINE_SD_DEG = 0.1  # of a stated incline
LENGTH_SD_MM = 0.2  # of a stated distance on the incline: a seed laid against a mark
QUANTITIES = (("run_out", "mm"), ("rolling_friction", "1"), ("rolling_resistance", "1"))
FEW = "{} usable frames; a run-out needs at least 8"
STILL_SHARE = 0.02  # of the greatest speed, below which a seed has stopped


@dataclass(frozen=True)
class RunOut:
    """Quantities; places along the path [track unit]; fitted: (time, x) for the plot;
    notes."""

    quantities: tuple[Quantity, ...]
    junction: float | None = None
    stop: float | None = None
    stop_time: float | None = None
    fitted: tuple[np.ndarray, np.ndarray] | None = None
    notes: tuple[str, ...] = ()


def measure_run_out(
    track: Track, recording: Recording, *, junction: tuple[float, float] | None = None
) -> RunOut:
    """Quantities run_out, rolling_friction, rolling_resistance; junction: (place, sd)
    along the path where the picture shows it."""
    used = track.used()
    spikes = single_spikes(used.x)
    try:
        found = _measure(used.take(~spikes), recording, junction)
    except MeasurementError as error:
        return RunOut(all_failed(QUANTITIES, str(error)))
    spike_notes = (
        [f"{spikes.sum()} single rows far off their neighbours are left out"]
        if spikes.any()
        else []
    )
    return replace(found, notes=(*spike_notes, *found.notes))


def ends_on_incline(time: np.ndarray, x: np.ndarray, incline_length_mm: float) -> bool:
    """Whether a seed did not leave the incline: its path, time [s] and x [mm] (n,), is
    no longer, and it was still accelerating. That is, the last quarter of the path took
    less time than the quarter before."""
    length_mm = np.maximum.accumulate(np.abs(x - x[0]))
    if not 0 < length_mm[-1] <= incline_length_mm + LENGTH_SD_MM:
        return False
    first = np.unique(length_mm, return_index=True)[
        1
    ]  # of each place, when it was there first
    half, later, last = np.interp(
        np.array([0.5, 0.75, 1.0]) * length_mm[-1], length_mm[first], time[first]
    )
    return bool(last - later < later - half)


def _measure(
    track: Track, recording: Recording, in_picture: tuple[float, float] | None
) -> RunOut:
    if len(track) < 2:
        raise MeasurementError(FEW.format(len(track)))
    sign = 1.0 if track.x[-1] >= track.x[0] else -1.0
    time, x = track.time, sign * track.x
    _check_run(track, x, recording)
    half = max(
        2, len(x) // 100
    )  # of about 2 % of the rows, over which speeds and the plotted path are taken
    row = np.arange(len(x))
    low, high = np.clip(row - half, 0, None), np.clip(row + half, None, len(x) - 1)
    speed = (x[high] - x[low]) / (time[high] - time[low])
    top = float(np.percentile(speed, 98))
    no_stop = ""
    try:
        stop, stop_sd, stop_row, doubts = _stop(track, x, speed, top)
    except MeasurementError as error:
        stop, stop_sd, stop_row, doubts, no_stop = (
            float(x[-1]),
            math.nan,
            len(x) - 1,
            [],
            str(error),
        )
    place, place_sd, notes, junction_doubts = _junction(
        track, x, speed, stop_row, recording, sign, in_picture
    )
    doubts = [*doubts, *junction_doubts, *_jumps(track, x, speed)]
    length = stop - place
    if length <= 0:
        raise MeasurementError(
            no_stop
            or "the seed stops before the junction: it never reaches the level plate"
        )
    rests = not no_stop and stop <= x.max()
    level = fit_resistance(
        track, x, (place, place_sd), stop if rests else None, recording
    )
    mean = np.ones(2 * half + 1) / (2 * half + 1)
    resistance, path = (
        level.resistance,
        np.convolve(np.pad(x, half, mode="edge"), mean, mode="valid"),
    )
    path[level.rows] = level.curve
    notes += resistance_notes(recording, [resistance])
    if resistance.quality != FAILED:
        resistance = resistance.doubt(*junction_doubts)
    fitted = (time, sign * path)
    if no_stop:
        both = all_failed(QUANTITIES[:2], no_stop)
        return RunOut(
            (*both, resistance), sign * place, None, None, fitted, tuple(notes)
        )
    scale_sd = recording.camera.scale_sd if track.unit == "mm" else 0.0
    sd = math.sqrt(stop_sd**2 + place_sd**2 + (scale_sd * length) ** 2)
    run_out = Quantity(
        "run_out", length, sd, track.unit, sd_common=scale_sd * length
    ).doubt(*doubts)
    friction = _friction(run_out, recording)
    above = friction.value - resistance.value
    if above > 3 * math.hypot(friction.sd, resistance.sd) and resistance.value > 0:
        share = f"{100 * above / resistance.value:.2g} % above rolling_resistance"
        losses = "it counts losses to the air and at the corner as friction"
        notes.append(f"rolling_friction (Eq. 3) is {share}: {losses}")
    return RunOut(
        (run_out, friction, resistance),
        sign * place,
        sign * stop,
        float(time[stop_row]),
        fitted,
        tuple(notes),
    )


def _check_run(track: Track, x: np.ndarray, recording: Recording) -> None:
    """MeasurementError where the places x (n,) show no run-out: at rest, on the incline
    only, or too few rows."""
    if np.ptp(x) < (1.0 if track.unit == "mm" else 4.0):
        raise MeasurementError(
            f"the seed does not roll: it moves {np.ptp(x):.3g} {track.unit} in all"
        )
    length_mm = recording.roll.incline_length_mm
    if length_mm and track.physical and ends_on_incline(track.t_s, x, length_mm):
        of = f"{np.ptp(x):.4g} of {length_mm:g} mm"
        raise MeasurementError(
            f"the seed does not leave the incline ({of}): there is no run-out"
        )
    if recording.evidence == "gates.csv":
        raise MeasurementError(
            "light gates do not show where the seed stops: a run-out needs a film, a"
            " track or a reading"
        )
    if len(track) < 8:
        raise MeasurementError(FEW.format(len(track)))


def _friction(run_out: Quantity, recording: Recording) -> Quantity:
    """Quantity rolling_friction by Eq. 3; failed, naming the key, where the incline is
    not described."""
    try:
        length_mm = recording.need(
            "roll.incline_length_mm", "for rolling_friction (Eq. 3)"
        )
        beta = recording.need("roll.incline_deg", "for rolling_friction (Eq. 3)")
        if run_out.unit != "mm":
            recording.need(
                "camera.mm_per_px", "for rolling_friction: the run-out is in pixels"
            )
    except MeasurementError as error:
        return failed("rolling_friction", "1", str(error))
    value, by = rolling_friction_eq3(length_mm, beta, run_out.value)
    parts = by * [LENGTH_SD_MM, INCLINE_SD_DEG, run_out.sd]
    common = math.hypot(parts[1], by[2] * run_out.sd_common)
    quantity = Quantity(
        "rolling_friction", value, float(np.linalg.norm(parts)), "1", sd_common=common
    )
    return quantity.doubt(run_out.reason)


def rolling_friction_eq3(
    length_mm: float, incline_deg: float, run_out_mm: float
) -> tuple[float, np.ndarray]:
    """μ_r = S sin β / (S cos β + L) and its derivatives by S [1/mm], β [1/°] and L
    [1/mm]."""
    beta = math.radians(incline_deg)
    below = length_mm * math.cos(beta) + run_out_mm
    value = length_mm * math.sin(beta) / below
    by_beta = (
        length_mm * math.cos(beta) * below + length_mm**2 * math.sin(beta) ** 2
    ) / below**2
    return value, np.array(
        [math.sin(beta) * run_out_mm / below**2, math.radians(by_beta), -value / below]
    )


def _stop(
    track: Track, x: np.ndarray, speed: np.ndarray, top: float
) -> tuple[float, float, int, list[str]]:
    """Place of the stop, its sd, the row from which the seed rests, doubts. For a
    rocking seed: the mean of its last places."""
    moving = np.flatnonzero(speed > STILL_SHARE * top)
    last = int(moving[-1]) + 1
    back = np.flatnonzero(
        (speed < -STILL_SHARE * top) & (x > x[0] + 0.9 * (x[-1] - x[0]))
    )
    if len(back):  # it rocks: the run ends when it first rolls back
        last = min(last, int(back[0]))
    rest = len(x) - last
    tail = slice(-max(5, len(x) // 50), None)
    end_speed = float(np.polyfit(track.time[tail], x[tail], 1)[0])
    doubts: list[str] = []
    if rest < 5 and end_speed > 0.05 * top:
        return _extrapolated(track, x, end_speed)
    # The last third of the rest: a seed that rocks has lost most of its swing by then.
    rows = slice(len(x) - max(5, rest // 3), None)
    swing = float(np.ptp(x[rows])) / 2
    stop, sd = correlated_mean(x[rows], track.frame[rows])
    noise = difference_noise(x, 2)
    if swing > 6 * noise + 0.5:
        doubts.append(
            f"the seed still rocks by ± {swing:.2g} {track.unit} at the end of the"
            " recording"
        )
        sd = math.hypot(sd, swing / 2)
    if rest < 5:
        doubts.append("the seed comes to rest only in the last frames")
        sd = math.hypot(sd, swing)
    return stop, sd, min(last, len(x) - 1), doubts


def _extrapolated(
    track: Track, x: np.ndarray, end_speed: float
) -> tuple[float, float, int, list[str]]:
    """As `_stop`, for a seed that still moves at the end: extrapolated at constant
    deceleration; MeasurementError if that is far."""
    late = slice(np.searchsorted(x, x[0] + 0.6 * np.ptp(x)), None)
    t = track.time[late] - track.time[-1]
    unit = f"{track.unit}/{track.time_unit}"
    text = (
        f"still moving at {end_speed:.3g} {unit} in the last frame: it leaves the"
        " picture, or the recording ends too early"
    )
    if len(t) < 8:
        raise MeasurementError(text)
    found = fit(
        np.column_stack([np.ones(len(t)), t, t**2 / 2]),
        x[late],
        frame_lag(track.frame[late]),
    )
    place, speed, slow = found.params
    ahead = speed**2 / (-2 * slow) if slow < 0 and speed > 0 else math.inf
    if ahead > 0.25 * np.ptp(x):
        raise MeasurementError(text)
    gradient = np.array([1.0, -speed / slow, speed**2 / (2 * slow**2)])
    sd = math.sqrt(float(gradient @ found.cov @ gradient) + (0.2 * ahead) ** 2)
    return (
        float(place + ahead),
        sd,
        len(x) - 1,
        [f"{text}; the stop is extrapolated by {ahead:.3g} {track.unit}"],
    )


def _jumps(track: Track, x: np.ndarray, speed: np.ndarray) -> list[str]:
    """A doubt where a step is larger than twice the greatest speed and the noise
    allow."""
    excess = (
        np.abs(np.diff(x))
        - 2 * float(speed.max()) * np.diff(track.time)
        - 8 * difference_noise(x, 3)
    )
    at = int(np.argmax(excess))
    if excess[at] <= 0:
        return []
    when = f"{track.time[at + 1]:.4g} {track.time_unit}"
    return [
        f"the track jumps by {x[at + 1] - x[at]:+.3g} {track.unit} in one step at"
        f" {when}"
    ]


def _rest_rows(track: Track, x: np.ndarray, speed: np.ndarray) -> int:
    """Number of rows at the start in which the seed rests, 0 where the track begins
    with a moving seed."""
    near = x <= np.median(x[:5]) + 4 * difference_noise(x, 3) + 1e-6 * np.ptp(x)
    rows = int(np.flatnonzero(near)[-1]) + 1
    if rows < 4 or np.polyfit(track.time[:rows], x[:rows], 1)[0] > 0.25 * np.percentile(
        speed, 98
    ):
        return 0
    return rows


def _junction(
    track: Track, x, speed, stop_row: int, recording: Recording, sign: float, in_picture
):
    """Place of the junction along the path, from the picture, from the release, or from
    the motion; sd, notes, doubts."""
    kinematic = _fastest_place(track, x, speed, stop_row)
    length_mm = recording.roll.incline_length_mm
    if in_picture is not None:
        place, sd, notes = sign * in_picture[0], in_picture[1], []
    elif (
        length_mm is not None
        and track.unit == "mm"
        and (rest := _rest_rows(track, x, speed))
    ):
        start, start_sd = correlated_mean(x[:rest], track.frame[:rest])
        place, sd = start + length_mm, math.hypot(start_sd, LENGTH_SD_MM)
        notes = [
            f"the junction is {length_mm:g} mm along the path from where the seed rests"
            " at first"
        ]
    elif kinematic is None:
        missing = (
            f"{recording.toml}: [roll] incline_length_mm is missing, and the motion"
            " does not show where the incline ends"
        )
        early = (
            "neither the release nor the end of the incline is in the track: begin it"
            " before the seed is let go"
        )
        raise MeasurementError(missing if length_mm is None else early)
    else:
        place, sd = kinematic
        return (
            place,
            sd,
            [
                f"the junction is where speeding up turns into slowing down, ± {sd:.2g}"
                f" {track.unit}"
            ],
            [],
        )
    if kinematic is None or abs(kinematic[0] - place) <= 4 * math.hypot(
        kinematic[1], sd
    ) + 0.03 * np.ptp(x):
        return place, sd, notes, []
    check = "the scale" if in_picture is not None else "incline_length_mm and the scale"
    off = (
        f"the seed is fastest at {kinematic[0] - place:+.3g} {track.unit} from the"
        f" junction as stated: check {check}"
    )
    return place, sd, notes, [off]


def _fastest_place(
    track: Track, x: np.ndarray, speed: np.ndarray, stop_row: int
) -> tuple[float, float] | None:
    """Place and sd of the greatest speed: two parabolas that share place and speed at a
    free time; None where they do not fit."""
    top = np.percentile(speed, 98)
    begin = int(np.flatnonzero(speed > 0.15 * top)[0])
    rows = slice(begin, max(stop_row - len(x) // 50, begin + 2))
    t, place, frame = track.time[rows], x[rows], track.frame[rows]
    if len(t) < 10 or int(np.argmax(speed)) - begin < 3:
        return None

    def columns(turn):
        late = t - turn
        return np.column_stack(
            [
                np.ones(len(t)),
                late,
                np.minimum(late, 0) ** 2 / 2,
                np.maximum(late, 0) ** 2 / 2,
            ]
        )

    lag, rho = frame_lag(frame), 0.0

    def misfit(turn: float) -> float:
        both = whiten(np.column_stack([columns(turn), place]), lag, rho)
        return float(np.asarray(np.linalg.qr(both, mode="r"))[-1, -1] ** 2)

    for _ in range(2):  # the second time under the noise's own correlation
        grid = np.linspace(t[2], t[-3], 200)
        best = int(np.argmin([misfit(float(g)) for g in grid]))
        bounds = (grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)])
        turn = float(minimize_scalar(misfit, bounds=bounds, method="bounded").x)
        rho = estimate_rho(columns(turn), place, lag)
    found = fit(columns(turn), place, frame_lag(frame))
    if found.params[2] < 0 or found.params[3] > 0:
        return None
    # The place's sd with the time of the turn free as well: its own column is the
    # model's slope in that time.
    late = t - turn
    slope = (
        -found.params[1]
        - found.params[2] * np.minimum(late, 0)
        - found.params[3] * np.maximum(late, 0)
    )
    white = (
        whiten(np.column_stack([columns(turn), slope]), frame_lag(frame), found.rho)
        / found.noise
    )
    return float(found.params[0]), math.sqrt(
        float(np.linalg.pinv(white.T @ white)[0, 0])
    )
