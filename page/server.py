"""The application: plain routes for files and pictures, pages for people, all behind
the guard."""

import math
import re
import secrets
import shutil
from pathlib import Path
from urllib.parse import quote

from fastapi import FastAPI, Request, Response
from fastapi.responses import (
    FileResponse,
    HTMLResponse,
    JSONResponse,
    PlainTextResponse,
)
from fastapi.staticfiles import StaticFiles

from benchtwin.bench.language import tr
from benchtwin.page import pictures
from benchtwin.page.downloads import card_files, packed_bench, sheet, zipped
from benchtwin.page.folder import MARK, RESULTS, Folder, Refused
from benchtwin.page.guard import Entrance, Guard
from benchtwin.page.results import next_recordings
from benchtwin.page.site import Site
from benchtwin.page.sound_impacts import waveform
from benchtwin.page.upload import Placed, ReceivedFile, check, place_files
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.motion.drop_sound import sound_of

SERVED = {
    ".html": "text/html",
    ".png": "image/png",
    ".csv": "text/csv",
    ".json": "application/json",
    ".txt": "text/plain",
    ".mp4": "video/mp4",
    ".md": "text/plain",
}
BATCH = re.compile("[0-9a-f-]{36}")  # a name that the browser draws
CHECKED_EVERY = 50_000_000  # bytes of a file that comes
# a report draws its figures itself, and reaches nothing of the page
SCRIPTS = (
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'"
    " 'unsafe-eval'; style-src 'unsafe-inline'; img-src data: blob:; font-src data:"
)
# a contact sheet loads pictures that lie beside it
NO_SCRIPTS = (
    "sandbox allow-same-origin; default-src 'none'; style-src 'unsafe-inline';"
    " img-src 'self' data:"
)


def application(folder: Folder, port: int, entrance: Entrance, incoming: Path) -> Guard:
    """The whole server for one folder; incoming: where files are on their way."""
    from nicegui import ui

    from benchtwin.page.views import pages

    site = Site(folder)
    app = FastAPI(openapi_url=None, docs_url=None, redoc_url=None)
    for kind in (Refused, MeasurementError, OSError):
        app.exception_handler(kind)(_refused)
    app.mount("/static", StaticFiles(directory=Path(__file__).parent / "static"))
    _files(app, site, incoming)
    _pictures(app, site)
    pages(site)
    ui.run_with(
        app,
        title="benchtwin",
        dark=None,
        reconnect_timeout=60.0,
        show_welcome_message=False,
    )
    return Guard(app, port, entrance)


async def _refused(_: Request, error: Exception) -> Response:
    return PlainTextResponse(str(error), status_code=422)


