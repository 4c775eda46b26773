# SPDX-License-Identifier: GPL-3.0-or-later
"""How far what Cycles renders of a stack lies from the truth, at the default quality."""

from typing import NamedTuple

import numpy as np

from ...reference_py.lobes.brushing import has_brushing
from ...reference_py.lobes.error_estimate import ErrorEstimator
from ...reference_py.lobes.made import Made
from ...reference_py.lobes.methods import DEFAULT_METHOD, make_lobe_set
from ...reference_py.lobes.methods.not_bakeable import not_bakeable
from ...reference_py.lobes.truth import truth_of
from ...reference_py.material.coverage import patches
from ...reference_py.material.stack import Stack
from ...reference_py.optics.error_measure import albedo_error, worst_share
from ...reference_py.optics.frame import spherical
from ...reference_py.registry import make_model

THETA_DEG = np.array([0.0, 30.0, 60.0, 75.0])
# Views of anisotropic surfaces: along the tangent and across.
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
    made = make_lobe_set(stack)
    return _against_walks(stack, made) if has_brushing(stack) or not_bakeable(stack) else _against_adding(stack, made)


def _against_adding(stack: Stack, made: Made) -> StackErrors:
    found, labels = [], []
    for patch in patches(stack):
        part = make_lobe_set(patch.stack)
        labels.append(part.choice.chosen.label)
        found.append(ErrorEstimator(patch.stack, truth_of(patch.stack), np.cos(np.radians(THETA_DEG))).errors(part))
    albedo, shape = (max(float(np.max(getattr(e, name))) for e in found) for name in ("albedo", "shape"))
    return StackErrors(" and ".join(dict.fromkeys(labels)), made.lobe_count, "adding", albedo, 0.0, shape)


def _against_walks(stack: Stack, made: Made) -> StackErrors:
    wo = spherical(np.radians(THETA_DEG)[:, None], np.radians(_PHI_DEG)).reshape(-1, 3)
    truth, stderr = make_model("position_free", stack).albedo_stderr(wo)
    albedo = make_model("closure_model", stack, method=DEFAULT_METHOD).albedo(wo)
    error, noise = albedo_error(albedo, truth), worst_share(stderr, truth)
    return StackErrors(made.lobe_set.name, made.lobe_count, "position_free", float(error.max()), float(noise.max()), None)
