"""Nothing outside the opened folder is reached, by no name and by no link; files appear
whole or not at all."""

import itertools
import os

import pytest

from benchtwin.bench.whole_file import new_folder, write_whole
from benchtwin.page.folder import (
    MARK,
    RESULTS,
    Folder,
    Refused,
    clean_name,
)

OUT = (
    "..",
    "../x",
    "a/../../x",
    "/etc/passwd",
    "//x",
    "~/x",
    "~root",
    "C:/x",
    "C:\\x",
    "..\\x",
    "a\\..\\..\\x",
    "a/..",
    "a//b",
    "",
    "/",
    "a\0b",
)
NESTED = tuple(
    "/".join(parts)
    for parts in itertools.product(("a", "..", "link"), repeat=4)
    if ".." in parts or parts[0] == "link"
)


@pytest.fixture
def folder(tmp_path):
    root = tmp_path / "root"
    (root / "a").mkdir(parents=True)
    (tmp_path / "secret").mkdir()
    (tmp_path / "secret" / "x").write_text("not yours")
    (root / "link").symlink_to(tmp_path / "secret")
    (root / "a" / "link").symlink_to("../../secret/x")
    return Folder(root)


def test_a_hundred_names_that_lead_out_are_refused(folder):
    names = [
        *OUT,
        *NESTED,
        *(f"{'../' * n}etc/passwd" for n in range(1, 12)),
        "link/x",
        "a/link",
        "a/" + "b" * 5000,
    ]
    assert len(names) > 90
    for name in names:
        with pytest.raises(Refused):
            folder.inside(name)


@pytest.mark.parametrize(
    "name", ["a", "a/b.txt", "<script>alert(1)</script>.png", "ä ö [1].jpg", "."]
)
def test_names_within_are_found(folder, name):
    path = folder.inside(name)
    assert path.is_relative_to(folder.root)
    assert folder.inside(folder.name_of(path)) == path


@pytest.mark.parametrize(
    ("name", "clean"),
    [
        ("../../etc/passwd", "passwd"),
        ("C:\\photos\\a.jpg", "a.jpg"),
        (".bashrc", "bashrc"),
        ("", "file"),
        ("a\x1b[31m.png", "a[31m.png"),
        ("<script>.png", "<script>.png"),
        ("x" * 500 + ".jpeg", "x" * 95 + ".jpeg"),
    ],
)
def test_clean_names(name, clean):
    assert clean_name(name) == clean


def test_a_folder_that_is_interrupted_never_appears(folder):
    with (
        pytest.raises(RuntimeError),
        new_folder(folder.root / "new") as part,
    ):
        (part / "file").write_text("half")
        raise RuntimeError
    assert not (folder.root / "new").exists()
    with pytest.raises(FileExistsError), new_folder(folder.root / "a"):
        pass
    assert (folder.root / "a").is_dir()


def test_a_file_that_cannot_be_written_stays_as_it_was(tmp_path, monkeypatch):
    file = tmp_path / "recording.toml"
    file.write_text("old")

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space"):
        write_whole(file, b"new")
    assert file.read_text() == "old" and list(tmp_path.iterdir()) == [file]


def test_benches_and_their_results(tmp_path):
    assert Folder(tmp_path).benches() == [tmp_path]  # an empty folder is a bench to be
    for name in ("soy/drop-01", "maize/pile-01"):
        (tmp_path / name).mkdir(parents=True)
        (tmp_path / name / "recording.toml").write_text("")
    folder = Folder(tmp_path)
    assert [p.name for p in folder.benches()] == ["maize", "soy"]
    folder.results(tmp_path / "soy")
    assert (tmp_path / "soy" / RESULTS / MARK).exists()
    assert Folder(tmp_path / "soy").benches() == [tmp_path / "soy"]
