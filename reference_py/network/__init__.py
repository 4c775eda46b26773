# SPDX-License-Identifier: GPL-3.0-or-later
"""Networks: what Cycles is told about a stack, as a list of lobes that depend on the view alone.

A tier turns a stack into a network. `lobes(cos_theta_o)` gives the lobes for views; `models.mirror`
evaluates them exactly as Cycles does, and `addon.network` writes them as a shader.
"""

from ..errors import LaminaError
from ..stack import Stack
from .analytic import AnalyticNetwork
from .baking import BakedNetwork
from .choice import AutoNetwork
from .weidlich_wilkie import WeidlichWilkieNetwork

TIERS = {network.tier: network for network in (WeidlichWilkieNetwork, AnalyticNetwork, BakedNetwork, AutoNetwork)}
DEFAULT_TIER = WeidlichWilkieNetwork.tier
# Shaders of these hold a stack's values and not only its structure.
HOLD_VALUES = (BakedNetwork.tier, AutoNetwork.tier)


def require_tier(tier: str) -> str:
    """The tier itself. Raises LaminaError on an unknown one."""
    if tier not in TIERS:
        raise LaminaError(f"unknown tier {tier!r}; choose {', '.join(TIERS)}")
    return tier


def make_network(stack: Stack, tier: str = DEFAULT_TIER):
    """The network of a stack. Raises LaminaError on an unknown tier."""
    return TIERS[require_tier(tier)](stack)
