# SPDX-License-Identifier: GPL-3.0-or-later
"""Lobe sets: what Cycles is told about a stack, as a list of lobes that depend on the view alone.

A tier turns a stack into a lobe set. `lobes(cos_theta_o)` gives the lobes for views; `closure_model`
evaluates them exactly as Cycles does, and `addon.shader` writes them as a shader.
"""

from collections.abc import Callable

from ...errors import LaminaError
from ...material.stack import Stack
from ..analytic import AnalyticLobes
from ..baked import BakedLobes
from .auto import AutoLobes
from .paper import PaperLobes
from .patches import PatchTier

TIERS = {lobe_set.tier: PatchTier(lobe_set) for lobe_set in (PaperLobes, AnalyticLobes, BakedLobes, AutoLobes)}
DEFAULT_TIER = AutoLobes.tier
# What stands in for a tier that takes time until it is there.
PROVISIONAL_TIER = AnalyticLobes.tier
# Shaders of these hold a stack's values and not only its structure.
HOLD_VALUES = (BakedLobes.tier, AutoLobes.tier)


def require_tier(tier: str) -> str:
    """The tier itself. Raises LaminaError on an unknown one."""
    if tier not in TIERS:
        raise LaminaError(f"unknown tier {tier!r}; choose {', '.join(TIERS)}")
    return tier


def make_lobe_set(
    stack: Stack,
    tier: str = DEFAULT_TIER,
    live: tuple[tuple[int, str], ...] = (),
    progress: Callable[[float], None] | None = None,
):
    """The lobe set of a stack. Raises LaminaError on an unknown tier.

    `live` names the values that a texture or an animation gives, as (index of the layer or -1, parameter): shaders
    that hold values must not hold these. `progress` gets the share done and may raise to cancel.
    """
    lobe_set = TIERS[require_tier(tier)]
    return lobe_set(stack, live=live, progress=progress) if tier in HOLD_VALUES else lobe_set(stack)
