# SPDX-License-Identifier: GPL-3.0-or-later
"""Truth at one view, as points that any lobe of the stack is seen by."""

from dataclasses import dataclass

import numpy as np

from ..optics.microfacet import GGX
from ..optics.quadrature import balanced_directions

# Widths of successive strategies are at most this factor apart.
_STEP = 3.0
# Points of each strategy.
_COUNT = 300


@dataclass(frozen=True)
class View:
    """`wi` (q, 3), `share` (q,) the measure cos(theta_i) dw of each point, `f` (q, 3) the truth there."""

    cos_theta_o: float
    wo: np.ndarray
    wi: np.ndarray
    share: np.ndarray
    f: np.ndarray

    def distance(self, f: np.ndarray) -> float:
        """Cosine-weighted L1 between f (q, 3) and the truth over the truth's albedo, worst channel."""
        gap = self.share @ np.abs(f - self.f)
        return float(np.max(gap / np.maximum(self.share @ self.f, 1e-9)))


def view_of(cos_theta_o: float) -> np.ndarray:
    """wo (3,) in the xz plane."""
    return np.array([np.sqrt(max(1.0 - cos_theta_o**2, 0.0)), 0.0, cos_theta_o])


def truth_at(truth, cosines: np.ndarray, widths: list[float]) -> list[View]:
    """Samples of `truth` at view cosines; `widths` are the alphas of the stack's rough surfaces."""
    placed = [_points(cos_o, _ladder(widths)) for cos_o in cosines]
    wo = np.concatenate([np.broadcast_to(view_of(c), wi.shape) for c, (wi, _) in zip(cosines, placed)])
    f = truth.f(wo, np.concatenate([wi for wi, _ in placed]))
    ends = np.cumsum([len(wi) for wi, _ in placed])[:-1]
    return [View(float(c), view_of(c), wi, share, part) for c, (wi, share), part in zip(cosines, placed, np.split(f, ends))]


def _ladder(widths: list[float]) -> list[float]:
    """Alphas from the narrowest to what all surfaces together may blur to."""
    if not widths:
        return []
    low, high = min(widths), min(1.0, float(np.sqrt(np.sum(np.square(widths)))))
    return list(np.geomspace(low, high, int(np.ceil(np.log(high / low) / np.log(_STEP))) + 1)) if high > low else [low]


def _points(cos_o: float, alphas: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """wi (q, 3) on the half with y >= 0, as f is even in azimuth, and their measure (q,)."""
    wi, measure = balanced_directions(view_of(cos_o), [(GGX, alpha) for alpha in alphas], _COUNT)
    wi[:, 1] = np.abs(wi[:, 1])
    return wi, measure
