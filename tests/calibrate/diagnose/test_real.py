"""Real ball drops, air withheld (shared/real/ball-drops): light balls show drag or its rivals, a bowling ball nothing."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from calibrate.diagnose.rigs.drop.diagnose import diagnose_drop
from calibrate.twin.tracks import SeenTrack

DATA = Path(__file__).parents[4] / "shared" / "real" / "ball-drops"
BEGUN_S = 0.2  # t = 0 is not exactly the release


def ball(which):
    drops = pd.read_csv(DATA / "drops.csv")
    about = pd.read_csv(DATA / "balls.csv").set_index("ball").loc[which]
    camera = {"fps": 15.0, "scale_sd": 0.01, "plumb_sd_deg": 0.5}
    told = {"seed": {"length_mm": 1e3 * about.diameter_m, "mass_g": 1e3 * about.mass_kg}, "camera": camera}
    told |= {"air": {"density_kg_m3": 0.0}, "drop": {}}
    for number, rows in drops[drops.ball == which].groupby("drop"):
        time, n = rows.t_s.to_numpy(), len(rows)
        flight, up = np.where(time > BEGUN_S, 0, -1), 1e3 * rows.height_m.to_numpy()
        unseen = np.full(n, np.nan)
        yield SeenTrack(f"{which}-{number}", "", np.arange(n), time, 0 * up, up, unseen, None, flight, np.zeros(0), False, told)


@pytest.mark.skipif(not DATA.is_dir(), reason="shared/real/ball-drops is not here")
@pytest.mark.parametrize(
    ("which", "alarmed"), [("Orange Whiffle Ball", True), ("Yellow Whiffle Ball", True), ("Bowling Ball", False)]
)
def test_drag_of_real_balls(which, alarmed):
    found = diagnose_drop(list(ball(which)), np.random.default_rng(0))
    assert (found.verdict != "none") == alarmed
    if alarmed:  # nothing that is not there is named, beside drag; of two films a force along the flight may be drag's own
        assert found.sectors[0].name == "flight" and set(found.names) <= {"drag", "perspective", "scale-error", "clock-error"}
        assert found.effects["drag"].probability > 0.1