def _files(app: FastAPI, site: Site, incoming: Path) -> None:
    folder = site.folder

    @app.put("/upload/{batch}")
    async def upload(batch: str, name: str, request: Request) -> Response:
        if not BATCH.fullmatch(batch):
            raise Refused(tr("this batch has no proper name"))
        wrong = name.startswith("/") or {"\0", "\\"} & {*name} or len(name) > 1000
        if wrong or ".." in name.split("/"):
            raise Refused(tr("{!r} is not a name for a file here", name[:80]))
        check(name, int(request.headers.get("content-length", 0)), folder)
        place = incoming / batch
        place.mkdir(exist_ok=True)
        file = place / secrets.token_hex(8)
        try:
            await _receive(request, file, name, folder)
        except BaseException as error:  # refused, or the copy was cut off
            file.unlink(missing_ok=True)
            if not isinstance(error, OSError):
                raise
            raise Refused(
                tr("{}: cannot be written: {}", name, error.strerror)
            ) from error
        site.batches.setdefault(batch, []).append(ReceivedFile(name, file))
        return Response(status_code=204)

    @app.post("/sort/{batch}")
    def sort(batch: str, bench: str) -> Response:
        try:
            arrived = site.batches.pop(batch, [])
            placed = place_files(arrived, folder.inside(bench))
        except (Refused, OSError) as error:
            placed = Placed([], [str(error)])
        finally:
            if BATCH.fullmatch(batch):
                shutil.rmtree(incoming / batch, ignore_errors=True)
        made = [folder.name_of(p) for p in placed.made]
        where = f"/recording?r={quote(made[0])}" if len(made) == 1 else None
        return JSONResponse({"refused": placed.refused, "open": where, "made": made})

    @app.get("/results/{name:path}")
    def result_file(name: str) -> Response:
        path = folder.inside(name)
        within = [p for p in path.parents if p.is_relative_to(folder.root.resolve())]
        if (
            not path.is_file()
            or path.suffix not in SERVED
            or not any((p / MARK).is_file() for p in within)
        ):
            raise Refused(tr("{}: not among the results here", name))
        headers = {"cache-control": "no-cache"}
        if path.suffix == ".html":
            headers["content-security-policy"] = (
                SCRIPTS if path.name == "report.html" else NO_SCRIPTS
            )
        return FileResponse(path, media_type=SERVED[path.suffix], headers=headers)

    def results(bench: str) -> tuple[Path, Path]:
        """A bench's folder, and that of its results."""
        path = folder.inside(bench)
        folder.refuse_links(path / RESULTS)
        return path, path / RESULTS

    @app.get("/zip")
    def packed(bench: str) -> Response:
        path = folder.inside(bench)
        file, name = packed_bench(path, incoming), f"{path.name}.zip"
        return FileResponse(file, filename=name, media_type="application/zip")

    @app.get("/cards")
    def engine_cards(bench: str, engine: str) -> Response:
        path, found = results(bench)
        name = quote(f"{path.name}-{engine}.zip")
        headers = {"content-disposition": f"attachment; filename*=utf-8''{name}"}
        data = zipped(card_files(found, engine))
        return Response(data, media_type="application/zip", headers=headers)

    @app.get("/next")
    def to_record(bench: str) -> Response:
        path, found = results(bench)
        return HTMLResponse(sheet(path.name, next_recordings(found)))


async def _receive(request: Request, file: Path, name: str, folder: Folder) -> None:
    """Stream the body into the file; what the header promised is checked again on what
    comes."""
    size = 0
    with file.open("xb") as out:
        async for chunk in request.stream():
            before = size // CHECKED_EVERY
            size += len(chunk)
            if size // CHECKED_EVERY > before:
                check(name, size, folder)
            out.write(chunk)
    check(name, size, folder)
    if not size:
        raise Refused(tr("{}: the file is empty (0 bytes)", name))


def _pictures(app: FastAPI, site: Site) -> None:
    folder = site.folder

    def jpeg(data: bytes, version: str = "") -> Response:
        # without a version another recording may have the name when it is asked again
        kept = "max-age=3600" if version else "no-cache"
        headers = {"cache-control": f"private, {kept}"}
        return Response(data, media_type="image/jpeg", headers=headers)

    @app.get("/thumb")
    def thumb(r: str, v: str = "") -> Response:
        data = pictures.thumbnail(site.recording(r))
        return jpeg(data, v) if data else Response(status_code=404)

    @app.get("/photo")
    def whole(r: str, v: str = "") -> Response:
        file = site.recording(r).files[0]
        image = pictures.photo(file, file.stat().st_mtime_ns)
        return jpeg(pictures.as_jpeg(image)[0], v)

    @app.get("/frame")
    def frame(r: str, i: int, v: str = "") -> Response:
        return jpeg(site.film(r).frame(i), v)

    @app.get("/wave")
    def wave(r: str, a: float, b: float, n: int) -> Response:
        sound, _ = site.sound(site.recording(r))
        if not (math.isfinite(a) and math.isfinite(b) and a < b):
            raise Refused(tr("{:g} to {:g} s is no stretch of a sound", a, b))
        return JSONResponse(waveform(sound, a, b, n))

    @app.get("/sound")
    def heard(r: str) -> Response:
        file = sound_of(site.recording(r))
        if file is None:
            raise Refused(tr("{} has no sound", r))
        if not file.stat().st_size:
            raise Refused(tr("{}: the file is empty (0 bytes)", file.name))
        # a link out of the folder is refused
        return FileResponse(folder.inside(folder.name_of(file)))

    @app.get("/overlay")
    def overlay(r: str, name: str) -> Response:
        found = site.observation(site.recording(r))
        if name not in found.pictures:
            raise Refused(tr("{}: no such picture", name))
        return jpeg(pictures.as_jpeg(found.pictures[name])[0])
