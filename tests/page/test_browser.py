"""The page in a real browser: adding files, corrections, keys, runs, results. Skipped
where there is no Chromium with its driver."""

import http.server
import io
import json
import re
import shutil
import subprocess
import sys
import threading
import time
import tomllib
import urllib.error
import urllib.request
from pathlib import Path
from typing import ClassVar
from urllib.parse import quote

import numpy as np
import pytest
from PIL import Image
from synthetic.piles import PileScene, draw_pile

from benchtwin.page.guard import forwarding
from benchtwin.vision.motion.drop_sound import impacts_in_sound
from benchtwin.vision.pile.repose import measure_repose
from benchtwin.vision.recording import read_recording

BROWSER = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))),
    None,
)
DRIVER = shutil.which("chromedriver")
pytestmark = pytest.mark.skipif(
    not (BROWSER and DRIVER), reason="no Chromium with chromedriver on this machine"
)
ANGLE = 30.0
LOADING_S = 60.0  # of a page; a report takes 20 and more on a busy machine
SURFACE, FITTED = (
    (0x2F, 0xD0, 0x6B),
    (0xFF, 0x4D, 0x4D),
)  # the drawn surface; the fitted line lies over it


class Window:
    """A browser window on a page that is served from a folder; driver: of a browser
    that is open."""

    def __init__(self, address: str, folder, driver=None):
        self.folder, self.root = folder, address.split("?")[0].rstrip("/")
        self.driver = driver or self.browser()
        self.driver.set_page_load_timeout(LOADING_S)
        self.open(address)

    def browser(self):
        from selenium import webdriver
        from selenium.webdriver.chrome.service import Service

        options = webdriver.ChromeOptions()
        options.binary_location = str(BROWSER)
        for argument in (
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-dev-shm-usage",
            "--window-size=1280,900",
        ):
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        return webdriver.Chrome(options=options, service=Service(DRIVER))

    def open(self, address: str) -> None:
        from selenium.common.exceptions import TimeoutException

        try:
            self.driver.get(address)
        except TimeoutException:  # the driver missed that the page has loaded
            self.driver.get(address)

    def go(self, path: str) -> None:
        self.open(self.root + path)

    def all(self, selector: str):
        return self.driver.find_elements("css selector", selector)

    def text(self, selector: str = "body") -> str:
        from selenium.common.exceptions import StaleElementReferenceException

        try:
            return "\n".join(e.text for e in self.all(selector))
        except StaleElementReferenceException:  # drawn anew meanwhile
            return ""

    def until(self, condition, seconds: float = 30.0):
        end = time.time() + seconds
        while not (found := condition()):
            assert time.time() < end, (
                f"not within {seconds} s; the page says:\n{self.text()}"
            )
            time.sleep(0.05)
        return found

    def press(self, label: str, selector: str = "button, nav a") -> None:
        def there():
            return next(
                (
                    e
                    for e in self.all(selector)
                    if e.text.strip().lower() == label.lower()
                ),
                None,
            )

        self.driver.execute_script(
            "arguments[0].scrollIntoView({block: 'center'}); arguments[0].click()",
            self.until(there),
        )

    def add_files(self, *files) -> None:
        entry = self.until(lambda: self.all("input[type=file]"))[0]
        self.driver.execute_script("arguments[0].style.display = 'block'", entry)
        entry.send_keys("\n".join(map(str, files)))

    def type(self, label: str, text: str) -> None:
        field = self.until(
            lambda: next(
                (
                    e
                    for e in self.all(f'input[aria-label="{label}"]')
                    if e.is_displayed()
                ),
                None,
            )
        )
        self.driver.execute_script(
            "arguments[0].scrollIntoView({block: 'center'})", field
        )
        field.send_keys("\ue009a\ue000", text)  # Ctrl+A, then what replaces it
        time.sleep(0.3)

    def drag(self, handle: str, dx: int, dy: int) -> None:
        from selenium.webdriver import ActionChains

        place = self.until(lambda: self.all(f'[data-handle="{handle}"]'))[0]
        ActionChains(self.driver, duration=30).move_to_element(
            place
        ).click_and_hold().move_by_offset(dx, dy).release().perform()

    def keys(self, text: str) -> None:
        """Press keys on whatever has the focus."""
        from selenium.webdriver import ActionChains

        for key in text:
            ActionChains(self.driver).send_keys(key).perform()

    def troubles(self) -> list[str]:
        return [
            e["message"]
            for e in self.driver.get_log("browser")
            if e["level"] == "SEVERE" and "favicon" not in e["message"]
        ]


