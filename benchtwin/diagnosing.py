"""`benchtwin.diagnose`: a bench folder → what physics the twin leaves out, and how sure
that is."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path

import pandas as pd
from plotly.graph_objects import Figure

from benchtwin import shown
from benchtwin.blas import on_one_blas_thread
from benchtwin.diagnose.bench import Diagnosis, diagnose_bench
from benchtwin.diagnose.words import lines
from benchtwin.diagnose_command import RIG_NAMES, Asked, diagnose_into
from benchtwin.measuring import Bench, recordings_of
from benchtwin.report.draw import BLUE, RED

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
    folder: where files were written, None where none were. details: every fit; its
    fields may change between versions."""

    verdicts: pd.DataFrame
    effects: pd.DataFrame
    not_diagnosed: dict[str, str]
    in_words: tuple[str, ...]
    folder: Path | None
    details: Diagnosis = field(repr=False)

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
            "What the recordings show beyond the model", cells, self.in_words
        )


@on_one_blas_thread
def diagnose(
    bench: Bench,
    *,
    out: str | Path | None = None,
    rigs: Sequence[str] = (),
    twin: bool = True,
    quick: bool = False,
    rng: int = 1,
    overwrite: bool = False,
    progress: bool = False,
) -> DiagnosisSummary:
    """Diagnose where recordings and simulation differ: where, and which physics was
    left out.

    bench: its folder, or what `measure` found on it: no recording is then read again.
    out: folder for diagnosis.json, report and the twin's new runs, none of them without
    it; twin: run the twin again with what was found; quick: its tracks only, no
    pictures. rigs: only these of drop, slide, roll and pile. rng: seed of the random
    numbers. overwrite: replace a diagnosis. progress: shown on stderr.

    Raises FileNotFoundError for a bench that is not there; FileExistsError where `out`
    must not be replaced; ValueError for an unknown rig. A rig that cannot be diagnosed
    raises nothing: `not_diagnosed` says why."""
    if wrong := [rig for rig in rigs if rig not in RIG_NAMES]:
        raise ValueError(f"rigs: no rig {wrong[0]!r}; there are {', '.join(RIG_NAMES)}")
    recordings = recordings_of(bench)
    if out is None:
        return _summary(diagnose_bench(recordings, seed=rng, only=tuple(rigs)), None)
    asked = Asked(
        recordings, Path(out), tuple(rigs), rng, twin, quick, overwrite, not progress
    )
    found, _ = diagnose_into(asked)
    return _summary(found, asked.out)


def _summary(found: Diagnosis, folder: Path | None) -> DiagnosisSummary:
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
    )
