# SPDX-License-Identifier: GPL-3.0-or-later
"""What a way to render a stack reflects, in numpy, and how far that is from the truth. Does not need bpy.

Lobe sets and baselines equal their renders to 1e-4 and 5e-4 (tests/addon/test_parity*.py, test_baselines_render.py), so that
their errors need no render.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ...reference_py.lobes.closure import is_specular_lobe, lobe_energy, lobe_f
from ...reference_py.lobes.lobe import GlossyLobe
from ...reference_py.lobes.samples import truth_at
from ...reference_py.lobes.view_table import KNOTS, DiffuseTable, GlossyTable, TableLobes, knot_cosines
from ...reference_py.material.stack import Stack
from ...reference_py.optics.error_measure import albedo_error, worst_share
from ...reference_py.optics.frame import spherical
from ...reference_py.optics.microfacet import GGX
from ...reference_py.optics.optical_stack import OpticalStack, rough_surfaces
from ...reference_py.optics.quadrature import directional_albedo

THETA_DEG = np.array([0.0, 20.0, 40.0, 60.0, 75.0, 80.0])
# Alphas that a plain glossy node is tried with.
_GUESSES = np.geomspace(0.02, 1.0, 14)


class Reflectance(Protocol):
    """`f(wo, wi)` (..., 3) without mirror-like parts, `albedo(cos)` and its mirror-like share `specular_albedo(cos)`, each (n, 3)."""

    def f(self, wo: np.ndarray, wi: np.ndarray) -> np.ndarray: ...
    def albedo(self, cos_theta_o: np.ndarray) -> np.ndarray: ...
    def specular_albedo(self, cos_theta_o: np.ndarray) -> np.ndarray: ...


class LobeReflectance:
    """That of a lobe set."""

    def __init__(self, lobe_set):
        self.lobe_set = lobe_set

    def f(self, wo, wi):
        return sum(lobe_f(lobe, wo, wi) for lobe in self.lobe_set.lobes(wo[..., 2]))

    def albedo(self, cos_theta_o):
        return self._energy(cos_theta_o, lambda lobe: True)

    def specular_albedo(self, cos_theta_o):
        return self._energy(cos_theta_o, lambda lobe: isinstance(lobe, GlossyLobe) and is_specular_lobe(lobe))

    def _energy(self, cos_theta_o, counts):
        return sum((lobe_energy(lobe, cos_theta_o) for lobe in self.lobe_set.lobes(cos_theta_o) if counts(lobe)), np.zeros((len(cos_theta_o), 3)))


class ModelReflectance:
    """That of a model of the registry."""

    def __init__(self, model):
        self.model = model
        self._rough = rough_surfaces(model.stack)

    def f(self, wo, wi):
        return self.model.f(wo, wi)

    def albedo(self, cos_theta_o):
        return self.model.albedo(_views(cos_theta_o))

    def specular_albedo(self, cos_theta_o):
        if not is_specular_somewhere(self.model.stack):
            return np.zeros((len(cos_theta_o), 3))
        wo = _views(cos_theta_o)
        return np.maximum(self.model.albedo(wo) - directional_albedo(self.model.f, wo, self._rough), 0.0)


class TruthReflectance(ModelReflectance):
    """That of `adding`, which knows its mirror-like part."""

    def specular_albedo(self, cos_theta_o):
        return self.model.specular_albedo(cos_theta_o)


def _views(cos_theta_o) -> np.ndarray:
    return spherical(np.arccos(np.asarray(cos_theta_o, float)), 0.0)


def is_specular_somewhere(stack: Stack) -> bool:
    """Whether light can come back as from a mirror."""
    optics = OpticalStack.of(stack)
    return optics.base.is_specular or any(s.facets.is_specular for s in optics.interfaces)


# Points of each strategy at a view.
_POINTS = 300


@dataclass(frozen=True)
class Errors:
    """Relative error of the albedo, worst channel and view; L1 of f over the albedo, worst view and mean of the views."""

    albedo: float
    shape: float
    shape_mean: float


class Reference:
    """The truth at THETA_DEG. Light that leaves as from a mirror counts in the shape as one more direction."""

    def __init__(self, stack: Stack, truth):
        self._cosines = np.cos(np.radians(THETA_DEG))
        self._views = truth_at(truth, self._cosines, [alpha for _, alpha in rough_surfaces(stack)], _POINTS)
        exact = TruthReflectance(truth)
        self._albedo, self._specular_albedo = exact.albedo(self._cosines), exact.specular_albedo(self._cosines)

    def errors(self, reflectance: Reflectance) -> Errors:
        albedo = albedo_error(reflectance.albedo(self._cosines), self._albedo)
        views = self._views
        gaps = np.abs(reflectance.specular_albedo(self._cosines) - self._specular_albedo)
        for gap, wo, wi, share, f in zip(gaps, views.wo, views.wi, views.share, views.f):
            gap += share @ np.abs(reflectance.f(np.broadcast_to(wo, wi.shape), wi) - f)
        shape = worst_share(gaps, self._albedo)
        return Errors(float(np.max(albedo)), float(np.max(shape)), float(np.mean(shape)))


def plain_glossy(stack: Stack, truth) -> tuple[np.ndarray, float]:
    """(color (3,), alpha) of the one glossy node that comes closest: the truth's mean color, and the best of _GUESSES."""
    cosines = np.sqrt((np.arange(8) + 0.5) / 8.0)
    color, reference = TruthReflectance(truth).albedo(cosines).mean(axis=0), Reference(stack, truth)
    alpha = min(_GUESSES, key=lambda a: reference.errors(LobeReflectance(glossy_lobes(color, a))).shape_mean)
    return color, float(alpha)


def glossy_lobes(color: np.ndarray, alpha: float) -> TableLobes:
    """A Glossy node (GGX) as a lobe set."""
    ones = np.ones((KNOTS, 3))
    return TableLobes((GlossyTable(GGX, ones * color, ones * (alpha, alpha, 0.0)),))


def belcour_lobes(model) -> TableLobes:
    """Belcour's lobes in tables. What T(wi) does within the diffuse lobe becomes part of its weight."""
    cosines = knot_cosines()
    tables = []
    for weight, alpha in model.lobes(cosines):
        tables.append(GlossyTable(GGX, weight, np.stack([alpha, alpha, np.zeros(KNOTS)], axis=-1)))
    if model.stack.base.kind != "conductor":
        glossy = LobeReflectance(TableLobes(tuple(tables))).albedo(cosines) if tables else 0.0
        tables.append(DiffuseTable(np.maximum(model.albedo(_views(cosines)) - glossy, 0.0)))
    return TableLobes(tuple(tables))
