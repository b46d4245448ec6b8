"""A valid file for every reader of benchtwin, and the call that reads it; fuzz.py
spoils these files."""

import io
import json
import os
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any
from unittest import mock

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import av
import numpy as np
from measure_all import measure
from PIL import Image

from benchtwin.calibrate.export import ENGINES, cards, read_result
from benchtwin.calibrate.procedure import from_tables, joint, steel
from benchtwin.calibrate.procedure.bench import Bench, bench_of
from benchtwin.calibrate.procedure.tables import naming
from benchtwin.vision.evidence.photo import read_photo
from benchtwin.vision.evidence.read_keys import read_toml
from benchtwin.vision.import_command import import_command
from benchtwin.vision.measurement import FAILED

SAMPLES = Path(__file__).parent.parent / "samples"


ROLL = b"""rig = "roll"
seed = {length_mm = 7.5, width_mm = 7.1, density_kg_m3 = 1250.0}
camera = {fps = 200.0, mm_per_px = 0.25}
roll = {incline_deg = 15.0, incline_length_mm = 20.0}
"""


@dataclass(frozen=True)
class Reader:
    """A valid file (bytes), the separator of its cells, and its reader: `read(file)`
    raises what a user would see."""

    valid: bytes
    parting: str
    read: Callable[[Path], object]
    others: dict[str, bytes] | None = None  # files beside it


def nothing_measured(path: Path) -> bool:
    """Measure the path; whether every quantity failed, none of them by a fault of
    benchtwin."""
    quantities = [
        quantity for observation in measure(path) for quantity in observation.quantities
    ]
    faults = [
        quantity.reason
        for quantity in quantities
        if "a fault of benchtwin" in quantity.reason
    ]
    assert not faults, faults
    return all(quantity.quality == FAILED for quantity in quantities)


def folder_unmeasured(file: Path) -> bool:
    """The same of the recording's folder."""
    return nothing_measured(file.parent)


def exported(file: Path) -> None:
    for engine in ENGINES:
        cards(read_result(file.parent), engine)


@cache
def paper_bench(trimmed: tuple[tuple[str, int], ...]) -> Bench:
    return bench_of(SAMPLES / "soybean-paper", dict(trimmed))


def calibrate_tables_beside(file: Path) -> bool:
    """Calibrate the paper's bench on the tables beside `file`, with a posterior of a
    few draws; whether any rig was refused. A refusal names a table and has words of
    ours."""
    few = mock.patch.multiple(
        joint, sample=partial(joint.sample, max_steps=4), GRID_CELLS=400
    )
    with (
        few,
        mock.patch.object(steel, "GRID_CELLS", 400),
        mock.patch.multiple(
            from_tables,
            bench_of=lambda _, trimmed: paper_bench(tuple(trimmed.items())),
            naming=naming_in_our_words,
        ),
    ):
        found = from_tables.calibrate_tables(file.parent.parent)
    for why in found.refused.values():
        assert str(file.parent) in why, f"the table is not named: {why}"
    return bool(found.refused)


@contextmanager
def naming_in_our_words(file: Path) -> Iterator[None]:
    with naming(file):
        try:
            yield
        except ValueError as error:
            assert "calibrate" in error_place(error), f"not our words: {error!r}"
            raise


