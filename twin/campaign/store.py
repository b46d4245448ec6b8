"""The store: DIR/runs/KEY/ holds a recording and what was measured on it. A folder
there is whole; elsewhere it is not there.

    campaign.json            which store this is: workers on other machines check that
                             they see the same
    runs/KEY/                recording.toml, simulation.json, …, measurements.json
    failed/KEY.json          why a job failed
    claims/KEY               locked by who is computing it
    parts/KEY.…/             where it is computed, until it is moved to runs/

measurements.json is what counts and is on the disk (fsync) before the folder is moved;
the other files of a run may be lost to a power cut seconds after it. A run whose
measurements.json cannot be read counts as not there."""

import errno
import json
import math
import os
import shlex
import shutil
import sys
import tempfile
import uuid
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from benchtwin.bench.whole_file import write_whole
from benchtwin.twin.campaign.results import (
    DONE,
    FAILED,
    UNMEASURED,
    Measured,
    Measurement,
    Outcome,
)

MEASUREMENTS = "measurements.json"
FOLDERS = ("runs", "failed", "claims", "parts")
TAKEN = (errno.EEXIST, errno.ENOTEMPTY)


class CampaignStopped(RuntimeError):
    """No job can go on: the store cannot be written, or the workers are gone. What is
    finished is kept."""


@dataclass(frozen=True)
class Store:
    """root: DIR above; id: what campaign.json says."""

    root: Path
    id: str

    @contextmanager
    def claim(self, key: str, *, wait: bool = False) -> Iterator[None]:
        """Held by whoever computes a job, on whatever machine that sees the store; the
        system releases it when the process dies. Where another holds it, it is waited
        for, or `filelock.Timeout` raised at once."""
        file = self.root / "claims" / key
        with FileLock(file, timeout=-1 if wait else 0):
            try:
                yield
            finally:
                file.unlink(missing_ok=True)  # whoever waits for it makes a new one

    def part(self, key: str) -> tempfile.TemporaryDirectory[str]:
        """A new folder in which a job is computed; it goes with the block."""
        return tempfile.TemporaryDirectory(
            prefix=f"{key}.", dir=self.root / "parts", ignore_cleanup_errors=True
        )

    def find(self, keys: Iterable[str]) -> dict[str, Outcome]:
        """What there is of these keys: finished runs, else failures. Two listings, then
        a small file a key."""
        runs, fails = (
            {entry.name for entry in os.scandir(self.root / name)}
            for name in ("runs", "failed")
        )
        found = {}
        for key in dict.fromkeys(keys):
            outcome = self.finished(key) if key in runs else None
            if outcome is None and f"{key}.json" in fails:
                outcome = self.failure(key)
            if outcome is not None:
                found[key] = outcome
        return found

    def finished(self, key: str, *, since_s: float = 0.0) -> Outcome | None:
        """The outcome of a finished run; None when there is none, or it cannot be read,
        or it is an unmeasured one from before `since_s`."""
        folder = f"{self.root}/runs/{key}"
        try:
            with open(f"{folder}/{MEASUREMENTS}", "rb") as file:  # noqa: PTH123  a third of the time of a Path, times 10,000
                told = json.loads(file.read())
            measured = tuple(_measurement(m) for m in told["measurements"])
            truth = {name: _number(value) for name, value in told["truth"].items()}
            reason, notes, seconds = told["reason"], told["notes"], told["seconds"]
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            return None
        if reason and since_s and Path(folder, MEASUREMENTS).stat().st_mtime < since_s:
            return None
        status = UNMEASURED if reason else DONE
        return Outcome(
            key, status, measured, truth, tuple(notes), reason, "", folder, seconds
        )

    def failure(
        self, key: str, *, lasting: bool | None = None, since_s: float = math.inf
    ) -> Outcome | None:
        """The recorded failure of a job; with `lasting` only one that would come again,
        or that came after `since_s`."""
        file = self.root / "failed" / f"{key}.json"
        try:
            told = json.loads(file.read_text(encoding="utf8"))
            counts = (
                lasting is None
                or (lasting and told["lasting"])
                or file.stat().st_mtime >= since_s
            )
            return self._failed(key, told) if counts else None
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def put(
        self, folder: Path, job: Any, measured: Measured, seconds: float, more: dict
    ) -> Outcome:
        """Write measurements.json into the folder that a job was computed in, and move
        it to runs/; what was measured there meanwhile stands."""
        final = self.root / "runs" / job.key
        folder.mkdir(parents=True, exist_ok=True)
        told = {
            "schema": 1,
            "key": job.key,
            "input": job.input,
            "measurements": [_plain(asdict(m)) for m in measured.measurements],
            "truth": _plain(measured.truth),
            "notes": list(measured.notes),
            # where it can be looked at
            "reason": measured.reason.replace(str(folder), str(final)),
            "seconds": round(seconds, 3),
            **more,
        }
        text = json.dumps(told, indent=1, allow_nan=False)
        write_whole(folder / MEASUREMENTS, text)
        try:
            folder.rename(final)
        except OSError as error:
            if error.errno not in TAKEN:
                raise
            standing = self.finished(job.key)
            # torn by a power cut, or measured anew: removed with the part
            if standing is None or standing.status == UNMEASURED:
                final.rename(folder.with_name("before"))
                folder.rename(final)
        (self.root / "failed" / f"{job.key}.json").unlink(missing_ok=True)
        outcome = self.finished(job.key)
        if outcome is None:
            raise OSError(f"{final}: what was written there cannot be read")
        return outcome

    def put_failure(self, key: str, told: dict) -> Outcome:
        """Record why a job failed (reason, lasting, …)."""
        text = json.dumps({"schema": 1, "key": key, **told}, indent=1)
        write_whole(self.root / "failed" / f"{key}.json", text)
        return self._failed(key, told)

    def _failed(self, key: str, told: dict) -> Outcome:
        return Outcome(
            key, FAILED, reason=told["reason"], rerun=rerun_command(self.root, key)
        )

    def now_s(self) -> float:
        """Time by the clock of the drive, to compare with `failure`'s; that of this
        machine may go wrong beside it."""
        with tempfile.TemporaryFile(dir=self.root / "parts") as file:
            return os.fstat(file.fileno()).st_mtime

    def sweep(self) -> None:
        """Remove half-written folders and claims of processes that have died."""
        left = [*(self.root / "parts").iterdir(), *(self.root / "claims").iterdir()]
        for key in {path.name.partition(".")[0] for path in left}:
            with suppress(Timeout), self.claim(key):
                for part in (self.root / "parts").glob(f"{key}.*"):
                    shutil.rmtree(part, ignore_errors=True)


