"""`benchtwin import`: a bench that measures, with every guess and question in it; whole
or not at all."""

import tomllib

import numpy as np
import pytest
from bouncing import HEIGHT_M, IMPACTS_S, ball
from measure_all import measure
from typer.testing import CliRunner

from benchtwin.command_line import app

FRAME, X, Y = ball()


def exported(times: float = 1.0) -> str:
    rows = [
        f"{times * t:.6g};{x:.6g};{y:.6g}".replace(".", ",")
        for t, x, y in zip(FRAME / 120, X, Y)
    ]
    return "\n".join([";mass A;", "t;x;y", *rows])


HEARD = "Event time (s),Interval (s)\n" + "".join(
    f"{t},{g}\n" for t, g in zip(IMPACTS_S, np.append(np.diff(IMPACTS_S), 0))
)
PLATE = "time (s),ax (g),ay (g),az (g)\n" + "".join(
    f"{t:.2f},{np.sin(a):.6f},0,{np.cos(a):.6f}\n"
    for t in np.arange(0, 12, 0.05)
    for a in [np.radians(np.clip(2 * (t - 1), 0, 18))]
)


def run(*words: object):
    return CliRunner().invoke(app, ["import", *map(str, words)])


@pytest.fixture
def files(tmp_path):
    for name, text in {
        "film.txt": exported(),
        "clap.csv": HEARD,
        "plate.csv": PLATE,
    }.items():
        (tmp_path / name).write_text(text, encoding="utf8")
    return tmp_path


def test_a_bench_is_written_that_measures(files):
    result = run(
        files / "film.txt",
        files / "clap.csv",
        files / "plate.csv",
        "--out",
        files / "bench",
    )
    assert result.exit_code == 0, result.output
    bench = files / "bench"
    assert sorted(
        p.relative_to(bench).as_posix() for p in bench.rglob("*") if p.is_file()
    ) == [
        "bench.toml",
        "clap/impacts.csv",
        "clap/recording.toml",
        "film/recording.toml",
        "film/track.csv",
        "plate/recording.toml",
        "plate/tilt.csv",
    ]
    for file in bench.rglob("*.toml"):
        tomllib.loads(file.read_text(encoding="utf8"))
    film = (bench / "film" / "recording.toml").read_text(encoding="utf8")
    assert (
        'rig = "drop"' in film
        and "# GUESS: lengths in m, which the file does not say" in film
        and "[drop]\n# QUESTION: from which height" in film
    )
    questions = (bench / "bench.toml").read_text(encoding="utf8")
    assert "# length_mm =" in questions
    for said in (
        "film, clap: [drop] height_mm",
        "plate: was the plate stopped",
    ):
        assert said in questions and said in result.output
    with (bench / "bench.toml").open("a") as file:
        file.write(f"[drop]\nheight_mm = {1000 * HEIGHT_M}\n")
        file.write("[air]\ndensity_kg_m3 = 0\n")
    found = {
        (o.recording, q.name): q.value for o in measure(bench) for q in o.quantities
    }
    assert found["film", "restitution"] == pytest.approx(0.8, abs=0.003)
    assert found["clap", "restitution_normal"] == pytest.approx(
        0.8, abs=1e-3
    )  # ± .01 by the height


def test_what_cannot_be_read_is_named_and_the_rest_written(files):
    (files / "spoilt.trk").write_text("<object")
    result = run(
        files / "film.txt", files / "spoilt.trk", "--out", files / "bench", "--quiet"
    )
    assert result.exit_code == 0
    assert "spoilt.trk" in result.output and "# NOT READ: " in (
        files / "bench" / "bench.toml"
    ).read_text(encoding="utf8")
    assert (files / "bench" / "film" / "track.csv").is_file()


def test_nothing_read_is_nothing_written(files):
    (files / "spoilt.trk").write_text("<object")
    assert run(files / "spoilt.trk", "--out", files / "bench").exit_code == 1
    assert not (files / "bench").exists()


def test_a_write_that_fails_leaves_no_half_bench(files, monkeypatch):
    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pandas.DataFrame.to_csv", full)
    result = run(files / "film.txt", "--out", files / "bench")
    assert result.exit_code == 2 and "No space left" in result.output
    assert sorted(p.name for p in files.iterdir()) == [
        "clap.csv",
        "film.txt",
        "plate.csv",
    ]


def test_a_doubted_unit_is_a_question_and_stays(files):
    (files / "film.txt").write_text(
        exported(1000).replace("t;x;y", "t (s);x (m);y (m)")
    )
    result = run(files / "film.txt", "--out", files / "bench")
    assert "are the times milliseconds?" in result.output
    rows = np.loadtxt(files / "bench" / "film" / "track.csv", delimiter=",", skiprows=1)
    assert rows[-1, 0] == pytest.approx(1000 * FRAME[-1] / 120, rel=1e-4)
    (reason,) = {q.reason for o in measure(files / "bench") for q in o.quantities}
    assert "are the times milliseconds?" in reason


