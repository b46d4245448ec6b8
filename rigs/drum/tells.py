"""What drums tell a calibration: the parameters of seed on seed, and which narrower
drum is simulated in the place of a wide one."""

from benchtwin.bench.language import tr
from benchtwin.bench.tells import BySurface
from benchtwin.rigs.drum import RIG, keys
from benchtwin.sim.rigs.drum import Drum
from benchtwin.twin.scene import section_of

# what the angle depends on; width: only by its end walls, and a slice has none
NEEDED = ("drum_mm", "fill_share", "speed_rpm")


def slice_of(
    stated: dict, width_mm: float | None, fill_mm: float
) -> tuple[dict, tuple[str, ...]]:
    """[drum] of the simulations, and notes where it is not the bench's own: a drum
    wider than `width_mm` is simulated as a slice, and what is not stated is assumed."""
    whole = section_of(Drum(), keys.Drum()).model_dump(mode="json")
    notes = tuple(
        tr(
            "[drum] {} is not stated: {} is assumed; measure and state it",
            key,
            whole[key],
        )
        for key in NEEDED
        if key not in stated
    )
    diameter, width = stated.get("drum_mm", whole["drum_mm"])
    if width_mm is None or width <= width_mm:
        return dict(stated), notes
    note = tr(
        "the drum was simulated as a slice {:g} mm wide between smooth ends, in place"
        " of the drum as described: --whole-pile simulates that",
        width_mm,
    )
    return stated | {"drum_mm": [diameter, width_mm]}, (*notes, note)


TELLS = BySurface(rig=RIG, simulated=slice_of, shown=lambda stated: {}, minutes=5.0)
