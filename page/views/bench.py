"""The page of a bench: its recordings, keys common to all, runs, results."""

import asyncio
from collections import Counter
from html import escape
from pathlib import Path
from urllib.parse import quote

from nicegui import Client, background_tasks, ui

from benchtwin.bench.language import tr
from benchtwin.bench.numbers import plus_minus
from benchtwin.page.folder import RESULTS, Refused, clean_name
from benchtwin.page.measuring import (
    FILMS,
    CardNumber,
    measured_number,
    number_of_last_run,
    original_name,
    version,
)
from benchtwin.page.site import Site
from benchtwin.page.views import keys_form, recording_menu, results
from benchtwin.page.views import runs as runs_panel
from benchtwin.page.views.frame import (
    ANSWER_S,
    attribute,
    errors_shown,
    frame,
    in_words,
    kind_in_words,
    recording_address,
    tabs,
)
from benchtwin.vision.find_recordings import NothingHere
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.new_bench import new_bench
from benchtwin.vision.recording import Recording

TABS = ("Recordings", "What holds for all", "Run", "Results")
PICTURED = ("photos", "frames", "video")


def register(site: Site) -> None:
    """Add the page of a bench, and of a folder of benches, to the site."""

    @ui.page("/", title="benchtwin", response_timeout=ANSWER_S)
    async def start() -> None:
        benches = site.folder.benches()
        if len(benches) == 1:
            await _bench(site, site.folder.name_of(benches[0]), TABS[0], "")
            return
        with frame(site.folder.root.name):
            _benches(site, benches)

    @ui.page("/bench", response_timeout=ANSWER_S)
    async def bench(b: str, tab: str = TABS[0], part: str = "") -> None:
        await _bench(site, b, tab, part)


def _benches(site: Site, benches: list[Path]) -> None:
    """Every bench of the folder, and a new one."""
    ui.label(tr("Benches in this folder")).classes("text-h6")
    with ui.element("div").classes("card-grid"):
        for bench in benches:
            name = site.folder.name_of(bench)
            with (
                ui.link(target=f"/bench?b={quote(name)}").classes("card-link"),
                ui.card().classes("w-full"),
            ):
                ui.label(name).classes("font-bold anywhere")
                ui.label(_holds(site, bench)).classes("soft")
    ui.label(
        tr("A new bench of your own: files dropped on it stay in its folder")
    ).classes("soft q-mt-md")
    with ui.row().classes("items-center"):
        name_of_new = ui.input(tr("name")).props("dense")

        @errors_shown
        def make() -> None:
            if not (name_of_new.value or "").strip():
                raise Refused(tr("say a name for the bench first"))
            path = site.folder.inside(clean_name(name_of_new.value))
            try:
                new_bench(path)
            except MeasurementError as error:
                raise Refused(str(error).rpartition("/")[2]) from error
            ui.navigate.to(f"/bench?b={quote(site.folder.name_of(path))}")

        name_of_new.on("keydown.enter", make)
        ui.button(tr("New bench"), on_click=make).props("no-caps")


def _holds(site: Site, bench: Path) -> str:
    """ "8 drops, 5 slides, 3 piles", told by rig; or why it cannot be opened."""
    try:
        entries = site.recordings(bench)
    except Refused as error:
        return str(error)
    rigs = Counter(
        r.rig or tr("recording") for r in entries if isinstance(r, Recording)
    )
    each = (tr("{} {}{}", n, rig, "" if n == 1 else "s") for rig, n in rigs.items())
    return ", ".join(each) or tr("nothing yet")


async def _bench(site: Site, name: str, tab: str, part: str) -> None:
    try:
        folder = site.folder.inside(name)
        site.folder.results(folder)
        entries = await asyncio.to_thread(site.recordings, folder)
    except (Refused, OSError) as error:
        with frame("benchtwin", back="/"):
            ui.label(tr("This bench cannot be opened: {}", error)).classes("failed")
        return
    tab = tab if tab in TABS else TABS[0]
    address = f"/bench?b={quote(name)}"
    back = "/" if len(site.folder.benches()) > 1 else ""
    with frame(folder.name, back=back, bench=name):
        tabs(TABS, tab, lambda label: f"{address}&tab={quote(label)}", "Bench")
        if tab == TABS[0]:
            _recordings(site, folder, entries)
        elif tab == TABS[1]:
            ui.label(
                tr(
                    "A key stated here holds for every recording that does not say"
                    " otherwise (bench.toml)."
                )
            ).classes("soft")
            keys_form.KeysForm(site, folder / "bench.toml", None, {})
        elif tab == TABS[2]:
            runs_panel.panel(site, folder)
        else:
            results.panel(site, folder, part)


