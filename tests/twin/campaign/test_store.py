"""The store: whole or not at all, the same numbers back, and quick to look up."""

import contextlib
import json
import math
import threading
import time
from pathlib import Path

import pytest
from campaign_stand_ins import Square, nothing_half_written, square

from benchtwin.twin.campaign import Measured, Measurement
from benchtwin.twin.campaign.store import open_store


@pytest.fixture
def store(tmp_path):
    return open_store(tmp_path / "store")


def put(store, job, measured=None):
    with store.claim(job.key), store.part(job.key) as part:
        done = square(job, Path(part) / job.key, 1)
        folder = Path(part) / job.key
        return store.put(folder, job, measured or done, 1.25, {"kept": "all"})


def test_numbers_come_back_bit_for_bit(store):
    measured = Measured(
        (
            Measurement("a", 0.1 + 0.2, 1e-300, "mm"),
            Measurement("b", math.nan, math.inf, "1", "failed", "why"),
        )
    )
    put(store, Square(3), measured)
    a, b = store.finished(Square(3).key).measurements
    assert (a.value, a.sd) == (0.1 + 0.2, 1e-300)
    assert (
        math.isnan(b.value)
        and math.isnan(b.sd)
        and (b.quality, b.reason) == ("failed", "why")
    )


def test_a_run_is_never_seen_in_part(store):
    """A reader that looks all the time sees all of its files or none."""
    seen, over = [], threading.Event()
    final = store.root / "runs" / Square(3).key

    def look() -> None:
        while not over.is_set():
            with contextlib.suppress(FileNotFoundError):
                seen.append(len(list(final.iterdir())))

    with store.part(Square(3).key) as part:
        folder = Path(part) / Square(3).key
        folder.mkdir()
        for n in range(500):
            (folder / f"{n}.png").touch()
        reader = threading.Thread(target=look)
        reader.start()
        store.put(folder, Square(3), Measured(), 1.0, {})
    time.sleep(0.05)
    over.set()
    reader.join()
    assert set(seen) == {501}


def test_the_first_of_two_stands(store):
    job = Square(3)
    put(store, job, Measured((Measurement("a", 1.0, 0.1, "mm"),)))
    second = put(store, job, Measured((Measurement("a", 2.0, 0.1, "mm"),)))
    assert second.measurements[0].value == 1.0


def test_a_torn_run_counts_as_not_there_and_is_replaced(store):
    job = Square(3)
    put(store, job)
    (store.root / "runs" / job.key / "measurements.json").write_text(
        '{"schema": 1, "meas'
    )
    assert store.finished(job.key) is None and store.find([job.key]) == {}
    assert put(store, job).status == "done"
    store.sweep()
    assert nothing_half_written(store.root)


def test_what_could_not_be_measured_is_found_unless_it_is_to_be_done_again(store):
    job = Square(3)
    assert put(store, job, Measured(reason="no bounce")).status == "unmeasured"
    assert store.finished(job.key).reason == "no bounce"
    assert store.finished(job.key, since_s=time.time() + 60) is None
    assert put(store, job).status == "done"


def test_a_success_takes_back_the_failure(store):
    job = Square(3)
    store.put_failure(job.key, {"reason": "r", "lasting": True})
    assert store.find([job.key])[job.key].reason == "r"
    put(store, job)
    assert store.find([job.key])[job.key].status == "done" and not list(
        (store.root / "failed").iterdir()
    )


def test_another_store_is_refused(store, tmp_path):
    assert open_store(store.root, id=store.id) == store == open_store(store.root)
    with pytest.raises(FileNotFoundError, match="another campaign store"):
        open_store(store.root, id="0" * 32)
    with pytest.raises(FileNotFoundError, match="no campaign store"):
        open_store(tmp_path, id=store.id)


def test_ten_thousand_finished_jobs_are_looked_up_in_two_seconds(store):
    keys = [f"{n:016x}" for n in range(10_000)]
    number = {
        "name": "a",
        "value": 1.0,
        "sd": 0.1,
        "unit": "mm",
        "quality": "good",
        "reason": "",
    }
    told = {
        "measurements": [number] * 4,
        "truth": {"a": 1.0},
        "notes": [],
        "reason": "",
        "seconds": 1.0,
    }
    text = json.dumps(told)
    for key in keys:
        (store.root / "runs" / key).mkdir()
        (store.root / "runs" / key / "measurements.json").write_text(text)
    begin = time.process_time()  # a busy machine is not the lookup's fault
    found = store.find(keys)
    assert time.process_time() - begin < 2.0
    assert len(found) == 10_000
