"""A film of frames drawn in memory."""

from pathlib import Path

import numpy as np

from benchtwin.vision.evidence.frames import Frame, FrameSource


class Drawn(FrameSource):
    """Frames drawn in memory."""

    def __init__(self, frames, fps=None, times=None):
        super().__init__(path=Path("drawn"), count=len(frames), fps=fps)
        self.frames = frames
        self.times = np.arange(len(frames)) / fps if times is None else times

    def iterate(self):
        for n, pixels in enumerate(self.frames):
            yield Frame(n, float(self.times[n]), pixels)

    def picked(self, n):
        frames = list(self.iterate())
        return [
            frames[i]
            for i in np.unique(
                np.linspace(0, len(frames) - 1, min(n, len(frames))).astype(int)
            )
        ]
