"""Measures the seeds of one photo, with the scale from graph paper in it, and draws the overlay."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from vision.evidence.photo import read_photo
from vision.measurement import MeasurementError
from vision.overlay.grains import draw_grains
from vision.paper.scale import read_scale
from vision.shape.grains import Grains, measure_seeds


def observe_seeds(path: Path, mm_per_px: float | None = None, mm_per_px_sd: float | None = None) -> tuple[Grains, np.ndarray]:
    """Grains of a photo and an overlay (uint8 RGB); scale: `mm_per_px`, else read from graph paper, else sizes are in px.

    Raises MeasurementError, naming the file, where the picture cannot be read or shows no seeds.
    """
    image = read_photo(path)
    try:
        try:
            paper, trouble = read_scale(image), ""
        except MeasurementError as error:
            paper, trouble = None, str(error)
        scale = paper if mm_per_px is None else mm_per_px
        grains = measure_seeds(image, scale, mm_per_px_sd=mm_per_px_sd, paper=paper)
    except MeasurementError as error:
        raise MeasurementError(f"{path}: {error}") from error
    if scale is None:
        grains = replace(grains, notes=(*grains.notes, f"sizes are in px: no mm_per_px was given and {trouble}"))
    return grains, draw_grains(image, grains, paper)