@pytest.fixture(scope="module")
def window(serve, tmp_path_factory):
    folder = tmp_path_factory.mktemp("served") / "bench"
    with serve(folder) as address:
        opened = Window(address, folder)
        yield opened
        opened.driver.quit()


@pytest.fixture
def photo(tmp_path):
    picture = draw_pile(
        PileScene(angle_deg=ANGLE, size=(900, 600), pile_height=180),
        np.random.default_rng(0),
    )
    file = tmp_path / "heap <b>&amp;.png"
    Image.fromarray(picture).save(file)
    return file


def numbers(window, name: str) -> list[float]:
    """The values in the row `name` of the table, in the order of its columns."""
    row = re.search(rf"^{name} (.*)$", window.text(".numbers"), re.M)
    return [float(v) for v in re.findall(r"([\d.]+) ±", row[1])] if row else []


def test_a_dropped_photo_is_measured_and_corrected(window, photo):
    window.go("/")
    began = time.time()
    window.add_files(photo)
    angle = window.until(lambda: numbers(window, "repose angle"))
    assert time.time() - began < 20  # of the 60 s that a person has
    assert angle == [pytest.approx(ANGLE, abs=0.1)]
    assert photo.name not in window.driver.title and "pile-01" in window.driver.title

    window.until(lambda: window.all(".look image"))
    time.sleep(0.5)
    drawn = Image.open(
        io.BytesIO(window.all(".look svg")[0].screenshot_as_png)
    ).convert("RGB")
    assert surface_share(drawn, photo) > 0.8
    assert (
        surface_share(
            drawn.transform(drawn.size, Image.Transform.AFFINE, (1, 0, 0, 0, 1, 25)),
            photo,
        )
        < 0.4
    )  # the control

    window.press("Base line")
    window.drag("base-left", 0, -12)
    window.until(lambda: len(numbers(window, "repose angle")) == 2)
    both = numbers(window, "repose angle")
    assert both[1] == pytest.approx(ANGLE, abs=0.1) and both[0] != both[1]
    text = (window.folder / "pile-01" / "recording.toml").read_text()
    assert (
        "set by hand" in text and len(tomllib.loads(text)["pile"]["baseline_px"]) == 4
    )
    window.press("Automatic again")
    window.until(lambda: len(numbers(window, "repose angle")) == 1)
    assert (
        "baseline_px" not in (window.folder / "pile-01" / "recording.toml").read_text()
    )
    assert not window.troubles()


def surface_share(drawn: Image.Image, photo) -> float:
    """How much of the surface, as measured apart from the page, is drawn in the page's
    picture (within 4 px)."""
    image = np.asarray(Image.open(photo))
    surface = measure_repose(image).surface
    scale = min(drawn.width / image.shape[1], drawn.height / image.shape[0])
    left, top = (
        (drawn.width - scale * image.shape[1]) / 2,
        (drawn.height - scale * image.shape[0]) / 2,
    )
    line = np.logical_or(
        *(
            np.abs(np.asarray(drawn).astype(int) - colour).sum(axis=2) < 150
            for colour in (SURFACE, FITTED)
        )
    )
    columns = np.flatnonzero(np.isfinite(surface))[5:-5:7]
    places = [
        (round(left + scale * c), round(top + scale * surface[c])) for c in columns
    ]
    return float(
        np.mean(
            [
                line[max(0, y - 4) : y + 5, max(0, x - 3) : x + 4].any()
                for x, y in places
            ]
        )
    )


def readings(
    folder, name: str, text: str = 'rig = "drop"  # of the grey plate\n'
) -> None:
    (folder / name).mkdir(parents=True, exist_ok=True)
    (folder / name / "recording.toml").write_text(text)
    (folder / name / "readings.csv").write_text("rebound_height_mm\n70\n72\n71\n")


def test_what_is_missing_is_asked_for_and_saved_as_toml(window):
    readings(window.folder, "drop-01")
    window.go("/recording?r=drop-01")
    window.until(lambda: "needed: Release to plate" in window.text())
    window.type("height_mm [mm]", "310,5")
    window.until(lambda: numbers(window, "restitution"))
    text = (window.folder / "drop-01" / "recording.toml").read_text()
    assert text == 'rig = "drop"  # of the grey plate\n\n[drop]\nheight_mm = 310.5\n'
    window.type("height_mm [mm]", "high")
    window.until(lambda: "height_mm: 'high' is not a number" in window.text())
    assert (window.folder / "drop-01" / "recording.toml").read_text() == text


