"""What the commands have in common: exit codes by whose error it was, folders that are
kept."""

import pytest

from benchtwin.bench.exits import DONE, FAILED, MISUSED, Misuse
from benchtwin.bench.whole_file import write_whole
from benchtwin.command_line import exit_code
from benchtwin.twin.command import check_bench, check_out


def raising(error):
    def work():
        raise error

    return work


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (Misuse("--rig fall: no such rig"), MISUSED, "--rig fall: no such rig"),
        (FileExistsError("out: holds a result"), MISUSED, "out: holds a result"),
        (ValueError("no drop could be read"), FAILED, "no drop could be read"),
        (RuntimeError("too many runs gave nothing"), FAILED, "too many runs"),
        (
            OSError(28, "No space left on device", "out/result.json"),
            FAILED,
            "out/result.json: No space",
        ),
        (PermissionError(13, "Permission denied"), FAILED, "OUT: Permission denied"),
        (
            KeyboardInterrupt(),
            FAILED,
            "stopped; the same command goes on where it stopped (OUT)",
        ),
    ],
)
def test_an_error_is_one_line_and_its_code_says_whose_it_was(
    capsys, error, code, words
):
    assert exit_code("calibrate", "OUT", raising(error)) == code
    line = capsys.readouterr().err
    assert line.startswith(f"benchtwin calibrate: {words}") and line.count("\n") == 1


def test_a_command_says_which_errors_are_misuse_and_which_are_faults_of_ours():
    wrong = raising(ValueError("a setting that does not fit"))
    assert exit_code("predict", "OUT", wrong, misuses=(ValueError,)) == MISUSED
    with pytest.raises(ValueError):
        exit_code("diagnose", "OUT", wrong, failures=())
    assert exit_code("diagnose", "OUT", lambda: DONE) == DONE


def test_results_and_what_others_wrote_are_not_replaced(tmp_path):
    ours, file = {"result.json", "runs"}, tmp_path / "out" / "result.json"
    assert check_out(file.parent, ours, "calibration") == set()
    file.parent.mkdir()
    write_whole(file, "{}")
    assert [p.name for p in file.parent.iterdir()] == ["result.json"]
    with pytest.raises(
        FileExistsError, match=r"holds a calibration already; .* say --overwrite"
    ):
        check_out(file.parent, ours, "calibration", "result.json", overwrite=False)
    assert check_out(file.parent, ours, "calibration", "result.json") == {"result.json"}
    (file.parent / "thesis.tex").touch()
    with pytest.raises(
        FileExistsError, match=r"thesis\.tex, which no calibration wrote"
    ):
        check_out(file.parent, ours, "calibration", "result.json")
    with pytest.raises(FileExistsError, match="is a file"):
        check_out(file, ours, "calibration")


def test_results_do_not_lie_among_the_recordings(tmp_path):
    bench = tmp_path / "bench"
    with pytest.raises(FileNotFoundError, match="no such folder"):
        check_bench(bench, tmp_path / "out")
    bench.mkdir()
    check_bench(bench, tmp_path / "out")
    for out in (bench, bench / "out"):
        with pytest.raises(Misuse, match="within the bench folder"):
            check_bench(bench, out)
