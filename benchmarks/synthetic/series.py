"""Pictures in a series: photos of different heaps, and the frames of a film."""

import numpy as np
from PIL import Image

from synthetic.piles import PileScene, draw_pile

SIZE = (320, 240)


def heap_photos(count: int, seed: int = 0) -> list[Image.Image]:
    """Photos of heaps, each poured anew before one background."""
    rng = np.random.default_rng(seed)
    return [
        Image.fromarray(
            draw_pile(
                PileScene(
                    angle_deg=rng.uniform(24, 36),
                    size=SIZE,
                    pile_height=int(rng.uniform(60, 80)),
                ),
                rng,
            )
        )
        for _ in range(count)
    ]


def film_frames(count: int, seed: int = 0) -> list[Image.Image]:
    """Frames of a still camera with noise, before which a seed falls."""
    rng = np.random.default_rng(seed)
    background = rng.normal(110, 25, SIZE[::-1])
    frames = []
    for n in range(count):
        frame = background + rng.normal(0, 3, background.shape)
        top = 10 + int(200 * (n / count) ** 2)
        frame[top : top + 9, 150:162] = 220
        frames.append(Image.fromarray(frame.clip(0, 255).astype(np.uint8)))
    return frames
