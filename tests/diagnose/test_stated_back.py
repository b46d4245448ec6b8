"""A key and a finding have one sign: every finding is stated back to its bench by the
key that it names, and nothing is missing then; unstated it is found."""

import dataclasses
import tomllib
from pathlib import Path

import falling
import heaping
import numpy as np
import pandas as pd
import pytest
import rolling
import tomli_w

from benchtwin.bench.keys import Camera
from benchtwin.bench.rigs import RIGS
from benchtwin.diagnose.bench import diagnose_bench
from benchtwin.diagnose.stated import with_stated
from benchtwin.diagnose.words import verdict_in_words
from benchtwin.infer.finding import Finding
from benchtwin.rigs.pile.diagnose import diagnose_pile
from benchtwin.vision.recording import Recording

PIXEL_MM = falling.PIXEL_MM
DROPS = falling.Bench(fps=500.0, axes=(3.5e-3,) * 3, tip_deg=30.0)


def write(folder: Path, told: dict, rows: dict) -> None:
    """A recording whose track is in pixels and frames, so that keys count."""
    folder.mkdir(parents=True)
    (folder / "recording.toml").write_text(tomli_w.dumps(told))
    pd.DataFrame(rows).to_csv(folder / "track.csv", index=False)


def drops(folder: Path, **concealed) -> None:
    rng, off = np.random.default_rng(11), concealed.pop("height_mm", 0.0)
    for k, height in enumerate((0.2, 0.3, 0.4)):
        bench = dataclasses.replace(DROPS, height=height, **concealed)
        _, x, z, angle, frame = falling.film(bench, rng)
        camera = {"fps": bench.fps / (1 + bench.clock), "mm_per_px": PIXEL_MM}
        camera |= {"mm_per_px_sd": 2e-4, "plumb_deg": 0.0, "plumb_sd_deg": 0.05}
        sizes = dict.fromkeys(("length_mm", "width_mm", "thickness_mm"), 7.0)
        drop = {"height_mm": 1e3 * height - off}
        told = {"rig": "drop", "camera": camera, "drop": drop}
        told |= {"seed": sizes | {"density_kg_m3": 1250.0}}
        told |= {"air": {"density_kg_m3": 1.2}}
        rows = {"frame": frame, "x_px": x / PIXEL_MM, "y_px": z / PIXEL_MM}
        write(folder / f"drop-{k}", told, rows | {"angle_deg": angle})


def rolls(folder: Path, **concealed) -> None:
    rng = np.random.default_rng(3)
    bench = rolling.Bench(stated=rolling.BALL, radius_mm=3.5, **concealed)
    for k in range(6):
        way = "+x" if k % 2 else "-x"
        rows = rolling.table(bench, 1.0 if k % 2 else -1.0, rng)
        frame = np.round(rows["t_s"] * bench.fps).astype(int)
        roll = {"incline_deg": 15.0, "incline_length_mm": 30.0, "direction": way}
        camera = {"fps": bench.fps, "mm_per_px": 0.25, "mm_per_px_sd": 2e-4}
        told = {"rig": "roll", "roll": roll, "camera": camera, "seed": rolling.BALL}
        told |= {"air": {"density_kg_m3": 0.0}}
        pixels = {f"{c}_px": rows[f"{c}_mm"] / 0.25 for c in "xy"}
        write(folder / f"roll-{k}", told, {"frame": frame} | pixels)


def of_folder(rig: str, make, **concealed):
    """A function of what is stated beside: the finding."""

    def diagnosed(tmp_path: Path, stated: dict[str, dict]) -> Finding:
        make(tmp_path / "bench", **concealed)
        for file in (tmp_path / "bench").glob("*/recording.toml"):
            told = tomllib.loads(file.read_text())
            for section, keys in stated.items():
                for key, values in keys.items():
                    here = told.setdefault(section, {})
                    here[key] = values[here.get(key, 0.0)]
            file.write_text(tomli_w.dumps(told))
        return diagnose_bench(tmp_path / "bench", only=(rig,)).findings[rig]

    return diagnosed


def heaps(tmp_path: Path, stated: dict[str, dict]) -> Finding:
    """Photos of heaps by a camera that is rolled by 3°, on a plate seen level."""
    rng = np.random.default_rng(4)
    plumb = stated.get("camera", {}).get("plumb_deg", {0.0: 0.0})[0.0]
    bench = heaping.Heap(roll_deg=3.0, angle_sd_deg=0.3, plumb_sd_deg=0.1)
    photos = []
    for k in range(6):
        seen = heaping.picture(bench, rng, f"heap-{k}", gate_speed_mm_s=50.0)
        camera = seen.description["camera"] | {"plumb_deg": plumb}
        photos.append(
            dataclasses.replace(seen, description=seen.description | {"camera": camera})
        )
    found = diagnose_pile(photos, np.random.default_rng(0))
    told = Recording(
        "heap", Path(), "pile", "photos", (), camera=Camera(plumb_deg=plumb)
    )
    return with_stated(found, [told])


BENCHES = {
    ("roll", "slope"): of_folder("roll", rolls, slope_deg=-0.3),
    ("drop", "plate-tilt"): of_folder("drop", drops, tilt_deg=4.0),
    ("drop", "scale-error"): of_folder("drop", drops, scale=0.03),
    ("drop", "clock-error"): of_folder("drop", drops, clock=0.03),
    ("drop", "camera-roll"): of_folder("drop", drops, roll_deg=1.5),
    ("drop", "release-height"): of_folder("drop", drops, height_mm=25.0),
    ("pile", "camera-roll"): heaps,
}


def test_every_effect_that_has_a_key_is_tried():
    effects = {
        (rig.name, effect.name)
        for rig in RIGS.values()
        if rig.effects
        for effect in rig.part("effects").values()
        if effect.key
    }
    assert effects == set(BENCHES)


# of further keys of the camera and the release in the slow tests
FURTHER = ("clock-error", "camera-roll", "release-height")
TRIED = [
    pytest.param(
        *one, marks=[pytest.mark.slow] * (one[0] == "drop" and one[1] in FURTHER)
    )
    for one in BENCHES
]


@pytest.mark.parametrize(("rig", "name"), TRIED)
def test_a_finding_that_is_stated_is_found_no_more(rig, name, tmp_path):
    diagnosed = BENCHES[rig, name]
    found = diagnosed(tmp_path / "1", {})
    print(found.verdict, found.names, found.keys, verdict_in_words(found))
    told = found.keys[name]
    assert name in found.names
    key = RIGS[rig].part("effects")[name].key
    whole = dict(zip(told.stated, told.should_be, strict=True))
    again = diagnosed(tmp_path / "2", {key.section: {key.name: whole}})
    print(again.verdict, again.names, again.p_global, verdict_in_words(again))
    assert again.verdict == "none", verdict_in_words(again)


def test_a_table_that_cannot_be_read_states_nothing(tmp_path):
    drops(tmp_path, clock=0.03)
    table = pd.read_csv(tmp_path / "drop-2" / "track.csv")
    table = table.iloc[[*range(len(table)), 5]].sort_index()
    table["x_px"] += 0.1 * np.arange(len(table))  # two places at one time
    (bad := tmp_path / "twice").mkdir()
    table.to_csv(bad / "track.csv", index=False)
    (bad / "recording.toml").write_text(
        (tmp_path / "drop-2/recording.toml").read_text()
    )
    found = diagnose_bench(tmp_path)
    assert [name for name, *_ in found.trouble] == ["twice"]
    assert found.findings["drop"].keys["clock-error"].key == "[camera] fps"
