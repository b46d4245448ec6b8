"""Colour differences in sds of the noise, with little weight for changes that a shadow can make.

A shadow scales the background: the change is parallel to the background's colour at that pixel. A seed replaces it. Changes along
the background's colour are therefore weighted less, the deeper shadows may be.
"""

import cv2
import numpy as np

# Orthonormal: brightness and two colours; a grey picture has only the first.
AXES = np.array([[1.0, 1.0, 1.0], [1.0, 0.0, -1.0], [1.0, -2.0, 1.0]])
AXES /= np.linalg.norm(AXES, axis=1, keepdims=True)
HUE_FLOOR = 1.5 / 255  # of white: video stores colours coarsely, with errors where something moves


def noise_matrix(sd: np.ndarray, white: float) -> np.ndarray:
    """(c, c): transforms colours to sds of the noise; sd (c,): of brightness and, for three colours, of the two other axes."""
    if len(sd) == 1:
        return np.array([[1 / sd[0]]], np.float32)
    hue = max(sd[0], HUE_FLOOR * white)
    return (AXES / np.maximum(sd, [0.0, hue, hue])[:, None]).astype(np.float32)


def colour_axes(colours: np.ndarray) -> np.ndarray:
    """(h, w, c): brightness and the two other axes."""
    return colours if colours.shape[2] == 1 else cv2.transform(colours, AXES.astype(np.float32))


def in_sds(colours: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """(h, w, c) float32 in sds of the noise."""
    return colours * matrix[0, 0] if matrix.shape == (1, 1) else cv2.transform(colours, matrix)


def weighted_product(a: np.ndarray, b: np.ndarray, background_sds: np.ndarray, shade: float) -> np.ndarray:
    """Scalar product of two differences (…, c) where shadows of relative sd `shade` count as noise; all in sds of the noise.

    Of grey pictures, in which a shadow is a change like any other, the plain product.
    """
    plain = dot(a, b)
    if background_sds.shape[-1] == 1 or shade == 0:
        return plain
    return plain - dot(a, background_sds) * dot(b, background_sds) / (shade**-2 + dot(background_sds, background_sds))


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Scalar product over the last axis."""
    return np.einsum("...k,...k->...", a, b)
