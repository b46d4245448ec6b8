"""What rolls tell a calibration: the rolling friction of seed on steel."""

from benchtwin.bench import run_out
from benchtwin.bench.tells import ByCurve
from benchtwin.rigs.roll import RIG


def rolling_friction(run_out_mm: float, roll: dict) -> float | None:
    """Eq. 3 of the soybean paper: μ_r = S sin β/(S cos β + L), way S on the incline β,
    L beyond it.

    >>> lengths = {"incline_deg": 15.0, "incline_length_mm": 10.0}
    >>> round(rolling_friction(214.0, lengths), 5)
    0.01157
    """
    if "incline_deg" not in roll or "incline_length_mm" not in roll:
        return None
    lengths = roll["incline_length_mm"], roll["incline_deg"]
    return run_out.rolling_friction(*lengths, run_out_mm)[0]


# limits and steps span what seeds on steel can show, with room; the seed's range spans
# what is published of seeds on seeds, 0.04 to 0.083 (docs/seeds.md), with room, its
# limits what the simulation still follows
TELLS = ByCurve(
    rig=RIG,
    parameter="rolling_friction",
    equation="Eq. 7",
    limits=(0.0005, 1.0),
    step=0.004,
    first=0.02,
    assumed=0.01,
    formula_name="Eq. 3",
    formula=rolling_friction,
    seed_range=(0.005, 0.12),
    seed_limits=(0.0005, 0.5),
)
