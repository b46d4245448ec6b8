"""Writes the table in docs/seeds.md: every published property of seeds that the package
holds, with its source.

python scripts/seeds_reference.py
"""

import argparse
import tomllib
from pathlib import Path

from benchtwin.bench.seed_kinds import FILE

OUT = Path(__file__).parent.parent / "docs" / "seeds.md"
START = "<!-- written by scripts/seeds_reference.py -->"
NAMES = {
    "length_mm": "length, mm",
    "width_mm": "width, mm",
    "thickness_mm": "thickness, mm",
    "density_kg_m3": "density, kg/m³",
    "restitution": "restitution",
    "static_friction": "static friction",
    "rolling_friction": "rolling friction",
}


def reference() -> str:
    """The tables as Markdown: one a kind, and the sources."""
    table = tomllib.loads(FILE.read_text(encoding="utf8"))
    numbers = {key: n for n, key in enumerate(table["sources"], 1)}
    parts = [START]
    for kind, rows in table["kinds"].items():
        parts += [f"### {kind.capitalize()}", ""]
        parts += [
            "| | value | moisture, or how it was found | source |",
            "|---|---|---|---|",
        ]
        for row in rows:
            what = NAMES[row["quantity"]] + (f" on {row['on']}" if "on" in row else "")
            value = (
                f"{row['low']:g}"
                if row["low"] == row["high"]
                else f"{row['low']:g} to {row['high']:g}"
            )
            parts.append(
                f"| {what} | {value} | {row.get('moisture', '')} |"
                f" [{numbers[row['source']]}](#sources) |"
            )
        parts.append("")
    parts += ["### Sources", ""]
    parts += [f"{n}. {table['sources'][key]}" for key, n in numbers.items()]
    return "\n".join(parts) + "\n"


def page() -> str:
    """docs/seeds.md with its tables written anew, its text kept."""
    return OUT.read_text(encoding="utf8").split(START)[0] + reference()


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    OUT.write_text(page(), encoding="utf8")
