"""How fast the page answers: first paint, a dropped photo, a dragged base line on 12
megapixels, a bench of 100, memory with a film.

Needs Chromium with chromedriver.
"""

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import psutil
from PIL import Image
from synthetic.piles import PileScene, draw_pile

ROOT = Path(__file__).parent.parent
FRAMES = 5000


def main() -> None:
    argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    ).parse_args()
    browser, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if not (browser and driver):
        sys.exit("no Chromium with chromedriver on this machine")
    with tempfile.TemporaryDirectory() as folder:
        for what, took, unit in rows(Path(folder)):
            print(f"{what:50} {took:7.2f} {unit}", flush=True)


def rows(place: Path) -> Iterator[tuple[str, float, str]]:
    """What is timed, how long it took, and its unit."""
    large = draw(place / "heap.jpg")
    yield "opening an empty folder, first paint", timed(place / "0", first_paint), "s"
    took = timed(place / "one", dropped, large)
    yield "a photo of 12 megapixels dropped → its angle", took, "s"
    yield "base line dragged → new angle", timed(place / "one", dragged), "s"
    many, fifty = place / "many", place / "fifty"
    for n in range(100):
        for bench in (many, fifty)[: 1 + (n < 50)]:
            (bench / f"pile-{n:03d}").mkdir(parents=True)
            (bench / f"pile-{n:03d}" / "recording.toml").write_text('rig = "pile"\n')
            shutil.copy(large, bench / f"pile-{n:03d}")
    yield "a bench of 100 photos opened", timed(many, cards, 100), "s"
    yield "50 photos of 12 megapixels measured, `measure`", measured(fifty), "s"
    film = place / "film" / "drop-01"
    film.mkdir(parents=True)
    (film / "recording.toml").write_text('rig = "drop"\n')
    size_mb = draw_film(film / "film.mp4", FRAMES, (640, 480), noise=0) / 1e6
    took = timed(film.parent, film_open)
    yield f"memory, a film of 5,000 frames ({size_mb:.0f} MB) measured", took, "MB"
    large_film = place / "large" / "drop-01"
    large_film.mkdir(parents=True)
    (large_film / "recording.toml").write_text('rig = "drop"\n')
    size_mb = draw_film(large_film / "film.mp4", 600, (1920, 1080), noise=40) / 1e6
    took = timed(large_film.parent, first_frame)
    yield f"a film of {size_mb:.0f} MB opened → its first frame", took, "s"


