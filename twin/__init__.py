"""The bridge between measuring and simulating, the only package that imports both:
recordings of the bench and of the twin read by the same code.

from benchtwin.twin import Parameters, observe, simulate

rng = np.random.default_rng(1)
recording = simulate(rig, Parameters(restitution=0.6), rng=rng, out=Path("twin"))
for q in observe(recording).quantities:
    print(q.name, q.value, q.sd, q.unit)
"""

from importlib import import_module

__all__ = ["Parameters", "observe", "simulate"]
_WHERE = {"Parameters": "parameters", "observe": "run", "simulate": "run"}


def __getattr__(name: str):
    """Imported when asked for: who only reads tracks need not wait for the engine's
    compiler."""
    if name not in _WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_WHERE[name]}"), name)
