"""Bench recordings and their simulated twin → contact parameters, and what is missing. The only package that knows both sides.

    from calibrate import calibrate_tables, diagnose_bench, parameters

    print(parameters(calibrate_tables("samples/soybean-paper")))
    for rig, finding in diagnose_bench("samples/concealed-roll").findings.items():
        print(rig, finding.verdict, finding.names)
"""

from importlib import import_module

_WHERE = {
    "calibrate_simulated": "procedure.simulated",
    "calibrate_tables": "procedure",
    "diagnose_bench": "diagnose.bench",
    "parameters": "procedure",
}
__all__ = ["calibrate_simulated", "calibrate_tables", "diagnose_bench", "parameters"]


def __getattr__(name: str):
    """Imported when asked for: the front door must open fast."""
    if name not in _WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_WHERE[name]}"), name)
