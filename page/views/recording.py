"""The page of a recording: picture with overlays, corrections by hand, its keys."""

import asyncio
from collections.abc import Awaitable, Callable
from contextlib import suppress
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
from nicegui import ui

from benchtwin.bench.language import tr
from benchtwin.bench.rigs import RIGS
from benchtwin.page import measuring, sound_impacts, toml_file
from benchtwin.page.folder import Refused
from benchtwin.page.form import needed
from benchtwin.page.measuring import original_name
from benchtwin.page.recording_files import own_folder
from benchtwin.page.site import Site
from benchtwin.page.views import keys_form, recording_menu
from benchtwin.page.views.frame import (
    ANSWER_S,
    Picture,
    Wave,
    attribute,
    errors_shown,
    frame,
    kind_in_words,
    neighbours,
    open_recording,
    quantities_table,
    quiet_button,
    say,
)
from benchtwin.vision.evidence.photo import photo_size
from benchtwin.vision.evidence.read_keys import read_toml
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.motion.drop_sound import sound_of
from benchtwin.vision.recording import Recording

TOOL_NAMES = {
    "": "Look",
    "base": "Base line",
    "roi": "Region",
    "window": "Window",
    "ruler": "Ruler",
    "plumb": "Plumb line",
    "strike": "Strike out",
    "follow": "Follow",
    "place": "Place",
}
HELP = {
    "": "",
    "base": "Drag the two handles, or Tab to one and use the arrow keys.",
    "roi": "Only what lies inside is looked at. Drag the corners.",
    "window": "The line is fitted between these two heights. Drag them.",
    "ruler": "Lay it over a length that you know, and say how long it is.",
    "plumb": "Lay it along a plumb line, or a wall that stands upright.",
    "strike": "Click the places that are wrong, or step to one and press Enter: no fit"
    " uses them. Once more takes them in again.",
    "follow": "Click the seed, where another thing was followed.",
    "place": "Click the middle of the seed, frame by frame: the film steps on by"
    " itself. Delete takes a place away. By key: Tab to the cross, move it with the"
    " arrow keys, Enter sets it.",
}
BY_HAND = {  # keys that "Automatic again" takes away
    "pile": [("pile", "baseline_px"), ("pile", "roi_px"), ("pile", "window_pct")],
    "film": [
        ("track", "left_out_frames"),
        ("track", "follow_px"),
        ("track", "places_px"),
        ("track", "only_places"),
    ],
    "sound": [("drop", "impacts_added_s"), ("drop", "impacts_struck_s")],
}
KEPT_AS = {
    "plumb": ("camera", "plumb_deg"),
    "follow": ("track", "follow_px"),
    "place": ("track", "places_px"),
    "unplace": ("track", "places_px"),
    "strike": ("track", "left_out_frames"),
    "base": ("pile", "baseline_px"),
    "roi": ("pile", "roi_px"),
    "window": ("pile", "window_pct"),
}
SHARED = [*BY_HAND["pile"], ("camera", "mm_per_px"), ("camera", "mm_per_px_sd")]
SHARED += [("camera", "plumb_deg"), ("camera", "plumb_sd_deg")]
UNTIMED_FPS = 25.0  # a film whose rate nobody knows is played at


def register(site: Site) -> None:
    """Add the page of a recording to the site."""

    @ui.page("/recording", response_timeout=ANSWER_S)
    async def recording(r: str) -> None:
        try:
            shown = site.recording(r)
        except (Refused, OSError) as error:
            with frame("benchtwin", back="/"):
                why = str(error).replace(f"{site.folder.root}/", "")
                said = ui.label(tr("This recording cannot be opened: {}", why))
                said.classes("failed").style("white-space: pre-wrap")
                _only_keys(site, r)
            return
        await View(site, r, shown).build()


