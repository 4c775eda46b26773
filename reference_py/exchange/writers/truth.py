# SPDX-License-Identifier: GPL-3.0-or-later
"""The truth at many pairs of directions: `adding`, or walks of `position_free` for a stack that adding refuses."""

from collections.abc import Callable

import numpy as np

from ...errors import LaminaError
from ...material.coverage import Patch, patches
from ...material.place import Place, places
from ...material.schema import ANISOTROPY
from ...material.stack import Stack
from ...models.adding.adding_model import Adding
from ...models.position_free import PositionFree
from ...optics.microfacet import SPECULAR_ALPHA
from ...optics.optical_stack import OpticalStack
from ...registry import make_model

Progress = Callable[[float], None]

# Pairs between two reports.
_CHUNK = 1024


class Truth:
    """What a table is made of; `walks` per value count where it is walks. Raises LaminaError for what no model knows."""

    def __init__(self, stack: Stack, walks: int, surface: str | None = None):
        options = {"surface": surface} if surface else {}
        try:
            self._model = make_model(Adding.name, stack, **options)
        except LaminaError:
            self._model = make_model(PositionFree.name, stack, walks=walks, **options)
        self._rng = np.random.default_rng(0)
        self.stack, self.surface = stack, surface
        self.name: str = self._model.name
        self.stochastic: bool = self._model.stochastic
        self.note: str | None = getattr(self._model, "f_note", None)

    def f(self, wo: np.ndarray, wi: np.ndarray, progress: Progress | None = None) -> np.ndarray:
        """BRDF (n, 3) in 1/sr without cosine at directions (n, 3)."""
        return self.f_stderr(wo, wi, progress)[0]

    def f_stderr(self, wo: np.ndarray, wi: np.ndarray, progress: Progress | None = None) -> tuple[np.ndarray, np.ndarray]:
        """`f` and its standard error, both (n, 3); 0 where the truth has no noise."""
        f, stderr = np.zeros(wo.shape), np.zeros(wo.shape)
        for start in range(0, len(wo), _CHUNK):
            rows = slice(start, start + _CHUNK)
            if self.stochastic:
                f[rows], stderr[rows] = self._model.f_stderr(wo[rows], wi[rows], rng=self._rng)
            else:
                f[rows] = self._model.f(wo[rows], wi[rows])
            if progress:
                progress(min(start + _CHUNK, len(wo)) / len(wo))
        return f, stderr


def is_isotropic(stack: Stack) -> bool:
    """Whether f knows the difference of azimuths alone."""
    return not any(element.has(ANISOTROPY) for _, element in places(stack))


def require_isotropic(stack: Stack, form: str, others: str) -> None:
    """Raise LaminaError naming the anisotropic layer that a format cannot hold."""
    for index, element in places(stack):
        if element.has(ANISOTROPY):
            raise LaminaError(f"{form} holds isotropic materials alone, and {Place(index, '').where} is anisotropic; choose {others}, or remove its anisotropy")


def require_finite(stack: Stack, form: str) -> None:
    """Raise LaminaError where light meets a smooth surface before a rough one: what that reflects has a direction and no f."""
    for patch in patches(stack):
        if patch.share > 0.0 and (mirror := _mirror(patch)):
            raise LaminaError(f"{form} holds finite values, and {mirror} is as smooth as a mirror; give it a roughness above {SPECULAR_ALPHA**0.5:.2g}")


def _mirror(patch: Patch) -> str | None:
    """The smooth surface, in words."""
    optics = OpticalStack.of(patch.stack)
    for index, interface in zip(patch.layers, optics.interfaces):
        if interface.facets.is_specular and (interface.eta != 1.0 or interface.film is not None):
            return Place(index, "").where
        if interface.eta != 1.0:
            return None
    return Place(patch.base, "").where if optics.base.is_specular else None
