"""Pictures, frames, videos and tracks from the bench → measurements with standard
deviations. Knows nothing of simulating.

from benchtwin.vision import measure

for observation in measure("my-bench"):
    for q in observation.quantities:
        print(observation.recording, q.name, q.value, q.sd, q.unit, q.quality)
"""


def __getattr__(name: str):
    """`measure`, imported when it is asked for: the front door must open fast."""
    if name == "measure":
        from benchtwin.vision.batch import measure

        return measure
    raise AttributeError(f"module 'vision' has no attribute '{name}'")
