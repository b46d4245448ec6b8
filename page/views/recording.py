"""The page of a recording: picture with overlays, corrections by hand, its keys."""

import asyncio
from dataclasses import asdict
from functools import partial
from typing import Any
from urllib.parse import quote

import numpy as np
from benchtwin.page import measuring, sound_impacts, toml_file
from benchtwin.page.folder import Refused
from benchtwin.page.form import needed
from benchtwin.page.server import Site
from benchtwin.page.views import keys_form
from benchtwin.page.views.elements import Picture, Wave
from benchtwin.page.views.frame import errors_shown, frame, neighbours
from benchtwin.page.views.numbers import quantities_table
from benchtwin.vision.evidence.read_keys import read_toml
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.motion.drop_sound import sound_of
from benchtwin.vision.recording import Recording
from nicegui import ui
from PIL import Image

TOOL_NAMES = {
    "": "Look",
    "base": "Base line",
    "roi": "Region",
    "window": "Window",
    "ruler": "Ruler",
    "plumb": "Plumb line",
    "strike": "Strike out",
    "follow": "Follow",
}
RIG_NAMES = {
    "drop": "a seed falls on a plate",
    "slide": "a plate is raised",
    "roll": "a seed rolls and runs out",
    "pile": "a heap",
}
BY_HAND = {  # keys that "Automatic again" takes away
    "pile": [("pile", "baseline_px"), ("pile", "roi_px"), ("pile", "window_pct")],
    "film": [("track", "left_out_frames"), ("track", "follow_px")],
    "sound": [("drop", "impacts_added_s"), ("drop", "impacts_struck_s")],
}
KEPT_AS = {
    "base": ("pile", "baseline_px"),
    "roi": ("pile", "roi_px"),
    "window": ("pile", "window_pct"),
}


def register(site: Site) -> None:
    """Add the page of a recording to the site."""

    @ui.page("/recording")
    async def recording(r: str) -> None:
        try:
            shown = site.recording(r)
        except (Refused, OSError) as error:
            with frame("benchtwin", back="/"):
                ui.label(f"This recording cannot be opened: {error}").classes(
                    "failed"
                ).style("white-space: pre-wrap")
                _only_keys(site, r)
            return
        await View(site, r, shown).build()


def _only_keys(site: Site, name: str) -> None:
    """The form alone, where it is the keys that are wrong."""
    try:
        folder = site.folder.inside(name)
        site.folder.refuse_links(folder)
    except Refused:
        return
    if (folder / "recording.toml").is_file():
        keys_form.form_for(
            folder / "recording.toml", None, {}, set(), ui.navigate.reload
        )