def test_a_second_page_does_not_overwrite_the_first_one_s_change(window):
    readings(window.folder, "drop-02")
    window.go("/recording?r=drop-02")
    window.until(lambda: "needed: Release" in window.text())
    (window.folder / "drop-02" / "recording.toml").write_text(
        'rig = "drop"\n[drop]\nheight_mm = 200\n'
    )  # the other page
    keys = window.folder / "drop-02" / "recording.toml"
    window.type("height_mm [mm]", "310")
    window.until(lambda: "was changed meanwhile" in window.text())
    assert "height_mm = 200" in keys.read_text()
    window.type("height_mm [mm]", "311")  # knowing what stands there
    window.until(lambda: "height_mm = 311" in keys.read_text())


def test_a_run_is_followed_and_its_results_stand_in_a_frame(window):
    for name in ("drop-05", "drop-06"):
        readings(window.folder, name, 'rig = "drop"\n[drop]\nheight_mm = 310\n')
    window.go("/")
    window.press("Run")
    window.press("Measure")
    window.until(lambda: "1. measure" in window.text() and "done" in window.text(), 60)
    window.press("Results")
    window.until(
        lambda: (
            "Means over repeats" in window.text()
            and not window.text(".q-table")  # folded: the long table comes last
        )
    )
    window.driver.execute_script(
        "document.querySelector('.q-expansion-item__container [role=button]').click()"
    )
    window.until(lambda: "restitution" in window.text(".q-table"))
    assert "as one zip" in window.text()
    assert not window.troubles()


def test_unreadable_files_are_named_and_the_others_added(window, tmp_path):
    bad, good = tmp_path / "<i>x.exe", tmp_path / "drop 9.csv"
    bad.write_text("x")
    good.write_text("t_s\n0.25\n0.5\n0.7\n")
    window.go("/")
    window.add_files(bad, good)
    window.until(
        lambda: (
            "<i>x.exe: not something that benchtwin reads" in window.text("#refused")
        )
    )  # it shows as itself
    assert (window.folder / "drop 9" / "impacts.csv").read_text() == good.read_text()


@pytest.mark.parametrize(
    ("name", "reason"),
    [("nowhere", "no longer there"), ("../../etc", "not a name inside this folder")],
)
def test_a_recording_that_cannot_be_opened_gives_the_reason_and_no_form(
    window, name, reason
):
    """A form would write keys of a recording that is not there, or outside the
    folder."""
    window.go(f"/recording?r={name}")
    window.until(lambda: "cannot be opened" in window.text())
    assert reason in window.text(".failed")
    assert not window.all('input[aria-label^="id"]') and not window.all(".numbers")


@pytest.mark.parametrize(
    "path",
    [
        "/",
        "/photo?r=pile-01",
        "/_nicegui_ws/socket.io/?EIO=4&transport=polling",
        "/static/page.js",
    ],
)
def test_without_the_key_nothing_answers(window, path):
    with pytest.raises(urllib.error.HTTPError) as refused:
        urllib.request.urlopen(window.root + path, timeout=10)
    assert refused.value.code == 403


def test_a_wrong_place_in_a_film_is_struck_out(window):
    sample = Path(__file__).parents[2] / "samples" / "drawn-bench" / "drop-phone"
    shutil.copytree(sample, window.folder / "film")
    window.troubles()  # of the tests before: refused requests are logged
    window.go("/recording?r=film")
    window.until(lambda: window.all(".dot"), 60)
    window.press("Strike out")
    dot = window.all(".dot")[30]
    window.driver.execute_script(
        "arguments[0].dispatchEvent(new PointerEvent('pointerdown', {bubbles: true}))",
        dot,
    )
    keys = window.folder / "film" / "recording.toml"
    window.until(lambda: "left_out_frames" in keys.read_text())
    (frame,) = tomllib.loads(keys.read_text())["track"]["left_out_frames"]
    window.until(
        lambda: any(
            f"frame {frame}, left out" in e.get_attribute("textContent")
            for e in window.all(".dot")
        ),
        60,
    )
    assert not window.troubles()


