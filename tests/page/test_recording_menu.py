"""What can be done with a recording's files, in a real browser."""

import io
import tomllib

import pytest
from synthetic.series import heap_photos

from .test_browser import BROWSER, DRIVER, Window

pytestmark = pytest.mark.skipif(
    not (BROWSER and DRIVER), reason="no Chromium with chromedriver on this machine"
)
COUNT = 13


def as_bytes(picture):
    out = io.BytesIO()
    picture.save(out, "JPEG")
    return out.getvalue()


@pytest.fixture(scope="module")
def window(serve, tmp_path_factory):
    place = tmp_path_factory.mktemp("menu")
    bench = place / "bench"
    (bench / "either").mkdir(parents=True)
    (place / "sent").mkdir()
    (bench / "bench.toml").write_text("")
    for n, picture in enumerate(heap_photos(COUNT)):
        picture.save(bench / "either" / f"a_{n:04d}.png")
        picture.save(place / "sent" / f"IMG_{4300 + n}.jpg")
    (bench / "IMG_7.jpg").write_bytes(as_bytes(heap_photos(1)[0]))
    for name, keys in (
        ("heap", 'rig = "heap"\n[camera]\nfps = "fast"\n'),
        ("no-toml", "rig = \n"),
        ("lone", 'rig = "heap"\n'),
    ):
        (bench / name).mkdir()
        (bench / name / "recording.toml").write_text(keys)
        (bench / name / "h.jpg").write_bytes(as_bytes(heap_photos(1)[0]))
    with serve(bench) as address:
        window = Window(address, bench)
        yield window
        window.driver.quit()


def names(bench):
    return sorted(p.name for p in bench.iterdir() if not p.name.startswith("."))


def test_photos_numbered_by_a_camera_become_heaps(window):
    window.go("/bench?b=.")
    window.add_files(*sorted((window.folder.parent / "sent").iterdir()))

    def piles():
        return [n for n in names(window.folder) if n.startswith("pile-")]

    window.until(lambda: len(piles()) == COUNT, 60)
    window.until(lambda: f"IMG_{4300 + COUNT - 1}.jpg" in window.text(".card-link"), 60)


def test_where_both_fit_it_is_asked_and_the_answer_can_be_taken_back(window):
    window.go("/recording?r=either")
    window.until(lambda: f"{COUNT} photos of heaps, or one film?" in window.text())
    window.press(f"{COUNT} photos of heaps")
    window.until(lambda: "Removed: either" in window.text(), 60)
    split = [f"a_{n:04d}" for n in range(COUNT)]
    assert {*split} <= {*names(window.folder)} and "either" not in names(window.folder)
    window.press("undo\nPut back")
    window.until(lambda: "either" in names(window.folder))


def test_deleted_and_put_back(window):
    window.go("/recording?r=lone")
    window.press("more_vert\nFiles")
    window.press("Delete", ".q-item")
    window.until(lambda: "Removed: lone" in window.text())
    assert "lone" not in names(window.folder)
    window.press("undo\nPut back")
    window.until(lambda: "lone" in names(window.folder))


def test_a_loose_photo_gets_its_folder_with_the_first_correction(window):
    window.go("/recording?r=IMG_7.jpg")
    window.until(lambda: "repose angle" in window.text(), 60)
    window.press("Base line", ".q-btn")
    window.drag("base-left", 0, -12)
    file = window.folder / "IMG_7" / "recording.toml"
    window.until(lambda: file.is_file() and "baseline_px" in file.read_text())
    keys = tomllib.loads(file.read_text())
    assert keys["rig"] == "pile" and len(keys["pile"]["baseline_px"]) == 4
    assert not (window.folder / "IMG_7.jpg").exists()
    window.until(lambda: "corrected" in window.text(), 60)


def test_wrong_keys_are_mended_in_the_form_one_by_one(window):
    file = window.folder / "heap" / "recording.toml"
    window.go("/recording?r=heap")
    window.until(lambda: "fps = 'fast'" in window.text())
    assert "heap (not known)" in window.text()
    window.press("Camera", ".q-item__label")
    window.type("fps [1/s]", "50\n")
    window.until(lambda: "fps = 50" in file.read_text())
    window.until(lambda: "fps" not in window.text(".failed"))
    rig = window.until(lambda: window.all('.q-select input[aria-label="rig"]'))[0]
    rig.send_keys("\ue015")  # arrow down: opens the list
    window.press("pile", ".q-menu .q-item")
    window.until(lambda: "repose angle" in window.text(), 60)


def test_what_is_no_toml_is_mended_as_text(window):
    window.go("/recording?r=no-toml")
    text = window.until(lambda: window.all("textarea"))[0]
    text.send_keys('\ue009a\ue000rig = "pile"')
    window.press("Save")
    window.until(lambda: "repose angle" in window.text(), 60)
