"""Prints a report's page as PDF with a browser that is installed: the same page and its
print style sheet, no second layout."""

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from benchtwin.bench.exits import Misuse
from benchtwin.bench.whole_file import whole
from benchtwin.report.template import PAGE, PRINTED

BROWSERS = (
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "microsoft-edge",
    "chrome",
    "msedge",
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
    *(
        f"{os.environ[folder]}/{program}"
        for folder in ("PROGRAMFILES", "PROGRAMFILES(X86)", "LOCALAPPDATA")
        if folder in os.environ
        for program in (
            "Google/Chrome/Application/chrome.exe",
            "Microsoft/Edge/Application/msedge.exe",
        )
    ),
)
DRAWN_MS = 20_000  # of the page's own clock, until every figure is drawn
LONGEST_S = 180


def browser() -> str:
    """The program that prints. RuntimeError where none is installed."""
    for name in BROWSERS:
        if found := shutil.which(name):
            return found
    raise RuntimeError(
        "printing takes Chromium, Chrome or Edge, and none is installed: install one,"
        " or open the report in any browser and print it there"
    )


def page_of(results: Path) -> Path:
    """The page of a folder of results, or the page itself. Misuse without one."""
    page = results / PAGE if results.is_dir() else results
    if page.suffix != ".html" or not page.is_file():
        raise Misuse(f"{results}: no {PAGE} there; calibrate and diagnose make one")
    return page


def print_pdf(page: Path, out: Path) -> None:
    """Print `page` to `out`, which is replaced when the whole is there. RuntimeError
    when the browser fails."""
    with tempfile.TemporaryDirectory() as folder:
        printed = Path(folder) / PRINTED
        told = [
            "--headless",
            "--disable-gpu",
            "--window-size=760,1000",  # an A4 page's width, for which figures are drawn
            f"--virtual-time-budget={DRAWN_MS}",
            "--no-pdf-header-footer",
            f"--user-data-dir={folder}/profile",
            "--host-resolver-rules=MAP * ~NOTFOUND",  # a report needs no network
            f"--print-to-pdf={printed}",
        ]
        if getattr(os, "geteuid", lambda: 1)() == 0:
            told.append("--no-sandbox")  # Chromium has none for root
        try:
            done = subprocess.run(
                [browser(), *told, page.resolve().as_uri()],
                capture_output=True,
                text=True,
                errors="replace",
                timeout=LONGEST_S,
            )
        except subprocess.TimeoutExpired:
            raise RuntimeError(
                f"the browser did not print {page} within {LONGEST_S} s"
            ) from None
        if not printed.is_file():
            why = done.stderr.strip().splitlines()[-1:] or ["it said nothing"]
            raise RuntimeError(f"the browser did not print {page}: {why[0]}")
        with whole(out) as part:
            shutil.copyfile(printed, part)
