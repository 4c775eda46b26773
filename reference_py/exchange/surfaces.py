# SPDX-License-Identifier: GPL-3.0-or-later
"""The surfaces of MaterialX files that are read and written: their inputs and defaults, and what each means by OpenPBR's names.

Sources: the node definitions of MaterialX 1.39 and its own graphs of them, but for disney_principled (Burley 2012).
OpenPBR's anisotropy a makes the alphas' ratio 1 - a and keeps the mean of their squares; the others keep their product.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ..optics.diffuse import fujii_roughness
from .appearance import BELOW_COAT, BELOW_SPECULAR, Rules

_WHITE, _BLACK = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)
OPENPBR = {
    "base_weight": 1.0, "base_color": (0.8, 0.8, 0.8), "base_diffuse_roughness": 0.0, "base_metalness": 0.0,
    "specular_weight": 1.0, "specular_color": _WHITE, "specular_roughness": 0.3, "specular_ior": 1.5,
    "specular_roughness_anisotropy": 0.0, "transmission_weight": 0.0, "transmission_color": _WHITE, "transmission_depth": 0.0,
    "transmission_scatter": _BLACK, "transmission_scatter_anisotropy": 0.0, "transmission_dispersion_scale": 0.0,
    "transmission_dispersion_abbe_number": 20.0, "subsurface_weight": 0.0, "subsurface_color": (0.8, 0.8, 0.8), "subsurface_radius": 1.0,
    "subsurface_radius_scale": (1.0, 0.5, 0.25), "subsurface_scatter_anisotropy": 0.0, "fuzz_weight": 0.0, "fuzz_color": _WHITE,
    "fuzz_roughness": 0.5, "coat_weight": 0.0, "coat_color": _WHITE, "coat_roughness": 0.0, "coat_roughness_anisotropy": 0.0,
    "coat_ior": 1.6, "coat_darkening": 1.0, "thin_film_weight": 0.0, "thin_film_thickness": 0.5, "thin_film_ior": 1.4,
    "emission_luminance": 0.0, "emission_color": _WHITE, "geometry_opacity": 1.0, "geometry_thin_walled": 0.0,
}  # fmt: skip
"""Every input of OpenPBR that is a value, with the specification's default; films in micrometres."""
STANDARD = {
    "base": 1.0, "base_color": (0.8, 0.8, 0.8), "diffuse_roughness": 0.0, "metalness": 0.0, "specular": 1.0, "specular_color": _WHITE,
    "specular_roughness": 0.2, "specular_IOR": 1.5, "specular_anisotropy": 0.0, "specular_rotation": 0.0, "transmission": 0.0,
    "transmission_color": _WHITE, "transmission_depth": 0.0, "transmission_scatter": _BLACK, "transmission_scatter_anisotropy": 0.0,
    "transmission_dispersion": 0.0, "transmission_extra_roughness": 0.0, "subsurface": 0.0, "subsurface_color": _WHITE,
    "subsurface_radius": _WHITE, "subsurface_scale": 1.0, "subsurface_anisotropy": 0.0, "sheen": 0.0, "sheen_color": _WHITE,
    "sheen_roughness": 0.3, "coat": 0.0, "coat_color": _WHITE, "coat_roughness": 0.1, "coat_anisotropy": 0.0, "coat_rotation": 0.0,
    "coat_IOR": 1.5, "coat_affect_color": 0.0, "coat_affect_roughness": 0.0, "thin_film_thickness": 0.0, "thin_film_IOR": 1.5,
    "emission": 0.0, "emission_color": _WHITE, "opacity": _WHITE, "thin_walled": 0.0,
}  # fmt: skip
GLTF = {
    "base_color": _WHITE, "metallic": 1.0, "roughness": 1.0, "occlusion": 1.0, "transmission": 0.0, "specular": 1.0, "specular_color": _WHITE,
    "ior": 1.5, "alpha": 1.0, "alpha_mode": 0.0, "alpha_cutoff": 0.5, "iridescence": 0.0, "iridescence_ior": 1.3, "iridescence_thickness": 100.0,
    "sheen_color": _BLACK, "sheen_roughness": 0.0, "clearcoat": 0.0, "clearcoat_roughness": 0.0, "emissive": _BLACK, "emissive_strength": 1.0,
    "thickness": 0.0, "attenuation_distance": 0.0, "attenuation_color": _WHITE, "anisotropy_strength": 0.0, "anisotropy_rotation": 0.0,
    "dispersion": 0.0,
}  # fmt: skip
USD = {
    "diffuseColor": (0.18, 0.18, 0.18), "emissiveColor": _BLACK, "useSpecularWorkflow": 0.0, "specularColor": _BLACK, "metallic": 0.0,
    "roughness": 0.5, "clearcoat": 0.0, "clearcoatRoughness": 0.01, "opacity": 1.0, "opacityMode": 0.0, "opacityThreshold": 0.0, "ior": 1.5,
    "displacement": 0.0, "occlusion": 1.0,
}  # fmt: skip
DISNEY = {
    "baseColor": (0.16, 0.16, 0.16), "metallic": 0.0, "roughness": 0.5, "anisotropic": 0.0, "specular": 0.5, "specularTint": 0.0, "sheen": 0.0,
    "sheenTint": 0.5, "clearcoat": 0.0, "clearcoatGloss": 1.0, "specTrans": 0.0, "ior": 1.5, "subsurface": 0.0, "subsurfaceDistance": _WHITE,
}  # fmt: skip
_UM_PER_NM = 1e-3
# Above this share a colored F0 is a metal's.
_METAL_F0 = 0.25
_DISNEY_F0 = 0.08
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


