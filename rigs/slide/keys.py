"""[slide] of recording.toml."""

from typing import Annotated

from pydantic import Field

from benchtwin.bench.section import Length, Section, TwoLengths


class Slide(Section):
    """A plate is raised about a hinge until the seeds on it slide."""

    tilt_rate_deg_s: (
        Annotated[float, Field(ge=0, lt=1000, allow_inf_nan=False)] | None
    ) = None
    """How fast the plate is raised, 0 where it stands; or give the angle of each row in
    the column tilt_deg of track.csv."""
    travel_mm: Length | None = None
    """How far the seeds can slide."""
    plate_mm: TwoLengths | None = None
    """Length and width of the plate."""
    start_mm: Length | None = None
    """Where the seeds lie at first, from the hinge."""
    start_deg: Annotated[float, Field(ge=0, lt=80)] | None = None
    """Angle of the plate when the recording begins."""