class View:
    """A recording's page; measuring runs beside it, the page stays alive."""

    def __init__(self, site: Site, name: str, recording: Recording):
        self.site, self.name, self.recording = site, name, recording
        at = recording.path
        self.bench = at if at == site.folder.root else at.parent
        self.picture: Picture | None = None
        self.wave: Wave | None = None
        self.heard: sound_impacts.SoundView | None = None
        self.size = (1, 1)
        self.ruler: list[float] | None = None
        self.uncorrected: measuring.PileOverlay | None = (
            None  # measured once: a reload forgets it
        )

    @property
    def is_pile(self) -> bool:
        return self.recording.rig == "pile" and self.recording.evidence == "photos"

    async def build(self) -> None:
        back = f"/bench?b={quote(self.site.folder.name_of(self.bench))}"
        with frame(self.recording.id, back=back):
            entries = await asyncio.to_thread(self.site.recordings, self.bench)
            names = [
                self.site.folder.name_of(e.path)
                for e in entries
                if isinstance(e, Recording)
            ]
            neighbours(
                names,
                self.name,
                f"{self.recording.rig or 'which rig?'} · {self.recording.evidence}",
            )
            if self.recording.rig is None:
                self._which_rig()
            with ui.row().classes("w-full no-wrap items-start max-lg:flex-wrap"):
                with ui.column().classes("grow").style("min-width: min(100%, 34rem)"):
                    await self._picture()
                with ui.column().style("min-width: 20rem; max-width: 30rem"):
                    self.numbers = ui.html("", sanitize=False)
                    self.reasons = ui.column().classes("gap-1")
                    self.busy = ui.row().classes("items-center")
            self.form = ui.column().classes("w-full")
        await ui.context.client.connected(
            timeout=30
        )  # the page is there while it is measured
        await self._measure()

    def _which_rig(self) -> None:
        """What was done, asked before anything else: nothing is measured without it."""

        async def say(rig: str) -> None:
            if await self._keep({("", "rig"): rig}, by_hand=False):
                ui.navigate.reload()

        with ui.row().classes("items-center"):
            ui.label("What was done?").classes("text-lg failed")
            for rig, means in RIG_NAMES.items():
                ui.button(f"{rig}: {means}", on_click=partial(say, rig)).props(
                    "no-caps outline"
                )

    async def _picture(self) -> None:
        if self.is_pile:
            with Image.open(self.recording.files[0]) as photo:
                self.size = (
                    photo.size if photo.getexif().get(274, 1) < 5 else photo.size[::-1]
                )
            self._tools(("", "base", "roi", "window", "ruler", "plumb"))
            version = self.recording.files[0].stat().st_mtime_ns
            source = f"/photo?r={quote(self.name)}&v={version}"
            self.picture = Picture(
                source, self.size, f"Photo of {self.recording.id}", self._moved
            )
        elif self.recording.evidence in ("frames", "video"):
            await self._film()
        if not self.is_pile:
            await self._sound()
            self.plots = ui.column().classes("w-full")

    async def _sound(self) -> None:
        """The waveform of a drop that was heard."""
        if (
            self.recording.rig != "drop"
            or await asyncio.to_thread(sound_of, self.recording) is None
        ):
            return
        try:
            sound, _ = await asyncio.to_thread(self.site.sound, self.recording)
        except (MeasurementError, OSError):
            return  # measuring says why
        with ui.row().classes("items-center"):
            ui.element("audio").props(
                f'controls preload=none src="/sound?r={quote(self.name)}"'
            ).style("height: 2.2rem")
            if self.picture is None:
                ui.button(
                    "Automatic again", on_click=errors_shown(self._automatic)
                ).props("flat dense no-caps")
        self.wave = Wave(
            f"/wave?r={quote(self.name)}",
            sound.start_s,
            sound.start_s + sound.duration_s,
            self._clicked,
        )

    async def _clicked(self, at_s: float, reach_s: float) -> None:
        """An impact was added or struck out."""
        if self.heard is not None:
            await self._keep(
                sound_impacts.changes_of_click(
                    at_s, reach_s, self.heard, self.recording.drop
                )
            )

    def _tools(self, tools: tuple[str, ...]) -> None:
        with ui.row().classes("items-center"):
            self.tool = ui.toggle({t: TOOL_NAMES[t] for t in tools}, value="").props(
                "dense no-caps"
            )
            self.tool.on_value_change(lambda e: self._show(tool=e.value or ""))
            ui.button("Automatic again", on_click=errors_shown(self._automatic)).props(
                "flat dense no-caps"
            )
            with (
                ui.row()
                .classes("items-center")
                .bind_visibility_from(self.tool, "value", value="ruler")
            ):
                self.length = (
                    ui.number("ruler, mm", value=100, min=0)
                    .props("dense")
                    .classes("w-24")
                )
                ui.button("Set scale", on_click=errors_shown(self._set_scale)).props(
                    "dense no-caps"
                )

    async def _film(self) -> None:
        film = await asyncio.to_thread(self.site.film, self.recording)
        self.size = film.size
        self._tools(("", "strike", "follow", "ruler", "plumb"))
        self.picture = Picture(
            self._frame(0), self.size, f"Film of {self.recording.id}", self._moved
        )
        with ui.row().classes("w-full items-center no-wrap"):
            last = max(film.count - 1, 0)
            slider = (
                ui.slider(min=0, max=last, value=0, step=1)
                .props('label aria-label="Frame"')
                .classes("grow")
            )
            ui.label().bind_text_from(
                slider, "value", lambda v: f"frame {int(v)} of {last}"
            ).classes("whitespace-nowrap")
        slider.on_value_change(
            lambda e: self._show(src=self._frame(int(e.value)), frame=int(e.value))
        )
        words = (
            "Arrow keys step from frame to frame. Strike out: click the places that are"
            " wrong. Follow: click the seed."
        )
        ui.label(words).classes("soft text-xs")

    def _frame(self, index: int) -> str:
        return f"/frame?r={quote(self.name)}&i={index}"

    def _show(self, **props: Any) -> None:
        if self.picture is not None:
            self.picture.show(**props)

    async def _measure(self) -> None:
        """Measure anew with what the files say now, and show it."""
        self.busy.clear()
        with self.busy:
            ui.spinner()
            ui.label("measuring …")
        try:
            self.recording = self.site.recording(self.name)
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
                ui.label(text).classes("text-sm")
        self.form.clear()
        with self.form:
            self._keys(reasons)

    async def _measure_pile(self) -> list[str]:
        options, plain = (
            measuring.corrected_options(self.recording),
            measuring.automatic_options(self.recording),
        )
        found = await asyncio.to_thread(measuring.measure_pile, self.recording, options)
        columns = {"automatic": found.quantities}
        if options != plain:
            if self.uncorrected is None:
                self.uncorrected = await asyncio.to_thread(
                    measuring.measure_pile, self.recording, plain
                )
            columns = {
                "corrected": found.quantities,
                "automatic": self.uncorrected.quantities,
            }
        self._show(
            layers={
                k: v
                for k, v in asdict(found).items()
                if k not in ("quantities", "notes", "trouble")
            }
        )
        self.numbers.set_content(quantities_table(columns))
        return measuring.reasons(found.quantities, found.notes, found.trouble)

    async def _listen(self) -> list[str]:
        """The impacts on the waveform and what they say; where there are pictures too,
        that is the sound's part alone."""
        sound, onsets = await asyncio.to_thread(self.site.sound, self.recording)
        now = self.heard = await asyncio.to_thread(
            sound_impacts.find_with_corrections, sound, onsets, self.recording
        )
        assert self.wave is not None
        self.wave.show(
            impacts=now.impacts, added=now.added, struck=now.struck, others=now.others
        )
        drop = self.recording.drop
        by_hand = bool(drop.impacts_added_s or drop.impacts_struck_s)
        columns = (
            {"corrected": now.quantities, "automatic": now.automatic}
            if by_hand
            else {"automatic": now.quantities}
        )
        self.numbers.set_content(quantities_table(columns))
        self.plots.clear()
        with self.plots:
            self._overlay("sound")
        return measuring.reasons(now.quantities, now.notes, now.trouble)

    def _overlay(self, name: str) -> None:
        version = hash(
            (
                (
                    self.recording.toml.stat().st_mtime_ns
                    if self.recording.toml.exists()
                    else 0
                ),
                name,
            )
        )
        ui.image(
            f"/overlay?r={quote(self.name)}&name={quote(name)}&v={version}"
        ).classes("w-full")

    async def _measure_other(self) -> list[str]:
        if self.wave is not None:
            reasons = await self._listen()
            if self.recording.evidence == "sound":
                return reasons
        found = await asyncio.to_thread(self.site.seen, self.recording)
        self.numbers.set_content(quantities_table({"measured": found.quantities}))
        if found.places is not None:
            rows = [
                [int(r.frame), round(r.x_px, 2), round(r.y_px, 2), bool(r.left_out)]
                for r in found.places.itertuples()
            ]
            self._show(layers={"track": rows})
        self.plots.clear()
        with self.plots:
            for picture in found.pictures:
                self._overlay(picture)
        return measuring.reasons(found.quantities, found.notes)

    def _keys(self, reasons: list[str]) -> None:
        if not self.recording.path.is_dir():
            ui.label(
                "This photo lies loose in the folder; put it into a folder of its own"
                " to say something about it."
            ).classes("soft")
            return
        beside = self.bench / "bench.toml"
        try:
            defaults = read_toml(beside) if beside.is_file() else {}
        except MeasurementError as error:
            defaults = {}
            ui.label(str(error)).classes("failed")
        ui.label("What is known of this recording").classes("text-h6")
        keys_form.form_for(
            self.recording.path / "recording.toml",
            self.recording.rig,
            defaults,
            needed(reasons),
            ui.navigate.reload,
        )

    async def _moved(self, what: str, value: Any) -> None:
        """A handle was let go: keep it, measure anew."""
        if what == "ruler":
            self.ruler = value
        elif what == "plumb":
            await self._keep(
                {("camera", "plumb_deg"): round(measuring.plumb(value), 3)}
            )
        elif what == "follow":
            await self._keep(
                {("track", "follow_px"): [round(float(v), 1) for v in value]}
            )
        elif what == "strike":
            struck = set(self.recording.track.left_out_frames or ()) ^ {int(value)}
            await self._keep({("track", "left_out_frames"): sorted(struck) or None})
        elif what in KEPT_AS:
            kept = (
                [int(v) for v in value]
                if what == "roi"
                else [round(float(v), 2) for v in value]
            )
            await self._keep({KEPT_AS[what]: kept})

    async def _set_scale(self) -> None:
        points = self.ruler or [
            0.35 * self.size[0],
            0.5 * self.size[1],
            0.65 * self.size[0],
            0.5 * self.size[1],
        ]
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
        kinds = (
            ["pile"]
            if self.is_pile
            else ["film"] * (self.picture is not None)
            + ["sound"] * (self.wave is not None)
        )
        if self.picture is not None:
            self.tool.set_value("")
        await self._keep(dict.fromkeys(key for kind in kinds for key in BY_HAND[kind]))

    async def _keep(self, changes: dict, *, by_hand: bool = True) -> bool:
        """Write keys and measure anew; whether they could be written."""
        kept = True
        try:
            if not self.recording.path.is_dir():
                raise Refused(
                    "This photo lies loose in the folder; put it into a folder of its"
                    " own to correct it"
                )
            keys = toml_file.read(self.recording.path / "recording.toml")
            toml_file.change(keys, changes, by_hand=by_hand)
        except (Refused, OSError) as error:
            kept = False
            ui.notify(str(error), type="negative", timeout=12_000, close_button="OK")
        await self._measure()
        return kept
