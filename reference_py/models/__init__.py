# SPDX-License-Identifier: GPL-3.0-or-later
"""Models turn a stack into numbers. All share one signature and are listed in one registry.

A model is built from a stack and named options and has `f(wo, wi)` and `albedo(wo)`, both (..., 3).
"""

from ..errors import LaminaError
from ..stack import Stack

from .mirror import Mirror
from .weidlich_wilkie import WeidlichWilkie

MODELS = {model.name: model for model in (WeidlichWilkie, Mirror)}


def make_model(name: str, stack: Stack, **options: str):
    """Build a model by name. Raises LaminaError on an unknown name or option."""
    if name not in MODELS:
        raise LaminaError(f"unknown model {name!r}; choose {', '.join(MODELS)}")
    return MODELS[name](stack, **options)
