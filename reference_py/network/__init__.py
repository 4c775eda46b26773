# SPDX-License-Identifier: GPL-3.0-or-later
"""Networks: what Cycles is told about a stack, as a list of lobes that depend on the view alone.

A tier turns a stack into a network. `lobes(cos_theta_o)` gives the lobes for views; `models.mirror`
evaluates them exactly as Cycles does, and `addon.network` writes them as a shader.
"""

from ..errors import LaminaError
from ..stack import Stack
from .weidlich_wilkie import WeidlichWilkieNetwork

TIERS = {network.tier: network for network in (WeidlichWilkieNetwork,)}
DEFAULT_TIER = WeidlichWilkieNetwork.tier


def make_network(stack: Stack, tier: str = DEFAULT_TIER):
    """The network of a stack. Raises LaminaError on an unknown tier."""
    if tier not in TIERS:
        raise LaminaError(f"unknown tier {tier!r}; choose {', '.join(TIERS)}")
    return TIERS[tier](stack)
