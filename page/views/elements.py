"""The picture with what was found over it, as a part of a page."""

from collections.abc import Callable
from typing import Any

from nicegui.element import Element
from nicegui.events import GenericEventArguments

TOOLS = ("", "base", "roi", "window", "ruler", "plumb", "strike", "follow")


class Picture(Element, component="../static/look.js"):
    """Zoomed, panned and dragged in the browser; moved(what, value) is called on release.

    layers, in px of the original picture: surface [[x, y], …], base and lines [x1, y1, x2, y2], roi [x, y, w, h], window
    [low %, high %], crest [x, y], track [[frame, x, y, left out], …].
    """

    def __init__(self, source: str, size: tuple[int, int], label: str, moved: Callable[[str, Any], Any]):
        super().__init__()
        self._props.update(src=source, width=size[0], height=size[1], label=label, layers={}, tool="", frame=0)

        async def send(event: GenericEventArguments) -> None:
            result = moved(event.args["what"], event.args["value"])
            if result is not None and hasattr(result, "__await__"):
                await result

        self.on("moved", send)

    def show(self, **props: Any) -> None:
        """Change the source, layers, tool or frame."""
        self._props.update(props)
        self.update()
