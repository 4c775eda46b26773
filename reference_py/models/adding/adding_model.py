# SPDX-License-Identifier: GPL-3.0-or-later
"""The model `adding`: energies from the azimuthal mean alone, f from a Fourier series in azimuth.

f is split. What the topmost rough surface reflects once or twice, or a medium above that scatters once, seen through smooth interfaces,
is a formula (`direct`, `two_events`); the rest is smoother and comes from the grid, made reciprocal. Doubling the resolution changes albedo by
less than 0.1 % (`tests/reference_py/test_adding.py`). f differs from the walk of `position_free` by 1 % in the median
and 2.5 % at most, beyond four standard errors, relative to f + 2 % of the peak, for alpha >= 0.05; 3.5 % is stated. On
the suite (figures/suite_agreement.csv) it is within that for all stacks. Limit:
where a rough surface below a rough one is narrower than about 2 / modes, the rest of f is blurred or rings, by up to
11 % at alpha = 0.005; energies stay right.

option  | default  | meaning
------- | -------- | -------
surface | multiple | multiple: lossless microsurfaces (Heitz16); single: one event per surface, separable Smith masking,
        |          | what is left over is lost
nodes   | none     | directions from the normal to grazing in the thinnest medium, a whole number from 8 to 512;
        |          | none is 32, for f up to 48 where a lobe is narrow
modes   | none     | azimuthal modes of f, a whole number from 1 to 512; none is 64
draft   | 0        | a whole number from 0 to 1; 1 is f for fits, three to ten times faster, with energies as ever: in the
        |          | worst view of a stack of the suite .4 % of what is reflected lies elsewhere in the median, 6 % at most,
        |          | and 18 % where f itself is blurred (narrow over narrow). It chooses nodes and modes that are not given

>>> model = make_model("adding", presets.load("glazed_mug"), nodes=16)
>>> model.albedo(spherical(0.5, 0.0)).round(3).tolist()
[0.07, 0.131, 0.193]
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from math import ceil

import numpy as np

from ...errors import LaminaError, one_of
from ...material.schema import SCATTERING, THIN_FILM
from ...material.stack import Stack
from ...optics.facet_reflectance import DielectricFacet
from ...optics.frame import color_axis, no_axis, per_direction, sampled
from ...optics.microfacet import is_specular
from ...optics.optical_stack import OpticalStack, supports
from ...optics.quadrature import LobeMixture
from .assembly import TRAPPED_LOSS, Layers, add, empty, round_trips
from .bounces import NARROW_ALPHA
from .depth import operators_by_depth
from .direct import direct_f, specular_reflectance
from .direction_grid import Grid, chebyshev
from .effective_stack import EffectiveStack, base_rows
from .facets import MULTIPLE, SURFACES
from .film_operators import film_operators, film_rows
from .operators import ENERGY, InterfaceOperators, Resolution, transmittance

_NODES, _MODES = 32, 64
# Lobes this wide and wider have an f within the stated error.
_RESOLVED_WIDTH = 0.1
# f: nodes per width of the narrowest lobe that the grid has to carry, and the most that are worth their time.
_NODES_PER_WIDTH, _MOST_NODES = 4.5, 48
# A draft's nodes where none of its lobes wants more, and its modes without and with a narrow surface.
_DRAFT_NODES, _DRAFT_MODES = 24, (24, 48)
# Views with fewer pairs of directions than this in the mean are taken together, so many pairs at once: a processor's cache holds them.
_PAIRS_OF_A_VIEW, _AT_ONCE = 4, 128
# Views of many pairs whose densities are looked up together.
_VIEWS = 64


@dataclass(frozen=True, eq=False, repr=False)
class LayerEnergies:
    """Reflectance and transmittance of the layers without the base, all media included.

    Above is vacuum, below is the last medium of index `n_below`; cosines are those of the side's own medium.
    """

    n_below: float
    grid: Grid
    nodal: dict[str, np.ndarray]

    def above(self, cos_theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Directional (R, T), each (I, 3), for light from above at cosines (I,)."""
        at = self.grid.interpolation(1.0, np.asarray(cos_theta, float))
        return at @ self.nodal["r_up"], at @ self.nodal["t_down"]

    def below(self, cos_theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Directional (R, T), each (I, 3), for light from below at cosines (I,) in the last medium."""
        at = self.grid.interpolation(self.n_below, np.asarray(cos_theta, float))
        return at @ self.nodal["r_down"], at @ self.nodal["t_up"]

    @property
    def diffuse_above(self) -> tuple[np.ndarray, np.ndarray]:
        """(R, T), each (3,), of uniform light from above."""
        return self._mean("r_up", 1.0), self._mean("t_down", 1.0)

    @property
    def diffuse_below(self) -> tuple[np.ndarray, np.ndarray]:
        """(R, T), each (3,), of uniform light from below."""
        return self._mean("r_down", self.n_below), self._mean("t_up", self.n_below)

    def _mean(self, name: str, n: float) -> np.ndarray:
        return self.grid.weights(n) @ self.nodal[name] / (np.pi * n * n)


@supports("model", features=(SCATTERING, THIN_FILM))
class Adding:
    """The truth, deterministic: adding of interface operators, all orders.

    Raises LaminaError on a bad option.
    """

    name = "adding"
    stochastic = False

    def __init__(self, stack: Stack, surface: str = MULTIPLE, nodes: int | None = None, modes: int | None = None, draft: int = 0):
        self.stack, self.surface = stack, one_of(f"model {self.name}", "surface", surface, SURFACES)
        optics = OpticalStack.of(stack, self)
        self.channels, self._effective = optics.channels, EffectiveStack.of(optics)
        self._mixture = LobeMixture.of(optics.rough_surfaces())
        self._width, self._unresolved = self._effective.narrowest_lobe(), nodes is modes is None
        fine = _NODES_PER_WIDTH / max(self._width, _NODES_PER_WIDTH / _MOST_NODES)
        draft = _whole("draft", draft, 0, 1)
        if draft:
            shape_nodes, self._shape = self._draft(fine)
        else:
            shape_nodes, self._shape = max(_NODES, ceil(fine)), _fine(_MODES)
        if modes is not None:
            modes = _whole("modes", modes, 1, 512)
            self._shape = replace(self._shape, modes=modes) if draft else _fine(modes)
        if nodes is not None:
            shape_nodes = _whole("nodes", nodes, 8, 512)
        nodes = _NODES if nodes is None else shape_nodes
        self._grid, self._shape_grid = self._effective.grid(nodes), self._effective.grid(shape_nodes)
        self._depths: dict[tuple[DielectricFacet, ...], tuple[list[InterfaceOperators], Resolution]] = {}

    def _draft(self, fine: float) -> tuple[int, Resolution]:
        """Nodes and resolution of a draft for lobes that want `fine` nodes."""
        if fine > _DRAFT_NODES:
            return ceil(fine), Resolution(_MODES, across=16, along=32, is_draft=True)
        is_narrow = any(alpha < NARROW_ALPHA for alpha in self._effective.rough_alphas())
        return _DRAFT_NODES, Resolution(_DRAFT_MODES[is_narrow], across=16, along=28, is_draft=True)

    @property
    def f_note(self) -> str | None:
        """What somebody who reads f should know, for a stack whose lobes are narrower than the default resolution."""
        if self._width >= _RESOLVED_WIDTH or not self._unresolved:
            return None
        return (
            f"model adding: f is blurred or rings where a lobe is as narrow as {self._width:.2g} in n sin(theta), and this stack has"
            " one; energies are right; for f use position_free, or the options nodes=96 and modes=256, a minute"
        )

    # --- energies ---

    @per_direction(color_axis)
    def albedo(self, wo: np.ndarray) -> np.ndarray:
        """Directional albedo (..., 3) for wo (..., 3) above the surface, mirror-like parts included; 0 below."""
        cos_theta, inverse = np.unique(wo[:, 2], return_inverse=True)
        visible = np.flatnonzero(cos_theta > 0.0)
        result = np.zeros((len(cos_theta), self.channels))
        if len(visible):
            cos_o = np.minimum(cos_theta[visible], 1.0)
            top_rows = cache(partial(self._top_rows, cos_o))  # channels whose facets are alike share them
            for channel, members in self._effective.channels():
                inside = self._turned_out(channel, cos_o, top_rows) * np.exp(-self._effective.tau_above[channel] / cos_o)
                result[np.ix_(visible, members)] = inside[:, None]
        return result[inverse]

    def _turned_out(self, channel: int, cos_o: np.ndarray, top_rows: Callable) -> np.ndarray:
        """Energy (I,) that all below the medium at the top gives back outside for what reaches it from cosines (I,)."""
        effective, grid = self._effective, self._grid
        outside = transmittance(grid, 1.0, effective.tau_above[channel])
        if not effective.interfaces:
            return sum(base_rows(effective.base, channel, cos_o, self.surface, grid, ENERGY))[0] @ outside
        reflected, crossed = top_rows(effective.facets(channel)[0])
        return reflected @ outside + crossed @ self._escape[channel]

    def _top_rows(self, cos_o: np.ndarray, facet: DielectricFacet) -> tuple[np.ndarray, np.ndarray]:
        """(reflected, crossed), each (I, N): what the first interface does to light from cosines (I,)."""
        top = self._effective.interfaces[0]
        setup = (top.alpha, top.distribution, self.surface, self._grid, ENERGY)
        single, multi, crossed = film_rows(facet, self._effective.distinct_facets[0], cos_o, *setup)
        return (single + multi)[0], crossed[0]

    @cached_property
    def _escape(self) -> dict[int, np.ndarray]:
        """By channel: what light going down just below the first interface gives outside, at the grid's directions."""
        escape = {}
        for channel, _ in self._effective.channels():
            below = self._below(0, channel, ENERGY)
            top = self._operators(0, channel, ENERGY)
            outside = top.t_up[0] @ transmittance(self._grid, 1.0, self._effective.tau_above[channel])
            escape[channel] = round_trips(below[0], top.r_down[0], below[0] @ outside)
        return escape

    def specular_albedo(self, cos_theta: np.ndarray) -> np.ndarray:
        """The part (..., 3) of the albedo that is mirror-like and has no f, for view cosines (...)."""
        cos_theta = np.asarray(cos_theta, float)
        return specular_reflectance(self._effective, cos_theta.ravel()).reshape(cos_theta.shape + (self.channels,))

    def layer_energies(self) -> LayerEnergies:
        """Energies of all layers without the base."""
        effective, grid = self._effective, self._grid
        n_below = effective.base.n_above
        nodal = {key: np.zeros((grid.count(n), self.channels)) for key, n in (("r_up", 1.0), ("t_down", 1.0), ("r_down", n_below), ("t_up", n_below))}
        for channel, members in effective.channels():
            whole = self._layers(channel)
            for key, values in nodal.items():
                values[:, members] = getattr(whole, key)[0].sum(axis=-1)[:, None]
        return LayerEnergies(n_below, grid, nodal)

    def _layers(self, channel: int) -> Layers:
        effective, grid = self._effective, self._grid
        whole = empty(grid.count(1.0), 1).over_medium(effective.medium(0, channel, grid, 1))
        for k in range(len(effective.interfaces)):
            whole = add(whole, self._operators(k, channel, ENERGY).over_medium(effective.medium(k + 1, channel, grid, 1)))
        return whole

    def _operators(self, k: int, channel: int, resolution: Resolution) -> InterfaceOperators:
        if resolution is self._shape:
            return self._by_depth(channel)[0][k]
        i = self._effective.interfaces[k]
        return film_operators(i.facet(channel), self._effective.distinct_facets[k], i.alpha, i.distribution, self.surface, self._grid, resolution)

    def _by_depth(self, channel: int) -> tuple[list[InterfaceOperators], Resolution]:
        facets = self._effective.facets(channel)
        if facets not in self._depths:
            self._depths[facets] = operators_by_depth(self._effective, channel, self.surface, self._shape_grid, self._shape)
        return self._depths[facets]

    def _grid_for(self, resolution: Resolution) -> Grid:
        return self._shape_grid if resolution is self._shape else self._grid

    def _below(self, k: int, channel: int, resolution: Resolution) -> np.ndarray:
        """Reflection operator of all that is below interface k, its medium included."""
        return self._reflection(k + 1, channel, resolution)[0]

    def _reflection(self, k: int, channel: int, resolution: Resolution):
        """(whole, mirror-like (N,), direct) reflection of interface k and all below, seen through the medium above it.

        `direct` is the part that `direct_f` knows in closed form.
        """
        effective, grid = self._effective, self._grid_for(resolution)
        if k == len(effective.interfaces):
            base = effective.base
            seen = self._by_depth(channel)[1] if resolution is self._shape else resolution
            single, multi = base_rows(base, channel, grid.cosines(base.n_above), self.surface, grid, seen)
            whole, direct = single + multi, single
            specular = np.diagonal(multi[0]) if base.is_specular else np.zeros(len(single[0]))
        else:
            top = self._operators(k, channel, resolution)
            below, specular_below, direct_below = self._reflection(k + 1, channel, resolution)
            reached, whole = top.cut(len(below)), top.r_up.copy()
            whole[: len(below)] += reached.t_down @ round_trips(below, reached.r_down, below @ reached.t_up)
            if is_specular(effective.interfaces[k].alpha):
                trips = 1.0 / (1.0 - (1.0 - TRAPPED_LOSS) * specular_below * np.diagonal(top.r_down[0]))
                specular = np.diagonal(top.r_up[0] + top.t_down[0] * (trips * specular_below) @ top.t_up[0])
                direct = (reached.t_down * trips) @ direct_below @ (trips[:, None] * reached.t_up)
            else:
                specular, direct = np.zeros(len(whole[0])), top.single
        medium = effective.medium(k, channel, grid, len(whole))
        share = medium.share
        direct = direct * (share[:, None] * share)
        if effective.is_smooth_above(k):
            direct = direct + medium.once(specular)
        return medium.over(whole), specular * share * share, direct

    # --- shape ---

    @per_direction(color_axis)
    def f(self, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
        """BRDF (..., 3) in 1/sr without cosine; mirror-like parts have no f; 0 below the horizon."""
        visible = (wo[:, 2] > 0.0) & (wi[:, 2] > 0.0)
        result = np.zeros((len(wo), self.channels))
        wo, wi = wo[visible], wi[visible]
        if len(wo):
            value = self.direct_f(wo, wi) + self.smooth_f(wo, wi)
            result[visible] = np.maximum(value, 0.0)  # a cut Fourier series may undershoot
        return result

    @sampled
    def sample(self, wo: np.ndarray, rng: np.random.Generator | int) -> tuple[np.ndarray, np.ndarray]:
        """One light direction (..., 3) per wo, of facets of the rough surfaces or of a cosine, and whether it is valid, (...)."""
        return self._mixture.sample(wo, rng)

    @per_direction(no_axis)
    def pdf(self, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
        """Density (...) in 1/sr of `sample`."""
        return self._mixture.pdf(wo, wi)

    def direct_f(self, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
        """The part (n, 3) of f that is in closed form, for directions (n, 3) above the surface."""
        return direct_f(self._effective, self.surface, wo, wi, self._shape_grid, self._shape)

    def smooth_f(self, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
        """The rest (n, 3) of f, from the grid, for directions (n, 3) above the surface; reciprocal, and below 0 where the series undershoots."""
        cos_o, which_o = np.unique(np.minimum(wo[:, 2], 1.0), return_inverse=True)
        cos_i, which_i = np.unique(np.minimum(wi[:, 2], 1.0), return_inverse=True)
        dtype = self._shape.dtype
        at_o, at_i = (self._shape_grid.interpolation(1.0, cosines, dtype) for cosines in (cos_o, cos_i))
        azimuth = wo[:, 0] * wi[:, 0] + wo[:, 1] * wi[:, 1]
        sines = np.hypot(wo[:, 0], wo[:, 1]) * np.hypot(wi[:, 0], wi[:, 1])
        # travel: a mirror, whose wi is opposite in azimuth, turns by 0
        turn = -np.clip(np.where(sines > 1e-12, azimuth / np.maximum(sines, 1e-12), -1.0), -1.0, 1.0)
        # along the normal there is no azimuth: its mean alone counts
        both = np.where(sines > 1e-6, 2.0, 0.0).astype(dtype)
        result = np.zeros((len(wo), self.channels))
        densities = [(members, self._remainder[channel].astype(dtype, copy=False)) for channel, members in self._effective.channels()]
        by_view = len(wo) > _PAIRS_OF_A_VIEW * len(cos_o)
        order = np.argsort(which_o, kind="stable")
        for here in _parts(which_o[order], by_view):
            here = order[here]
            harmonics = chebyshev(turn[here].astype(dtype, copy=False), self._shape.modes)
            harmonics[1:] *= both[here]
            rows, view = at_i[which_i[here]], which_o[here[0]]
            if by_view and view % _VIEWS == 0:
                from_views = [at_o[view : view + _VIEWS] @ density for _, density in densities]
            for i, (members, density) in enumerate(densities):
                if by_view:
                    value = np.einsum("mq,mq->q", from_views[i][:, view % _VIEWS] @ rows.T, harmonics)
                else:
                    value = np.sum(np.einsum("mqn,mq->qn", at_o[which_o[here]] @ density, harmonics) * rows, axis=1)
                result[np.ix_(here, members)] = value[:, None]
        return result

    @cached_property
    def _remainder(self) -> dict[int, np.ndarray]:
        """By channel: modes of f (modes, N, N) at the grid's directions, without mirror-like and direct parts."""
        remainder = {}
        for channel, _ in self._effective.channels():
            whole, specular, direct = self._reflection(0, channel, self._shape)
            density = (whole - np.diag(specular) - direct) / self._shape_grid.weights(1.0)
            remainder[channel] = 0.5 * (density + np.swapaxes(density, -1, -2))
        return remainder


def _fine(modes: int) -> Resolution:
    return Resolution(modes, across=max(24, modes // 2), along=48)


def _parts(views: np.ndarray, by_view: bool) -> list[slice]:
    """Slices of sorted numbers of views that are worth one product each: all pairs of a view, or many views of few pairs."""
    ends = np.cumsum(np.bincount(views)).tolist() if by_view else [*range(_AT_ONCE, len(views), _AT_ONCE), len(views)]
    return [slice(start, end) for start, end in zip([0, *ends], ends)]


def _whole(name: str, value, low: int, high: int) -> int:
    if isinstance(value, str) and value.isascii() and value.isdigit():
        value = int(value)  # as the command line gives it
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not low <= value <= high:
        raise LaminaError(f"model adding: {name} is {value!r}; choose a whole number from {low} to {high}")
    return int(value)