def test_impacts_are_struck_out_and_added_on_the_waveform(window):
    """A click on an impact, arrows and Enter on another sound; keys in the file, both
    values side by side, the command line alike."""
    from selenium.webdriver import ActionChains

    sample = Path(__file__).parents[2] / "samples" / "heard-drop" / "drop-01"
    shutil.copytree(sample, window.folder / "heard")
    keys = window.folder / "heard" / "recording.toml"
    keys.write_text('rig = "drop"\n[drop]\nheight_mm = 310  # to the plate\n')
    window.troubles()
    window.go("/recording?r=heard")
    window.until(
        lambda: len(window.all("[data-impact]")) == 5 and numbers(window, "restitution")
    )
    wave = window.all(".wave svg")[0]
    last = window.all("[data-impact]")[-1]
    at = float(last.get_attribute("data-impact"))
    right = (
        last.rect["x"]
        + last.rect["width"] / 2
        - wave.rect["x"]
        - wave.rect["width"] / 2
    )
    ActionChains(window.driver, duration=20).move_to_element_with_offset(
        wave, round(right), 0
    ).click().perform()
    window.until(
        lambda: (
            len(window.all("[data-impact]")) == 4
            and len(numbers(window, "restitution")) == 2
        )
    )
    written = tomllib.loads(keys.read_text())["drop"]
    assert written["impacts_struck_s"] == [pytest.approx(at, abs=1e-3)]
    assert "# to the plate" in keys.read_text() and "set by hand" in keys.read_text()
    heard = impacts_in_sound(
        sample / "sound.ogg", read_recording(window.folder / "heard")
    )
    assert [len(drop.times) for drop in heard.drops] == [4]

    window.driver.execute_script("document.querySelector('.wave').focus()")
    for key in ("\ue014", "\ue007"):  # to the first sudden sound, Enter
        ActionChains(window.driver).send_keys(key).perform()
    window.until(lambda: len(window.all(".impact.added")) == 1)
    assert len(tomllib.loads(keys.read_text())["drop"]["impacts_added_s"]) == 1
    window.press("Automatic again")
    window.until(
        lambda: (
            "impacts" not in keys.read_text()
            and len(window.all("[data-impact]")) == 5
            and len(numbers(window, "restitution")) == 1
        )
    )
    assert not window.troubles()


@pytest.fixture(scope="module")
def calibrated(window, tmp_path_factory):
    """A bench in the served folder, with a calibration's and a diagnosis' results; back
    to what was there afterwards."""
    samples = Path(__file__).parents[2] / "samples"
    left = window.folder / "results"
    out = tmp_path_factory.mktemp("calibrated") / "calibrated"
    command = [
        sys.executable,
        "-m",
        "benchtwin",
        "calibrate",
        str(samples / "soybean-paper"),
        "--tables",
        "--out",
        str(out),
        "--quiet",
    ]
    assert subprocess.run(command, timeout=120).returncode == 0
    left.mkdir(exist_ok=True)
    (left / ".results").touch()
    shutil.copytree(out, left / "calibrated")
    shutil.copytree(samples / "drawn-bench" / "drop-phone", window.folder / "twinned")
    shutil.copytree(
        samples / "drawn-bench" / "drop-phone",
        left / "calibrated" / "twin" / "drop" / "key",
    )
    file = left / "calibrated" / "result.json"
    pair = {
        "rig": "drop",
        "recording": "drop-phone",
        "alike": True,
        "twin": "twin/drop/key",
    }
    file.write_text(json.dumps(json.loads(file.read_text()) | {"pairs": [pair]}))
    (left / "diagnosed").mkdir()
    one = {
        "verdict": "name",
        "p_global": 1e-6,
        "matters": True,
        "next_record": "a drop from twice the height",
        "sentence": "air drag is missing, and nothing else (93 %)",
        "tone": "name",
        "explanations": [{"effects": ["drag"], "probability": 0.93}],
    }
    (left / "diagnosed" / "diagnosis.json").write_text(
        json.dumps({"rigs": {"drop": one}})
    )
    window.troubles()
    yield left
    shutil.rmtree(left / "calibrated")
    shutil.rmtree(left / "diagnosed")


@pytest.mark.slow
def test_recording_and_twin_stand_side_by_side_with_one_slider(window, calibrated):
    window.go("/bench?b=.&tab=Results")
    window.press("Bench and twin")
    assert "part=Bench" in window.driver.current_url
    slider = window.until(lambda: window.all(".beside input[type=range]"), 180)[0]
    pictures = [e.get_attribute("src") for e in window.all(".beside img")]
    assert len(pictures) == 2 and all("/frame?r=" in src for src in pictures)
    before = window.text(".beside-words")
    assert "difference 0 mm" in before  # one film, whose falls give the scale
    slider.send_keys("\ue014" * 40)
    window.until(lambda: window.text(".beside-words") != before)
    later = [e.get_attribute("src") for e in window.all(".beside img")]
    assert all(
        int(b.rpartition("=")[2]) > int(a.rpartition("=")[2])
        for a, b in zip(pictures, later)
    )
    loaded = (
        "return [...document.querySelectorAll('.beside img')].every(e => e.complete &&"
        " e.naturalWidth > 100)"
    )
    window.until(lambda: window.driver.execute_script(loaded))
    assert not window.troubles()


