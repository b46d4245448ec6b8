"""Compiling the engine's kernels for one set of laws, and keeping the machine code
where the user can write.

A kernel is a template: an ordinary function whose module names (`friction`, `rolling`,
…) stand for laws. `specialise` gives a copy its own laws and compiles it. Its name
carries a fingerprint of every source that goes into it, so that numba's cache on disk
never hands out code made from an older law: numba itself looks only at the file of the
outermost function."""

import dis
import hashlib
import inspect
import os
import tempfile
import threading
import types
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import numba

from benchtwin.bench.whole_file import own_folder
from benchtwin.sim.engine.numba_pipeline import QuickCompiler
from benchtwin.sim.engine.view import View

# Of fastmath only "contract", a·b + c rounded once: sums are not reordered, which would
# make a force depend on how a loop was cut into vectors. error_model numpy drops the
# division checks, which keep loops from becoming vectors. Without _nrt numba counts
# references to every array that it slices or hands on, by locked instructions: 90 % of
# a one-seed run was spent on that. The price is that a kernel cannot allocate: scratch
# is handed in.
OPTIONS: dict[str, Any] = {
    "fastmath": {"contract"},
    "error_model": "numpy",
    "nogil": True,
    "boundscheck": False,
    "_nrt": False,
    "pipeline_class": QuickCompiler,
    "no_cfunc_wrapper": True,
}
ALLOCATING: dict[str, Any] = {**OPTIONS, "_nrt": True}
# of a part of a kernel, which only compiled code calls
INNER: dict[str, Any] = {**OPTIONS, "no_cpython_wrapper": True}


ONE_AT_A_TIME = threading.Lock()  # numba's setting is one for all threads


@cache
def cache_folder() -> Path:
    """Where compiled kernels are kept: $NUMBA_CACHE_DIR, else the user's cache folder,
    else a folder of the user's in /tmp."""
    asked, user = os.environ.get("NUMBA_CACHE_DIR"), getattr(os, "getuid", lambda: 0)()
    choices = [Path(asked)] if asked else []
    with suppress(RuntimeError):  # nobody's home
        release = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
        choices += [Path(release).expanduser() / "benchtwin" / "kernels"]
    shared = Path(tempfile.gettempdir()) / f"benchtwin-kernels-{user}"
    for folder in (*choices, shared):
        try:
            if folder == shared:  # compiled code is not taken from another's folder
                own_folder(folder)
            folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            with tempfile.TemporaryFile(dir=folder):
                return folder
        except OSError:
            continue
    raise RuntimeError(
        "no folder to keep compiled kernels in: cannot write to"
        f" {', '.join(map(str, (*choices, shared)))}; set NUMBA_CACHE_DIR"
    )


@cache
def fingerprint_of_sources() -> str:
    """Of every file of the engine, of the contact law that is always there, and of
    numba's version."""
    digest = hashlib.sha256(numba.__version__.encode())
    here = Path(__file__).parent
    for file in (*sorted(here.glob("*.py")), here.parent / "laws" / "hertz_mindlin.py"):
        digest.update(file.name.encode() + file.read_bytes())
    return digest.hexdigest()


def fingerprint(*parts: object) -> str:
    """Short hash of what a specialised kernel is made from; a function counts with its
    source and its name."""
    digest = hashlib.sha256(fingerprint_of_sources().encode())
    for part in parts:
        digest.update(
            (inspect.getsource(part) if callable(part) else repr(part)).encode() + b"\0"
        )
    return digest.hexdigest()[:16]


def bind(template: Callable, names: dict[str, object]) -> Callable:
    """A copy of `template` that sees `names` in place of its module's own, and in the
    place of each plain function that it calls the same of that, compiled as a part."""
    seen = {**template.__globals__, **names}
    for line in dis.get_instructions(template):
        part = seen.get(line.argval) if line.opname == "LOAD_GLOBAL" else None
        if isinstance(part, types.FunctionType):
            seen[line.argval] = inner(part, **names)
    made = types.FunctionType(
        template.__code__, seen, template.__name__, template.__defaults__
    )
    made.__module__ = template.__module__
    return made


@cache  # what two call is compiled once
def inner(template: Callable, **names: object) -> Callable:
    """`template` with `names` bound, compiled as a part of a kernel (kept on disk only
    inside that kernel). One that takes the View becomes a part of it before its types
    are inferred: to hand on 400 numbers takes half of a kernel's time to compile."""
    whole = View in template.__annotations__.values()
    how = {"inline": "always"} if whole else {"forceinline": True}
    return numba.njit(**how, **INNER)(bind(template, names))


def kernel(
    template: Callable, mark: str, options: dict = OPTIONS, **names: object
) -> Callable:
    """`template` with `names` bound, compiled and kept on disk under its name and
    `mark` (see `fingerprint`)."""
    made = bind(template, names)
    made.__qualname__ = f"{template.__name__}_{mark}"
    with ONE_AT_A_TIME:
        before = numba.config.CACHE_DIR
        # read while the dispatcher is made
        numba.config.CACHE_DIR = str(cache_folder())
        try:
            return numba.njit(cache=True, **options)(made)
        finally:
            numba.config.CACHE_DIR = before


def is_kept(name: str, mark: str) -> bool:
    """Whether a kernel of that template and mark has been compiled and kept before."""
    return any(cache_folder().rglob(f"*{name}_{mark}*.nbi"))
