# SPDX-License-Identifier: GPL-3.0-or-later
"""A stack in optical terms: relative indices, alphas, optical depths, complex index of the base."""

from dataclasses import dataclass

import numpy as np

from ..colour import artist_index, conductor_rgb
from ..stack import Element, Stack
from .microfacet import alpha_from_roughness, is_specular

# A tint of 0 means black after any thickness; the floor keeps tau finite in float32 too.
TINT_FLOOR = 1e-30


@dataclass(frozen=True)
class Interface:
    """One dielectric interface and the medium below it."""

    n_above: float
    n_below: float
    alpha: float
    distribution: str
    tau: np.ndarray
    """Optical depth (3,) of one perpendicular crossing of the medium below."""

    @property
    def eta(self) -> float:
        """n_below / n_above."""
        return self.n_below / self.n_above


def optical_depth(tint, thickness: float) -> np.ndarray:
    """tau (3,) of one perpendicular crossing: tint ** thickness is what it leaves (Weidlich07, eq. 5)."""
    return -np.log(np.maximum(np.asarray(tint, float), TINT_FLOOR)) * thickness


def interfaces(stack: Stack) -> tuple[Interface, ...]:
    """The dielectric interfaces from the top; vacuum above the first."""
    result, n_above = [], 1.0
    for layer in stack.layers:
        result.append(
            Interface(
                n_above=n_above,
                n_below=layer["ior"],
                alpha=float(alpha_from_roughness(layer["roughness"])),
                distribution=layer["distribution"],
                tau=optical_depth(layer["tint"], layer["thickness"]),
            )
        )
        n_above = layer["ior"]
    return tuple(result)


def rough_surfaces(stack: Stack) -> list[tuple[str, float]]:
    """(distribution, alpha) of every surface that does something and is not smooth, from the top: where f can be narrow."""
    surfaces = [(s.distribution, s.alpha) for s in interfaces(stack) if s.eta != 1.0]
    if stack.base.kind == "conductor":
        surfaces.append((stack.base["distribution"], float(alpha_from_roughness(stack.base["roughness"]))))
    return [(kind, alpha) for kind, alpha in surfaces if not is_specular(alpha)]


def n_above_base(stack: Stack) -> float:
    """Absolute index of the medium in contact with the base."""
    return stack.layers[-1]["ior"] if stack.layers else 1.0


def channels(stack: Stack) -> int:
    """Length of the colour axis: 3 for RGB, the number of wavelengths for a stack of `spectral`."""
    return len(stack.base["color"] if "color" in stack.base else conductor_index(stack.base)[0])


def conductor_index(base: Element) -> tuple[np.ndarray, np.ndarray]:
    """Absolute complex index (eta, k), each (3,), of a conductor base."""
    if "metal" in base:
        return conductor_rgb(base["metal"])
    if "eta" in base:
        return np.array(base["eta"]), np.array(base["k"])
    return artist_index(np.array(base["reflectance"]), np.array(base["edge_color"]))
