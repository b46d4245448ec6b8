"""What a calibration found, in sentences."""

import pandas as pd

from benchtwin.bench.language import tr

FREE_SAID = 2  # pairs of parameters that are told together


def in_status(status: str, remark: str) -> str:
    """ "only bounded: at least 0.436; nothing is known beyond 0.7"."""
    return f"{tr(status)}: {remark}" if remark else tr(status)


def ties_in_words(ties: pd.DataFrame) -> list[str]:
    """A sentence on each of the closest pairs of `trade_offs`."""
    return [
        tr(
            "{} and {} are known together rather than each by itself: with a higher {}"
            " and a {} {} the recordings would look the same",
            row.one,
            row.other,
            row.one,
            tr("lower") if row.correlation < 0 else tr("higher"),
            row.other,
        )
        for row in ties.head(FREE_SAID).itertuples()
    ]
