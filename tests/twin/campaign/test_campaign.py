"""Whole campaigns on local worker processes: order, resuming, Ctrl-C, failures."""

import os
import re
import shlex
import signal
import socket
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import psutil
import pytest
from campaign_stand_ins import Square, computed, nothing_half_written, square

import benchtwin
from benchtwin.twin import Parameters
from benchtwin.twin.campaign import (
    CampaignStopped,
    processes,
    read_campaign,
    run_campaign,
    stream_campaign,
)
from benchtwin.twin.campaign.run import threads_each
from benchtwin.twin.job import Job

SCRIPT = """
import faulthandler
import sys
faulthandler.dump_traceback_later(80)  # says where it waits, if it does
from campaign_stand_ins import Square, square
from benchtwin.twin.campaign import stream_campaign
if __name__ == "__main__":
    store, log, count, takes_s = *sys.argv[1:3], int(sys.argv[3]), float(sys.argv[4])
    jobs = [Square(n, log, takes_s) for n in range(count)]
    for outcome in stream_campaign(jobs, store, work=square, **eval(sys.argv[5])):
        print(outcome.key, outcome.status, flush=True)
"""


def campaign_process(
    tmp_path: Path, store: Path, log: Path, count: int, takes_s: float, **options
) -> subprocess.Popen:
    """A campaign in a process group of its own, as a terminal starts it."""
    script = tmp_path / "campaign_script.py"
    script.write_text(SCRIPT)
    line = [
        sys.executable,
        str(script),
        str(store),
        str(log),
        str(count),
        str(takes_s),
        repr(options),
    ]
    env = os.environ | {"PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
    pipe = subprocess.PIPE
    heard = partial(
        signal.signal, signal.SIGINT, signal.SIG_DFL
    )  # tests run in the background inherit that Ctrl-C is ignored
    return subprocess.Popen(
        line,
        stdout=pipe,
        stderr=pipe,
        text=True,
        env=env,
        start_new_session=True,
        preexec_fn=heard,
    )


def test_a_campaign_is_resumed_and_failures_are_named(tmp_path, monkeypatch):
    """One campaign over everything, because workers take seconds to start."""
    log = tmp_path / "log"
    roll = Job("roll", Parameters(), {"roll": {"direction": "+x"}}, rendered=False)
    jobs = [Square(n, str(log)) for n in (5, 3, 4)]
    mixed = [jobs[0], Square(9, trouble="raise"), jobs[1], jobs[2], jobs[1]]
    seen = []
    results = run_campaign(
        mixed, tmp_path / "store", workers=2, progress=seen.append, work=square
    )
    assert list(results.table.status) == ["done", "failed", "done", "done", "done"]
    assert list(results.table.area_mm2.dropna()) == [25.1, 9.1, 16.1, 9.1]
    assert "cannot be squared" in results.failed[0].reason
    assert sorted(computed(log)) == sorted(job.key for job in jobs)
    assert (seen[0].finished, seen[-1].finished, seen[-1].failed, seen[-1].left_s) == (
        0,
        4,
        1,
        0.0,
    )
    dead = tmp_path / "store" / "parts" / f"{mixed[0].key}.of-a-power-cut"
    dead.mkdir()
    monkeypatch.setattr("benchtwin.twin.campaign.run.local", None)  # none is needed
    again = run_campaign(mixed, tmp_path / "store", work=square)
    assert again.table.equals(results.table) and len(computed(log)) == 3
    assert read_campaign([*mixed, roll], tmp_path / "store").counts() == {
        "done": 4,
        "unmeasured": 0,
        "failed": 1,
        "missing": 1,
    }
    assert nothing_half_written(tmp_path / "store")


def listening(process: psutil.Process) -> list:
    """TCP ports that a process and its children listen on."""
    return [
        (p.pid, connection.laddr)
        for p in (process, *process.children(recursive=True))
        for connection in p.net_connections("tcp")
        if connection.status == psutil.CONN_LISTEN
    ]


def test_local_work_opens_no_port_and_leaves_no_process(tmp_path):
    """Whoever reached a port could have the workers run code as this user."""
    me, ports, most = psutil.Process(), [], 0
    before = {p.pid for p in me.children(recursive=True)}
    jobs = [Square(n, takes_s=0.2) for n in range(8)]
    for _ in stream_campaign(jobs, tmp_path / "store", workers=2, work=square):
        ports += listening(me)
        most = max(most, len(me.children(recursive=True)) - len(before))
    assert most >= 2 and ports == []
    with socket.create_server(("127.0.0.1", 0)):  # the control
        assert len(listening(me)) == 1
    left = [p for p in me.children(recursive=True) if p.pid not in before]
    assert not [p for p in left if "spawn_main" in " ".join(p.cmdline())]


def test_nothing_else_of_ours_opens_a_port():
    """But the page, behind its guard; dask is asked for where a scheduler is named."""
    root = Path(benchtwin.__file__).parent
    opening = re.compile(
        r"create_server|\.listen\(|LocalCluster|HTTPServer|(import|from) distributed\b"
    )
    found = {
        str(file.relative_to(root))
        for package in root.iterdir()
        if package.is_dir()
        for file in package.rglob("*.py")
        if opening.search(file.read_text(encoding="utf8"))
    }
    assert found == {"page/command.py", "twin/campaign/processes.py"}


def test_workers_end_with_whoever_started_them(tmp_path):
    """Killed, it can end nobody itself."""
    log = tmp_path / "log"
    process = campaign_process(tmp_path, tmp_path / "store", log, 6, 2.0, workers=2)
    assert process.stdout.readline()
    children = psutil.Process(process.pid).children(recursive=True)
    process.kill()
    process.communicate()
    assert len(children) >= 2 and psutil.wait_procs(children, timeout=10)[1] == []


def test_a_job_whose_worker_dies_goes_to_another_and_is_given_up_at_last(
    tmp_path, monkeypatch
):
    monkeypatch.setattr(processes, "LIVES", 2)
    log = tmp_path / "log"
    jobs = [Square(n, str(log), trouble="kill once" if n == 2 else "") for n in (1, 2)]
    jobs.append(Square(3, str(log), trouble="kill"))
    results = run_campaign(jobs, tmp_path / "store", workers=2, work=square)
    assert list(results.table.status) == ["done", "done", "failed"]
    assert "every worker process that ran it died" in results.failed[0].reason
    assert sorted(computed(log)) == [job.key for job in jobs[:2]]
    assert nothing_half_written(tmp_path / "store")


def test_a_job_of_another_campaign_is_left_to_it_and_taken_when_it_dies(tmp_path):
    store, log = tmp_path / "store", tmp_path / "log"
    other = campaign_process(tmp_path, store, log, 2, 3.0, workers=1)
    assert other.stdout.readline()  # it has done the first job and is at the second
    seen = []

    def watch(progress) -> None:
        seen.append(progress)
        if progress.elsewhere:
            other.kill()

    jobs = [Square(n, str(log)) for n in range(2)]
    results = run_campaign(jobs, store, workers=1, work=square, progress=watch)
    other.communicate()
    assert results.counts()["done"] == 2 and computed(log) == [job.key for job in jobs]
    assert any(p.elsewhere == 1 and p.finished == 1 for p in seen)
    assert nothing_half_written(store)


def test_a_full_disk_stops_the_campaign_and_keeps_what_is_done(tmp_path):
    jobs = [
        Square(1),
        Square(2, takes_s=0.3, trouble="full"),
        *(Square(n, takes_s=0.3) for n in range(3, 40)),
    ]
    with pytest.raises(CampaignStopped, match="No space left on device"):
        run_campaign(jobs, tmp_path / "store", workers=1, work=square)
    assert read_campaign(jobs, tmp_path / "store").counts() == {
        "done": 1,
        "unmeasured": 0,
        "failed": 0,
        "missing": 38,
    }
    assert nothing_half_written(tmp_path / "store")


def test_a_store_that_cannot_be_made_is_refused(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(CampaignStopped, match="cannot be written"):
        run_campaign([Square(1)], tmp_path / "file" / "store")


def test_no_workers_are_refused(tmp_path):
    with pytest.raises(ValueError, match="workers = 0"):
        run_campaign([Square(1)], tmp_path / "store", workers=0)


def test_nothing_is_there_before_anything_has_run(tmp_path):
    assert list(read_campaign([Square(1)], tmp_path / "store").table.status) == [
        "missing"
    ]
    assert not (tmp_path / "store").exists()


@pytest.mark.parametrize(
    ("jobs", "cores", "threads"), [(1, 8, 8), (3, 8, 2), (8, 8, 1), (100, 8, 1)]
)
def test_few_jobs_share_all_cores(jobs, cores, threads):
    assert threads_each(jobs, cores) == threads


def test_no_jobs_need_no_workers(tmp_path):
    assert list(stream_campaign([], tmp_path / "store")) == []


def test_interrupted_and_resumed_has_every_job_once_and_in_order(tmp_path):
    """Ctrl-C reaches the whole process group, as from a terminal."""
    store, log = tmp_path / "store", tmp_path / "log"
    process = campaign_process(tmp_path, store, log, 12, 2.0, workers=2)
    first = [process.stdout.readline() for _ in range(3)]
    children = psutil.Process(process.pid).children(recursive=True)
    os.killpg(process.pid, signal.SIGINT)
    begin = time.monotonic()
    _, errors = process.communicate(timeout=120)
    assert time.monotonic() - begin < 60  # a busy machine; it takes about a second
    assert all(first) and process.returncode != 0
    assert errors.rstrip().splitlines()[-1] == "KeyboardInterrupt", errors
    assert "Process SpawnProcess" not in errors, errors  # no worker's own traceback
    assert psutil.wait_procs(children, timeout=60)[1] == []
    assert nothing_half_written(store)
    jobs = [Square(n, str(log)) for n in range(12)]
    left = read_campaign(jobs, store).counts()
    assert left["missing"] > 0 and left["done"] >= 3
    resumed = run_campaign(jobs, store, workers=1, work=square)
    assert resumed.counts()["done"] == 12
    assert [o.measurements[0].value for o in resumed.outcomes] == [
        n**2 + 0.1 for n in range(12)
    ]
    assert sorted(set(computed(log))) == sorted(job.key for job in jobs)


@pytest.mark.slow
def test_interrupted_physics_equals_uninterrupted(tmp_path):
    jobs = [
        Job(
            "roll",
            Parameters(),
            {"roll": {"direction": "+x"}},
            rng=(1, n),
            rendered=False,
        )
        for n in range(6)
    ]
    stream = stream_campaign(jobs, tmp_path / "store", workers=2)
    next(stream)
    stream.close()
    assert nothing_half_written(tmp_path / "store")
    resumed, whole = (
        run_campaign(jobs, tmp_path / "store", workers=1),
        run_campaign(jobs, tmp_path / "other", workers=2),
    )
    assert resumed.counts()["done"] == 6
    assert [o.measurements for o in resumed.outcomes] == [
        o.measurements for o in whole.outcomes
    ]


@pytest.mark.usefixtures("rigs_compiled")
def test_the_command_runs_a_failed_job_of_the_twin_alone(tmp_path):
    far = Job(
        "drop", Parameters(), {"camera": {"target_mm": [500.0, 0.0, 0.0]}}
    )  # looks past the seed
    good = Job("roll", Parameters(), {"roll": {"direction": "+x"}}, rendered=False)
    results = run_campaign([far, good], tmp_path / "store", workers=1)
    assert results.counts()["done"] == 1 and results.outcomes[1].measurements
    (failed,) = results.failed
    assert failed.reason.startswith("ValueError: the camera does not see the seed")
    again = subprocess.run(
        shlex.split(failed.rerun), capture_output=True, text=True, check=False
    )
    assert (
        again.returncode == 1
        and "ValueError: the camera does not see the seed" in again.stderr
    )


def test_rerunning_nothing_says_how(capsys):
    from benchtwin.twin.campaign.__main__ import main

    assert main([]) == 2 and "DIR/failed/KEY.json" in capsys.readouterr().err
