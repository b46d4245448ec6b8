"""Fall and first rebound of a drop with few rows (light gates, a stroboscope, some
pictures), at known gravity.

    h = a₀ + b₀ τ − γ τ²/2 before the impact,   h = a₁ + b₁ τ − γ τ²/2 behind it

The impact lies between two neighbouring rows; all pairs are tried. With γ known the
model is linear in its four parameters: five rows are enough, or four with stated sds.
Light gates know the height and measure the time: a row's error is σ_t times the speed.
"""

import math
from dataclasses import replace

import numpy as np
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.motion.flight import Flights, Gravity, fit_rows
from benchtwin.vision.motion.least_squares import all_stated, variance_factor
from benchtwin.vision.motion.outliers import STILL, rows_at_rest

# with fewer, no rows are left out about a contact, and outliers are not detected
FEW_ROWS = 16
# of the time between two rows, by which noise may move the impact out of that interval
SLACK = 0.05


def fit_few_flights(
    time: np.ndarray,
    frame: np.ndarray,
    height: np.ndarray,
    across: np.ndarray,
    sd: np.ndarray,
    gravity: Gravity,
    *,
    gates: bool,
) -> Flights:
    """Fit both flights, as flight.fit_flights does; sd (n,): of each height, or NaN;
    `frame` and `across` are not used."""
    stated = all_stated(sd)
    unknowns = 4 + (gravity.value is None)
    least = unknowns + (not stated)
    begin = rows_at_rest(height)
    if len(time) - begin < least:
        gravity_too = "gravity, " if gravity.value is None else ""
        message = (
            f"{len(time) - begin} rows of fall and rebound for {unknowns} unknowns"
            f" ({gravity_too}two places and two speeds)"
        )
        raise MeasurementError(
            f"{message}; {least} are needed"
            + ("" if stated else f", or {least - 1} with their sd stated")
        )
    tried = [
        _fit_impact_after(time, height, sd, gravity, begin, j, least, gates)
        for j in range(begin + 1, len(time) - 2)
    ]
    found = [flights for flights in tried if flights is not None]
    if not found:
        raise MeasurementError(
            "no impact lies between two of the rows: none of them splits into a fall"
            " and a rebound of two rows each"
        )
    return min(
        found,
        key=lambda f: (
            f.noise * (1.0 if stated else len(time) / len(np.concatenate(f.rows)))
        ),
    )


def _fit_impact_after(
    time, height, sd, gravity: Gravity, begin: int, j: int, least: int, gates: bool
) -> Flights | None:
    """Both flights, fitted with the impact between rows j and j + 1; None where the fit
    puts it elsewhere."""
    end = j + 3
    while end <= len(time):
        if end - begin < least:
            end += 1
            continue
        flights = _two_flights(
            time,
            height,
            sd,
            gravity,
            (np.arange(begin, j + 1), np.arange(j + 1, end)),
            gates,
        )
        if (
            not np.isfinite(flights.params).all()
            or not flights.gamma > 0
            or abs(flights.params[0] - flights.params[2]) > 1e12
        ):
            return None
        meets = flights.contact_time(0)
        slack = SLACK * (time[j + 1] - time[j])
        if (
            not time[j] - slack <= meets <= time[j + 1] + slack
            or flights.speed(0, meets) >= 0
            or flights.speed(1, meets) <= 0
        ):
            return None
        landing = flights.contact_times()[-1]
        if time[end - 1] > landing:
            return None
        if end < len(time) and time[end] < landing:
            end += 1
            continue
        slack = max(3 * flights.noise, STILL * np.ptp(height))
        if flights.height(0, meets) > height.min() + slack:
            return None  # some row is lower than the plate
        if (
            len(later := height[end:])
            and later.max() > flights.height(1, flights.apex_time(1)) + slack
        ):
            return None  # a later bounce would be higher
        return flights
    return None


def _two_flights(
    time, height, sd, gravity: Gravity, rows: tuple[np.ndarray, np.ndarray], gates: bool
) -> Flights:
    """Both flights by flight.fit_rows; unstated errors are those about the fit, of
    light gates in proportion to the speed."""
    stated, used = all_stated(sd), np.concatenate(rows)
    weight = 1 / sd if stated else np.ones(len(time))
    noise = 1.0 if stated else float(np.ptp(height))
    least = 1e-9 * float(np.abs(height).max()) * (weight.max() if stated else 1.0)
    freedom = len(used) - 4 - (gravity.value is None)
    none = np.zeros(len(time), dtype=bool)
    for _ in range(3):
        found, left = fit_rows(
            rows, time, time, height, weight, gravity, none, 0.0, True, noise
        )
        chi2 = max(float(left @ left), least**2 * freedom)
        factor, _ = variance_factor(chi2, freedom, stated)
        noise = math.sqrt(factor)
        if gates and not stated:
            speed = np.abs(
                np.concatenate([found.speed(k, time[r]) for k, r in enumerate(rows)])
            )
            slow = np.maximum(speed, 0.1 * speed.max())
            weight[used] = np.median(slow) / slow
    found, left = fit_rows(
        rows, time, time, height, weight, gravity, none, 0.0, True, noise
    )
    scatter = math.sqrt(float(left @ left) / max(freedom, 1))
    return replace(found, noise=scatter * (float(np.median(sd)) if stated else 1.0))


def is_few(flights: Flights) -> bool:
    """Whether the flights were fitted here: no rows are left out about the contacts."""
    return flights.guard == 0.0
