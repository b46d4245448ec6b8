"""DEM contact parameters for seeds and grains, from what you film at the bench.

    import benchtwin

    print(benchtwin.measure("samples/soybean-bench").summary)
    print(benchtwin.calibrate("samples/soybean-paper", tables=True).parameters)

What `__all__` names is the Python interface; docs/python.md says what of it may change
between versions."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from benchtwin.auditing import audit as audit
    from benchtwin.recording_commands import measure as measure
    from benchtwin.sim.laws.law import Law as Law
    from benchtwin.sim.rigs.bench import Bench as Bench
    from benchtwin.sim.seed import Seed as Seed
    from benchtwin.simulation_commands import calibrate as calibrate
    from benchtwin.simulation_commands import compare as compare
    from benchtwin.simulation_commands import diagnose as diagnose
    from benchtwin.simulation_commands import export as export
    from benchtwin.simulation_commands import predict as predict
    from benchtwin.simulation_commands import simulate as simulate
    from benchtwin.twin.parameters import Parameters as Parameters
    from benchtwin.vision.measurement import MeasurementError as MeasurementError

_MODULES = {
    "Bench": "benchtwin.sim.rigs.bench",
    "Law": "benchtwin.sim.laws.law",
    "MeasurementError": "benchtwin.vision.measurement",
    "Parameters": "benchtwin.twin.parameters",
    "Seed": "benchtwin.sim.seed",
    "audit": "benchtwin.auditing",
    "calibrate": "benchtwin.simulation_commands",
    "compare": "benchtwin.simulation_commands",
    "diagnose": "benchtwin.simulation_commands",
    "export": "benchtwin.simulation_commands",
    "measure": "benchtwin.recording_commands",
    "predict": "benchtwin.simulation_commands",
    "simulate": "benchtwin.simulation_commands",
}
__all__ = [
    "Bench",
    "Law",
    "MeasurementError",
    "Parameters",
    "Seed",
    "audit",
    "calibrate",
    "compare",
    "diagnose",
    "export",
    "measure",
    "predict",
    "simulate",
]


def __dir__() -> list[str]:
    return __all__


# Packages that bear a function's name: their first import puts them in its place, a
# later one of what is in them does not.
for _package in ("calibrate", "diagnose", "measure"):
    import_module(f"{__name__}.{_package}")
    del globals()[_package]

if not TYPE_CHECKING:  # a type checker would take every name for one of ours

    def __getattr__(name: str) -> object:
        """Import a name when it is asked for: `import benchtwin` stays fast, since the
        engine's compiler loads for seconds."""
        if name not in _MODULES:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        return getattr(import_module(_MODULES[name]), name)