def test_videos_sounds_and_photos_are_copied_in(files):
    for name in ("a.mp4", "b.wav", "c.jpg"):
        (files / name).write_bytes(name.encode())
    assert (
        run(
            *(files / name for name in ("a.mp4", "b.wav", "c.jpg")),
            "--out",
            files / "bench",
        ).exit_code
        == 0
    )
    assert (files / "bench" / "b" / "b.wav").read_bytes() == b"b.wav"
    rigs = [
        tomllib.loads((files / "bench" / name / "recording.toml").read_text()).get(
            "rig"
        )
        for name in "abc"
    ]
    assert rigs == [None, "drop", "pile"]


def test_track_and_rig_are_chosen_by_hand(files):
    rows = [
        f"{t:.5f},{x:.6f},{y:.6f},{0.2 + 0.1 * t:.6f},0.3"
        for t, x, y in zip(FRAME / 120, X, Y)
    ]
    (files / "two.csv").write_text("\n".join(["t,x,y,x,y", *rows]))
    assert (
        run(
            files / "two.csv", "--out", files / "bench", "--track", 2, "--rig", "roll"
        ).exit_code
        == 0
    )
    written = np.loadtxt(
        files / "bench" / "two" / "track.csv", delimiter=",", skiprows=1
    )
    assert (
        written[:, 2] == pytest.approx(300)
        and 'rig = "roll"' in (files / "bench" / "two" / "recording.toml").read_text()
    )
    assert (
        "--track 3: it holds 2 tracks"
        in run(files / "two.csv", "--out", files / "b", "--track", 3).output
    )


def test_overwrite_replaces_its_own_bench_and_nothing_else(files):
    words = (files / "film.txt", "--out", files / "bench")
    assert run(*words).exit_code == 0
    assert "say --overwrite" in run(*words).output
    assert run(*words, "--overwrite").exit_code == 0
    (files / "bench" / "film" / "video.mp4").write_bytes(b"mine")
    result = run(*words, "--overwrite")
    assert (
        result.exit_code == 2
        and "holds something else than a drafted bench (film)" in result.output
    )
    assert (files / "bench" / "film" / "video.mp4").read_bytes() == b"mine"


def test_a_name_that_could_break_the_file_does_not(files):
    name = 'a"b\\c [d] #e.txt'
    (files / name).write_text(exported(), encoding="utf8")
    assert (
        run(files / name, files / "film.txt", "--out", files / "bench").exit_code == 0
    )
    for file in (files / "bench").rglob("*.toml"):
        tomllib.loads(file.read_text(encoding="utf8"))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("no.trk",), "no such file"),
        (("film.txt", "--rig", "fall"), "it is one of drop, slide"),
    ],
)
def test_misuse_is_told(files, words, said):
    result = run(files / words[0], *words[1:], "--out", files / "bench")
    assert result.exit_code == 2 and said in result.output


@pytest.mark.parametrize(
    ("name", "height", "said"),
    [
        ("drop_150mm_3", 150.0, "height_mm = 150: the length in the file's name"),
        ("Fall aus 15,5 cm", 155.0, "height_mm = 155"),
        ("ball40mm_h2m", None, "which length in the file's name"),
        ("run_3m2", None, "[drop] height_mm: from which height"),
    ],
)
def test_a_height_in_the_file_s_name_is_a_guess_or_a_question(
    tmp_path, name, height, said
):
    (tmp_path / f"{name}.csv").write_text(HEARD)
    result = run(tmp_path / f"{name}.csv", "--out", tmp_path / "bench")
    assert said in result.output
    (file,) = (tmp_path / "bench").glob("*/recording.toml")
    assert tomllib.loads(file.read_text()).get("drop", {}).get("height_mm") == height


def test_columns_of_repeats_become_a_recording_each(tmp_path):
    rows = [f"{t},{y},{y + 0.01}" for t, y in zip(FRAME / 120, Y)]
    (tmp_path / "runs.csv").write_text("\n".join(["t (s),y1 (m),y2 (m)", *rows]))
    assert run(tmp_path / "runs.csv", "--out", tmp_path / "bench").exit_code == 0
    measured = measure(tmp_path / "bench")
    assert [o.recording for o in measured] == ["runs-1", "runs-2"]


def test_conditions_in_file_names_are_guesses_and_materials_a_question(tmp_path):
    names = [
        f"{plate}_{k}_humidity{50 + k}pct" for plate in ("wood", "tin") for k in (1, 2)
    ]
    for name in names:
        (tmp_path / f"{name}.csv").write_text(HEARD)
    result = run(tmp_path, "--out", tmp_path / "bench")
    assert "[conditions]: the names differ by tin, wood" in result.output
    for name in names:
        stated = tomllib.loads((tmp_path / f"bench/{name}/recording.toml").read_text())
        assert stated["conditions"] == {"humidity_pct": 50 + int(name.split("_")[1])}


