"""Chosen laws put together: for each kind one compiled function, which `kernels.build`
binds into the kernels.

Each chosen contact law has columns of its own in the table of material pairs: first
whether it is on for that pair, then its parameters. A tile carries them as rows, so
that laws still run in vector registers; what laws remember of a contact comes in rows
after all of them."""

from collections.abc import Callable
from typing import NamedTuple

from numba import njit

from benchtwin.sim.engine import quadrature, tiles
from benchtwin.sim.engine.compiled import INNER, inner
from benchtwin.sim.laws.contract import FIXED, RETURNED
from benchtwin.sim.laws.law import ALONE, CONTACT_KINDS, NORMAL_KINDS, Law


class Place(NamedTuple):
    """A contact law, the extra column where its numbers start (whether it is on for the
    pair, then its parameters), and the row of a tile where its memory does."""

    law: Law
    column: int
    memory: int


def _tile_numbers(row: int, count: int):
    """Compiled function that makes the tuple of lane `t` of `count` rows of a tile."""
    if count == 0:
        return njit(**INNER)(lambda P, t: ())
    before, where = _tile_numbers(row, count - 1), (row + count - 1) * tiles.STRIDE
    return njit(**INNER)(lambda P, t: (*before(P, t), P[where + t]))


def _table_numbers(first: int, count: int):
    """The same of extra columns of the table's row `row`."""
    if count == 0:
        return njit(**INNER)(lambda table, row: ())
    before, at = _table_numbers(first, count - 1), tiles.COLUMNS + first + count - 1
    return njit(**INNER)(lambda table, row: (*before(table, row), table[row, at]))


def places(laws: tuple[Law, ...]) -> list[Place]:
    """Where each contact law finds its own."""
    chosen = [law for law in laws if law.kind in CONTACT_KINDS]
    row = tiles.FIXED_ROWS + sum(1 + len(law.parameters) for law in chosen)
    placed, column = [], 0
    for law in chosen:
        placed.append(Place(law, column, row))
        column += 1 + len(law.parameters)
        row += len(law.memory)
    return placed


def _touching(radius, modulus, *numbers):
    """The reach of a law that acts on touching surfaces only."""
    return 0.0


def _numbers(place: Place):
    """A law's parameters in a tile."""
    row = tiles.FIXED_ROWS + place.column + 1
    return _tile_numbers(row, len(place.law.parameters))


def _acts(place: Place):
    """Whether a law acts: it is on for the pair of materials and, along the normal,
    surfaces overlap or are within its own reach, whatever another law's is."""
    on = (tiles.FIXED_ROWS + place.column) * tiles.STRIDE
    if place.law.kind not in NORMAL_KINDS:
        return njit(**INNER)(lambda told, P, t: P[on + t] > 0.5)
    reach, numbers = njit(**INNER)(place.law.reach or _touching), _numbers(place)

    def acts(told, P, t):
        near = -told[0] <= reach(told[2], told[3], *numbers(P, t))
        return P[on + t] > 0.5 and near

    return njit(**INNER)(acts)


def _one(place: Place, else_):
    """A law as the tile loop calls it: fixed arguments, then P and t; what holds where
    it does not act."""
    law, count = place.law, len(FIXED[place.law.kind])
    f, acts, numbers = inner(law.function), _acts(place), _numbers(place)
    if law.memory:
        f, numbers = _remembering(place, f), njit(**INNER)(lambda P, t: (P, t))

    def call(*told):
        P, t = told[-2], told[-1]
        if acts(told, P, t):
            return f(*told[:count], *numbers(P, t))
        return else_(*told)

    return njit(**INNER)(call)


def _remembering(place: Place, f):
    """The law as a function of its fixed arguments, P and t, that keeps what it gives
    to remember."""
    count, store = RETURNED.get(place.law.kind, 1), None
    for n in range(len(place.law.memory)):
        store = _stored(store, count + n, (place.memory + n) * tiles.STRIDE)
    memory = _tile_numbers(place.memory, len(place.law.memory))
    numbers = _numbers(place)

    def call(*told):
        P, t = told[-2], told[-1]
        given = f(*told[:-2], *memory(P, t), *numbers(P, t))
        store(given, P, t)
        return given[0] if count == 1 else given[:count]

    return njit(**INNER)(call)


def _stored(before, at: int, where: int):
    before = before or njit(**INNER)(lambda told, P, t: None)

    def store(told, P, t):
        before(told, P, t)
        P[where + t] = told[at]

    return njit(**INNER)(store)


def _weight(place: Place, else_):
    """The weight of a spring's damping where surfaces touch first and where they
    part."""
    on, numbers = (tiles.FIXED_ROWS + place.column) * tiles.STRIDE, _numbers(place)
    reach, step_weight = njit(**INNER)(place.law.reach or _touching), _STEP_WEIGHT

    def weight(P, t, dt):
        if P[on + t] <= 0.5:
            return else_(P, t, dt)
        left, closing = P[tiles.OVERLAP + t], P[tiles.CLOSING + t]
        if closing < 0.0 or left < 0.0:
            left += reach(P[tiles.RADIUS + t], P[tiles.MODULUS + t], *numbers(P, t))
        return step_weight(max(left, 0.0), closing, dt)

    return njit(**INNER)(weight)


_STEP_WEIGHT = inner(quadrature.step_weight)


def _after(first, second):
    """Laws that follow one another: the second takes the first's result."""

    def call(speed, value, P, t):
        return second(speed, first(speed, value, P, t), P, t)

    return njit(**INNER)(call)


def _sum(first, second):
    def call(a, b, c, d, P, t):
        return first(a, b, c, d, P, t) + second(a, b, c, d, P, t)

    return njit(**INNER)(call)


def contact_laws(placed: list[Place]) -> dict:
    """What the kernels are bound to: the chosen laws of each kind as one function."""
    bound: dict = {}
    if own := sum(len(place.law.memory) for place in placed):
        bound = {"OWN": own, "OWN_ROW": placed[0].memory * tiles.STRIDE}
    if within := reach(placed):
        bound |= {"REACH": True, "reach": within}
    for place in placed:
        kind = place.law.kind
        earlier = bound.get(kind) or inner(getattr(tiles, kind))
        if kind in ALONE:
            call = _one(place, earlier)
        else:
            combine = _after if kind in ("restitution", "friction") else _sum
            call = _one(place, inner(getattr(tiles, kind)))
            call = combine(earlier, call) if kind in bound else call
        bound |= {kind: call, f"HAS_{kind.upper()}": True}
        if kind == "spring":
            bound["weight"] = _weight(place, bound.get("weight") or inner(tiles.weight))
    return bound


def reach(placed: list[Place]) -> Callable | None:
    """The farthest reach of all laws that have one, or None."""
    whole = None
    for law, at, _ in placed:
        if law.reach is not None:
            numbers = _table_numbers(at + 1, len(law.parameters))
            whole = _farther(inner(law.reach), _table_numbers(at, 1), numbers, whole)
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
