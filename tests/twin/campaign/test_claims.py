"""Claims: one owner at a time, and what dead owners left is free."""

import signal
import subprocess
import sys
import threading

import pytest
from filelock import Timeout

from benchtwin.twin.campaign.store import open_store

HOLD = """
import sys, time
from pathlib import Path
from benchtwin.twin.campaign.store import open_store
store = open_store(Path(sys.argv[1]))
with store.claim("k"), store.part("k") as part:
    print(part, flush=True)
    time.sleep(60)
"""


def is_claimed(store, key: str) -> bool:
    try:
        with store.claim(key):
            return False
    except Timeout:
        return True


@pytest.fixture
def store(tmp_path):
    return open_store(tmp_path / "store")


@pytest.fixture
def holder(store):
    process = subprocess.Popen(
        [sys.executable, "-c", HOLD, str(store.root)], stdout=subprocess.PIPE
    )
    assert process.stdout.readline()
    yield process
    process.kill()
    process.communicate()


def test_one_of_many_gets_it(store):
    got, ready, done = [], threading.Barrier(16), threading.Barrier(16)

    def ask() -> None:
        ready.wait()
        try:
            with store.claim("k"):
                got.append(1)
                done.wait()
        except Timeout:
            done.wait()

    threads = [threading.Thread(target=ask) for _ in range(16)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(got) == 1


def test_what_is_released_can_be_claimed_again_and_other_keys_are_free(store):
    with store.claim("k"), store.claim("kk"):
        assert is_claimed(store, "k") and is_claimed(store, "kk")
        assert not is_claimed(store, "other")
    assert not is_claimed(store, "k") and list((store.root / "claims").iterdir()) == []


def test_a_live_owner_keeps_its_job_and_its_folder(store, holder):
    store.sweep()
    assert is_claimed(store, "k") and list((store.root / "parts").iterdir())


def test_what_a_dead_owner_left_is_free_even_unburied(store, holder):
    holder.send_signal(signal.SIGKILL)  # a zombie now: nobody has waited for it
    holder.stdout.read()  # until it has ended
    assert not is_claimed(store, "k") and list((store.root / "parts").iterdir())
    store.sweep()
    assert list((store.root / "parts").iterdir()) == []
    assert list((store.root / "claims").iterdir()) == []


def test_who_waits_gets_it_when_the_owner_dies(store, holder):
    threading.Timer(0.5, holder.kill).start()
    with store.claim("k", wait=True):
        assert holder.wait(10) == -signal.SIGKILL


@pytest.mark.parametrize("owner", ["", "null", '{"pid": 1}', "\0"])
def test_a_forged_claim_holds_nothing_up(store, owner):
    """Only who holds the lock computes; what a file says is nothing."""
    (store.root / "claims" / "k").write_text(owner)
    assert not is_claimed(store, "k")
