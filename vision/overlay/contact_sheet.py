"""All overlays of a run on one page, so that fifty are looked through in a minute: failed and doubtful ones first."""

from dataclasses import dataclass, field
from pathlib import Path

from jinja2 import Environment, PackageLoader

from vision.measurement import DOUBTFUL, FAILED, GOOD, Observation, worst

_ORDER = {FAILED: 0, DOUBTFUL: 1, GOOD: 2}


@dataclass
class ContactSheet:
    """Gathers what stands under each picture; `write` makes the page, which names the pictures beside it."""

    cards: list[dict] = field(default_factory=list)

    def add(self, file: str, picture: str, observation: Observation) -> None:
        """The picture `file` (named `picture` in the observation), with what was measured on it."""
        first = picture == next(iter(observation.pictures))
        quantities = observation.quantities if first else ()
        lines = []
        for q in (q for q in quantities if q.quality != FAILED):
            sd = f" ± {q.sd:.2g}" if q.sd == q.sd else ""
            lines.append(f"{q.name} {q.value:.4g}{sd} {'' if q.unit == '1' else q.unit}")
        self.cards.append({
            "file": file, "rig": observation.rig, "lines": lines,
            "title": observation.recording if first else f"{observation.recording}: {picture}",
            "quality": worst(quantities) if quantities else GOOD,
            "reasons": tuple(dict.fromkeys(f"{q.name}: {q.reason}" for q in quantities if q.reason)),
        })  # fmt: skip

    def write(self, page: Path) -> None:
        """One HTML file without scripts; it loads the pictures as they come into view."""
        cards = sorted(self.cards, key=lambda card: _ORDER[card["quality"]])
        pages = Environment(loader=PackageLoader("vision.overlay", "."), autoescape=True, trim_blocks=True)
        template = pages.get_template("contact_sheet.html.j2")
        page.write_text(template.render(cards=cards, kinds=(FAILED, DOUBTFUL, GOOD)), encoding="utf8", errors="backslashreplace")
