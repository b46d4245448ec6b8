"""Common to all pages: heading, navigation, style, error messages; tables of
quantities; parts that the browser draws itself (a picture with overlays, a waveform,
recording beside twin)."""

import html
import inspect
import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial, wraps
from pathlib import Path
from typing import Any
from urllib.parse import quote

from nicegui import ui
from nicegui.element import Element
from nicegui.events import GenericEventArguments
from nicegui.language import Language

from benchtwin.bench.language import spoken, tr
from benchtwin.bench.numbers import plus_minus, with_unit
from benchtwin.page.folder import Refused
from benchtwin.vision.measurement import Quantity
from benchtwin.vision.recording import Recording

ANSWER_S = 60.0  # a large bench on a busy machine takes its time
SAID = sorted(  # sentences of the scripts, which get them in the language spoken
    {
        sentence
        for file in Path(__file__).parents[1].glob("static/*.js")
        for sentence in re.findall(r"\btr\('([^']+)'", file.read_text(encoding="utf8"))
    }
)
FILES = """<link rel="stylesheet" href="/static/page.css">
<script>window.sentences = {}</script><script src="/static/page.js"></script>"""
TAGS: dict[str, Language] = {"en": "en-US", "zh": "zh-CN"}  # of Quasar's own words


@contextmanager
def frame(title: str, back: str = "", bench: str = "") -> Iterator[None]:
    """The page's frame; back: where the arrow leads; bench: where dropped files go."""
    sentences = json.dumps({s: tr(s) for s in SAID}).replace("<", "\\u003c")
    ui.add_head_html(FILES.format(sentences))
    ui.context.client.page.language = TAGS[spoken()]
    ui.page_title(f"{title} · benchtwin")
    with ui.header().classes("items-center q-py-sm"):
        if back:
            ui.button(icon="arrow_back", on_click=lambda: ui.navigate.to(back)).props(
                f'flat color=white dense aria-label="{attribute(tr("Back"))}"'
            )
        ui.label(title).classes("text-lg title")
        ui.label().props('id="upload-progress" role="status"')
        dark = ui.dark_mode(None)
        turn = ui.button(
            icon="contrast", on_click=lambda: dark.set_value(not dark.value)
        )
        turn.props(
            f'flat color=white dense aria-label="{attribute(tr("Dark or light"))}"'
        )
    with ui.column().classes("w-full max-w-screen-2xl mx-auto") as body:
        if bench:
            body.props(f'data-bench="{attribute(bench)}"')
        yield


def tabs(
    labels: Iterable[str], here: str, address: Callable[[str], str], of: str
) -> None:
    """Links to the parts of a page, which look like tabs: the address follows, in
    English, and reload, back and a bookmark lead where one was."""
    with ui.element("nav").classes("tabs").props(f'aria-label="{attribute(tr(of))}"'):
        for label in labels:
            link = ui.link(tr(label), address(label))
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
            ("navigate_before", -1, "j", tr("The recording before")),
            ("navigate_next", 1, "k", tr("The next recording")),
        ):
            if 0 <= at + step < len(names):
                go = partial(open_recording, names[at + step])
                button = ui.button(icon=icon, on_click=go)
                button.props(
                    f'flat dense aria-label="{attribute(label)}" accesskey="{key}"'
                )
        ui.label(tr("{} of {} · {}", at + 1, len(names), caption)).classes(
            "soft anywhere"
        )


def attribute(words: str) -> str:
    """Words as they can stand in an attribute of NiceGUI's."""
    return words.replace("&", "&amp;").replace('"', "&quot;")


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
        refusal, type="negative", multi_line=True, timeout=12_000, close_button=tr("OK")
    )


def in_words(name: str) -> str:
    """A quantity's name: repose_angle is "repose angle"."""
    return name.replace("_", " ")


def kind_in_words(recording: Recording) -> str:
    """ "drop · photos"."""
    return f"{recording.rig or tr('which rig?')} · {tr(recording.evidence)}"


def quantities_table(columns: Mapping[str, Iterable[Quantity]]) -> str:
    """HTML table: a row a quantity, a column a way of measuring ("automatic",
    "corrected")."""
    by_name: dict[str, dict[str, Quantity]] = {}
    for heading, quantities in columns.items():
        for q in quantities:
            by_name.setdefault(q.name, {})[heading] = q
    head = "".join(f'<th scope="col">{html.escape(tr(h))}</th>' for h in columns)
    rows = []
    for name, found in by_name.items():
        unit = with_unit(next(iter(found.values())).unit).strip()
        cells = "".join(_cell(found.get(h)) for h in columns)
        rows.append(
            f'<tr><th scope="row">{html.escape(in_words(name))}</th>{cells}'
            f"<td>{html.escape(unit)}</td></tr>"
        )
    return (
        '<table class="numbers"><thead><tr><th></th>'
        f"{head}<th></th></tr></thead><tbody>{''.join(rows)}</tbody></table>"
    )


def _cell(q: Quantity | None) -> str:
    if q is None:
        return "<td></td>"
    title = f' title="{html.escape(q.reason)}"' if q.reason else ""
    return (
        f'<td class="n {q.quality}"{title}>{plus_minus(q.value, q.sd)}'
        f" <small>{html.escape(tr(q.quality))}</small></td>"
    )


class Picture(Element, component="../static/look.js"):
    """Zoomed, panned and dragged in the browser, a film played there too; moved(what,
    value) is called on release.

    layers, in px of the original picture: surface [[x, y], …], base and lines [x1, y1,
    x2, y2], roi [x, y, w, h], window [low %, high %], crest [x, y], track [[frame, x,
    y, left out], …], places [[frame, x, y], …]. film: its frames' numbers, the address
    `source` to which &i=number is added, the rate [frames/s] at which speed 1 plays it,
    and whether that is the camera's (timed)."""

    def __init__(
        self,
        source: str,
        size: tuple[int, int],
        label: str,
        moved: Callable[[str, Any], Any],
        film: dict[str, Any] | None = None,
    ):
        super().__init__()
        self._props.update(
            src=source,
            width=size[0],
            height=size[1],
            label=label,
            layers={},
            tool="",
            film=film,
        )

        async def send(event: GenericEventArguments) -> None:
            result = moved(event.args["what"], event.args["value"])
            if result is not None and hasattr(result, "__await__"):
                await result

        self.on("moved", send)

    def show(self, **props: Any) -> None:
        """Change the layers or the tool."""
        self._props.update(props)
        self.update()


class Wave(Element, component="../static/wave.js"):
    """Zoomed and panned in the browser, which asks `source` for what it shows;
    clicked(at_s, reach_s) is called on a click.

    marks, moments in s: impacts, added (those of them that were set by hand), struck,
    others."""

    def __init__(
        self,
        source: str,
        begin_s: float,
        end_s: float,
        clicked: Callable[[float, float], Any],
    ):
        super().__init__()
        self._props.update(src=source, begin=begin_s, end=end_s, marks={})

        async def send(event: GenericEventArguments) -> None:
            await clicked(float(event.args["at"]), float(event.args["reach"]))

        self.on("clicked", send)

    def show(self, **marks: list[float]) -> None:
        """Change what is marked."""
        self._props["marks"] = marks
        self.update()


class SideBySide(Element, component="../static/side_by_side.js"):
    """Recording, twin and difference; `shown` as `page.side_by_side.browser_data` gives
    it."""

    def __init__(self, shown: dict):
        super().__init__()
        self._props.update(shown=shown)
