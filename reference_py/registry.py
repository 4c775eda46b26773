# SPDX-License-Identifier: GPL-3.0-or-later
"""Models turn a stack into numbers. All share one signature and are listed in one registry.

A model is built from a stack and named options; `models.model` says what it has. The head of each model's file has a table of
its options, and an example, which needs these imports:

>>> from lamina.reference_py.material import presets
>>> from lamina.reference_py.optics.frame import spherical
>>> from lamina.reference_py.registry import make_model
>>> make_model("schlick", presets.load("glazed_mug")).albedo(spherical(0.5, 0.0)).round(3).tolist()
[0.096, 0.243, 0.366]
"""

from functools import cache
from inspect import signature
from typing import Any

from .errors import LaminaError
from .lobes.methods.closure_model import ClosureModel
from .material.coverage import is_plain, patches
from .material.stack import Stack
from .models.adding import Adding
from .models.baselines import BASELINES
from .models.patch_model import PatchModel
from .models.position_free import PositionFree
from .models.weidlich_wilkie import WeidlichWilkie
from .models.weidlich_wilkie_repaired import WeidlichWilkieRepaired

MODELS = {model.name: model for model in (WeidlichWilkie, WeidlichWilkieRepaired, Adding, PositionFree, ClosureModel, *BASELINES)}


# What models and their options were called before.
OLD_NAMES = {"mirror": ClosureModel.name}
_OLD_OPTIONS = {ClosureModel.name: {"tier": "method"}}


@cache
def model_options(name: str) -> tuple[str, ...]:
    """Names of the options of a model of `MODELS`: what its class takes beside the stack."""
    return tuple(signature(MODELS[name]).parameters)[1:]


def make_model(name: str, stack: Stack, **options: str) -> Any:
    """Build a model (`models.model.Model`) by name; of a stack with covered or opaque layers, the mixture of its patches.

    Raises LaminaError on an unknown name or option, what is no Stack, or what the model does not know (`OpticalStack.of`).
    """
    name = OLD_NAMES.get(name, name)
    if name not in MODELS:
        raise LaminaError(f"unknown model {name!r}; choose {', '.join(MODELS)}")
    if not isinstance(stack, Stack):
        raise LaminaError(f"model {name} needs a Stack, not {type(stack).__name__}: see Stack.load, Stack.from_dict, presets.load")
    options = {_OLD_OPTIONS.get(name, {}).get(key, key): value for key, value in options.items()}
    for key in options:
        if key not in model_options(name):
            known = f"choose {', '.join(model_options(name))}" if model_options(name) else "it has none"
            raise LaminaError(f"model {name}: unknown option {key!r}; {known}")
    if ClosureModel.name == name or is_plain(stack):  # its lobe set is a mixture itself
        return MODELS[name](stack, **options)
    parts = [(patch, MODELS[name](patch.stack, **options)) for patch in patches(stack) if patch.share > 0.0]
    return parts[0][1] if len(parts) == 1 else PatchModel(parts)
