# SPDX-License-Identifier: GPL-3.0-or-later
"""Networks: what Cycles is told about a stack, as a list of lobes that depend on the view alone.

A tier turns a stack into a network. `lobes(cos_theta_o)` gives the lobes for views; `closure_model`
evaluates them exactly as Cycles does, and `addon.shader` writes them as a shader.
"""

from collections.abc import Callable

from ...errors import LaminaError
from ...material.stack import Stack
from ..analytic import AnalyticNetwork
from ..baked import BakedNetwork
from .auto import AutoNetwork
from .paper import WeidlichWilkieNetwork
from .patches import PatchTier

TIERS = {network.tier: PatchTier(network) for network in (WeidlichWilkieNetwork, AnalyticNetwork, BakedNetwork, AutoNetwork)}
DEFAULT_TIER = AutoNetwork.tier
# What stands in for a tier that takes time until it is there.
PROVISIONAL_TIER = AnalyticNetwork.tier
# Shaders of these hold a stack's values and not only its structure.
HOLD_VALUES = (BakedNetwork.tier, AutoNetwork.tier)


def require_tier(tier: str) -> str:
    """The tier itself. Raises LaminaError on an unknown one."""
    if tier not in TIERS:
        raise LaminaError(f"unknown tier {tier!r}; choose {', '.join(TIERS)}")
    return tier


def make_network(
    stack: Stack,
    tier: str = DEFAULT_TIER,
    live: tuple[tuple[int, str], ...] = (),
    progress: Callable[[float], None] | None = None,
):
    """The network of a stack. Raises LaminaError on an unknown tier.

    `live` names the values that a texture or an animation gives, as (index of the layer or -1, parameter): shaders
    that hold values must not hold these. `progress` gets the share done and may raise to cancel.
    """
    network = TIERS[require_tier(tier)]
    return network(stack, live=live, progress=progress) if tier in HOLD_VALUES else network(stack)
