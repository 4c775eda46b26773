# SPDX-License-Identifier: GPL-3.0-or-later
"""How wrong a stack's shader is said to be, for the header of its pictures. Needs no bpy."""

from ...reference_py.errors import LaminaError
from ...reference_py.lobes.cache import remembered, truth_of
from ...reference_py.lobes.error_estimate import Judge, ball_cosines
from ...reference_py.lobes.methods import AutoNetwork, make_network
from ...reference_py.lobes.view_table import TableNetwork
from ...reference_py.material.stack import Stack


def estimate(stack: Stack, tier: str) -> dict[str, str]:
    """Texts "lamina:chosen" and "lamina:error": errors as shares of the reflected light, or why there are none."""
    network = make_network(stack, tier)
    own = isinstance(network, AutoNetwork)
    # tables alone do not know which tier they were made by
    told = network if isinstance(network.resolved, TableNetwork) else network.resolved
    chosen = network.choice.chosen.label if own else told.tier
    if own:
        c = network.choice.chosen
        error = {"albedo": c.albedo, "soft_light": c.soft_light, "shape": c.shape}
    else:
        try:
            error = remembered(f"errors {tier} {AutoNetwork.key(stack)}", lambda: _judged(stack, network), dict, dict)
        except LaminaError as why:
            return {"lamina:chosen": chosen, "lamina:error": f"unknown: {why}"}
    return {"lamina:chosen": chosen, "lamina:error": " ".join(f"{name} {value:.5f}" for name, value in error.items())}


def _judged(stack: Stack, network) -> dict[str, float]:
    errors = Judge(stack, truth_of(stack), ball_cosines()).errors(network)
    return {"albedo": float(errors.albedo.max()), "soft_light": float(errors.soft_light.mean()), "shape": float(errors.shape.mean())}
