"""Differences between two colours in units of the noise; how much of one a shadow can make.

A shadow scales what is behind it: the change is parallel to the background's own colour at that pixel. A body replaces it. In a
product of differences, whatever lies along the background's colour therefore counts less the deeper shadows may be.
"""

import cv2
import numpy as np

# Orthonormal: brightness and two colours. A grey picture has the first alone.
AXES = np.array([[1.0, 1.0, 1.0], [1.0, 0.0, -1.0], [1.0, -2.0, 1.0]])
AXES /= np.linalg.norm(AXES, axis=1, keepdims=True)
HUE_FLOOR = 1.5 / 255  # of white: video stores colours coarsely, and errs in them where something moves, whatever it shows at rest


def noise_matrix(sd: np.ndarray, white: float) -> np.ndarray:
    """(c, c): colours of a picture → units of noise, from the noise (c,) along brightness and, of three colours, the two others."""
    if len(sd) == 1:
        return np.array([[1 / sd[0]]], np.float32)
    hue = max(sd[0], HUE_FLOOR * white)
    return (AXES / np.maximum(sd, [0.0, hue, hue])[:, None]).astype(np.float32)


def along_axes(colours: np.ndarray) -> np.ndarray:
    """(h, w, c) along brightness and the two others."""
    return colours if colours.shape[2] == 1 else cv2.transform(colours, AXES.astype(np.float32))


def in_noise(colours: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """(h, w, c) float32 in units of noise."""
    return colours * matrix[0, 0] if matrix.shape == (1, 1) else cv2.transform(colours, matrix)


def product(a: np.ndarray, b: np.ndarray, behind: np.ndarray, shade: float) -> np.ndarray:
    """Product of two differences (…, c) before the background `behind` (…, c), all in units of noise, where shadows of sd `shade`
    (a share of the background) are noise as well. Of grey pictures, where a shadow is like any other change, the plain product.
    """
    plain = _dot(a, b)
    if behind.shape[-1] == 1 or shade == 0:
        return plain
    return plain - _dot(a, behind) * _dot(b, behind) / (shade**-2 + _dot(behind, behind))


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("...k,...k->...", a, b)
