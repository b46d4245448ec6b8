"""What comes from others besides recordings: archives, results that a page shows, ids
and conditions on their way into tables; each a valid file and what reads it. fuzz.py
spoils them."""

import csv
import io
import json
import zipfile
from collections.abc import Callable
from pathlib import Path

from fuzz_files import RESULT, Reader
from measure_all import measure

from benchtwin.bench.exits import Misuse
from benchtwin.bench.outlets import FORMULA, NOT_SHOWN, NUMBER
from benchtwin.page import results
from benchtwin.page.folder import Refused
from benchtwin.report.pack import MANIFEST, pack
from benchtwin.report.unpack import unpack
from benchtwin.vision.results import Results

TEXTS = b"""rig = "drop"
id = "one"
session = "1"
provenance = "measured"
[drop]
height_mm = 100.0
[conditions]
moisture_pct = 12.5
plate = "steel"
self = 1
"""
DIAGNOSIS = {
    "rigs": {
        "drop": {
            "sentence": "air drag is missing (70 %)",
            "tone": "class",
            "matters": True,
            "next_record": "a drop from twice the height",
            "explanations": [{"effects": ["drag"], "probability": 0.7}],
        }
    }
}
ONES: dict[str, dict] = RESULT["parameters"]  # type: ignore[assignment]
TOLD = {"status": "calibrated", "remark": ""}
STATED = {name: one | TOLD for name, one in ONES.items()}
CALIBRATED = RESULT | {"parameters": STATED, "not_calibrated": {"pile": "no photo"}}
LEFT = {  # below results/, and how its cells are parted
    "calibrated/result.json": (json.dumps(CALIBRATED, indent=1).encode(), ":"),
    "diagnosed/diagnosis.json": (json.dumps(DIAGNOSIS, indent=1).encode(), ":"),
    "calibrated/tables/next_tests.csv": (
        b"pick,test,variance_left_after\n1,slide,0.6\n2,drop,0.4\n",
        ",",
    ),
    "measured/measurements.csv": (
        b"recording,quality,reason\na,failed,no impact\nb,good,\n",
        ",",
    ),
}


def outside() -> dict[str, Reader]:
    """Name of a file → the valid file and its reader."""
    made = {
        "recording.toml of ids and conditions": Reader(
            TEXTS, "=", written, {"readings.csv": b"rebound_height_mm\n30.0\n31.0\n"}
        ),
        "pack.zip": Reader(packed(), "", unpacked),
    }
    with zipfile.ZipFile(io.BytesIO(packed())) as held:
        inside = {name: held.read(name) for name in held.namelist()}
    manifest = inside.pop(MANIFEST)
    made[MANIFEST] = Reader(manifest, ":", lambda f: unpacked(f.parent), inside)
    for name, (content, parting) in LEFT.items():
        up = len(Path(name).parents) - 1
        made[name] = Reader(content, parting, shown(up))
    return made


def packed() -> bytes:
    """A pack of a bench of two files."""
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        (place / "bench" / "drop").mkdir(parents=True)
        (place / "bench" / "drop" / "recording.toml").write_bytes(TEXTS)
        pack(place / "bench", [], place / "pack.zip")
        return (place / "pack.zip").read_bytes()


def unpacked(file: Path) -> bool:
    """Whether a pack is refused, in one sentence that names it."""
    out = file.with_name(f"{file.name}-out")
    try:
        unpack(file, out)
    except Misuse as error:
        assert str(file) in str(error) and not out.exists()
        return True
    except OSError as error:
        assert error.strerror and not out.exists(), error
        return True
    assert all(p.resolve().is_relative_to(out.resolve()) for p in out.rglob("*"))
    return False


def written(file: Path) -> bool:
    """Measure a recording and write its tables, of which no cell may be a formula or
    move the cursor; whether nothing was measured."""
    left = Results(file.parent.parent / f"{file.parent.name}-out")
    try:
        for observation in measure(file.parent):
            left.add(observation)
        table = left.finish()
    finally:
        left.abandon()
    for tabled in left.out.glob("*.csv"):
        for row in csv.reader(io.StringIO(tabled.read_text("utf8"), newline="")):
            for one in row:
                assert not NOT_SHOWN.search(one), one
                assert not FORMULA.search(one) or NUMBER.fullmatch(one), one
        tabled.unlink()
    (left.out / "results.xlsx").unlink()
    left.out.rmdir()
    return bool((table["quality"] == "failed").all())


def shown(up: int) -> Callable[[Path], bool]:
    """What the page reads of results, `up` folders above the file; whether any of it
    was refused, in one sentence."""

    def read(file: Path) -> bool:
        try:
            results.next_recordings(file.parents[up])
        except Refused as error:
            assert "\n" not in str(error)
            return True
        return False

    return read
