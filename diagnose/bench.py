"""Diagnosis of a bench folder: a finding for each rig, or why there is none."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from benchtwin.bench.language import tr
from benchtwin.bench.lines import one_a_reason
from benchtwin.bench.rigs import RIGS
from benchtwin.diagnose.stated import with_stated
from benchtwin.diagnose.words import fault_in_words, tone, verdict_in_words
from benchtwin.infer.finding import Finding
from benchtwin.twin.bench_folder import Observed
from benchtwin.twin.seen import Listed, Recording, listed

Say = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """What a bench folder gave, rig by rig."""

    folder: Path
    findings: dict[str, Finding]
    recordings: dict[str, list]  # those used
    refused: dict[str, str]  # why there is no finding
    trouble: tuple[tuple[str, str, str], ...]  # (name, rig, why) of those not usable
    notes: tuple[str, ...] = ()
    took_s: float = 0.0
    seed: int = 1  # of the random numbers
    twins: dict[str, Any] = field(default_factory=dict)  # rerun.Resimulation

    def to_json(self) -> dict:
        """The content of diagnosis.json."""
        rigs = {}
        for rig, finding in self.findings.items():
            said = {"sentence": verdict_in_words(finding), "tone": tone(finding)}
            twin = {"twin": self.twins[rig].to_json()} if rig in self.twins else {}
            rigs[rig] = said | finding.to_json() | twin
        trouble = [
            dict(zip(("recording", "rig", "why"), entry, strict=True))
            for entry in self.trouble
        ]
        return {
            "schema": 1,
            "rigs": rigs,
            "refused": self.refused,
            "trouble": trouble,
            "notes": list(self.notes),
            "random_seed": self.seed,
        }


def diagnose_bench(
    folder: Path | Observed,
    *,
    seed: int = 1,
    only: tuple[str, ...] = (),
    say: Say = lambda text: None,
) -> Diagnosis:
    """Diagnose every rig of a bench folder, or those in `only`."""
    begun = time.monotonic()
    observed = Observed.under(folder).with_rigs()
    entries = listed(observed)
    trouble = [(e.recording, e.rig, e.trouble) for e in entries if e.trouble]
    findings, used, refused = {}, {}, {}
    rigs = dict.fromkeys((*RIGS, *(e.rig for e in entries if e.rig)))
    for number, rig in enumerate(rig for rig in rigs if not only or rig in only):
        here = [e for e in entries if e.rig == rig and not (e.trouble or e.aside)]
        if not here:
            continue
        rng = np.random.default_rng([seed, number])
        found, used[rig], wrong = _diagnosed(observed, rig, here, rng, say)
        trouble += wrong
        if isinstance(found, Finding):
            unread = {name for name, *_ in wrong}
            read = [e for e in here if e.recording not in unread]
            findings[rig] = with_stated(found, _used(observed, rig, read))
        else:
            refused[rig] = found
    took = time.monotonic() - begun
    notes = tuple(
        tr("{}: one recording only: nothing could be held out", n)
        for n, f in findings.items()
        if len(f.recordings) == 1
    )
    said = tuple(dict.fromkeys(trouble))
    aside = one_a_reason((e.recording, e.aside) for e in entries if e.aside)
    notes = (*notes, *_sds_not_used(entries, tuple(used)), *aside)
    return Diagnosis(observed.folder, findings, used, refused, said, notes, took, seed)


def _used(observed: Observed, rig: str, here: list[Listed]) -> list[Recording]:
    """The recordings of a rig that can be used."""
    names = {e.recording for e in here}
    return [
        entry
        for entry in observed.entries
        if isinstance(entry, Recording) and entry.rig == rig and entry.id in names
    ]


def _sds_not_used(entries: list[Listed], only: tuple[str, ...]) -> list[str]:
    """Stated standard deviations that nobody can know, one line for all recordings that
    state the same."""
    found: dict[str, list[str]] = {}
    for entry in entries:
        for line in entry.notes if entry.rig in only else ():
            found.setdefault(line, []).append(entry.recording)
    return [
        f"{who[0] if len(who) == 1 else f'{len(who)} recordings'}: {line}"
        for line, who in found.items()
    ]


def _diagnosed(
    observed: Observed,
    rig: str,
    entries: list[Listed],
    rng: np.random.Generator,
    say: Say,
):
    """A Finding or why there is none; recordings used; those that were not: (name, rig,
    why)."""
    record = RIGS[rig]
    if not record.diagnose:
        return tr("a {} cannot be diagnosed yet", rig), [], []
    say(tr("{}: reading {} recording{}", rig, len(entries), "s" * (len(entries) != 1)))
    try:
        seen = record.part("read")(observed)
        # every rig's reader reports unreadable files
        known = {e.recording for e in entries}
        wrong = [
            (s.recording, rig, s.trouble)
            for s in seen
            if s.trouble and s.recording in known
        ]
        usable = [s for s in seen if not s.trouble]
        if not usable:
            return tr("none of its recordings can be used"), [], wrong
        say(
            tr(
                "{}: diagnosing {} recording{}",
                rig,
                len(usable),
                "s" * (len(usable) != 1),
            )
        )
        with np.errstate(
            all="ignore"
        ):  # a fit may try a step that overflows, and takes it back
            return record.part("diagnose")(usable, rng), usable, wrong
    except ValueError as error:
        return str(error), [], []
    except Exception as error:  # an error in one rig must not stop the others
        return (
            tr("a fault of benchtwin, please report it: {}", fault_in_words(error)),
            [],
            [],
        )
