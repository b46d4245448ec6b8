"""The page of a bench: its recordings, keys common to all, runs, results."""

import asyncio
from collections import Counter
from pathlib import Path
from urllib.parse import quote

from benchtwin.page.folder import Refused, clean_name
from benchtwin.page.server import Site
from benchtwin.page.views import keys_form, results
from benchtwin.page.views import runs as runs_panel
from benchtwin.page.views.frame import errors_shown, frame
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.new_bench import new_bench
from benchtwin.vision.recording import Recording
from nicegui import ui

TABS = ("Recordings", "What holds for all", "Run", "Results")
PICTURED = ("photos", "frames", "video")


def register(site: Site) -> None:
    """Add the page of a bench, and of a folder of benches, to the site."""

    @ui.page("/", title="benchtwin")
    async def start() -> None:
        benches = site.folder.benches()
        if len(benches) == 1:
            await _bench(site, site.folder.name_of(benches[0]), TABS[0])
            return
        with frame(site.folder.root.name):
            _benches(site, benches)

    @ui.page("/bench")
    async def bench(b: str, tab: str = TABS[0]) -> None:
        await _bench(site, b, tab)


def _benches(site: Site, benches: list[Path]) -> None:
    """Every bench of the folder, and a new one."""
    ui.label("Benches in this folder").classes("text-h6")
    with ui.element("div").classes("card-grid"):
        for bench in benches:
            name = site.folder.name_of(bench)
            with (
                ui.link(target=f"/bench?b={quote(name)}").classes(
                    "no-underline text-inherit"
                ),
                ui.card().classes("w-full"),
            ):
                ui.label(name).classes("font-bold").style("overflow-wrap: anywhere")
                ui.label(_holds(site, bench)).classes("soft")
    ui.label("A new bench of your own: files dropped on it stay in its folder").classes(
        "soft q-mt-md"
    )
    with ui.row().classes("items-center"):
        name_of_new = ui.input("name").props("dense")

        @errors_shown
        def make() -> None:
            if not (name_of_new.value or "").strip():
                raise Refused("say a name for the bench first")
            path = site.folder.inside(clean_name(name_of_new.value))
            try:
                new_bench(path)
            except MeasurementError as error:
                raise Refused(str(error).rpartition("/")[2]) from error
            ui.navigate.to(f"/bench?b={quote(site.folder.name_of(path))}")

        name_of_new.on("keydown.enter", make)
        ui.button("New bench", on_click=make).props("no-caps")


def _holds(site: Site, bench: Path) -> str:
    """ "8 drops, 5 slides, 3 piles", told by rig; or why it cannot be opened."""
    try:
        entries = site.recordings(bench)
    except Refused as error:
        return str(error)
    rigs = Counter(r.rig or "recording" for r in entries if isinstance(r, Recording))
    return (
        ", ".join(f"{n} {rig}{'' if n == 1 else 's'}" for rig, n in rigs.items())
        or "nothing yet"
    )


async def _bench(site: Site, name: str, tab: str) -> None:
    try:
        folder = site.folder.inside(name)
        site.folder.results(folder)
        entries = await asyncio.to_thread(site.recordings, folder)
    except (Refused, OSError) as error:
        with frame("benchtwin", back="/"):
            ui.label(f"This bench cannot be opened: {error}").classes("failed")
        return
    with frame(
        folder.name, back="/" if len(site.folder.benches()) > 1 else "", bench=name
    ):
        with ui.tabs().props("align=left no-caps") as tabs:
            for label in TABS:
                ui.tab(label)
        with ui.tab_panels(
            tabs, value=tab if tab in TABS else TABS[0], animated=False
        ).classes("w-full"):
            with ui.tab_panel(TABS[0]):
                _recordings(site, entries)
            with ui.tab_panel(TABS[1]):
                ui.label(
                    "A key stated here holds for every recording that does not say"
                    " otherwise (bench.toml)."
                ).classes("soft")
                keys_form.form_for(folder / "bench.toml", None, {}, set(), lambda: None)
            with ui.tab_panel(TABS[2]):
                runs_panel.panel(site, folder)
            with ui.tab_panel(TABS[3]):
                results_panel = ui.refreshable(results.panel)
                results_panel(site, folder)
        tabs.on_value_change(
            lambda e: results_panel.refresh() if e.value == TABS[3] else None
        )


def _recordings(site: Site, entries: list[Recording | MeasurementError]) -> None:
    good = [e for e in entries if isinstance(e, Recording)]
    trouble = [
        e
        for e in entries
        if not isinstance(e, Recording) and "nothing to measure here" not in str(e)
    ]
    with ui.row().classes("items-center"):
        ui.html(
            '<label class="q-btn bg-primary text-white" style="padding:.5rem'
            ' 1rem;cursor:pointer">Add files<input type="file" multiple'
            ' style="display:none" onchange="uploadFiles(this)"></label>',
            sanitize=False,
        )
        ui.label(
            "or drop photos, films, tables or whole folders anywhere on this page. A"
            " photo is measured at once."
        ).classes("soft")
    if not good and not trouble:
        ui.label("Nothing here yet. Drop the photo of a pile to begin with.").classes(
            "text-lg"
        )
    for error in trouble:
        ui.label(str(error)).classes("failed").style("white-space: pre-wrap")
    with ui.element("div").classes("card-grid"):
        for recording in good:
            _card(site, recording)


def _card(site: Site, recording: Recording) -> None:
    name = site.folder.name_of(recording.path)
    with (
        ui.link(target=f"/recording?r={quote(name)}").classes(
            "no-underline text-inherit"
        ),
        ui.card().tight().classes("w-full"),
    ):
        if recording.evidence in PICTURED:
            ui.element("img").classes("thumb").props(
                f'src="/thumb?r={quote(name)}" loading=lazy alt=""'
            )
        else:
            ui.icon("show_chart", size="4rem").classes("thumb text-white")
        with ui.column().classes("q-pa-sm gap-0"):
            ui.label(recording.id).classes("font-bold").style("overflow-wrap: anywhere")
            ui.label(f"{recording.rig or 'which rig?'} · {recording.evidence}").classes(
                "soft"
            )
