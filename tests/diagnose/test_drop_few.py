"""Diagnosis of drops of few rows and past light gates: none refused, clean ones raise
no alarm, a falling restitution is seen."""

from pathlib import Path

import numpy as np
import pytest
from test_drop_few_rows import flights

from benchtwin.rigs.drop.diagnose import diagnose_drop
from benchtwin.rigs.drop.read import read_drops

SEED = "length_mm = 40\nwidth_mm = 40\nthickness_mm = 40\nmass_g = 150\n"


def bench(
    folder: Path,
    count: int,
    rng: np.random.Generator,
    *,
    gates: bool,
    falls: float = 0.0,
) -> Path:
    """Drops from 0.3 to 1.5 m of a ball whose restitution falls by `falls` per m/s."""
    folder.mkdir()
    camera = "" if gates else "[camera]\nmm_per_px = 0.5\nmm_per_px_sd = 0.0005\n"
    (folder / "bench.toml").write_text(f'rig = "drop"\n[seed]\n{SEED}{camera}')
    for k in range(count):
        high = rng.uniform(0.3, 1.5)
        e = 0.75 - falls * (np.sqrt(2 * 9.8 * high) - 4) + 0.004 * rng.standard_normal()
        t, y, _, hit = flights(high, e)
        run = folder / f"drop-{k:02d}"
        run.mkdir()
        if gates:
            places = np.array([0.03, 0.08, 0.13])
            down, up = (
                t <= hit,
                (t >= hit) & (t <= t[np.argmax(np.where(t > hit, y, 0))]),
            )
            time = np.append(
                np.interp(places[::-1], y[down][::-1], t[down][::-1]),
                np.interp(places, y[up], t[up]),
            )
            time = time + 2e-5 * rng.standard_normal(6)
            rows = "y_mm,t_s\n" + "".join(
                f"{p:.3f},{s:.7f}\n"
                for p, s in zip(1000 * np.append(places[::-1], places), time)
            )
            (run / "gates.csv").write_text(rows)
        else:
            time = np.linspace(0.03, 0.97 * t[-1], rng.integers(8, 12))
            seen = 1000 * np.interp(time, t, y) + 0.3 * rng.standard_normal(len(time))
            rows = "t_s,x_mm,y_mm\n" + "".join(
                f"{s:.6f},{0.3 * n:.4f},{p:.4f}\n"
                for s, p, n in zip(time, seen, rng.standard_normal(20))
            )
            (run / "track.csv").write_text(rows)
        (run / "recording.toml").write_text("")
    return folder


FALSE_ALARMS = pytest.mark.xfail(
    strict=True,
    reason=(
        "light gates' errors grow with the speed, the diagnosis counts them as equal: 2"
        " of these 4 benches alarm"
    ),
)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("gates", "seeds"),
    [
        pytest.param(True, (1, 2, 3, 4), marks=[FALSE_ALARMS, pytest.mark.slow]),
        (False, (1,)),
    ],
)
def test_drops_of_few_rows_are_diagnosed(tmp_path, gates, seeds):
    alarms = []
    for seed in seeds:
        clean = read_drops(
            bench(tmp_path / str(seed), 10, np.random.default_rng(seed), gates=gates)
        )
        assert not [d.trouble for d in clean if d.trouble]
        found = diagnose_drop(clean, np.random.default_rng(0))
        assert len(found.recordings) == 10
        alarms.append(found.alarm)
    assert sum(alarms) <= 1  # one in a hundred by chance
