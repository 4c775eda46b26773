# SPDX-License-Identifier: GPL-3.0-or-later
"""Models turn a stack into numbers. All share one signature and are listed in one registry.

A model is built from a stack and named options and has `f(wo, wi)` and `albedo(wo)`, both (..., 3). Most can be
sampled: `sample(wo, rng)` gives (wi, valid), (..., 3) and (...), and `pdf(wo, wi)` the density (...) of wi in 1/sr.
Samples that are not valid have value 0 and count as samples.
"""

from ..errors import LaminaError
from ..stack import Stack

from .adding import Adding
from .mirror import Mirror
from .peers import PEERS
from .position_free import PositionFree
from .weidlich_wilkie import WeidlichWilkie
from .weidlich_wilkie_repaired import WeidlichWilkieRepaired

MODELS = {model.name: model for model in (WeidlichWilkie, WeidlichWilkieRepaired, Adding, PositionFree, Mirror, *PEERS)}


def make_model(name: str, stack: Stack, **options: str):
    """Build a model by name. Raises LaminaError on an unknown name or option, or what is no Stack."""
    if name not in MODELS:
        raise LaminaError(f"unknown model {name!r}; choose {', '.join(MODELS)}")
    if not isinstance(stack, Stack):
        raise LaminaError(f"model {name} needs a Stack, not {type(stack).__name__}: see Stack.load, Stack.from_dict, presets.load")
    return MODELS[name](stack, **options)
