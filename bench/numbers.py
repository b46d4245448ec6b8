"""Numbers as a person reads them, with the digits that their standard deviation bears,
and as a table stores them."""

import math

from benchtwin.bench.language import tr

MOST_DIGITS = 12  # significant ones, of any number
LEAST_STORED = 6  # significant digits of a number in a table
STORED_SHARE = 1e-4  # of the sd, to which a table rounds
EXACT_SHARE = 1e-9  # of a value: no reading has so small an sd


def with_sd(value: float, sd: float) -> tuple[str, str]:
    """Value and sd to two digits of the sd; four digits of the value where the sd is
    not known.

    >>> with_sd(0.5402, 0.0123), with_sd(123456.0, 2300.0), with_sd(2.0, math.nan)
    (('0.540', '0.012'), ('123500', '2300'), ('2', ''))
    >>> with_sd(3.55132374218194169, 4.4e-16)
    ('3.55132374218', '4.4e-16')
    """
    if not math.isfinite(value):
        return "–", ""
    if not (math.isfinite(sd) and sd > 0):
        return _minus(f"{value:.4g}"), ""
    if sd < EXACT_SHARE * abs(value):
        return _minus(f"{value:.{MOST_DIGITS}g}"), f"{sd:.2g}"
    return _to(value, _places(sd)), _to(sd, _places(sd))


def plus_minus(value: float, sd: float, unit: str = "1") -> str:
    """ "0.540 ± 0.012 mm": see `with_sd`; unit "1" and "" are not written.

    >>> plus_minus(-31.234, 0.21, "°"), plus_minus(0.54, 0.012)
    ('−31.23 ± 0.21°', '0.540 ± 0.012')
    """
    shown = " ± ".join(filter(None, with_sd(value, sd)))
    return shown + with_unit(unit)


def with_interval(value: float, low: float, high: float) -> str:
    """A value with its interval, to two digits of a quarter of its width.

    >>> with_interval(0.5397671, 0.4967, 0.5806)
    '0.540 (0.497 to 0.581)'
    """
    if not high > low:
        return with_sd(value, math.nan)[0]
    one, *ends = (beside_interval(v, low, high) for v in (value, low, high))
    return f"{one} ({ends[0]} to {ends[1]})"


def beside_interval(value: float, low: float, high: float) -> str:
    """A number in the digits that an interval carries.

    >>> beside_interval(0.54, 0.4967, 0.5806)
    '0.540'
    """
    return _to(value, _places((high - low) / 4)) if high > low else f"{value:g}"


def to_interval(value: float, low: float, high: float) -> float:
    """The value in the digits that `with_interval` shows of it.

    >>> to_interval(0.5397671, 0.4967, 0.5806)
    0.54
    """
    return round(float(value), _places((high - low) / 4)) if high > low else value


def with_unit(unit: str) -> str:
    """What follows a number: " mm", "°", nothing for the unit 1."""
    if unit in ("1", ""):
        return ""
    return "°" if unit in ("deg", "°") else f" {unit}"


def stored(value: float, sd: float) -> str:
    """For a table: rounded to 1e-4 of the sd, 6 to 12 significant digits.

    >>> stored(1234567.891, 0.02), stored(0.123456789, 0.01), stored(2.5, 1e-20)
    ('1234567.891', '0.123457', '2.5')
    """
    if not math.isfinite(value):
        return "" if math.isnan(value) else str(value)
    digits = LEAST_STORED
    if value and math.isfinite(sd) and sd >= 0:
        least = max(STORED_SHARE * sd, abs(value) * 10.0**-MOST_DIGITS)
        digits = 1 + math.floor(math.log10(abs(value))) - math.floor(math.log10(least))
    return f"{value:.{min(max(digits, LEAST_STORED), MOST_DIGITS)}g}"


def exact_by_mistake(value: float, sd: float) -> str:
    """Why an sd cannot be true, "" where it can: no reading is so exact."""
    if not (math.isfinite(value) and 0 < sd < EXACT_SHARE * abs(value)):
        return ""
    return tr(
        "a standard deviation of {:.2g} is smaller than any reading's: the numbers"
        " follow a formula exactly, or one of them was used twice",
        sd,
    )


def _places(sd: float) -> int:
    """Decimals that two digits of an sd take; negative before the point."""
    return 1 - math.floor(math.log10(float(f"{sd:.1e}")))


def _to(x: float, places: int) -> str:
    return _minus(f"{round(x, places):.{max(places, 0)}f}")


def _minus(text: str) -> str:
    return text.replace("-", "−") if "e" not in text else text