def track(rig: str) -> Reader:
    folder = SAMPLES / "drawn-bench" / f"{rig}-track"
    lines = (folder / "track.csv").read_bytes().splitlines()
    few = b"\n".join([lines[0], *lines[1 :: max(1, len(lines) // 150)]])
    return Reader(
        few,
        ",",
        folder_unmeasured,
        {"recording.toml": (folder / "recording.toml").read_bytes()},
    )


def heard(name: str) -> Reader:
    file = next((SAMPLES / "heard-drop" / name).glob("sound.*"))
    return Reader(
        file.read_bytes(), "", folder_unmeasured, {"recording.toml": b'rig = "drop"\n'}
    )


def clicks(form: str) -> Reader:
    """A ball that bounces four times, as "wav" or "flac"."""
    sound = np.random.default_rng(0).normal(0, 30, 12_000)
    ring = 15_000 * np.exp(-np.arange(80) / 12) * np.sin(np.arange(80) * 1.9)
    for at in (2000, 4800, 6760, 8132):
        sound[at : at + 80] += ring
    with av.open(file := io.BytesIO(), "w", format=form) as out:
        stream: Any = out.add_stream(
            {"wav": "pcm_s16le", "flac": "flac"}[form], rate=8000, layout="mono"
        )
        block = av.AudioFrame.from_ndarray(
            sound.astype("<i2")[None], format="s16", layout="mono"
        )
        block.sample_rate = 8000
        out.mux([*stream.encode(block), *stream.encode(None)])
    return Reader(
        file.getvalue(), "", folder_unmeasured, {"recording.toml": b'rig = "drop"\n'}
    )


def import_other_tool(file: Path) -> bool:
    """A file of another tool, measured as it is and imported as a bench; whether
    neither could be."""
    refused = nothing_measured(file)
    with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()) as said:
        code = import_command(
            [file], file.parent / "bench", "", None, overwrite=False, quiet=False
        )
    assert code == 0 or str(file.parent) in said.getvalue(), (
        f"the file is not named: {said.getvalue()}"
    )
    for toml in (file.parent / "bench").rglob("*.toml"):
        read_toml(toml)
    return refused and code != 0


def other_tools_files() -> dict[str, tuple[bytes, str]]:
    """A small file as each tool writes it, of a ball that bounces, and what parts its
    cells."""
    t = np.arange(0, 0.9, 1 / 60)
    high = np.where(
        t < 0.319, 0.5 - 4.9 * t**2, 2.5 * (t - 0.319) - 4.9 * (t - 0.319) ** 2
    )
    places = [
        (k, f"{s:.5f}", f"{100 + 20 * s:.3f}", f"{400 - 600 * y:.3f}", f"{y:.5f}")
        for k, (s, y) in enumerate(zip(t, high))
    ]
    frames = "".join(
        f'<property name="[{k}]" type="object"><object'
        f' class="PointMass$FrameData">\n<property name="x">{x}</property>\n<property'
        f' name="y">{y}</property></object></property>\n'
        for k, _, x, y, _ in places
    )
    trk = TRK.replace("FRAMES", frames).encode()
    spots = "".join(
        f"ID{k},{k},0,7.5,{x},{y},0,{s},{k},2.5\n" for k, s, x, y, _ in places
    )
    detections = "".join(
        f'<detection t="{k}" x="{x}" y="{y}" z="0.0" />\n' for k, _, x, y, _ in places
    )
    events = "Event time (s),Interval (s)\n1.0,0.51\n1.51,0.41\n1.92,0.33\n2.25,0\n"
    clock = "property,value\nSTART,0.0\n"
    tilt = "".join(
        f"{k / 20},{np.sin(a):.5f},0.001,{np.cos(a):.5f}\n"
        for k, a in enumerate(np.radians(np.linspace(0, 25, 80)))
    )
    points = "".join(
        f"<TrackPoint>{x};{y};{1502 * k}</TrackPoint>\n" for k, _, x, y, _ in places
    )
    repeats = "Experiment 1\nZeit;Versuch 1;Versuch 2\ns;m;m\n" + "".join(
        f"{s};{y};{y}\n".replace(".", ",") for _, s, _, _, y in places
    )
    wave = "sample rate 8000 Hz\n" + "".join(
        f"{np.sin(k) * np.exp(-(k % 400) / 30):.4f}\n" for k in range(1200)
    )
    return {
        "drop.trk": (trk, ">"),
        "repeats.csv": (repeats.encode(), ";"),
        "bare.txt": ("".join(f"{s} {y}\n" for _, s, _, _, y in places).encode(), " "),
        "wave.txt": (wave.encode(), "\n"),
        "drop.trz": (zipped({"a/drop.trk": trk, "video.mp4": b"\0" * 50}), ""),
        "export.txt": (
            (
                "\tmass A\t\nt\tx\ty\n"
                + "".join(f"{s}\t0.1\t{y}\n" for _, s, _, _, y in places)
            )
            .replace(".", ",")
            .encode(),
            "\t",
        ),
        "manual.xls": (
            (
                " \tTrack n°\tSlice n°\tX\tY\tDistance\tVelocity\tPixel Value\n"
                + "".join(
                    f"{k + 1}\t1\t{k + 1}\t{x}\t{y}\t{k}.5\t1\t230\n"
                    for k, _, x, y, _ in places
                )
            ).encode(),
            "\t",
        ),
        "spots.csv": (
            (
                "LABEL,ID,TRACK_ID,QUALITY,POSITION_X,POSITION_Y,POSITION_Z,POSITION_T,FRAME,RADIUS\nLabel,Spot"
                " ID\nLabel,Spot"
                " ID\n,,,(quality),(pixel),(pixel),(pixel),(sec),,(pixel)\n" + spots
            ).encode(),
            ",",
        ),
        "tracks.xml": (
            '<?xml version="1.0"?>\n<Tracks spaceUnits="pixel" frameInterval="1.0"'
            ' timeUnits="sec" from="TrackMate">\n<particle'
            f' nSpots="9">\n{detections}</particle></Tracks>'.encode(),
            '"',
        ),
        "drop.mdf": (
            (
                "MTrackJ 1.5.1 Data File\nAssembly 1\nCluster 1\nTrack 1\n"
                + "".join(
                    f"Point {k + 1} {x} {y} 1.0 {k + 1}.0 1.0\n"
                    for k, _, x, y, _ in places
                )
            ).encode(),
            " ",
        ),
        "events.csv": (events.encode(), ","),
        "events.zip": (
            zipped({"All.csv": events.encode(), "meta/time.csv": clock.encode()}),
            "",
        ),
        "events.xlsx": (
            workbook(
                {
                    "All": EVENTS,
                    "Metadata Time": (
                        "<row><c t='inlineStr'><is><t>event</t></is></c></row>"
                    ),
                }
            ),
            "",
        ),
        "plate.csv": (("time (s),ax (g),ay (g),az (g)\n" + tilt).encode(), ","),
        "kinovea.csv": (
            (
                '"Time","ball/0/X","ball/0/Y"\n'
                + "".join(f'"{s}","0.1","{y}"\n' for _, s, _, _, y in places)
            ).encode(),
            ",",
        ),
        "kinovea.txt": (
            (
                "#Kinovea Trajectory data export\n#T X Y\n"
                + "".join(f"0:00:00:{k % 60:02d} 0.1 {y}\n" for k, _, _, _, y in places)
            ).encode(),
            " ",
        ),
        "drop.kva": (
            (
                "<KinoveaVideoAnalysis>\n<AverageTimeStampsPerFrame>1502</AverageTimeStampsPerFrame>\n<CaptureFramerate>60"
                "</CaptureFramerate>\n<Calibration><CalibrationLine><Length>5</Length><Segment><A>1;2</A><B>30;2</B></Segment>"
                "</CalibrationLine>\n<Unit>Centimeters</Unit></Calibration>\n<Tracks><Track"
                f" name='b'><TrackPointList>\n{points}"
                "</TrackPointList></Track></Tracks></KinoveaVideoAnalysis>"
            ).encode(),
            "<",
        ),
    }


def workbook(sheets: dict[str, str]) -> bytes:
    """An .xlsx of these sheets, by name: the least that the format wants."""
    kind = "http://schemas.openxmlformats.org"
    numbered = list(enumerate(sheets, 1))
    listed = "".join(
        f'<sheet name="{n}" sheetId="{k}" r:id="r{k}"/>' for k, n in numbered
    )
    related = "".join(
        f'<Relationship Id="r{k}"'
        f' Type="{kind}/officeDocument/2006/relationships/worksheet"'
        f' Target="worksheets/sheet{k}.xml"/>'
        for k, _ in numbered
    )
    return zipped(
        {
            "_rels/.rels": (
                "<Relationships"
                f' xmlns="{kind}/package/2006/relationships"><Relationship Id="r0"'
                f' Type="{kind}/officeDocument/2006/relationships/officeDocument"'
                ' Target="xl/workbook.xml"/></Relationships>'.encode()
            ),
            "xl/workbook.xml": (
                f'<workbook xmlns="{kind}/spreadsheetml/2006/main"'
                f' xmlns:r="{kind}/officeDocument/2006/relationships">'
                f"<sheets>{listed}</sheets></workbook>".encode()
            ),
            "xl/_rels/workbook.xml.rels": (
                f'<Relationships xmlns="{kind}/package/2006/relationships">{related}'
                "</Relationships>".encode()
            ),
            **{
                f"xl/worksheets/sheet{k}.xml": (
                    "<worksheet"
                    f' xmlns="{kind}/spreadsheetml/2006/main">'
                    f"<sheetData>{sheets[n]}</sheetData>"
                    "</worksheet>".encode()
                )
                for k, n in numbered
            },
        }
    )


EVENTS = (
    "<row><c t='inlineStr'><is><t>Event (s)</t></is></c><c"
    " t='inlineStr'><is><t>Interval (s)</t></is></c></row>"
    + "".join(
        f"<row><c><v>{a}</v></c><c><v>{b}</v></c></row>"
        for a, b in ((1.0, 0.51), (1.51, 0.41), (1.92, 0.33), (2.25, 0))
    )
)


def zipped(members: dict[str, bytes]) -> bytes:
    with zipfile.ZipFile(out := io.BytesIO(), "w", zipfile.ZIP_DEFLATED) as packed:
        for name, content in members.items():
            packed.writestr(name, content)
    return out.getvalue()


TRK = """<?xml version="1.0" encoding="UTF-8"?>
<object class="org.opensourcephysics.cabrillo.tracker.TrackerPanel">
<property name="clipcontrol"><object>\
<property name="delta_t" type="double">16.6667</property></object></property>
<property name="coords"><object><property name="framedata"><property name="[0]"><object>
<property name="xorigin">320.0</property>
<property name="yorigin">430.0</property>
<property name="angle">0.5</property>
<property name="xscale">600.0</property>
<property name="yscale">600.0</property>
</object></property></property></object></property>
<property name="length_unit">m</property>
<property name="tracks">\
<property name="item"><object class="tracker.TapeMeasure"></object></property>
<property name="item"><object class="tracker.PointMass">\
<property name="name">A</property>
<property name="framedata">FRAMES</property></object></property></property>
</object>
"""


def gates(rig: str, table: str, more: str) -> Reader:
    seed = "[seed]\nlength_mm = 15\nwidth_mm = 15\nthickness_mm = 15\n"
    return Reader(
        table.encode(),
        ",",
        folder_unmeasured,
        {"recording.toml": f'rig = "{rig}"\n{seed}{more}'.encode()},
    )


def photo(suffix: str, *, deep: bool = False) -> Reader:
    ramp = np.add.outer(np.arange(60), np.arange(80)) * (400 if deep else 1)
    file = io.BytesIO()
    Image.fromarray(ramp.astype(np.uint16 if deep else np.uint8)).save(file, suffix)
    return Reader(file.getvalue(), "", read_photo)


def readers() -> dict[str, Reader]:
    drawn, paper = SAMPLES / "drawn-bench", SAMPLES / "soybean-paper"
    tables = {f"tables/{f.name}": f.read_bytes() for f in (paper / "tables").iterdir()}
    few = {"track.csv": track("drop").valid}
    made = {
        "track.csv": track("drop"),
        "track.csv of a slide": track("slide"),
        "track.csv of a roll": Reader(
            (SAMPLES / "soybean-bench/roll-01/track.csv").read_bytes(),
            ",",
            folder_unmeasured,
            {"recording.toml": ROLL},
        ),
        **{name: gates(*about) for name, about in GATES.items()},
        "track.csv of few rows": Reader(
            FEW, ",", folder_unmeasured, {"recording.toml": b'rig = "drop"\n'}
        ),
        "impacts.csv": Reader(
            (drawn / "drop-heard/impacts.csv").read_bytes(),
            ",",
            folder_unmeasured,
            {"recording.toml": (drawn / "drop-heard/recording.toml").read_bytes()},
        ),
        "readings.csv": Reader(
            (paper / "drop/readings.csv").read_bytes(),
            ",",
            folder_unmeasured,
            {"recording.toml": (paper / "drop/recording.toml").read_bytes()},
        ),
        "recording.toml": Reader(
            (drawn / "drop-track/recording.toml").read_bytes(),
            "=",
            folder_unmeasured,
            few,
        ),
        "bench.toml": Reader(
            (drawn / "bench.toml").read_bytes(),
            "=",
            folder_unmeasured,
            {
                "drop/recording.toml": b'rig = "drop"\n',
                "drop/track.csv": few["track.csv"],
            },
        ),
        "impacts.csv of known sd": Reader(
            b"t_s,sd_s\n0.27,1e-4\n0.55,1e-4\n0.70,2e-4\n0.79,1e-4\n",
            ",",
            folder_unmeasured,
            {"recording.toml": (drawn / "drop-heard/recording.toml").read_bytes()},
        ),
        "sound.wav": clicks("wav"),
        "sound.flac": clicks("flac"),
        "sound.ogg": heard("drop-01"),
        "sound.mp3": heard("drop-02"),
        "sound.m4a": heard("drop-03"),
        "photo.png": photo("png"),
        "deep.png": photo("png", deep=True),
        "photo.jpg": photo("jpeg"),
        "photo.tif": photo("tiff"),
        "photo.bmp": photo("bmp"),
        "photo.webp": photo("webp"),
        "photo.heic": photo("heif"),
        "result.json": Reader(json.dumps(RESULT, indent=1).encode(), ":", exported),
        **{
            name: Reader(content, parting, import_other_tool)
            for name, (content, parting) in other_tools_files().items()
        },
    }
    for name in sorted(tables):
        beside = {k: v for k, v in tables.items() if k != name}
        made[name] = Reader(
            tables[name],
            "=" if name.endswith("toml") else ",",
            calibrate_tables_beside,
            beside,
        )
    return made


GATES = {  # rig, table, more of recording.toml
    "gates.csv": (
        "roll",
        "x_mm,t_s,sd_s,sd_mm\n150,0,1e-4,0.3\n350,0.31,1e-4,0.3\n550,0.52,1e-4,0.3\n750,0.7,1e-4,0.3\n950,0.85,,\n",
        "[roll]\nincline_deg = 8\nlevel = false\nrail_gap_mm = 6\n",
    ),
    "gates.csv of both legs": (
        "roll",
        "x_mm,t_s\n50,0.4\n90,0.52\n150,0.68\n300,1.1\n450,1.8\n",
        "[roll]\nincline_deg = 8\nincline_length_mm = 100\n",
    ),
    "gates.csv of a drop": (
        "drop",
        "y_mm,t_s,sd_s\n300,0,1e-4\n200,0.14,1e-4\n50,0.226,1e-4\n50,0.29,1e-4\n100,0.33,1e-4\n",
        "",
    ),
    "gates.csv of a slide": (
        "slide",
        "x_mm,t_s\n20,0.2\n80,0.4\n160,0.55\n260,0.7\n400,0.88\n",
        "[slide]\nstart_deg = 25\n",
    ),
}
FEW = (
    b"t_s,x_mm,y_mm,sd_mm\n"
    b"0,0,500,1\n0.2,1,304,1\n0.3,1,60,1\n0.4,2,120,1\n0.5,2,200,1\n0.6,2,190,1\n"
)
PAIR = {
    f"{who}{name}": {"value": 0.3, "low": 0.2, "high": 0.4, "unit": "1"}
    for who in ("", "seed_")
    for name in ("restitution", "static_friction", "rolling_friction")
}
SOLID = {"density_kg_m3": 1250.0, "shear_modulus_pa": 1e7, "poisson_ratio": 0.4}
RESULT = {
    "parameters": PAIR,
    "conventions": {"rolling": "edem"},
    "materials": {
        "seed": {"name": "soybean", **SOLID},
        "wall": {"name": "steel", **SOLID},
    },
    "seed_shape": {
        "length_mm": 8.7,
        "width_mm": 6.8,
        "thickness_mm": 6.0,
        "spheres": [[0, 0, 0, 3.0], [2.0, 0, 0, 2.5]],
    },
}


def error_place(error: BaseException) -> str:
    """The file whose line raised it."""
    at = error.__traceback__
    while at is not None and at.tb_next is not None:
        at = at.tb_next
    return "" if at is None else at.tb_frame.f_code.co_filename
