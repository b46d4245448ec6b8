"""A waveform with the impacts heard in it, as a part of a page."""

from collections.abc import Callable
from typing import Any

from nicegui.element import Element
from nicegui.events import GenericEventArguments


class Wave(Element, component="../static/wave.js"):
    """Zoomed and panned in the browser, which asks `source` for what it shows; clicked(at_s, reach_s) is called on a click.

    marks, moments in s: impacts, added (those of them that were set by hand), struck, others.
    """

    def __init__(self, source: str, begin_s: float, end_s: float, clicked: Callable[[float, float], Any]):
        super().__init__()
        self._props.update(src=source, begin=begin_s, end=end_s, marks={})

        async def send(event: GenericEventArguments) -> None:
            await clicked(float(event.args["at"]), float(event.args["reach"]))

        self.on("clicked", send)

    def show(self, **marks: list[float]) -> None:
        """Change what is marked."""
        self._props["marks"] = marks
        self.update()
