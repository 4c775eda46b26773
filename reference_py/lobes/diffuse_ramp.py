# SPDX-License-Identifier: GPL-3.0-or-later
"""Profiles of diffuse light: what leaves a base through layers goes the same way whatever the view, but not as Lambert's light goes.

Light that meets a Lambert base has lost its direction, so that f is through(wo) through(wi) times a constant, by reciprocity. Cycles' closure
`diffuse_ramp` of OSL has any such f: between eight even cosines of wi its ramp is linear, and the cosine is a part of it. Stock nodes have none.
"""

import numpy as np

RAMP_COSINES = np.linspace(0.0, 1.0, 8)
# Less is known too roughly to say where it goes: what is black altogether goes as Lambert's light.
_LEAST_THROUGH = 3e-4


def ramp_of(through: np.ndarray) -> np.ndarray:
    """The ramp (8, c) of an f of energy 1 that is in proportion to `through` (8, c) at RAMP_COSINES."""
    ramp = (through + _LEAST_THROUGH) * RAMP_COSINES[:, None]
    return ramp / ramp_energy(ramp)


def ramp_energy(ramp: np.ndarray) -> np.ndarray:
    """The albedo (c,) of a ramp (8, c) that begins with 0: twice its integral over the cosine."""
    return 2.0 * RAMP_COSINES[1] * (np.sum(ramp, axis=0) - 0.5 * ramp[-1])


def ramp_f(ramp: np.ndarray, cos_theta_i: np.ndarray) -> np.ndarray:
    """f (..., c) of a ramp (8, c) for directions of these cosines (...) above 0."""
    cos_i = np.clip(cos_theta_i, 1e-9, 1.0)
    at = np.stack([np.interp(cos_i, RAMP_COSINES, channel) for channel in ramp.T], axis=-1)
    return at / (np.pi * cos_i[..., None])
