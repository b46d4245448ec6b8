"""Versions of what computes a recording, a result or a diagnosis."""

import platform
from importlib.metadata import version

PACKAGES = ("benchtwin", "numpy", "scipy", "pandas", "numba", "emcee")


def versions() -> dict[str, str]:
    """Of Python, of this program and of the libraries that numbers depend on."""
    return {
        "python": platform.python_version(),
        **{name: version(name) for name in PACKAGES},
    }
