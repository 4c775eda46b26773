# SPDX-License-Identifier: GPL-3.0-or-later
"""Visible facet normals of Smith microsurfaces: their density and exact samples (Heitz14, Heitz16).

A direction `w` leaves the surface. Unlike elsewhere it may point below the horizon (w_z < 0): a ray inside a
rough surface sees facets from there too. Arrays are (n, 3). An alpha is a number or a tuple, see `Distribution`.
"""

import numpy as np

from .microfacet import distribution_of, facet_distribution


def projected_area(w: np.ndarray, alpha, distribution: str) -> np.ndarray:
    """Area (n,) of the facets seen from w per unit of macrosurface, cos(w) (1 + Lambda(w)) (Heitz16)."""
    return distribution_of(distribution).projected_area(w, alpha)


def visible_normal_density(w: np.ndarray, wm: np.ndarray, alpha, distribution: str) -> np.ndarray:
    """Density (n,) in 1/sr of the facet normals wm seen from w (Heitz14)."""
    cos = np.maximum(np.einsum("ij,ij->i", w, wm), 0.0)
    return cos * facet_distribution(wm, alpha, distribution) / projected_area(w, alpha, distribution)


def sample_visible_normals(w: np.ndarray, alpha, distribution: str, rng: np.random.Generator) -> np.ndarray:
    """Facet normals (n, 3) of density `visible_normal_density`; any w_z."""
    return distribution_of(distribution).sample_visible_normals(w, alpha, rng)
