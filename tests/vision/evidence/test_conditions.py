"""[conditions] and the other keys of what differs between recordings: what is taken,
what is refused, and what should stand there."""

from pathlib import Path

import pytest

from benchtwin.bench.conditions import MOST_CONDITIONS
from benchtwin.vision.evidence.read_keys import merge, read_toml, validate
from benchtwin.vision.measurement import MeasurementError
from benchtwin.vision.recording import read_recording, write_recording

IMPACTS = "t_s\n0.1\n0.4\n"


def read(folder: Path, recording: str, bench: str = ""):
    """The recording of a bench with these two files."""
    path = folder / "one"
    path.mkdir(parents=True)
    (folder / "bench.toml").write_text(bench, encoding="utf8")
    (path / "recording.toml").write_text(recording, encoding="utf8")
    (path / "impacts.csv").write_text(IMPACTS, encoding="utf8")
    return read_recording(path)


@pytest.mark.parametrize(
    ("stated", "value"),
    [
        ("moisture_pct = 12", 12.0),
        ("t_c = -3.5", -3.5),
        ('plate = "B"', "B"),
        ('plate = "2B"', "2B"),
        ('lot = "no 3"', "no 3"),
        ('day = "2026-03-02"', "2026-03-02"),
        ('coat = "3 old layers"', "3 old layers"),
        ('wet = "yes"', "yes"),
        ("a1_ = 0", 0.0),
    ],
)
def test_numbers_and_words_are_taken_as_they_stand(stated, value):
    import tomllib

    known = validate({"conditions": tomllib.loads(stated)}, Path("recording.toml"))
    assert list(known.conditions.values()) == [value]
    assert all(type(v) is type(value) for v in known.conditions.values())


@pytest.mark.parametrize(
    ("stated", "should_be"),
    [
        ('moisture = "12 %"', "moisture_pct = 12"),
        ('moisture_pct = "12%"', "moisture_pct = 12"),
        ('gap = "12.4"', "gap = 12.4"),
        ('gap = "12,4"', "gap = 12.4"),
        ('gap = "-1e-3"', "gap = -1e-3"),
        ('gap = "+3.0 mm"', "gap_mm = 3.0"),
        ('room = "20 °C"', "room_c = 20"),
        ('room = "20 C"', "room_c = 20"),
        ('air = "about 40 % "', "air_pct = 40"),
        ('air = "40 ± 2 %"', "air_pct = 40"),
        ('load = "5g"', "load_g = 5"),
        ('plate = "3"', 'a word: "no 3"'),
        ("wet = true", 'wet = "yes"'),
        ("wet = false", 'wet = "no"'),
        ("day = 2026-03-02", 'day = "2026-03-02"'),
    ],
)
@pytest.mark.parametrize("where", ["bench.toml", "one/recording.toml"])
def test_what_is_written_otherwise_is_told_with_what_should_stand_there(
    tmp_path, stated, should_be, where
):
    section = f"[conditions]\n{stated}\n"
    with pytest.raises(MeasurementError) as error:
        read(tmp_path, *(("", section) if where == "bench.toml" else (section, "")))
    said = str(error.value)
    assert said.startswith(
        f"{tmp_path / where}: [conditions] {stated.split()[0]}"
    ) and said.endswith(should_be)


