"""What draw-downs tell a calibration: the parameters of seed on seed, and which thinner
box is simulated in the place of a deep one."""

from benchtwin.bench.tells import BySurface
from benchtwin.rigs.drawdown import RIG


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
    note = (
        f"the draw-down was simulated as a slice {width_mm:g} mm deep between smooth"
        " panes, in place of the box as described: --whole-pile simulates that"
    )
    return stated | slab, (note,)


TELLS = BySurface(
    rig=RIG,
    simulated=slice_of,
    shown=lambda stated: {},
    not_seen=("true_photo_s", "true_lies_still", "true_jammed", "true_tray_mass_g"),
    minutes=4.0,
)
