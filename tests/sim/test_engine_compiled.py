"""Where compiled kernels are kept, and that code made from other laws is never taken
for these."""

import gc
import math
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from numba.core.errors import TypingError

from benchtwin.sim.engine import compiled, step
from benchtwin.sim.engine.view import View
from benchtwin.sim.engine.walls import Plane
from benchtwin.sim.engine.world import Placed, World
from benchtwin.sim.material import Q235, SOYBEAN, SOYBEAN_Q235, SOYBEAN_SOYBEAN
from benchtwin.sim.seed import Seed


@pytest.fixture
def fresh_choice(monkeypatch):
    compiled.cache_folder.cache_clear()
    yield monkeypatch
    monkeypatch.undo()
    compiled.cache_folder.cache_clear()


def test_kernels_go_where_the_user_says(fresh_choice, tmp_path):
    fresh_choice.setenv("NUMBA_CACHE_DIR", str(tmp_path / "here"))
    assert compiled.cache_folder() == tmp_path / "here"


def test_else_into_the_users_cache_folder_and_never_beside_the_source(
    fresh_choice, tmp_path
):
    fresh_choice.delenv("NUMBA_CACHE_DIR", raising=False)
    fresh_choice.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert compiled.cache_folder() == tmp_path / "benchtwin" / "kernels"


def test_else_into_the_temporary_folder(fresh_choice, tmp_path):
    """A folder that cannot be made: its parent is a file."""
    (tmp_path / "file").write_text("")
    fresh_choice.setenv("NUMBA_CACHE_DIR", str(tmp_path / "file" / "a"))
    fresh_choice.setenv("XDG_CACHE_HOME", str(tmp_path / "file" / "b"))
    fresh_choice.setattr(compiled.tempfile, "gettempdir", lambda: str(tmp_path))
    assert compiled.cache_folder().parent == tmp_path


def test_threads_that_make_kernels_at_once_keep_them_in_the_same_folder(
    fresh_choice, tmp_path
):
    """numba's setting is one for all threads: it is as before, and each kernel's folder
    is ours."""
    fresh_choice.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    fresh_choice.setattr(compiled.numba.config, "CACHE_DIR", "")
    njit, rng = compiled.numba.njit, np.random.default_rng(1)

    def slow_njit(**options):
        time.sleep(rng.uniform(0, 2e-3))  # in which another thread may come between
        return njit(**options)

    def twice(x):
        return 2.0 * x

    fresh_choice.setattr(compiled.numba, "njit", slow_njit)
    with ThreadPoolExecutor(8) as pool:
        made = list(pool.map(lambda k: compiled.kernel(twice, f"{k}"), range(64)))
    folders = {Path(kernel._cache.cache_path).parent for kernel in made}
    assert folders == {tmp_path} and compiled.numba.config.CACHE_DIR == ""


def total(s: View, first):
    out = 0.0
    for k in range(first, len(s.motion)):
        out += math.sin(s.motion[k]) / max(s.load[k], 1e-3)
        if out > 1e3:
            return out
    return out


def both(s, first):
    return total(s, first) + 0.5 * total(s, first + 1)


def unknown(s, first):
    return s.nothing


def test_the_quicker_compiler_gives_what_numbas_own_gives():
    """To the last bit, of a part that takes a View; and the search for garbage goes on
    afterwards, when a function cannot be compiled, too."""
    rng = np.random.default_rng(7)
    seen = View(**{name: rng.normal(size=50) for name in View._fields})
    numbas = {k: v for k, v in compiled.OPTIONS.items() if k != "pipeline_class"}
    njit = compiled.numba.njit
    quick = njit(**compiled.OPTIONS)(compiled.bind(both, {}))
    part = {"total": njit(**numbas)(total)}
    plain = njit(**numbas)(compiled.bind(both, part))
    for first in (0, 3, 50):
        assert quick(seen, first) == plain(seen, first)
        assert quick(seen, first) == pytest.approx(both(seen, first), rel=1e-12)
    with pytest.raises(TypingError):
        njit(**compiled.OPTIONS)(unknown)(seen, 3)
    assert gc.isenabled()


def test_a_laws_source_is_part_of_its_mark():
    def law(x):
        return 2.0 * x

    def other(x):
        return 3.0 * x

    assert compiled.fingerprint(law) == compiled.fingerprint(law)
    assert compiled.fingerprint(law) != compiled.fingerprint(other)
    assert compiled.fingerprint(law, True) != compiled.fingerprint(law, False)


def test_the_first_compilation_says_so(monkeypatch, capsys):
    monkeypatch.setattr(step, "is_kept", lambda name, mark: False)
    monkeypatch.setattr(step, "_ANNOUNCED", set())
    seed = Seed.from_spheres([[0, 0, 0]], [3e-3])
    world = World(
        (Placed((seed,), SOYBEAN, [[0, 0, 0.01]]),),
        (Plane("floor", Q235),),
        (SOYBEAN_Q235, SOYBEAN_SOYBEAN),
    )
    step.init(world, np.random.default_rng(0))
    step.init(world, np.random.default_rng(0))
    assert capsys.readouterr().err.count("compiling the step loop") == 1


@pytest.mark.slow
def test_a_second_process_starts_warm(tmp_path):
    """From nothing, compiling, then again from the kept code; generous bounds for a
    busy machine."""
    script = Path(__file__).parents[2] / "benchmarks" / "engine.py"
    code = (
        f"import runpy, sys; sys.path.insert(0, {str(script.parent)!r});"
        f" exec(runpy.run_path({str(script)!r})['DROP'])"
    )
    ready = []
    for _ in range(2):
        environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
        done = subprocess.run(
            [sys.executable, "-c", code],
            env=environment,
            capture_output=True,
            text=True,
            check=True,
        )
        ready.append(float(done.stdout.split()[0]))
    assert ready[0] < 60.0 and ready[1] < 4.0
