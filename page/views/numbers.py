"""Tables of quantities as people read them."""

import html
import math
from collections.abc import Iterable, Mapping

from benchtwin.vision.measurement import Quantity


def number(value: float, sd: float) -> str:
    """Value ± sd, to two figures of the sd."""
    if not math.isfinite(value):
        return "–"
    if not math.isfinite(sd) or sd <= 0:
        return f"{value:.4g}"
    places = max(0, 1 - math.floor(math.log10(sd)))
    return f"{value:.{places}f} ± {sd:.{places}f}"


def quantities_table(columns: Mapping[str, Iterable[Quantity]]) -> str:
    """HTML table: a row a quantity, a column a way of measuring ("automatic",
    "corrected")."""
    by_name: dict[str, dict[str, Quantity]] = {}
    for heading, quantities in columns.items():
        for q in quantities:
            by_name.setdefault(q.name, {})[heading] = q
    head = "".join(f"<th>{html.escape(h)}</th>" for h in columns)
    rows = []
    for name, found in by_name.items():
        unit = next(iter(found.values())).unit
        cells = "".join(_cell(found.get(h)) for h in columns)
        heading = html.escape(name.replace("_", " "))
        stated = "" if unit == "1" else html.escape(unit)
        rows.append(f"<tr><th>{heading}</th>{cells}<td>{stated}</td></tr>")
    return (
        f'<table class="numbers"><thead><tr><th></th>{head}<th></th></tr></thead>'
        f"<tbody>{''.join(rows)}</tbody></table>"
    )


def _cell(q: Quantity | None) -> str:
    if q is None:
        return "<td></td>"
    title = f' title="{html.escape(q.reason)}"' if q.reason else ""
    return (
        f'<td class="n {q.quality}"{title}>{number(q.value, q.sd)}'
        f" <small>{q.quality}</small></td>"
    )
