# SPDX-License-Identifier: GPL-3.0-or-later
"""Model `position_free`: Monte Carlo walks of Guo18 through the whole stack, all orders, nothing approximated.

The first ground truth. Every figure has a standard error; the same seed gives the same figures. Memory does not
grow with the number of walks: they are done in batches.

option  | default  | meaning
------- | -------- | -------
surface | multiple | multiple: lossless microsurfaces (Heitz16); single: what a facet sends to the wrong side is lost
walks   | 65536    | walks per figure, a whole number from 2
seed    | 0        | of the random numbers, a whole number from 0

>>> model = make_model("position_free", presets.load("glazed_mug"), walks=2000, seed=1)
>>> model.albedo(spherical(0.5, 0.0)).round(2).tolist()
[0.07, 0.13, 0.19]
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...errors import LaminaError, one_of
from ...material.schema import ANISOTROPY, SCATTERING, THIN_FILM
from ...material.stack import Stack
from ...optics.frame import color_axis, generator, no_axis, per_direction, sampled
from ...optics.microsurface import SURFACES
from ...optics.optical_stack import OpticalStack, supports
from ...optics.quadrature import LobeMixture
from .walk import Walk, connected_f
from .walk_surfaces import Surfaces

BATCH = 1 << 15
DEFAULT_WALKS = 1 << 16


def _depth_axes(model) -> tuple[int, ...]:
    return len(model._surfaces), model.channels


class Cancelled(Exception):
    """Raised out of a method whose `cancel` returned true; no figures are returned."""


@dataclass(frozen=True, eq=False, repr=False)
class Histogram:
    """Energy (T, P, 3) per bin of wi, and its standard error, for one viewer."""

    energy: np.ndarray
    stderr: np.ndarray
    theta_edges: np.ndarray
    """(T + 1,) polar angle in radians."""
    phi_edges: np.ndarray
    """(P + 1,) azimuth from the viewer's, in radians: the mirror direction is at pi."""

    def f(self) -> tuple[np.ndarray, np.ndarray]:
        """Mean BRDF (T, P, 3) of each bin in 1/sr, mirror-like components included, and its standard error."""
        projected = 0.5 * np.diff(np.square(np.sin(self.theta_edges)))[:, None] * np.diff(self.phi_edges)
        return self.energy / projected[..., None], self.stderr / projected[..., None]