@dataclass(frozen=True)
class Surface:
    """A node of MaterialX. `names` are its inputs by OpenPBR's name; `to_open` gives all values by OpenPBR's names."""

    node: str
    title: str
    defaults: dict
    rules: Rules
    names: dict
    to_open: Callable[[dict], dict]
    unlimited: frozenset = field(default_factory=frozenset)
    """Inputs from 0 up that no 1 limits."""
    film_unit: float = 1.0
    """nm of a film's thickness of 1."""

    def own(self, name: str) -> str:
        """Its own name of a value of OpenPBR's."""
        return self.names.get(name, name)


def open_roughness(roughness: float, ratio: float) -> float:
    """OpenPBR's roughness of the alphas' ratio whose geometric mean is roughness^2."""
    return roughness * (0.5 * (ratio + 1.0 / ratio)) ** 0.25


def geometric_roughness(roughness: float, ratio: float) -> float:
    """The inverse of `open_roughness`."""
    return roughness / (0.5 * (ratio + 1.0 / ratio)) ** 0.25


def _anisotropic(roughness: float, anisotropy: float) -> tuple[float, float]:
    """OpenPBR's roughness and anisotropy of MaterialX's node roughness_anisotropy."""
    anisotropy = min(anisotropy, 0.98)
    return min(open_roughness(roughness, 1.0 - anisotropy), 1.0), anisotropy


def _of_standard(v: dict) -> dict:
    coat = v["coat"]
    rough = v["specular_roughness"] + coat * v["coat_affect_roughness"] * v["coat_roughness"] * (1.0 - v["specular_roughness"])
    rough, anisotropy = _anisotropic(rough, v["specular_anisotropy"])
    coat_rough, coat_anisotropy = _anisotropic(v["coat_roughness"], v["coat_anisotropy"])
    gamma = 1.0 + coat * v["coat_affect_color"]
    is_metal = v["metalness"] >= 0.5
    same = ("specular_color", "transmission_color", "transmission_depth", "transmission_scatter", "coat_color", "emission_color")
    return {key: v[key] for key in same} | {
        "base_weight": v["base"], "base_color": v["base_color"] if is_metal else tuple(np.power(v["base_color"], gamma)),
        "base_diffuse_roughness": float(fujii_roughness(min(np.degrees(v["diffuse_roughness"]), 90.0))), "base_metalness": v["metalness"],
        "specular_weight": v["specular"], "specular_roughness": rough, "specular_roughness_anisotropy": anisotropy, "specular_ior": v["specular_IOR"],
        "transmission_weight": v["transmission"], "subsurface_weight": v["subsurface"], "subsurface_radius": v["subsurface_scale"],
        "subsurface_radius_scale": v["subsurface_radius"], "subsurface_scatter_anisotropy": v["subsurface_anisotropy"],
        "subsurface_color": tuple(np.power(v["subsurface_color"], gamma)), "fuzz_weight": v["sheen"], "fuzz_color": v["sheen_color"],
        "fuzz_roughness": v["sheen_roughness"], "coat_weight": coat, "coat_roughness": coat_rough, "coat_roughness_anisotropy": coat_anisotropy,
        "coat_ior": v["coat_IOR"], "thin_film_weight": float(v["thin_film_thickness"] > 0.0),
        "thin_film_thickness": _UM_PER_NM * v["thin_film_thickness"], "thin_film_ior": v["thin_film_IOR"], "emission_luminance": v["emission"],
        "geometry_opacity": float(_LUMINANCE @ v["opacity"]), "geometry_thin_walled": v["thin_walled"],
        "specular_rotation": v["specular_rotation"], "coat_rotation": v["coat_rotation"],
    }  # fmt: skip


