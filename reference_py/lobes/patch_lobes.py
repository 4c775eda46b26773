# SPDX-License-Identifier: GPL-3.0-or-later
"""The lobes of a stack with covered or opaque layers: those of its patches, weighted by their shares."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..material.coverage import Patch
from ..material.stack import Stack
from .lobe import DiffuseLobe, GlossyLobe, SchlickCurve
from .pools import MAX_CLOSURES, MAX_NODE_CLOSURES, Energy, Pool, pooled, pools_of


@dataclass(frozen=True)
class PatchLobes:
    """The lobe sets of a stack's patches; lobes that differ in their weight alone are one, and so are those of a pool."""

    stack: Stack
    parts: tuple[tuple[Patch, Any], ...]
    """What was made of each patch (`Made`), or, of `tabulate`, its tables."""
    energy: Energy | None = None
    """Of glossy closures of weight 1, to pool lobes by; None for stock nodes, which have no table of it, but room for MAX_NODE_CLOSURES."""

    name = "patches"

    @property
    def lobe_count(self) -> int:
        """How many closures they are."""
        return len(self.lobes(np.ones(1)))

    def lobes(self, cos_theta_o: np.ndarray, phi: np.ndarray | float = 0.0) -> list[GlossyLobe | DiffuseLobe]:
        """The lobes for views of cosine cos_theta_o (...) and azimuth phi (...); weights are (..., 3)."""
        scaled, pools = [], {}
        for number, (patch, lobe_set) in enumerate(self.parts):
            for i, lobe in enumerate(lobe_set.lobes(cos_theta_o, phi) if patch.share > 0.0 else ()):
                own = replace(lobe, weight=patch.share * np.asarray(lobe.weight))
                if (number, i) in self.pools:
                    pools.setdefault(self.pools[number, i], []).append(own)
                else:
                    scaled.append(own)
        return [*merged(scaled), *(pooled(members, cos_theta_o, self.energy) for members in pools.values())]

    @cached_property
    def pools(self) -> Mapping[tuple[int, int], Pool]:
        """The pools of lobes that share one (`pools.pools_of`)."""
        return pools_of(self.parts, MAX_NODE_CLOSURES if self.energy is None else MAX_CLOSURES)


def merged(lobes: Sequence[GlossyLobe | DiffuseLobe]) -> list[GlossyLobe | DiffuseLobe]:
    """The lobes with weights of equal ones summed, in order of their first."""
    result: list[GlossyLobe | DiffuseLobe] = []
    for lobe in lobes:
        for i, other in enumerate(result):
            if _is_same(lobe, other):
                result[i] = replace(other, weight=other.weight + lobe.weight)
                break
        else:
            result.append(lobe)
    return result


def _is_same(a, b) -> bool:
    """Whether two lobes differ in their weight alone."""
    if type(a) is not type(b):
        return False
    if isinstance(a, DiffuseLobe):
        if a.ramp is not None or b.ramp is not None:
            return False
        return (a.sigma_deg, a.power) == (b.sigma_deg, b.power) and (a.color is None) == (b.color is None) and np.all(np.equal(a.color, b.color))
    if (a.distribution, a.frame) != (b.distribution, b.frame) or type(a.fresnel) is not type(b.fresnel) or isinstance(a.fresnel, SchlickCurve):
        return False
    shapes = ((a.alpha_x, b.alpha_x), (a.alpha_y, b.alpha_y), (a.tilt, b.tilt))
    return a.fresnel == b.fresnel and all(np.all(np.asarray(x) == np.asarray(y)) for x, y in shapes)