def test_a_sound_linked_from_outside_the_folder_is_refused(window, tmp_path):
    secret = tmp_path / "secret"
    secret.write_text("no sound")
    (window.folder / "linked").mkdir()
    (window.folder / "linked" / "recording.toml").write_text('rig = "drop"\n')
    (window.folder / "linked" / "sound.wav").symlink_to(secret)
    window.go("/")
    fetched = (
        "const done = arguments[0]; fetch('/sound?r=linked').then(async r =>"
        " done([r.status, await r.text()]))"
    )
    status, said = window.driver.execute_async_script(fetched)
    assert status == 422 and "is a link out of this folder" in said
    shutil.rmtree(window.folder / "linked")
    window.troubles()


def test_the_list_of_what_to_record_and_the_cards_are_downloaded(window, calibrated):
    fetched = """const done = arguments[arguments.length - 1];
        fetch(arguments[0]).then(async r => done([
            r.status,
            (await r.arrayBuffer()).byteLength,
            r.headers.get('content-disposition')]))"""
    window.go("/bench?b=.&tab=Results")
    links = window.until(
        lambda: [
            e.get_attribute("href")
            for e in window.all("a[href*='/cards'], a[href*='/zip']")
        ]
    )
    assert len(links) == 6
    for link in links:
        status, size, kept = window.driver.execute_async_script(fetched, link)
        assert status == 200 and size > 500 and ".zip" in kept
    window.go("/next?bench=.")
    window.until(lambda: "drop: a drop from twice the height" in window.text("li"))
    assert window.all("button")[0].is_displayed()
    window.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    assert not window.all("button")[0].is_displayed()
    window.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
    assert not window.troubles()


@pytest.mark.slow
def test_a_film_without_a_rig_asks_what_was_done(window):
    """It is measured as what its motion tells, and one click confirms it."""
    sample = Path(__file__).parents[2] / "samples" / "drawn-bench" / "drop-phone"
    (window.folder / "unnamed").mkdir()
    shutil.copy(sample / "video.mp4", window.folder / "unnamed")
    (window.folder / "unnamed" / "recording.toml").write_text(
        '# rig = "drop"             # drop, slide, roll or pile\n'
    )
    window.troubles()
    window.go("/recording?r=unnamed")
    window.until(
        lambda: (
            "What was done?" in window.text()
            and "taken for a drop" in window.text()
            and numbers(window, "restitution normal")
        ),
        60,
    )
    window.press("drop: a seed falls on a plate")
    window.until(lambda: "taken for a drop" not in window.text(), 60)
    window.until(lambda: numbers(window, "restitution normal"), 60)
    assert tomllib.loads(
        (window.folder / "unnamed" / "recording.toml").read_text()
    ) == {"rig": "drop"}
    assert "What was done?" not in window.text() and not window.troubles()


@pytest.mark.slow
@pytest.mark.parametrize("width", [360, 390, 768, 1280])
def test_no_page_is_wider_than_the_window(window, calibrated, width):
    """Also with a long name, and the reports that stand in frames."""
    long = window.folder / ("heap_of_mung_beans_after_the_rain_" * 2 + "x")
    if not long.exists():
        readings(window.folder, long.name)
    shutil.copytree(
        Path(__file__).parents[2] / "samples" / "drawn-bench" / "pile-heap",
        window.folder / "heap",
        dirs_exist_ok=True,
    )
    size = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": False}
    window.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    parts = ("Calibration", "What to record next", "Bench and twin")
    pages = [
        "/",
        "/bench?b=.&tab=What%20holds%20for%20all",
        "/bench?b=.&tab=Run",
        *(f"/bench?b=.&tab=Results&part={quote(part)}" for part in parts),
        f"/recording?r={long.name}",
        "/recording?r=heap",
        "/recording?r=twinned",
        "/results/results/calibrated/report.html",
        "/next?bench=.",
    ]

    def wide():
        return window.driver.execute_script(
            "return document.documentElement.scrollWidth"
        )

    try:
        for page in pages:
            window.go(page)
            window.until(lambda: len(window.text()) > 20)
            time.sleep(0.4)  # what is drawn after the page is there
            window.until(lambda: wide() <= width, 60)  # and finds its place
            assert wide() <= width, page
    finally:
        window.driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def test_the_address_follows_tab_and_frame(window):
    """Reload and back land where one was."""
    window.go("/")
    window.press("Run")
    window.until(lambda: "tab=Run" in window.driver.current_url)
    window.press("Results")
    window.until(lambda: "tab=Results" in window.driver.current_url)
    current = '.tabs a[aria-current="page"]'
    window.driver.refresh()
    window.until(lambda: window.text(current).startswith("Results"))
    window.driver.back()
    window.until(lambda: window.text(current) == "Run")
    film(window, "addressed")
    window.go("/recording?r=addressed")
    focus(window, ".look")
    window.keys("\ue014" * 7)  # right
    window.until(lambda: "frame=7" in window.driver.current_url)
    window.driver.refresh()
    window.until(lambda: window.text(".moment").startswith("frame 7 "))


