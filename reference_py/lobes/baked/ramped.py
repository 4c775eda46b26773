# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes for OSL alone, in which the light of a base has the ramp of where it goes (`diffuse_ramp`), so that fits have only what the layers reflect."""

from dataclasses import replace
from functools import cached_property

import numpy as np

from ...optics.bases import DiffuseBase
from ...optics.optical_stack import OpticalStack
from ..diffuse_ramp import RAMP_COSINES, ramp_of
from ..samples import view_of
from ..truth import truth_of
from ..view_table import DiffuseTable, TableLobes, interpolate, knot_cosines
from .bake import Baker
from .base_ramp import reciprocal
from .black_and_white import light_of, over
from .plan import Plan, best_path


class RampBaker:
    """Bakes of the stack of a Baker, whose truth they share."""

    def __init__(self, baker: Baker):
        self._baker = baker
        self._tables, self._rest = baker.known
        stack = OpticalStack.of(baker.stack)
        self._is_diffuse = isinstance(stack.base, DiffuseBase)
        scatters = any(surface.scattering is not None for surface in stack.interfaces)
        self._is_able = not baker.is_smooth and bool(self._tables) and (self._is_diffuse or scatters)

    def counts(self, most: int) -> range:
        """The numbers of glossy lobes, up to `most`, of which there are bakes; none where the Baker's own have the ramp, or nothing is known of the top."""
        least = len(self._tables)
        return range(least, (most if self._is_diffuse else min(most, least)) + 1) if self._is_able else range(0)

    def lobe_set(self, glossy: int) -> TableLobes:
        """The bake of so many glossy lobes, one of `counts`. Without fits all that is left is taken for the base's light."""
        free = glossy - len(self._tables)
        if not free:
            return TableLobes((*self._tables, reciprocal(DiffuseTable(self._rest))))
        base, plan = self._beside_base
        path = best_path(plan, plan.branches(free))
        *fitted, lambert = self._baker.fitted(path, np.maximum(self._rest - base.weight, 0.0), keep=(DiffuseTable,), at_least=True)
        return TableLobes((*self._tables, *fitted, replace(base, weight=base.weight + lambert.weight)))

    @cached_property
    def _beside_base(self) -> tuple[DiffuseTable, Plan]:
        """The base's light, and a plan for what is left."""
        stack, truth = self._baker.stack, self._baker.truth
        if OpticalStack.of(stack).base.sigma_deg:
            # a rough base's light knows still where it came from: all that it adds is taken to go as it comes
            views = np.stack([view_of(c) for c in knot_cosines()])
            light = through = np.maximum(truth.albedo(views) - truth_of(over(stack, 0.0)).albedo(views), 0.0)
        else:
            through, back = light_of(truth)
            color = np.clip(stack.base["color"], 0.0, 1.0)
            light = through * color / (1.0 - back * color)
        base = DiffuseTable(light, ramp=ramp_of(interpolate(through, RAMP_COSINES)))
        return base, self._baker.plan(self._baker.top, base)
