"""The command line: its commands, and what is set up before one runs."""

import io
import os
import signal
import sys
import tempfile
import threading
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from benchtwin import recording_commands as recordings
from benchtwin import simulation_commands as simulations
from benchtwin.bench.outlets import plain
from benchtwin.bench.terminal import gated
from benchtwin.bench.whole_file import own_folder
from benchtwin.blas import one_thread_for_this_process
from benchtwin.options import said

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
COMMANDS: dict[str, Callable[..., None]] = {  # in the order of the help
    "measure": recordings.measure,
    "import": recordings.import_,
    "board": recordings.board,
    "shape": recordings.shape,
    "clump": recordings.clump,
    "simulate": simulations.simulate,
    "calibrate": simulations.calibrate,
    "predict": simulations.predict,
    "compare-engines": simulations.compare_engines,
    "diagnose": simulations.diagnose,
    "seeds": recordings.seeds,
    "export": simulations.export,
    "pdf": recordings.pdf,
    "pack": recordings.pack,
    "unpack": recordings.unpack,
    "prove": simulations.prove,
    "new": recordings.new,
    "page": recordings.page,
}
for name, command in COMMANDS.items():
    app.command(name)(command)


def _version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        typer.echo(f"benchtwin {version('benchtwin')}")
        raise typer.Exit


@app.callback()
def benchtwin(
    version: Annotated[
        bool, said("Print the version.", "--version", callback=_version, is_eager=True)
    ] = False,
) -> None:
    """DEM contact parameters for seeds and grains, from what you film at the bench."""


def _keep_compiled_code() -> None:
    """Numba keeps what it compiled beside the source or in the user's cache; where it
    may write to neither, in /tmp."""
    try:
        cache = Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache").expanduser()
        cache.mkdir(parents=True, exist_ok=True)
        if os.access(Path(__file__).parent, os.W_OK) or os.access(cache, os.W_OK):
            return
    except (OSError, RuntimeError):  # no home at all
        pass
    user = getattr(os, "getuid", lambda: 0)()
    folder = Path(tempfile.gettempdir()) / f"benchtwin-kernels-{user}"
    try:
        own_folder(folder)
    except OSError:  # compiled code is not taken from another's folder
        folder = Path(tempfile.mkdtemp(prefix="benchtwin-kernels-"))
    os.environ.setdefault("NUMBA_CACHE_DIR", str(folder))


def _run_nothing_from_here() -> None:
    """The folder that somebody stands in may be a bench that was sent: no process of
    ours imports from it, and numba loads no compiled code that a .numba_config.yaml in
    it points to."""
    os.environ.setdefault("PYTHONSAFEPATH", "1")
    os.environ.setdefault("NUMBA_CACHE_DIR", "")  # the default, stated


def main() -> None:
    """The command line. A fault of ours ends it with one line and exit code 1;
    BENCHTWIN_TRACEBACK=1 shows where it arose."""
    if threading.current_thread() is threading.main_thread():
        # asked to end, what is half-written is removed as after Ctrl-C
        signal.signal(signal.SIGTERM, signal.default_int_handler)
    one_thread_for_this_process()
    _keep_compiled_code()
    _run_nothing_from_here()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal that has no "±" shows "?"
    with gated():
        _run()


def _run() -> None:
    try:
        app()
    except Exception as error:
        if os.environ.get("BENCHTWIN_TRACEBACK"):
            raise
        place = traceback.extract_tb(error.__traceback__)[-1]
        where = f"{Path(place.filename).name}:{place.lineno}"
        fault = (
            f"benchtwin: a fault of benchtwin, please report it: {error!r} in {where}"
            " (BENCHTWIN_TRACEBACK=1 shows more)"
        )
        sys.exit(plain(fault))
