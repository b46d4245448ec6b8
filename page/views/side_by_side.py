"""A recording and its twin side by side, with one slider through both."""

import asyncio
from pathlib import Path

from nicegui import ui

from benchtwin.bench.language import tr
from benchtwin.page.side_by_side import BenchTwinPair, browser_data, pairs_of, read_pair
from benchtwin.page.site import Site
from benchtwin.page.views.frame import SideBySide
from benchtwin.vision.measurement import MeasurementError


def panel(site: Site, bench: Path) -> None:
    """A choice of pairs, and the chosen one."""
    pairs = pairs_of(bench, site.folder)
    if not pairs:
        ui.label(
            tr(
                "No twin to show: a calibration runs one of every rig that has more"
                " than readings, a full diagnosis films one."
            )
        )
        return
    by_title = {b.title: b for b in pairs}

    async def show(chosen: BenchTwinPair) -> None:
        place.clear()
        with place, ui.row().classes("items-center").props('role="status"'):
            ui.spinner()
            ui.label(tr("reading recording and twin …"))
        try:
            both = await asyncio.to_thread(read_pair, chosen)
            shown = browser_data(chosen, both, site.folder)
        except (MeasurementError, OSError, ValueError) as error:
            place.clear()
            with place:
                ui.label(str(error)).classes("failed")
            return
        place.clear()
        with place:
            SideBySide(shown)

    ui.select(
        list(by_title),
        value=pairs[0].title,
        on_change=lambda e: show(by_title[e.value]),
        label=tr("Which pair"),
    ).classes("w-96 max-w-full")
    place = ui.column().classes("w-full")
    ui.timer(0.1, lambda: show(pairs[0]), once=True)
