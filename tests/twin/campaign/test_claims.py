"""Claims: one owner at a time, and dead owners' claims taken over."""

import json
import os
import signal
import subprocess
import sys
import threading
import time

import psutil
import pytest

from benchtwin.twin.campaign import claims


def claimed_by(
    folder, *, pid: int, started: float, machine: str | None = None, key: str = "k"
) -> None:
    owner = {
        "token": "t",
        "machine": machine or claims._machine(),
        "host": "h",
        "pid": pid,
        "started": started,
    }
    (folder / f"{key}.0").write_text(json.dumps(owner))


@pytest.fixture
def sleeper():
    process = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
    yield process
    process.kill()
    process.wait()


def test_one_of_many_gets_it(tmp_path):
    got, ready = [], threading.Barrier(16)

    def ask() -> None:
        ready.wait()
        got.append(claims.take(tmp_path, "k"))

    threads = [threading.Thread(target=ask) for _ in range(16)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sum(claim is not None for claim in got) == 1


def test_what_is_released_can_be_claimed_again(tmp_path):
    claims.take(tmp_path, "k").release()
    assert list(tmp_path.iterdir()) == []
    assert claims.take(tmp_path, "k") is not None


def test_other_keys_are_free(tmp_path):
    assert (
        claims.take(tmp_path, "k")
        and claims.take(tmp_path, "kk")
        and claims.take(tmp_path, "K")
    )


def test_a_live_owner_keeps_it(tmp_path, sleeper):
    claimed_by(
        tmp_path, pid=sleeper.pid, started=psutil.Process(sleeper.pid).create_time()
    )
    assert claims.holder(tmp_path, "k")
    assert claims.take(tmp_path, "k") is None


def test_a_dead_owner_loses_it_even_unburied(tmp_path, sleeper):
    claimed_by(
        tmp_path, pid=sleeper.pid, started=psutil.Process(sleeper.pid).create_time()
    )
    os.kill(sleeper.pid, signal.SIGKILL)  # a zombie now: nobody has waited for it
    until = time.monotonic() + 10
    while claims.holder(tmp_path, "k") and time.monotonic() < until:
        time.sleep(0.01)
    assert claims.take(tmp_path, "k").number == 1


def test_another_process_with_the_number_of_the_owner_is_not_the_owner(tmp_path):
    claimed_by(tmp_path, pid=os.getpid(), started=psutil.Process().create_time() - 3600)
    assert claims.take(tmp_path, "k") is not None


def test_an_owner_elsewhere_is_judged_by_its_heartbeat(tmp_path):
    claimed_by(tmp_path, pid=1, started=0.0, machine="another")
    assert claims.take(tmp_path, "k") is None
    before = time.time() - 2 * claims.STALE_S
    os.utime(tmp_path / "k.0", (before, before))
    assert claims.take(tmp_path, "k").number == 1


def test_of_many_takers_of_a_dead_claim_at_most_one_gets_it(tmp_path):
    for attempt in range(20):
        key = f"k{attempt}"
        claimed_by(tmp_path, pid=os.getpid(), started=0.0, key=key)
        got, ready = [], threading.Barrier(8)

        def ask(key=key, got=got, ready=ready) -> None:
            ready.wait()
            got.append(claims.take(tmp_path, key))
            claims.remove_dead(tmp_path)  # clearing away must not let a second one in

        threads = [threading.Thread(target=ask) for _ in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert sum(claim is not None for claim in got) <= 1


def test_the_heart_beats(tmp_path):
    claim = claims.take(tmp_path, "k")
    os.utime(claim.file, (0, 0))
    with claims.beating(claim, every_s=0.01):
        until = time.monotonic() + 10
        while claim.file.stat().st_mtime == 0 and time.monotonic() < until:
            time.sleep(0.01)
    assert claim.file.stat().st_mtime > time.time() - 60


def test_an_outnumbered_claim_is_no_longer_valid(tmp_path):
    mine = claims.take(tmp_path, "k")
    assert mine.is_valid()
    os.utime(mine.file, (0, 0))
    theirs = claims.take(tmp_path, "k")
    assert theirs.is_valid() and not mine.is_valid()
    mine.release()
    assert theirs.is_valid()


def test_dead_claims_are_removed_and_live_ones_are_not(tmp_path):
    mine = claims.take(tmp_path, "live")
    claimed_by(tmp_path, pid=os.getpid(), started=0.0, key="dead")
    claims.remove_dead(tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == ["live.0"]
    assert claims.live_tokens(tmp_path) == {mine.token}
