# SPDX-License-Identifier: GPL-3.0-or-later
"""Spheres of presets, rendered once per size, and what their varnish alone contributes."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from ...reference_py.material import presets
from ...reference_py.material.stack import Stack
from ...reference_py.models.weidlich_wilkie import WeidlichWilkie
from ...reference_py.registry import make_model
from .seen_colors import xyz_of_rgb
from .sphere import Picture, render


class BaseOnly(WeidlichWilkie):
    """The base's component of Weidlich07, eq. 2: what comes back through the layers."""

    def f(self, wo, wi):
        return self.components(wo, wi)[-1]

    def specular_albedo(self, wo):
        return np.zeros(np.shape(wo)[:-1] + (self.channels,))


@lru_cache(maxsize=32)
def preset_sphere(name: str, size: int) -> tuple[np.ndarray, Picture]:
    """XYZ (size, size, 3) of a preset's sphere and its picture."""
    return stack_sphere(presets.load(name), size)


def stack_sphere(stack: Stack, size: int, model=None) -> tuple[np.ndarray, Picture]:
    """The same of any stack; `model` defaults to Weidlich07 with its default options."""
    picture = render(model or make_model("weidlich_wilkie", stack), size)
    return xyz_of_rgb(picture.radiance), picture


def with_top(stack: Stack, **values) -> Stack:
    """The stack with some values of its top layer replaced."""
    return replace(stack, layers=(stack.layers[0].with_values(**values), *stack.layers[1:]))
