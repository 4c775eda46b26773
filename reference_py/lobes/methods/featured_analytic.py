# SPDX-License-Identifier: GPL-3.0-or-later
"""Tier `analytic` for stacks with features. It has no colored interfaces: with a thin film `weidlich_wilkie` stands in. Normals are the renderer's."""

from ...material.stack import Stack
from ..analytic import AnalyticLobes
from ..analytic.brushed import BrushedLobes
from ..brushing import has_brushing
from .not_bakeable import has_film
from .paper import PaperLobes


def featured_analytic(stack: Stack) -> AnalyticLobes | PaperLobes:
    """The lobe set that a stack has in the method `analytic`."""
    if has_film(stack):
        return PaperLobes(stack)
    return BrushedLobes(stack) if has_brushing(stack) else AnalyticLobes(stack)
