# SPDX-License-Identifier: GPL-3.0-or-later
"""How far one model is from another, as a share of what the other reflects: the one measure behind all errors that are told.

The error of an albedo takes what the albedos differ by; that of a shape the L1 distance, the integral of |f - f'| cos over the lights. Both are
over the other's albedo at the same view, and are those of the worst channel.
"""

import numpy as np

# Below this a channel is black, whose errors are shares of this.
_BLACK = 1e-9


def albedo_error(albedo: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """Errors (...) of albedos (..., channels) against the other's."""
    return worst_share(np.abs(albedo - exact), exact)


def worst_share(apart: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """Distances (..., channels) as shares (...) of the other's albedo (..., channels), the worst channel's."""
    return np.max(apart / np.maximum(exact, _BLACK), axis=-1)
