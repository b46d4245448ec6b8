"""Everything under some paths, measured one after the other."""

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

from benchtwin.measure.batch import find_all, measure_each
from benchtwin.measure.observe import observe, observe_or_fail
from benchtwin.vision.measurement import Observation
from benchtwin.vision.pile.repose import PileOptions


def measure(
    paths: str | Path | Sequence[str | Path],
    options: PileOptions | None = None,
    trim: bool = False,
) -> Iterator[Observation]:
    """Observations of all recordings under `paths` (one path or several), one after the
    other; those of several together last."""
    chosen = [paths] if isinstance(paths, str | Path) else paths
    entries = find_all([Path(path) for path in chosen])
    measured = partial(observe, options=options, trim=trim)
    yield from measure_each(entries, lambda entry, _: observe_or_fail(entry, measured))
