"""A path-traced photo of a heap of peas beside a printed board, samples/board-heap:
nothing of camera, scale or level is stated.

.venv/bin/pip install -e '.[bench]'                    # mitsuba
.venv/bin/python samples/board_heap.py photo.jpg       # make it anew: minutes
.venv/bin/benchtwin measure samples/board-heap --out measured
"""

import sys
from pathlib import Path

from PIL import Image

sys.path.insert(0, str(Path(__file__).parent.parent / "benchmarks"))
from path_traced import Shot, take

SHOT = Shot("wood", 8.0, mirror=False, wall=False, seed=5, board="A6")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    photo = take(SHOT, width=1800, samples=32)
    Image.fromarray(photo.pixels).save(sys.argv[1], quality=85)
    print(photo.truth, f"mm per px {photo.mm_per_px:.5f}")