@supports("model", bases=None, features=(ANISOTROPY, THIN_FILM, SCATTERING))
class PositionFree:
    """The truth by Monte Carlo walks, each figure with its standard error.

    Methods take `rng`, a seed or a generator, in place of the model's seed, `progress`, called with the share done, and `cancel`, asked before every
    batch; if it says true they raise Cancelled.
    Raises LaminaError on an unknown option or choice.
    """

    name = "position_free"
    stochastic = True

    def __init__(self, stack: Stack, surface: str = SURFACES[0], walks: int = DEFAULT_WALKS, seed: int = 0):
        self.surface = one_of(f"model {self.name}", "surface", surface, SURFACES)
        self.walks = _whole_number("walks", walks, 2)
        self.seed = _whole_number("seed", seed, 0)
        self.stack = stack
        optics = OpticalStack.of(stack, self)
        self.channels, self._surfaces = optics.channels, Surfaces(optics, surface)
        self._mixture = LobeMixture.of(optics.rough_surfaces())

    def f(self, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
        """BRDF (..., 3) in 1/sr without cosine; mirror-like components have none and count as 0."""
        return self.f_stderr(wo, wi)[0]

    def albedo(self, wo: np.ndarray) -> np.ndarray:
        """Directional albedo (..., 3), mirror-like components included."""
        return self.albedo_stderr(wo)[0]

    @per_direction(color_axis, color_axis)
    def f_stderr(self, wo, wi, *, rng=None, progress=None, cancel=None) -> tuple[np.ndarray, np.ndarray]:
        """`f` and its standard error, both (..., 3)."""
        visible = (wo[..., 2] > 0.0) & (wi[..., 2] > 0.0)
        # f is symmetric. Few microfacets send light to a grazing direction, all take it from there: start with that.
        swap = (wi[..., 2] < wo[..., 2])[..., None]
        start, end = np.where(swap, wi, wo)[visible], np.where(swap, wo, wi)[visible]

        def sample(figure, rng):
            return connected_f(self._surfaces, start[figure], end[figure], rng)

        return self._spread(visible, *self._estimate(sample, len(start), (self.channels,), rng, progress, cancel))

    @sampled
    def sample(self, wo: np.ndarray, rng: np.random.Generator | int) -> tuple[np.ndarray, np.ndarray]:
        """One light direction (..., 3) per wo, of facets of the rough surfaces or of a cosine, and whether it is valid, (...)."""
        return self._mixture.sample(wo, rng)

    @per_direction(no_axis)
    def pdf(self, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
        """Density (...) in 1/sr of `sample`."""
        return self._mixture.pdf(wo, wi)

    @per_direction(color_axis, color_axis)
    def albedo_stderr(self, wo, *, rng=None, progress=None, cancel=None) -> tuple[np.ndarray, np.ndarray]:
        """`albedo` and its standard error, both (..., 3); 0 for viewers below the horizon."""
        visible = wo[..., 2] > 0.0
        wo_visible = wo[visible]

        def sample(figure, rng):
            return self.walked(wo_visible[figure], rng)

        return self._spread(visible, *self._estimate(sample, len(wo_visible), (self.channels,), rng, progress, cancel))

    def walked(self, wo: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """What one walk from each of wo (n, 3), above the surface, makes of its albedo: (n, 3), right in the mean alone."""
        energy = np.zeros((self.channels, len(wo)))
        for rays in Walk(self._surfaces, wo, rng, splits=True).exits():
            for total, throughput in zip(energy, rays.throughput.T):
                total += np.bincount(rays.path, throughput, len(total))
        return energy.T

    @per_direction(_depth_axes, _depth_axes)
    def albedo_by_depth(self, wo, *, rng=None, progress=None, cancel=None) -> tuple[np.ndarray, np.ndarray]:
        """Albedo (..., surfaces, 3) by the deepest surface that light has met, the base last; and its standard error."""
        visible = wo[..., 2] > 0.0
        wo_visible = wo[visible]
        depths = len(self._surfaces)

        def sample(figure, rng):
            walk = Walk(self._surfaces, wo_visible[figure], rng)
            energy = np.zeros((len(figure), depths, self.channels))
            for rays in walk.exits():
                energy[rays.path, walk.deepest[rays.path]] = rays.throughput
            return energy

        return self._spread(visible, *self._estimate(sample, len(wo_visible), (depths, self.channels), rng, progress, cancel))

    def histogram(self, wo, theta_edges, phi_edges, *, deepest: int | None = None, rng=None, progress=None, cancel=None) -> Histogram:
        """Where the energy that meets the stack along -wo, wo (3,), leaves to; edges in radians, ascending.

        `deepest` counts only light whose deepest surface was that one: 0 the top, -1 the base.
        """
        wo = np.asarray(wo, float)
        theta_edges, phi_edges = np.asarray(theta_edges, float), np.asarray(phi_edges, float)
        shape = (len(theta_edges) - 1, len(phi_edges) - 1)
        azimuth = np.arctan2(wo[1], wo[0])
        total, squares = np.zeros((2, shape[0] * shape[1], self.channels))
        for count, batch_rng in self._batches(1, rng, progress, cancel):
            walk = Walk(self._surfaces, np.broadcast_to(wo, (len(count), 3)), batch_rng)
            for rays in walk.exits():
                wi = rays.w
                row = np.searchsorted(theta_edges, np.arccos(np.clip(wi[:, 2], -1.0, 1.0)), side="right") - 1
                turn = np.arctan2(wi[:, 1], wi[:, 0]) - azimuth - phi_edges[0]
                column = np.searchsorted(phi_edges, turn % (2.0 * np.pi) + phi_edges[0], side="right") - 1
                inside = (row >= 0) & (row < shape[0]) & (column >= 0) & (column < shape[1])
                if deepest is not None:
                    inside &= walk.deepest[rays.path] == deepest % len(self._surfaces)
                bins, energy = (row * shape[1] + column)[inside], rays.throughput[inside]
                for channel in range(self.channels):
                    total[:, channel] += np.bincount(bins, energy[:, channel], len(total))
                    squares[:, channel] += np.bincount(bins, np.square(energy[:, channel]), len(total))
        mean, stderr = _mean_and_stderr(total, squares, self.walks)
        return Histogram(mean.reshape(*shape, self.channels), stderr.reshape(*shape, self.channels), theta_edges, phi_edges)

    def _batches(self, figures: int, rng, progress, cancel):
        """Yield (index of the figure per walk, rng) until every figure has its walks."""
        rng = generator(self.seed if rng is None else rng)
        walks = figures * self.walks
        for start in range(0, walks, BATCH):
            if cancel is not None and cancel():
                raise Cancelled
            stop = min(start + BATCH, walks)
            yield np.arange(start, stop) // self.walks, rng
            if progress is not None:
                progress(stop / walks)

    def _estimate(self, sample: Callable, figures: int, shape, rng, progress, cancel):
        """Mean and standard error (figures, *shape) of `sample(figure, rng)`, one row per walk."""
        total, squares = np.zeros((2, figures, *shape))
        for figure, batch_rng in self._batches(figures, rng, progress, cancel):
            values = sample(figure, batch_rng)
            first = np.flatnonzero(np.diff(figure, prepend=-1))
            total[figure[first]] += np.add.reduceat(values, first, axis=0)
            squares[figure[first]] += np.add.reduceat(np.square(values), first, axis=0)
        return _mean_and_stderr(total, squares, self.walks)

    @staticmethod
    def _spread(visible, *figures) -> tuple[np.ndarray, ...]:
        """Figures of visible directions in the caller's shape, 0 elsewhere."""
        out = tuple(np.zeros(visible.shape + values.shape[1:]) for values in figures)
        for spread, values in zip(out, figures):
            spread[visible] = values
        return out


def _mean_and_stderr(total, squares, n) -> tuple[np.ndarray, np.ndarray]:
    mean = total / n
    return mean, np.sqrt(np.maximum(squares / n - np.square(mean), 0.0) / (n - 1))


def _whole_number(name: str, value, minimum: int) -> int:
    try:
        number = int(value)
    except (TypeError, ValueError, OverflowError):
        number = None
    if number is None or isinstance(value, bool) or number < minimum or number != float(value):
        raise LaminaError(f"model {PositionFree.name}: {name} is {value!r}; choose a whole number from {minimum}")
    return number
