# SPDX-License-Identifier: GPL-3.0-or-later
"""A Cycles render of a sphere in the sun against the numpy evaluation of the same lobe set, pixel by pixel."""

import math
from dataclasses import dataclass

import numpy as np

from lamina.addon.rendering.measure import render_sun_sphere
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.optics.microfacet import BECKMANN, smith_lambda
from lamina.reference_py.optics.optical_stack import rough_surfaces

SUN_THETA_DEG = (10.0, 45.0, 75.0)
BRIGHT = 1e-4  # share of the brightest pixel below which a pixel does not count

# Relative error that a render may have at the 99th percentile. Below alpha .005 Cycles' float32 half vector shows:
# measured 1.3e-4 at alpha .002, the car paint's varnish, where only that highlight is looked at.
TOLERANCE = 1e-4
NARROW_TOLERANCE = 2e-4


def tolerance(stack: Stack) -> float:
    alphas = [alpha for _, alpha in rough_surfaces(stack)]
    return NARROW_TOLERANCE if alphas and min(alphas) < 0.005 else TOLERANCE


@dataclass(frozen=True)
class Parity:
    """Relative errors of the pixels that count (n, 3 channels flattened), and whether any pixel was not finite."""

    errors: np.ndarray
    finite: bool

    @property
    def percentile_99(self) -> float:
        return float(np.percentile(self.errors, 99))


def local_directions(normal: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """wi and wo (n, 3) in the local frames of unit normals (n, 3), the view in the plane y = 0."""
    cos_o = normal @ wo
    x = wo - cos_o[:, None] * normal
    length = np.linalg.norm(x, axis=-1, keepdims=True)
    fallback = np.cross(normal, [0.0, 1.0, 0.0])
    x = np.where(length > 1e-9, x / np.maximum(length, 1e-9), fallback / np.linalg.norm(fallback, axis=-1, keepdims=True))
    y = np.cross(normal, x)
    local_wi = np.stack([x @ wi, y @ wi, normal @ wi], axis=-1)
    local_wo = np.stack([x @ wo, y @ wo, cos_o], axis=-1)
    return local_wi, local_wo


def tangent_directions(normal: np.ndarray, wi: np.ndarray, wo: np.ndarray, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """wi and wo (n, 3) in frames whose x is what a Tangent node of radial axis Y gives: around the sphere's poles."""
    around = np.cross([0.0, 1.0, 0.0], position)
    y = np.cross(normal, around)
    y /= np.linalg.norm(y, axis=-1, keepdims=True)
    x = np.cross(y, normal)
    return tuple(np.stack([x @ w, y @ w, normal @ w], axis=-1) for w in (wi, wo))


def tangent_parity(material, f, sun_theta_deg: float, size: int = 96) -> Parity:
    """As `parity`, in frames that know the tangent."""
    return parity(material, f, sun_theta_deg, size, with_tangent=True)


def parity(material, f, sun_theta_deg: float, size: int = 96, window=(0.0, 0.0, 1.0), with_tangent: bool = False, **where) -> Parity:
    """Render `material` and compare with f(wo, wi), per pixel with the pixel's own normal; `where` are the device and whether by OSL."""
    picture = render_sun_sphere(material, sun_theta_deg, size, window=window, **where)
    normal = picture["normal"][picture["mask"]].astype(float)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    if with_tangent:
        wi, wo = tangent_directions(normal, picture["wi"], picture["wo"], picture["position"][picture["mask"]].astype(float))
    else:
        wi, wo = local_directions(normal, picture["wi"], picture["wo"])
    expected = f(wo, wi) * np.maximum(wi[:, 2:], 0.0)
    rendered = picture["radiance"][picture["mask"]].astype(float)
    counts = rendered > BRIGHT * rendered.max()
    errors = np.abs(rendered - expected)[counts] / rendered[counts]
    return Parity(errors, bool(np.isfinite(picture["radiance"]).all()))


def highlight_window(stack: Stack, sun_theta_deg: float) -> tuple[float, float, float] | None:
    """A window of the sphere around the highlight of the narrowest lobe, where the whole sphere would not show it."""
    alphas = [alpha for _, alpha in rough_surfaces(stack)]
    if not alphas or min(alphas) > 0.05:
        return None
    return (float(np.sin(np.radians(sun_theta_deg) / 2.0)), 0.0, max(6.0 * min(alphas), 0.01))


def beckmann_sampling_bias(stack: Stack, cos_o: np.ndarray) -> np.ndarray:
    """Relative error (n,) of an albedo that Cycles estimates by sampling a Beckmann lobe.

    Cycles draws exact visible normals but states their density with the rational Lambda, so the mean of
    value / density is off by (1 + rational) / (1 + exact): up to .1 % at 75 degrees for alpha .16.
    """
    tan = np.sqrt(1.0 - cos_o**2) / cos_o
    bias = np.zeros(len(cos_o))
    for kind, alpha in rough_surfaces(stack):
        if kind == BECKMANN:
            a = 1.0 / np.maximum(alpha * tan, 1e-9)
            exact = np.array([0.5 * (math.exp(-v * v) / (v * math.sqrt(math.pi)) - math.erfc(v)) for v in np.minimum(a, 20.0)])
            bias = np.maximum(bias, np.abs(smith_lambda(cos_o, alpha, kind) - exact) / (1.0 + exact))
    return bias