@pytest.mark.parametrize(
    ("section", "words"),
    [
        ("[conditions]\nw = nan", ["w = nan", "finite"]),
        ("[conditions]\nw = -inf", ["w = -inf", "finite"]),
        (f"[conditions]\nw = 1{'0' * 400}", ["w = 1", "finite"]),
        ("[conditions]\nw = 1e200", ["finite number below 1e+10"]),
        ("[conditions]\nw = [1, 2]", ["w is a list", "one number or one word"]),
        ("[conditions.w]\nx = 1", ["w is a section"]),
        ('[conditions]\nw = "unknown"', ["leave the key out"]),
        ('[conditions]\nw = " "', ["leave the key out"]),
        ('[conditions]\nw = "NaN"', ["leave the key out"]),
        (f'[conditions]\nw = "{"x" * 101}"', ["101 characters"]),
        (
            '[conditions]\n"moisture-pct" = 1',
            ["letters, digits and underscores", "moisture_pct"],
        ),
        ('[conditions]\n"" = 1', ["letters, digits and underscores"]),
        (f"[conditions]\n{'x' * 41} = 1", ["41 characters"]),
        ('[conditions]\nsession = "a"', ["a key of its own"]),
        ("[conditions]\norder = 3", ["another name"]),
        ("conditions = 3", ["conditions = 3", "section"]),
        ("[[conditions]]\na = 1", ["section"]),
        ("[reading]\nresolution = 1", ["did you mean resolution_deg?"]),
        ("[reading]\nresolution_deg = 0", ["resolution_deg = 0"]),
        ("[reading]\nresolution_deg = 30", ["resolution_deg = 30", "5"]),
        ("[camera]\nreadout_s = 8", ["8000 ms", "in seconds?"]),
        ("[camera]\nreadout_s = -0.001", ["readout_s"]),
        ("[roll]\nrail_gap_mm = 0", ["rail_gap_mm"]),
        ("[roll]\nrail_gap_mm = 4500", ["4.5 m", "in millimetres?"]),
        ("[seed]\nmass_g = 172600", ["172.6 kg", "in grams?"]),
        ("[seed]\nlength_mm = 2430", ["2.43 m", "in millimetres?"]),
        (f"[seed]\nlength_mm = {'9' * 400}", ["[seed] length_mm"]),
        (
            "[seed]\ninertia_factor = 1.4",
            ["inertia_factor = 1.4", "less than or equal to 1"],
        ),
    ],
)
def test_what_cannot_be_is_refused_with_its_file_and_key(tmp_path, section, words):
    with pytest.raises(MeasurementError) as error:
        read(tmp_path, section)
    for word in (str(tmp_path / "one" / "recording.toml"), *words):
        assert word in str(error.value)


def test_every_wrong_condition_is_told_not_only_the_first(tmp_path):
    with pytest.raises(MeasurementError) as error:
        read(tmp_path, '[conditions]\na = "1 %"\nb = true\nc = 3')
    lines = str(error.value).splitlines()
    assert len(lines) == 2 and all(
        str(tmp_path / "one" / "recording.toml") in line for line in lines
    )


def test_there_are_so_many_conditions_bench_and_recording_together(tmp_path):
    names = [f"c{k} = {k}" for k in range(MOST_CONDITIONS + 1)]
    most = read(tmp_path / "a", "\n".join(["[conditions]", *names[:-1]]))
    assert len(most.conditions) == MOST_CONDITIONS
    with pytest.raises(
        MeasurementError,
        match=(
            rf"{MOST_CONDITIONS + 1} of them; a recording states {MOST_CONDITIONS} at"
            r" most"
        ),
    ):
        read(
            tmp_path / "b",
            "\n".join(["[conditions]", *names[:10]]),
            "\n".join(["[conditions]", *names[10:]]),
        )


def test_the_recording_wins_over_the_bench_key_by_key(tmp_path):
    bench = (
        '[conditions]\nmoisture_pct = 12\nplate = "A"\n[reading]\nresolution_deg ='
        " 0.5\n[camera]\nreadout_s = 0.004"
    )
    made = read(tmp_path, '[conditions]\nplate = "B"\nload_g = 3', bench)
    assert made.conditions == {"moisture_pct": 12.0, "plate": "B", "load_g": 3.0}
    assert made.reading.resolution_deg == 0.5 and made.camera.readout_s == 0.004
    assert merge(read_toml(tmp_path / "bench.toml"), {})["conditions"]["plate"] == "A"


def test_what_is_stated_is_written_and_read_back(tmp_path):
    made = read(
        tmp_path,
        '[conditions]\nplate = "B"\nmoisture_pct = 12.4\n[reading]\nresolution_deg'
        " = 0.5",
    )
    write_recording(made)
    assert read_recording(made.path) == made and made.conditions == {
        "plate": "B",
        "moisture_pct": 12.4,
    }
    hash(made)


def test_nothing_stated_is_nothing_known(tmp_path):
    made = read(tmp_path, "")
    assert made.conditions == {} and made.reading.resolution_deg is None
    assert made.camera.readout_s is None and made.roll.rail_gap_mm is None


def test_a_basketball_and_a_bowling_ball_are_seeds_too(tmp_path):
    made = read(
        tmp_path,
        "[seed]\nlength_mm = 243\nwidth_mm = 243\nthickness_mm = 400\nmass_g = 7260",
    )
    assert (made.seed.length_mm, made.seed.mass_g) == (243.0, 7260.0)
