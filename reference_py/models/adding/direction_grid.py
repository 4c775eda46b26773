# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions in the media of a stack, in the transverse momentum s = n sin(theta).

A smooth interface conserves s, so its operators are diagonal and exact where both its media have the same directions. The measure s ds dphi is
n^2 cos(theta) dw: kernels per d2p = s ds dphi already hold the n^2 of basic radiance and are symmetric.
A medium's are cut where s equals its index (grazing) or that of one near it (critical angles: `EffectiveStack.grid`). On each panel
s^2 = a^2 + (b^2 - a^2) sin^2(psi) with Gauss nodes in psi makes the square roots at both ends smooth.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import ceil

import numpy as np

from ...optics.gauss import gauss_legendre

# Of a panel: stacks of many indices have many short ones.
FEWEST_NODES = 4
# Rays whose turns `project` makes at once, and moments that `chebyshev_moments` does.
_RAYS, _BLOCK = 4096, 8


@dataclass(frozen=True)
class Grid:
    """`edges`: of each medium of a stack, the increasing indices at which its directions are cut, its own the last; `nodes`: count from 0 to 1."""

    edges: tuple[tuple[float, ...], ...]
    nodes: int

    @classmethod
    def shared(cls, indices: Iterable[float], nodes: int) -> "Grid":
        """The same directions in all media of these indices, cut at each of them."""
        cuts = sorted(set(indices))
        return cls(tuple(tuple(cuts[: i + 1]) for i in range(len(cuts))), nodes)

    @cached_property
    def _media(self) -> dict[float, "_Medium"]:
        return {edges[-1]: _Medium(edges, self.nodes) for edges in self.edges}

    def count(self, n: float) -> int:
        """Number N of nodes in a medium of index n."""
        return self._media[n].starts[-1]

    def s(self, n: float) -> np.ndarray:
        """(N,) nodes in a medium of index n."""
        return self._media[n].s

    def weights(self, n: float) -> np.ndarray:
        """(N,) integral of each node's basis function over d2p = 2 pi s ds in a medium of index n; they sum to pi n^2."""
        return self._media[n].weights

    def cosines(self, n: float) -> np.ndarray:
        """(N,) cos(theta) of the nodes in a medium of index n, precise at grazing angles."""
        return self._media[n].cosines

    def interpolation(self, n: float, cos_theta: np.ndarray, dtype: type = np.float64) -> np.ndarray:
        """(I, N) weights, in this precision, that interpolate nodal values at the cosines (I,) in a medium of index n."""
        return self._media[n].interpolation(cos_theta, dtype)

    def project(self, n: float, directions: np.ndarray, modes: int, *weights: np.ndarray, dtype: type = np.float64) -> list[np.ndarray]:
        """For each array of weights (I, Q), rows (modes, I, N) of operators on nodal values.

        They are sums, in this precision, of weights times cos(m turn) times the node's basis over end directions (I, Q, 3) in a medium of index n,
        sign of z ignored.
        """
        return self._media[n].project(directions, modes, *weights, dtype=dtype)


