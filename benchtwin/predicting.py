"""`benchtwin.predict`: a calibration → what another system shows, with intervals."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd
from plotly.graph_objects import Figure

from benchtwin import shown
from benchtwin.blas import on_one_blas_thread
from benchtwin.calibrate.predict_command import Asked, predict_into
from benchtwin.calibrate.prediction.predict import (
    QUANTITIES,
    Prediction,
    intervals,
    rows,
    sign,
)
from benchtwin.calibrating import CalibrationSummary, folder_of
from benchtwin.measuring import Bench, recordings_of
from benchtwin.report.draw import BLUE, GREY, RED


@dataclass(frozen=True, eq=False)
class PredictionSummary:
    """What was predicted.

    quantities: a row a quantity: unit; mean; low, high: 95 % of single packings;
    mean_low, mean_high: 95 % of the mean over packings; parameter_sd, packing_sd.
    beside: a row a quantity that was recorded: its mean, and where that was expected
    (low to high, z). runs: a row a simulated run. notes: what was assumed or left out.
    folder: where files were written. details: its fields may change between
    versions."""

    quantities: pd.DataFrame
    beside: pd.DataFrame
    runs: pd.DataFrame = field(repr=False)
    notes: tuple[str, ...]
    folder: Path
    details: Prediction = field(repr=False)

    def plot(self) -> Figure:
        """A panel a quantity: runs at drawn parameters (grey), the mean with 95 % of
        single packings (blue), the mean of the recordings (red)."""
        names = QUANTITIES[self.details.rig]
        table = self.quantities
        titles = [f"{names[q]} ({sign(q).strip()})" for q in table["quantity"]]
        figure, places = shown.panels(titles)
        recorded = self.beside.set_index("quantity")["measured"]
        for row, place in zip(table.itertuples(), places, strict=True):
            runs = self.runs[row.quantity].dropna()
            drawn = shown.points(["runs"] * len(runs), runs, colour=GREY)
            figure.add_trace(drawn, **place)
            mean = shown.points(["predicted"], [row.mean], [row.high - row.mean])
            figure.add_trace(mean, **place)
            if row.quantity in recorded:
                seen = shown.points(["recorded"], [recorded[row.quantity]], colour=RED)
                figure.add_trace(seen, **place)
        figure.update_traces(error_y_color=BLUE)
        return figure

    def _repr_html_(self) -> str:
        names, table = QUANTITIES[self.details.rig], self.quantities
        one, many = zip(*map(intervals, table.itertuples()))
        columns = {"one packing, 95 %": one, "mean of many, 95 %": many}
        cells = pd.DataFrame({"quantity": table["quantity"].map(names), **columns})
        said = [*self.beside["said"], *self.notes]
        return shown.html(f"Predicted {self.details.rig}", cells, said)


BESIDE = ["quantity", "measured", "n", "predicted", "low", "high", "z", "said"]


@on_one_blas_thread
def predict(
    calibrated: str | Path | CalibrationSummary,
    rig: str,
    *,
    out: str | Path,
    beside: Bench | None = None,
    settings: Mapping[str, object] | None = None,
    like: str | Path | None = None,
    draws: int = 12,
    packings: int = 4,
    rendered: bool = False,
    rng: int = 1,
    workers: int | None = None,
    scheduler: str | None = None,
    overwrite: bool = False,
    progress: bool = False,
) -> PredictionSummary:
    """Predict another system from calibrated parameters; beside recordings of it, say
    whether they agree.

    calibrated: what `calibrate` found, or the folder that it wrote. rig: "pile",
    "cylinder" (a heap left by a lifted cylinder), "drum", "drawdown" or "bed". out:
    folder for the prediction and its finished runs. beside: recordings of that rig: a
    bench folder, or what `measure` found on it. settings: keys of recording.toml by
    their dotted names, {"drum.speed_rpm": 20.0}; like: a recording whose rig and seed
    to copy. draws: sets of parameters from the posterior, a run each; packings: runs at
    its mean. rendered: film every run and measure the pictures. rng, workers,
    scheduler, overwrite, progress: as `calibrate` takes them.

    Raises FileNotFoundError for a calibration that is not there; FileExistsError where
    `out` must not be replaced; ValueError for what does not fit; RuntimeError where
    runs fail."""
    asked = Asked(
        folder_of(calibrated),
        rig,
        Path(out),
        beside=None if beside is None else recordings_of(beside),
        like=None if like is None else Path(like),
        settings=settings or {},
        draws=draws,
        packings=packings,
        rendered=rendered,
        rng=rng,
        workers=workers,
        scheduler=scheduler,
        overwrite=overwrite,
        quiet=not progress,
    )
    found, seen, compared = predict_into(asked)
    return PredictionSummary(
        rows(found),
        pd.DataFrame([vars(one) for one in compared], columns=BESIDE),
        found.runs,
        (*found.notes, *(seen.notes if seen else ())),
        asked.out,
        found,
    )
