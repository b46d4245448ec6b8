"""Parts of a page that the browser draws itself: a picture with overlays, a waveform,
recording beside twin."""

from collections.abc import Callable
from typing import Any

from nicegui.element import Element
from nicegui.events import GenericEventArguments


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
