"""Our simulations beside the tabulated ones that they repeat: run by run, and all that
is read from them."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pandas as pd

from benchtwin.calibrate.procedure.calibration import Calibration
from benchtwin.calibrate.procedure.from_tables import published
from benchtwin.calibrate.procedure.published import check_pile, check_steel
from benchtwin.calibrate.procedure.rigs import PILE
from benchtwin.calibrate.procedure.tables import levels_table

RUNS = ["table", "at", "unit", "on_the_tables", "simulated", "sd", "runs"]


def beside_tables(c: Calibration, printed: Calibration) -> Calibration:
    """A simulated calibration with what the tabulated one (`calibrate_tables`) holds
    beside it.

    Its `more` gets two tables. runs_beside_tables, a row a run of the tables: table,
    at, unit, on_the_tables, simulated (mean), sd of single runs, runs. beside_tables, a
    row a quantity: item, printed, on_the_tables (recomputed from them), simulated.
    Printed values and flags are the tabulated one's."""
    runs = [*_steel_runs(c, printed), *_pile_runs(c, printed)]
    beside = c.adding(
        runs_beside_tables=pd.DataFrame(runs, columns=RUNS),
        beside_tables=_quantities(c, printed),
    )
    told = {"title": printed.title, "checks": printed.checks, "flags": printed.flags}
    return replace(beside, **told)


def _steel_runs(c: Calibration, printed: Calibration) -> Iterator[tuple]:
    for name in (n for n in printed.steel if n in c.steel):
        rig, theirs = printed.steel[name].rig, printed.steel[name].rows
        ours = c.steel[name].rows.set_index(rig.parameter)
        for value, tabulated in zip(theirs[rig.parameter], theirs[rig.response]):
            if value in ours.index:
                row, at = ours.loc[value], f"{rig.parameter} = {value:g}"
                found = row[rig.response], row[rig.sd], int(row["repeats"])
                yield name, at, rig.unit, tabulated, *found


def _pile_runs(c: Calibration, printed: Calibration) -> Iterator[tuple]:
    """Groups of the path, then the design's points; several runs of a point as their
    mean."""
    if c.surface is None or printed.surface is None:
        return
    fits = (c.surface, printed.surface)
    if c.surface.path is not None and printed.surface.path is not None:
        paths = (c.surface.path.errors, printed.surface.path.errors)
        ours, theirs = (p.set_index("group")[PILE.response] for p in paths)
        for group, tabulated in theirs.items():
            if group in ours.index:
                found = ours[group], float("nan"), 1
                yield "path", f"group {group:g}", "deg", tabulated, *found
    ours, theirs = (_points(f.design, list(printed.surface.box.names)) for f in fits)
    for at, row in theirs.iterrows():
        if at in ours.index:
            where, found = ", ".join(f"{v:g}" for v in at), ours.loc[at]
            runs = found["mean"], found["std"], int(found["count"])
            yield "design", where, "deg", row["mean"], *runs


def _points(design: pd.DataFrame, factors: list[str]) -> pd.DataFrame:
    """Mean, sd and number of the runs of every point, indexed by its factors."""
    at = [design[f].round(9) for f in factors]
    return design.groupby(at)[PILE.response].agg(["mean", "std", "count"])


def _quantities(c: Calibration, printed: Calibration) -> pd.DataFrame:
    folder = Path(printed.options["tables"])
    publication = published(folder / "published.toml")
    ours = []
    rows: list[tuple[object, ...]] = []
    verified = {o.split(": ")[0]: v for o, v in reversed(c.verified.items())}
    for n in (n for n in c.steel if n in printed.steel):
        both, keys = (printed.steel[n], c.steel[n]), publication.get(n, {})
        ours.append(check_steel(both[1], c.bench.rigs[n], keys, verified.get(n)))
        values = (fit.equation.at(fit.bench.value) for fit in both)
        rows.append((f"{n}: parameter", *values))
    if c.surface is not None and printed.surface is not None:
        levels, keys = (
            levels_table(folder / "levels.csv"),
            publication.get(PILE.name, {}),
        )
        ours.append(check_pile(c.surface, keys, levels, verified.get(PILE.name))[0])
        fits = (printed.surface, c.surface)
        rows += [
            (f"pile: optimum, {f}", *(s.optimum.point[f] for s in fits))
            for f in c.surface.box.names
        ]
        groups = [s.path.group for s in fits if s.path is not None]
        if len(groups) == len(fits):
            rows.append(("pile: nearest group of the path", *groups))
    answers = pd.DataFrame(rows, columns=["item", "on_the_tables", "simulated"])
    again = pd.concat(ours)[["item", "recomputed"]].drop_duplicates("item")
    both = (
        printed.checks[["item", "printed", "recomputed"]]
        .rename(columns={"recomputed": "on_the_tables"})
        .merge(again.rename(columns={"recomputed": "simulated"}), on="item")
    )
    answers = answers[~answers["item"].isin(both["item"])]
    whole = pd.concat([answers, both], ignore_index=True)
    return whole[["item", "printed", "on_the_tables", "simulated"]]