@pytest.mark.parametrize(("slower", "rig"), [(1, "drop"), (20, "")])
def test_a_fall_along_x_is_a_picture_on_its_side(tmp_path, slower, rig):
    """With the acceleration of gravity; a slower one may roll."""
    heading = "t (s),x (m),y (m)"
    rows = [f"{t},{-y / slower},{x}" for t, x, y in zip(FRAME / 120, X, Y)]
    (tmp_path / "side.csv").write_text("\n".join([heading, *rows]))
    assert run(tmp_path / "side.csv", "--out", tmp_path / "bench").exit_code == 0
    drafted = (tmp_path / "bench/side/recording.toml").read_text()
    assert tomllib.loads(drafted).get("rig", "") == rig
    assert ("lies on its side" in drafted) == bool(rig)
    assert ("is y up in it?" in drafted) != bool(rig)
    if rig:
        found = {q.name: q for o in measure(tmp_path / "bench") for q in o.quantities}
        assert found["restitution"].quality != "failed"


def test_a_fall_along_x_is_measured_as_it_lies(tmp_path):
    """Without an import, by the file alone."""
    rows = [f"{t},{-y},{x}" for t, x, y in zip(FRAME / 120, X, Y)]
    (tmp_path / "side.csv").write_text("\n".join(["t (s),x (m),y (m)", *rows]))
    (seen,) = measure(tmp_path / "side.csv")
    assert seen.rig == "drop"
    assert {q.name: q for q in seen.quantities}["restitution_normal"].quality == "good"


def answered(file, **values) -> None:
    """Each commented key of a draft with its number, in its place."""
    text = file.read_text(encoding="utf8")
    for key, value in values.items():
        assert text.count(f"# {key} =\n") == 1, (key, text)
        text = text.replace(f"# {key} =\n", f"{key} = {value}\n")
    file.write_text(text, encoding="utf8")


def test_every_question_is_answered_where_it_stands(files):
    """The # taken away and the number typed, or the key typed beneath: both measure."""
    run(files / "clap.csv", "--out", files / "bench")
    answered(files / "bench" / "clap" / "recording.toml", height_mm=1000 * HEIGHT_M)
    sizes = {"length_mm": 7, "width_mm": 7, "thickness_mm": 7, "mass_g": 3}
    answered(files / "bench" / "bench.toml", **sizes, distance_mm=1500)
    found = {q.name: q.value for o in measure(files / "bench") for q in o.quantities}
    assert found["restitution_normal"] == pytest.approx(0.8, abs=0.005)
    run(files / "clap.csv", "--out", files / "typed")
    with (files / "typed" / "clap" / "recording.toml").open("a") as file:
        file.write(f"height_mm = {1000 * HEIGHT_M}\n[air]\ndensity_kg_m3 = 0\n")
    found = {q.name: q.value for o in measure(files / "typed") for q in o.quantities}
    assert found["restitution_normal"] == pytest.approx(0.8, abs=0.01)


def test_a_key_in_the_wrong_place_is_told_its_section(files):
    run(files / "clap.csv", "--out", files / "bench")
    file = files / "bench" / "clap" / "recording.toml"
    text = file.read_text(encoding="utf8")
    for wrong, said in (
        (
            "height_mm = 300\n" + text,
            "height_mm; it belongs under [drop] or under [bed]",
        ),
        (text + 'rig = "drop"\n', "it belongs at the top of the file"),
        (text + "fps = 240\n", "[drop] fps; it belongs under [camera]"),
    ):
        file.write_text(wrong, encoding="utf8")
        (observation,) = measure(files / "bench")
        assert said in observation.quantities[0].reason


def test_a_bench_states_no_rig_for_what_is_added_later(files):
    """A slide that is put beside imported drops is measured as one; a rig stated for
    all is named where one recording fails by it."""
    run(files / "clap.csv", "--out", files / "bench")
    slide = files / "bench" / "slide-1"
    slide.mkdir()
    (slide / "readings.csv").write_text("slide_angle_deg\n19\n20\n21\n")
    found = {o.recording: o for o in measure(files / "bench")}
    assert found["slide-1"].rig == "slide"
    toml = files / "bench" / "bench.toml"
    toml.write_text('rig = "drop"\n' + toml.read_text(encoding="utf8"))
    failed = {o.recording: o for o in measure(files / "bench")}["slide-1"]
    (q,) = failed.quantities
    assert f"{toml} says rig = 'drop' for all" in q.reason


def test_a_film_is_asked_for_its_scale(files):
    (files / "a.mp4").write_bytes(b"a film")
    result = run(files / "a.mp4", "--out", files / "bench", "--rig", "drop")
    draft = (files / "bench" / "a" / "recording.toml").read_text()
    for key in ("mm_per_px", "fps", "height_mm"):
        assert f"# {key} =\n" in draft and key in result.output
