"""Runs of a bench: started, followed, stopped, resumed."""

import re
from functools import partial
from pathlib import Path

from nicegui import ui

from benchtwin.bench.language import tr
from benchtwin.page import runs
from benchtwin.page.folder import Refused
from benchtwin.page.runs import BROKEN, DONE, FAILED, RUNNING, STOPPED, WAITING, Run
from benchtwin.page.site import Site
from benchtwin.page.views.frame import errors_shown

EVERY_S = 0.7
QUICK = ("--quick",)
ASKS = {  # by the button: command, options, what for
    "Measure": (
        *("measure", ()),
        "every recording: numbers, pictures, means over the repeats",
    ),
    "Calibrate, quick": (
        *("calibrate", QUICK),
        "contact parameters from fewer simulations: minutes",
    ),
    "Calibrate": (
        *("calibrate", ()),
        "contact parameters with all repeats and piles: half an hour and more",
    ),
    "Diagnose": (
        *("diagnose", QUICK),
        "is anything in the recordings that no parameter explains?",
    ),
}
COLOURS = {DONE: "good", RUNNING: "", WAITING: "soft", FAILED: "failed"}
COLOURS |= dict.fromkeys((STOPPED, BROKEN), "doubtful")


def panel(site: Site, bench: Path) -> None:
    """Buttons and the list of runs, renewed while one runs."""

    def ask(command: str, options: tuple[str, ...]) -> None:
        runs.enqueue(bench, command, options, site.folder)
        listed.refresh()

    with ui.row():
        for label, (command, options, purpose) in ASKS.items():
            act = partial(errors_shown(ask), command, options)
            ui.button(tr(label), on_click=act).tooltip(tr(purpose))
    ui.label(
        tr(
            "A run goes on when this page or the browser is closed. Stopped, it goes on"
            " where it was."
        )
    ).classes("soft")
    opened: set[str] = set()

    @ui.refreshable
    def listed() -> None:
        found = runs.all_runs(bench)
        if not found:
            ui.label(tr("No run yet.")).classes("soft")
        for one in found:
            _shown(site, bench, one, opened, listed.refresh)

    listed()
    last: object = None

    def look() -> None:
        nonlocal last
        try:
            now = [
                (r.folder.name, r.status, r.progress, len(r.log), int(r.took_s))
                for r in runs.all_runs(bench)
                if r.status in (RUNNING, WAITING)
            ]
        except (OSError, Refused):
            return  # the bench was moved away; the page says so when it is used
        if now != last:
            last = now
            listed.refresh()

    ui.timer(EVERY_S, look)


def _shown(site: Site, bench: Path, one: Run, opened: set[str], refresh) -> None:
    name = one.folder.name

    @errors_shown
    def stop() -> None:
        runs.stop(one)
        refresh()

    @errors_shown
    def resume() -> None:
        runs.resume(one, bench, site.folder)
        refresh()

    with ui.card().classes("w-full q-pa-sm"), ui.column().classes("w-full gap-1"):
        with ui.row().classes("items-center w-full"):
            what = f"{one.number}. {one.command} {' '.join(one.options)}"
            ui.label(what).classes("font-bold anywhere")
            ui.label(tr(one.status)).classes(COLOURS[one.status])
            took = (
                f"{one.took_s:.0f} s"
                if one.took_s < 90
                else f"{one.took_s / 60:.0f} min"
            )
            ui.label(took if one.status != WAITING else "")
            ui.space()
            if one.status in (RUNNING, WAITING):
                ui.button(tr("Stop"), on_click=stop).props("flat dense")
            if one.status in (STOPPED, BROKEN, FAILED):
                ui.button(tr("Go on"), on_click=resume).props("flat dense")
        if one.status == RUNNING:
            part = re.search(r"\b(\d{1,9})/(\d{1,9})\b", one.progress, re.ASCII)
            share = int(part[1]) / max(int(part[2]), 1) if part else 0.0
            bar = ui.linear_progress(share, show_value=False)
            bar.props("" if part else "indeterminate")
            ui.label(one.progress).classes("text-sm").props('role="status"')
        if one.log:

            def turn(event) -> None:
                (opened.add if event.value else opened.discard)(name)

            shown = name in opened or one.status == FAILED
            output = ui.expansion(tr("Output"), value=shown, on_value_change=turn)
            with output.classes("w-full"):
                ui.label(one.log).classes("log")
