# SPDX-License-Identifier: GPL-3.0-or-later
"""Interfaces with the films of many stacks at once: their operators as sums of those of a few.

What light does that meets one facet is linear in the facet's Fresnel curve, and films of all thicknesses have curves that are sums of few. What meets
more facets is not, and may be off by .9 % of an albedo where a surface is as rough as can be, by .3 % at a roughness of .5.
"""

from dataclasses import fields
from functools import lru_cache

import numpy as np

from ...optics.facet_reflectance import DielectricFacet
from ...optics.microfacet import is_specular
from .operators import InterfaceOperators, dielectric_rows, interface_operators

# Curves that others are told by, and the cosines at which they are compared.
_MOST, _COSINES = 12, np.linspace(0.0, 1.0, 97)
# How much more counts that shares sum to 1.
_WHOLE = 30.0


def film_operators(facet: DielectricFacet, among: tuple[DielectricFacet, ...], alpha, *setup) -> InterfaceOperators:
    """`interface_operators` of one of the facets that an interface has in its channels."""
    if len(among) <= _MOST or is_specular(alpha):
        return interface_operators(facet, alpha, *setup)
    own = told_by_few(among)[1][among.index(facet)]
    return InterfaceOperators(*(_mixed(own, parts) for parts in _chosen_operators(among, alpha, *setup)))


def film_rows(facet: DielectricFacet, among: tuple[DielectricFacet, ...], cos_theta: np.ndarray, alpha, *setup) -> tuple[np.ndarray, ...]:
    """`dielectric_rows` of one of the facets that an interface has in its channels."""
    if len(among) <= _MOST or is_specular(alpha):
        return dielectric_rows(facet, cos_theta, alpha, *setup)
    own = told_by_few(among)[1][among.index(facet)]
    return tuple(_mixed(own, parts) for parts in _chosen_rows(among, tuple(cos_theta.tolist()), alpha, *setup))


@lru_cache(maxsize=4)
def told_by_few(facets: tuple[DielectricFacet, ...]) -> tuple[tuple[DielectricFacet, ...], np.ndarray]:
    """Of many facets of one interface some, and the shares (facets, some) of these that are nearest to each."""
    if len(facets) <= _MOST:
        return facets, np.eye(len(facets))
    curves = np.concatenate([[facet(_COSINES) for facet in facets], np.full((len(facets), 1), _WHOLE)], axis=1)
    left, chosen = curves.copy(), []
    for _ in range(_MOST):
        chosen.append(int(np.argmax(np.sum(np.square(left), axis=1))))
        direction = left[chosen[-1]] / np.linalg.norm(left[chosen[-1]])
        left = left - np.outer(left @ direction, direction)
    return tuple(facets[i] for i in chosen), np.linalg.lstsq(curves[chosen].T, curves.T, rcond=1e-6)[0].T


# both memories hold those of one interface at a time, and of the resolutions that an interface deep in a stack has
@lru_cache(maxsize=2)
def _chosen_operators(among: tuple[DielectricFacet, ...], alpha, *setup) -> list[np.ndarray]:
    operators = [interface_operators(facet, alpha, *setup) for facet in told_by_few(among)[0]]
    return [np.stack([getattr(one, part.name) for one in operators]) for part in fields(InterfaceOperators)]


@lru_cache(maxsize=2)
def _chosen_rows(among: tuple[DielectricFacet, ...], cos_theta: tuple[float, ...], alpha, *setup) -> list[np.ndarray]:
    rows = [dielectric_rows(facet, np.array(cos_theta), alpha, *setup) for facet in told_by_few(among)[0]]
    return [np.stack(parts) for parts in zip(*rows)]


def _mixed(shares: np.ndarray, parts: np.ndarray) -> np.ndarray:
    return np.tensordot(shares.astype(parts.dtype), parts, 1)
