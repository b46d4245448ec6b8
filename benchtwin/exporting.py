"""What `benchtwin.export` writes: calibrated parameters as another DEM engine takes
them."""

from dataclasses import dataclass, field
from html import escape
from pathlib import Path

from benchtwin.bench.exits import DONE


@dataclass(frozen=True)
class Cards:
    """An engine's files. texts: by file name; folder: where they were written."""

    engine: str
    folder: Path
    texts: dict[str, str] = field(repr=False)

    def _repr_html_(self) -> str:
        files = "".join(
            f"<p>{escape(name)}</p><pre>{escape(text)}</pre>"
            for name, text in self.texts.items()
        )
        return f"<p><b>{escape(self.engine)}</b></p>{files}"

    def tell(self, *, quiet: bool) -> int:
        """Print this as the command does, and return its exit code."""
        if not quiet:
            print(*(self.folder / name for name in self.texts), sep="\n")
        return DONE
