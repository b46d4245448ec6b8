"""Tests that render are skipped, with the reason, only where there really is no EGL; a
broken renderer fails them."""

import ctypes
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # picture_scenes.py


def _loads(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


@pytest.fixture(scope="session")
def egl():
    from benchtwin.sim.picture.context import EGL_PACKAGES

    if not (
        _loads("libEGL.so.1")
        and (_loads("libEGL_mesa.so.0") or _loads("libEGL_nvidia.so.0"))
    ):
        pytest.skip(f"no EGL on this machine: {EGL_PACKAGES} are missing")
