"""A drop of few rows (light gates, a stroboscope, some pictures): fall and first rebound, gravity known, from four numbers.

    h = a₀ + b₀ τ − γ τ²/2 before the impact,   h = a₁ + b₁ τ − γ τ²/2 behind it

The impact lies between two neighbouring rows; which, is tried. With γ known, rows are linear in the four numbers, so that five rows
are enough, or four of stated sd. Light gates know the height and read the time: a row's error is σ_t times the speed.
"""

import numpy as np
from scipy.stats import chi2 as chi_square
from scipy.stats import t as student

from vision.measurement import MeasurementError
from vision.motion.flight import Flights, Gravity, drag_shift

FEW_ROWS = 16  # of fewer, no row can be spared about a contact, and none tells by its neighbours that it is wrong
STILL = 0.01  # of the fall: rows so near the first are those of a seed that is held
SLACK = 0.05  # of the time between two rows, by which noise may put the impact outside
SURELY_WRONG = 0.01  # of a χ² as great by chance, below which a stated sd is not that of the rows


def fit_few(
    time: np.ndarray, frame: np.ndarray, height: np.ndarray, across: np.ndarray, sd: np.ndarray, gravity: Gravity, *, gates: bool
) -> Flights:
    """Like flight.fit_flights; sd (n,) of each height, or NaN. MeasurementError where no impact lies between two of the rows."""
    stated = bool(np.isfinite(sd).all() and (sd > 0).all())
    unknowns = 4 + (gravity.value is None)
    least = unknowns + (not stated)
    begin = _let_go(height)
    if len(time) - begin < least:
        why = "gravity, " if gravity.value is None else ""
        said = f"{len(time) - begin} rows of fall and rebound for {unknowns} unknowns ({why}two places and two speeds)"
        raise MeasurementError(f"{said}; {least} are needed" + ("" if stated else f", or {least - 1} with their sd stated"))
    found = [f for j in range(begin + 1, len(time) - 2) if (f := _at(time, height, sd, gravity, begin, j, least, gates)) is not None]
    if not found:
        raise MeasurementError("no impact lies between two of the rows: none of them splits into a fall and a rebound of two rows each")
    return min(found, key=lambda f: f.noise * (1.0 if stated else len(time) / len(np.concatenate(f.rows))))


def _let_go(height: np.ndarray) -> int:
    """The first row of the fall: behind those of a seed that is held."""
    still = np.abs(height - height[0]) < STILL * np.ptp(height)
    first = int(np.argmin(still)) if not still.all() else len(height)
    return 0 if first < 2 else first


def _at(time, height, sd, gravity: Gravity, begin: int, j: int, least: int, gates: bool) -> Flights | None:
    """Both flights where the impact lies between rows j and j + 1; None where it then does not."""
    end = j + 3
    while end <= len(time):
        if end - begin < least:
            end += 1
            continue
        flights = _linear(time, height, sd, gravity, (np.arange(begin, j + 1), np.arange(j + 1, end)), gates)
        if not np.isfinite(flights.params).all() or not flights.gamma > 0 or abs(flights.params[0] - flights.params[2]) > 1e12:
            return None
        meets = flights.meeting(0)
        slack = SLACK * (time[j + 1] - time[j])
        if not time[j] - slack <= meets <= time[j + 1] + slack or flights.speed(0, meets) >= 0 or flights.speed(1, meets) <= 0:
            return None
        landing = flights.contacts()[-1]
        if time[end - 1] > landing:
            return None
        if end < len(time) and time[end] < landing:
            end += 1
            continue
        slack = max(3 * flights.noise, STILL * np.ptp(height))
        if flights.height(0, meets) > height.min() + slack:
            return None  # nothing is lower than the plate
        if len(later := height[end:]) and later.max() > flights.height(1, flights.apex_time(1)) + slack:
            return None  # no later bounce is higher
        return flights
    return None


def _linear(time, height, sd, gravity: Gravity, rows: tuple[np.ndarray, np.ndarray], gates: bool) -> Flights:
    used = np.concatenate(rows)
    middle = np.array([time[r].mean() for r in rows])
    tau = time[used] - middle[np.repeat([0, 1], [len(r) for r in rows])]
    bare = np.zeros((len(used), 4))
    for k, r in enumerate(rows):
        here = np.isin(used, r)
        bare[here, 2 * k], bare[here, 2 * k + 1] = 1.0, tau[here]
    bend, known = -(tau**2) / 2, gravity.value
    stated = bool(np.isfinite(sd).all() and (sd > 0).all())
    weight, shift = np.ones(len(used)), np.zeros(len(used))
    for _ in range(3):
        columns = bare if known is not None else np.column_stack([bare, bend])
        target = height[used] - shift - (known * bend if known is not None else 0.0)
        row_weight = weight / sd[used] if stated else weight
        params = np.linalg.lstsq(columns * row_weight[:, None], target * row_weight, rcond=None)[0]
        gamma = float(known if known is not None else params[4])
        apex = np.repeat([params[1], params[3]], [len(r) for r in rows]) / gamma
        shift, fall = drag_shift(tau - apex, gamma, gravity.drag)
        if gates and not stated:
            speed = np.abs(np.repeat([params[1], params[3]], [len(r) for r in rows]) - gamma * tau + fall)
            weight = 1 / np.maximum(speed, 0.1 * speed.max()) * np.median(np.maximum(speed, 0.1 * speed.max()))
    left = (target - columns @ params) * row_weight
    freedom, chi2 = len(used) - columns.shape[1], float(left @ left)
    inverse = np.linalg.pinv((columns * row_weight[:, None]).T @ (columns * row_weight[:, None]))
    floor = (1e-9 * float(np.abs(height).max())) ** 2
    if stated and (freedom < 1 or chi_square.sf(chi2, freedom) >= SURELY_WRONG):
        power = 1.0
    else:
        power = max(chi2 / freedom, floor) * (student.ppf(0.975, freedom) / 1.96) ** 2
    cov = np.zeros((6, 6))
    cov[: len(params), : len(params)] = power * inverse
    both = np.array([*params[:4], gamma, 0.0])
    if known is not None:  # a wrong gravity bends both flights alike
        by_gamma = np.append(-np.linalg.lstsq(columns * row_weight[:, None], bend * row_weight, rcond=None)[0], 1.0)
        scale, other = known * gravity.scale_sd, known * gravity.other_sd
        cov[:5, :5] += np.outer(by_gamma, by_gamma) * (scale**2 + other**2)
        cov[:5, 5] = cov[5, :5] = by_gamma * scale * gravity.scale_sd
        cov[5, 5] = gravity.scale_sd**2
    noise = np.sqrt(chi2 / max(freedom, 1)) * (float(np.median(sd)) if stated else 1.0)
    none = np.zeros(len(time), dtype=bool)
    return Flights(rows, time, middle, both, cov, float(noise), 0.0, gamma, gamma, none, 0.0, gravity.drag)


def is_few(flights: Flights) -> bool:
    """Whether they were fitted here: no row is spared about the contacts."""
    return flights.guard == 0.0

