"""Results of a bench: reports, bench beside twin, what to record next, downloads."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TypeVar
from urllib.parse import quote

import pandas as pd
from nicegui import ui

from benchtwin.bench.language import tr
from benchtwin.bench.numbers import with_interval, with_unit
from benchtwin.calibrate.export import ENGINES
from benchtwin.page import results
from benchtwin.page.folder import MEASURED, Refused
from benchtwin.page.side_by_side import pairs_of
from benchtwin.page.site import Site
from benchtwin.page.views import side_by_side
from benchtwin.page.views.frame import attribute, in_words, tabs

REPORTS = (  # file below results/, heading
    ("calibrated/report.html", "Calibration"),
    ("diagnosed/report.html", "Diagnosis"),
    ("measured/overlays/index.html", "What was found on each recording"),
)
COLUMNS = (
    *("rig", "quantity", "conditions"),
    *("mean", "n", "scatter", "far from the others"),
)
T = TypeVar("T")


def panel(site: Site, bench: Path, part: str) -> None:
    """Reports, which begin with values and verdicts, pictures and pairs, one at a time,
    then the long table. part: the heading that is shown."""
    folder = site.folder.results(bench)
    for link in site.folder.links_out(folder):
        ui.label(site.folder.refused_link(link)).classes("failed")
        return
    or_said = partial(_or_said, set())
    parts = _parts(site, bench, folder, or_said)
    if parts:
        here = part if part in parts else next(iter(parts))
        address = f"/bench?b={quote(site.folder.name_of(bench))}&tab=Results"
        tabs(parts, here, lambda p: f"{address}&part={quote(p)}", "Results")
        with (
            ui.element("section")
            .classes("w-full")
            .props(f'aria-label="{attribute(tr(here))}"')
        ):
            parts[here]()
    else:
        ui.label(tr("Nothing yet: run something first.")).classes("soft")
    or_said(lambda: _means(folder / MEASURED / "summary.csv"), None)
    _downloads(site, bench, folder)


def _or_said(said: set[str], read: Callable[[], T], nothing: T) -> T:
    """What is read; where it cannot be, the page says so, once."""
    try:
        return read()
    except Refused as error:
        if str(error) not in said:
            ui.label(str(error)).classes("failed anywhere")
        said.add(str(error))
        return nothing


def _parts(
    site: Site, bench: Path, folder: Path, or_said: Callable
) -> dict[str, Callable[[], object]]:
    """What there is to show, by its heading."""
    parts: dict[str, Callable[[], object]] = {}
    for file, heading in REPORTS:
        if (folder / file).is_file():
            parts[heading] = partial(_framed, site, folder / file, heading)
    if or_said(lambda: pairs_of(bench, site.folder), []):
        parts["Bench and twin"] = partial(side_by_side.panel, site, bench)
    if to_record := or_said(lambda: results.next_recordings(folder), {}):
        parts["What to record next"] = partial(
            _next, to_record, f"/next?bench={quote(site.folder.name_of(bench))}"
        )
    return parts


def _downloads(site: Site, bench: Path, folder: Path) -> None:
    name, names = quote(site.folder.name_of(bench)), {"mercury": "MercuryDPM"}
    with ui.row().classes("items-center"):
        ui.link(tr("This bench with its results as one zip"), f"/zip?bench={name}")
        if (folder / "calibrated" / "result.json").is_file():
            ui.label(tr("Calibrated parameters as cards for")).classes("soft")
            for engine in ENGINES:
                address = f"/cards?bench={name}&engine={engine}"
                ui.link(names.get(engine, engine.upper()), address)


def _framed(site: Site, file: Path, heading: str) -> None:
    address = f"/results/{quote(site.folder.name_of(file))}?v={file.stat().st_mtime_ns}"
    sandbox = "allow-scripts" if file.name == "report.html" else "allow-same-origin"
    ui.element("iframe").classes("report").props(
        f'src="{address}" sandbox="{sandbox}" title="{attribute(tr(heading))}"'
    )


def _next(to_record: dict[str, list[results.ToRecord]], address: str) -> None:
    ui.link(tr("As a list to print"), address, new_tab=True)
    for heading, rows in to_record.items():
        ui.label(tr(heading)).classes("text-lg")
        for row in rows:
            with ui.column().classes("gap-0"):
                ui.label(row.what)
                ui.label(row.why).classes("soft text-sm")


def _means(file: Path) -> None:
    """summary.csv as a table; a bench with nothing measured has none."""
    with results.read(file):
        table = results.table(file)
        table = pd.DataFrame() if table is None else table[table["n"] > 1]
        rows = [_mean(row) for row in table.itertuples()]
    if not rows:
        return
    title = tr("Means over repeats, with 95 % intervals ({} rows)", len(table))
    heads = [{"name": c, "label": tr(c), "field": c, "align": "left"} for c in COLUMNS]
    with ui.expansion(title).classes("w-full"), ui.element("div").classes("scroll-x"):
        ui.table(columns=heads, rows=rows, pagination=12).props("dense flat")


def _mean(row) -> dict[str, str]:
    """A row of summary.csv, to the digits that its interval bears."""
    unit = str(row.unit)
    named = (
        row.rig,
        in_words(row.quantity),
        "" if pd.isna(row.conditions) else row.conditions,
        f"{with_interval(row.mean, row.low, row.high)}{with_unit(unit)}",
        str(row.n),
        f"{row.scatter:.2g}{with_unit(unit)}",
        "" if pd.isna(row.outliers) else row.outliers,
    )
    return dict(zip(COLUMNS, named, strict=True))
