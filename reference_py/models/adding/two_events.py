# SPDX-License-Identifier: GPL-3.0-or-later
"""Light that a rough surface reflects twice, as a formula: the part of f that polynomials and azimuthal modes cannot hold near grazing.

Both lobes of two reflections are narrow there: their width in azimuth is that of the facets times the cosine. On a Smith microsurface
(Heitz16) the heights of both events integrate to a quotient of Lambdas, and what is left is one integral over the direction w between them,

    f = 1 / (16 cos_o cos_i (1 + L_o + L_i)) int D(h(o, w)) F D(h(-w, i)) F / (|cos_w| (1 + L_w + L)) dw,

L being L_o where w rises and L_i where it falls, and h the facets' normals. In azimuth it is a convolution, done by Fourier transforms of
samples; over the cosine of w it is cut at the nodes of a table, in which f is interpolated.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ...optics import microfacet
from ...optics.facet_reflectance import Facet
from ...optics.gauss import gauss_legendre
from .bounces import ENERGY, NARROW_ALPHA, Microsurface
from .facets import smith_lambda

# Directions of the table from the normal to grazing and azimuths of the half circle, for surfaces narrower than this and for others.
_NARROW, _FINE, _COARSE = 0.15, (28, 256), (20, 128)
# Samples about the middle of a lobe that are means, and the nodes of each.
_NEAR, _NODES = 3, 6
# Cells of the table of Fresnel's curve over the facet's cosine.
_CELLS = 4096
# The last direction of the table: closer to grazing f changes no more.
_LAST = 1e-3
# What is less than this share of f at its best azimuth is rounding, whose logarithm a cubic must not follow.
_NOISE, _LEAST = 1e-12, 1e-60


@dataclass(frozen=True, eq=False, repr=False)
class TwoReflections:
    """f of `curves` Fresnel curves, tabulated."""

    alpha: float
    distribution: str
    log_f: np.ndarray
    """(directions, directions, azimuths + 1, curves) logarithm of f times `_fading`, at even steps of `_place` and of azimuth from the mirror's on."""

    def __call__(self, cos_o: np.ndarray, cos_i: np.ndarray, cos_turn: np.ndarray) -> np.ndarray:
        """f (P, curves) in 1/sr; a turn of 0 is that of a mirror."""
        o, weight_o = _around(_place(cos_o, self.alpha), self.log_f.shape[0])
        i, weight_i = _around(_place(cos_i, self.alpha), self.log_f.shape[1])
        turn = np.arccos(np.clip(cos_turn, -1.0, 1.0)) / np.pi * (self.log_f.shape[2] - 1)
        cell = np.minimum(turn.astype(int), self.log_f.shape[2] - 2)
        # curve by curve, at places in a row: gathering is most of it
        across, along, curves = self.log_f.strides[0] // 8, self.log_f.strides[1] // 8, self.log_f.shape[3]
        first, share = o * across + i * along + cell * curves, turn - cell
        result = np.zeros((len(cos_o), curves))
        for a in range(4):
            for b in range(4):
                weight = weight_o[a] * weight_i[b]
                for curve in range(curves):
                    here = self.log_f.ravel()[a * across + b * along + curve :]
                    low = here.take(first)
                    low += share * (here[curves:].take(first) - low)
                    low *= weight
                    result[:, curve] += low
        fading = _fading(smith_lambda(cos_o, self.alpha, self.distribution), smith_lambda(cos_i, self.alpha, self.distribution))
        return np.exp(result) / fading[:, None]


def _fading(lambda_o, lambda_i):
    """f falls as the inverse of this where one direction is closer to grazing than the other: it sees the top alone, which has no second facet."""
    return np.square(1.0 + lambda_o + lambda_i) / ((1.0 + lambda_o) * (1.0 + lambda_i))


def _around(place, count: int):
    """First of the four nodes about a place in [0, 1], and their weights (4, P) in the cubic through them."""
    x = place * (count - 1)
    first = np.clip(x.astype(int) - 1, 0, count - 4)
    t = x - first
    return first, [-(t - 1) * (t - 2) * (t - 3) / 6.0, t * (t - 2) * (t - 3) / 2.0, -t * (t - 1) * (t - 3) / 2.0, t * (t - 1) * (t - 2) / 6.0]


def _place(cos_theta, alpha: float):
    """0 to 1 from the normal to grazing, half of it in the angle and half in that of the surface stretched to alpha 1, dense at grazing."""
    sin_theta = np.sqrt(np.maximum(1.0 - np.square(cos_theta), 0.0))
    even = (np.arctan2(sin_theta, cos_theta) + np.arctan2(alpha * sin_theta, cos_theta)) / np.pi
    return 1.0 - np.sqrt(1.0 - np.minimum(even, 1.0))


