"""What the page hands out as files: a bench as one zip, cards for other engines, a
printable list of what to record next."""

import html
import io
import os
import secrets
import zipfile
from contextlib import suppress
from pathlib import Path

from benchtwin.bench.language import spoken, tr
from benchtwin.calibrate.export import ENGINES, cards, read_result
from benchtwin.page.folder import CALIBRATED, RESULTS, Refused
from benchtwin.page.results import ToRecord, read
from benchtwin.vision.recording import RESULTS_MARK

MOST_AT_ONCE = 4  # older packages are thrown away
SHEET = """<!doctype html><html lang="{language}"><head><meta charset="utf-8">
<title>{title}</title><link rel="stylesheet" href="/static/next.css"></head>
<body><h1>{title}</h1><p><button onclick="print()">{print}</button></p>{body}</body>
</html>"""


def packed_bench(bench: Path, place: Path) -> Path:
    """The zip file, in the folder `place`: all but links and hidden files, and the
    cards of what is calibrated. Refused, in words, where it cannot be written."""
    for old in sorted(place.glob("zip-*"), key=lambda p: p.stat().st_mtime)[
        :-MOST_AT_ONCE
    ]:
        old.unlink(missing_ok=True)
    out = place / f"zip-{secrets.token_hex(8)}"
    try:
        with zipfile.ZipFile(
            out, "w", zipfile.ZIP_DEFLATED, compresslevel=1, strict_timestamps=False
        ) as pack:
            _pack(bench, pack)
    except OSError as error:
        out.unlink(missing_ok=True)
        raise Refused(tr("the zip cannot be written: {}", error.strerror)) from error
    return out


def _pack(bench: Path, pack: zipfile.ZipFile) -> None:
    for at, folders, files in os.walk(bench):
        inside = Path(at).relative_to(bench)
        folders[:] = sorted(f for f in folders if not f.startswith("."))
        for name in sorted(files):
            path = Path(at) / name
            hidden = name.startswith(".") and name != RESULTS_MARK
            if path.is_file() and not path.is_symlink() and not hidden:
                pack.write(path, Path(bench.name) / inside / name)
    result = bench / RESULTS / CALIBRATED / "result.json"
    for engine in ENGINES if result.is_file() and not result.is_symlink() else ():
        with suppress(Refused):  # a result that lacks a parameter has no cards
            for name, text in card_files(bench / RESULTS, engine).items():
                where = f"{RESULTS}/{CALIBRATED}/export/{engine}/{name}"
                pack.writestr(f"{bench.name}/{where}", text)


def card_files(results: Path, engine: str) -> dict[str, str]:
    """An engine's cards of the last calibration, text by file name; Refused, in words,
    where there is none."""
    result = results / CALIBRATED / "result.json"
    if not result.is_file():
        raise Refused(tr("nothing is calibrated yet: no cards"))
    with read(result):
        try:
            return cards(read_result(results / CALIBRATED), engine)
        except (ValueError, OSError) as error:
            raise Refused(str(error).replace(f"{results / CALIBRATED}/", "")) from error


def zipped(files: dict[str, str]) -> bytes:
    """Texts by file name as one compressed ZIP archive."""
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w", zipfile.ZIP_DEFLATED) as pack:
        for name, text in files.items():
            pack.writestr(name, text)
    return data.getvalue()


def sheet(bench: str, to_record: dict[str, list[ToRecord]]) -> str:
    """The printable page of what to record next; all names escaped."""
    parts = [
        f"<h2>{html.escape(tr(heading))}</h2><ul>{''.join(map(_item, rows))}</ul>"
        for heading, rows in to_record.items()
    ]
    title = tr("What to record next: {}", html.escape(bench))
    body = "".join(parts) or (
        f"<p>{tr('Nothing yet: calibrate or diagnose first.')}</p>"
    )
    return SHEET.format(
        title=title, body=body, language=spoken(), print=html.escape(tr("Print"))
    )


def _item(row: ToRecord) -> str:
    what, why = html.escape(row.what), html.escape(row.why)
    return f"<li><span>{what}<small>{why}</small></span></li>"
