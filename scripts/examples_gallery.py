"""Writes docs/examples.md from the scripts in samples/examples, and their pictures.

python scripts/examples_gallery.py             the page, from docstrings and code
python scripts/examples_gallery.py --pictures  and what each script shows, drawn anew:
                                               some minutes, and Chromium is needed
"""

import argparse
import ast
import runpy
import shutil
import subprocess
import tempfile
from itertools import pairwise
from pathlib import Path

import numpy as np
from PIL import Image
from plotly.graph_objects import Figure
from plotly.offline import get_plotlyjs

ROOT = Path(__file__).parents[1]
SCRIPTS = ROOT / "samples" / "examples"
OUT = ROOT / "docs" / "examples.md"
PICTURES = ROOT / "docs" / "examples"
WIDTH_PX, HEIGHT_PX = 640, 400
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
GROUPS = {
    "Measuring": (
        "measure_a_photo",
        "base_line_by_hand",
        "doubtful_numbers",
        "repeats_and_their_mean",
        "readings_only",
        "restitution_from_sound",
        "light_gates",
        "damp_slides",
        "audit_a_bench",
    ),
    "Simulating": (
        "simulate_and_film",
        "block_on_incline",
        "ball_on_incline",
        "two_hundred_seeds",
        "a_lot_that_scatters",
        "clump_from_a_mesh",
        "own_force_law",
        "resumed_after_a_stop",
        "lammps_beside_ours",
    ),
    "Calibrating and predicting": (
        "paper_tables",
        "valley_of_one_angle",
        "what_a_second_rig_narrows",
        "rolling_conventions",
        "export_to_engines",
        "predict_a_drum",
    ),
    "Diagnosing": ("concealed_drag", "uneven_plate"),
    "Whether intervals are right": ("coverage_of_intervals", "correlated_noise"),
}
HEAD = """# Examples

One idea each, in 20 to 60 lines, with the picture that the script makes. They lie in
`samples/examples/`, run in the folder that holds `samples/`, and take seconds; the
first run of a rig compiles the engine, which takes 10 to 20 seconds. A test runs each
and checks one number of it against a closed form, a drawn truth or the paper. This
page is written by `scripts/examples_gallery.py`.
"""


def page() -> str:
    """The page as Markdown."""
    parts = [HEAD]
    for group, names in GROUPS.items():
        parts.append(f"## {group}\n")
        parts += [_entry(name) for name in names]
    return "\n".join(parts)


def _entry(name: str) -> str:
    """A script: its title, what it shows and why, its picture, its code."""
    source = (SCRIPTS / f"{name}.py").read_text(encoding="utf8")
    tree = ast.parse(source)
    title, _, text = (ast.get_docstring(tree) or "").partition("\n")
    code = "\n".join(source.splitlines()[tree.body[0].end_lineno :]).strip()
    picture = f"![{title}](examples/{name}.webp)\n"
    return (
        f"### {title.rstrip('.')}\n\n{text.strip()}\n\n"
        f"{picture if (PICTURES / f'{name}.webp').is_file() else ''}\n"
        f'```python title="samples/examples/{name}.py"\n{code}\n```\n'
    )


def draw(names: list[str]) -> None:
    """Run the scripts, and write what each leaves as `picture`."""
    PICTURES.mkdir(exist_ok=True)
    figures: dict[str, Figure] = {}
    for name in names:
        shown = runpy.run_path(str(SCRIPTS / f"{name}.py"), run_name="__main__")[
            "picture"
        ]
        if isinstance(shown, np.ndarray):
            _write(Image.fromarray(shown), name)
        else:
            figures[name] = shown
    shots = photographed(list(figures.values())) if figures else []
    for name, shot in zip(figures, shots, strict=True):
        _write(shot, name)


def photographed(figures: list[Figure]) -> list[Image.Image]:
    """Figures as a browser draws them, all on one page. FileNotFoundError without a
    browser."""
    browser = next((path for b in BROWSERS if (path := shutil.which(b))), None)
    if browser is None:
        raise FileNotFoundError(f"no browser: one of {', '.join(BROWSERS)} is needed")
    divs, ends = "", [0]
    for figure in figures:
        height = figure.layout.height or HEIGHT_PX
        look = {"width": WIDTH_PX, "height": height, "font_size": 11}
        figure.update_layout(template="plotly_white", **look)
        if figure.layout.margin.t is None:
            figure.update_layout(margin={"l": 60, "r": 20, "t": 30, "b": 50})
        drawn = figure.to_html(
            {"displayModeBar": False}, include_plotlyjs=False, full_html=False
        )
        divs += f'<div style="width:{WIDTH_PX}px;height:{height}px">{drawn}</div>'
        ends.append(ends[-1] + height)
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        (place / "page.html").write_text(
            f'<meta charset="utf8"><script>{get_plotlyjs()}</script>'
            f'<body style="margin:0">{divs}</body>',
            encoding="utf8",
        )
        asked = [
            browser,
            "--headless",
            "--no-sandbox",
            "--hide-scrollbars",
            "--virtual-time-budget=60000",
            f"--window-size={WIDTH_PX},{ends[-1]}",
            f"--screenshot={place / 'page.png'}",
            (place / "page.html").as_uri(),
        ]
        subprocess.run(asked, check=True, capture_output=True)
        with Image.open(place / "page.png") as whole:
            return [
                whole.crop((0, top, WIDTH_PX, end)).copy()
                for top, end in pairwise(ends)
            ]


def _write(picture: Image.Image, name: str) -> None:
    """A picture of at most WIDTH_PX."""
    picture = picture.convert("RGB")
    picture.thumbnail((WIDTH_PX, 2 * WIDTH_PX))
    picture.save(PICTURES / f"{name}.webp", quality=75, method=6)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--pictures", action="store_true", help="draw them anew")
    parser.add_argument("names", nargs="*", help="of scripts whose pictures to draw")
    chosen = parser.parse_args()
    if chosen.pictures:
        draw(chosen.names or [name for names in GROUPS.values() for name in names])
    OUT.write_text(page(), encoding="utf8")
