"""`benchtwin page`: finds a free port, prints an address, opens the browser."""

import secrets
import socket
import threading
import webbrowser
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from benchtwin.bench.exits import Misuse
from benchtwin.bench.language import tr
from benchtwin.bench.whole_file import folder_beside
from benchtwin.page.folder import INCOMING, Folder
from benchtwin.page.guard import Entrance, forwarding
from benchtwin.page.private import private_folder
from benchtwin.page.server import application

LOOPBACK = "127.0.0.1"
ANSWERS_AFTER_S = 0.8  # the server is up by then
OPENS_WITHIN_S = 60.0  # a browser that has not by then is not awaited any more


def page(folder: Path, port: int, browser: bool) -> None:
    """Serve the page on `folder` until Ctrl+C. port 0: a free one. Misuse where folder
    or port cannot be used."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        listener = socket.create_server((LOOPBACK, port))
    except OSError as error:
        where = tr("port {}", port) if folder.is_dir() else str(folder)
        raise Misuse(f"{where}: {error.strerror or error}") from error
    try:
        private_folder()
    except (OSError, RuntimeError) as error:
        raise Misuse(
            tr(
                "no folder for its own keys: {}. Set XDG_STATE_HOME to a folder that"
                " you may write to",
                error,
            )
        ) from error
    entrance = Entrance()
    site = f"http://{entrance.host}:{listener.getsockname()[1]}/"

    def tell(words: str) -> None:
        """Print an address; when it has been used, the next one."""
        key = entrance.new_key(lambda: tell(tr("For another browser:")))
        with suppress(OSError):  # the terminal was closed
            print(f"{words}  {site}?token={key}", flush=True)

    print(tr("benchtwin page on {}", folder.resolve()))
    tell(tr("Open in a browser (only on this machine, once):"))
    print(tr("A browser that does not find it: {} in the place of its name.", LOOPBACK))
    print(tr("Ctrl+C ends it."), flush=True)
    with suppress(KeyboardInterrupt):
        serve(folder, listener, entrance, site if browser else "")


def serve(
    folder: Path, listener: socket.socket, entrance: Entrance, opened: str
) -> None:
    """Serve until interrupted; opened: the address that the browser opens once the
    server answers, "" for none."""
    import uvicorn

    # beside those of other pages on this folder; what a killed one left is removed
    with folder_beside(folder.resolve() / INCOMING / "page") as incoming:
        port = listener.getsockname()[1]
        config = uvicorn.Config(
            application(Folder(folder.resolve()), port, entrance, incoming),
            log_level="error",
            timeout_graceful_shutdown=1,
        )
        remove = open_browser(incoming, entrance, opened) if opened else None
        try:
            uvicorn.Server(config).run(sockets=[listener])
        finally:
            if remove:
                remove()
    with suppress(OSError):  # of another page
        incoming.parent.rmdir()


def open_browser(incoming: Path, entrance: Entrance, site: str) -> Callable[[], None]:
    """Open the page by a file that only this user can read, for command lines can be
    read by all. It lies in the folder that is open, for browsers in a sandbox see no
    hidden folder of the user's; on a drive that knows no owners, in the private one. It
    is removed when it was used, or after OPENS_WITHIN_S; returns what removes it."""
    ours_alone = not incoming.stat().st_mode & 0o077
    place = incoming if ours_alone else private_folder()
    file = place / f"open-{secrets.token_hex(8)}.html"

    def remove() -> None:
        entrance.void(key)
        file.unlink(missing_ok=True)

    key = entrance.new_key(remove)
    file.write_text(forwarding(f"{site}?token={key}"), encoding="utf8")
    for after_s, what in (
        (ANSWERS_AFTER_S, lambda: webbrowser.open(file.as_uri())),
        (OPENS_WITHIN_S, remove),
    ):
        timer = threading.Timer(after_s, what)
        timer.daemon = True
        timer.start()
    return remove
