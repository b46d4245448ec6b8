"""What heaps tell a calibration: the parameters of seed on seed, and which smaller heap
is simulated in the bench's place."""

from benchtwin.bench.language import tr
from benchtwin.bench.tells import BySurface
from benchtwin.rigs.pile import RIG

# the paper's rig, for a bench that states none: box, plate, filling
BOX_MM, PLATE_MM, HIGH_MM = (105.0, 105.0, 200.0), (200.0, 200.0), 100.0
# a picture wide enough to see single seeds; its margin beside the plate; and the height
# of its middle in widths of the plate: half as high as wide, it begins below the plate
WIDTH_PX, MARGIN_MM, MIDDLE = 1600, 20, 0.22


def slice_of(
    stated: dict, width_mm: float | None, fill_mm: float
) -> tuple[dict, tuple[str, ...]]:
    """[pile] of the simulations, and a note where it is not the bench's own.

    A slice as long as the box between smooth sides takes the place of a pile that is
    wider or filled higher; a bench that is such a slice itself, a lifted cylinder, or a
    channel, whose walls hold seeds back, is simulated as it is, as all are without a
    width."""
    filled = stated.get("fill_height_mm", HIGH_MM)
    low = "fill_height_mm" in stated and filled <= fill_mm
    small = stated.get("slab") and low
    as_it_is = small or stated.get("cylinder_mm") or stated.get("channel_mm")
    if width_mm is None or as_it_is:
        return dict(stated), ()
    length, _, height = stated.get("box_mm", BOX_MM)
    fill = min(fill_mm, filled)
    slab = {
        "box_mm": [length, width_mm, height],
        "gate_mm": [width_mm, height],
        "plate_mm": [stated.get("plate_mm", PLATE_MM)[0], width_mm],
        "fill_height_mm": fill,
        "slab": True,
    }
    kept = {k: v for k, v in stated.items() if k in ("gate_speed_mm_s", "photo_s")}
    note = tr(
        "the pile was simulated as a slice {:g} mm wide between smooth sides, filled"
        " {:g} mm high, in place of the pile as described: --whole-pile simulates that",
        width_mm,
        fill,
    )
    return slab | kept, (note,)


def whole_plate(pile: dict) -> dict:
    """A camera that sees all of the plate beside the box, or of the channel, and some
    of what stands above it; the rig's own for a cylinder."""
    floor = pile.get("channel_mm") or pile.get("plate_mm")
    if pile.get("cylinder_mm") or floor is None:
        return {}
    plate = float(floor[0])
    return {
        "width_px": WIDTH_PX,
        "height_px": WIDTH_PX // 2,
        "mm_per_px": (plate + MARGIN_MM) / WIDTH_PX,
        "target_mm": [plate / 2, 0.0, MIDDLE * plate],
    }


TELLS = BySurface(
    rig=RIG,
    simulated=slice_of,
    shown=whole_plate,
    not_seen=("true_photo_s", "true_lies_still"),
)
