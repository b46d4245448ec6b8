"""Numbers and tables of quantities as people read them."""

import html
import math
from collections.abc import Iterable, Mapping

from benchtwin.vision.measurement import Quantity

UNITS = {"1": "", "deg": "°"}  # unit of a quantity → as it is printed
WITHOUT_SPACE = ("°",)
ROUNDING = 1e-9  # a standard deviation below this share of its value is no statement


def number(value: float, sd: float) -> str:
    """Value ± sd, to two figures of the sd.

    >>> number(30.0213, 0.052), number(3.55132374218194, 4e-16)
    ('30.021 ± 0.052', '3.551')
    """
    if not math.isfinite(value):
        return "–"
    if not math.isfinite(sd) or sd <= ROUNDING * abs(value):
        return f"{value:.4g}"
    places = max(0, 1 - math.floor(math.log10(sd)))
    return f"{value:.{places}f} ± {sd:.{places}f}"


def unit_in_words(unit: str) -> str:
    """A unit as it is printed; "" for a ratio."""
    return UNITS.get(unit, unit)


def with_unit(value: float, sd: float, unit: str) -> str:
    """Value ± sd and the unit.

    >>> with_unit(30.02, 0.05, "deg"), with_unit(0.54, 0.01, "1")
    ('(30.020 ± 0.050)°', '0.540 ± 0.010')
    """
    text, unit = number(value, sd), unit_in_words(unit)
    if unit and "±" in text:
        text = f"({text})"
    return text + ("" if not unit or unit in WITHOUT_SPACE else " ") + unit


def in_words(name: str) -> str:
    """A quantity's name: repose_angle is "repose angle"."""
    return name.replace("_", " ")


def quantities_table(columns: Mapping[str, Iterable[Quantity]]) -> str:
    """HTML table: a row a quantity, a column a way of measuring ("automatic",
    "corrected")."""
    by_name: dict[str, dict[str, Quantity]] = {}
    for heading, quantities in columns.items():
        for q in quantities:
            by_name.setdefault(q.name, {})[heading] = q
    head = "".join(f'<th scope="col">{html.escape(h)}</th>' for h in columns)
    rows = []
    for name, found in by_name.items():
        unit = unit_in_words(next(iter(found.values())).unit)
        cells = "".join(_cell(found.get(h)) for h in columns)
        rows.append(
            f'<tr><th scope="row">{html.escape(in_words(name))}</th>{cells}'
            f"<td>{html.escape(unit)}</td></tr>"
        )
    return (
        '<table class="numbers"><thead><tr><th></th>'
        f"{head}<th></th></tr></thead><tbody>{''.join(rows)}</tbody></table>"
    )


def _cell(q: Quantity | None) -> str:
    if q is None:
        return "<td></td>"
    title = f' title="{html.escape(q.reason)}"' if q.reason else ""
    return (
        f'<td class="n {q.quality}"{title}>{number(q.value, q.sd)}'
        f" <small>{q.quality}</small></td>"
    )
