"""The README's picture is composed from reports; the templates' own tags stand in for
those of `make demo`."""

import base64
import importlib.util
import json
import re
from pathlib import Path

import cv2
import numpy as np
import pytest

ROOT = Path(__file__).parent.parent
_spec = importlib.util.spec_from_file_location(
    "readme_picture", ROOT / "scripts" / "readme_picture.py"
)
program = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(program)


def tag(template: str, shade: int, said: str) -> str:
    """The template's <img>, filled with a picture of one shade."""
    text = (ROOT / "report" / template).read_text(encoding="utf8")
    (found,) = re.findall(r'<img src="data:image/png[^>]*>', text)
    png = base64.b64encode(
        cv2.imencode(".png", np.full((100, 200, 3), shade, np.uint8))[1].tobytes()
    ).decode()
    return re.sub(
        r"\{\{ title \}\}", said, re.sub(r"\{\{ (png|r\.picture) \}\}", png, found)
    )


@pytest.fixture
def demo(tmp_path):
    for name in ("calibrated", "diagnosed"):
        (tmp_path / name).mkdir()
    shown = [
        (10, "recorded: drop-01"),
        (20, "the twin"),
        (30, "recorded: pile-01"),
        (40, "the twin"),
    ]
    page = "".join(tag("page.html.j2", shade, said) for shade, said in shown)
    (tmp_path / "calibrated" / "report.html").write_text(page)
    (tmp_path / "diagnosed" / "report.html").write_text(
        tag("diagnosis.html.j2", 50, "")
    )
    roll = {"twin": {"change": "the level plate falls by 0.2° towards +x"}}
    (tmp_path / "diagnosed" / "diagnosis.json").write_text(
        json.dumps({"rigs": {"roll": roll}})
    )
    return tmp_path


def test_pile_twin_roll_and_drop_stand_where_their_titles_say(demo):
    picture = program.composed(demo)
    high, below = 300 + program.BAND, program.BAND + 150
    assert picture.shape == (2 * high, 2 * program.WIDE + program.GAP, 3)
    assert [
        int(picture[y, x, 0]) for x in (300, 900) for y in (below, high + below)
    ] == [30, 40, 50, 10]


def test_without_a_roll_that_was_run_again_it_says_so(demo):
    (demo / "diagnosed" / "diagnosis.json").write_text(
        '{"rigs": {"roll": {"twin": null}}}'
    )
    with pytest.raises(ValueError, match="no roll that was run again"):
        program.composed(demo)
