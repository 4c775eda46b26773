# SPDX-License-Identifier: GPL-3.0-or-later
"""Model `lafortune`: the generalised cosine lobes of Lafortune et al. 1997, "Non-Linear Approximation of Reflectance Functions".

f = d / pi + sum of max(Cxy (x x' + y y') + Cz z z', 0)^n. It is a fit to measurements and knows no layers: the
material is that of option `fit`, and the stack is not used at all. `blue_paint` stands in for the measured latex
paint of Weidlich07, figure 9, which is not at hand: three lobes per channel as printed in pbrt version 1 (Pharr and
Humphreys 2004), materials/bluepaint.cpp, not checked against the paper of 1997.
Limits: fixed data in RGB, no mirror-like coat. The third lobe peaks off the mirror direction; the first is a
retroreflection, the second broad. Its albedo is .31 .40 .73 at normal and .38 .46 .75 at grazing views.

option | default    | meaning
------ | ---------- | -------
fit    | blue_paint | measured material: blue_paint

>>> model = make_model("lafortune", presets.load("glazed_mug"), fit="blue_paint")
>>> model.albedo(spherical(0.5, 0.0)).round(3).tolist()
[0.317, 0.406, 0.731]
"""

import numpy as np

from ...errors import one_of
from ...material.stack import Stack
from ...optics.optical_stack import supports
from .parts import Baseline

# d; then per lobe Cxy, Cz, n; RGB
_FITS = {
    "blue_paint": (
        (0.3094, 0.39667, 0.70837),
        (
            ((0.870567, 0.857255, 0.670982), (0.803624, 0.774290, 0.586674), (21.820103, 18.597755, 7.472717)),
            ((-0.451218, -0.406681, -0.477976), (0.023123, 0.017625, 0.227295), (2.774499, 2.581499, 3.677653)),
            ((-1.031545, -1.029426, -1.026588), (0.706734, 0.696530, 0.687715), (66.899060, 63.767912, 57.489181)),
        ),
    ),
}


@supports("model", spectral=False)
class Lafortune(Baseline):
    """Lafortune 1997: the fit of a blue paint; it ignores the stack."""

    name = "lafortune"

    def __init__(self, stack: Stack, fit: str = "blue_paint"):
        super().__init__(stack)
        self._fit = one_of(f"model {self.name}", "fit", fit, tuple(_FITS))

    def _f(self, wo, wi):
        return np.array(_FITS[self._fit][0]) / np.pi * np.ones(wi.shape) + sum(lobes(wo, wi, self._fit))


def lobes(wo: np.ndarray, wi: np.ndarray, fit: str = "blue_paint") -> list[np.ndarray]:
    """Each lobe's f (..., 3); the first of the blue paint is its retroreflection."""
    across = (wi[..., 0] * wo[..., 0] + wi[..., 1] * wo[..., 1])[..., None]
    along = (wi[..., 2] * wo[..., 2])[..., None]
    return [np.maximum(np.array(c_xy) * across + np.array(c_z) * along, 0.0) ** np.array(n) for c_xy, c_z, n in _FITS[fit][1]]
