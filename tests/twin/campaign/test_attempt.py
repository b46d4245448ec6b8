"""One job in a worker: done once, failing alone, and the disk's trouble told apart from
the job's."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from campaign_stand_ins import Square, computed, nothing_half_written, square

from benchtwin.twin.campaign import Measured
from benchtwin.twin.campaign.attempt import Order, Reply
from benchtwin.twin.campaign.attempt import attempt as attempt_as
from benchtwin.twin.campaign.store import open_store


def attempt(order: Order, job) -> Reply:
    return attempt_as(order, job, job.key)


@pytest.fixture
def order(tmp_path):
    store = open_store(tmp_path / "store")
    return Order(
        str(store.root),
        store.id,
        square,
        1,
        store.now_s(),
    )


def later(order: Order, **changes) -> Order:
    """The order of a campaign begun after everything so far."""
    return replace(order, since_s=order.since_s + 3600, **changes)


def test_a_job_is_computed_once(order, tmp_path):
    job = Square(3, str(tmp_path / "log"))
    first, second = attempt(order, job), attempt(order, job)
    assert first.outcome == second.outcome and (first.computed, second.computed) == (
        True,
        False,
    )
    assert computed(tmp_path / "log") == [job.key]
    assert nothing_half_written(Path(order.root))


def test_a_job_that_another_process_has_is_left_to_it(order):
    with open_store(Path(order.root)).claim(Square(3).key):
        assert attempt(order, Square(3)).busy
    assert attempt(order, Square(3)).outcome.status == "done"


@pytest.mark.parametrize(
    ("trouble", "reason"),
    [
        ("raise", "RuntimeError: number 3 cannot be squared"),
        ("nan", "ValueError: area = nan"),
    ],
)
def test_a_failing_job_is_named_and_stays_failed(order, trouble, reason):
    job = Square(3, trouble=trouble)
    outcome = attempt(order, job).outcome
    assert outcome.status == "failed" and outcome.reason.startswith(reason)
    assert outcome.rerun.endswith(
        f"-m benchtwin.twin.campaign {order.root}/failed/{job.key}.json"
    )
    told = json.loads((Path(order.root) / "failed" / f"{job.key}.json").read_text())
    assert (
        told["input"] == job.input
        and ("in square" if trouble == "raise" else "_check_numbers")
        in told["traceback"]
    )
    assert nothing_half_written(Path(order.root))
    assert not attempt(later(order), Square(3)).computed
    assert attempt(later(order, alone=True), Square(3)).outcome.status == "done"


def test_a_failure_of_the_machine_is_tried_again_by_the_next_campaign(order):
    assert (
        attempt(order, Square(3, trouble="memory")).outcome.reason
        == "MemoryError: no room"
    )
    assert (
        attempt(order, Square(3)).outcome.status == "failed"
    )  # not twice in one campaign
    assert attempt(later(order), Square(3)).outcome.status == "done"


def test_a_full_disk_is_no_failure_of_the_job(order):
    reply = attempt(order, Square(3, trouble="full"))
    assert reply.outcome is None and "No space left on device" in reply.stop
    assert nothing_half_written(Path(order.root)) and not list(
        (Path(order.root) / "failed").iterdir()
    )


def test_wherever_the_disk_ends_nothing_is_left_half_written(order):
    """Files of a process may not exceed a limit [bytes]: the claim, measurements.json
    or the evidence is what does not fit."""
    code = f"""
import resource, sys
sys.path[:0] = {sys.path!r}
from pathlib import Path
from campaign_stand_ins import Square, nothing_half_written, square
from benchtwin.twin.campaign.attempt import Order, attempt
order = Order({order.root!r}, {order.id!r}, square, "photos", 1, {order.since_s}, False)
_, most = resource.getrlimit(resource.RLIMIT_FSIZE)
for n, limit in enumerate((0, 100, 300, 5000)):
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, most))
    job = Square(n, trouble="" if limit == 300 else "large")
    assert "File too large" in attempt(order, job, job.key).stop, limit
    assert nothing_half_written(Path(order.root)), limit
"""
    subprocess.run([sys.executable, "-c", code], check=True)
    assert not [
        *(Path(order.root) / "runs").iterdir(),
        *(Path(order.root) / "failed").iterdir(),
    ]


def test_reasons_name_the_folder_that_stays(order):
    def dark(job, folder, threads):
        folder.mkdir()
        return Measured(reason=f"{folder}/photo.png: too dark")

    reason = attempt(replace(order, work=dark), Square(3)).outcome.reason
    assert reason == f"{order.root}/runs/{Square(3).key}/photo.png: too dark"


def test_an_unwritable_store_stops(order, monkeypatch):
    def refuse(path, *args, **kwargs):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(os, "open", refuse)
    assert "Permission denied" in attempt(order, Square(3)).stop


def test_a_worker_that_does_not_see_the_store_stops(order, tmp_path):
    assert (
        "no campaign store here"
        in attempt(replace(order, root=str(tmp_path / "elsewhere")), Square(3)).stop
    )


def test_a_worker_of_another_version_stops(order):
    """Its key of the same job is another: what it computes would be stored for a job
    that it is not."""
    reply = attempt_as(order, Square(3), Square(4).key)
    assert "another version of benchtwin" in reply.stop and not list(
        (Path(order.root) / "runs").iterdir()
    )


@pytest.mark.parametrize(
    ("alone", "left"), [(False, {"photo.png"}), (True, {"photo.png", "frames"})]
)
def test_frames_go_but_of_a_job_that_is_run_alone(order, alone, left):
    def filmed(job, folder, threads, reason=""):
        (folder / "frames").mkdir(parents=True)
        (folder / "frames" / "000000.png").touch()
        (folder / "photo.png").touch()
        return Measured(reason=reason)

    attempt(replace(order, work=filmed, alone=alone), Square(3))
    run = Path(order.root) / "runs" / Square(3).key
    assert {p.name for p in run.iterdir()} == left | {"measurements.json"}
    dark = replace(order, work=lambda *a: filmed(*a, reason="dark"), alone=alone)
    attempt(dark, Square(4))
    assert (
        Path(order.root) / "runs" / Square(4).key / "frames"
    ).is_dir()  # what could not be measured can be looked at
