"""A recording → its quantities, whatever its rig and evidence; bench folders, one
recording after the other.

from benchtwin.measure.batch import measure

for observation in measure("my-bench"):
    for q in observation.quantities:
        print(observation.recording, q.name, q.value, q.sd, q.unit, q.quality)
"""
