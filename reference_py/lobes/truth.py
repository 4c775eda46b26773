# SPDX-License-Identifier: GPL-3.0-or-later
"""The truth that methods are judged by and bakes are fitted to."""

from ..errors import LaminaError
from ..material.coverage import is_plain
from ..material.schema import ANISOTROPY
from ..material.stack import Stack
from ..models.adding.adding_model import Adding
from .brushing import without_idle


def truth_of(stack: Stack):
    """The deterministic truth of a stack, its f a draft (`Adding`); it has no normals. Raises LaminaError for several patches and for anisotropy, of which 0 is none."""
    if not is_plain(stack):
        raise LaminaError("a stack with coverage or opaque layers has one truth for each of its patches; judge them one by one")
    stack, _ = without_idle(stack)
    for where, element in [*((f"layer {i}", e) for i, e in enumerate(stack.layers)), ("the base", stack.base)]:
        if element.has(ANISOTROPY):
            raise LaminaError(f"the truth that methods are judged by, adding, knows no {ANISOTROPY.name}, which {where} has")
    return Adding(stack, draft=1)
