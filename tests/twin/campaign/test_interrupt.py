"""Ctrl-C reaches the program even where Python drops it."""

import gc
import signal
import threading

import pytest

from benchtwin.twin.campaign.interrupt import kept_interrupt


class Dropping:
    """Pressed Ctrl-C while it is destroyed: Python would print a KeyboardInterrupt and
    go on."""

    def __del__(self):
        signal.raise_signal(signal.SIGINT)


@pytest.mark.filterwarnings("error::pytest.PytestUnraisableExceptionWarning")
def test_an_interrupt_in_a_destructor_is_raised_at_the_next_check_alone():
    with kept_interrupt() as check:
        check()  # nothing was pressed
        Dropping()
        gc.collect()
        with pytest.raises(KeyboardInterrupt):
            check()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_an_interrupt_is_raised_at_once_elsewhere():
    with pytest.raises(KeyboardInterrupt), kept_interrupt():
        signal.raise_signal(signal.SIGINT)


def test_another_handler_and_another_thread_are_left_alone():
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with kept_interrupt() as check:
            assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
            check()
    finally:
        signal.signal(signal.SIGINT, before)
    seen = []
    thread = threading.Thread(target=lambda: seen.append(kept_interrupt().__enter__()))
    thread.start()
    thread.join()
    assert (
        len(seen) == 1 and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    )