@dataclass(frozen=True)
class _Medium:
    """Directions in a medium whose index is the last edge."""

    edges: tuple[float, ...]
    nodes: int

    @cached_property
    def _panels(self) -> list[tuple[float, float, np.ndarray, np.ndarray]]:
        """(a, b, Gauss nodes in [-1, 1], weights) of each panel."""
        panels, a, whole = [], 0.0, self.nodes * max(1.0, self.edges[0])
        for b in self.edges:
            share = 1.0 - np.arcsin(a / b) / (0.5 * np.pi)
            panels.append((a, b, *gauss_legendre(max(FEWEST_NODES, ceil(whole * share)))))
            a = b
        return panels

    @cached_property
    def starts(self) -> list[int]:
        """Index of each panel's first node, and the total count at the end."""
        return [0, *np.cumsum([len(x) for _, _, x, _ in self._panels]).tolist()]

    @cached_property
    def s(self) -> np.ndarray:
        """Nodes (N,)."""
        return np.concatenate([np.sqrt(a * a + (b * b - a * a) * np.square(np.sin(_psi(x)))) for a, b, x, _ in self._panels])

    @cached_property
    def weights(self) -> np.ndarray:
        """Integrals (N,) of the nodes' basis functions."""
        return np.concatenate([0.25 * np.pi**2 * (b * b - a * a) * np.sin(2.0 * _psi(x)) * w for a, b, x, w in self._panels])

    @cached_property
    def cosines(self) -> np.ndarray:
        """Cosines (N,) of the nodes."""
        n = self.edges[-1]
        return np.concatenate([np.sqrt((n * n - b * b) + (b * b - a * a) * np.square(np.cos(_psi(x)))) / n for a, b, x, _ in self._panels])

    def interpolation(self, cos_theta: np.ndarray, dtype: type) -> np.ndarray:
        """Weights (I, N) of the nodes at cosines (I,), in this precision."""
        cos2 = np.square(np.asarray(cos_theta, float))
        rows = np.zeros((len(cos2), self.starts[-1]), dtype)
        panel = self._panel(1.0 - cos2)
        for p, (start, end) in enumerate(zip(self.starts, self.starts[1:])):
            here = panel == p
            rows[here, start:end] = self._basis(p, 1.0 - cos2[here], cos2[here], dtype).T @ to_nodes(end - start).astype(dtype, copy=False)
        return rows

    def project(self, directions: np.ndarray, modes: int, *weights: np.ndarray, dtype: type = np.float64) -> list[np.ndarray]:
        """`Grid.project` in this medium."""
        (count, size), panels = weights[0].shape, len(self.edges)
        lit = np.flatnonzero(np.any(weights, axis=0))
        x, y, z = directions.reshape(-1, 3)[lit].T
        # by row, and in a row by panel
        cell = lit // size * panels + self._panel(x * x + y * y)
        order = np.argsort(cell, kind="stable")
        x, y, z = x[order], y[order], z[order]
        sin2, cos2, panel = x * x + y * y, z * z, cell[order] % panels
        bases = [self._basis(p, sin2[panel == p], cos2[panel == p], dtype) for p in range(panels)]
        counts = np.bincount(cell, minlength=count * panels).reshape(count, panels)
        ends, columns = np.cumsum(counts).reshape(counts.shape), np.cumsum(counts, axis=0)
        # travel of the walker, which starts along -x: the cosine of the azimuth by which the interface turned it
        across = np.sqrt(sin2)
        cos_turn = np.where(across > 0.0, -x / np.maximum(across, 1e-300), 1.0)
        weights = [w.ravel()[lit[order]].astype(dtype, copy=False) for w in weights]
        moments = [np.zeros((len(weights), modes, count, len(basis))) for basis in bases]
        # turns of few rays take as long as those of many: rows share them
        shared = np.flatnonzero(np.diff(ends[:, -1] // _RAYS)) + 1
        for together in np.split(np.arange(count), shared):
            start = ends[together[0], 0] - counts[together[0], 0]
            turns = chebyshev(cos_turn[start : ends[together[-1], -1]], modes).astype(dtype, copy=False)
            for i in together:
                for p in np.flatnonzero(counts[i]):
                    here = slice(ends[i, p] - counts[i, p], ends[i, p])
                    basis = bases[p][:, columns[i, p] - counts[i, p] : columns[i, p]]
                    turn = turns[:, here.start - start : here.stop - start]
                    for moment, weight in zip(moments[p], weights):
                        moment[:, i] = (turn * weight[here]) @ basis.T if modes < len(basis) else turn @ (basis * weight[here]).T
        rows = np.concatenate([moment @ to_nodes(moment.shape[-1]) for moment in moments], axis=-1)
        return list(rows)

    def _panel(self, sin2: np.ndarray) -> np.ndarray:
        """(P,) number of the panel of directions whose squared sine is this."""
        return np.searchsorted(np.square(self.edges[:-1]), self.edges[-1] ** 2 * sin2, side="right")

    def _basis(self, p: int, sin2: np.ndarray, cos2: np.ndarray, dtype: type = np.float64) -> np.ndarray:
        """(nodes of panel p, P) Legendre polynomials at directions on it, in this precision."""
        (a, b, nodes, _), n = self._panels[p], self.edges[-1]
        rise = np.sqrt(np.maximum(n * n * sin2 - a * a, 0.0))
        fall = np.sqrt(np.maximum(b * b - n * n + n * n * cos2, 0.0))
        return legendre((4.0 / np.pi * np.arctan2(rise, fall) - 1.0).astype(dtype, copy=False), len(nodes))


def _psi(x: np.ndarray) -> np.ndarray:
    return 0.25 * np.pi * (x + 1.0)


@lru_cache(maxsize=128)
def to_nodes(count: int) -> np.ndarray:
    """(count, count), not to be written to: from values of the Legendre polynomials at a point to weights of Gauss nodes."""
    # coefficient k of the interpolant is (k + 1/2) sum_j w_j P_k(x_j) g_j
    nodes, gauss = gauss_legendre(count)
    return legendre(nodes, count) * gauss * (np.arange(count) + 0.5)[:, None]


def legendre(x: np.ndarray, count: int) -> np.ndarray:
    """(count, ...) Legendre polynomials P_0 to P_(count-1) at x (...); twice as fast as numpy's."""
    result, spare = _two(x, count), np.empty_like(x)
    for k in range(2, count):
        np.multiply(x, result[k - 1], out=result[k])
        result[k] *= (2.0 * k - 1.0) / k
        result[k] -= np.multiply(result[k - 2], (k - 1.0) / k, out=spare)
    return result


def chebyshev(x: np.ndarray, count: int) -> np.ndarray:
    """(count, ...) cos(m acos(x)) for m = 0 to count-1 at x (...)."""
    result, twice = _two(x, count), 2.0 * x
    for k in range(2, count):
        np.multiply(twice, result[k - 1], out=result[k])
        result[k] -= result[k - 2]
    return result


def _two(x: np.ndarray, count: int) -> np.ndarray:
    """(count, ...) of which the first two are 1 and x (...)."""
    result = np.empty((count, *x.shape), x.dtype)
    result[0] = 1.0
    result[1:2] = x
    return result


def chebyshev_moments(f: np.ndarray, x: np.ndarray, count: int) -> np.ndarray:
    """(curves, count, P) sums of f (curves, P, T) times cos(m acos(x)) over the points x (P, T).

    cos(a + b) = 2 cos(a) cos(b) - cos(a - b): products of few cosines are as good as the cosines of all modes.
    """
    low = chebyshev(x, min(_BLOCK + 1, max(count, 2)))
    if count <= _BLOCK:
        return np.einsum("cpt,mpt->cmp", f, low[:count])
    high = chebyshev(low[_BLOCK], -(-count // _BLOCK))
    # (curves, P, blocks, T) @ (P, T, block)
    both = np.swapaxes(f[:, None] * high, 1, 2) @ low[:_BLOCK].transpose(1, 2, 0)
    result = np.empty((len(f), len(high) * _BLOCK, len(x)))
    for j in range(len(high)):
        start = j * _BLOCK
        own = result[:, start : start + _BLOCK]
        own[:] = np.swapaxes(both[:, :, j], -1, 1)
        if j:
            own[:, 1:] *= 2.0
            own[:, 1:] -= result[:, start - 1 : start - _BLOCK : -1]
    return result[:, :count]
