# SPDX-License-Identifier: GPL-3.0-or-later
"""Tier `baked`: the truth of a stack, computed once and fitted by few closures at every knot of the view.

Energy is exact at the knots by construction: the fitted weights are scaled to what `adding` says.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ...optics.material import interfaces, rough_surfaces
from ...optics.microfacet import GGX, is_specular
from ...stack import Stack
from ..closure import unit_energy
from ..lobe import DielectricCurve, DiffuseLobe, GlossyLobe
from ..table import KNOTS, DiffuseTable, GlossyTable, TableNetwork, knot_cosines, middle_cosines
from .fit import Mixture
from .memory import remembered, truth_of
from .plan import Plan, best_path
from .samples import truth_at

DEFAULT_GLOSSY, MAX_GLOSSY = 2, 4
# A lobe that nowhere carries more than this share of the albedo is left out.
_NEGLIGIBLE = 1e-3


@dataclass(frozen=True)
class Bake:
    """`network` in tables; `shape_error` (KNOTS,) is its cosine-weighted L1 at each knot, worst channel."""

    network: TableNetwork
    shape_error: np.ndarray


class Baker:
    """Bakes one stack with ever more lobes; what fewer lobes found is where more begin.

    `truth` is a model with f, albedo and mirror_albedo. `progress` is called with the share done; an exception that
    it raises cancels.
    """

    def __init__(self, stack: Stack, truth, progress: Callable[[float], None] | None = None):
        self._report = progress or (lambda share: None)
        cosines, surfaces = knot_cosines(), rough_surfaces(stack)
        widths = [alpha for _, alpha in surfaces]
        self._mirror = truth.mirror_albedo(cosines)
        views = truth_at(truth, np.concatenate([cosines, middle_cosines()]), widths)
        self._albedo = truth.albedo(np.stack([v.wo for v in views[:KNOTS]]))
        top = _top_lobe(stack)
        known = [None] if top is None else [None, top]
        self._plans = [Plan(lobe, surfaces, views[:KNOTS], views[KNOTS:]) for lobe in known]
        self._report(0.3)

    def bake(self, glossy: int) -> Bake:
        """The best that at most `glossy` glossy lobes and a Lambert lobe do."""
        spare = glossy - bool(np.any(self._mirror > 0.0))
        trials = []
        for done, plan in enumerate(self._plans):
            free = spare - (plan.known is not None)
            if free >= 0:
                trials.append((plan, plan.branches(free, lambda: self._report(0.3 + 0.6 * done / len(self._plans)))))
        plan, trial = min(trials, key=lambda t: t[1].error) if trials else (self._plans[0], self._plans[0].branches(0))
        mixtures = best_path(plan, trial)
        self._report(0.9)
        return Bake(self._network(plan.known, trial.kinds, mixtures), np.array([m.error for m in mixtures]))

    def _network(self, known: GlossyLobe | None, kinds: tuple[str, ...], mixtures: list[Mixture]) -> TableNetwork:
        cosines = knot_cosines()
        tables, spent = [], self._mirror
        ones = np.ones((len(cosines), 3))
        if np.any(self._mirror > 0.0):
            tables.append(GlossyTable(GGX, self._mirror, np.zeros((len(cosines), 3))))
        if known is not None:
            shape = np.array([known.alpha_x, known.alpha_y, 0.0]) * ones
            tables.append(GlossyTable(known.distribution, ones, shape, known.fresnel))
            spent = spent + unit_energy(known, cosines)
        fitted = []
        for i, kind in enumerate(kinds):
            shape = np.array([m.shape[i] for m in mixtures])
            weight = np.array([m.weight[:, i] for m in mixtures])
            table = GlossyTable(kind, weight, np.concatenate([np.exp(shape[:, :2]), shape[:, 2:]], axis=1))
            fitted.append((table, weight * unit_energy(table.lobe(cosines), cosines)))
        diffuse = np.array([m.weight[:, -1] for m in mixtures])
        fitted.append((DiffuseTable(diffuse), diffuse))
        fitted = [(table, energy) for table, energy in fitted if np.any(energy > _NEGLIGIBLE * self._albedo)]
        total = sum((energy for _, energy in fitted), np.zeros_like(self._albedo))
        scale = np.maximum(self._albedo - spent, 0.0) / np.maximum(total, 1e-12)
        return TableNetwork((*tables, *(replace(table, weight=table.weight * scale) for table, _ in fitted)))


class BakedNetwork:
    """A stack baked at construction: see `Baker`. Stacks of equal content share one bake in memory."""

    tier = "baked"

    def __init__(self, stack: Stack, glossy: int = DEFAULT_GLOSSY, progress: Callable[[float], None] | None = None):
        self.stack = stack
        self.bake = remembered(stack, ("baked", glossy), lambda: Baker(stack, truth_of(stack), progress).bake(glossy))
        self.resolved = self.bake.network

    @property
    def lobe_count(self) -> int:
        return self.resolved.lobe_count

    def lobes(self, cos_theta_o: np.ndarray) -> list[GlossyLobe | DiffuseLobe]:
        """The lobes for views of cosine cos_theta_o (...); weights are (..., 3)."""
        return self.resolved.lobes(cos_theta_o)


def _top_lobe(stack: Stack) -> GlossyLobe | None:
    """The closure that is exact for one event on a rough top interface, where there is one and nothing dims it."""
    for surface in interfaces(stack):
        if surface.eta != 1.0:
            if is_specular(surface.alpha):
                return None
            alpha = surface.alpha
            return GlossyLobe(surface.distribution, np.ones(3), alpha, alpha, fresnel=DielectricCurve(surface.eta))
        if np.any(surface.tau > 0.0):
            return None
    return None