def film(window, name: str) -> Path:
    """A film of a drop in the served folder; its recording.toml."""
    sample = Path(__file__).parents[2] / "samples" / "drawn-bench" / "drop-phone"
    shutil.copytree(sample, window.folder / name, dirs_exist_ok=True)
    return window.folder / name / "recording.toml"


def focus(window, selector: str) -> None:
    window.until(lambda: window.all(selector))
    window.driver.execute_script(
        "document.querySelector(arguments[0]).focus()", selector
    )


def test_a_card_has_number_quality_and_original_name(window):
    picture = draw_pile(
        PileScene(angle_deg=ANGLE, size=(900, 600), pile_height=180),
        np.random.default_rng(1),
    )
    (window.folder / "heap-7").mkdir()
    (window.folder / "heap-7" / "recording.toml").write_text('rig = "pile"\n')
    Image.fromarray(picture).save(window.folder / "heap-7" / "IMG_4300.png")
    window.go("/")

    def card():
        return next((t for t in cards(window) if t.startswith("heap-7")), "")

    window.until(lambda: "good" in card(), 60)
    angle = re.search(r"repose angle ([\d.]+) ± ([\d.]+)°", card())
    assert angle and float(angle[1]) == pytest.approx(ANGLE, abs=0.1)
    assert "IMG_4300.png" in card()
    readings(window.folder, "drop-11", 'rig = "drop"\n[drop]\nheight_mm = 310\n')
    window.go("/")
    window.until(
        lambda: any(
            "drop-11" in t and "n = 3" in t and "restitution 0.4" in t
            for t in cards(window)
        ),
        60,
    )


def cards(window) -> list[str]:
    return window.driver.execute_script(
        "return [...document.querySelectorAll('.card-link')].map(e => e.innerText)"
    )


def test_a_film_plays_at_the_speed_that_was_chosen(window):
    """At a tenth of the speed of its 60 frames a second a frame stands for 0.17 s, five
    of them 0.83 s; at full speed it is at its end in a moment."""
    film(window, "played")
    window.troubles()
    window.go("/recording?r=played")
    window.until(lambda: window.all(".player"))
    pick = "const s = document.querySelector('.player select'); s.value = arguments[0];"
    window.driver.execute_script(pick + " s.dispatchEvent(new Event('change'))", "0.1")
    at = lambda: int(re.search(r"frame (\d+)", window.text(".moment"))[1])  # noqa: E731
    focus(window, ".look")
    window.keys(" ")
    window.until(lambda: at() >= 2)
    began, first = time.time(), at()
    window.until(lambda: at() >= first + 5)
    assert time.time() - began > 0.6  # the first of them may have stood for a while
    window.driver.execute_script(pick + " s.dispatchEvent(new Event('change'))", "2")
    window.until(lambda: at() == 71, 20)
    window.keys("\ue012")  # left: one frame back
    window.until(lambda: at() == 70)
    assert not window.troubles()


