# SPDX-License-Identifier: GPL-3.0-or-later
"""Albedos of a surface as a file describes it, part by part: what a stack can show of it, and what it loses.

Values have OpenPBR's names (`openpbr.DEFAULTS`); a `Rules` says how the surface that they come from puts its parts
together. Layers scale what is below them by one less their own albedo; lobes have the energy of what meets facets
more than once (Turquin 2019). Of OpenPBR the coat darkens, absorbs along the path and roughens as `openpbr_coat` has it.
Limits: films are left out, anisotropy counts by its mean width; sheen is that of Estevez and Kulla 2017, an estimate for other kinds; a dense medium below
the surface counts as diffuse; emission is seen in a soft light of radiance 1.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..models.baselines.energy import mean_fresnel
from ..models.baselines.parts import COS_82, Fresnel, Lobe, conductor, dielectric, dielectric_f0, f82
from ..optics.colour import artist_index
from ..optics.diffuse import oren_nayar_albedo
from ..optics.frame import spherical
from ..optics.fresnel import cos_theta_t, fresnel_dielectric
from ..optics.interface import TINT_FLOOR
from ..optics.microfacet import GGX
from ..optics.quadrature import cosine_directions, directional_albedo, points
from .matching import COSINES, mean
from .slots import MOST_REFLECTANCE, effective_ior, sigma_of_fujii

_WO = spherical(np.arccos(COSINES), 0.0)
_POINTS = 2048
_LEAST_SHEEN_ROUGHNESS = 0.07
TOP, BELOW_COAT, BELOW_SPECULAR = "top", "below coat", "below specular"


@dataclass(frozen=True)
class Rules:
    """How a surface is put together.

    `under_coat`: its specular index is that against air, and counts relative to the coat above it. `physical_coat`: the
    coat's color absorbs along the path, and the coat darkens and roughens. `scales_lobe`: the specular weight scales the
    lobe, not its F0. `gives_edge`: the specular color of a metal is Gulbrandsen's edge tint, not a share of Schlick's curve.
    `fuzz`: where the sheen lies. `thin_subsurface`: share of the subsurface light that a thin wall lets through.
    """

    under_coat: bool = False
    physical_coat: bool = False
    scales_lobe: bool = False
    gives_edge: bool = False
    fuzz: str = TOP
    thin_subsurface: float = 1.0


@dataclass(frozen=True, eq=False, repr=False)
class Appearance:
    """`solid` (views, 3): albedo of the opaque reflecting part. `seen`: the same by the file's opacity.

    `lost`: light (views, 3) that no stack sends back, by the parameter that it is due to.
    """

    solid: np.ndarray
    seen: np.ndarray
    lost: dict[str, np.ndarray]

    @property
    def all_lost(self) -> np.ndarray:
        """The sum of what is lost, (views, 3)."""
        return sum(self.lost.values(), np.zeros_like(self.seen))


def appearance(values: dict, rules: Rules) -> Appearance:
    """Of a complete set of values."""
    v = {k: np.asarray(value, float) for k, value in values.items()}
    weight = float(v["coat_weight"])
    bare, bare_lost = _base(v, rules, False)
    if weight == 0.0:
        solid, lost = bare, bare_lost
    elif rules.physical_coat:
        coat, left = _physical_coat(v, rules)
        coated, coated_lost = _base(v, rules, True)
        solid = weight * (coat + left * coated) + (1.0 - weight) * bare
        lost = {k: weight * left * coated_lost[k] + (1.0 - weight) * light for k, light in bare_lost.items()}
    else:
        coat = weight * dielectric_albedo(float(v["coat_ior"]), float(v["coat_roughness"]))
        left = (1.0 - coat) * (1.0 + weight * (v["coat_color"] - 1.0))
        solid, lost = coat + left * bare, {k: left * light for k, light in bare_lost.items()}
    if rules.fuzz == TOP:
        solid, lost = _fuzzed(v, solid, lost)
    lost["emission_luminance"] = np.broadcast_to(v["emission_luminance"] * v["emission_color"], solid.shape)
    opacity = float(v["geometry_opacity"])
    lost = {k: opacity * light for k, light in lost.items() if np.any(light > 0.0)}
    if opacity < 1.0:
        lost["geometry_opacity"] = np.full(solid.shape, 1.0 - opacity)
    return Appearance(solid, opacity * solid, lost)


def body_color(v: dict) -> np.ndarray:
    """Diffuse color (3,) of values: base and dense subsurface, mixed."""
    share = float(v["subsurface_weight"])
    return (1.0 - share) * v["base_weight"] * np.asarray(v["base_color"]) + share * np.asarray(v["subsurface_color"])


def _base(v: dict, rules: Rules, coated: bool) -> tuple[np.ndarray, dict]:
    """Albedo (views, 3) of what is below the coat, and what it loses."""
    roughness = float(v["specular_roughness"])
    if coated:
        roughness = min(1.0, roughness**4 + 2.0 * float(v["coat_roughness"]) ** 4) ** 0.25
    gloss = dielectric_albedo(specular_index(v, rules), roughness) * (v["specular_weight"] if rules.scales_lobe else 1.0)
    body, share = _body(v)
    lost = {"subsurface_weight": np.zeros_like(body)}
    if v["geometry_thin_walled"] and share:
        through = share * rules.thin_subsurface * v["subsurface_color"]
        lost["subsurface_weight"] = np.broadcast_to(through, body.shape)
        body = body - through
    if rules.fuzz == BELOW_SPECULAR:
        body, lost = _fuzzed(v, body, lost)
    through = float(v["transmission_weight"])
    solid = gloss * v["specular_color"] + (1.0 - gloss) * (1.0 - through) * body
    lost = {k: (1.0 - gloss) * (1.0 - through) * light for k, light in lost.items()}
    lost["transmission_weight"] = (1.0 - gloss) * through * v["transmission_color"]
    metalness = float(v["base_metalness"])
    if metalness > 0.0:
        solid = metalness * metal_albedo(v, rules, roughness) + (1.0 - metalness) * solid
        lost = {k: (1.0 - metalness) * light for k, light in lost.items()}
    return _fuzzed(v, solid, lost) if rules.fuzz == BELOW_COAT else (solid, lost)


def _body(v: dict) -> tuple[np.ndarray, float]:
    """Albedo (views, 3) of base and subsurface, and the share of the latter."""
    share, color = float(v["subsurface_weight"]), v["base_weight"] * v["base_color"]
    sigma = sigma_of_fujii(float(v["base_diffuse_roughness"]))
    diffuse = oren_nayar_albedo(COSINES, np.clip(color, 0.0, 1.0), sigma) if sigma else np.broadcast_to(color, (len(COSINES), 3))
    return (1.0 - share) * diffuse + share * v["subsurface_color"], share


def specular_index(v: dict, rules: Rules) -> float:
    """Index of the specular interface to what is above it, by the weight where that scales F0."""
    eta = float(v["specular_ior"])
    if rules.under_coat:
        eta /= 1.0 + float(v["coat_weight"]) * (max(float(v["coat_ior"]), 1.0) - 1.0)
    return effective_ior(eta, 0.5 if rules.scales_lobe else 0.5 * float(v["specular_weight"]))


def metal_albedo(v: dict, rules: Rules, roughness: float) -> np.ndarray:
    """(views, 3) of the metal that base color and specular color describe."""
    color = np.clip(v["base_weight"] * v["base_color"], 0.0, 1.0)
    if rules.gives_edge:
        return _metal(True, tuple(np.minimum(color, MOST_REFLECTANCE)), tuple(np.clip(v["specular_color"] * v["specular_weight"], 0.0, 1.0)), roughness)
    return float(v["specular_weight"]) * _metal(False, tuple(color), tuple(np.clip(v["specular_color"], 0.0, 1.0)), roughness)


def _fuzzed(v: dict, solid: np.ndarray, lost: dict) -> tuple[np.ndarray, dict]:
    weight = float(v["fuzz_weight"])
    if weight == 0.0:
        return solid, lost
    cover = weight * sheen_albedo(max(float(v["fuzz_roughness"]), _LEAST_SHEEN_ROUGHNESS))
    below = {k: (1.0 - cover) * light for k, light in lost.items()}
    return (1.0 - cover) * solid, {**below, "fuzz_weight": cover * v["fuzz_color"]}


def _physical_coat(v: dict, rules: Rules) -> tuple[np.ndarray, np.ndarray]:
    """Albedo of the coat, and what it leaves of the base below it (`openpbr_coat`), each (views, 3)."""
    eta, roughness = max(float(v["coat_ior"]), 1.0), float(v["coat_roughness"])
    coat = dielectric_albedo(eta, roughness)
    metalness, f0 = float(v["base_metalness"]), dielectric_f0(specular_index(v, rules))
    crossed = np.maximum(v["coat_color"], TINT_FLOOR) ** (0.5 / cos_theta_t(COSINES, eta)[:, None])
    # a metal sends light back as steeply as it came, a diffuse base from everywhere
    absorbed = crossed * (metalness * crossed + (1.0 - metalness) * mean(crossed))
    smooth = fresnel_dielectric(COSINES, eta)[:, None]
    rough = 1.0 - (1.0 - float(mean_fresnel(dielectric(eta))[0])) / eta**2
    specular = min(1.0, float(v["specular_roughness"]) ** 4 + 2.0 * roughness**4) ** 0.25
    inside = smooth + (metalness * specular + (1.0 - metalness) * (1.0 + f0 * (specular - 1.0))) * (rough - smooth)
    diffuse = f0 + (1.0 - f0) * body_color(v)
    below = np.clip(metalness * v["base_weight"] * v["base_color"] + (1.0 - metalness) * diffuse, 0.0, 1.0)
    darkening = (1.0 - inside) / np.maximum(1.0 - below * inside, 1e-12)
    return coat, absorbed * (1.0 - coat) * (1.0 + v["coat_darkening"] * (darkening - 1.0))


@lru_cache(maxsize=256)
def dielectric_albedo(eta: float, roughness: float) -> np.ndarray:
    """Albedo (views, 1) of a reflecting interface."""
    if eta == 1.0:
        return np.zeros((len(COSINES), 1))
    f0 = np.full(1, dielectric_f0(eta))
    return np.minimum(lobe_albedo(dielectric(eta), f0, roughness), 1.0)


@lru_cache(maxsize=256)
def _metal(by_edge: bool, color: tuple, tint: tuple, roughness: float) -> np.ndarray:
    f0, tint = np.array(color), np.array(tint)
    curve = conductor(*artist_index(f0, tint)) if by_edge else f82(f0, tint * (f0 + (1.0 - f0) * (1.0 - COS_82) ** 5))
    return np.minimum(lobe_albedo(curve, f0, roughness), 1.0)


def lobe_albedo(fresnel: Fresnel, f0: np.ndarray, roughness: float) -> np.ndarray:
    """Albedo (views, channels) of a GGX lobe with the energy that single scattering loses; `f0` (channels,) is `fresnel`'s at 0 degrees."""
    single, whole = (_single_scatter(curve, roughness) for curve in (fresnel, lambda cos: np.ones((*cos.shape, 1))))
    return single * (1.0 + f0 * (1.0 - whole) / whole)


def _single_scatter(fresnel, roughness: float) -> np.ndarray:
    lobe = Lobe(roughness**2, GGX, fresnel)
    return directional_albedo(lobe.f, _WO, [lobe.width], _POINTS) + lobe.specular_albedo(COSINES)


@lru_cache(maxsize=64)
def sheen_albedo(roughness: float) -> np.ndarray:
    """Albedo (views, 1): D of Estevez and Kulla 2017, the visibility of Neubelt and Pettineo 2013."""
    wi = cosine_directions(*points(_POINTS))
    result = []
    for wo in _WO:
        wh = wi + wo
        sin_h = np.hypot(wh[:, 0], wh[:, 1]) / np.linalg.norm(wh, axis=1)
        density = (2.0 + 1.0 / roughness) * sin_h ** (1.0 / roughness) / (2.0 * np.pi)
        result.append(np.mean(np.pi * density / (4.0 * (wi[:, 2] + wo[2] - wi[:, 2] * wo[2]))))
    return np.minimum(np.array(result), 1.0)[:, None]
