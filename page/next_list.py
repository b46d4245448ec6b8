"""What to record next as a sheet of paper: plain HTML with boxes to tick, and a button that prints it."""

import html

from page.results import ToRecord


def sheet(bench: str, told: dict[str, list[ToRecord]]) -> str:
    """The whole page; all names escaped."""
    parts = [f"<h2>{html.escape(heading)}</h2><ul>{''.join(map(_item, rows))}</ul>" for heading, rows in told.items()]
    title = f"What to record next: {html.escape(bench)}"
    body = "".join(parts) or "<p>Nothing yet: calibrate or diagnose first.</p>"
    button = '<p><button onclick="print()">Print</button></p>'
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
        '<link rel="stylesheet" href="/static/next.css"></head>'
        f"<body><h1>{title}</h1>{button}{body}</body></html>"
    )


def _item(row: ToRecord) -> str:
    return f"<li><span>{html.escape(row.what)}<small>{html.escape(row.why)}</small></span></li>"
