# SPDX-License-Identifier: GPL-3.0-or-later
"""What a lobe set costs to render: what its parts cost, fitted to renders (`study/calibrate_cost.py`)."""

import numpy as np

from ...optics.bases import ConductorBase
from ..analytic import AnalyticLobes
from ..closure import is_specular_lobe
from ..lobe import DiffuseLobe, GlossyLobe
from .paper import PaperLobes

# CPU time over that of a frame-filling object with a plain glossy node: of the object itself, of light that is sampled for closures that are
# no mirrors, of each closure, and of each layer's arithmetic in a live method; OSL folds that of `analytic` where parameters are constant and
# layers few. Closures' are to .05 what `study/calibrate_cost.py` finds. Layers' stand for many: a clear smooth one takes .1 to .2, a rough
# tinted one .45 to .7 where it folds or is of `weidlich_wilkie`.
PARTS = {
    "object": 0.5,
    "lit": 0.35,
    "diffuse": 0.07,
    "mirror": 0.1,
    "glossy": 0.2,
    "folded_layer": 0.15,
    "folded_layer_over_metal": 0.8,
    "analytic_layer": 0.8,
    "analytic_layer_over_metal": 2.4,
    "weidlich_wilkie_layer": 0.5,
}
FOLDED_LAYERS = 3


def cost(lobe_set, live: bool = False) -> float:
    """An estimate of the CPU time of a frame-filling object over that of a plain glossy node; `live` values are not constant.

    Of 30 materials of up to five closures the worst is 12 % off, with live methods of rough tinted layers 43 % (figures/cost_fit.csv).
    Of those of `lamina chart pareto` bare copper by `analytic` is off by more than a quarter: 1.05 is estimated for 1.53
    (tests/study/test_calibration.py).
    """
    return sum(PARTS[part] * count for part, count in parts(lobe_set, live).items())


def parts(lobe_set, live: bool = False) -> dict[str, int]:
    """How many of which parts a lobe set has."""
    lobes = lobe_set.lobes(np.ones(1))
    diffuse = sum(isinstance(lobe, DiffuseLobe) for lobe in lobes)
    mirror = sum(isinstance(lobe, GlossyLobe) and is_specular_lobe(lobe) for lobe in lobes)
    found = {"object": 1, "lit": int(mirror < len(lobes)), "diffuse": diffuse, "mirror": mirror, "glossy": len(lobes) - diffuse - mirror}
    if isinstance(lobe_set, AnalyticLobes):
        folds = not live and len(lobe_set.stack.layers) <= FOLDED_LAYERS
        over_metal = isinstance(lobe_set.base, ConductorBase)
        found[f"{'folded' if folds else 'analytic'}_layer{'_over_metal' if over_metal else ''}"] = len(lobe_set.stack.layers)
    elif isinstance(lobe_set, PaperLobes):
        found["weidlich_wilkie_layer"] = len(lobe_set.stack.layers)
    return found
