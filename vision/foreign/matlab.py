"""Vectors in a MATLAB file (.mat, to version 7) as the columns of a table."""

import math
import struct
import zlib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

MAGIC = (b"MATLAB 5.0 MAT-file", NEWER := b"MATLAB 7.3 MAT-file")
MOST_NUMBERS = 2_000_000
MOST_BYTES = 32 * MOST_NUMBERS
HEADER = 128  # bytes before the first element
MATRIX, COMPRESSED = 14, 15  # types of elements
DEEPEST = 16  # structs within structs


def columns_of(path: Path) -> list[list[object]]:
    """Names and values of the vectors of the commonest length, of variables and of
    fields of a struct, a row for each element. ValueError where the file is damaged,
    too large or newer."""
    from scipy.io import loadmat

    with path.open("rb") as file:
        if file.read(len(NEWER)) == NEWER:
            raise ValueError("a MATLAB file of version 7.3; save it with -v7")
    try:
        if _numbers_in(path.read_bytes()) > MOST_NUMBERS:
            raise ValueError(f"more than {MOST_NUMBERS:,} numbers")
        found = loadmat(path, squeeze_me=True, struct_as_record=False)
    except Exception as error:  # the library raises many kinds for a damaged file
        raise ValueError(f"the MATLAB file is damaged ({str(error)[:200]})") from error
    vectors = dict(_vectors({k: v for k, v in found.items() if k[:2] != "__"}))
    lengths = Counter(len(v) for v in vectors.values())
    if not lengths:
        return []
    most = max(lengths, key=lambda n: (lengths[n], n))
    kept = {name: v for name, v in vectors.items() if len(v) == most}
    rows: list[list[object]] = [[*kept]]
    rows += [[float(v) for v in row] for row in zip(*kept.values())]
    return rows


def _numbers_in(raw: bytes) -> int:
    """How many numbers the arrays of a file say that they hold, in structs and cells,
    too; nothing of it is unfolded that is too large. ValueError where something is."""
    order = ">" if raw[126:128] == b"MI" else "<"
    left, count = MOST_BYTES, 0
    for kind, data in _elements(memoryview(raw)[HEADER:], order):
        if kind == COMPRESSED:
            unfolded = zlib.decompressobj().decompress(data, left + 1)
            if (left := left - len(unfolded)) < 0:
                raise ValueError(f"more than {MOST_BYTES:,} bytes unfolded")
            data = memoryview(unfolded)
            count += sum(_held(d, order) for k, d in _elements(data, order))
        elif kind == MATRIX:
            count += _held(data, order)
    return count


def _held(matrix: memoryview, order: str, depth: int = 0) -> int:
    """Numbers that an array says it holds (its second part is its shape), and those of
    the arrays in it."""
    if depth > DEEPEST:
        raise ValueError("arrays within arrays, too deep")
    parts = [*_elements(matrix, order)]
    shape = np.frombuffer(parts[1][1], f"{order}u4") if len(parts) > 1 else ()
    return math.prod(map(int, shape)) * bool(len(shape)) + sum(
        _held(data, order, depth + 1) for kind, data in parts[2:] if kind == MATRIX
    )


def _elements(data: memoryview, order: str) -> Iterator[tuple[int, memoryview]]:
    """Type and content of one element of a file after the other."""
    at = 0
    while at + 8 <= len(data):
        kind, size = struct.unpack_from(f"{order}II", data, at)
        begin = at + 8
        if kind >> 16:  # a small one, in the place of its size
            kind, size, begin = kind & 0xFFFF, kind >> 16, at + 4
        yield kind, data[begin : begin + size]
        at = max(begin + size, at + 8)
        at += 0 if kind == COMPRESSED else -at % 8


def _vectors(held: dict[str, Any]) -> list[tuple[str, np.ndarray]]:
    found = []
    for name, value in held.items():
        if fields := getattr(value, "_fieldnames", None):
            found += _vectors({field: getattr(value, field) for field in fields})
        elif isinstance(value, np.ndarray) and value.ndim == 1 and value.size > 1:
            found += [(name, value)] if value.dtype.kind in "iuf" else []
    return found
