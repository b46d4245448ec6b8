"""Bench recordings and their simulated twin → contact parameters.

from benchtwin.calibrate import calibrate_tables, parameters

print(parameters(calibrate_tables("samples/soybean-paper")))
"""

from importlib import import_module

_WHERE = {
    "calibrate_simulated": "procedure.simulated",
    "calibrate_tables": "procedure",
    "parameters": "procedure",
}
__all__ = ["calibrate_simulated", "calibrate_tables", "parameters"]


def __getattr__(name: str):
    """Imported when asked for: the front door must open fast."""
    if name not in _WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_WHERE[name]}"), name)