def test_places_are_set_by_hand_with_mouse_and_keys(window):
    from selenium.webdriver import ActionChains

    keys = film(window, "clicked")
    window.troubles()
    window.go("/recording?r=clicked")
    window.until(lambda: window.all(".dot"), 60)
    window.press("Place")
    focus(window, ".look")
    window.keys("\ue014" * 30)
    svg = window.all(".look svg")[0]
    ActionChains(window.driver).move_to_element(svg).click().perform()
    stated = window.until(lambda: stated_places(keys))
    assert stated[0][0] == 30
    window.until(lambda: window.text(".moment").startswith("frame 31 "))
    focus(window, '[data-handle="spot"]')
    window.keys("\ue014\ue014\ue007")  # two pixels to the right, Enter
    assert [p[0] for p in window.until(lambda: both(stated_places(keys)))] == [30, 31]
    window.until(lambda: len(window.all(".placed")) == 2)
    focus(window, ".look")
    window.keys("\ue012\ue017")  # back to frame 31, Delete
    window.until(lambda: len(stated_places(keys)) == 1)
    window.until(lambda: "1 place set by hand" in window.text(), 60)
    assert not window.troubles()


def stated_places(keys: Path) -> list:
    return tomllib.loads(keys.read_text()).get("track", {}).get("places_px", [])


def both(places: list) -> list:
    return places if len(places) == 2 else []


def test_a_correction_is_undone_and_done_again(window):
    from selenium.webdriver import ActionChains

    keys = film(window, "undone")
    before = keys.read_text()
    window.go("/recording?r=undone")
    window.until(lambda: window.all(".dot"), 60)
    window.press("Strike out")
    focus(window, ".look")
    window.keys("\ue007")  # Enter: the frame shown
    window.until(lambda: "left_out_frames" in keys.read_text())
    window.until(lambda: window.all("[data-key=undo]:not([disabled])"))
    ActionChains(window.driver).key_down("\ue009").send_keys("z").key_up(
        "\ue009"
    ).perform()
    window.until(lambda: keys.read_text() == before)
    window.until(lambda: not redo_off(window))
    window.press("redo\nRedo")
    window.until(lambda: "left_out_frames" in keys.read_text())


def redo_off(window) -> bool:
    return window.all("[data-key=redo]")[0].get_attribute("disabled") is not None


def test_a_region_is_used_on_chosen_photos_only(window):
    """Two of three others; undo on any of them takes all back."""
    picture = draw_pile(
        PileScene(angle_deg=ANGLE, size=(600, 400), pile_height=120),
        np.random.default_rng(2),
    )
    files = {}
    for name in ("r1", "r2", "r3", "r4"):
        (window.folder / name).mkdir()
        Image.fromarray(picture).save(window.folder / name / f"{name}.png")
        files[name] = window.folder / name / "recording.toml"
        files[name].write_text('rig = "pile"\n')
    files["r1"].write_text('rig = "pile"\n[pile]\nroi_px = [10, 10, 560, 380]\n')
    window.go("/recording?r=r1")
    window.press("Use on other photos …")
    window.until(lambda: len(window.all(".chosen-photos .q-checkbox")) > 2)
    for box in window.all(".chosen-photos .q-checkbox"):
        if box.text.startswith(("r2 ", "r4 ")):
            box.click()
    window.press("Use on these")
    window.until(lambda: "roi_px" in files["r4"].read_text())
    assert "roi_px" in files["r2"].read_text()
    assert "roi_px" not in files["r3"].read_text()
    window.go("/recording?r=r4")
    window.until(lambda: window.all("[data-key=undo]:not([disabled])"))
    window.driver.execute_script("document.querySelector('[data-key=undo]').click()")
    window.until(lambda: "roi_px" not in files["r2"].read_text())
    window.until(lambda: files["r4"].read_text() == 'rig = "pile"\n')
    assert "roi_px" in files["r1"].read_text()


def test_files_dropped_with_the_mouse_are_taken(window, photo):
    """The browser's own drag-and-drop of a file, not an input field."""
    window.go("/")
    window.until(lambda: window.all("input[type=file]"))
    data = {"items": [], "files": [str(photo)], "dragOperationsMask": 1}
    for kind in ("dragEnter", *["dragOver"] * 3, "drop"):
        window.driver.execute_cdp_cmd(
            "Input.dispatchDragEvent",
            {"type": kind, "x": 400, "y": 500, "data": data},
        )
    angle = window.until(lambda: numbers(window, "repose angle"))
    assert angle == [pytest.approx(ANGLE, abs=0.1)]
    assert not window.troubles()


