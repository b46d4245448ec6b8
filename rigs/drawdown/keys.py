"""[drawdown] of recording.toml."""

from typing import Annotated

from benchtwin.bench.section import (
    FROM_LIST,
    SIMULATED,
    Extent,
    FourNumbers,
    Length,
    NotNegative,
    Pixel,
    Positive,
    Section,
    ThreeLengths,
)

Region = Annotated[tuple[Pixel, Pixel, Extent, Extent], FROM_LIST]


class Drawdown(Section):
    """A box between two panes empties through a slot in its floor onto a tray."""

    box_mm: ThreeLengths | None = None
    """Inside length (from the back wall to the end wall), width (between the panes) and
    height of the box."""
    slot_mm: Length | None = None
    """How far the shelf ends before the end wall."""
    fill_height_mm: Length | None = None
    """How high the seeds were filled in."""
    fall_mm: Length | None = None
    """From the shelf's top down to the tray."""
    tray_mm: Length | None = None
    """Length of the tray; its middle stands below the slot's."""
    slide_speed_mm_s: Positive | None = None
    """How fast the slide below the slot is drawn out."""
    pane_friction: NotNegative | None = None
    """Static friction of seed on pane. Absent: unknown, and averaged over."""
    slab: Annotated[bool | None, SIMULATED] = None
    """Whether only a slice, between smooth panes, is simulated."""
    photo_s: Positive | None = None
    """When the photo was taken, after the slide began to move. Absent: when all seeds
    lay still."""
    filled_mass_g: Positive | None = None
    """What was filled in, up to fill_height_mm."""
    retained_mass_g: Positive | None = None
    """What is left in the box."""
    tray_mass_g: Positive | None = None
    """What lies on the tray."""
    spilt_mass_g: NotNegative | None = None
    """What ran over the tray's ends."""
    flow_time_s: Positive | None = None
    """How long the middle of the flow took, from when a tenth of what comes out was
    through the slot to when nine tenths were."""
    jammed: bool | None = None
    """Whether an arch over the slot ended the flow."""
    upper_px: Region | None = None
    """Where the slope above is in the photo: left, top, width, height."""
    lower_px: Region | None = None
    """Where the heap below is in the photo."""
    shelf_px: FourNumbers | None = None
    """The shelf's top in the photo, x1, y1, x2, y2 (y down). Absent: found."""
    tray_px: FourNumbers | None = None
    """The tray's top in the photo. Absent: found."""
