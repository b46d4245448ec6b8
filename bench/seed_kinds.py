"""Published properties of seeds and grains by kind (`[seed] kind`), each with its
source."""

import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from benchtwin.bench.language import tr

FILE = Path(__file__).with_suffix(".toml")
SIZES, DENSITY = ("length_mm", "width_mm", "thickness_mm"), "density_kg_m3"


@dataclass(frozen=True)
class Published:
    """One published range. quantity: key of [seed], or restitution, static_friction,
    rolling_friction; on: the other surface, "itself" for seed on seed, "" for
    properties of the seed; moisture: as the source states it, or how the value was
    determined."""

    quantity: str
    low: float
    high: float
    source: str
    on: str = ""
    moisture: str = ""

    def __str__(self) -> str:
        if self.low == self.high:
            value = f"{self.low:g}"
        else:
            value = f"{self.low:g} to {self.high:g}"
        of = f"{self.quantity} on {self.on}" if self.on else self.quantity
        return (
            f"{of}: {value}"
            f" ({f'{self.moisture}; ' if self.moisture else ''}{self.source})"
        )


@cache
def kinds() -> dict[str, tuple[Published, ...]]:
    """All kinds with their published ranges, from seed_kinds.toml."""
    table = tomllib.loads(FILE.read_text(encoding="utf8"))
    return {
        kind: tuple(
            Published(**{**row, "source": table["sources"][row["source"]]})
            for row in rows
        )
        for kind, rows in table["kinds"].items()
    }


def known(kind: str) -> str:
    """The kind itself; ValueError with the list of kinds where it is not in the
    table."""
    if kind not in kinds():
        raise ValueError(
            tr(
                "kind = {!r}: must be one of {} (benchtwin seeds shows them)",
                kind,
                ", ".join(kinds()),
            )
        )
    return kind


def with_published_values(section: dict) -> tuple[dict, list[str]]:
    """A [seed] table with absent sizes and density as published for its kind, and a
    note for each such value. Sizes are taken together, and only where no size, lot or
    shape is stated; the density only where neither it nor the mass is. A value is the
    middle of the first published range, which is of means over varieties and moisture,
    not of single seeds."""
    kind = section.get("kind")
    if kind is None:
        return section, []
    first: dict[str, Published] = {}
    for entry in kinds()[known(kind)]:
        if not entry.on:
            first.setdefault(entry.quantity, entry)
    wanted: tuple[str, ...] = ()
    if all(name in first for name in SIZES) and not any(
        section.get(name) for name in (*SIZES, "lot", "shape")
    ):
        wanted += SIZES
    if DENSITY in first and not any(section.get(name) for name in (DENSITY, "mass_g")):
        wanted += (DENSITY,)
    found = {
        name: float(f"{(first[name].low + first[name].high) / 2:.4g}")
        for name in wanted
    }
    notes = [
        tr(
            "[seed] {} = {:g}: not stated, taken as published for {}, {}",
            name,
            value,
            kind,
            first[name],
        )
        for name, value in found.items()
    ]
    return {**section, **found}, notes


def published_contact_parameters(kind: str) -> list[str]:
    """A line for each published contact parameter of the kind, to compare a calibration
    with."""
    return [
        tr("published for {}: {}", kind, entry)
        for entry in kinds()[known(kind)]
        if entry.on
    ]
