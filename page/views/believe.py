"""What the commands left: reports in a frame, the pictures, everything to take away."""

from pathlib import Path
from urllib.parse import quote

import pandas as pd
from nicegui import ui

from page.server import Site

PARTS = (  # file below results/, heading
    ("calibrated/report.html", "Calibration"),
    ("diagnosed/report.html", "Diagnosis"),
    ("measured/overlays/index.html", "What was found on each recording"),
)


def panel(site: Site, bench: Path) -> None:
    """The reports that are there, means over repeats, the zip."""
    results = site.folder.results(bench)
    ui.link("Take everything away: this bench with its results as one zip", f"/zip?bench={quote(site.folder.name_of(bench))}")
    there = [(file, heading) for file, heading in PARTS if (results / file).is_file()]
    if (results / "measured" / "summary.csv").is_file():
        _means(results / "measured" / "summary.csv")
    if not there:
        ui.label("Nothing yet: run something first.").classes("soft")
        return
    with ui.tabs().props("align=left") as tabs:
        for _, heading in there:
            ui.tab(heading)
    with ui.tab_panels(tabs, value=there[0][1], animated=False).classes("w-full"):
        for file, heading in there:
            name = site.folder.name_of(results / file)
            address = f"/left/{quote(name)}?v={(results / file).stat().st_mtime_ns}"
            with ui.tab_panel(heading):
                sandbox = "allow-scripts" if file.endswith("report.html") else "allow-same-origin"
                ui.element("iframe").classes("report").props(f'src="{address}" sandbox="{sandbox}" title="{heading}"')


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
            {"rig": r.rig, "quantity": r.quantity.replace("_", " "), "conditions": "" if pd.isna(r.conditions) else r.conditions,
             "mean": f"{r.mean:.4g} ± {(r.high - r.low) / 2:.2g}", "unit": "" if str(r.unit) == "1" else r.unit, "n": r.n,
             "scatter": f"{r.scatter:.2g}", "far from the others": "" if pd.isna(r.outliers) else r.outliers}
            for r in table.itertuples()
        ]  # fmt: skip
        ui.table(rows=rows, pagination=12).props("dense flat")
