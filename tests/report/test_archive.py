"""`benchtwin pack` and `unpack`: everything that was there comes back byte for byte,
nothing of the machine goes along, what has changed is named, every refusal is a
sentence."""

import hashlib
import json
import shutil
import zipfile
from pathlib import Path

import pytest
from PIL import Image
from typer.testing import CliRunner

from benchtwin.command_line import app
from benchtwin.report.pack import FORMAT, MANIFEST

RESULT = {
    "parameters": {
        "restitution": {"value": 0.54, "low": 0.497, "high": 0.581, "status": "found"}
    },
    "conventions": {"rolling": "edem", "rolling_means": "torque"},
    "materials": {"seed": {"name": "soybean", "source": "Ding et al. 2023"}},
}


def run(*arguments):
    return CliRunner().invoke(app, [*map(str, arguments)])


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A bench and what was calibrated on it, as a machine's folders hold them."""
    monkeypatch.chdir(tmp_path)
    bench = tmp_path / "Körner bench"
    (bench / "drop-01").mkdir(parents=True)
    (bench / "drop-01" / "recording.toml").write_text('rig = "drop"\n', "utf8")
    (bench / "drop-01" / "film.mp4").write_bytes(bytes(range(256)) * 9)
    (bench / ".hidden").write_text("no part of it")
    out = tmp_path / "calibrated"
    (out / "runs" / "abc").mkdir(parents=True)
    (out / "runs" / "abc" / "simulation.json").write_text("{}")
    told = RESULT | {"bench": {"folder": str(bench), "home": str(Path.home() / "x")}}
    (out / "result.json").write_text(json.dumps(told, ensure_ascii=False), "utf8")
    (out / "report.html").write_text(f"<p>{bench}/drop-01</p>", "utf8")
    return tmp_path


@pytest.mark.parametrize("name", ["packed", "packed.zip"])
def test_everything_comes_back(place, name):
    done = run("pack", "Körner bench", "calibrated", "--out", name)
    assert done.exit_code == 0, done.output
    again = run("unpack", name, "--out", "again")
    assert again.exit_code == 0 and "every file is as it was packed" in again.output
    inside = {p.relative_to(place / "again").as_posix() for p in files(place / "again")}
    assert inside == {
        "README.md",
        "bench/Körner bench/drop-01/film.mp4",
        "bench/Körner bench/drop-01/recording.toml",
        "results/calibrated/report.html",
        "results/calibrated/result.json",
    }
    film = place / "again" / "bench" / "Körner bench" / "drop-01" / "film.mp4"
    assert film.read_bytes() == bytes(range(256)) * 9


def files(folder):
    return [p for p in folder.rglob("*") if p.is_file()]


def test_nothing_of_the_machine_goes_along(place):
    run("pack", "Körner bench", "calibrated", "--out", "packed")
    for file in files(place / "packed"):
        raw = file.read_bytes()
        for folder in (place, Path.home(), Path.cwd()):
            assert str(folder).encode() not in raw or str(folder) == "/", file
    told = json.loads((place / "packed/results/calibrated/result.json").read_text())
    assert told["bench"] == {"folder": "bench/Körner bench", "home": "./x"}
    page = (place / "packed/results/calibrated/report.html").read_text("utf8")
    assert page == "<p>bench/Körner bench/drop-01</p>"


def test_what_a_reader_needs_stands_in_it(place):
    run("pack", "Körner bench", "calibrated", "--out", "packed")
    about = (place / "packed" / "README.md").read_text("utf8")
    assert "| restitution, seed–steel | 0.540 (0.497 to 0.581) | found |" in about
    assert "Ding et al. 2023" in about and "Simulated runs are left out" in about
    manifest = json.loads((place / "packed" / MANIFEST).read_text("utf8"))
    assert {"benchtwin", "numpy", "python"} <= set(manifest["versions"])
    for name, row in manifest["files"].items():
        raw = (place / "packed" / name).read_bytes()
        hashed = hashlib.sha256(raw).hexdigest()
        assert (row["bytes"], row["sha256"]) == (len(raw), hashed)


def test_runs_go_along_where_they_are_asked_for(place):
    run("pack", "Körner bench", "calibrated", "--runs", "--out", "packed")
    assert (place / "packed/results/calibrated/runs/abc/simulation.json").is_file()


def test_the_same_content_is_the_same_zip(place):
    run("pack", "Körner bench", "calibrated", "--out", "a.zip")
    for file in files(place / "Körner bench"):
        file.touch()
    run("pack", "Körner bench", "calibrated", "--out", "b.zip")
    assert (place / "a.zip").read_bytes() == (place / "b.zip").read_bytes()


