# SPDX-License-Identifier: GPL-3.0-or-later
"""Energies at the knots of the view that a bake keeps: of mirrors, and what is left for the lobes that are fitted."""

from functools import lru_cache

import numpy as np

from ...material.stack import Stack
from ...optics.microfacet import is_specular
from ...optics.optical_stack import OpticalStack
from ..closure import unit_energy
from ..lobe import DielectricCurve, GlossyLobe
from ..samples import view_of
from ..view_table import knot_cosines


def top_lobe(stack: Stack) -> GlossyLobe | None:
    """The closure that is exact for one event on a rough top interface, where there is one without film and nothing dims it."""
    for surface in OpticalStack.of(stack).interfaces:
        if not surface.does_nothing:
            if surface.film is not None or is_specular(surface.alpha):
                return None
            alpha = surface.alpha
            return GlossyLobe(surface.distribution, np.ones(3), alpha, alpha, fresnel=DielectricCurve(surface.eta))
        if np.any(surface.tau > 0.0):
            return None
    return None


def shares(truth, known: GlossyLobe | None) -> tuple[np.ndarray, np.ndarray]:
    """Energies (KNOTS, c) of mirrors, and of what is neither in these nor in a known lobe."""
    cosines = knot_cosines()
    mirrors = truth.specular_albedo(cosines)
    return mirrors, left_over(truth.albedo(np.stack([view_of(c) for c in cosines])), mirrors, known)


def left_over(albedo: np.ndarray, mirrors: np.ndarray, known: GlossyLobe | None) -> np.ndarray:
    """What of an albedo (KNOTS, c) is neither in mirrors (KNOTS, c) nor in a known lobe, which is grey."""
    return np.maximum(albedo - (mirrors if known is None else mirrors + _energy(known.distribution, float(known.alpha_x), known.fresnel.eta)), 0.0)


@lru_cache(maxsize=64)
def _energy(distribution: str, alpha: float, eta: float) -> np.ndarray:
    """What `top_lobe` has, (KNOTS, 1)."""
    return unit_energy(GlossyLobe(distribution, np.ones(3), alpha, alpha, fresnel=DielectricCurve(eta)), knot_cosines())[:, :1]
