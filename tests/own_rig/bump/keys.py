"""[bump] of recording.toml."""

from benchtwin.bench.section import Positive, Section


class Bump(Section):
    """A seed on a thread, drawn aside, swings against a wall."""

    start_deg: Positive | None = None
    """How far it is drawn aside, from the vertical."""
