"""[drop] of recording.toml."""

from typing import Annotated, Literal

from pydantic import Field

from benchtwin.bench.priors import stated_sd, usable_sd
from benchtwin.bench.section import (
    FROM_LIST,
    SIMULATED,
    Coverage,
    Finite,
    FourNumbers,
    Length,
    NotNegative,
    Section,
    SeedPlate,
    TwoLengths,
    Vector,
)


class Drop(Section):
    """A seed falls on a plate and rebounds."""

    height_mm: Length | None = None
    """Release to plate, of the seed's lowest point."""
    height_sd_mm: NotNegative | None = None
    """sd of height_mm, common to a session; absent: 5 mm, as of hands and rulers."""
    plate_mm: TwoLengths | None = None
    """Length and width of the plate."""
    bounces: Annotated[Annotated[int, Field(ge=1, le=100)] | None, SIMULATED] = None
    """How many bounces are simulated."""
    orientation: Literal["flat", "any"] | FourNumbers | None = None
    """How the seed lies when released: "flat", "any", or a quaternion."""
    tip_sd_deg: NotNegative | None = None
    """Scatter of that about flat."""
    spin_rad_s: Vector | None = None
    """Spin at the release."""
    spin_sd_rad_s: NotNegative | None = None
    """Scatter of the spin at the release."""
    hold_s: NotNegative | None = None
    """How long the film runs before the release."""
    tilt_deg: Annotated[float, Field(gt=-15, lt=15)] | None = None
    """Tilt of the plate, falling towards +x."""
    plate: SeedPlate | None = None
    """ "seeds": what it falls on is seeds of its own lot, glued down in one layer.
    Absent: a smooth plate."""
    coverage: Coverage | None = None
    """Share of a plate of seeds that they cover, seen from above. Absent: as people lay
    them."""
    coverage_sd: NotNegative | None = None
    """sd of coverage; absent: 0.01, as of a count."""
    plate_photo: str | None = None
    """Photo of the plate of seeds from above, filled by it: coverage is read from it
    where none is stated."""
    glue_loss: Annotated[float, Field(ge=0, lt=1)] | None = None
    """Share that the glue of a plate of seeds takes of what an impact gives back of the
    energy. Absent: as of hard glue."""
    drops: Annotated[Annotated[int, Field(ge=1, le=1000)] | None, SIMULATED] = None
    """How many seeds fall on each simulated plate of seeds."""
    impacts_added_s: Annotated[tuple[Finite, ...], FROM_LIST] | None = None
    """Moments in the sound at which an impact was not found."""
    impacts_struck_s: Annotated[tuple[Finite, ...], FROM_LIST] | None = None
    """Moments in the sound at which something was taken for an impact that is none."""

    @property
    def height_sd(self) -> float:
        """sd of height_mm [mm], as stated, else of heights that people state."""
        if self.height_sd_mm is None:
            return stated_sd("release-height")
        return usable_sd("release-height", self.height_sd_mm)

    @property
    def used_sds(self) -> dict[str, float]:
        return {"height_sd_mm": self.height_sd}
