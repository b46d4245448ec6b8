"""Diagnosis of a bench: where its recordings depart from what any contact parameters explain, and which physics was left out.

    from diagnose import diagnose_bench

    for rig, finding in diagnose_bench("samples/concealed-roll").findings.items():
        print(rig, finding.verdict, finding.names)

rigs/RIG/ states the recordings of a rig as one problem, effects/RIG/ lists what may be missing, one effect a file, and
engine/ weighs the explanations; what an effect is called is known to its own file only.
"""


def __getattr__(name: str):
    """Imported when asked for: the front door must open fast."""
    if name != "diagnose_bench":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from diagnose.bench import diagnose_bench

    return diagnose_bench
