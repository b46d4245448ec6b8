"""Numbers and tables of quantities as people read them."""

import html
from collections.abc import Iterable, Mapping

from benchtwin.bench.numbers import plus_minus, with_unit
from benchtwin.vision.measurement import Quantity


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
        unit = with_unit(next(iter(found.values())).unit).strip()
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
        f'<td class="n {q.quality}"{title}>{plus_minus(q.value, q.sd)}'
        f" <small>{q.quality}</small></td>"
    )
