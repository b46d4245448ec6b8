"""[slide] of recording.toml."""

from typing import Annotated

from pydantic import Field

from benchtwin.bench.section import (
    SIMULATED,
    Coverage,
    Length,
    NotNegative,
    Section,
    SeedPlate,
    TwoLengths,
)


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
    plate: SeedPlate | None = None
    """ "seeds": a card with seeds glued to its underside slides on a plate of seeds of
    the same lot, glued down in one layer. Absent: a smooth plate."""
    coverage: Coverage | None = None
    """Share of a plate of seeds, and of the card, that seeds cover, seen from above.
    Absent: as people lay them."""
    coverage_sd: NotNegative | None = None
    """sd of coverage; absent: 0.01, as of a count."""
    plate_photo: str | None = None
    """Photo of the plate of seeds from above, filled by it: coverage is read from it
    where none is stated."""
    card_mm: TwoLengths | None = None
    """Length, along the plate, and width of the card on a plate of seeds."""
    slides: Annotated[Annotated[int, Field(ge=1, le=1000)] | None, SIMULATED] = None
    """How often the card slides on each simulated plate of seeds."""