def _only_keys(site: Site, name: str) -> None:
    """What mends it where the files cannot be read: their menu, and the keys."""
    try:
        path = site.folder.inside(name)
        site.folder.refuse_links(path)
    except Refused:
        return
    if not path.exists():
        return
    recording_menu.show_for_broken(site, path)

    async def again(_: set[keys_form.Place]) -> None:
        ui.navigate.reload()

    beside = path.parent / "bench.toml"
    wrong = path != site.folder.root and _unreadable(beside)
    if not path.is_dir() and not wrong:
        return
    file = beside if wrong else path / "recording.toml"
    ui.label(file.name).classes("text-h6")
    keys_form.KeysForm(site, file, None, {}, again)


def _unreadable(file: Path) -> bool:
    if not file.is_file():
        return False
    try:
        read_toml(file)
    except (MeasurementError, OSError):
        return True
    return False


class View:
    """A recording's page; measuring runs beside it, the page stays alive."""

    def __init__(self, site: Site, name: str, recording: Recording):
        self.site, self.name, self.recording = site, name, recording
        at = recording.path
        self.bench = at if at == site.folder.root else at.parent
        self.picture: Picture | None = None
        self.wave: Wave | None = None
        self.heard: sound_impacts.SoundView | None = None
        self.form: keys_form.KeysForm | None = None
        self.size = (1, 1)
        self.ruler: list[float] | None = None
        self.layers: dict[str, Any] = {}
        self.done = 0.0  # of the measuring that goes on
        self.asked = 0  # how often measuring was asked for; only the last one is done
        self.one_at_a_time = asyncio.Lock()
        # measured once: a reload forgets it
        self.uncorrected: measuring.PileOverlay | None = None

    @property
    def is_pile(self) -> bool:
        return self.recording.rig == "pile" and self.recording.evidence == "photos"

    async def build(self) -> None:
        back = f"/bench?b={quote(self.site.folder.name_of(self.bench))}"
        with frame(self.recording.id, back=back):
            entries = await asyncio.to_thread(self.site.recordings, self.bench)
            self.others = [e for e in entries if isinstance(e, Recording)]
            names = [self.site.folder.name_of(e.path) for e in self.others]
            with ui.row().classes("w-full items-center gap-x-4"):
                neighbours(names, self.name, self._caption())
                self._undo_buttons()
                recording_menu.show(self.site, self.recording, entries)
            if self.recording.rig is None and self.recording.evidence != "photos":
                self._which_rig()
            with ui.element("div").classes("picture-and-numbers"):
                with ui.column().classes("w-full min-w-0") as self.place:
                    await self._tried(self._picture)
                with ui.column().classes("min-w-0 gap-2"):
                    with ui.element("div").classes("scroll-x"):
                        self.numbers = ui.html("", sanitize=False)
                    self.reasons = ui.column().classes("gap-1")
                    self.busy = ui.row().classes("items-center").props('role="status"')
            with ui.column().classes("w-full"):
                self._keys()
        # the page is there while the sound is read and all is measured
        await ui.context.client.connected(timeout=30)
        with self.place:
            await self._heard()
        await self._measure()

    async def _tried(self, show: Callable[[], Awaitable[None]]) -> None:
        """Show a part of the page; where its file cannot be read, measuring says so."""
        with suppress(MeasurementError, OSError):
            await show()

    def _caption(self) -> str:
        file = original_name(self.recording)
        kind = kind_in_words(self.recording)
        return f"{kind} · {file}" if file else kind

    def _undo_buttons(self) -> None:
        with ui.row().classes("gap-1 items-center"):
            self.undo = ui.button(tr("Undo"), icon="undo")
            self.undo.on_click(errors_shown(partial(self._turn, back=True)))
            self.redo = ui.button(tr("Redo"), icon="redo")
            self.redo.on_click(errors_shown(partial(self._turn, back=False)))
            for button, keys, name in (
                (self.undo, "Ctrl+Z", "undo"),
                (self.redo, "Ctrl+Shift+Z", "redo"),
            ):  # page.js presses them by key
                button.props(f"flat dense no-caps data-key={name}").tooltip(keys)
        self._undo_state()

    def _undo_state(self) -> None:
        self.undo.set_enabled(self.site.history.can_undo(self.recording.toml))
        self.redo.set_enabled(self.site.history.can_redo(self.recording.toml))

    async def _turn(self, *, back: bool) -> None:
        """Take back, or do again, the last change of this recording's keys."""
        rig, history = self.recording.rig, self.site.history
        turned = (history.undo if back else history.redo)(self.recording.toml)
        others = [file.parent.name for file in turned if file != self.recording.toml]
        if others:
            ui.notify(tr("Also in {}", ", ".join(others)))
        await self._changed(rig)

    async def _changed(self, rig: str | None) -> None:
        """The keys are others now; rig: what it was before."""
        try:
            now = self.site.recording(self.name).rig
        except (Refused, OSError):
            now = rig  # measuring says why
        if now != rig:
            ui.navigate.reload()
            return
        if self.form:
            self.form.take()
        await self._measure()

    def _which_rig(self) -> None:
        """What was done, asked before anything else: nothing is measured without it."""

        async def done(rig: str) -> None:
            await self._keep({("", "rig"): rig}, by_hand=False)

        with ui.row().classes("items-center"):
            ui.label(tr("What was done?")).classes("text-lg failed")
            for rig in RIGS.values():
                words, act = f"{rig.name}: {tr(rig.what)}", partial(done, rig.name)
                ui.button(words, on_click=act).props("no-caps outline")

    async def _picture(self) -> None:
        if self.is_pile:
            self.size = photo_size(self.recording.files[0])
            self._tools(("", "base", "roi", "window", "ruler", "plumb"))
            version = self.recording.files[0].stat().st_mtime_ns
            source = f"/photo?r={quote(self.name)}&v={version}"
            self.picture = Picture(
                source, self.size, tr("Photo of {}", self.recording.id), self._moved
            )
        elif self.recording.evidence in ("frames", "video"):
            await self._film()

    async def _heard(self) -> None:
        if not self.is_pile:
            await self._tried(self._sound)
            self.plots = ui.column().classes("w-full")

    async def _sound(self) -> None:
        """The waveform of a drop that was heard."""
        if (
            self.recording.rig != "drop"
            or await asyncio.to_thread(sound_of, self.recording) is None
        ):
            return
        sound, _ = await asyncio.to_thread(self.site.sound, self.recording)
        with ui.row().classes("items-center"):
            ui.element("audio").props(
                f'controls preload=none src="/sound?r={quote(self.name)}"'
                f' aria-label="{attribute(tr("The sound"))}"'
            ).style("height: 2.2rem; max-width: 100%")
            if self.picture is None:
                quiet_button(tr("Automatic again"), self._automatic)
        address = f"/wave?r={quote(self.name)}"
        end_s = sound.start_s + sound.duration_s
        self.wave = Wave(address, sound.start_s, end_s, self._clicked)

    async def _clicked(self, at_s: float, reach_s: float) -> None:
        """An impact was added or struck out."""
        if self.heard is not None:
            drop = self.recording.drop
            await self._keep(
                sound_impacts.changes_of_click(at_s, reach_s, self.heard, drop)
            )

    def _tools(self, tools: tuple[str, ...]) -> None:
        with ui.row().classes("items-center gap-2"):
            self.tool = ui.toggle(
                {t: tr(TOOL_NAMES[t]) for t in tools}, value=""
            ).props(f'dense no-caps aria-label="{attribute(tr("Tool"))}"')
            self.tool.classes("wrapping")
            self.tool.on_value_change(lambda e: self._take_tool(e.value or ""))
            quiet_button(tr("Automatic again"), self._automatic)
            if self.is_pile and self._alike():
                quiet_button(tr("Use on other photos …"), self._ask_others)
            with ui.row().classes("items-center") as scale:
                self.length = ui.number(
                    tr("length of the ruler [mm]"), value=100, min=0
                )
                self.length.props("dense").classes("w-40")
                act = errors_shown(self._set_scale)
                ui.button(tr("Set scale"), on_click=act).props("dense no-caps")
            scale.bind_visibility_from(self.tool, "value", value="ruler")
            only = ui.checkbox(
                tr("Use only places set by hand"),
                value=bool(self.recording.track.only_places),
                on_change=lambda e: self._keep(
                    {("track", "only_places"): True if e.value else None}
                ),
            )
            only.bind_visibility_from(self.tool, "value", value="place").props("dense")
        self.help = ui.label().classes("soft text-xs")
        self.help.set_visibility(False)

    def _take_tool(self, tool: str) -> None:
        self.help.set_text(tr(HELP[tool]))
        self.help.set_visibility(bool(tool))
        self._show(tool=tool)

    async def _film(self) -> None:
        film = await asyncio.to_thread(self.site.film, self.name)
        self.size = film.size
        movable = self.recording.rig in ("drop", "roll", "slide")
        of_seed = ("strike", "follow", "place") if movable else ()
        self._tools(("", *of_seed, "ruler", "plumb"))
        version = self.recording.files[0].stat().st_mtime_ns
        played = {
            "numbers": film.numbers,
            "source": f"/frame?r={quote(self.name)}&v={version}",
            "rate": film.source.fps or UNTIMED_FPS,
            "timed": bool(film.source.fps),
        }
        label = tr("Film of {}", self.recording.id)
        self.picture = Picture("", self.size, label, self._moved, played)
        ui.label(
            tr("On the picture: ← → one frame (Shift: ten), Space plays, + − 0 zoom.")
            + (
                ""
                if played["timed"]
                else tr(" Its frame rate is not known: 25 a second.")
            )
        ).classes("soft text-xs")

    def _show(self, **props: Any) -> None:
        if self.picture is not None:
            self.picture.show(**props)

    def _draw(self, **layers: Any) -> None:
        """Change some of what lies over the picture."""
        self.layers = self.layers | layers
        self._show(layers=self.layers)

    async def _measure(self) -> None:
        """Measure anew with what the files say now, and show it; what is asked for
        meanwhile is done once, afterwards."""
        self.asked += 1
        mine = self.asked
        self._undo_state()
        async with self.one_at_a_time:
            if mine == self.asked:
                await self._measure_now()

    async def _measure_now(self) -> None:
        self.done = 0.0
        self.busy.clear()
        with self.busy:
            ui.spinner()
            words = ui.label(tr("measuring …"))
            ui.timer(0.5, lambda: words.set_text(self._going_on()))
        try:
            self.recording = self.site.recording(self.name)
            self._draw(places=[list(p) for p in self.recording.track.places_px or ()])
            if self.is_pile:
                reasons = await self._measure_pile()
            else:
                reasons = await self._measure_other()
        except (Refused, OSError, MeasurementError) as error:
            reasons = [str(error)]
        self.busy.clear()
        self.reasons.clear()
        with self.reasons:
            for text in reasons:
                ui.label(text).classes("text-sm anywhere")
        if self.form:
            self.form.ask_for(needed(reasons, self.recording))

    def _going_on(self) -> str:
        return tr("measuring …") + (f" {self.done:.0%}" if self.done else "")

    def _done(self, share: float) -> None:
        self.done = share

    async def _measure_pile(self) -> list[str]:
        options = measuring.corrected_options(self.recording)
        plain = measuring.automatic_options(self.recording)
        found = await asyncio.to_thread(measuring.measure_pile, self.recording, options)
        columns = {"automatic": found.quantities}
        if options != plain:
            if self.uncorrected is None:
                self.uncorrected = await asyncio.to_thread(
                    measuring.measure_pile, self.recording, plain
                )
            columns = {"corrected": found.quantities}
            columns["automatic"] = self.uncorrected.quantities
        told = {"quantities", "notes", "trouble"}
        self._draw(**{k: v for k, v in asdict(found).items() if k not in told})
        self.numbers.set_content(quantities_table(columns))
        return measuring.reasons(found.quantities, found.notes, found.trouble)

    async def _listen(self) -> list[str]:
        """The impacts on the waveform and what they say; where there are pictures too,
        that is the sound's part alone."""
        sound, onsets = await asyncio.to_thread(self.site.sound, self.recording)
        now = await asyncio.to_thread(
            sound_impacts.find_with_corrections, sound, onsets, self.recording
        )
        self.heard = now
        assert self.wave is not None
        self.wave.show(
            impacts=now.impacts, added=now.added, struck=now.struck, others=now.others
        )
        drop = self.recording.drop
        columns = {"automatic": now.quantities}
        if drop.impacts_added_s or drop.impacts_struck_s:
            columns = {"corrected": now.quantities, "automatic": now.automatic}
        self.numbers.set_content(quantities_table(columns))
        self.plots.clear()
        with self.plots:
            self._overlay("sound")
        return measuring.reasons(now.quantities, now.notes, now.trouble)

    def _overlay(self, name: str) -> None:
        toml = self.recording.toml
        version = hash((toml.stat().st_mtime_ns if toml.exists() else 0, name))
        ui.image(
            f"/overlay?r={quote(self.name)}&name={quote(name)}&v={version}"
        ).classes("w-full")

    async def _measure_other(self) -> list[str]:
        if self.wave is not None:
            reasons = await self._listen()
            if self.recording.evidence == "sound":
                return reasons
        found = await asyncio.to_thread(
            self.site.observation, self.recording, self._done
        )
        self.numbers.set_content(quantities_table({"measured": found.quantities}))
        if found.places is not None:
            rows = [
                [int(r.frame), round(r.x_px, 2), round(r.y_px, 2), bool(r.left_out)]
                for r in found.places.itertuples()
            ]
            self._draw(track=rows)
        self.plots.clear()
        with self.plots:
            for picture in found.pictures:
                self._overlay(picture)
        return measuring.reasons(found.quantities, found.notes)

    def _keys(self) -> None:
        if not self.recording.path.is_dir():
            ui.label(
                tr(
                    "This photo lies loose in the folder. The first correction puts it"
                    " into a folder of its own, which holds what is said of it."
                )
            ).classes("soft")
            recording_menu.own_folder_button(self.site, self.recording)
            return
        beside = self.bench / "bench.toml"
        try:
            defaults = read_toml(beside) if beside.is_file() else {}
        except MeasurementError as error:
            defaults = {}
            ui.label(str(error)).classes("failed")
        ui.label(tr("What is known of this recording")).classes("text-h6")

        async def saved(keys: set[keys_form.Place]) -> None:
            if ("", "rig") in keys:
                ui.navigate.reload()
            else:
                await self._measure()

        self.form = keys_form.KeysForm(
            self.site, self.recording.toml, self.recording.rig, defaults, saved
        )

    async def _moved(self, what: str, value: Any) -> None:
        """A handle was let go: keep it, measure anew."""
        if what == "ruler":
            self.ruler = value
            return
        kept: Any = value
        track = self.recording.track
        if what == "plumb":
            kept = round(measuring.plumb(value), 3)
        elif what in ("place", "unplace"):
            at = int(value[0] if what == "place" else value)
            kept = [[*p] for p in track.places_px or () if p[0] != at]
            if what == "place":
                kept.append([at, *(round(float(v), 1) for v in value[1:])])
            kept = sorted(kept) or None
        elif what == "strike":
            kept = sorted({*(track.left_out_frames or ())} ^ {int(value)}) or None
        elif what == "roi":
            kept = [int(v) for v in value]
        else:
            kept = [round(float(v), 1 if what == "follow" else 2) for v in value]
        await self._keep({KEPT_AS[what]: kept})

    async def _set_scale(self) -> None:
        width, height = self.size
        points = self.ruler or [0.35 * width, 0.5 * height, 0.65 * width, 0.5 * height]
        try:
            scale, sd = measuring.ruler(points, float(self.length.value or np.nan))
        except MeasurementError as error:
            raise Refused(str(error)) from error
        await self._keep(
            {
                ("camera", "mm_per_px"): float(f"{scale:.6g}"),
                ("camera", "mm_per_px_sd"): float(f"{sd:.2g}"),
            }
        )

    async def _automatic(self) -> None:
        filmed, heard = self.picture is not None, self.wave is not None
        kinds = ["pile"] if self.is_pile else ["film"] * filmed + ["sound"] * heard
        if filmed:
            self.tool.set_value("")
        await self._keep(dict.fromkeys(key for kind in kinds for key in BY_HAND[kind]))

    async def _keep(self, changes: dict, *, by_hand: bool = True) -> None:
        """Write keys and measure anew."""
        rig = self.recording.rig
        try:
            loose = not self.recording.path.is_dir()
            if loose:
                made = own_folder(self.recording.path, self.site.folder)
                self.name = self.site.folder.name_of(made)
                self.recording = self.site.recording(self.name)
            with self.site.history.kept(self.recording.toml):
                keys = toml_file.read(self.recording.toml)
                toml_file.change(keys, changes, by_hand=by_hand)
            self.recording = self.site.recording(self.name)
        except (Refused, OSError) as error:
            say(str(error))
            loose = False
        if loose:
            open_recording(self.name)
            return
        await self._changed(rig)

    def _alike(self) -> list[Recording]:
        """The other photos of piles in this bench, each in a folder of its own."""
        return [
            r
            for r in self.others
            if r.rig == "pile"
            and r.evidence == "photos"
            and r.path.is_dir()
            and r.path != self.recording.path
        ]

    def _ask_others(self) -> None:
        """Which photos are to have the base line, region, window, scale and plumb line
        of this one."""
        stated = toml_file.read(self.recording.toml).content
        shared = {
            place: stated[place[0]][place[1]]
            for place in SHARED
            if place[1] in stated.get(place[0], {})
        }
        with ui.dialog() as dialog, ui.card().classes("w-96 max-w-full"):
            ui.label(tr("Use on other photos")).classes("text-h6")
            if not shared:
                ui.label(
                    tr(
                        "Nothing was set by hand here yet: set a base line, a region, a"
                        " window, a scale or a plumb line first."
                    )
                )
                ui.button(tr("Close"), on_click=dialog.close).props("flat no-caps")
                dialog.open()
                return
            ui.label(", ".join(key for _, key in shared)).classes("anywhere")
            boxes: dict[Path, ui.checkbox] = {}
            with ui.row():
                for words, value in ((tr("All"), True), (tr("None"), False)):
                    quiet_button(
                        words, lambda v=value: [b.set_value(v) for b in boxes.values()]
                    )
            with ui.column().classes("gap-0 w-full chosen-photos"):
                for one in self._alike():
                    file = original_name(one)
                    boxes[one.path] = ui.checkbox(f"{one.id} ({file})").props("dense")
            with ui.row().classes("w-full justify-end"):
                ui.button(tr("Cancel"), on_click=dialog.close).props("flat no-caps")

                def use() -> None:
                    chosen = [r for r in self._alike() if boxes[r.path].value]
                    dialog.close()
                    self._use_on(chosen, shared)

                ui.button(tr("Use on these"), on_click=errors_shown(use)).props(
                    "no-caps"
                )
        dialog.open()

    def _use_on(self, chosen: list[Recording], shared: dict) -> None:
        """Write the keys into each chosen recording, as one change; Refused where a
        photo has another size in pixels: nothing is written then."""
        size = photo_size(self.recording.files[0])
        if other := [r.id for r in chosen if photo_size(r.files[0]) != size]:
            raise Refused(
                tr(
                    "{}: not of {} × {} px as this photo is; places in px do not fit"
                    " there. Nothing was changed",
                    ", ".join(other),
                    size[0],
                    size[1],
                )
            )
        with self.site.history.kept(self.recording.toml, *(r.toml for r in chosen)):
            for one in chosen:
                toml_file.change(toml_file.read(one.toml), shared, by_hand=True)
        ui.notify(
            tr(
                "Used on {} photo{}; Undo on the page of one of them takes it back",
                len(chosen),
                "" if len(chosen) == 1 else "s",
            )
        )
