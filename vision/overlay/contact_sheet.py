"""All overlays of a run on one page, so that fifty are looked through in a minute: failed and doubtful ones first."""

from dataclasses import dataclass, field
from pathlib import Path

from jinja2 import Environment, PackageLoader

from vision.measurement import DOUBTFUL, FAILED, GOOD, Observation, worst

_ORDER = {FAILED: 0, DOUBTFUL: 1, GOOD: 2}


@dataclass(frozen=True)
class _Card:
    file: str
    title: str
    rig: str
    quality: str
    lines: tuple[str, ...]
    reasons: tuple[str, ...]


@dataclass
class ContactSheet:
    """Gathers what stands under each picture; `write` makes the page, which names the pictures beside it."""

    cards: list[_Card] = field(default_factory=list)

    def add(self, file: str, picture: str, observation: Observation) -> None:
        """The picture `file` (named `picture` in the observation), with what was measured on it."""
        first = picture == next(iter(observation.pictures))
        quantities = observation.quantities if first else ()
        lines = tuple(f"{q.name} {_number(q.value, q.sd)} {'' if q.unit == '1' else q.unit}" for q in quantities if q.quality != FAILED)
        reasons = tuple(dict.fromkeys(f"{q.name}: {q.reason}" for q in quantities if q.reason))
        quality = worst(quantities) if quantities else GOOD
        title = observation.recording if first else f"{observation.recording}: {picture}"
        self.cards.append(_Card(file, title, observation.rig, quality, lines, reasons))

    def write(self, page: Path) -> None:
        """One HTML file without scripts; it loads the pictures as they come into view."""
        cards = sorted(self.cards, key=lambda card: _ORDER[card.quality])
        template = Environment(loader=PackageLoader("vision.overlay", "."), autoescape=True, trim_blocks=True).get_template(
            "contact_sheet.html.j2"
        )
        page.write_text(template.render(cards=cards, kinds=(FAILED, DOUBTFUL, GOOD)), encoding="utf8", errors="backslashreplace")


def _number(value: float, sd: float) -> str:
    return f"{value:.4g} ± {sd:.2g}" if sd == sd else f"{value:.4g}"
