"""Every force law, and the core of every contact, runs unchanged as a CUDA device
function and gives the CPU's numbers.

numba-cuda's simulator shows that a law is callable from a kernel and right there. It
runs Python, so it does not show that the law compiles: where NVIDIA's compiler
libraries are found too (nvidia-nvvm and nvidia-cuda-nvrtc from PyPI; no GPU is needed),
the second test makes device code (PTX) of each."""

import os
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest
from law_samples import arity, functions, samples

ROWS = 40


def table_of(name: str, ranges) -> np.ndarray:
    return samples(ranges, ROWS, np.random.default_rng(sum(map(ord, name))))


def outputs(function, row) -> int:
    result = function(*map(float, row))
    return len(result) if isinstance(result, tuple) else 1


def loop_source(arguments: int, count: int, on_gpu: bool) -> str:
    """A loop over rows that calls `law`, written out for its number of arguments and
    results: kernels know no star-arguments."""
    call = f"law({', '.join(f'table[i, {k}]' for k in range(arguments))})"
    head = (
        ["    i = cuda.grid(1)", "    if i < len(table):"]
        if on_gpu
        else ["    for i in range(len(table)):"]
    )
    store = (
        [f"        out[i, {k}] = result[{k}]" for k in range(count)]
        if count > 1
        else ["        out[i, 0] = result"]
    )
    return "\n".join(
        ["def loop(table, out):", *head, f"        result = {call}", *store]
    )


def run_on_simulator(folder: Path) -> None:
    """In a process of its own, with NUMBA_ENABLE_CUDASIM=1 set before numba is
    imported."""
    from numba import cuda

    for name, function, ranges in functions():
        table = table_of(name, ranges)
        out = np.full((ROWS, outputs(function, table[0])), np.nan)
        names = {"cuda": cuda, "law": cuda.jit(device=True)(function)}
        exec(loop_source(arity(function), out.shape[1], on_gpu=True), names)
        cuda.jit(names["loop"])[1, 64](table, out)
        np.save(folder / f"{name}.npy", out)


def test_every_law_gives_the_same_numbers_on_the_simulator(tmp_path):
    environment = {
        **os.environ,
        "NUMBA_ENABLE_CUDASIM": "1",
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
    }
    done = subprocess.run(
        [sys.executable, __file__, str(tmp_path)],
        env=environment,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    for name, function, ranges in functions():
        table, simulated = table_of(name, ranges), np.load(tmp_path / f"{name}.npy")
        names = {"law": numba.njit(function)}
        exec(loop_source(arity(function), simulated.shape[1], on_gpu=False), names)
        ours = np.empty_like(simulated)
        numba.njit(names["loop"])(table, ours)
        # pow and exp of two libraries may differ in the last bit, and differences of
        # large terms show it.
        scale = np.abs(ours).max(axis=0)
        assert np.isfinite(simulated).all() and np.allclose(
            simulated, ours, rtol=1e-12, atol=1e-13 * scale
        ), name


def device_code(function, row) -> str:
    from numba import cuda, types

    count = outputs(function, row)
    result = types.float64 if count == 1 else types.UniTuple(types.float64, count)
    code, _ = cuda.compile(
        function,
        result(*[types.float64] * len(row)),
        device=True,
        abi="numba",
        cc=(8, 0),
        output="ptx",
    )
    return code


def test_every_law_compiles_to_device_code():
    try:
        device_code(lambda x: x + 1.0, [1.0])
    except (
        Exception
    ) as missing:  # whatever numba-cuda raises where NVIDIA's libraries are not found
        pytest.skip(
            f"no NVIDIA compiler library here: {str(missing).splitlines()[0][:80]}"
        )
    for name, function, ranges in functions():
        code = device_code(function, table_of(name, ranges)[0])
        assert ".func" in code and function.__name__ in code, name


if __name__ == "__main__":
    run_on_simulator(Path(sys.argv[1]))
