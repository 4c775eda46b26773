# SPDX-License-Identifier: GPL-3.0-or-later
"""LayeredBxDF of Pharr23 (section 14.3): a stochastic f, one random walk between two interfaces with a medium between them.

What it does: light enters through the top by one sampled refraction of the view and leaves by one of the light's direction; between them a walk turns
by the phase function or off either interface. After each event it is joined to the sampled exit (next event), and its own new direction
to the exit's f, both weighted by the power heuristic (Veach95). Facets are met once, paths end after `depth` events, by roulette from the fourth on.

How a stack is read: its lowest layer lies over the base, and each one above lies over that result, as his template nests. He has one
extinction for all channels; channels that differ in it walk apart here. Of the exit he asks the density of the light's direction given
the inner one, which is not what was sampled, so that his weights do not add up to 1 under rough interfaces; here they do. What
nests is weighted as if it were sampled by the cosine.

It is no model of the registry: charts compare with it (`lamina chart peers`).
"""

from dataclasses import dataclass, fields, replace

import numpy as np

from ...material.stack import Stack
from ...optics import microsurface
from ...optics.directions import components, vectors
from ...optics.frame import dot
from ...optics.interface import Interface
from ...optics.optical_stack import OpticalStack
from ...optics.sampling import sample_visible_normals
from ..position_free.media import ScatteringMedium
from ..position_free.walk_surfaces import Surfaces

DEPTH = 10
"""His `maxdepth`."""
_ROULETTE_FROM, _ROULETTE_BELOW = 3, 0.25


