"""`benchtwin.audit`: what a bench states, what is unknown, and what stating it would
add."""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import pandas as pd
from plotly.graph_objects import Figure

from benchtwin import shown
from benchtwin.blas import on_one_blas_thread
from benchtwin.measuring import Measurements
from benchtwin.options import Bench
from benchtwin.page.form import Field, form, needed
from benchtwin.recording_commands import measure
from benchtwin.report.draw import BLUE, GREY
from benchtwin.vision.recording import Recording

KEYS = ["rig", "key", "unit", "stated_by", "of", "value", "meaning", "absent", "asked"]
Row = tuple[str, str, str, int, int, object, str, str, str]
ABSENT = "Absent: "  # in a key's help: what holds where nothing is stated


@dataclass(frozen=True, eq=False)
class Audit:
    """What a bench states and what it leaves open.

    keys: a row a rig and key: how many recordings state it (stated_by) of how many
    (of), its value (a list where recordings differ, None where none states it), what it
    means, what holds where it is absent (a sentence, "" where nothing is assumed), and
    asked: what a measurement said it could not do without it. Keys that only a
    simulation needs are left out. assumed: a row a note of what measuring assumed or
    left out: recording, note."""

    keys: pd.DataFrame
    assumed: pd.DataFrame

    @property
    def unknown(self) -> pd.DataFrame:
        """Keys that not every recording states; first those that a measurement asked
        for, then those in whose place something is assumed."""
        table = self.keys[self.keys["stated_by"] < self.keys["of"]]
        rank = 2 - 2 * table["asked"].ne("") - table["absent"].ne("")
        order = rank.sort_values(kind="stable").index
        return table.loc[order].reset_index(drop=True)

    def plot(self) -> Figure:
        """A panel a rig: for each key the share of its recordings that state it."""
        groups = list(self.keys.groupby("rig", sort=False))
        figure, places = shown.panels([str(rig) for rig, _ in groups])
        for (_, rows), place in zip(groups, places, strict=True):
            rows = rows.iloc[::-1]
            share = rows["stated_by"] / rows["of"]
            look = {"y": rows["key"].tolist(), "orientation": "h", **place}
            figure.add_bar(x=share, marker_color=BLUE, **look)
            figure.add_bar(x=1.0 - share, marker_color=GREY, opacity=0.2, **look)
        most = max((len(rows) for _, rows in groups), default=1)
        tall = 80 + 18 * most * ((len(groups) + 1) // 2)
        figure.update_layout(barmode="stack", height=tall)
        return figure

    def _repr_html_(self) -> str:
        table = self.unknown
        cells = table[["rig", "key", "unit"]].assign(
            stated=[f"{r.stated_by} of {r.of}" for r in table.itertuples()],
            meaning=table["meaning"],
            adds=table["asked"].where(table["asked"].ne(""), table["absent"]),
        )
        notes = [f"{r.recording}: {r.note}" for r in self.assumed.itertuples()]
        return shown.html("Not stated by every recording", cells, notes)


@on_one_blas_thread
def audit(bench: Bench) -> Audit:
    """Say what a bench states, what is unknown, and what stating it would add.

    Parameters
    ----------
    bench
        Its folder, or what `measure` found on it: no recording is then read again.

    Returns
    -------
    Audit
        Keys that are stated, and those that are not.

    Raises
    ------
    FileNotFoundError
        For a bench that is not there.
    """
    found = bench if isinstance(bench, Measurements) else measure(bench)
    recordings = [e for e in found.observed.entries if isinstance(e, Recording)]
    rigs = dict.fromkeys(recording.rig or "" for recording in recordings)
    said = {
        o.recording: (*(q.reason for q in o.quantities), *o.notes)
        for o in found.observations
    }
    rows = []
    for rig in rigs:
        mine = [r for r in recordings if (r.rig or "") == rig]
        rows += _keys(rig, mine, said)
    keys = pd.DataFrame(rows, columns=KEYS)
    return Audit(keys, pd.DataFrame(found.notes, columns=["recording", "note"]))


def _keys(
    rig: str, recordings: list[Recording], said: Mapping[str, Iterable[str]]
) -> list[Row]:
    """A row a key of this rig that a measurement may use; said: reasons and notes of
    each recording."""
    rows = []
    for section in form(rig or None, {}, {}):
        for key in section.fields:
            if not section.name or key.rare:
                continue
            values = [_stated(r, key) for r in recordings]
            there = [value for value in values if value is not None]
            meaning, _, absent = key.help.partition(ABSENT)
            asked = dict.fromkeys(
                line
                for r in recordings
                for line in said.get(r.id, ())
                if (key.section, key.key) in needed([line], r)
            )
            rows.append(
                (
                    rig,
                    f"{key.section}.{key.key}",
                    key.unit,
                    len(there),
                    len(recordings),
                    _alike(there),
                    meaning.strip(),
                    absent,
                    "; ".join(asked),
                )
            )
    return rows


def _stated(recording: Recording, key: Field) -> object:
    """What a recording says of a key, None where it says nothing."""
    section = getattr(recording, key.section)
    return getattr(section, key.key) if key.key in section.model_fields_set else None


def _alike(values: Iterable[object]) -> object:
    """The one value, or the list of different ones; None without any."""
    different = list(Counter(values))
    return different[0] if len(different) == 1 else different or None
