"""Results of a bench: reports, bench beside twin, posterior, explanations, what to
record next, downloads."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from urllib.parse import quote

import pandas as pd
from benchtwin.calibrate.export import ENGINES
from benchtwin.diagnose.words import percent
from benchtwin.page import results
from benchtwin.page.server import Site
from benchtwin.page.side_by_side import pairs_of
from benchtwin.page.views import side_by_side
from benchtwin.page.views.elements import PosteriorCloud
from benchtwin.vision.numbers import plus_minus
from nicegui import ui

REPORTS = (  # file below results/, heading
    ("calibrated/report.html", "Calibration"),
    ("diagnosed/report.html", "Diagnosis"),
    ("measured/overlays/index.html", "What was found on each recording"),
)
TONES = {"sure": "text-positive", "open": "", "quiet": "soft"}  # else "text-warning"


def panel(site: Site, bench: Path) -> None:
    """All that is there, one tab each."""
    left = site.folder.results(bench)
    _downloads(site, bench, left)
    if (left / "measured" / "summary.csv").is_file():
        _means(left / "measured" / "summary.csv")
    parts = _parts(site, bench, left)
    if not parts:
        ui.label("Nothing yet: run something first.").classes("soft")
        return
    with ui.tabs().props("align=left no-caps outside-arrows mobile-arrows") as tabs:
        for heading in parts:
            ui.tab(heading)
    with ui.tab_panels(tabs, value=next(iter(parts)), animated=False).classes("w-full"):
        for heading, show in parts.items():
            with ui.tab_panel(heading):
                show()


def _parts(site: Site, bench: Path, left: Path) -> dict[str, Callable[[], object]]:
    """What there is to show, by its heading."""
    parts: dict[str, Callable[[], object]] = {}
    for file, heading in REPORTS:
        if (left / file).is_file():
            parts[heading] = partial(_framed, site, left / file, heading)
    if pairs_of(bench, site.folder):
        parts["Bench and twin"] = partial(side_by_side.panel, site, bench)
    if (cloud := results.posterior(left)) is not None:
        parts["Posterior"] = partial(PosteriorCloud, cloud)
    if found := results.explained(left):
        parts["Explanations"] = partial(_explanations, found)
    if to_record := results.next_recordings(left):
        parts["What to record next"] = partial(
            _next, to_record, f"/next?bench={quote(site.folder.name_of(bench))}"
        )
    return parts


def _downloads(site: Site, bench: Path, left: Path) -> None:
    name, names = quote(site.folder.name_of(bench)), {"mercury": "MercuryDPM"}
    with ui.row().classes("items-center"):
        ui.link("This bench with its results as one zip", f"/zip?bench={name}")
        if (left / "calibrated" / "result.json").is_file():
            ui.label("Calibrated parameters as cards for").classes("soft")
            for engine in ENGINES:
                ui.link(
                    names.get(engine, engine.upper()),
                    f"/cards?bench={name}&engine={engine}",
                )


def _framed(site: Site, file: Path, heading: str) -> None:
    address = f"/left/{quote(site.folder.name_of(file))}?v={file.stat().st_mtime_ns}"
    sandbox = "allow-scripts" if file.name == "report.html" else "allow-same-origin"
    ui.element("iframe").classes("report").props(
        f'src="{address}" sandbox="{sandbox}" title="{heading}"'
    )


def _explanations(found: list[results.Explained]) -> None:
    """A bar an explanation, as long as it is probable."""
    for one in found:
        with ui.column().classes("w-full gap-1 q-mb-md"):
            ui.label(f"{one.rig.capitalize()}: {one.sentence}.").classes(
                f"text-lg {TONES.get(one.tone, 'text-warning')}"
            )
            for explanation in one.explanations:
                with ui.row().classes("items-center w-full no-wrap"):
                    ui.label(percent(explanation.probability)).classes(
                        "w-16 text-right"
                    )
                    ui.linear_progress(
                        explanation.probability, show_value=False
                    ).classes("w-40").props("aria-hidden=true")
                    ui.label(
                        " and ".join(explanation.effects) or "nothing is missing"
                    ).classes("grow")


def _next(to_record: dict[str, list[results.ToRecord]], address: str) -> None:
    ui.link("As a list to print", address, new_tab=True)
    for heading, rows in to_record.items():
        ui.label(heading).classes("text-lg")
        for row in rows:
            with ui.column().classes("gap-0"):
                ui.label(row.what)
                ui.label(row.why).classes("soft text-sm")


def _means(file: Path) -> None:
    """summary.csv as a table; a bench with nothing measured has none."""
    try:
        table = pd.read_csv(file)
    except (pd.errors.EmptyDataError, OSError):
        return
    table = table[table["n"] > 1]
    if not len(table):
        return
    with ui.expansion("Means over repeats", value=True).classes("w-full"):
        rows = [
            {
                "rig": r.rig,
                "quantity": r.quantity.replace("_", " "),
                "conditions": "" if pd.isna(r.conditions) else r.conditions,
                "mean": plus_minus(r.mean, (r.high - r.low) / 2),
                "unit": "" if str(r.unit) == "1" else r.unit,
                "n": r.n,
                "scatter": f"{r.scatter:.2g}",
                "far from the others": "" if pd.isna(r.outliers) else r.outliers,
            }
            for r in table.itertuples()
        ]
        ui.table(rows=rows, pagination=12).props("dense flat")
