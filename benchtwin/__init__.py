"""DEM contact parameters for seeds and grains, from what you film at the bench.

    import benchtwin

    print(benchtwin.measure("samples/soybean-bench").summary)
    print(benchtwin.calibrate("samples/soybean-paper", tables=True).parameters)

What `__all__` names is the Python interface; docs/python.md says what of it may change
between versions."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from benchtwin.calibrating import calibrate as calibrate
    from benchtwin.diagnosing import diagnose as diagnose
    from benchtwin.exporting import export as export
    from benchtwin.measuring import measure as measure
    from benchtwin.simulating import simulate as simulate
    from sim.laws.law import Law as Law
    from sim.rigs.bench import Bench as Bench
    from sim.seed import Seed as Seed
    from twin.parameters import Parameters as Parameters
    from vision.measurement import MeasurementError as MeasurementError

_MODULES = {
    "Bench": "sim.rigs.bench",
    "Law": "sim.laws.law",
    "MeasurementError": "vision.measurement",
    "Parameters": "twin.parameters",
    "Seed": "sim.seed",
    "calibrate": "benchtwin.calibrating",
    "diagnose": "benchtwin.diagnosing",
    "export": "benchtwin.exporting",
    "measure": "benchtwin.measuring",
    "simulate": "benchtwin.simulating",
}
__all__ = [
    "Bench",
    "Law",
    "MeasurementError",
    "Parameters",
    "Seed",
    "calibrate",
    "diagnose",
    "export",
    "measure",
    "simulate",
]


def __dir__() -> list[str]:
    return __all__


if not TYPE_CHECKING:  # a type checker would take every name for one of ours

    def __getattr__(name: str) -> object:
        """Import a name when it is asked for: `import benchtwin` stays fast, since the
        engine's compiler loads for seconds."""
        if name not in _MODULES:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        return getattr(import_module(_MODULES[name]), name)
