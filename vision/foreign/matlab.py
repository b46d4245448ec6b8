"""Vectors in a MATLAB file (.mat, to version 7) as the columns of a table."""

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

MAGIC = (b"MATLAB 5.0 MAT-file", NEWER := b"MATLAB 7.3 MAT-file")
MOST_NUMBERS = 2_000_000


def columns_of(path: Path) -> list[list[object]]:
    """Names and values of the vectors of the commonest length, of variables and of
    fields of a struct, a row for each element. ValueError where the file is damaged,
    too large or newer."""
    from scipy.io import loadmat, whosmat

    with path.open("rb") as file:
        if file.read(len(NEWER)) == NEWER:
            raise ValueError("a MATLAB file of version 7.3; save it with -v7")
    try:
        held = {name: int(np.prod(shape)) for name, shape, _ in whosmat(path)}
        if sum(held.values()) > MOST_NUMBERS:
            raise ValueError(f"more than {MOST_NUMBERS:,} numbers")
        found = loadmat(path, squeeze_me=True, struct_as_record=False)
    except Exception as error:  # the library raises many kinds for a damaged file
        raise ValueError(f"the MATLAB file is damaged ({str(error)[:200]})") from error
    vectors = dict(_vectors({k: v for k, v in found.items() if k in held}))
    lengths = Counter(len(v) for v in vectors.values())
    if not lengths:
        return []
    most = max(lengths, key=lambda n: (lengths[n], n))
    kept = {name: v for name, v in vectors.items() if len(v) == most}
    rows: list[list[object]] = [[*kept]]
    rows += [[float(v) for v in row] for row in zip(*kept.values())]
    return rows


def _vectors(held: dict[str, Any]) -> list[tuple[str, np.ndarray]]:
    found = []
    for name, value in held.items():
        if fields := getattr(value, "_fieldnames", None):
            found += _vectors({field: getattr(value, field) for field in fields})
        elif isinstance(value, np.ndarray) and value.ndim == 1 and value.size > 1:
            found += [(name, value)] if value.dtype.kind in "iuf" else []
    return found
