"""The page in Firefox: a photo is measured, its base line dragged, an impact struck out
by click and by key.

Firefox is driven by its own Marionette protocol: length-prefixed JSON over a socket.
Skipped where there is no Firefox."""

import json
import shutil
import socket
import subprocess
import time
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from synthetic.piles import PileScene, draw_pile

BROWSER = next(filter(None, map(shutil.which, ("firefox", "firefox-esr"))), None)
pytestmark = pytest.mark.skipif(not BROWSER, reason="no Firefox on this machine")
NUMBERS = """return [...document.querySelectorAll('.numbers tr')]
    .map(r => r.innerText.replace(/\\s+/g, ' '))
    .find(t => t.startsWith(arguments[0])) || ''"""
MIDDLE = """const found = [...document.querySelectorAll(arguments[0])];
    const r = found.at(-1).getBoundingClientRect();
    return [r.x + r.width / 2, r.y + r.height / 2]"""
# the name of an element's reference in the WebDriver protocol
ELEMENT = "element-6066-11e4-a52e-4f735466cecf"


class Firefox:
    """A headless window with an empty profile."""

    def __init__(self, profile: Path):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        (profile / "user.js").write_text(
            'user_pref("marionette.port",'
            f' {port});\nuser_pref("browser.shell.checkDefaultBrowser", false);\n'
        )
        command = [
            str(BROWSER),
            "--headless",
            "--marionette",
            "--no-remote",
            "--profile",
            str(profile),
        ]
        self.process = subprocess.Popen(
            command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        self.number, end = 0, time.time() + 60
        while True:
            try:
                self.stream = socket.create_connection(("127.0.0.1", port), timeout=60)
                break
            except OSError:
                assert time.time() < end and self.process.poll() is None, (
                    "Firefox does not start"
                )
                time.sleep(0.2)
        self._read()  # its greeting
        self.ask("WebDriver:NewSession", {"capabilities": {}})
        self.ask("WebDriver:SetWindowRect", {"width": 1280, "height": 900})

    def ask(self, command: str, parameters: dict) -> Any:
        """What Firefox answers; AssertionError with its words where it refuses."""
        self.number += 1
        message = json.dumps([0, self.number, command, parameters]).encode()
        self.stream.sendall(f"{len(message)}:".encode() + message)
        _, _, error, result = self._read()
        assert error is None, error
        return result

    def _read(self) -> Any:
        length = b""
        while (one := self.stream.recv(1)) != b":":
            length += one
        data = b""
        while len(data) < int(length):
            data += self.stream.recv(int(length) - len(data))
        return json.loads(data)

    def go(self, address: str) -> None:
        self.ask("WebDriver:Navigate", {"url": address})

    def run(self, script: str, *arguments: Any) -> Any:
        return self.ask(
            "WebDriver:ExecuteScript", {"script": script, "args": list(arguments)}
        )["value"]

    def until(self, script: str, *arguments: Any, seconds: float = 60.0) -> Any:
        end = time.time() + seconds
        while not (found := self.run(script, *arguments)):
            assert time.time() < end, (
                f"{script}: not within {seconds} s; the page"
                f" says:\n{self.run('return document.body.innerText')}"
            )
            time.sleep(0.1)
        return found

    def element(self, selector: str) -> str:
        return self.ask(
            "WebDriver:FindElement", {"using": "css selector", "value": selector}
        )["value"][ELEMENT]

    def type(self, selector: str, text: str) -> None:
        self.ask(
            "WebDriver:ElementSendKeys", {"id": self.element(selector), "text": text}
        )

    def press(self, label: str) -> None:
        find = (
            "[...document.querySelectorAll('button')].find(b => b.innerText.trim() =="
            " arguments[0])"
        )
        self.until(f"return !!{find}", label)
        self.run(f"{find}.click()", label)

    def pointer(self, *moves: dict) -> None:
        actions = [
            {
                "type": "pointer",
                "id": "mouse",
                "parameters": {"pointerType": "mouse"},
                "actions": list(moves),
            }
        ]
        self.ask("WebDriver:PerformActions", {"actions": actions})

    def close(self) -> None:
        self.process.terminate()
        self.process.wait(20)


DOWN, UP = {"type": "pointerDown", "button": 0}, {"type": "pointerUp", "button": 0}


def to(x: float, y: float) -> dict:
    return {"type": "pointerMove", "x": round(x), "y": round(y), "duration": 30}


@pytest.fixture(scope="module")
def window(serve, tmp_path_factory):
    folder = tmp_path_factory.mktemp("served") / "bench"
    with serve(folder) as address:
        opened = Firefox(tmp_path_factory.mktemp("profile"))
        try:
            opened.go(address)
            yield opened, folder, address.split("/?")[0]
        finally:
            opened.close()


def middle(window: Firefox, selector: str) -> tuple[float, float]:
    """Of the last element that the selector finds."""
    window.until("return !!document.querySelector(arguments[0])", selector)
    x, y = window.run(MIDDLE, selector)
    return x, y


def test_a_photo_is_measured_and_its_base_line_dragged(window, tmp_path):
    firefox, folder, _ = window
    picture = draw_pile(
        PileScene(angle_deg=30, size=(900, 600), pile_height=180),
        np.random.default_rng(0),
    )
    Image.fromarray(picture).save(tmp_path / "heap.png")
    firefox.until("return !!document.querySelector('input[type=file]')")
    firefox.run("document.querySelector('input[type=file]').style.display = 'block'")
    firefox.type("input[type=file]", str(tmp_path / "heap.png"))
    assert "30.0" in firefox.until(NUMBERS, "repose angle")
    firefox.press("Base line")
    x, y = middle(firefox, "[data-handle=base-left]")
    firefox.pointer(to(x, y), DOWN, to(x, y - 12), UP)
    firefox.until(
        "return document.querySelector('.numbers').innerText.includes('corrected')"
    )
    assert (
        len(
            tomllib.loads((folder / "pile-01" / "recording.toml").read_text())["pile"][
                "baseline_px"
            ]
        )
        == 4
    )


def test_a_dropped_file_is_taken_and_the_address_follows_the_tab(window, tmp_path):
    """A drop event with a file in it; then a tab, and back."""
    firefox, folder, root = window
    firefox.go(f"{root}/")
    firefox.until("return !!document.querySelector('[data-bench]')")
    firefox.run(
        """const data = new DataTransfer();
        const rows = 'rebound_height_mm\\n70\\n72\\n71\\n';
        const how = {bubbles: true, cancelable: true, dataTransfer: data};
        data.items.add(new File([rows], 'dropped.csv'));
        for (const kind of ['dragover', 'drop'])
            document.body.dispatchEvent(new DragEvent(kind, how))"""
    )
    firefox.until("return location.pathname == '/recording'")
    assert (folder / "dropped" / "readings.csv").read_text().endswith("71\n")
    firefox.go(f"{root}/")
    firefox.until("return !!document.querySelector('.tabs a')")
    firefox.run("[...document.querySelectorAll('.tabs a')][2].click()")
    firefox.until("return location.search.includes('tab=Run')")
    firefox.ask("WebDriver:Refresh", {})
    current = (
        "return document.querySelector('.tabs a[aria-current]').innerText =="
        " arguments[0]"
    )
    firefox.until(current, "Run")
    firefox.ask("WebDriver:Back", {})
    firefox.until(current, "Recordings")


def test_impacts_are_struck_out_by_click_and_by_key(window):
    firefox, folder, root = window
    sample = Path(__file__).parents[2] / "samples" / "heard-drop" / "drop-01"
    shutil.copytree(sample, folder / "heard")
    (folder / "heard" / "recording.toml").write_text(
        'rig = "drop"\n[drop]\nheight_mm = 310\n'
    )
    firefox.go(f"{root}/recording?r=heard")
    firefox.until("return document.querySelectorAll('[data-impact]').length == 5")
    x, y = middle(firefox, "[data-impact]")
    firefox.pointer(to(x, y), DOWN, UP)
    firefox.until("return document.querySelectorAll('[data-impact]').length == 4")
    firefox.run("document.querySelector('.wave').focus()")
    firefox.type(
        ".wave", "\ue012\ue014\ue014"
    )  # left does nothing at the beginning; the second sudden sound
    firefox.type(".wave", "\ue007")
    firefox.until("return document.querySelectorAll('.impact.added').length == 1")
    keys = tomllib.loads((folder / "heard" / "recording.toml").read_text())["drop"]
    assert len(keys["impacts_struck_s"]) == len(keys["impacts_added_s"]) == 1
