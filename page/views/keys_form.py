"""The keys of a recording or bench as a form that saves itself in its TOML file."""

import math
from collections.abc import Awaitable, Callable
from functools import partial
from pathlib import Path
from time import strftime
from typing import Any

from nicegui import ui

from benchtwin.bench.language import tr
from benchtwin.page import toml_file
from benchtwin.page.folder import Refused
from benchtwin.page.form import UNKNOWN, Field, form, table
from benchtwin.page.site import Site
from benchtwin.page.views.frame import attribute, errors_shown

REST_MS = 800  # without typing, after which what was typed is saved

Place = tuple[str, str]  # (section, key)


class KeysForm:
    """The form of one TOML file. What is typed is saved when the typing rests or the
    field is left; what cannot be saved stays in its field, with the reason below it."""

    def __init__(
        self,
        site: Site,
        path: Path,
        rig: str | None,
        defaults: dict,
        saved: Callable[[set[Place]], Awaitable[None]] | None = None,
    ):
        """defaults: what bench.toml says; saved: called with the keys after they were
        saved."""
        self.site, self.path, self.saved = site, path, saved
        self.refused: set[Place] = set()  # typed, but not saved
        self.loaded: dict[Place, Any] = {}  # the file's values as the form shows them
        self.inputs: dict[Place, _Input] = {}
        self.conditions: _Conditions | None = None
        self.sections: dict[str, Any] = {}
        self.status = ui.label(tr("Saves itself.")).classes("soft text-sm anywhere")
        self.status.props('role="status"')
        try:
            content = toml_file.read(path).content
        except (Refused, OSError) as error:
            self.status.set_text(str(error))
            self._text()
            return
        self._build(content, content.get("rig") or rig, defaults)

    def _build(self, content: dict, rig: str | None, defaults: dict) -> None:
        for section in form(rig, content, defaults):
            opened = section.name in ("", rig, UNKNOWN)
            caption = tr(section.help) or None
            place = ui.expansion(tr(section.title), caption=caption, value=opened)
            self.sections[section.name] = place.classes("w-full")
            rare = [one for one in section.fields if one.rare]
            with place:
                self._grid([one for one in section.fields if not one.rare], content)
                if rare:
                    with ui.expansion(tr("For simulating only")).classes("w-full soft"):
                        self._grid(rare, content)

    def _grid(self, fields: list[Field], content: dict) -> None:
        with ui.element("div").classes("card-grid"):
            for one in fields:
                self._add(one, content)

    def _text(self) -> None:
        """The file as it is, where it is no TOML that a form could show."""
        seen = toml_file.any_text(self.path)
        text = ui.textarea(self.path.name, value=seen)
        text.classes("w-full").props("outlined autogrow")

        @errors_shown
        async def save() -> None:
            with self.site.history.kept(self.path):
                toml_file.write_text(self.path, text.value or "", seen)
            if self.saved:
                await self.saved(set())
            ui.navigate.reload()

        ui.button(tr("Save"), on_click=save).props("no-caps")

    def _add(self, one: Field, content: dict) -> None:
        if one.kind == "conditions":
            present = table(content, "conditions")
            self.conditions = _Conditions(present, self.change)
            self.loaded |= {("conditions", k): v for k, v in present.items()}
            return
        place = (one.section, one.key)
        self.loaded[place] = _in(content, place)
        self.inputs[place] = _Input(one, partial(self.change, place))

    async def change(self, place: Place, typed: Any) -> None:
        """Save what somebody typed or chose; what is refused stays in its field."""
        field = self.inputs.get(place)
        self.refused.discard(place)
        try:
            if field and typed == field.shown(self.loaded.get(place)):
                field.say("")
                return
            self._write(place, typed if field is None else field.key.read(typed))
        except (Refused, OSError) as error:
            self.refused.add(place)
            self.status.set_text(tr("Not saved: {}", error))
            if field:
                field.say(str(error))
            return
        if field:
            field.say("")
        self.status.set_text(
            tr("Saved in {} at {}", self.path.name, strftime("%H:%M:%S"))
        )
        if self.saved:
            await self.saved({place})

    def _write(self, place: Place, value: Any) -> None:
        """Refused where the key has another value by now than the form showed."""
        keys = toml_file.read(self.path)
        present = _in(keys.content, place)
        if present != self.loaded.get(place) and present != value:
            self.loaded[place] = present
            raise Refused(
                tr(
                    "{} was changed meanwhile, elsewhere: it is {} now. Yours is not"
                    " saved; change it again to save it all the same",
                    place[1],
                    _shown(present) or tr("not stated"),
                )
            )
        with self.site.history.kept(self.path):
            toml_file.change(keys, {place: value})
        self.loaded[place] = value

    def ask_for(self, needed: set[Place]) -> None:
        """Mark the keys that measuring asked for, and open their sections."""
        for place, field in self.inputs.items():
            field.mark(place in needed)
        for section, _ in needed & self.inputs.keys():
            self.sections[section].set_value(True)

    def take(self) -> None:
        """Show what the file says by now; what is typed and not saved stays."""
        try:
            content = toml_file.read(self.path).content
        except Refused as error:
            self.status.set_text(str(error))
            return
        for place, field in self.inputs.items():
            self.loaded[place] = _in(content, place)
            if place not in self.refused:
                field.show(self.loaded[place])
        if self.conditions:
            present = table(content, "conditions")
            self.loaded |= {("conditions", k): v for k, v in present.items()}
            self.conditions.take(present)


