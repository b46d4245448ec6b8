"""[bed] of recording.toml."""

from typing import Annotated

from pydantic import Field

from benchtwin.bench.section import SIMULATED, Length, Section, ThreeLengths


class Bed(Section):
    """A seed falls onto a bed of seeds."""

    box_mm: ThreeLengths | None = None
    """Inside length, width and height of the box that holds the bed."""
    depth_mm: Length | None = None
    """How deep the bed is, struck off level."""
    height_mm: Length | None = None
    """From the bed's surface up to the seed's lowest point at the release."""
    drops: Annotated[Annotated[int, Field(ge=1, le=1000)] | None, SIMULATED] = None
    """How many seeds fall on each simulated bed."""
