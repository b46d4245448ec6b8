"""What several threads need inside one compiled loop: an atomic counter and a barrier.

numba has no atomics for the CPU, so they are written in LLVM's terms here. The loop
runs with the GIL released; every thread calls `barrier` between the phases of a step.
Which thread does which block is left to chance (`take`); what a block computes is not.
"""

import ctypes

from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic

SPINS = 2000  # about 10 µs of waiting before giving the core away


@intrinsic
def add_and_fetch(typingctx, array, index, amount):
    """Atomically array[index] += amount; returns the value before."""
    signature = types.int64(array, types.intp, types.int64)

    def codegen(context, builder, sig, args):
        holder = context.make_array(sig.args[0])(context, builder, args[0])
        pointer = cgutils.get_item_pointer(
            context, builder, sig.args[0], holder, [args[1]], wraparound=False
        )
        return builder.atomic_rmw("add", pointer, args[2], "seq_cst")

    return signature, codegen


@intrinsic
def load(typingctx, array, index):
    """array[index], read afresh from memory."""
    signature = types.int64(array, types.intp)

    def codegen(context, builder, sig, args):
        holder = context.make_array(sig.args[0])(context, builder, args[0])
        pointer = cgutils.get_item_pointer(
            context, builder, sig.args[0], holder, [args[1]], wraparound=False
        )
        return builder.load_atomic(pointer, "seq_cst", 8)

    return signature, codegen


def _has_yield() -> bool:
    try:
        return hasattr(ctypes.CDLL(None), "sched_yield")
    except (OSError, TypeError):  # Windows: a thread that waits keeps its core
        return False


HAS_YIELD = _has_yield()
_sched_yield = types.ExternalFunction("sched_yield", types.int32())


@njit(nogil=True)
def rest():
    """Let another thread have the core, where the system can."""
    if HAS_YIELD:
        _sched_yield()


@njit(nogil=True)
def barrier(counters, threads):
    """Wait until all threads are here. counters[0] counts arrivals, counters[1] the
    barriers passed."""
    if threads == 1:
        return
    passed = load(counters, 1)
    if add_and_fetch(counters, 0, 1) == threads - 1:
        add_and_fetch(counters, 0, -threads)
        add_and_fetch(counters, 1, 1)
        return
    spins = 0
    while load(counters, 1) == passed:
        spins += 1
        if spins > SPINS:
            rest()


@njit(nogil=True)
def take(counters, slot, threads, serial_next):
    """The next block to work on: from the shared counter, or simply `serial_next` when
    there is one thread."""
    if threads == 1:
        return serial_next
    return add_and_fetch(counters, slot, 1)