def _recordings(
    site: Site, bench: Path, entries: list[Recording | MeasurementError]
) -> None:
    good = [e for e in entries if isinstance(e, Recording)]
    trouble = [e for e in entries if not isinstance(e, Recording | NothingHere)]
    with ui.row().classes("items-center"):
        ui.html(
            '<label class="file-button q-btn bg-primary text-white">'
            + escape(tr("Add files"))
            + '<input type="file" multiple onchange="uploadFiles(this)"></label>',
            sanitize=False,
        )
        ui.label(
            tr(
                "or drop photos, films, tables or whole folders anywhere on this page."
                " A photo is measured at once."
            )
        ).classes("soft")
    if not good and not trouble:
        nothing = ui.label(
            tr("Nothing here yet. Drop the photo of a pile to begin with.")
        )
        nothing.classes("text-lg")
    for error in trouble:
        why = str(error).replace(f"{bench}/", "")
        ui.label(why).classes("failed").style("white-space: pre-wrap")
        if error.recording and (bench / error.recording).exists():
            name = site.folder.name_of(bench / error.recording)
            ui.link(tr("Open {}", error.recording), recording_address(name))
    recording_menu.removed_from(bench)
    with ui.element("div").classes("card-grid"):
        cards = [(one, _card(site, one)) for one in good]
    background_tasks.create(_fill(site, bench, cards, ui.context.client))


def _card(site: Site, recording: Recording) -> ui.column:
    """A link with picture, names and a place for the number, which is returned."""
    name = site.folder.name_of(recording.path)
    with (
        ui.link(target=recording_address(name)).classes("card-link"),
        ui.card().tight().classes("w-full h-full"),
    ):
        if recording.evidence in PICTURED:
            ui.element("img").classes("thumb").props(
                f'src="/thumb?r={quote(name)}" loading=lazy alt=""'
            )
        else:
            icon = "graphic_eq" if recording.evidence == "sound" else "show_chart"
            sign = ui.icon(icon, size="4rem").classes("thumb text-white")
            sign.props("aria-hidden=true")
        with ui.column().classes("q-pa-sm gap-0 w-full"):
            ui.label(recording.id).classes("font-bold anywhere")
            if (file := original_name(recording)) and Path(file).stem != recording.id:
                ui.label(file).classes("soft text-xs anywhere")
            ui.label(kind_in_words(recording)).classes("soft")
            return ui.column().classes("gap-0 w-full").props("aria-live=polite")


async def _fill(
    site: Site, bench: Path, cards: list[tuple[Recording, ui.column]], client: Client
) -> None:
    """Put each card's number into its place as soon as it is known. A film that no run
    has measured is not measured here: that may take minutes."""
    results_folder = bench / RESULTS
    await client.connected(timeout=30)
    unknown = []
    for recording, place in cards:
        known = site.cards.get(version(recording)) or await asyncio.to_thread(
            number_of_last_run, recording, results_folder
        )
        if known is None and recording.evidence not in FILMS:
            unknown.append((recording, place))
        _number(place, known, tr("not measured yet") if known is None else "")
    for _, place in unknown:
        _number(place, None, tr("measuring …"))
    for recording, place in unknown:
        if not client.has_socket_connection:
            return
        async with site.measuring:  # one at a time, whatever the number of open pages
            key = version(recording)
            if key not in site.cards:
                site.cards[key] = await asyncio.to_thread(measured_number, recording)
        _number(place, site.cards[key], "")


def _number(place: ui.column, known: CardNumber | None, words: str) -> None:
    place.clear()
    with place:
        if known is None:
            ui.label(words).classes("soft text-sm")
            return
        if known.n:
            value = plus_minus(known.value, known.sd, known.unit)
            repeats = f" · n = {known.n}" if known.n > 1 else ""
            said = ui.label(f"{in_words(known.quantity)} {value}{repeats}")
            said.classes("font-medium")
        quality = ui.label(tr(known.quality)).classes(f"{known.quality} text-sm")
        if known.reason:
            ui.label(known.reason).classes("soft text-xs anywhere clamped")
            quality.props(f'title="{attribute(known.reason)}"')
