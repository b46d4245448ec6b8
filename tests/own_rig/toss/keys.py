"""[toss] of recording.toml."""

from benchtwin.bench.section import Positive, Section


class Toss(Section):
    """A seed is thrown straight upwards."""

    speed_mm_s: Positive | None = None
    """How fast it leaves the hand."""
    flight_s: Positive | None = None
    """How long it is filmed."""
