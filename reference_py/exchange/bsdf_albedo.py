# SPDX-License-Identifier: GPL-3.0-or-later
"""Albedos of a tree of MaterialX's BSDFs, as its own shaders put it together.

A layer scales what is below it by one less its own albedo, a mix and a sum are linear, a factor scales the light that comes
back. Every leaf sees the view as it is in air. Films are left out; sheen is that of Estevez and Kulla 2017.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..models.baselines.parts import COS_82, conductor
from ..optics.diffuse import oren_nayar_albedo
from ..optics.frame import dot, half_vector, spherical
from ..optics.quadrature import cosine_directions, points
from .appearance import dielectric_albedo, lobe_albedo, sheen_albedo
from .bsdf_tree import BURLEY, CONDUCTOR, DIELECTRIC, OREN_NAYAR, SCHLICK, SHEEN, SUBSURFACE, Added, Layered, Leaf, Mixed, Scaled, Tree
from .matching import COSINES
from .slots import sigma_of_fujii

_WO = spherical(np.arccos(COSINES), 0.0)
_POINTS = 1024
_LEAST_IOR = 0.2


@dataclass(frozen=True, eq=False, repr=False)
class Light:
    """`back` (views, 3) comes back, `through` (views, 3) goes on to what is below; `lost`, by leaf, is what no stack sends back."""

    back: np.ndarray
    through: np.ndarray
    lost: dict[str, np.ndarray]


def light_of(tree: Tree) -> Light:
    """Of a complete tree."""
    if isinstance(tree, Leaf):
        return _leaf(tree)
    if isinstance(tree, Layered):
        top, base = light_of(tree.top), light_of(tree.base)
        return Light(top.back + top.through * base.back, top.through * base.through, _sum(top.lost, _times(base.lost, top.through)))
    if isinstance(tree, Scaled):
        inner, color = light_of(tree.bsdf), np.array(tree.color)
        return Light(inner.back * color, inner.through, _times(inner.lost, color))
    first, second = light_of(tree.first), light_of(tree.second)
    if isinstance(tree, Mixed):
        a, b = 1.0 - tree.share, tree.share
        return Light(a * first.back + b * second.back, a * first.through + b * second.through, _sum(_times(first.lost, a), _times(second.lost, b)))
    assert isinstance(tree, Added)
    return Light(first.back + second.back, np.maximum(first.through + second.through - 1.0, 0.0), _sum(first.lost, second.lost))


def _sum(first: dict, second: dict) -> dict:
    return {name: first.get(name, 0.0) + second.get(name, 0.0) for name in {**first, **second}}


def _times(lost: dict, factor) -> dict:
    return {name: light * factor for name, light in lost.items()}


def _leaf(leaf: Leaf) -> Light:
    v, black, whole = leaf.values, np.zeros((len(COSINES), 3)), np.ones((len(COSINES), 3))
    weight = v["weight"]
    if leaf.kind == DIELECTRIC:
        reflected = dielectric_albedo(max(v["ior"], _LEAST_IOR), leaf.alpha**0.5) * whole
        through = weight * (1.0 - reflected) * np.array(v["tint"])
        back = weight * reflected * np.array(v["tint"]) if "R" in leaf.mode else black
        return Light(back, 1.0 - weight * reflected if leaf.mode == "R" else black, {} if leaf.mode == "R" else {leaf.name: through})
    if leaf.kind in (CONDUCTOR, SCHLICK):
        reflected = weight * specular_albedo(leaf) * whole
        # one number goes on, so that what is below keeps its color
        return Light(reflected, black if leaf.kind == CONDUCTOR else 1.0 - np.mean(reflected, axis=1, keepdims=True) * whole, {})
    if leaf.kind in (OREN_NAYAR, BURLEY, SUBSURFACE):
        return Light(weight * _diffuse(leaf), (1.0 - weight) * whole, {})
    if leaf.kind == SHEEN:
        cover = weight * sheen_albedo(max(v["roughness"], 0.07))
        return Light(black, (1.0 - cover) * whole, {leaf.name: cover * np.array(v["color"])})
    return Light(black, (1.0 - weight) * whole, {leaf.name: weight * whole * np.array(v["color"])})


def specular_albedo(leaf: Leaf) -> np.ndarray:
    """Albedo (views, 3) of a conductor or a curve of Schlick's, at a weight of 1."""
    v = leaf.values
    if leaf.kind == CONDUCTOR:
        return _conductor(v["ior"], v["extinction"], leaf.alpha**0.5)
    return _schlick(v["color0"], v["color82"], v["color90"], v["exponent"], leaf.alpha**0.5)


@lru_cache(maxsize=64)
def _conductor(ior: tuple, extinction: tuple, roughness: float) -> np.ndarray:
    curve = conductor(np.maximum(ior, 1e-3), np.array(extinction))
    return np.minimum(lobe_albedo(curve, curve(np.ones(())), roughness), 1.0)


@lru_cache(maxsize=64)
def _schlick(color0: tuple, color82: tuple, color90: tuple, exponent: float, roughness: float) -> np.ndarray:
    """With the dip that makes it color82 times as much at 82 degrees."""
    f0, f90 = np.array(color0), np.array(color90)
    drop = (f0 + (f90 - f0) * (1.0 - COS_82) ** exponent) * (1.0 - np.array(color82)) / (COS_82 * (1.0 - COS_82) ** 6)

    def curve(cos):
        cos = cos[..., None]
        return np.clip(f0 + (f90 - f0) * (1.0 - cos) ** exponent - drop * cos * (1.0 - cos) ** 6, 0.0, 1.0)

    return np.minimum(lobe_albedo(curve, f0, roughness), 1.0)


def _diffuse(leaf: Leaf) -> np.ndarray:
    color = np.array(leaf.values["color"])
    if leaf.kind == OREN_NAYAR and (sigma := sigma_deg(leaf)):
        return oren_nayar_albedo(COSINES, color, sigma)
    return color * (_burley(leaf.values["roughness"]) if leaf.kind == BURLEY else np.ones((len(COSINES), 1)))


def sigma_deg(leaf: Leaf) -> float:
    """Slope deviation in degrees of a leaf of Oren and Nayar: its roughness is that in radians or, with energy compensation, Fujii's."""
    roughness = leaf.values["roughness"]
    return sigma_of_fujii(roughness) if leaf.values["energy_compensation"] else min(float(np.degrees(roughness)), 90.0)


@lru_cache(maxsize=16)
def _burley(roughness: float) -> np.ndarray:
    """Albedo (views, 1) of white (Burley 2012, "Physically Based Shading at Disney", section 5.3)."""
    wi, result = cosine_directions(*points(_POINTS)), []
    for wo in _WO:
        rise = 2.0 * roughness * np.square(dot(wi, half_vector(wi, wo))) - 0.5
        result.append(np.mean((1.0 + rise * (1.0 - wi[:, 2]) ** 5) * (1.0 + rise * (1.0 - wo[2]) ** 5)))
    return np.array(result)[:, None]
