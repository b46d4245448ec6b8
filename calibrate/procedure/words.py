"""What a calibration found, in sentences."""

import pandas as pd

FREE_SAID = 2  # pairs of parameters that are told together


def in_status(status: str, remark: str) -> str:
    """ "only bounded: at least 0.436; nothing is known beyond 0.7"."""
    return f"{status}: {remark}" if remark else status


def ties_in_words(ties: pd.DataFrame) -> list[str]:
    """A sentence on each of the closest pairs of `trade_offs`."""
    return [
        f"{row.one} and {row.other} are known together rather than each by itself: with"
        f" a higher {row.one} and a {'lower' if row.correlation < 0 else 'higher'}"
        f" {row.other} the recordings would look the same"
        for row in ties.head(FREE_SAID).itertuples()
    ]
