# SPDX-License-Identifier: GPL-3.0-or-later
"""Bare bases of which Cycles has a closure of its own."""

from ..material.schema import ANISOTROPY
from ..material.stack import Stack
from ..optics.bases import DiffuseBase
from ..optics.optical_stack import OpticalStack


def is_bare_oren_nayar(stack: Stack) -> bool:
    """Whether Cycles has the stack itself as closures, which tables do not know."""
    base = OpticalStack.of(stack).base
    return not stack.layers and isinstance(base, DiffuseBase) and base.sigma_deg > 0.0


def is_bare_brushed(stack: Stack) -> bool:
    """Whether the stack is a brushed metal alone, which one live closure shows within 1 %: tables follow live values of it, and need hold no others."""
    return not stack.layers and stack.base.has(ANISOTROPY)