def _of_gltf(v: dict) -> dict:
    is_metal = v["metallic"] >= 0.5
    alpha = v["roughness"] ** 2
    along = alpha + v["anisotropy_strength"] ** 2 * (1.0 - alpha)
    ratio = max(alpha / along, 0.02) if along > 0.0 else 1.0
    sheen = max(v["sheen_color"])
    opacity = {0.0: 1.0, 1.0: float(v["alpha"] >= v["alpha_cutoff"])}.get(v["alpha_mode"], v["alpha"])
    return {
        "base_color": v["base_color"], "base_metalness": v["metallic"], "specular_weight": 1.0 if is_metal else v["specular"],
        "specular_color": _WHITE if is_metal else v["specular_color"], "specular_roughness": min(open_roughness((alpha * along) ** 0.25, ratio), 1.0),
        "specular_roughness_anisotropy": 1.0 - ratio, "specular_rotation": v["anisotropy_rotation"] / (2.0 * np.pi) % 1.0, "specular_ior": v["ior"],
        "transmission_weight": v["transmission"], "transmission_color": v["base_color"], "fuzz_weight": sheen,
        "fuzz_color": tuple(c / sheen for c in v["sheen_color"]) if sheen else _BLACK, "fuzz_roughness": v["sheen_roughness"] ** 2,
        "coat_weight": v["clearcoat"], "coat_roughness": v["clearcoat_roughness"], "coat_ior": 1.5, "thin_film_weight": v["iridescence"],
        "thin_film_thickness": _UM_PER_NM * v["iridescence_thickness"], "thin_film_ior": v["iridescence_ior"],
        "emission_luminance": v["emissive_strength"] * float(any(v["emissive"])), "emission_color": v["emissive"], "geometry_opacity": opacity,
    }  # fmt: skip


def _of_usd(v: dict) -> dict:
    color, ior, metalness, tint = v["diffuseColor"], v["ior"], v["metallic"], _WHITE
    if v["useSpecularWorkflow"]:
        f0 = max(v["specularColor"])
        metalness = float(f0 > _METAL_F0)
        color = v["specularColor"] if metalness else color
        if not metalness:
            tint = tuple(c / f0 for c in v["specularColor"]) if f0 else _WHITE
            ior = _ior_of_f0(f0)
    is_cut = v["opacityThreshold"] > 0.0
    opacity = float(v["opacity"] >= v["opacityThreshold"]) if is_cut else v["opacity"] if v["opacityMode"] == 1.0 else 1.0
    through = 0.0 if is_cut or v["opacityMode"] == 1.0 else 1.0 - v["opacity"]
    return {
        "base_color": color, "base_metalness": metalness, "specular_color": tint, "specular_ior": ior, "specular_roughness": v["roughness"],
        "coat_weight": v["clearcoat"], "coat_roughness": v["clearcoatRoughness"], "coat_ior": v["ior"], "transmission_weight": through,
        "geometry_opacity": opacity, "emission_luminance": float(any(v["emissiveColor"])), "emission_color": v["emissiveColor"],
    }  # fmt: skip


def _of_disney(v: dict) -> dict:
    color = np.asarray(v["baseColor"], float)
    brightness = float(_LUMINANCE @ color)
    tint = color / brightness if brightness > 0.0 else np.ones(3)
    rough, anisotropy = _anisotropic(v["roughness"], v["anisotropic"])
    is_metal = v["metallic"] >= 0.5
    return {
        "base_color": v["baseColor"], "base_metalness": v["metallic"], "specular_roughness": rough, "specular_roughness_anisotropy": anisotropy,
        "specular_ior": v["ior"] if v["specTrans"] >= 0.5 else _ior_of_f0(_DISNEY_F0 * v["specular"]),
        "specular_color": _WHITE if is_metal else tuple(np.minimum(1.0 + v["specularTint"] * (tint - 1.0), 1.0)),
        "transmission_weight": v["specTrans"], "transmission_color": v["baseColor"], "subsurface_weight": v["subsurface"],
        "subsurface_color": v["baseColor"], "subsurface_radius_scale": v["subsurfaceDistance"], "fuzz_weight": v["sheen"], "fuzz_color": tuple(np.minimum(1.0 + v["sheenTint"] * (tint - 1.0), 1.0)),
        "coat_weight": v["clearcoat"], "coat_ior": 1.5, "coat_roughness": 1.0 - v["clearcoatGloss"],
    }  # fmt: skip


