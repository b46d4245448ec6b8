"""Fills a report's template: one file with its figures and plotly in it, that needs no
network."""

import json
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from typing import Any

from benchtwin.bench.language import spoken, tr
from benchtwin.bench.whole_file import write_whole
from benchtwin.twin.versions import versions

PAGE, PRINTED = "report.html", "report.pdf"


def write_page(out: Path, page: str) -> None:
    """Write a report's page into the folder of its results; a print of an older one
    goes."""
    write_whole(out / PAGE, page)
    (out / PRINTED).unlink(missing_ok=True)


def fill(
    template: str,
    figures: dict[str, dict],
    filters: dict[str, Callable],
    **content: Any,
) -> str:
    """The page as text. figures: plotly's JSON by the id that the template draws it
    under."""
    from jinja2 import Environment, StrictUndefined
    from plotly.offline import get_plotlyjs

    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= filters
    environment.globals |= {"tr": tr, "language": spoken()}
    page = environment.from_string(
        (files("benchtwin.report") / template).read_text(encoding="utf8")
    )
    # "</script" or "<!--" would end the element that carries the figures
    drawn = json.dumps(figures, separators=(",", ":"), allow_nan=False).replace(
        "<", "\\u003c"
    )
    return page.render(
        figures=sorted(figures),
        drawn=drawn,
        plotly=get_plotlyjs(),
        versions=versions(),
        **content,
    )