def measured(bench: Path) -> float:
    """Seconds of `benchtwin measure` on a bench."""
    command = [sys.executable, "-m", "benchtwin", "measure", str(bench)]
    began = time.perf_counter()
    out = str(bench.with_name("measured"))
    subprocess.run([*command, "--out", out], check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - began


def draw(file: Path) -> Path:
    picture = draw_pile(
        PileScene(angle_deg=30, size=(4000, 3000), pile_height=900),
        np.random.default_rng(0),
    )
    Image.fromarray(picture).save(file, quality=92)
    return file


def draw_film(file: Path, frames: int, size: tuple[int, int], noise: int) -> int:
    """A falling ball; the file's bytes. noise: grey levels, which no coder packs."""
    rng, (width, height) = np.random.default_rng(0), size
    out = cv2.VideoWriter(str(file), cv2.VideoWriter.fourcc(*"mp4v"), 60, size)
    grain = rng.integers(0, noise + 1, (16, height, width, 3), dtype=np.uint8)
    for n in range(frames):
        frame = np.full((height, width, 3), 90, np.uint8) + grain[n % 16]
        at = (width // 2, int(60 + 0.01 * (n % 190) ** 2))
        cv2.circle(frame, at, 9, (220, 220, 230), -1)
        out.write(frame)
    out.release()
    return file.stat().st_size


class Served:
    """The page on a folder, and a browser window on it."""

    def __init__(self, folder: Path):
        from selenium import webdriver
        from selenium.webdriver.chrome.service import Service

        command = [
            sys.executable,
            "-m",
            "benchtwin",
            "page",
            str(folder),
            "--no-browser",
        ]
        self.server = subprocess.Popen(
            command, stdout=subprocess.PIPE, text=True, cwd=ROOT
        )
        assert self.server.stdout is not None
        said = ""
        while not (found := re.search(r"http://\S+token=\S+", said)):
            said += self.server.stdout.readline()
        self.address = re.sub(r"\w+\.localhost", "127.0.0.1", found[0])
        self.root = self.address.split("/?")[0]
        time.sleep(3)
        options = webdriver.ChromeOptions()
        for argument in (
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--window-size=1280,900",
        ):
            options.add_argument(argument)
        self.driver = webdriver.Chrome(
            options=options, service=Service(shutil.which("chromedriver"))
        )

    def until(self, script: str, seconds: float = 60.0) -> float:
        """Seconds until the script gives something true."""
        began = time.perf_counter()
        while not self.driver.execute_script(f"return {script}"):
            if time.perf_counter() - began > seconds:
                raise TimeoutError(script)
            time.sleep(0.01)
        return time.perf_counter() - began

    def close(self) -> None:
        self.driver.quit()
        self.server.terminate()
        self.server.wait()


def timed(folder: Path, what, *arguments) -> float:
    served = Served(folder)
    try:
        return what(served, *arguments)
    finally:
        served.close()


def first_paint(served: Served) -> float:
    served.driver.get(served.address)
    served.until("document.body && document.body.innerText.includes('Nothing here')")
    painted = "performance.getEntriesByName('first-contentful-paint')"
    served.until(f"{painted}.length > 0")
    return served.driver.execute_script(f"return {painted}[0].startTime") / 1000


NUMBERS = "(document.querySelector('.numbers') || {innerText: ''}).innerText"


def dropped(served: Served, photo: Path) -> float:
    served.driver.get(served.address)
    served.until("document.querySelector('input[type=file]') !== null")
    entry = served.driver.find_element("css selector", "input[type=file]")
    served.driver.execute_script("arguments[0].style.display = 'block'", entry)
    entry.send_keys(str(photo))
    return served.until(f"{NUMBERS}.includes('repose angle')")


def dragged(served: Served) -> float:
    from selenium.webdriver import ActionChains

    served.driver.get(served.address)
    served.driver.get(served.root + "/recording?r=pile-01")
    served.until(f"{NUMBERS}.includes('repose angle')")
    served.driver.execute_script(
        "[...document.querySelectorAll('button')].find(b => b.innerText == 'Base"
        " line').click()"
    )
    took = []
    for shift in (-10, 6, -4, 8, -6):
        served.until("document.querySelector('[data-handle=base-left]') !== null")
        before = served.driver.execute_script(f"return {NUMBERS}")
        handle = served.driver.find_element("css selector", "[data-handle=base-left]")
        ActionChains(served.driver, duration=20).move_to_element(
            handle
        ).click_and_hold().move_by_offset(0, shift).release().perform()
        took.append(served.until(f"{NUMBERS} != {before!r}"))
        time.sleep(1)
    return float(
        np.median(took[1:])
    )  # the first one also measures without corrections, to stand beside


def cards(served: Served, count: int) -> float:
    began = time.perf_counter()
    served.driver.get(served.address)
    served.until(
        f"document.querySelectorAll('.thumb').length == {count} &&"
        " document.querySelector('.thumb').complete"
    )
    return time.perf_counter() - began


def first_frame(served: Served) -> float:
    served.driver.get(served.address)
    served.until("document.querySelector('.thumb, .card, a') !== null")
    began = time.perf_counter()
    served.driver.get(served.root + "/recording?r=drop-01")
    served.until("document.querySelector('.look image') !== null")
    return time.perf_counter() - began


def film_open(served: Served) -> float:
    served.driver.get(served.address)
    served.driver.get(served.root + "/recording?r=drop-01")
    served.until("document.querySelector('.look image') !== null")
    served.until("!document.body.innerText.includes('measuring')", 300)
    process = psutil.Process(served.server.pid)
    return process.memory_info().rss / 1e6


if __name__ == "__main__":
    main()
