# SPDX-License-Identifier: GPL-3.0-or-later
"""How far what Cycles renders of a stack lies from the truth, at the default quality."""

from typing import NamedTuple

import numpy as np

from ...reference_py.lobes.cache import truth_of
from ...reference_py.lobes.error_estimate import ErrorEstimator
from ...reference_py.lobes.methods import DEFAULT_TIER, make_lobe_set
from ...reference_py.lobes.methods.auto import AutoLobes
from ...reference_py.lobes.methods.not_bakeable import unbaked
from ...reference_py.material.coverage import patches
from ...reference_py.material.stack import Stack
from ...reference_py.optics.frame import spherical
from ...reference_py.registry import make_model

THETA_DEG = np.array([0.0, 30.0, 60.0, 75.0])
# Views of brushed surfaces: along the tangent and across.
_PHI_DEG = np.array([0.0, 90.0])


class StackErrors(NamedTuple):
    """What the tier is for a stack, and its worst errors as shares; `shape` is None where the truth is walks.

    `stderr` is the albedo's standard error, 0 where the truth has no noise.
    """

    chosen: str
    closures: int
    truth: str
    albedo: float
    stderr: float
    shape: float | None


def errors_of(stack: Stack) -> StackErrors:
    """Errors of the default tier against the truth that knows the stack's features."""
    lobe_set = make_lobe_set(stack, DEFAULT_TIER)
    return _against_walks(stack, lobe_set) if unbaked(stack) else _against_adding(stack, lobe_set)


def _against_adding(stack: Stack, lobe_set) -> StackErrors:
    found, labels = [], []
    for patch in patches(stack):
        part = AutoLobes(patch.stack)
        labels.append(part.choice.chosen.label)
        found.append(ErrorEstimator(patch.stack, truth_of(patch.stack), np.cos(np.radians(THETA_DEG))).errors(part))
    albedo, shape = (max(float(np.max(getattr(e, name))) for e in found) for name in ("albedo", "shape"))
    return StackErrors(" and ".join(dict.fromkeys(labels)), lobe_set.lobe_count, "adding", albedo, 0.0, shape)


def _against_walks(stack: Stack, lobe_set) -> StackErrors:
    wo = spherical(np.radians(THETA_DEG)[:, None], np.radians(_PHI_DEG)).reshape(-1, 3)
    truth, stderr = make_model("position_free", stack).albedo_stderr(wo)
    told = make_model("mirror", stack, tier=DEFAULT_TIER).albedo(wo)
    error, noise = np.abs(told / truth - 1.0), stderr / truth
    return StackErrors(lobe_set.resolved.tier, lobe_set.lobe_count, "position_free", float(error.max()), float(noise.max()), None)
