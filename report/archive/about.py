"""README.md of a pack: what is in it, its numbers, how to compute them again, whom to
cite."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path

from benchtwin.bench.numbers import with_interval
from benchtwin.report import draw
from benchtwin.report.archive import MANIFEST
from benchtwin.twin.versions import versions

RESULT = "result.json"
KINDS = {
    RESULT: "a calibration",
    "diagnosis.json": "a diagnosis",
    "prediction.json": "a prediction",
    "measurements.csv": "measurements",
}


def about(name: str, files: Mapping[str, Path | str], runs: bool) -> str:
    """README.md as text. files: what else is in the pack."""
    folders = sorted({"/".join(at.split("/")[:2]) for at in files})
    results = [folder for folder in folders if folder.startswith("results/")]
    lines = [
        f"# {name}: recordings and results",
        "",
        f"Made with benchtwin {versions()['benchtwin']}. `{MANIFEST}` holds the SHA-256"
        " of every file and the versions of all libraries.",
        "",
        f"- `bench/{name}`: the recordings, with what is known of them (`bench.toml`,"
        " `recording.toml`)",
        *(f"- `{folder}`: {_kind(folder, files)}" for folder in results),
        "" if runs else "\nSimulated runs are left out; the commands below make them.",
        "",
        *_parameters(files, results),
        "## To compute it again",
        "",
        f"With benchtwin {versions()['benchtwin']}; options and the seed of the random"
        f" numbers stand in each {RESULT}:",
        "",
        "```sh",
        f"benchtwin measure bench/{name} --out measured",
        f"benchtwin calibrate bench/{name} --out calibrated",
        "```",
        "",
        "## To cite",
        "",
        "benchtwin (CITATION.cff in its repository), and the sources of what was not"
        " measured:",
        "",
        *sorted({f"- {source}" for source in _sources(files, results)}),
        "",
    ]
    return "\n".join(lines)


def _kind(folder: str, files: Mapping[str, Path | str]) -> str:
    there = [what for file, what in KINDS.items() if f"{folder}/{file}" in files]
    return there[0] if there else "results"


def _results(
    files: Mapping[str, Path | str], results: list[str]
) -> Iterator[tuple[str, dict]]:
    """The calibrations among the results; one that cannot be read tells nothing."""
    for folder in results:
        content = files.get(f"{folder}/{RESULT}")
        if content is not None:
            text = content if isinstance(content, str) else content.read_text("utf8")
            try:
                yield folder, json.loads(text)
            except ValueError:
                continue


def _parameters(files: Mapping[str, Path | str], results: list[str]) -> Iterator[str]:
    for folder, result in _results(files, results):
        yield from (f"## Contact parameters, `{folder}`", "")
        yield from ("| parameter | value (95 % interval) | |", "|---|---|---|")
        for key, row in result.get("parameters", {}).items():
            value = with_interval(row["value"], row["low"], row["high"])
            yield f"| {draw.name(key)} | {value} | {row['status']} |"
        rolling = result.get("conventions", {}).get("rolling_means", "")
        yield from ("", f"Rolling friction: {rolling}.", "")


def _sources(files: Mapping[str, Path | str], results: list[str]) -> Iterator[str]:
    for _, result in _results(files, results):
        for material in result.get("materials", {}).values():
            if isinstance(material, dict) and material.get("source"):
                yield str(material["source"])
