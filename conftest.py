"""Tests compute on one BLAS thread each (matrices are small, and threads that wait for
each other cost four times the time), and what numba compiles is compiled by one worker
only."""

import os
import signal
import tempfile
from pathlib import Path

import pytest

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# a tenth of compiling is colouring messages of overloads that do not fit
os.environ.setdefault("NUMBA_DISABLE_ERROR_MESSAGE_HIGHLIGHTING", "1")
# what a test starts runs this checkout, wherever benchtwin is installed from
os.environ["PYTHONPATH"] = str(Path(__file__).parent)


def pytest_configure(config):
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        # a shell lets what it starts in the background ignore interrupts, which tests
        # send to themselves and to what they start
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if hasattr(config, "workerinput") and os.name == "posix":
        locks = Path(tempfile.gettempdir()) / f"benchtwin-test-locks-{os.getuid()}"
        locks.mkdir(mode=0o700, exist_ok=True)
        compile_in_one_worker(locks)


def compile_in_one_worker(locks: Path) -> None:
    """One worker compiles a function that numba keeps on disk; the others wait and load
    it. A step loop takes half a minute, and every worker needs it."""
    import fcntl

    from numba.core.caching import NullCache
    from numba.core.compiler_lock import global_compiler_lock
    from numba.core.dispatcher import Dispatcher

    compile_now = Dispatcher.compile

    def compile_alone(self, signature):
        if isinstance(self._cache, NullCache):
            return compile_now(self, signature)
        name = f"{self.py_func.__module__}.{self.py_func.__qualname__}"
        with global_compiler_lock, (locks / name).open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            return compile_now(self, signature)

    Dispatcher.compile = compile_alone


@pytest.fixture(scope="session")
def rigs_compiled():
    """The rigs' step loop is on disk: processes that a test starts load it."""
    import numpy as np

    from benchtwin.sim.rigs.bench import Bench
    from benchtwin.sim.rigs.drop import Drop, run_drop

    run_drop(Drop(height_m=1e-3), Bench(), np.random.default_rng(0))
