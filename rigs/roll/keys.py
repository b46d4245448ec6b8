"""[roll] of recording.toml."""

from typing import Annotated, Literal

from pydantic import Field

from benchtwin.bench.section import Length, NotNegative, Section, TwoLengths


class Roll(Section):
    """A seed rolls down an incline and runs out on a level plate."""

    incline_deg: Annotated[float, Field(gt=0, lt=90, allow_inf_nan=False)] | None = None
    """Angle of the incline against the level plate."""
    incline_length_mm: Length | None = None
    """Path on the incline, from the release to its end."""
    direction: Literal["+x", "-x"] | None = None
    """Which way the seed rolls; the same plate run both ways tells whether it is
    level."""
    rail_gap_mm: Annotated[float, Field(gt=0, lt=2000, allow_inf_nan=False)] | None = (
        None
    )
    """Inside width between two rails that a ball rolls on. Absent: a plate."""
    level: bool | None = None
    """No where the seed stays on its incline. Absent: as the incline's length and the
    rows say."""
    plate_mm: TwoLengths | None = None
    """Length and width of the plate."""
    orientation: Literal["across", "any"] | None = None
    """How the seed lies when released: its longest axis across the way, or any way."""
    axis_sd_deg: NotNegative | None = None
    """Scatter of that axis."""
    slope_deg: Annotated[float, Field(gt=-5, lt=5)] | None = None
    """Slope of the level plate, positive where it falls towards +x."""
