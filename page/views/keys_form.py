"""The keys of a recording or bench as a form, saved in its TOML file."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchtwin.page import toml_file
from benchtwin.page.folder import Refused
from benchtwin.page.form import Field, form
from benchtwin.page.views.frame import errors_shown
from nicegui import ui


def form_for(
    path: Path,
    rig: str | None,
    defaults: dict,
    needed: set[tuple[str, str]],
    saved: Callable[[], Any],
) -> None:
    """The form of one TOML file. defaults: what bench.toml says; needed: keys that
    measuring asked for; saved: called after."""
    try:
        keys = toml_file.read(path)
    except Refused as error:
        ui.label(str(error)).classes("failed")
        return
    state = {"keys": keys}
    changed: dict[tuple[str, str], Any] = {}
    inputs: list[tuple[Field, Any]] = []

    @errors_shown
    def save() -> None:
        changes = {**changed}
        for field, text in list(changed_texts.items()):
            changes[field.section, field.key] = field.read(text)
        if not changes:
            ui.notify("Nothing was changed")
            return
        state["keys"] = toml_file.change(state["keys"], changes)
        changed.clear()
        changed_texts.clear()
        ui.notify(f"Saved in {path.name}", type="positive")
        saved()

    changed_texts: dict[Field, Any] = {}
    rig = keys.content.get("rig") or rig
    for section in form(rig, keys.content, defaults):
        wanted = any((section.name, f.key) in needed for f in section.fields)
        with ui.expansion(
            section.title,
            caption=section.help or None,
            value=wanted or section.name in ("", rig),
        ).classes("w-full"):
            usual = [f for f in section.fields if not f.rare]
            rare = [f for f in section.fields if f.rare]
            with ui.element("div").classes("card-grid"):
                for field in usual:
                    inputs.append(
                        (
                            field,
                            _input(
                                field,
                                (section.name, field.key) in needed,
                                changed_texts,
                                changed,
                                keys.content,
                            ),
                        )
                    )
            if rare:
                with (
                    ui.expansion("For simulating only").classes("w-full soft"),
                    ui.element("div").classes("card-grid"),
                ):
                    for field in rare:
                        _input(field, False, changed_texts, changed, keys.content)
    ui.button("Save", on_click=save).props('color=primary accesskey="s"')


def _input(
    field: Field, needed: bool, texts: dict[Field, Any], changed: dict, content: dict
) -> Any:
    """One key; what somebody types is kept in `texts` until it is saved."""
    if field.kind == "conditions":
        return _conditions(content.get("conditions", {}), changed)
    label = field.key + (f" [{field.unit}]" if field.unit else "")
    hint = (
        f"bench: {_shown(field.inherited)}"
        if field.inherited is not None
        else field.bounds
    )
    note = lambda event: texts.__setitem__(field, event.value)  # noqa: E731
    with ui.column().classes("gap-0 w-full" + (" needed" if needed else "")):
        if field.kind in ("choice", "yes"):
            options: Any = (
                {None: "–", True: "yes", False: "no"}
                if field.kind == "yes"
                else {None: "–", **{c: c for c in field.choices}}
            )
            value = field.value if not isinstance(field.value, list) else None
            made: Any = ui.select(options, label=label, value=value, on_change=note)
        else:
            made = ui.input(label, value=_shown(field.value), on_change=note)
        made.classes("w-full").props(f'dense stack-label placeholder="{hint}"')
        ui.label(("needed: " if needed else "") + field.help).classes(
            "text-xs " + ("failed" if needed else "soft")
        )
    return made


def _conditions(present: dict, changed: dict) -> Any:
    """Rows of name and value, whatever the names; a value that is a number is one."""
    rows: list[tuple[Any, Any]] = []

    def note() -> None:
        now = {n.value.strip(): _value(v.value) for n, v in rows if n.value.strip()}
        for name in {*present, *now}:
            changed["conditions", name] = now.get(name) if now.get(name) != "" else None

    with ui.column().classes("w-full gap-0"):
        ui.label(
            "Conditions: whatever differs between recordings, such as moisture_pct ="
            " 12.5 or plate = steel 3"
        ).classes("text-xs soft")
        with ui.column().classes("w-full gap-0") as place:

            def row(name: str, value: str) -> None:
                with place, ui.row().classes("w-full no-wrap"):
                    pair = (
                        ui.input("name", value=name, on_change=note),
                        ui.input("value", value=value, on_change=note),
                    )
                    rows.append(pair)

            for name, value in present.items():
                row(name, _shown(value))
        ui.button("Add a condition", on_click=lambda: row("", "")).props("flat dense")
    return None


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
        return ", ".join(f"{v:g}" if isinstance(v, float) else str(v) for v in value)
    return f"{value:.10g}" if isinstance(value, float) else str(value)