def test_links_and_photos_that_say_where_are_named(place):
    (place / "Körner bench" / "link.txt").symlink_to(place / "calibrated")
    photo, exif = Image.new("RGB", (9, 9)), Image.Exif()
    exif.get_ifd(0x8825)[1] = "N"
    photo.save(place / "Körner bench" / "heap.jpg", exif=exif)
    photo.save(place / "Körner bench" / "plain.jpg")
    (place / "calibrated" / "report.html").write_text(f"made in {place}", "utf8")
    (place / "calibrated" / "report.pdf").write_bytes(b"%PDF made there")
    said = run("pack", "Körner bench", "calibrated", "--out", "packed").output
    left = next(line for line in said.splitlines() if line.startswith("left out"))
    assert "link.txt" in left and "report.pdf" in left
    assert "heap.jpg" in said and "plain.jpg" not in said
    assert not (place / "packed/bench/Körner bench/link.txt").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nowhere", "--out", "x"], "nowhere: no such folder"),
        (["Körner bench", "nowhere", "--out", "x"], "nowhere: no such folder"),
        (["Körner bench", "--out", "calibrated"], "is there already"),
        (["Körner bench", "--out", "Körner bench/x"], "lies within Körner bench"),
        (["Körner bench", "a/calibrated", "calibrated", "--out", "x"], "two folders"),
    ],
)
def test_misuse_is_a_sentence(place, arguments, words):
    shutil.copytree(place / "calibrated", place / "a" / "calibrated")
    done = run("pack", *arguments)
    assert done.exit_code == 2 and words in done.output and not (place / "x").exists()


def test_a_bench_that_names_a_place_on_this_machine_is_refused(place):
    toml = place / "Körner bench" / "drop-01" / "recording.toml"
    toml.write_text(f'rig = "drop"\n[seed]\nlot = "{place}/lot/lot.toml"\n', "utf8")
    done = run("pack", "Körner bench", "--out", "x")
    assert done.exit_code == 2 and "recording.toml: names" in done.output
    assert str(place) in done.output.replace("\n", "") and not (place / "x").exists()


@pytest.mark.parametrize("name", ["x", "x.zip"])
def test_a_full_disk_is_said_so_and_leaves_nothing(place, monkeypatch, name):
    def full(*_):
        raise OSError(28, "No space left on device")

    before = {p.name for p in place.iterdir()}
    monkeypatch.setattr("shutil.copyfileobj", full)
    done = run("pack", "Körner bench", "calibrated", "--out", name)
    assert done.exit_code == 1 and "No space left on device" in done.output
    assert {p.name for p in place.iterdir()} == before


def repacked(place, change):
    """A pack whose manifest was changed."""
    run("pack", "Körner bench", "calibrated", "--out", "packed")
    file = place / "packed" / MANIFEST
    manifest = json.loads(file.read_text("utf8"))
    change(manifest)
    file.write_text(json.dumps(manifest), "utf8")
    return run("unpack", "packed", "--out", "again")


def test_another_version_is_said_and_nothing_is_lost(place):
    done = repacked(
        place, lambda m: m["versions"].update(benchtwin="0.1.7", numpy="1.0")
    )
    said = " ".join(done.output.split())
    assert done.exit_code == 0 and len(files(place / "again")) == 5
    assert "packed by benchtwin 0.1.7; this is" in said and "numpy 1.0 (here" in said


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda m: m.update(format=FORMAT + 1), "which reads up to"),
        (lambda m: m["files"].update({"../x": {"sha256": "0"}}), "outside the pack"),
        (lambda m: m["files"].update({"/etc/x": {"sha256": "0"}}), "outside the pack"),
        (lambda m: m.pop("files"), "pack.json in it is damaged"),
        (lambda m: m.update(files=[1]), "pack.json in it is damaged"),
        (lambda m: m.update(versions=[1, 2]), "pack.json in it is damaged"),
        (lambda m: m["files"]["README.md"].update(bytes="9"), "pack.json in it is"),
        (lambda m: m["files"].update({"a\x1b[2J": {}}), "outside the pack"),
        (lambda m: m["files"].update({"README.md/x": {}}), "a file in a file"),
    ],
)
def test_a_pack_that_cannot_be_followed_is_a_sentence(place, change, words):
    done = repacked(place, change)
    assert done.exit_code == 2 and words in " ".join(done.output.split())
    assert not (place / "again").exists() and "Traceback" not in done.output


def test_what_has_changed_is_named(place):
    run("pack", "Körner bench", "calibrated", "--out", "packed")
    (place / "packed/results/calibrated/report.html").write_text("other")
    (place / "packed/bench/Körner bench/drop-01/film.mp4").unlink()
    (place / "packed/more.txt").write_text("more")
    done = run("unpack", "packed", "--out", "again")
    assert done.exit_code == 1
    assert "not as packed: results/calibrated/report.html" in done.output
    assert "missing: bench/Körner bench/drop-01/film.mp4" in done.output
    assert "not listed, and not copied: more.txt" in done.output
    assert (place / "again/results/calibrated/report.html").read_text() == "other"
    assert not (place / "again/more.txt").exists()