# of films one table holds many curves, some megabytes
@lru_cache(maxsize=8)
def two_reflections(alpha: float, distribution: str, facets: tuple[Facet, ...]) -> TwoReflections:
    """That of a surface of these facets, a curve each."""
    directions, azimuths = _FINE if alpha < _NARROW else _COARSE
    angles = 1.0 - np.square(np.linspace(1.0, 0.0, 2049))
    nodes = np.interp(np.linspace(0.0, 1.0, directions), _place(np.cos(0.5 * np.pi * angles), alpha), angles)
    cos = np.maximum(np.cos(0.5 * np.pi * nodes), _LAST)
    z, weights = _between(np.append(cos, 0.0)[::-1], alpha)
    facet_cosines = np.linspace(0.0, 1.0, _CELLS + 1)
    curves = [facet(facet_cosines) for facet in facets]
    own, between = smith_lambda(cos, alpha, distribution), smith_lambda(z, alpha, distribution)
    rising = weights / (z * (1.0 + own[:, None] + between))
    up = _lobes(cos, z, alpha, distribution, curves, azimuths)
    down = _lobes(cos, -z, alpha, distribution, curves, azimuths)
    scale = _fading(own[:, None], own) / (16.0 * cos[:, None] * cos * (1.0 + own[:, None] + own))
    (o, i), tables = np.triu_indices(directions), []
    for facet, first, then in zip(facets, up, down):
        # (modes, o, z) @ (modes, z, i)
        half = np.ascontiguousarray(np.moveaxis(first * rising[..., None], -1, 0)) @ np.ascontiguousarray(np.moveaxis(then, -1, 0)).swapaxes(-1, -2)
        further = _further(cos, alpha, distribution, facet)
        # light may go either way: half of all pairs
        f = np.fft.irfft((half[:, o, i] + half[:, i, o]).T)[:, : azimuths + 1]
        f *= (np.pi / azimuths) * (scale * (1.0 + further[:, None] * further))[o, i, None]
        table = np.empty((directions, directions, azimuths + 1))
        table[o, i] = table[i, o] = np.log(np.maximum(f, _NOISE * np.max(f, axis=-1, keepdims=True) + _LEAST))
        tables.append(table)
    return TwoReflections(alpha, distribution, np.stack(tables, axis=-1))


def _further(cos, alpha: float, distribution: str, facet: Facet):
    """(I,) whose products are what a narrow surface reflects otherwise, over what it reflects twice: from the energies of both."""
    if alpha >= NARROW_ALPHA:
        return np.zeros(len(cos))
    again, twice = Microsurface(alpha, distribution, facet).shares(cos, ENERGY)
    return np.sqrt(np.clip(again[0, 0, :, 0] / np.maximum(twice[0, :, 0], 1e-9) - 1.0, 0.0, 1.0))


def _between(edges, alpha: float):
    """Nodes and weights between edges (E,), ascending, dense at both, where lobes as narrow as alpha may lie."""
    half = 0.5 * np.diff(edges)
    rate = np.log1p(half / alpha)
    # the middle of each half in a variable whose logarithm is even
    step, measure = alpha * np.expm1(0.5 * rate), rate * alpha * np.exp(0.5 * rate)
    return np.stack([edges[:-1] + step, edges[1:] - step], axis=1).ravel(), np.repeat(measure, 2)


def _lobes(cos, z, alpha, distribution, curves, azimuths):
    """By curve, the spectrum (I, Z, azimuths + 1) over azimuth of D F of the facets that turn light from cosines (I,) to cosines z (Z,)."""
    # no facet turns light to where it goes down more steeply than it came
    own, other = np.nonzero(cos[:, None] + z > 0.0)
    come, go = cos[own, None], z[other, None]
    rise, base = come + go, 2.0 * (1.0 + come * go)
    sines, inverse_rise2 = 2.0 * np.sqrt((1.0 - np.square(come)) * (1.0 - np.square(go))), 1.0 / np.square(np.maximum(rise, 1e-15))
    law = microfacet.distribution_of(distribution)

    def lobe(cos_phi):
        length2 = base - sines * cos_phi
        np.maximum(length2, 1e-30, out=length2)
        cell = np.sqrt(length2)
        cell *= 0.5 * _CELLS
        cell += 0.5
        cell = cell.astype(np.int32)
        length2 *= inverse_rise2  # 1 / cos^2 of the facet
        facets = law.slope_density((length2 - 1.0) * (1.0 / alpha**2))
        facets *= length2
        facets *= length2
        facets *= 1.0 / (np.pi * alpha**2)
        return [facets * curve[cell] for curve in curves]

    # the samples that a lobe may be narrower than are means over their cells, by an angle in which it is smooth
    step, width = np.pi / azimuths, np.maximum(alpha * rise, 1e-9)
    edges = np.arctan(step * np.maximum(np.arange(_NEAR + 1) - 0.5, 0.0) / width)
    x, gauss = gauss_legendre(_NODES)
    span = 0.5 * np.diff(edges)[..., None]
    t = edges[:, :-1, None] + span * (x + 1.0)
    shares = gauss * span / np.square(np.cos(t))
    shares /= np.sum(shares, axis=-1, keepdims=True)
    near = lobe((np.cos(width[..., None] * np.tan(t))).reshape(len(t), -1))
    spectra = []
    for values, fine in zip(lobe(np.cos(step * np.arange(azimuths + 1))), near):
        values[:, :_NEAR] = np.sum(fine.reshape(t.shape) * shares, axis=-1)
        spectra.append(np.zeros((len(cos), len(z), azimuths + 1)))
        spectra[-1][own, other] = np.fft.rfft(np.concatenate([values, values[:, -2:0:-1]], axis=-1), axis=-1).real
    return spectra
