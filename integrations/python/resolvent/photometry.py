"""Photometry: luminance and illuminance from radiometric RGB."""
from __future__ import annotations

import numpy as np

from .arrays import ArrayLike, real

#: Luminance of linear RGB with the primaries of Rec. 709.
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
#: lm/W at 555 nm, where the eye is most sensitive (SI, 2019).
LUMINOUS_EFFICACY = 683.0


def luminance(rgb: ArrayLike) -> np.ndarray:
    """Luminance: a weighted sum of the channels. (..., 3) -> (...), float64, in the unit of the input."""
    array = real("rgb", rgb)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError(f"rgb: shape {array.shape}; expected (..., 3)")
    return array.astype(np.float64) @ LUMINANCE


def illuminance(irradiance: ArrayLike) -> np.ndarray:
    """Lux of an irradiance. (..., 3) W/m2 -> (...) lx, float64.

    Uses 683 lm/W, as exporters of glTF do for candela. This is right for scenes whose lights use this factor.
    """
    return LUMINOUS_EFFICACY * luminance(irradiance)
