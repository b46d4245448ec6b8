"""Common to all pages: heading, navigation, style, error messages."""

import inspect
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import partial, wraps
from typing import Any
from urllib.parse import quote

from nicegui import ui

from benchtwin.page.folder import Refused

ANSWER_S = 60.0  # a large bench on a busy machine takes its time
FILES = (
    '<link rel="stylesheet" href="/static/page.css"><script'
    ' src="/static/page.js"></script>'
)


@contextmanager
def frame(title: str, back: str = "", bench: str = "") -> Iterator[None]:
    """The page's frame; back: where the arrow leads; bench: where dropped files go."""
    ui.add_head_html(FILES)
    ui.page_title(f"{title} · benchtwin")
    with ui.header().classes("items-center q-py-sm"):
        if back:
            ui.button(icon="arrow_back", on_click=lambda: ui.navigate.to(back)).props(
                'flat color=white dense aria-label="Back"'
            )
        ui.label(title).classes("text-lg title")
        ui.label().props('id="upload-progress" role="status"')
        dark = ui.dark_mode(None)
        turn = ui.button(
            icon="contrast", on_click=lambda: dark.set_value(not dark.value)
        )
        turn.props('flat color=white dense aria-label="Dark or light"')
    with ui.column().classes("w-full max-w-screen-2xl mx-auto") as body:
        if bench:
            body.props(f'data-bench="{bench_attribute(bench)}"')
        yield


def tabs(
    labels: Iterable[str], here: str, address: Callable[[str], str], of: str
) -> None:
    """Links to the parts of a page, which look like tabs: the address follows, and
    reload, back and a bookmark lead where one was."""
    with ui.element("nav").classes("tabs").props(f'aria-label="{of}"'):
        for label in labels:
            link = ui.link(label, address(label))
            if label == here:
                link.props("aria-current=page")


def recording_address(name: str) -> str:
    """Where the recording of this name is shown."""
    return f"/recording?r={quote(name)}"


def open_recording(name: str) -> None:
    """Go to the page of the recording of this name."""
    ui.navigate.to(recording_address(name))


def neighbours(names: list[str], here: str, caption: str) -> None:
    """Buttons and arrow keys to the recordings before and after `here`."""
    at = names.index(here) if here in names else 0
    with ui.row().classes("items-center gap-1 min-w-0"):
        for icon, step, key, label in (
            ("navigate_before", -1, "j", "The recording before"),
            ("navigate_next", 1, "k", "The next recording"),
        ):
            if 0 <= at + step < len(names):
                go = partial(open_recording, names[at + step])
                button = ui.button(icon=icon, on_click=go)
                button.props(f'flat dense aria-label="{label}" accesskey="{key}"')
        ui.label(f"{at + 1} of {len(names)} · {caption}").classes("soft anywhere")


def bench_attribute(name: str) -> str:
    """A folder's name as it can stand in an attribute of NiceGUI's."""
    return name.replace("&", "&amp;").replace('"', "&quot;")


def quiet_button(words: str, act: Callable[..., Any]) -> ui.button:
    """A button that does not stand out; what its work refuses is shown."""
    return ui.button(words, on_click=errors_shown(act)).props("flat dense no-caps")


def errors_shown(work: Callable[..., Any]) -> Callable[..., Any]:
    """Decorates the work of a button: what it refuses, or fails at, is shown on the
    page."""

    @contextmanager
    def shown() -> Iterator[None]:
        try:
            yield
        except (Refused, OSError) as error:
            where = getattr(error, "filename", None) or ""
            say(f"{where} {error}".strip())

    if inspect.iscoroutinefunction(work):

        @wraps(work)
        async def later(*args: Any) -> Any:
            with shown():
                return await work(*args)

        return later

    @wraps(work)
    def now(*args: Any) -> Any:
        with shown():
            return work(*args)

    return now


def say(refusal: str) -> None:
    """Show why something was refused until it is read."""
    ui.notify(
        refusal, type="negative", multi_line=True, timeout=12_000, close_button="OK"
    )
