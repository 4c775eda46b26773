# SPDX-License-Identifier: GPL-3.0-or-later
"""How far two models of the same stack are apart."""

from dataclasses import dataclass

import numpy as np

from ..material.stack import Stack
from ..optics.error_measure import albedo_error, worst_share
from ..optics.frame import spherical
from ..optics.optical_stack import rough_surfaces
from ..optics.quadrature import directional_albedo


@dataclass(frozen=True, eq=False, repr=False)
class Distance:
    """Per view: relative error of the albedo (n,), worst channel; cosine-weighted L1 of f over the albedo (n,)."""

    albedo: np.ndarray
    shape: np.ndarray


def distance(stack: Stack, model, truth, theta: np.ndarray) -> Distance:
    """Distance of `model` to `truth` at view angles theta (n,) in radians, for deterministic models.

    The L1 covers what has a finite f; mirror-like parts show in the albedo alone.
    """
    wo = spherical(theta, 0.0)
    exact = truth.albedo(wo)

    def gap(wo, wi):
        return np.abs(model.f(wo, wi) - truth.f(wo, wi))

    return Distance(albedo_error(model.albedo(wo), exact), worst_share(directional_albedo(gap, wo, rough_surfaces(stack)), exact))
