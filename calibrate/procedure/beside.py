"""Our simulations beside the tabulated ones that they repeat: run by run, and all that
is read from them."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pandas as pd
from benchtwin.calibrate.procedure.calibration import Calibration
from benchtwin.calibrate.procedure.from_tables import published
from benchtwin.calibrate.procedure.published import check_pile, check_steel
from benchtwin.calibrate.procedure.rigs import PILE_RESPONSE
from benchtwin.calibrate.procedure.tables import levels_table

RUNS = ["table", "at", "unit", "on_the_tables", "simulated", "sd", "runs"]


def beside_tables(c: Calibration, printed: Calibration) -> Calibration:
    """A simulated calibration with what the tabulated one (`calibrate_tables`) holds
    beside it.

    Its `more` gets two tables. runs_beside_tables, a row a run of the tables: table,
    at, unit, on_the_tables, simulated (mean), sd of single runs, runs. beside_tables, a
    row a quantity: item, printed, on_the_tables (recomputed from them), simulated.
    Printed values and flags are the tabulated one's."""
    runs = pd.DataFrame(
        [*_steel_runs(c, printed), *_pile_runs(c, printed)], columns=RUNS
    )
    more = {
        **c.more,
        "runs_beside_tables": runs,
        "beside_tables": _quantities(c, printed),
    }
    return replace(
        c, more=more, title=printed.title, checks=printed.checks, flags=printed.flags
    )


def _steel_runs(c: Calibration, printed: Calibration) -> Iterator[tuple]:
    for name in (n for n in printed.steel if n in c.steel):
        rig, ours = (
            printed.steel[name].rig,
            c.steel[name].rows.set_index(c.steel[name].rig.parameter),
        )
        for value, tabulated in (
            printed.steel[name]
            .rows[[rig.parameter, rig.response]]
            .itertuples(index=False, name=None)
        ):
            if value in ours.index:
                row = ours.loc[value]
                at, found = (
                    f"{rig.parameter} = {value:g}",
                    (row[rig.response], row[rig.sd]),
                )
                yield name, at, rig.unit, tabulated, *found, int(row["repeats"])


def _pile_runs(c: Calibration, printed: Calibration) -> Iterator[tuple]:
    """Groups of the path, then the design's points; several runs of a point as their
    mean."""
    if c.pile is None or printed.pile is None:
        return
    if c.pile.path is not None and printed.pile.path is not None:
        ours = c.pile.path.errors.set_index("group")[PILE_RESPONSE]
        for group, tabulated in printed.pile.path.errors.set_index("group")[
            PILE_RESPONSE
        ].items():
            if group in ours.index:
                yield (
                    "path",
                    f"group {group:g}",
                    "deg",
                    tabulated,
                    ours[group],
                    float("nan"),
                    c.options["effort"]["path"],
                )
    ours, theirs = (
        _points(p.design, list(printed.pile.box.names)) for p in (c.pile, printed.pile)
    )
    for at, row in theirs.iterrows():
        if at in ours.index:
            where = ", ".join(f"{v:g}" for v in at)
            yield (
                "design",
                where,
                "deg",
                row["mean"],
                ours.loc[at, "mean"],
                ours.loc[at, "std"],
                int(ours.loc[at, "count"]),
            )


def _points(design: pd.DataFrame, factors: list[str]) -> pd.DataFrame:
    """Mean, sd and number of the runs of every point, indexed by its factors."""
    return design.groupby([design[f].round(9) for f in factors])[PILE_RESPONSE].agg(
        ["mean", "std", "count"]
    )


def _quantities(c: Calibration, printed: Calibration) -> pd.DataFrame:
    folder = Path(printed.options["tables"])
    publication = published(folder / "published.toml")
    ours = [
        check_steel(c.steel[n], c.bench.rigs[n], publication.get(n, {}))
        for n in c.steel
        if n in printed.steel
    ]
    rows = [
        (f"{n}: parameter", printed.steel[n].inverse.value, c.steel[n].inverse.value)
        for n in printed.steel
        if n in c.steel
    ]
    if c.pile is not None and printed.pile is not None:
        ours.append(
            check_pile(
                c.pile, publication.get("pile", {}), levels_table(folder / "levels.csv")
            )[0]
        )
        rows += [
            (
                f"pile: optimum, {f}",
                printed.pile.optimum.point[f],
                c.pile.optimum.point[f],
            )
            for f in c.pile.box.names
        ]
        if c.pile.path is not None and printed.pile.path is not None:
            rows.append(
                (
                    "pile: nearest group of the path",
                    printed.pile.path.group,
                    c.pile.path.group,
                )
            )
    answers = pd.DataFrame(rows, columns=["item", "on_the_tables", "simulated"])
    simulated = pd.concat(ours)[["item", "recomputed"]].rename(
        columns={"recomputed": "simulated"}
    )
    stated = printed.checks[["item", "printed", "recomputed"]].rename(
        columns={"recomputed": "on_the_tables"}
    )
    both = stated.merge(simulated.drop_duplicates("item"), on="item", how="inner")
    whole = pd.concat(
        [answers[~answers["item"].isin(both["item"])], both], ignore_index=True
    )
    return whole[["item", "printed", "on_the_tables", "simulated"]]