def test_what_lies_beside_the_place_is_no_part_of_the_pack(place):
    """Left over by a run that was killed, or put there by somebody else."""
    (place / ".again.part").mkdir()
    (place / ".again.part" / "evil.txt").write_text("not packed")
    (place / "elsewhere").mkdir()
    (place / ".more.part").symlink_to(place / "elsewhere")
    run("pack", "Körner bench", "--out", "packed.zip")
    for out in ("again", "more"):
        assert run("unpack", "packed.zip", "--out", out).exit_code == 0
        assert not (place / out / "evil.txt").exists()
        assert not (place / out).is_symlink()
    assert not files(place / "elsewhere")


def test_neither_command_writes_through_a_link(place):
    (place / "theirs").write_text("theirs")
    (place / "nowhere").symlink_to(place / "made")
    run("pack", "Körner bench", "--out", "packed")
    for name in ("link", "link.zip"):
        (place / name).symlink_to(place / "theirs")
        for words in (["pack", "Körner bench"], ["unpack", "packed"]):
            assert run(*words, "--out", name).exit_code == 2
            assert run(*words, "--out", "nowhere").exit_code == 2
    assert (place / "theirs").read_text() == "theirs"
    assert not (place / "made").exists()


def bomb(place, size, told):
    """A zip with a file of so many zeros, of which its manifest says `told` bytes."""
    row = {"bytes": told, "sha256": hashlib.sha256(bytes(size)).hexdigest()}
    listed = {"format": FORMAT, "versions": {}, "files": {"zeros": row}}
    with zipfile.ZipFile(place / "bomb.zip", "w", zipfile.ZIP_DEFLATED) as held:
        held.writestr("zeros", bytes(size))
        held.writestr(MANIFEST, json.dumps(listed))
    return run("unpack", "bomb.zip", "--out", "again")


def test_no_more_is_unpacked_than_the_pack_says(place):
    done = bomb(place, 9_000_000, 100)
    assert done.exit_code == 1 and "longer than packed, and not copied: zeros" in (
        " ".join(done.output.split())
    )
    assert not files(place / "again")


def test_what_does_not_fit_on_the_disk_is_refused_before_anything_is_written(place):
    before = {p.name for p in place.iterdir()}
    done = bomb(place, 9, 10**18)
    assert done.exit_code == 1 and "1000000000.0 GB in it," in done.output
    assert {p.name for p in place.iterdir()} == before | {"bomb.zip"}


@pytest.mark.parametrize(
    ("text", "words"),
    [(b" " * 99_000_000, "is larger than"), (b"[" * 9_000_000, "is damaged")],
)
def test_a_manifest_that_unfolds_is_refused_unread(place, text, words):
    with zipfile.ZipFile(place / "bomb.zip", "w", zipfile.ZIP_DEFLATED) as held:
        held.writestr(MANIFEST, text)
    done = run("unpack", "bomb.zip", "--out", "again")
    assert done.exit_code == 2 and words in " ".join(done.output.split())


@pytest.mark.parametrize("name", ["a:b.csv", "a\\b.csv", "a\x1bb.csv"])
def test_a_name_that_would_not_unpack_is_not_packed(place, name):
    (place / "Körner bench" / name).write_text("x")
    done = run("pack", "Körner bench", "--out", "x")
    assert done.exit_code == 2 and "a name that not every system" in done.output


def test_a_place_in_a_file_is_a_sentence_with_its_name(place):
    run("pack", "Körner bench", "--out", "packed.zip")
    for words in (["pack", "Körner bench"], ["unpack", "packed.zip"]):
        done = run(*words, "--out", "packed.zip/x")
        assert done.exit_code and "Errno" not in done.output
        assert "packed.zip" in done.output


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 cut", b"x" * 999])
def test_what_is_no_pack_is_a_sentence(tmp_path, content):
    (tmp_path / "a.zip").write_bytes(content)
    done = run("unpack", tmp_path / "a.zip", "--out", tmp_path / "b")
    assert done.exit_code == 2 and "a damaged zip, or none" in done.output
    (tmp_path / "folder").mkdir()
    done = run("unpack", tmp_path / "folder")
    assert done.exit_code == 2 and "pack.json is not in it" in done.output
    done = run("unpack", tmp_path / "nowhere")
    assert done.exit_code == 2 and "no such file or folder" in done.output


def test_a_zip_damaged_inside_is_a_sentence(place):
    run("pack", "Körner bench", "calibrated", "--out", "a.zip")
    raw = bytearray((place / "a.zip").read_bytes())
    with zipfile.ZipFile(place / "a.zip") as held:
        (film,) = (i for i in held.infolist() if i.filename.endswith("film.mp4"))
    for k in range(20):
        raw[film.header_offset + 80 + k] ^= 0xFF
    (place / "a.zip").write_bytes(raw)
    done = run("unpack", "a.zip", "--out", "again")
    assert done.exit_code == 2 and "a damaged zip" in done.output, done.output
    assert not (place / "again").exists()
