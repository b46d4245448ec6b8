"""What can be done with a recording's files, and what was removed from a bench."""

from collections.abc import Callable
from pathlib import Path
from urllib.parse import quote

from nicegui import run, ui

from benchtwin.bench.language import tr
from benchtwin.page import recording_files as files
from benchtwin.page.folder import Refused
from benchtwin.page.site import Site
from benchtwin.page.views.frame import attribute, errors_shown, open_recording
from benchtwin.vision.evidence.film_or_photos import film_or_photos
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.recording import Recording


def show(
    site: Site, recording: Recording, entries: list[Recording | MeasurementError]
) -> None:
    """The menu of a recording, and the question whether its pictures are a film where
    they may be either; entries: what its bench holds."""
    menu = _Menu(site, recording.path, recording, entries)
    if recording.evidence == "photos" and recording.rig is None:
        menu.ask(recording)
    menu.show()


def show_for_broken(site: Site, path: Path) -> None:
    """The menu of a recording that cannot be read."""
    _Menu(site, path, None, []).show()


def own_folder_button(site: Site, recording: Recording) -> None:
    """For a photo that lies loose: puts it into a folder of its own."""

    @errors_shown
    def make() -> None:
        made = files.own_folder(recording.path, site.folder)
        open_recording(site.folder.name_of(made))

    ui.button(tr("Put it into a folder of its own"), on_click=make).props(
        "no-caps outline"
    )


def removed_from(bench: Path) -> None:
    """What was removed from a bench, the last first, each with a button that puts it
    back; nothing where nothing was."""
    gone = files.removed(bench)
    for path in gone[:1]:
        _put_back(path, bench)
    if gone[1:]:
        with ui.expansion(tr("{} removed before", len(gone) - 1)).classes("soft"):
            for path in gone[1:]:
                _put_back(path, bench)


def _put_back(path: Path, bench: Path) -> None:
    @errors_shown
    def back() -> None:
        files.put_back(path, bench)
        ui.navigate.reload()

    with ui.row().classes("items-center"):
        ui.label(tr("Removed: {}", path.name)).classes("soft anywhere")
        ui.button(tr("Put back"), icon="undo", on_click=back).props(
            f'flat dense no-caps aria-label="{attribute(tr("Put back {}", path.name))}"'
        )


class _Menu:
    def __init__(
        self,
        site: Site,
        path: Path,
        recording: Recording | None,
        entries: list[Recording | MeasurementError],
    ):
        self.site, self.path, self.recording = site, path, recording
        self.bench = path.parent
        self.series = files.series(recording, entries) if recording else []

    def show(self) -> None:
        if self.path == self.site.folder.root:
            return
        with (
            ui.button(tr("Files"), icon="more_vert").props(
                "flat dense no-caps"
                f' aria-label="{attribute(tr("Files of this recording"))}"'
            ),
            ui.menu(),
        ):
            self._items()

    def _items(self) -> None:
        one = self.recording
        if one and len(one.files) > 1 and one.evidence in ("photos", "frames"):
            _item(tr("Split into {} photos", len(one.files)), self.split)
        if self.series:
            _item(tr("Join {} as a film", self._joined()), self.join)
        _item(tr("Rename …"), self.ask_name)
        if [b for b in self.site.folder.benches() if b != self.bench]:
            _item(tr("Move to another bench …"), self.ask_bench)
        _item(tr("Delete"), self.remove)

    def ask(self, recording: Recording) -> None:
        """Both fit: what are these pictures?"""
        taken = recording.files
        why = film_or_photos({p.name: p for p in taken}).why
        with ui.column().classes("w-full gap-1"):
            ui.label(
                tr(
                    "{} to {}: {} photos of heaps, or one film?",
                    taken[0].name,
                    taken[-1].name,
                    len(taken),
                )
            ).classes("text-lg failed anywhere")
            with ui.row():
                photos = tr("{} photos of heaps", len(taken))
                for words, act in ((photos, self.split), (tr("One film"), self.join)):
                    button = ui.button(words, on_click=errors_shown(act))
                    button.props("no-caps outline")
            ui.label(tr("The pictures do not tell: {}.", why)).classes("soft text-sm")

    def _joined(self) -> str:
        if len(self.series) == 1:
            return tr("{} photos", len(self.series[0].files))
        first, last = self.series[0].files[0].name, self.series[-1].files[0].name
        return tr("{} to {} ({})", first, last, len(self.series))

    async def split(self) -> None:
        assert self.recording is not None
        made = await run.io_bound(
            files.split_into_photos, self.recording, self.site.folder
        )
        if made is None:  # the server is being stopped
            return
        ui.notify(tr("{} photos; the recording as it was is under Removed", len(made)))
        self._to_bench()

    async def join(self) -> None:
        made = await run.io_bound(files.join_as_film, self.series, self.site.folder)
        if made is not None:  # None: the server is being stopped
            self._open(made)

    def remove(self) -> None:
        files.remove(self.path, self.site.folder)
        self._to_bench()

    def ask_name(self) -> None:
        with ui.dialog() as dialog, ui.card():
            name = ui.input(tr("New name"), value=self.path.name)

            @errors_shown
            def act() -> None:
                made = files.rename(self.path, name.value or "", self.site.folder)
                self._open(made)

            name.on("keydown.enter", act)
            ui.button(tr("Rename"), on_click=act).props("no-caps")
        dialog.open()

    def ask_bench(self) -> None:
        folder = self.site.folder
        benches = {folder.name_of(b): b for b in folder.benches() if b != self.bench}
        with ui.dialog() as dialog, ui.card():
            ui.label(tr("What its bench.toml says holds for it no longer.")).classes(
                "soft"
            )
            chosen = ui.select([*benches], label=tr("Bench"), value=next(iter(benches)))

            @errors_shown
            def act() -> None:
                if chosen.value not in benches:
                    raise Refused(tr("say to which bench"))
                self._open(files.move(self.path, benches[chosen.value], folder))

            ui.button(tr("Move"), on_click=act).props("no-caps")
        dialog.open()

    def _open(self, made: Path) -> None:
        open_recording(self.site.folder.name_of(made))

    def _to_bench(self) -> None:
        ui.navigate.to(f"/bench?b={quote(self.site.folder.name_of(self.bench))}")


def _item(words: str, act: Callable) -> None:
    ui.menu_item(words, on_click=errors_shown(act))