class _Input:
    """One key: field, meaning, and why it could not be saved."""

    def __init__(self, key: Field, changed: Callable[[Any], Awaitable[None]]):
        self.key = key
        label = key.key + (f" [{key.unit}]" if key.unit else "")
        inherited = key.inherited is not None
        hint = tr("bench: {}", _shown(key.inherited)) if inherited else key.bounds
        with ui.column().classes("gap-0 w-full") as self.column:
            self.made: Any
            if key.kind in ("choice", "yes"):
                yes = {True: tr("yes"), False: tr("no")}
                named = yes if key.kind == "yes" else {c: c for c in key.choices}
                self.named: dict = {None: "–", **named}
                self.made = ui.select(
                    self._with(self.shown(key.value)),
                    label=label,
                    value=self.shown(key.value),
                    on_change=lambda e: changed(e.value),
                )
            else:
                self.made = ui.input(
                    label,
                    value=self.shown(key.value),
                    on_change=lambda e: changed(e.value),
                )
                self.made.props(f"debounce={REST_MS}")
            if key.kind == "rows":
                self.made.props("readonly")
            self.made.classes("w-full").props(
                "dense stack-label hide-bottom-space"
                f' placeholder="{attribute(hint)}"'
                f' aria-label="{attribute(label)}"'
            )
            self.help = ui.label().classes("text-xs")
        self.mark(False)

    def shown(self, value: Any) -> Any:
        """A value as the field holds it."""
        if self.key.kind == "yes" and isinstance(value, bool):
            return value
        if self.key.kind in ("yes", "choice"):
            return None if value is None or isinstance(value, list) else str(value)
        if self.key.kind == "rows" and isinstance(value, list):
            return tr("{} set on the picture", len(value)) if value else ""
        return _shown(value)

    def _with(self, value: Any) -> dict:
        """The choices, and a value that is none of them."""
        known = value in self.named
        return (
            self.named if known else {**self.named, value: tr("{} (not known)", value)}
        )

    def show(self, value: Any) -> None:
        if self.key.kind in ("yes", "choice"):
            self.made.set_options(self._with(self.shown(value)))
        self.made.set_value(self.shown(value))

    def say(self, why: str) -> None:
        self.made.error = why or None

    def mark(self, needed: bool) -> None:
        self.column.classes(**{"add" if needed else "remove": "needed"})
        self.help.set_text(
            tr("needed: {}", tr(self.key.help)) if needed else tr(self.key.help)
        )
        now, before = ("failed", "soft") if needed else ("soft", "failed")
        self.help.classes(add=now, remove=before)


class _Conditions:
    """Rows of name and value, whatever the names; a value that is a number is one. They
    are saved when a field is left: half a name is no name."""

    def __init__(self, present: dict, change: Callable[[Place, Any], Awaitable[None]]):
        self.present, self.change = present, change
        self.rows: list[tuple[Any, Any]] = []
        with ui.column().classes("w-full gap-0"):
            ui.label(
                tr(
                    "Conditions: whatever differs between recordings, such as"
                    " moisture_pct = 12.5 or plate = steel 3"
                )
            ).classes("text-xs soft")
            self.place = ui.column().classes("w-full gap-0")
            self._rows()
            ui.button(tr("Add a condition"), on_click=lambda: self._row("", "")).props(
                "flat dense no-caps"
            )

    def _rows(self) -> None:
        self.rows = []
        self.place.clear()
        for name, value in self.present.items():
            self._row(name, _shown(value))

    def _row(self, name: str, value: str) -> None:
        with self.place, ui.row().classes("w-full no-wrap"):
            pair = ui.input(tr("name"), value=name), ui.input(tr("value"), value=value)
        for one in pair:
            one.classes("grow min-w-0").on("blur", self._left)
            one.on("keydown.enter", self._left)
        self.rows.append(pair)

    async def _left(self) -> None:
        typed = {n.value.strip(): _value(v.value) for n, v in self.rows}
        now = {name: value for name, value in typed.items() if name and value != ""}
        before, self.present = self.present, now
        for name in {*before, *now}:
            if now.get(name) != before.get(name):
                await self.change(("conditions", name), now.get(name))

    def take(self, present: dict) -> None:
        if present != self.present:
            self.present = present
            self._rows()


def _in(content: dict, place: Place) -> Any:
    section, key = place
    return (table(content, section) if section else content).get(key)


def _value(text: str) -> float | str:
    try:
        value = float(text.strip().replace(",", "."))
    except ValueError:
        return text.strip()
    return value if math.isfinite(value) else text.strip()


def _shown(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, list | tuple):
        return ", ".join(_shown(v) for v in value)
    return f"{value:.10g}" if isinstance(value, float) else str(value)
