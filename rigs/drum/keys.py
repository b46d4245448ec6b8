"""[drum] of recording.toml."""

from typing import Annotated

from pydantic import Field

from benchtwin.bench.section import SIMULATED, Positive, Section, TwoLengths


class Drum(Section):
    """Seeds flow in a drum that turns about a level axis; the camera looks along it."""

    drum_mm: TwoLengths | None = None
    """Inside diameter and width."""
    fill_share: Annotated[float, Field(ge=0.1, le=0.6)] | None = None
    """Share of its cross-section that the seeds fill."""
    speed_rpm: Annotated[float, Field(gt=0, le=600, allow_inf_nan=False)] | None = None
    """Turns a minute."""
    lining_friction: Annotated[float, Field(ge=0, le=3)] | None = None
    """Static friction of its inside in a simulation. Absent: 0.9, a lining on which
    nothing slips."""
    wait_s: Positive | None = None
    """How long it turns before the film begins."""
    film_s: Annotated[Positive | None, SIMULATED] = None
    """How long a simulated film is."""
