"""One BLAS thread: our matrices are small, and threads that wait for each other take
1.7 times the processor time."""

import os
from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

CHOSEN_BY = (
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "BLIS_NUM_THREADS",
    "OMP_NUM_THREADS",
)
P = ParamSpec("P")
R = TypeVar("R")


def chosen() -> bool:
    """Whether the user has said how many threads BLAS takes, in the environment."""
    return any(name in os.environ for name in CHOSEN_BY)


def one_thread_for_this_process() -> None:
    """Ask for one thread before BLAS is loaded, unless the user has chosen."""
    if not chosen():
        os.environ["OPENBLAS_NUM_THREADS"] = "1"


def on_one_blas_thread(function: Callable[P, R]) -> Callable[P, R]:
    """The function with BLAS on one thread while it runs, unless the user has chosen;
    afterwards BLAS is as it was."""

    @wraps(function)
    def limited(*args: P.args, **kwargs: P.kwargs) -> R:
        if chosen():
            return function(*args, **kwargs)
        import scipy.linalg  # noqa: F401  # only a library that is loaded is limited
        from threadpoolctl import threadpool_limits

        with threadpool_limits(1, user_api="blas"):
            return function(*args, **kwargs)

    return limited