class LayeredBxdf:
    """Stochastic f and albedo with their standard errors: `walks` for each figure, of at most `depth` events. Raises LaminaError for a stack of patches."""

    name = "layered_bxdf"

    def __init__(self, stack: Stack, walks: int = 2, depth: int = DEPTH, seed: int = 0):
        optics = OpticalStack.of(stack)
        self.walks, self.seed, self.channels = walks, seed, optics.channels
        surfaces = Surfaces(optics, "single")
        depths = np.reshape([layer.tau for layer in optics.interfaces], (-1, optics.channels))
        _, group = np.unique(depths, axis=1, return_inverse=True)
        groups = [np.flatnonzero(np.ravel(group) == g) for g in range(np.max(group) + 1)]
        self._parts = [(members, _nested(optics, surfaces, members, depth)) for members in groups]

    def f_stderr(self, wo: np.ndarray, wi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """f (n, channels) in 1/sr of directions (n, 3) above the surface, and its standard error."""
        start, end = self._repeated(wo), self._repeated(wi)
        return self._figures(lambda part, rng: part.cosine_f(start, end, rng) / end[:, 2:])

    def albedo_stderr(self, wo: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Directional albedo (n, channels), mirror-like parts included, and its standard error."""
        start = self._repeated(wo)
        return self._figures(lambda part, rng: part.sample(start, rng).weight)

    def _repeated(self, w) -> np.ndarray:
        return np.asfortranarray(np.repeat(np.asarray(w, float), self.walks, axis=0))

    def _figures(self, estimate) -> tuple[np.ndarray, np.ndarray]:
        rng, columns = np.random.default_rng(self.seed), {}
        for members, part in self._parts:
            columns |= dict(zip(members.tolist(), estimate(part, rng).T))
        values = np.stack([columns[c] for c in range(self.channels)], axis=-1).reshape(-1, self.walks, self.channels)
        return values.mean(axis=1), values.std(axis=1, ddof=1) / np.sqrt(self.walks)


@dataclass(frozen=True, eq=False, repr=False)
class _Sample:
    """Directions (n, 3) off a surface, their energy (n, channels), and whether mirrors alone had a part in them (n,)."""

    direction: np.ndarray
    weight: np.ndarray
    is_delta: np.ndarray


@dataclass(frozen=True, eq=False, repr=False)
class _Exit:
    """A light's directions wi (n, 3), those below the top that were sampled to them, u (n, 3), their energy and their density (n,)."""

    wi: np.ndarray
    u: np.ndarray
    energy: np.ndarray
    density: np.ndarray


@dataclass(frozen=True, eq=False, repr=False)
class _Rays:
    """Walks between two interfaces: row of the result, travel, throughput (n, channels), depth from 0 to 1, and as in `_Sample`."""

    path: np.ndarray
    d: np.ndarray
    beta: np.ndarray
    depth: np.ndarray
    is_delta: np.ndarray

    def at(self, keep: np.ndarray) -> "_Rays":
        return _Rays(*(getattr(self, field.name)[keep] for field in fields(self)))

    @staticmethod
    def joined(parts: "list[_Rays]") -> "_Rays":
        return _Rays(*(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(_Rays)))


def _nested(optics: OpticalStack, surfaces: Surfaces, members: np.ndarray, depth: int):
    below = _Base(surfaces.all[-1], members)
    for layer, medium in zip(reversed(optics.interfaces), reversed(surfaces.media)):
        below = _Layered(_Top(layer), layer, medium, members, below, depth)
    return below


class _Base:
    """An opaque base, as the walks of `position_free` meet it; w (n, 3) points to where light came from."""

    def __init__(self, surface, members: np.ndarray):
        self._surface, self._members, self.is_delta = surface, members, surface.is_delta

    def sample(self, w, rng) -> _Sample:
        event = self._surface.scatter(w, False, rng)
        weight = np.where(event.direction[:, 2:] > 0.0, event.weight, 0.0)
        return _Sample(event.direction, weight[:, self._members], np.full(len(w), self.is_delta))

    def cosine_f(self, w, target, rng) -> np.ndarray:
        return self._surface.scatter(w, False, rng, target).toward[:, self._members]

    def density(self, w, o) -> np.ndarray:
        return self._surface.density(w, o, False)


class _Top:
    """A dielectric interface in the frame of `optics.microsurface`: w and o (n, 3) leave it, w_z > 0 whichever side that is."""

    def __init__(self, layer: Interface):
        self._layer, self._is_clear = layer, layer.eta == 1.0
        self.is_delta = layer.facets.is_specular or self._is_clear

    def _eta(self, from_below: bool) -> float:
        return 1.0 / self._layer.eta if from_below else self._layer.eta

    def bend(self, w, from_below, rng, reflects: bool | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Directions and their energy (n,): all reflected or all let pass, weighted by Fresnel's share; or one of them by chance."""
        eta = self._eta(from_below)
        if self.is_delta:
            wm = np.asfortranarray(np.tile([0.0, 0.0, 1.0], (len(w), 1)))
        else:
            wm = sample_visible_normals(w, self._layer.alpha, self._layer.distribution, rng)
        cos = dot(w, wm)
        share, cos_t = (np.zeros(len(w)), cos) if self._is_clear else microsurface.fresnel_and_refraction(cos, eta)
        if reflects is None:
            reflected, energy = rng.random(len(w)) < share, np.ones(len(w))
        else:
            reflected, energy = np.full(len(w), reflects), share if reflects else 1.0 - share
        along, normal = np.where(reflected, -1.0, -1.0 / eta), np.where(reflected, 2.0 * cos, cos / eta - cos_t)
        o = vectors(*(along * a + normal * m for a, m in zip(components(w), components(wm))))
        energy = energy if self.is_delta else energy * microsurface.masking(o, self._layer.alpha, self._layer.distribution)
        return o, np.where((o[:, 2] > 0.0) == reflected, energy, 0.0)

    def density(self, w, o, from_below) -> np.ndarray:
        """Density (n,) in 1/sr of o, all on one side, Fresnel's chance of that side counted."""
        return microsurface.scattering_density(w, o, self._eta(from_below), self._layer.alpha, self._layer.distribution)

    def cosine_f(self, w, o, from_below) -> np.ndarray:
        """BSDF times cosine (n,) towards o."""
        return self.density(w, o, from_below) * microsurface.masking(o, self._layer.alpha, self._layer.distribution)


class _Layered:
    """One interface and its medium over what reflects below them, as a surface like `_Base`."""

    def __init__(self, top: _Top, layer: Interface, medium: ScatteringMedium | None, members: np.ndarray, below, depth: int):
        self._top, self._below, self._depth, self._count = top, below, depth, len(members)
        self._tau, self._n2 = float(layer.tau[members[0]]), layer.eta**2
        self._medium = medium if medium and np.any(layer.tau[members] * medium.albedo[members] > 0.0) else None
        self._albedo = self._medium.albedo[members] if self._medium else None
        self.is_delta = top.is_delta and self._medium is None and below.is_delta

    def density(self, w, o) -> np.ndarray:
        return np.maximum(o[:, 2], 0.0) / np.pi

    def sample(self, w, rng) -> _Sample:
        """Walks until they leave, or `depth` events are over."""
        o, energy = self._top.bend(w, False, rng)
        goes_in = o[:, 2] < 0.0
        weight = np.tile(np.where(goes_in, 0.0, energy)[:, None], self._count)
        result = _Sample(np.asfortranarray(np.where(goes_in[:, None], [0.0, 0.0, 1.0], o)), weight, np.full(len(w), self._top.is_delta))
        self._walk(self._entering(o, np.where(goes_in, energy, 0.0)), rng, exits=result)
        return result

    def cosine_f(self, w, target, rng) -> np.ndarray:
        """One estimate (n, channels) of f times cosine towards the target."""
        total = np.zeros((len(w), self._count))
        if not self._top.is_delta:
            total += self._top.cosine_f(w, target, False)[:, None]
        below, passed = self._top.bend(target, False, rng, reflects=False)
        below = np.asfortranarray(np.where(passed[:, None] > 0.0, below, [0.0, 0.0, -1.0]))
        density = np.full(len(w), np.inf) if self._top.is_delta else self._top.density(target, below, False)
        # f_t(a, b) / n_b^2 = f_t(b, a) / n_a^2 (Walter07); what is met below is asked for times its cosine
        light = _Exit(target, -below, passed * target[:, 2] / (self._n2 * -below[:, 2]), density)
        o, energy = self._top.bend(w, False, rng, reflects=False)
        self._walk(self._entering(o, np.where(passed > 0.0, energy, 0.0)), rng, light, total)
        return total

    def _entering(self, o, energy) -> _Rays:
        alive = np.flatnonzero(energy > 0.0)
        beta = np.tile(energy[alive, None], self._count)
        return _Rays(alive, o[alive], beta, np.zeros(len(alive)), np.full(len(alive), self._top.is_delta))

    def _walk(self, rays: _Rays, rng, light: _Exit | None = None, total=None, exits: _Sample | None = None) -> None:
        """Follow rays from the top: what reaches a light is added to `total` (n, channels), or else what leaves is put into `exits`."""
        for event in range(self._depth):
            if event > _ROULETTE_FROM:
                rays = _survivors(rays, rng)
            if not len(rays.path):
                return
            rays, inside = self._fly(rays, rng)
            at_top = ~inside & (rays.depth == 0.0)
            meet = ((inside, self._scatter), (at_top, self._turn_back), (~inside & ~at_top, self._reflect))
            rays = _Rays.joined([step(rays.at(np.flatnonzero(some)), rng, light, total, exits) for some, step in meet if np.any(some)])

    def _fly(self, rays: _Rays, rng) -> tuple[_Rays, np.ndarray]:
        """The rays at their next event, and whether that is one of the medium's."""
        z = rays.d[:, 2]
        if self._medium is None:
            passed = np.exp(-self._tau / np.maximum(np.abs(z), 1e-12))
            return replace(rays, beta=rays.beta * passed[:, None], depth=np.where(z < 0.0, 1.0, 0.0)), np.zeros(len(z), bool)
        depth = rays.depth - z * rng.standard_exponential(len(z)) / self._tau
        return replace(rays, depth=np.clip(depth, 0.0, 1.0)), (depth > 0.0) & (depth < 1.0)

    def _scatter(self, rays: _Rays, rng, light, total, exits) -> _Rays:
        rays = replace(rays, beta=rays.beta * self._albedo)
        if light is not None:
            phase = self._medium.toward(rays.d, light.u[rays.path])
            self._join(rays, light, total, phase[:, None], phase)
        d, cos = self._medium.turn(np.asfortranarray(rays.d), rng)
        rays = replace(rays, d=d, is_delta=np.zeros(len(d), bool))
        if light is not None:
            self._reach(rays, light, total, self._medium.phase(cos))
        return rays

    def _turn_back(self, rays: _Rays, rng, light, total, exits) -> _Rays:
        """The top from below, in whose frame a rising ray came from where it goes to."""
        o, energy = self._top.bend(np.asfortranarray(rays.d), True, rng, reflects=None if light is None else True)
        rays = replace(rays, beta=rays.beta * energy[:, None], d=-o, is_delta=rays.is_delta & self._top.is_delta)
        if exits is not None:
            out = rays.at(np.flatnonzero((o[:, 2] < 0.0) & (energy > 0.0)))
            exits.direction[out.path], exits.weight[out.path], exits.is_delta[out.path] = out.d, out.beta, out.is_delta
        return rays.at(np.flatnonzero((o[:, 2] > 0.0) & (energy > 0.0)))

    def _reflect(self, rays: _Rays, rng, light, total, exits) -> _Rays:
        w = np.asfortranarray(-rays.d)
        if light is not None and not self._below.is_delta:
            u = np.asfortranarray(light.u[rays.path])
            self._join(rays, light, total, self._below.cosine_f(w, u, rng), self._below.density(w, u))
        off = self._below.sample(w, rng)
        rays = replace(rays, beta=rays.beta * off.weight, d=off.direction, is_delta=rays.is_delta & off.is_delta)
        if light is not None:
            # what mirrors alone sent is found in no other way
            self._reach(rays, light, total, np.where(off.is_delta, np.inf, self._below.density(w, off.direction)))
        return rays.at(np.flatnonzero((rays.d[:, 2] > 0.0) & np.any(rays.beta > 0.0, axis=1)))

    def _join(self, rays: _Rays, light: _Exit, total, value, density) -> None:
        """Next event: the sampled exit, to which an event sends `value` (n, channels) and its own samples with a density (n,)."""
        u_z, path = light.u[rays.path, 2], rays.path
        passed = np.exp(-self._tau * rays.depth / u_z) * light.energy[path] * _power(light.density[path], density)
        total[path] += rays.beta * value * passed[:, None]

    def _reach(self, rays: _Rays, light: _Exit, total, density) -> None:
        """Rays that rise by samples of a density (n,), and what the top's f lets come to the light."""
        if self._top.is_delta:
            return
        rows = np.flatnonzero((rays.d[:, 2] > 0.0) & np.any(rays.beta > 0.0, axis=1))
        if not len(rows):
            return
        rising, density = rays.at(rows), density[rows]
        d, wi = np.asfortranarray(rising.d), np.asfortranarray(light.wi[rising.path])
        passed = np.exp(-self._tau * rising.depth / d[:, 2]) * _power(density, self._top.density(wi, -d, False))
        total[rising.path] += rising.beta * (self._top.cosine_f(d, -wi, True) * passed)[:, None]


def _survivors(rays: _Rays, rng) -> _Rays:
    brightest = np.max(rays.beta, axis=1, initial=0.0)
    chance = np.where(brightest < _ROULETTE_BELOW, brightest, 1.0)
    alive = rng.random(len(chance)) < chance
    return replace(rays, beta=rays.beta / np.maximum(chance, 1e-300)[:, None]).at(np.flatnonzero(alive))


def _power(own, other) -> np.ndarray:
    """The power heuristic's weight (n,) of a technique of density `own`; infinite densities are those of mirrors."""
    return 1.0 / (1.0 + np.square(other / np.maximum(own, 1e-300)))
