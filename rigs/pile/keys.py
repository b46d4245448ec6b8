"""[pile] of recording.toml."""

from typing import Annotated

from benchtwin.bench.section import (
    FROM_LIST,
    SIMULATED,
    Extent,
    FourNumbers,
    Length,
    Pixel,
    Positive,
    Section,
    Share,
    ThreeLengths,
    TwoLengths,
)


class Pile(Section):
    """A box, or a cylinder, of seeds is let go and leaves a pile."""

    box_mm: ThreeLengths | None = None
    """Inside length (gate at its +x end), width and height of the box."""
    gate_mm: TwoLengths | None = None
    """Width and height of the gate."""
    cylinder_mm: TwoLengths | None = None
    """Inside diameter and height of a lifted cylinder, in the box's place."""
    plate_mm: TwoLengths | None = None
    """Length and width of the plate."""
    channel_mm: TwoLengths | None = None
    """Inside length and width of a channel in whose one end the box stands, its sides
    the box's and a wall at its far end; in the plate's place."""
    fill_height_mm: Length | None = None
    """How high the seeds were filled in."""
    gate_speed_mm_s: Positive | None = None
    """How fast the gate, or the cylinder, is lifted."""
    baseline_px: FourNumbers | None = None
    """The plate's line in the photo, x1, y1, x2, y2 (y down). Absent: found in the
    photo."""
    roi_px: Annotated[tuple[Pixel, Pixel, Extent, Extent], FROM_LIST] | None = None
    """Look only there in the photo: left, top, width, height."""
    window_pct: Annotated[tuple[Share, Share], FROM_LIST] | None = None
    """Heights, in % of the crest's, between which the line is fitted. Absent: 20 and
    80."""
    photo_s: Positive | None = None
    """When the photo was taken, after the gate began to move. Absent: when all seeds
    lay still."""
    side_walls_in_view: bool | None = None
    """Whether the camera looks through side walls."""
    slab: Annotated[bool | None, SIMULATED] = None
    """Whether only a slice of the pile, between smooth sides, is simulated."""
    plain: bool | None = None
    """Whether the seeds are known to be as usual: what heaps that do not say so show
    beyond this one is missing."""
    filled_mass_g: Positive | None = None
    """What was filled in, up to fill_height_mm; weighed, it tells more than the
    angle."""
    retained_mass_g: Positive | None = None
    """What is left when the photo is taken."""
