"""What draw-downs tell a calibration: the parameters of seed on seed, and which thinner
box is simulated in the place of a deep one."""

from benchtwin.bench.language import tr
from benchtwin.bench.priors import unstated_sd
from benchtwin.bench.tells import Believed, BySurface
from benchtwin.rigs.drawdown import RIG

PANES = Believed(0.3, unstated_sd("pane-friction"), (0.1, 0.5))


def slice_of(
    stated: dict, width_mm: float | None, fill_mm: float
) -> tuple[dict, tuple[str, ...]]:
    """[drawdown] of the simulations, and a note where it is not the bench's own: of a
    box deeper than `width_mm`, a slice between smooth panes. A filling is simulated as
    high as it is: slope, heap and time depend on it."""
    box = stated.get("box_mm")
    if width_mm is None or box is None or box[1] <= width_mm:
        return dict(stated), ()
    length, _, height = box
    slab = {"box_mm": [length, width_mm, height], "slab": True}
    note = tr(
        "the draw-down was simulated as a slice {:g} mm deep between smooth panes, in"
        " place of the box as described: --whole-pile simulates that",
        width_mm,
    )
    return stated | slab, (note,)


def left_open(stated: dict) -> dict[str, Believed]:
    """Friction on the panes, where they rub and it is not stated."""
    known = stated.get("slab") or "pane_friction" in stated
    return {} if known else {"pane_friction": PANES}


TELLS = BySurface(
    rig=RIG,
    simulated=slice_of,
    shown=lambda stated: {},
    not_seen=("true_photo_s", "true_lies_still", "true_jammed", "true_tray_mass_g"),
    minutes=4.0,
    ratios={"retained_share": ("retained_mass_g", "filled_mass_g")},
    left_open=left_open,
)
