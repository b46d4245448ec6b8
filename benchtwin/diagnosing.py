"""What `benchtwin.diagnose` finds: what physics the twin leaves out, and how sure that
is."""

import json
import shutil
from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path

import pandas as pd
from plotly.graph_objects import Figure

from benchtwin import shown
from benchtwin.bench.exits import DONE, FAILED, Misuse, say
from benchtwin.bench.language import tr
from benchtwin.bench.rigs import RIGS
from benchtwin.bench.terminal import Terminal
from benchtwin.bench.whole_file import write_whole
from benchtwin.diagnose.bench import Diagnosis, Say
from benchtwin.diagnose.rerun import resimulate_all
from benchtwin.diagnose.words import lines
from benchtwin.report.diagnosis import render
from benchtwin.report.draw import BLUE, RED
from benchtwin.report.template import PAGE, PRINTED, write_page
from benchtwin.twin.bench_folder import Observed
from benchtwin.twin.command import check_bench, check_out, print_lines, reported

OURS = {"diagnosis.json", PAGE, PRINTED, "twin"}  # what a diagnosis leaves
RIG_NAMES = tuple(rig.name for rig in RIGS.values() if rig.diagnose)
VERDICTS = [
    "rig",
    "verdict",
    "names",
    "probability",
    "p_noise",
    "matters",
    "next_record",
]
EFFECTS = ["rig", "effect", "probability", "value", "low95", "high95", "unit"]


@dataclass(frozen=True, eq=False)
class DiagnosisSummary:
    """What a diagnosis found.

    verdicts: a row a rig: verdict ("none", "name", "class" or "unknown"), the effects
    that it names, its probability, the chance p_noise that noise alone makes as great a
    mismatch, whether the effect moves a contact parameter by half its standard
    deviation, and what to record next. effects: a row an effect that may be missing,
    with its probability and its size in `unit`, NaN where it has none. not_diagnosed:
    rigs without a verdict, and why. in_words: the lines that the command prints.
    folder: where files were written, None where none were; reported: whether the report
    could be drawn. details: every fit; its fields may change between versions."""

    verdicts: pd.DataFrame
    effects: pd.DataFrame
    not_diagnosed: dict[str, str]
    in_words: tuple[str, ...]
    folder: Path | None
    details: Diagnosis = field(repr=False)
    reported: bool = True

    def plot(self) -> Figure:
        """A panel a rig: the probability of each effect that may be missing; red are
        those that the verdict names."""
        rigs = list(self.verdicts["rig"])
        figure, places = shown.panels(rigs)
        for rig, named, place in zip(rigs, self.verdicts["names"], places, strict=True):
            rows = self.effects[self.effects["rig"] == rig].iloc[::-1]
            effects = rows["effect"].tolist()
            colour = [RED if e in named.split(", ") else BLUE for e in effects]
            figure.add_bar(
                x=rows["probability"],
                y=[escape(effect) for effect in effects],
                orientation="h",
                marker_color=colour,
                **place,
            )
        figure.update_xaxes(range=[0, 1])
        return figure

    def _repr_html_(self) -> str:
        table = self.verdicts
        cells = table[["rig", "verdict", "names"]].assign(
            probability=[f"{p:.3g}" for p in table["probability"]],
            matters=["yes" if m else "no" for m in table["matters"]],
        )
        return shown.html(
            tr("What the recordings show beyond the model"), cells, self.in_words
        )

    def tell(self, *, quiet: bool) -> int:
        """Print this as the command does, and return its exit code."""
        out, found = self.folder or Path(), not self.verdicts.empty
        if not found:
            nothing = tr("nothing could be diagnosed in {}", self.details.folder)
            for line in (*self.in_words, nothing):
                say("diagnose", line, FAILED)
        elif not quiet:
            report = out / (PAGE if self.reported else "diagnosis.json")
            print_lines(Terminal(), *self.in_words, f"report: {report}")
        return DONE if found and self.reported else FAILED


def known(rigs: Sequence[str]) -> tuple[str, ...]:
    """The rigs asked for; Misuse for one that is not there."""
    if wrong := [rig for rig in rigs if rig not in RIG_NAMES]:
        raise Misuse(f"--rig {wrong[0]}: no such rig; there are {', '.join(RIG_NAMES)}")
    return tuple(rigs)


def check(bench: Path | Observed, out: Path, *, overwrite: bool) -> None:
    """FileNotFoundError without a bench folder; FileExistsError where `out` holds
    something that must not be replaced."""
    check_bench(bench, out)
    check_out(out, OURS, "diagnosis", "diagnosis.json", overwrite)


def modelled(found: Diagnosis, out: Path, *, pictures: bool, say: Say) -> Diagnosis:
    """Run the simulation again with what was found; failures become notes."""
    shutil.rmtree(out / "twin", ignore_errors=True)  # films of an older diagnosis
    again: Diagnosis = resimulate_all(found, out / "twin", pictures=pictures, say=say)
    return again


def written(found: Diagnosis, out: Path) -> DiagnosisSummary:
    """Write a diagnosis and its report into `out`; a fault in drawing the report is one
    line, and the verdict stays."""
    out.mkdir(parents=True, exist_ok=True)
    file = out / "diagnosis.json"
    for name in (file.name, PAGE, PRINTED):  # of an older one
        (out / name).unlink(missing_ok=True)
    write_whole(file, json.dumps(found.to_json(), indent=1, allow_nan=False))
    drawn = reported(
        lambda: write_page(out, render(found)),
        tr("the verdict is in {}", file),
        "diagnose",
    )
    return summary(found, out, reported=drawn)


def summary(
    found: Diagnosis, folder: Path | None = None, *, reported: bool = True
) -> DiagnosisSummary:
    """Read off what stands in diagnosis.json, so that file and summary cannot
    differ."""
    rigs = found.to_json()["rigs"]
    verdicts = [
        (
            rig,
            r["verdict"],
            ", ".join(r["names"]),
            r["p_verdict"],
            r["p_global"],
            r["matters"],
            r["next_record"],
        )
        for rig, r in rigs.items()
    ]
    effects = [
        (rig, name, e["probability"], e["value"], e["low95"], e["high95"], e["unit"])
        for rig, r in rigs.items()
        for name, e in r["effects"].items()
    ]
    return DiagnosisSummary(
        pd.DataFrame(verdicts, columns=VERDICTS),
        pd.DataFrame(effects, columns=EFFECTS),
        dict(found.refused),
        tuple(lines(found)),
        folder,
        found,
        reported,
    )
