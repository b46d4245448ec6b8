"""A scheduler and workers as processes of their own, joined over TCP; one of them
dies."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest
from campaign_stand_ins import Square, computed, nothing_half_written, square
from test_campaign import campaign_process

from benchtwin.twin.campaign import (
    CampaignStopped,
    processes,
    read_campaign,
    run_campaign,
    stream_campaign,
)

DASK = Path(sys.executable).parent / "dask"


def started(*words: str) -> subprocess.Popen:
    env = os.environ | {"PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
    quiet = subprocess.DEVNULL
    return subprocess.Popen([str(DASK), *words], stdout=quiet, stderr=quiet, env=env)


def worker(address: str, folder: Path) -> subprocess.Popen:
    """Without a nanny: when it is killed, nobody starts another."""
    options = (
        "--nthreads",
        "1",
        "--no-nanny",
        "--no-dashboard",
        "--local-directory",
        str(folder),
    )
    return started("worker", address, *options)


@pytest.fixture
def scheduler(tmp_path):
    file = tmp_path / "scheduler.json"
    process = started(
        "scheduler",
        "--host",
        "127.0.0.1",
        "--port",
        "0",
        "--scheduler-file",
        str(file),
        "--no-dashboard",
    )
    until = time.monotonic() + 30
    address = ""
    while not address and time.monotonic() < until:
        time.sleep(0.05)
        if file.exists() and file.read_text():
            address = json.loads(file.read_text())["address"]
    yield address
    process.kill()
    process.wait()


@pytest.fixture
def workers(scheduler, tmp_path):
    processes = [worker(scheduler, tmp_path / f"worker-{n}") for n in range(2)]
    yield processes
    for process in processes:
        process.kill()
        process.wait()


@pytest.mark.slow
def test_a_killed_worker_costs_nothing_and_two_campaigns_share_one_store(
    scheduler, workers, tmp_path
):
    """Job 2 kills its worker half-way, the first time; then two clients run the same
    jobs at once, one on workers of its own."""
    log, store = tmp_path / "log", tmp_path / "store"
    jobs = [Square(n, str(log), 0.05, "kill once" if n == 2 else "") for n in range(12)]
    results = run_campaign(jobs, store, scheduler=scheduler, work=square)
    assert results.counts()["done"] == 12
    assert [o.measurements[0].value for o in results.outcomes] == [
        n**2 + 0.1 for n in range(12)
    ]
    assert [process.poll() is None for process in workers].count(
        True
    ) == 1  # one was killed indeed
    assert sorted(computed(log)) == sorted(job.key for job in jobs)
    assert nothing_half_written(store)

    log, store = tmp_path / "log-2", tmp_path / "store-2"
    clients = [
        campaign_process(tmp_path, store, log, 30, 0.2, scheduler=scheduler),
        campaign_process(tmp_path, store, log, 30, 0.2, workers=2),
    ]
    told = [
        client.communicate(timeout=120) for client in clients
    ]  # they take seconds; a busy machine
    assert [client.returncode for client in clients] == [0, 0], told
    for out, _ in told:
        assert sorted(out.split()[::2]) == [f"{n:016x}" for n in range(30)] and set(
            out.split()[1::2]
        ) == {"done"}
    assert sorted(computed(log)) == [f"{n:016x}" for n in range(30)]
    assert read_campaign([Square(n) for n in range(30)], store).counts()["done"] == 30
    assert nothing_half_written(store)


def test_a_scheduler_without_workers_is_said_to_have_none(
    scheduler, tmp_path, monkeypatch
):
    monkeypatch.setattr(processes, "PATIENCE_S", 0.5)
    with pytest.raises(CampaignStopped, match=f"dask worker {scheduler}"):
        run_campaign([Square(1)], tmp_path / "store", scheduler=scheduler, work=square)


def test_a_scheduler_that_goes_ends_the_campaign_with_a_sentence(
    scheduler, workers, tmp_path
):
    jobs = [Square(n, takes_s=0.5) for n in range(40)]
    with pytest.raises(CampaignStopped, match="is gone; what is finished is kept"):
        for _ in stream_campaign(
            jobs, tmp_path / "store", scheduler=scheduler, work=square
        ):
            for process in psutil.process_iter(["cmdline"]):
                if str(tmp_path / "scheduler.json") in (process.info["cmdline"] or ()):
                    process.kill()
    assert read_campaign(jobs, tmp_path / "store").counts()["done"] >= 1


def test_a_scheduler_that_is_not_there_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(processes, "PATIENCE_S", 0.5)
    with pytest.raises(CampaignStopped, match=r"tcp://127\.0\.0\.1:9: does not answer"):
        run_campaign(
            [Square(1)], tmp_path / "store", scheduler="tcp://127.0.0.1:9", work=square
        )
