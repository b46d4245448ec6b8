"""`benchtwin.simulate`: contact parameters → recordings of a simulated rig, measured
like the bench's own."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

import pandas as pd
from plotly.graph_objects import Figure

from benchtwin import shown
from benchtwin.blas import on_one_blas_thread
from benchtwin.measuring import Measurements, measure
from benchtwin.twin.campaign.results import Measurement
from benchtwin.twin.engine import Engine
from benchtwin.twin.parameters import Parameters
from benchtwin.twin.run import RECORD
from benchtwin.twin.simulate_command import check_ready, jobs_of, run_jobs


@dataclass(frozen=True, eq=False)
class Simulations:
    """Simulated recordings. folder: the bench folder that holds them; names: theirs;
    measured: what is measured on them."""

    folder: Path
    names: tuple[str, ...]
    measured: Measurements

    @property
    def truth(self) -> pd.DataFrame:
        """A row a recording: what the simulation itself knows of the answer, units at
        the end of the columns' names."""
        return pd.DataFrame(
            [{"recording": name} | _truth(self.folder / name) for name in self.names]
        )

    def plot(self) -> Figure:
        """What is measured on each recording, as `Measurements.plot`, and beside it as
        grey crosses what the simulation itself knows of it."""
        figure, truth = self.measured.plot(), self.truth.set_index("recording")
        table = self.measured.quantities.dropna(subset="value")
        groups = table.groupby(["rig", "quantity", "unit"], sort=False)
        for k, ((_, quantity, unit), rows) in enumerate(groups):
            column = Measurement(quantity, 0.0, 0.0, unit).column()
            name = column if column in truth else quantity
            if name in truth:
                known = [truth[name].get(r) for r in rows["recording"]]
                cross = {"symbol": "x-thin", "size": 12, "line": {"width": 2}}
                marked = shown.points(rows["recording"], known) | {"marker": cross}
                figure.add_trace(
                    marked, row=1 + k // 2, col=1 + k % 2 if len(groups) > 1 else 1
                )
        return figure

    def _repr_html_(self) -> str:
        cells = self.truth.map(lambda v: f"{v:.4g}" if isinstance(v, float) else v)
        return self.measured._repr_html_() + shown.html("The simulation knows", cells)


@on_one_blas_thread
def simulate(
    rig: str,
    parameters: Parameters | None = None,
    *,
    out: str | Path,
    repeats: int = 1,
    rng: int = 1,
    settings: Mapping[str, object] | None = None,
    like: str | Path | None = None,
    rendered: bool = False,
    threads: int = 2,
    engine: str = "benchtwin",
    ranks: int = 1,
    save: str | None = None,
    start: str | Path | None = None,
    progress: bool = False,
) -> Simulations:
    """Simulate a rig into the bench folder `out`, and measure that as if it came from
    the bench.

    rig: drop, slide, roll, pile, cylinder (a pile from a lifting one), drum (rotating),
    or a rig of your own. parameters: contact parameters, else those that the soybean
    paper calibrated. repeats: recordings, each with seeds, placing and packing of its
    own; rng: seed of the random numbers. settings: keys of recording.toml by their
    dotted names, {"drop.height_mm": 200.0}. like: a recording whose rig, seed and
    camera to copy. rendered: film or photograph the run, else its track is written.
    threads: processor cores for one pile. engine: "benchtwin" or "lammps"; ranks:
    processes that share one LAMMPS pile. save: "vtkhdf" for state.vtkhdf in each
    recording, the last state with its contacts; start: such a file, whose heap a pile
    or cylinder begins with. progress: shown on stderr.

    Called again, it goes on where it was stopped. Raises ValueError for a rig, number
    or setting that does not fit; FileExistsError where `out` holds other recordings of
    these names; RuntimeError where a run cannot end."""
    numbers = asdict(parameters or Parameters())
    folder = Path(out)
    jobs = jobs_of(
        rig,
        numbers,
        repeats,
        rng,
        settings or {},
        None if like is None else Path(like),
        rendered,
        Engine(engine, ranks),
        None if start is None else Path(start),
    )
    check_ready(jobs, save)
    run_jobs(jobs, rig, folder, threads, not progress, save)
    names = tuple(
        f"{rig}-{n:0{max(2, len(str(repeats)))}d}" for n in range(1, repeats + 1)
    )
    return Simulations(folder, names, measure([folder / name for name in names]))


def _truth(recording: Path) -> dict[str, float | None]:
    truth: dict[str, float | None] = json.loads(
        (recording / RECORD).read_text(encoding="utf8")
    )["truth"]
    return truth
