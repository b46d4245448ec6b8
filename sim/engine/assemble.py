"""Chosen laws put together: for each kind one compiled function, which `kernels.build`
binds into the kernels.

Each chosen contact law has columns of its own in the table of material pairs: first
whether it is on for that pair, then its parameters. A tile carries them as rows, so
that laws still run in vector registers."""

from collections.abc import Callable

from numba import njit

from benchtwin.sim.engine import tiles
from benchtwin.sim.engine.compiled import INNER, inner
from benchtwin.sim.laws.law import CONTACT_KINDS, Law


def _numbers_from(first: int, count: int, lanes: bool):
    """Compiled function that makes the tuple of `count` numbers from rows of a tile (or
    columns of a table row)."""
    if count == 0:
        return njit(**INNER)(lambda P, t: ())
    before = _numbers_from(first, count - 1, lanes)
    at = first + count - 1
    if lanes:
        where = tiles.EXTRA + at * tiles.STRIDE
        return njit(**INNER)(lambda P, t: (*before(P, t), P[where + t]))
    column = tiles.COLUMNS + at
    return njit(**INNER)(lambda P, t: (*before(P, t), P[t, column]))


def extra_columns(laws: tuple[Law, ...]) -> list[tuple[Law, int]]:
    """Contact laws and the extra column where each one's numbers start: whether it is
    on for the pair, then its parameters."""
    placed, column = [], 0
    for law in laws:
        if law.kind in CONTACT_KINDS:
            placed.append((law, column))
            column += 1 + len(law.parameters)
    return placed


def _one(law: Law, on: int, fixed: int, neutral):
    """A law as the tile loop calls it: fixed arguments, then P and t; `neutral` where
    it is off for the pair of materials."""
    f, is_on = inner(law.function), _numbers_from(on, 1, True)
    take_numbers = _numbers_from(on + 1, len(law.parameters), True)
    if fixed == 2:

        def call(a, b, P, t):
            return (
                f(a, b, *take_numbers(P, t)) if is_on(P, t)[0] > 0.5 else neutral(a, b)
            )
    elif fixed == 4:

        def call(a, b, c, d, P, t):
            return f(a, b, c, d, *take_numbers(P, t)) if is_on(P, t)[0] > 0.5 else 0.0
    else:

        def call(mx, my, mz, ax, ay, az, dt, k, fn, r, i, mu, P, t):
            if is_on(P, t)[0] > 0.5:
                return f(
                    mx, my, mz, ax, ay, az, dt, k, fn, r, i, mu, *take_numbers(P, t)
                )
            return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0

    return njit(**INNER)(call)


def _normal(law: Law, on: int, fixed: int, neutral):
    """A normal law acts on overlapping surfaces, and on separated ones only within its
    own reach, whatever another law's is."""
    f, is_on = inner(law.function), _numbers_from(on, 1, True)
    take_numbers = _numbers_from(on + 1, len(law.parameters), True)
    reach = njit(**INNER)(law.reach or _touching)

    def call(overlap, closing, radius, modulus, P, t):
        if is_on(P, t)[0] > 0.5 and -overlap <= reach(
            radius, modulus, *take_numbers(P, t)
        ):
            return f(overlap, closing, radius, modulus, *take_numbers(P, t))
        return 0.0

    return njit(**INNER)(call)


def _touching(radius, modulus, *numbers):
    """The reach of a law that acts on touching surfaces only."""
    return 0.0


def _after(first, second):
    """Laws that follow one another: the second takes the first's result."""

    def call(speed, value, P, t):
        return second(speed, first(speed, value, P, t), P, t)

    return njit(**INNER)(call)


def _sum(first, second):
    def call(a, b, c, d, P, t):
        return first(a, b, c, d, P, t) + second(a, b, c, d, P, t)

    return njit(**INNER)(call)


def contact_laws(placed: list[tuple[Law, int]]) -> dict:
    """What `tiles.laws` is bound to: the chosen laws of each kind as one function."""
    second_of_two = njit(**INNER)(lambda a, b: b)
    names = {
        "restitution": ("HAS_RESTITUTION", 2, _after),
        "friction": ("HAS_FRICTION", 2, _after),
        "normal": ("HAS_NORMAL", 4, _sum),
        "rolling_spin": ("HAS_SPIN", 4, _sum),
        "rolling_relative": ("HAS_RELATIVE", 4, _sum),
        "rolling_spring": ("HAS_SPRING", 12, None),
    }
    bound: dict = {}
    for kind, (flag, fixed, combine) in names.items():
        make = _normal if kind == "normal" else _one
        calls = [
            make(law, at, fixed, second_of_two)
            for law, at in placed
            if law.kind == kind
        ]
        if not calls:
            continue
        if len(calls) > 1 and combine is None:
            raise ValueError(f"{len(calls)} laws of kind {kind}: choose one")
        whole = calls[0]
        for call in calls[1:]:
            whole = combine(whole, call) if combine else call
        bound[flag] = True
        bound["normal_extra" if kind == "normal" else kind] = whole
    return bound


def reach(placed: list[tuple[Law, int]]) -> Callable | None:
    """The farthest reach of all laws that have one, or None."""
    whole = None
    for law, at in placed:
        if law.reach is None:
            continue
        f, is_on = inner(law.reach), _numbers_from(at, 1, False)
        numbers = _numbers_from(at + 1, len(law.parameters), False)
        whole = _farther(f, is_on, numbers, whole)
    return whole


def _farther(f, is_on, numbers, before):
    before = before or njit(**INNER)(lambda radius, modulus, row, table: 0.0)

    def call(radius, modulus, row, table):
        own = before(radius, modulus, row, table)
        if is_on(table, row)[0] > 0.5:
            own = max(own, f(radius, modulus, *numbers(table, row)))
        return own

    return njit(**INNER)(call)


def body_laws(laws: tuple[Law, ...]) -> Callable | None:
    """The sum of the chosen body laws as one function, or None; their numbers come one
    law after the other in a flat array."""
    whole, first = None, 0
    for law in laws:
        whole = _with_body(
            inner(law.function), _array_numbers(first, len(law.parameters)), whole
        )
        first += len(law.parameters)
    return whole


def _with_body(f, numbers, before):
    if before is None:

        def call(vx, vy, vz, wx, wy, wz, diameter, row):
            return f(vx, vy, vz, wx, wy, wz, diameter, *numbers(row))
    else:

        def call(vx, vy, vz, wx, wy, wz, diameter, row):
            a, b, c, d, e, g = f(vx, vy, vz, wx, wy, wz, diameter, *numbers(row))
            h, i, j, k, m, n = before(vx, vy, vz, wx, wy, wz, diameter, row)
            return a + h, b + i, c + j, d + k, e + m, g + n

    return njit(**INNER)(call)


def _array_numbers(first: int, count: int):
    if count == 0:
        return njit(**INNER)(lambda row: ())
    before, at = _array_numbers(first, count - 1), first + count - 1
    return njit(**INNER)(lambda row: (*before(row), row[at]))


def motions(laws: tuple[Law, ...]) -> Callable | None:
    """(value, rate) by the motion law of that number, at time t with its row of
    numbers; None without laws."""
    whole = None
    for number, law in reversed(list(enumerate(laws))):
        whole = _with_motion(
            inner(law.function), _array_numbers(0, len(law.parameters)), number, whole
        )
    return whole


def _with_motion(f, numbers, mine, others):
    others = others or njit(**INNER)(lambda number, t, row: (0.0, 0.0))

    def call(number, t, row):
        if number == mine:
            return f(t, *numbers(row))
        return others(number, t, row)

    return njit(**INNER)(call)
