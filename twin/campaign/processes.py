"""Worker processes of this user on this machine. They speak through pipes: no port is
open, and nobody else can hand them work."""

import os
import signal
import threading
from collections.abc import Callable
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from multiprocessing import get_context, parent_process
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any

LIVES = 4  # processes that one job may cost before it is given up


class WorkerDied(RuntimeError):
    """Every process that a job was given to has died."""


class Processes(Executor):
    """So many processes, each with a thread here that hands it one job after the other.
    A job whose process dies begins again in another."""

    def __init__(self, count: int) -> None:
        self.count = count
        self._threads = ThreadPoolExecutor(count, "campaign")
        self._mine = threading.local()  # each thread's pipe
        self._started: list[BaseProcess] = []
        self._starting = threading.Lock()
        self._closed = False

    def submit(
        self, work: Callable[..., Any], /, *args: Any, **kwargs: Any
    ) -> Future[Any]:
        """Have `work`, importable by its name, called in one of the processes."""
        return self._threads.submit(self._done, work, args, kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = True) -> None:
        """End the processes at once, whatever they are doing."""
        self._threads.shutdown(wait=False, cancel_futures=cancel_futures)
        with self._starting:
            self._closed = True
        for process in self._started:
            process.kill()
        for process in self._started if wait else ():
            process.join()

    def _done(self, *work: Any) -> Any:
        for _ in range(LIVES):
            try:
                pipe = self._pipe()
                pipe.send(work)
                came, answer = pipe.recv()
            except (EOFError, BrokenPipeError, ConnectionResetError):
                self._mine.pipe = None
                continue
            if not came:
                raise answer
            return answer
        raise WorkerDied(
            "every worker process that ran it died (memory, or a crash in compiled"
            " code)"
        )

    def _pipe(self) -> Connection:
        """The pipe to this thread's process, which is started if need be."""
        if getattr(self._mine, "pipe", None) is None:
            spawn = get_context("spawn")
            ours, theirs = spawn.Pipe()
            with self._starting:
                if self._closed:
                    raise WorkerDied("the campaign has ended")
                # Ctrl-C in a terminal reaches the whole group; until it is ready the
                # process would answer with a traceback of its own
                signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
                process = spawn.Process(target=_serve, args=(theirs,), daemon=True)
                process.start()
                self._started.append(process)
            theirs.close()
            self._mine.pipe = ours
        return self._mine.pipe


def _serve(pipe: Connection) -> None:
    """A worker's life: jobs in, answers out, until who started it is gone."""
    import scipy.linalg  # noqa: F401  # only a library that is loaded is limited
    from threadpoolctl import threadpool_limits

    signal.signal(signal.SIGINT, lambda *_: None)  # unlike SIG_IGN, not handed on
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    threading.Thread(target=_end_with_parent, daemon=True).start()
    with threadpool_limits(1, user_api="blas"):
        while True:
            try:
                work, args, kwargs = pipe.recv()
                answer = True, work(*args, **kwargs)
            except EOFError:
                return
            except Exception as error:
                answer = False, RuntimeError(f"{type(error).__name__}: {error}")
            pipe.send(answer)


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
