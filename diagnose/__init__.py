"""Diagnosis of a bench: which physics the simulation leaves out, where, and whether it
matters.

from benchtwin.diagnose import diagnose_bench

for rig, finding in diagnose_bench("samples/concealed-roll").findings.items():
    print(rig, finding.verdict, finding.names)
"""


def __getattr__(name: str):
    """Imported on first use: the package itself must import fast."""
    if name != "diagnose_bench":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from benchtwin.diagnose.bench import diagnose_bench

    return diagnose_bench