def test_the_keyboard_alone_opens_a_card_and_moves_the_base_line(window):
    """Tab to a card, Space; Tab to the tool and to the handle, arrow keys. What has the
    focus is outlined."""
    shutil.copytree(
        Path(__file__).parents[2] / "samples" / "drawn-bench" / "pile-heap",
        window.folder / "aaa-heap",
    )
    window.go("/")
    window.until(lambda: cards(window))
    tab_to(window, "e.matches('a.card-link') && e.href.includes('aaa-heap')")
    outline = "return getComputedStyle(document.activeElement).outlineStyle"
    assert window.driver.execute_script(outline) == "solid"
    window.keys(" ")
    window.until(lambda: "r=aaa-heap" in window.driver.current_url)
    window.until(lambda: numbers(window, "repose angle"))
    tab_to(window, "e.innerText.trim() === 'Base line'")
    window.keys("\ue007")
    window.until(lambda: window.all('[data-handle="base-left"]'))
    tab_to(window, "e.dataset.handle === 'base-left'")
    window.keys("\ue013" * 3)  # up
    window.until(lambda: len(numbers(window, "repose angle")) == 2)


def tab_to(window, condition: str) -> None:
    there = f"const e = document.activeElement || document.body; return {condition}"
    for _ in range(120):
        if window.driver.execute_script(there):
            return
        window.keys("\ue004")
    raise AssertionError(f"Tab does not reach what {condition} says")


def test_a_folder_of_benches_opens_with_all_of_them_and_makes_a_new_one(
    serve, tmp_path, window
):
    for name in ("one", "two"):
        readings(tmp_path / name, "drop-01")
    with serve(tmp_path) as address:
        window = Window(address, tmp_path, window.driver)
        window.until(lambda: "1 drop" in window.text())
        window.press("New bench")
        window.until(lambda: "say a name for the bench first" in window.text())
        window.type("name", "mung beans")
        window.press("New bench")
        window.until(lambda: "Nothing here yet" in window.text())
        assert (
            tomllib.loads((tmp_path / "mung beans" / "bench.toml").read_text())
            is not None
        )
        assert not window.troubles()
        window.open("about:blank")  # before the server is gone


class Elsewhere(http.server.BaseHTTPRequestHandler):
    """Another server, which notes what it was asked for."""

    asked: ClassVar[list[str]] = []

    def do_GET(self):
        self.asked.append(self.path)
        self.send_response(200)
        self.end_headers()

    def log_message(self, *_):
        pass


def test_a_report_draws_itself_and_reaches_nothing_elsewhere(window):
    """Whoever wrote it: no picture, no request, and the frame goes nowhere."""
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Elsewhere)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    away = f"http://127.0.0.1:{server.server_port}"
    results = window.folder / "results" / "calibrated"
    results.mkdir(parents=True, exist_ok=True)
    (results / "report.html").write_text(
        f"<p id=drawn></p><img src={away}/picture><script>"
        f"document.getElementById('drawn').textContent = 'drawn'; fetch('{away}/data')"
        f".catch(() => 0); setTimeout(() => {{ location = '{away}/page' }}, 500)"
        "</script>"
    )
    try:
        window.go("/bench?b=.&tab=Results&part=Calibration")
        frame = window.until(lambda: window.all("iframe"))[0]
        window.driver.switch_to.frame(frame)
        window.until(lambda: window.text("#drawn") == "drawn")
        window.driver.switch_to.default_content()
        time.sleep(2)
        assert Elsewhere.asked == []
        window.open(f"{away}/control")
        assert Elsewhere.asked[0] == "/control"
    finally:
        server.shutdown()
        (results / "report.html").unlink()
        window.driver.get_log("browser")  # it complains, as it should


def test_the_page_opens_from_a_file_and_no_other_server_gets_the_cookie(
    serve, tmp_path
):
    """As the command hands it to the browser: a strict cookie is sent all the same, and
    to no server on another port, neither by the number of this machine nor by its
    name."""
    heard = []

    class Listener(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            heard.append(self.headers.get("cookie"))
            self.send_response(200)
            self.end_headers()

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Listener)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    with serve(tmp_path / "bench", named=True) as address:
        file = tmp_path / "open.html"
        file.write_text(forwarding(address))
        window = Window(address.split("?")[0], tmp_path / "bench")
        try:
            assert "holds the key" in window.text()
            window.open(file.as_uri())
            window.until(lambda: "Nothing here yet" in window.text())
            assert "token" not in window.driver.current_url
            assert ".localhost" in window.driver.current_url
            assert len(window.driver.get_cookies()) >= 1  # the control
            for name in ("127.0.0.1", "localhost", "other.localhost"):
                window.open(f"http://{name}:{server.server_port}/")
        finally:
            window.driver.quit()
            server.shutdown()
    assert len(heard) >= 3 and not any(heard)
