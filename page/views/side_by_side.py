"""A recording and its twin side by side, with one slider through both."""

import asyncio
from pathlib import Path

from nicegui import ui
from nicegui.element import Element

from page.beside import Beside, drawn, laid_beside, pairs_of
from page.server import Site
from vision.measurement import MeasurementError


class Stage(Element, component="../static/beside.js"):
    """Recording, twin and difference; `shown` as `page.beside.drawn` gives it."""

    def __init__(self, shown: dict):
        super().__init__()
        self._props.update(shown=shown)


def panel(site: Site, bench: Path) -> None:
    """A choice of pairs, and the chosen one."""
    pairs = pairs_of(bench, site.folder)
    if not pairs:
        ui.label("No twin to show: a calibration runs one of every rig that has more than readings, a full diagnosis films one.")
        return
    by_title = {b.title: b for b in pairs}

    async def show(chosen: Beside) -> None:
        place.clear()
        with place:
            ui.spinner()
        try:
            both = await asyncio.to_thread(laid_beside, chosen)
            shown = drawn(chosen, both, site.folder)
        except (MeasurementError, OSError) as error:
            place.clear()
            with place:
                ui.label(str(error)).classes("failed")
            return
        place.clear()
        with place:
            Stage(shown)

    ui.select(list(by_title), value=pairs[0].title, on_change=lambda e: show(by_title[e.value]), label="Which pair").classes("w-96")
    place = ui.column().classes("w-full")
    ui.timer(0.1, lambda: show(pairs[0]), once=True)
