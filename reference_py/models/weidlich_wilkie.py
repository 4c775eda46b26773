# SPDX-License-Identifier: GPL-3.0-or-later
"""Weidlich07: "Arbitrarily Layered Micro-Facet Surfaces", eqs. 1 to 8 as printed.

Limits, all inherited from the paper: one bounce per interface (light that an interface turns back is lost),
no solid-angle compression on crossing, so a base lobe loses energy towards grazing views, and no broadening
of a base lobe by a rough coat. `lamina albedo` beside a white base shows it. Energy is gained too: directions
that refract about the half vector also cross by its Fresnel factor, which a grazing view does not raise to 1, so a
diffuse base of .5 under a smooth coat has albedo 1.42 at 89.9 degrees (figures/stress.csv). The density of samples
lacks the same Jacobian (`weidlich_wilkie_sampling`); `weidlich_wilkie_repaired` has it.

option       | default           | meaning
------------ | ----------------- | -------
refraction   | half_vector       | what the "two refraction directions" refract about: half_vector, which all interfaces then share,
             |                   | or macro_normal, the surface's
absorption   | inverse_cosine    | way through a medium: inverse_cosine, as in eq. 6, or inverse_angle, the 1/theta that eq. 3 prints
compensation | interface         | G of eq. 4, which does not say whose: interface is that of the one being left, at (i, o); none is t = T21
distribution | stack             | of facets: stack, as each surface names its own, or blinn, eq. 7
masking      | smith             | smith, consistent with any distribution, or v_cavity, which eq. 1 assumes
oren_nayar   | energy_preserving | model of that base: energy_preserving, or qualitative_1994, which the paper uses

>>> model = make_model("weidlich_wilkie", presets.load("glazed_mug"), refraction="macro_normal")
>>> model.albedo(spherical(0.5, 0.0)).round(3).tolist()
[0.093, 0.224, 0.333]
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..errors import one_of
from ..material.stack import Stack
from ..optics import microfacet
from ..optics.frame import color_axis, dot, half_vector, no_axis, per_direction, sampled
from ..optics.fresnel import fresnel_dielectric
from ..optics.interface import Microfacets
from ..optics.microfacet import is_specular
from ..optics.optical_stack import OpticalStack, supports
from ..optics.quadrature import directional_albedo
from . import weidlich_wilkie_sampling as sampling

# The print's ambiguities, each a named option; the head says what the choices mean.
OPTIONS = {
    "refraction": ("half_vector", "macro_normal"),
    "absorption": ("inverse_cosine", "inverse_angle"),
    "compensation": ("interface", "none"),
    "distribution": ("stack", "blinn"),
    "masking": ("smith", "v_cavity"),
    "oren_nayar": ("energy_preserving", "qualitative_1994"),
}

_NORMAL = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class _Facets:
    """The microfacet statistics of one interface or of a conductor base."""

    alpha: float
    distribution: str
    v_cavity: bool

    def masking(self, wi, wo, wh) -> np.ndarray:
        if self.v_cavity:
            return microfacet.masking_v_cavity(wi[..., 2], wo[..., 2], wh[..., 2], dot(wi, wh))
        # Blinn has no Smith function of its own: Beckmann's of the same alpha is its companion (Walter07)
        distribution = microfacet.BECKMANN if self.distribution == microfacet.BLINN else self.distribution
        return microfacet.masking_g2(wi[..., 2], wo[..., 2], self.alpha, distribution)

    def lobe(self, wi, wo, wh) -> np.ndarray:
        """D G / (4 cos_i cos_o), eq. 1 without Fresnel; 0 for a mirror, which has no finite f."""
        if is_specular(self.alpha):
            return np.zeros(np.broadcast_shapes(wi.shape, wo.shape)[:-1])
        d = microfacet.distribution(wh[..., 2], self.alpha, self.distribution)
        return d * self.masking(wi, wo, wh) / (4.0 * np.maximum(wi[..., 2] * wo[..., 2], 1e-30))


@dataclass(frozen=True, eq=False, repr=False)
class Level:
    """What one component of eq. 2 sees, once refracted through the interfaces above it."""

    wo: np.ndarray
    wi: np.ndarray
    reaches: np.ndarray
    """Bool (...): both directions are above every horizon on the way."""
    throughput: np.ndarray
    """Product (..., 3) of T12 a t of eq. 2; 0 where `reaches` is false."""


@supports("model", bases=None, distributions=None)
class WeidlichWilkie:
    """Weidlich and Wilkie 2007 as printed; its ambiguities are options.

    The colour axis, written (..., 3) below, has `channels` entries: one per wavelength for a stack of `spectral`.

    Raises LaminaError on an unknown option or choice.
    """

    name = "weidlich_wilkie"
    stochastic = False

    def __init__(
        self,
        stack: Stack,
        refraction: str = "half_vector",
        absorption: str = "inverse_cosine",
        compensation: str = "interface",
        distribution: str = "stack",
        masking: str = "smith",
        oren_nayar: str = "energy_preserving",
    ):
        given = (refraction, absorption, compensation, distribution, masking, oren_nayar)
        self.options = {key: one_of(f"model {self.name}", key, value, OPTIONS[key]) for key, value in zip(OPTIONS, given)}
        self.stack = stack
        optics = OpticalStack.of(stack, self)
        self.channels, self.interfaces, self.base = optics.channels, optics.interfaces, optics.base
        self._facets = tuple(self._make_facets(s.facets) for s in self.interfaces)
        self._base_facets = None if self.base.facets is None else self._make_facets(self.base.facets)

    def _make_facets(self, facets: Microfacets) -> _Facets:
        distribution = microfacet.BLINN if self.options["distribution"] == "blinn" else facets.distribution
        return _Facets(facets.alpha, distribution, self.options["masking"] == "v_cavity")

    @per_direction(color_axis)
    def f(self, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
        """BRDF (..., 3) in 1/sr without cosine; mirror-like components have none and count as 0."""
        return sum(self.components(wo, wi))

    def components(self, wo: np.ndarray, wi: np.ndarray) -> list[np.ndarray]:
        """The summands of eq. 2, unrolled: one (..., 3) per interface from the top, the base last."""
        *above, bottom = self.levels(wo, wi)
        parts = []
        for surface, facets, level in zip(self.interfaces, self._facets, above):
            wh = half_vector(level.wi, level.wo)
            cos_h = np.clip(dot(level.wi, wh), 0.0, 1.0)
            reflected = fresnel_dielectric(cos_h, surface.eta) * facets.lobe(level.wi, level.wo, wh)
            parts.append(level.throughput * reflected[..., None])
        return [*parts, bottom.throughput * self._base(bottom.wi, bottom.wo)]

    def levels(self, wo: np.ndarray, wi: np.ndarray) -> Iterator[Level]:
        """The levels from the top interface to the base."""
        wo, wi = np.broadcast_arrays(np.asarray(wo, float), np.asarray(wi, float))
        visible = (wo[..., 2] > 0.0) & (wi[..., 2] > 0.0)
        level = Level(wo, wi, visible, np.where(visible, 1.0, 0.0)[..., None] * np.ones(self.channels))
        yield level
        for surface, facets in zip(self.interfaces, self._facets):
            level = self._cross(surface, facets, level)
            yield level

    def _cross(self, surface, facets, level: Level) -> Level:
        """The level below `surface`."""
        wi, wo = level.wi, level.wo
        wh = half_vector(wi, wo)
        normal = wh if self.options["refraction"] == "half_vector" else np.broadcast_to(_NORMAL, wh.shape)
        eta = surface.eta
        cos_i, cos_o = np.clip(dot(wi, normal), 0.0, 1.0), np.clip(dot(wo, normal), 0.0, 1.0)
        t12 = 1.0 - fresnel_dielectric(cos_i, eta)
        wi_below, wo_below = _refract(wi, normal, cos_i, eta), _refract(wo, normal, cos_o, eta)
        # Fresnel is the same from either side of a refracted path, so T21 needs no second formula
        t21 = 1.0 - fresnel_dielectric(cos_o, eta)
        if self.options["compensation"] == "interface":
            g = facets.masking(wi, wo, wh)
            t21 = (1.0 - g) + t21 * g
        reaches = level.reaches & (wi_below[..., 2] > 0.0) & (wo_below[..., 2] > 0.0)
        factor = np.where(reaches, t12 * t21, 0.0)[..., None] * self._absorption(surface.tau, wi_below, wo_below)
        return Level(wo_below, wi_below, reaches, level.throughput * factor)

    def _absorption(self, tau, wi, wo) -> np.ndarray:
        cos_i, cos_o = np.clip(wi[..., 2], 1e-6, 1.0), np.clip(wo[..., 2], 1e-6, 1.0)
        if self.options["absorption"] == "inverse_angle":
            cos_i, cos_o = np.maximum(np.arccos(cos_i), 1e-6), np.maximum(np.arccos(cos_o), 1e-6)
        return np.exp(-tau * (1.0 / cos_i + 1.0 / cos_o)[..., None])

    def _base(self, wi, wo) -> np.ndarray:
        if self._base_facets is None:
            return self.base.f(wi, wo, qualitative=self.options["oren_nayar"] == "qualitative_1994")
        wh = half_vector(wi, wo)
        return self.base.reflectance(dot(wi, wh)) * self._base_facets.lobe(wi, wo, wh)[..., None]

    @sampled
    def sample(self, wo: np.ndarray, rng: np.random.Generator | int) -> tuple[np.ndarray, np.ndarray]:
        """One light direction (..., 3) per wo and whether it is valid, (...): false where it was culled.

        What culling loses is compensated in f, by t of eq. 4. A component without finite f is never picked.
        """
        return sampling.sample(self, wo, rng)

    @per_direction(no_axis)
    def pdf(self, wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
        """Density (...) in 1/sr that eq. 8 claims for `sample`; it is not the samples' own below an interface."""
        return sampling.pdf(self, wo, wi)

    @property
    def lobes(self) -> tuple[tuple[float, str] | None, ...]:
        """(alpha, distribution) of every component from the top; None for a diffuse base."""
        base = None if self._base_facets is None else (self._base_facets.alpha, self._base_facets.distribution)
        return (*((f.alpha, f.distribution) for f in self._facets), base)

    @per_direction(color_axis)
    def albedo(self, wo: np.ndarray) -> np.ndarray:
        """Directional albedo (..., 3), mirror-like components included."""
        widths = [(distribution, alpha) for alpha, distribution in filter(None, self.lobes)]
        return directional_albedo(self.f, wo, widths) + self.specular_albedo(wo)

    def specular_albedo(self, wo: np.ndarray) -> np.ndarray:
        """Energy (..., 3) of the mirror-like components, which have no finite f: their delta sits at h = n, where D integrates to 1."""
        top_cos, total = wo[..., 2], np.zeros(wo.shape[:-1] + (self.channels,))
        *above, bottom = self.levels(wo, wo * np.array([-1.0, -1.0, 1.0]))
        for surface, facets, level in zip(self.interfaces, self._facets, above):
            if is_specular(facets.alpha):
                fresnel = fresnel_dielectric(level.wo[..., 2], surface.eta)
                total = total + level.throughput * (fresnel * self._delta_energy(level.wo, top_cos, surface.n_above))[..., None]
        if self._base_facets and is_specular(self._base_facets.alpha):
            fresnel = self.base.reflectance(bottom.wo[..., 2])
            total = total + bottom.throughput * fresnel * self._delta_energy(bottom.wo, top_cos, self.base.n_above)[..., None]
        return total

    def _delta_energy(self, wo, top_cos, n_above):
        """What is left of a delta that eq. 1 evaluates inside, integrated over wi outside.

        dwi = 4 cos(h) dh about the shared half vector; n^2 cos_i' / cos_i dwi' about the surface normal.
        """
        if self.options["refraction"] == "half_vector":
            return np.square(top_cos / np.maximum(wo[..., 2], 1e-12))
        return np.full(wo.shape[:-1], n_above**2)


def _refract(w, normal, cos_n, eta):
    """Refract w (leaving the surface) about `normal` into the medium below; the result leaves the next surface.

    Under total reflection the direction grazes; its transmittance is 0 anyway.
    """
    cos_t = np.sqrt(np.maximum(1.0 - (1.0 - np.square(cos_n)) / np.square(eta), 0.0))
    return w / eta + (cos_t - cos_n / eta)[..., None] * normal
