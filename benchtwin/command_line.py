"""The command line: its commands, and what is set up before one runs."""

import inspect
import io
import os
import signal
import sys
import tempfile
import threading
import traceback
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Annotated, Any

import typer

from benchtwin import recording_commands as recordings
from benchtwin import simulation_commands as simulations
from benchtwin.bench.exits import DONE, FAILED, MISUSED, Misuse, say
from benchtwin.bench.language import speak
from benchtwin.bench.outlets import plain
from benchtwin.bench.terminal import gated
from benchtwin.bench.whole_file import own_folder
from benchtwin.blas import one_thread_for_this_process
from benchtwin.options import said

Errors = tuple[type[Exception], ...]

REQUIRED = inspect.Parameter.empty
MISUSES: Errors = (FileNotFoundError, FileExistsError, Misuse)
FAILURES: Errors = (ValueError, RuntimeError)
GOES_ON = "the same command goes on where it stopped ({out})"
NOTHING = "nothing was written"
app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
COMMANDS: dict[str, Callable[..., None]] = {}  # in the order of the help


def _spoken(language: str | None) -> None:
    if language is not None:
        try:
            speak(language)
        except ValueError as error:
            raise typer.BadParameter(str(error)) from error


LANGUAGE = inspect.Parameter(
    "language",
    inspect.Parameter.KEYWORD_ONLY,
    default=None,
    annotation=Annotated[
        str | None,
        said(
            "Of reports, page and messages: en, or zh (中文).",
            callback=_spoken,
            is_eager=True,
        ),
    ],
)


def exit_code(
    verb: str,
    out: object,
    work: Callable[[], int],
    *,
    stopped: str = GOES_ON,
    misuses: Errors = MISUSES,
    failures: Errors = FAILURES,
) -> int:
    """The exit code of `work`; an error that it raises is printed in one line, one of
    the system's with its file.

    misuses, failures: errors of what was typed, and of what came of it; others are
    faults of ours."""

    def words(error: Exception) -> object:
        if isinstance(error, OSError) and error.strerror:
            return f"{error.filename or out}: {error.strerror}"
        return error

    wrong: Errors = (*failures, OSError)
    try:
        return work()
    except KeyboardInterrupt:
        return say(verb, f"stopped; {stopped.format(out=out)}", FAILED)
    except misuses as error:
        return say(verb, words(error), MISUSED)
    except wrong as error:
        return say(verb, words(error), FAILED)


def _add(
    name: str,
    function: Callable[..., Any],
    *,
    stopped: str = GOES_ON,
    misuses: Errors | Callable[[], Errors] = MISUSES,
    failures: Errors = FAILURES,
    **defaults: object,
) -> None:
    """Make a function a command: its options are those of the signature, its help the
    docstring up to a form feed; what it returns is printed, an error becomes a line.

    stopped: said of what an interrupt leaves; misuses, failures: as `exit_code` has
    them; defaults: of options, where the command line has others than Python."""
    signature = inspect.signature(function)

    @wraps(function)
    def command(language: str | None = None, **options: Any) -> None:
        def work() -> int:
            found = function(**options)
            if found is None or isinstance(found, int):
                return found or DONE
            return int(found.tell(quiet=not options.get("progress", True)))

        out = options.get("out") or next(iter(options.values()))
        wrong = misuses if isinstance(misuses, tuple) else misuses()
        raise typer.Exit(
            exit_code(
                name, out, work, stopped=stopped, misuses=wrong, failures=failures
            )
        )

    parameters = [
        *(
            p.replace(default=defaults.get(p.name, p.default))
            for p in signature.parameters.values()
        ),
        LANGUAGE,
    ]
    command.__signature__ = signature.replace(  # type: ignore[attr-defined]
        parameters=parameters, return_annotation=None
    )
    command.__annotations__ = {p.name: p.annotation for p in parameters}
    COMMANDS[name] = app.command(name)(command)


def _unreadable() -> Errors:
    from benchtwin.vision.measurement import MeasurementError  # takes its time to load

    return (MeasurementError, OSError)


# the command says what was typed wrongly; any other error is a fault of ours
ITSELF: Any = {"stopped": NOTHING, "failures": ()}

_add(
    "measure",
    recordings.measure,
    out=REQUIRED,
    window_pct="20-80",
    misuses=_unreadable,
    **ITSELF,
)
_add("import", recordings.import_, misuses=_unreadable, **ITSELF)
_add("board", recordings.board, misuses=_unreadable, **ITSELF)
_add("shape", recordings.shape, misuses=_unreadable, **ITSELF)
_add("clump", recordings.clump, **ITSELF)
_add("simulate", simulations.simulate_and_measure, misuses=(ValueError, OSError))
_add("calibrate", simulations.calibrate, out=REQUIRED)
_add("predict", simulations.predict, misuses=(*MISUSES, ValueError))
_add("compare-engines", simulations.compare, misuses=(ValueError, FileExistsError))
_add(
    "diagnose",
    simulations.diagnose,
    out=REQUIRED,
    stopped="no diagnosis was written to {out}",
    failures=(),
)
_add("seeds", recordings.seeds, misuses=(ValueError,))
_add("export", simulations.export, misuses=(*MISUSES, ValueError))
_add("pdf", recordings.pdf, stopped=NOTHING, misuses=(Misuse,))
_add("pack", recordings.pack, stopped=NOTHING)
_add("unpack", recordings.unpack, stopped=NOTHING)
_add("prove", simulations.prove, **ITSELF)
_add("new", recordings.new, misuses=_unreadable)
_add("page", recordings.page, **ITSELF)


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
    # a tenth of compiling is colouring messages that nobody sees
    os.environ.setdefault("NUMBA_DISABLE_ERROR_MESSAGE_HIGHLIGHTING", "1")
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
