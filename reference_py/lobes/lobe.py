# SPDX-License-Identifier: GPL-3.0-or-later
"""One weighted closure of a lobe set, as numbers for given views."""

from dataclasses import dataclass

import numpy as np

from ..material.place import Place
from ..material.stack import Base
from ..optics.bases import conductor_index
from ..optics.diffuse import OREN_NAYAR_POWER, oren_nayar_shares
from ..optics.interface import Interface, Microfacets
from ..optics.thin_film import Film


@dataclass(frozen=True, eq=False, repr=False)
class SchlickCurve:
    """Fresnel curve f0 + (f90 - f0) (1 - cos(wi, wh))^5 of a lobe; f0 and f90 are (..., 3)."""

    f0: np.ndarray
    f90: np.ndarray


@dataclass(frozen=True)
class DielectricCurve:
    """The exact Fresnel curve of a dielectric of relative index eta."""

    eta: float


@dataclass(frozen=True)
class ConductorCurve:
    """The exact Fresnel curve of a metal of complex index eta + i k, of each channel."""

    eta: tuple[float, ...]
    k: tuple[float, ...]

    @classmethod
    def of(cls, base: Base) -> "ConductorCurve":
        """That of a bare conductor base."""
        eta, k = conductor_index(base)
        return cls(tuple(map(float, eta)), tuple(map(float, k)))


@dataclass(frozen=True)
class FilmCurve:
    """The reflectance of a dielectric of relative index eta that carries a film; both as seen from vacuum."""

    eta: float
    film: Film


@dataclass(frozen=True, eq=False, repr=False)
class GlossyLobe:
    """A microfacet reflection lobe.

    weight (..., 3); alpha_x along and alpha_y across the plane of incidence; `tilt` turns the lobe's normal
    by that angle in radians towards the viewer; `fresnel` acts on the half vector. With a `frame`, alpha_x is along
    the direction that is this angle in radians from the tangent, and there is no tilt.
    `normal` is the own normal of an element that the lobe is about (`own_normals`), None for the surface's.
    """

    distribution: str
    weight: np.ndarray
    alpha_x: np.ndarray
    alpha_y: np.ndarray
    tilt: np.ndarray = np.float64(0.0)
    fresnel: SchlickCurve | DielectricCurve | ConductorCurve | FilmCurve | None = None
    frame: float | None = None
    normal: Place | None = None


@dataclass(frozen=True, eq=False, repr=False)
class DiffuseLobe:
    """Lambert of albedo `weight` (..., 3), or, where `color` (..., 3) is given, weight times Oren-Nayar of it.

    `power` is that of `optics.diffuse.oren_nayar`, `normal` as in `GlossyLobe`. With a `ramp` (8, 3) light goes as `diffuse_ramp` has it.
    """

    weight: np.ndarray
    color: tuple[float, float, float] | np.ndarray | None = None
    sigma_deg: float = 0.0
    power: int = OREN_NAYAR_POWER
    normal: Place | None = None
    ramp: np.ndarray | None = None


# Color of a lobe that meets one facet alone: what meets more has this share of it.
DARK = 1e-5


def oren_nayar_lobes(weight: np.ndarray, color, sigma_deg: float) -> list[DiffuseLobe]:
    """Weight (..., 3) times Oren-Nayar of a color (3,), as two lobes that are the same in every Blender: a white one, and a
    dark one, which meets one facet alone."""
    white, single = oren_nayar_shares(color, sigma_deg)
    return [DiffuseLobe(weight * white, (1.0,) * 3, sigma_deg), DiffuseLobe(weight * single / DARK, (DARK,) * 3, sigma_deg)]


def top_curve(surface: Interface) -> DielectricCurve | FilmCurve:
    """The exact Fresnel curve of an interface below vacuum."""
    return DielectricCurve(surface.eta) if surface.film is None else FilmCurve(surface.eta, surface.film)


def surface_lobe(facets: Microfacets, weight: np.ndarray, fresnel=None) -> GlossyLobe:
    """The lobe of a surface of these facets: of its alpha, or, where it is anisotropic, of its own widths and frame."""
    widths = facets.anisotropic
    if widths is None:
        return GlossyLobe(facets.distribution, weight, facets.alpha, facets.alpha, fresnel=fresnel)
    return GlossyLobe(facets.distribution, weight, widths.alpha_x, widths.alpha_y, fresnel=fresnel, frame=widths.angle)
