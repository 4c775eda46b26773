# SPDX-License-Identifier: GPL-3.0-or-later
"""Truth at several views, as points that any lobe of the stack is seen by."""

from dataclasses import dataclass

import numpy as np

from ..optics.microfacet import GGX
from ..optics.quadrature import balanced_directions

# Widths of successive strategies are at most this factor apart.
_STEP = 3.0


@dataclass(frozen=True, eq=False, repr=False)
class Views:
    """Of each of V views, Q points: `wi` (V, Q, 3), `share` (V, Q) the measure cos(theta_i) dw of each, `f` (V, Q, 3) the truth there.

    `cos_theta_o` is (V,) and `wo` (V, 3), in the xz plane. Points below the horizon have no measure.
    """

    cos_theta_o: np.ndarray
    wo: np.ndarray
    wi: np.ndarray
    share: np.ndarray
    f: np.ndarray

    def thinned(self, step: int) -> "Views":
        """With every so many points."""
        return Views(self.cos_theta_o, self.wo, self.wi[:, ::step], self.share[:, ::step], self.f[:, ::step])

    def of(self, chosen) -> "Views":
        """The views that an index or a mask (V,) chooses."""
        return Views(self.cos_theta_o[chosen], self.wo[chosen], self.wi[chosen], self.share[chosen], self.f[chosen])


def view_of(cos_theta_o: float) -> np.ndarray:
    """wo (3,) in the xz plane."""
    return np.array([np.sqrt(max(1.0 - cos_theta_o**2, 0.0)), 0.0, cos_theta_o])


def truth_at(truth, cosines: np.ndarray, widths: list[float], count: int) -> Views:
    """Samples of `truth` at view cosines (V,); `widths` are the alphas of the stack's rough surfaces, `count` the points of each strategy."""
    strategies = [(GGX, alpha) for alpha in _ladder(widths)]
    wo = np.stack([view_of(c) for c in cosines])
    wi, share = balanced_directions(wo, strategies, count)
    wi[..., 1] = np.abs(wi[..., 1])  # f is even in azimuth
    f = truth.f(np.broadcast_to(wo[:, None], wi.shape), wi)
    return Views(np.asarray(cosines, float), wo, wi, share, f)


def _ladder(widths: list[float]) -> list[float]:
    """Alphas from the narrowest to what all surfaces together may blur to."""
    if not widths:
        return []
    low, high = min(widths), min(1.0, float(np.sqrt(np.sum(np.square(widths)))))
    return list(np.geomspace(low, high, int(np.ceil(np.log(high / low) / np.log(_STEP))) + 1)) if high > low else [low]
