"""Diagnosis of a bench: which physics the simulation leaves out, where, and whether it
matters.

from benchtwin.diagnose.bench import diagnose_bench

for rig, finding in diagnose_bench("samples/concealed-roll").findings.items():
    print(rig, finding.verdict, finding.names)
"""
