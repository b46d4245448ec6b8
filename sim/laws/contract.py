"""What a law must keep, tried before anything is compiled: its arguments, the names it
uses, and plain finite numbers for what it is given."""

import dis
import inspect
import itertools
import math
from collections.abc import Callable
from numbers import Real

Range = tuple[float, float]
SPEED, FORCE, SPIN = (0.0, 50.0), (0.0, 100.0), (0.0, 500.0)
RADIUS, MODULUS, DIAMETER = (1e-4, 0.05), (1e6, 1e11), (1e-4, 0.1)
EITHER_SPEED, EITHER_SPIN, MU = (-20.0, 20.0), (-300.0, 300.0), (0.0, 1.5)
ROLLING = {"normal_force": FORCE, "speed": SPIN, "arm": RADIUS, "mu_r": MU}
# kind → its fixed arguments with the range of each, in order
FIXED: dict[str, dict[str, Range]] = {
    "restitution": {"impact_speed": SPEED, "e": (0.05, 1.0)},
    "friction": {"slip_speed": SPEED, "mu": MU},
    "normal": {
        "overlap": (-1e-4, 1e-3),
        "closing_speed": EITHER_SPEED,
        "radius": RADIUS,
        "modulus": MODULUS,
    },
    "spring": {
        "overlap": (-1e-4, 1e-3),
        "closing_speed": EITHER_SPEED,
        "radius": RADIUS,
        "modulus": MODULUS,
        "e": (0.05, 1.0),
    },
    "rolling_spin": ROLLING,
    "rolling_relative": ROLLING,
    "rolling_spring": {
        **{n: (-1e-3, 1e-3) for n in ("mx", "my", "mz", "ax", "ay", "az")},
        "dt": (1e-7, 1e-4),
        "stiffness": (1e2, 1e8),
        "normal_force": FORCE,
        "radius": RADIUS,
        "inertia": (1e-12, 1e-3),
        "mu_r": MU,
    },
    "body": {
        **{n: EITHER_SPEED for n in ("vx", "vy", "vz")},
        **{n: EITHER_SPIN for n in ("wx", "wy", "wz")},
        "diameter": DIAMETER,
    },
    "motion": {"t": (0.0, 100.0)},
}
OF_REACH = {"radius": RADIUS, "modulus": MODULUS}
# numbers, besides a memory's; else one
RETURNED = {"spring": 4, "rolling_spring": 6, "body": 6, "motion": 2}
RESULTS: dict[str, Range] = {  # kind → what its one number lies between
    "restitution": (0.0, 1.0),
    "friction": (0.0, math.inf),
}
BUILT_IN = {"abs", "min", "max", "range", "float", "int"}
KINDS_OF_ARGUMENT = (
    inspect.Parameter.POSITIONAL_ONLY,
    inspect.Parameter.POSITIONAL_OR_KEYWORD,
)


def broken(
    kind: str, function: Callable, own: dict[str, Range], remembered: int = 0
) -> str:
    """Why a function cannot be a law of a kind (or the "reach" of one), with ranges of
    its own arguments, of which the first are `remembered`, in words; "": it can."""
    fixed, returned = FIXED.get(kind, OF_REACH), RETURNED.get(kind, 1) + remembered
    low, high = RESULTS.get(kind, (-math.inf, math.inf))
    ranges = [*fixed.values(), *own.values()]
    return (
        _wrong_arguments(function, fixed, own)
        or _wrong_names(function)
        or _wrong_values(function, ranges, returned, low, high)
    )


def _wrong_arguments(
    function: Callable, fixed: dict[str, Range], own: dict[str, Range]
) -> str:
    told = inspect.signature(function).parameters.values()
    plain = all(
        p.kind in KINDS_OF_ARGUMENT and p.default is inspect.Parameter.empty
        for p in told
    )
    names = [p.name for p in told]
    if plain and len(names) == len(fixed) + len(own) and names[len(fixed) :] == [*own]:
        return ""
    return (
        f"its function takes ({', '.join(map(str, told))}), not"
        f" ({', '.join([*fixed, *own])}), each by its place and without a default"
    )


def _wrong_names(function: Callable) -> str:
    """Compiled code is kept by the function's own text: what it finds elsewhere would
    not be noticed when it changes."""
    try:
        inspect.getsource(function)
    except (OSError, TypeError):
        return "its function has no source file, by which compiled code is known"
    code = function.__code__
    used = {i.argval for i in dis.get_instructions(code) if i.opname == "LOAD_GLOBAL"}
    outside = sorted(
        n for n in used - BUILT_IN if not _of_math(function.__globals__.get(n))
    )
    if outside or code.co_freevars:
        names = ", ".join([*outside, *code.co_freevars])
        return f"its function uses {names}; it may use its arguments and math only"
    return ""


def _of_math(value: object) -> bool:
    return value is math or getattr(value, "__module__", "") == "math"


def _wrong_values(
    function: Callable, ranges: list[Range], returned: int, low: float, high: float
) -> str:
    for arguments in _tried(ranges):
        said = ", ".join(f"{a:g}" for a in arguments)
        try:
            result = function(*arguments)
        except Exception as error:
            return f"its function fails for ({said}): {type(error).__name__}: {error}"
        values = result if isinstance(result, tuple) else (result,)
        if (
            len(values) != returned
            or isinstance(result, tuple) != (returned > 1)
            or not all(isinstance(v, Real) and math.isfinite(v) for v in values)
        ):
            what = f"{returned} finite numbers" if returned > 1 else "one finite number"
            return f"its function returns {result!r} for ({said}), not {what}"
        if not low <= min(values) <= max(values) <= high:
            what = f"{low:g} to {high:g}" if high < math.inf else f"{low:g} or more"
            return f"its function returns {result!r} for ({said}), not {what}"
    return ""


def _tried(ranges: list[Range]) -> list[tuple[float, ...]]:
    """The lowest, middle and highest of all arguments, and each by itself at an end."""
    middle = tuple((low + high) / 2 for low, high in ranges)
    alone = (
        (*middle[:k], end, *middle[k + 1 :])
        for k, ends in enumerate(ranges)
        for end in ends
    )
    corners = (tuple(r[side] for r in ranges) for side in (0, 1))
    return [*itertools.chain(corners, [middle], alone)]
