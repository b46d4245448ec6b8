"""Writes docs/keys.md: every key of recording.toml and bench.toml, from the models that
read them.

python scripts/keys_reference.py
"""

import argparse
from pathlib import Path

from benchtwin.bench.rigs import RIGS
from benchtwin.page.form import Field, form

OUT = Path(__file__).parent.parent / "docs" / "keys.md"
HEAD = """# All keys of recording.toml and bench.toml

`bench.toml` states what holds for every recording, `recording.toml` what holds for \
one. A key that is absent is unknown.
The unit stands at the end of a key's name.
This page is written by `scripts/keys_reference.py` from the code that reads the files.
"""
CONDITIONS = """## [conditions]

Whatever differs between recordings: numbers with the unit at the end of the name, \
or words.
"""


def reference() -> str:
    """The page as Markdown: a table a section."""
    sections = {section.name: section for rig in RIGS for section in form(rig, {}, {})}
    parts = [HEAD]
    for name, section in sections.items():
        parts += [
            f"## [{name}]\n" if name else "## At the top of the file\n",
            f"{section.help}\n" if section.help else "",
        ]
        rows = [
            f"| `{field.key}` | {_values(field)} | {field.help} |"
            for field in section.fields
            if field.kind != "conditions"
        ]
        parts.append(
            "\n".join(["| key | values | meaning |", "|---|---|---|", *rows, ""])
        )
    return "\n".join(part for part in [*parts, CONDITIONS] if part)


def _values(field: Field) -> str:
    """What may stand there, in words."""
    kind = {
        "choice": ", ".join(f'"{word}"' for word in field.choices),
        "yes": "true or false",
        "rows": "rows of numbers",
    }.get(field.kind, field.kind)
    return f"{kind}, {field.bounds}" if field.bounds else kind


if __name__ == "__main__":
    argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    ).parse_args()
    OUT.write_text(reference(), encoding="utf8")
