# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples of a model, as a measurement: what a stack, or a fit by others, would look like measured."""

import numpy as np

from ...errors import LaminaError, Sentence
from ...material.stack import Stack
from ...registry import make_model
from .measurement import Measurement, checked, spread_pairs

PAIRS = 3000


def sample_model(model: str, stack: Stack, only_nm: float | None = None, pairs: int = PAIRS, noise: float = 0.0, seed: int = 0) -> Measurement:
    """`pairs` values of a model of a stack, spread over the hemispheres, with multiplicative noise of deviation `noise`.

    Raises LaminaError for a model that does not know the stack.
    """
    if pairs < 1:
        raise LaminaError("{pairs} pairs of directions; choose at least 1", pairs=pairs)
    rng = np.random.default_rng(seed)
    wi, wo = spread_pairs(pairs, rng)
    f = make_model(model, stack).f(wo, wi)
    f = f * np.maximum(1.0 + noise * rng.standard_normal(f.shape), 0.0)
    return checked(wi, wo, f, f"model {model} of {stack.name or 'a stack'}", (Sentence("samples of the model {model}", model=model),), only_nm=only_nm)