def rerun_command(root: Path, key: str) -> str:
    """The line that runs one failed job alone, in one process."""
    file = root / "failed" / f"{key}.json"
    return shlex.join([sys.executable, "-m", "benchtwin.twin.campaign", str(file)])


def open_store(root: Path, *, id: str | None = None) -> Store:
    """The store in a folder, made when it is not there; OSError when it cannot be.

    id: the store that it must be: FileNotFoundError when another or none is there.
    """
    file = root / "campaign.json"
    if id is None:
        for name in FOLDERS:
            (root / name).mkdir(parents=True, exist_ok=True)
        with FileLock(root / ".campaign.lock"):  # the first of two decides the id
            if not _id_in(file):
                write_whole(file, json.dumps({"schema": 1, "id": uuid.uuid4().hex}))
    found = _id_in(file)
    if not found:
        raise FileNotFoundError(errno.ENOENT, "no campaign store here", str(root))
    if id not in (None, found):
        raise FileNotFoundError(
            errno.ENOENT, "another campaign store is here", str(root)
        )
    return Store(root, found)


def _id_in(file: Path) -> str:
    """What a campaign.json says, "" where it says nothing."""
    try:
        found = json.loads(file.read_text(encoding="utf8"))["id"]
    except (OSError, ValueError, KeyError, TypeError):
        return ""
    return found if isinstance(found, str) else ""


def _plain(told: dict) -> dict:
    """JSON has no NaN: null stands for it."""
    return {
        k: None if v in (math.inf, -math.inf) or v != v else v for k, v in told.items()
    }


def _measurement(told: dict) -> Measurement:
    return Measurement(**told | {n: _number(told[n]) for n in ("value", "sd")})


def _number(value: float | None) -> float:
    return math.nan if value is None else value
