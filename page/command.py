"""`benchtwin page`: finds a free port, prints the address, opens the browser."""

import socket
import sys
import threading
import webbrowser
from pathlib import Path

from benchtwin.page.folder import Folder
from benchtwin.page.guard import new_token
from benchtwin.page.server import application

STOPPED, MISUSED = 0, 2
LOOPBACK = "127.0.0.1"


def page_command(folder: Path, port: int, browser: bool) -> int:
    """Serve the page on `folder` until Ctrl+C; returns the exit code. port 0: a free
    one."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        listener = socket.create_server((LOOPBACK, port))
    except OSError as error:
        where = (
            folder
            if isinstance(error, FileExistsError | PermissionError)
            and not folder.is_dir()
            else f"port {port}"
        )
        print(f"benchtwin page: {where}: {error.strerror or error}", file=sys.stderr)
        return MISUSED
    port, token = listener.getsockname()[1], new_token()
    address = f"http://{LOOPBACK}:{port}/?token={token}"
    print(
        f"benchtwin page on {folder.resolve()}\nOpen in a browser (only on this"
        f" machine):  {address}\nCtrl+C ends it.",
        flush=True,
    )
    serve(folder, listener, token, address if browser else "")
    return STOPPED


def serve(folder: Path, listener: socket.socket, token: str, address: str) -> None:
    """Serve until interrupted; address: opened in the browser once the server answers,
    "" for none."""
    import uvicorn

    port = listener.getsockname()[1]
    config = uvicorn.Config(
        application(Folder(folder.resolve()), port, token),
        log_level="error",
        timeout_graceful_shutdown=1,
    )
    server = uvicorn.Server(config)
    if address:
        threading.Timer(0.8, webbrowser.open, [address]).start()
    server.run(sockets=[listener])
