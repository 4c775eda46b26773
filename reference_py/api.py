# SPDX-License-Identifier: GPL-3.0-or-later
"""What `import lamina` offers to scripts and notebooks. Blender never reads this file: the package gives its names when asked for one.

A stack is a `Stack`, a preset's name or a stack file. Directions are angles in degrees, (..., 2) of polar angle and azimuth, or unit
vectors (..., 3). Every function takes the name of a model and that model's options; `model` makes one to use again.
"""

import os
from typing import Any, NamedTuple

import numpy as np

from .errors import LaminaError
from .material import presets
from .material.stack import Stack
from .optics.frame import spherical
from .optics.spectral import SpectralStack, spectral_stack
from .plots.stack_picture import notebook
from .registry import MODELS, OLD_NAMES, make_model, model_options

__all__ = ["Samples", "SpectralStack", "Stack", "albedo", "f", "load", "model", "models", "names", "sample", "spectral_stack", "spherical"]

# The truth, and what can be sampled: what Cycles draws its samples of.
_TRUTH, _SAMPLED = "adding", "closure_model"


class Samples(NamedTuple):
    """Light directions of a view: the mean of `f * wi[..., 2:] / pdf[..., None]` over them, 0 where not `valid`, is the albedo."""

    wi: np.ndarray
    """(n, ..., 3) unit vectors."""
    valid: np.ndarray
    """(n, ...)"""
    pdf: np.ndarray
    """(n, ...) in 1/sr."""
    f: np.ndarray
    """(n, ..., channels) in 1/sr."""


def load(name_or_path: str | os.PathLike) -> Stack:
    """The stack of a preset's name or a stack file. Raises LaminaError; a name that is no preset lists them."""
    return presets.load(name_or_path)


def names() -> list[str]:
    """Names of all presets."""
    return presets.names()


def models() -> dict[str, tuple[str, ...]]:
    """Names of all models, with the names of their options."""
    return {name: model_options(name) for name in MODELS}


def model(stack: Stack | str | os.PathLike, model: str = _TRUTH, **options: Any) -> Any:
    """A model (`models.model.Model`) of a stack, to be asked more than once. Raises LaminaError as `registry.make_model`."""
    return make_model(model, _stack(stack), **options)


def albedo(stack: Stack | str | os.PathLike, theta=(0.0, 30.0, 60.0), model: str = _TRUTH, **options: Any) -> np.ndarray:
    """Share of light that a stack reflects, (..., channels), seen at angles theta (...) in degrees from the normal."""
    return make_model(model, _stack(stack), **options).albedo(spherical(np.radians(_angles("theta", theta)), 0.0))


def f(stack: Stack | str | os.PathLike, wo, wi, model: str = _TRUTH, **options: Any) -> np.ndarray:
    """BRDF (..., channels) in 1/sr without cosine, for directions to the viewer and to the light that broadcast."""
    return make_model(model, _stack(stack), **options).f(_directions("wo", wo), _directions("wi", wi))


def sample(stack: Stack | str | os.PathLike, wo, n: int = 1, rng: Any = 0, model: str = _SAMPLED, **options: Any) -> Samples:
    """n samples of light directions for each view; rng is a seed or a generator. Raises LaminaError for a model without samples."""
    able = [name for name, kind in MODELS.items() if hasattr(kind, "sample")]
    if OLD_NAMES.get(model, model) in MODELS and OLD_NAMES.get(model, model) not in able:
        raise LaminaError(f"model {model} has no samples; choose {', '.join(able)}")
    if isinstance(n, bool) or not isinstance(n, (int, np.integer)) or n < 0:
        raise LaminaError(f"n is {n!r}; choose a whole number of samples from 0")
    made, view = make_model(model, _stack(stack), **options), _directions("wo", wo)
    view = np.broadcast_to(view, (int(n), *view.shape))
    wi, valid = made.sample(view, rng)
    return Samples(wi, valid, made.pdf(view, wi), made.f(view, wi))


def _stack(stack) -> Stack:
    return stack if isinstance(stack, Stack) else load(stack)


def _angles(name: str, angles) -> np.ndarray:
    try:
        return np.asarray(angles, float)
    except (TypeError, ValueError):
        raise LaminaError(f"{name} is {str(angles)[:40]!r}; choose angles in degrees") from None


def _directions(name: str, w) -> np.ndarray:
    """Unit vectors (..., 3) of angles in degrees (..., 2); what is no pair of angles is left to the model."""
    w = _angles(name, w)
    if w.shape[-1:] != (2,):
        return w
    return spherical(np.radians(w[..., 0]), np.radians(w[..., 1]))


# Notebooks ask for this; stacks themselves know no models.
Stack._repr_html_ = notebook  # type: ignore[attr-defined]
