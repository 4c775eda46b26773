# SPDX-License-Identifier: GPL-3.0-or-later
"""How wrong a stack's shader is said to be, for the header of its pictures. Needs no bpy."""

from ...reference_py.errors import LaminaError
from ...reference_py.lobes.cache import cached
from ...reference_py.lobes.error_estimate import ErrorEstimator, ball_cosines
from ...reference_py.lobes.methods import DEFAULT_METHOD, key_of, make_lobe_set
from ...reference_py.lobes.tabulate import stock_lobes
from ...reference_py.lobes.truth import truth_of
from ...reference_py.material.stack import Stack


def estimate(stack: Stack, tier: str, osl: bool) -> dict[str, str]:
    """Texts "lamina:chosen" and "lamina:error", with OSL or in stock nodes: errors as shares of the reflected light, or why there are none."""
    made = make_lobe_set(stack, tier)
    if made.choice is not None:
        c = made.choice.shown(osl)
        chosen, error = c.label, {"albedo": c.albedo, "soft_light": c.soft_light, "shape": c.shape}
    else:
        chosen = made.lobe_set.name
        try:
            lobe_set = made.lobe_set if osl else stock_lobes(made.lobe_set)
            error = cached(f"errors {tier} {osl} {key_of(stack, DEFAULT_METHOD)}", lambda: _judged(stack, lobe_set), dict, dict)
        except LaminaError as why:
            return {"lamina:chosen": chosen, "lamina:error": f"unknown: {why}"}
    return {"lamina:chosen": chosen, "lamina:error": " ".join(f"{name} {value:.5f}" for name, value in error.items())}


def _judged(stack: Stack, lobe_set) -> dict[str, float]:
    errors = ErrorEstimator(stack, truth_of(stack), ball_cosines()).errors(lobe_set)
    return {"albedo": float(errors.albedo.max()), "soft_light": float(errors.soft_light.mean()), "shape": float(errors.shape.mean())}
