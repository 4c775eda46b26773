# SPDX-License-Identifier: GPL-3.0-or-later
"""How wrong a stack's shader is said to be, for the header of its pictures. Needs no bpy."""

from ...reference_py.errors import LaminaError
from ...reference_py.lobes.cache import remembered, truth_of
from ...reference_py.lobes.error_estimate import ErrorEstimator, ball_cosines
from ...reference_py.lobes.methods import AutoLobes, make_lobe_set
from ...reference_py.lobes.view_table import TableLobes
from ...reference_py.material.stack import Stack


def estimate(stack: Stack, tier: str) -> dict[str, str]:
    """Texts "lamina:chosen" and "lamina:error": errors as shares of the reflected light, or why there are none."""
    lobe_set = make_lobe_set(stack, tier)
    own = isinstance(lobe_set, AutoLobes)
    # tables alone do not know which tier they were made by
    told = lobe_set if isinstance(lobe_set.resolved, TableLobes) else lobe_set.resolved
    chosen = lobe_set.choice.chosen.label if own else told.tier
    if own:
        c = lobe_set.choice.chosen
        error = {"albedo": c.albedo, "soft_light": c.soft_light, "shape": c.shape}
    else:
        try:
            error = remembered(f"errors {tier} {AutoLobes.key(stack)}", lambda: _judged(stack, lobe_set), dict, dict)
        except LaminaError as why:
            return {"lamina:chosen": chosen, "lamina:error": f"unknown: {why}"}
    return {"lamina:chosen": chosen, "lamina:error": " ".join(f"{name} {value:.5f}" for name, value in error.items())}


def _judged(stack: Stack, lobe_set) -> dict[str, float]:
    errors = ErrorEstimator(stack, truth_of(stack), ball_cosines()).errors(lobe_set)
    return {"albedo": float(errors.albedo.max()), "soft_light": float(errors.soft_light.mean()), "shape": float(errors.shape.mean())}