def _ior_of_f0(f0: float) -> float:
    root = min(f0, 0.99) ** 0.5
    return (1.0 + root) / (1.0 - root)


SURFACES = {
    surface.node: surface
    for surface in (
        Surface(
            "open_pbr_surface", "OpenPBR", OPENPBR, Rules(under_coat=True, physical_coat=True, thin_subsurface=0.5), {}, dict,
            frozenset({"specular_weight", "emission_luminance"}), 1e3,
        ),
        Surface(
            "standard_surface", "standard_surface", STANDARD, Rules(scales_lobe=True, gives_edge=True, fuzz=BELOW_SPECULAR),
            {
                "base_weight": "base", "base_diffuse_roughness": "diffuse_roughness", "base_metalness": "metalness", "specular_weight": "specular",
                "specular_ior": "specular_IOR", "specular_roughness_anisotropy": "specular_anisotropy", "transmission_weight": "transmission",
                "transmission_dispersion_scale": "transmission_dispersion", "subsurface_weight": "subsurface", "fuzz_weight": "sheen",
                "fuzz_color": "sheen_color", "fuzz_roughness": "sheen_roughness", "coat_weight": "coat", "coat_roughness_anisotropy": "coat_anisotropy",
                "coat_ior": "coat_IOR", "thin_film_weight": "thin_film_thickness", "thin_film_ior": "thin_film_IOR", "emission_luminance": "emission",
                "geometry_opacity": "opacity", "geometry_thin_walled": "thin_walled",
            },
            _of_standard, frozenset({"emission", "emission_color"}),
        ),
        Surface(
            "gltf_pbr", "glTF PBR", GLTF, Rules(scales_lobe=True, fuzz=BELOW_COAT),
            {
                "base_metalness": "metallic", "specular_weight": "specular", "specular_ior": "ior", "specular_roughness": "roughness",
                "specular_roughness_anisotropy": "anisotropy_strength", "specular_rotation": "anisotropy_rotation", "transmission_weight": "transmission",
                "fuzz_weight": "sheen_color", "fuzz_roughness": "sheen_roughness", "coat_weight": "clearcoat", "coat_roughness": "clearcoat_roughness",
                "coat_ior": "clearcoat", "thin_film_weight": "iridescence", "thin_film_ior": "iridescence_ior",
                "thin_film_thickness": "iridescence_thickness", "emission_luminance": "emissive", "geometry_opacity": "alpha",
            },
            _of_gltf, frozenset({"emissive", "emissive_strength", "specular_color"}),
        ),
        Surface(
            "UsdPreviewSurface", "UsdPreviewSurface", USD, Rules(),
            {
                "base_color": "diffuseColor", "base_metalness": "metallic", "specular_color": "specularColor", "specular_ior": "ior",
                "specular_roughness": "roughness", "coat_weight": "clearcoat", "coat_roughness": "clearcoatRoughness", "coat_ior": "ior",
                "transmission_weight": "opacity", "geometry_opacity": "opacity", "emission_luminance": "emissiveColor",
            },
            _of_usd, frozenset({"emissiveColor", "displacement"}),
        ),
        Surface(
            "disney_principled", "disney_principled", DISNEY, Rules(fuzz=BELOW_SPECULAR),
            {
                "base_color": "baseColor", "base_metalness": "metallic", "specular_ior": "specular", "specular_roughness": "roughness",
                "specular_color": "specularTint", "specular_roughness_anisotropy": "anisotropic", "transmission_weight": "specTrans",
                "subsurface_weight": "subsurface", "subsurface_color": "baseColor", "fuzz_weight": "sheen", "coat_weight": "clearcoat",
                "coat_roughness": "clearcoatGloss", "coat_ior": "clearcoat",
            },
            _of_disney,
        ),
    )
}  # fmt: skip
