"""A campaign resumed after a stop: what is finished is not computed again.

Simulated recordings lie in a bench folder, each known by a key of everything that
decides its outcome. The same call goes on where it was stopped: here two rolls are lost
of three, and only these are run again, to the last bit alike."""

import shutil
import tempfile
from pathlib import Path

from benchtwin import simulate

out = Path(tempfile.mkdtemp())
first = simulate("roll", out=out, repeats=3)
before = first.measured.table["run_out_mm"].tolist()
kept = (out / "roll-01" / "track.csv").stat().st_mtime_ns
for lost in ("roll-02", "roll-03"):
    shutil.rmtree(out / lost)

again = simulate("roll", out=out, repeats=3)
after = again.measured.table["run_out_mm"].tolist()
untouched = (out / "roll-01" / "track.csv").stat().st_mtime_ns == kept
print(f"run-outs {before} and again {after}; the first was kept: {untouched}")

picture = again.plot()
