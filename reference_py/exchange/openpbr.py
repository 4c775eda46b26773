# SPDX-License-Identifier: GPL-3.0-or-later
"""OpenPBR 1.1 (base, specular, coat, thin film), by the names of its parameters, to a stack and back.

The specular index is absolute there: relative to it is the mean of 1 and the coat's by the coat's weight. The coat color
is what two perpendicular crossings leave. Films are in micrometres. Anisotropy a makes the alphas' ratio 1 - a and
keeps the mean of their squares at roughness^4.
"""

import numpy as np

from ..material.stack import Stack
from ..models.baselines import OpenPbrCoat
from ..models.baselines.parts import metal_colors
from ..optics.diffuse import fujii_roughness
from ..optics.optical_stack import OpticalStack
from .conversion import Converted, lost_if, require_finite, slots_to_stack, stack_to_slots
from .principled import coat_ior_loss, effective_ior
from .report import APPROXIMATED, KEPT, LOST, Loss, Report
from .slots import Slots, Surface, edge_of_f82, sigma_of_fujii

NAME = "OpenPBR"
_WHITE = (1.0, 1.0, 1.0)
DEFAULTS = {
    "base_weight": 1.0, "base_color": (0.8, 0.8, 0.8), "base_diffuse_roughness": 0.0, "base_metalness": 0.0,
    "specular_weight": 1.0, "specular_color": _WHITE, "specular_roughness": 0.3, "specular_ior": 1.5,
    "specular_roughness_anisotropy": 0.0, "transmission_weight": 0.0, "subsurface_weight": 0.0, "fuzz_weight": 0.0,
    "coat_weight": 0.0, "coat_color": _WHITE, "coat_roughness": 0.0, "coat_roughness_anisotropy": 0.0, "coat_ior": 1.6,
    "coat_darkening": 1.0, "thin_film_weight": 0.0, "thin_film_thickness": 0.5, "thin_film_ior": 1.4,
    "emission_luminance": 0.0, "geometry_opacity": 1.0,
}  # fmt: skip
"""Every parameter that is read or written, with the specification's default."""
_NO_PLACE = {
    "transmission_weight": "a stack's base is opaque", "subsurface_weight": "a stack's base is opaque",
    "fuzz_weight": "a stack has no fuzz", "emission_luminance": "a stack does not emit", "geometry_opacity": "a stack is opaque",
    "coat_darkening": "a stack always has the light that the coat holds back",
}  # fmt: skip
_NM_PER_UM = 1000.0
# Blender's anisotropy makes the alphas' ratio 1 - .9 anisotropy.
_BLENDER_RATIO = 0.9


def to_openpbr(stack: Stack) -> Converted:
    """Parameters as bright as the stack; what is not named is at its default."""
    slots, owners, report, _ = stack_to_slots(stack, OpenPbrCoat.name, NAME, room=frozenset({"anisotropy"}))
    values = {"base_color": tuple(slots.color)}
    losses = []
    if slots.coat:
        values |= {"coat_weight": slots.coat_weight, "coat_color": tuple(slots.coat_tint), "coat_ior": slots.coat.eta}
        values |= _rough("coat", slots.coat.roughness, slots.coat.features, losses)
    features = slots.gloss.features if slots.gloss else slots.features
    if slots.is_metal:
        values |= {"base_metalness": 1.0, "specular_color": tuple(metal_colors(OpticalStack.of(slots.image(False)))[1])}
        values |= _rough("specular", slots.roughness, features, losses)
    elif slots.gloss:
        values |= {"specular_ior": slots.gloss.eta * _above(slots)} | _rough("specular", slots.gloss.roughness, features, losses)
    else:
        values |= {"specular_weight": 0.0}
    if slots.sigma_deg:
        values["base_diffuse_roughness"] = float(fujii_roughness(slots.sigma_deg))
    if features.get("film_thickness"):
        values |= {"thin_film_weight": 1.0, "thin_film_thickness": features["film_thickness"] / _NM_PER_UM, "thin_film_ior": features["film_ior"]}
    report = Report((*report.losses, *losses), report.match)
    return Converted(stack, values, slots, owners, report)


def _above(slots: Slots) -> float:
    return 1.0 + slots.coat_weight * (slots.coat.eta - 1.0) if slots.coat else 1.0


def _rough(part: str, roughness: float, features: dict, losses: list[Loss]) -> dict:
    """Roughness and anisotropy of the coat or the specular lobe."""
    if not features.get("anisotropy"):
        return {f"{part}_roughness": roughness}
    if features["rotation"]:
        losses.append(Loss(f"{part} rotation", features["rotation"], LOST, f"{NAME} turns the tangent of the geometry instead"))
    ratio = 1.0 - _BLENDER_RATIO * features["anisotropy"]
    return {f"{part}_roughness": min(roughness * (0.5 * (ratio + 1.0 / ratio)) ** 0.25, 1.0), f"{part}_roughness_anisotropy": 1.0 - ratio}


def _smooth(part: str, values: dict) -> tuple[float, dict]:
    """Roughness and features in a stack's terms; the inverse of `_rough`."""
    roughness, anisotropy = values[f"{part}_roughness"], min(values[f"{part}_roughness_anisotropy"], _BLENDER_RATIO)
    if not anisotropy:
        return roughness, {}
    ratio = 1.0 - anisotropy
    return roughness / (0.5 * (ratio + 1.0 / ratio)) ** 0.25, {"anisotropy": anisotropy / _BLENDER_RATIO, "rotation": 0.0}


def from_openpbr(values: dict, name: str = "") -> Converted:
    """The stack that is as bright as OpenPBR. Parameters that are left out are at their defaults."""
    values = DEFAULTS | {k: v for k, v in values.items() if k in DEFAULTS}
    require_finite(values, NAME)
    losses: list[Loss] = []
    for parameter, why in _NO_PLACE.items():
        lost_if(losses, parameter, values[parameter], DEFAULTS[parameter], why)
    is_metal = values["base_metalness"] >= 0.5
    if 0.0 < values["base_metalness"] < 1.0:
        losses.append(Loss("base_metalness", values["base_metalness"], LOST, f"a base is metal or not; it is {'metal' if is_metal else 'diffuse'}"))
    losses.append(Loss("base_color", values["base_color"], APPROXIMATED, "solved such that the mean albedo stays"))
    losses.append(Loss("specular_roughness", values["specular_roughness"], KEPT, "as roughness"))
    done = slots_to_stack(_slots(values, is_metal, losses), OpenPbrCoat.name, name, "Converted from OpenPBR", losses)
    return Converted(done.stack, values, done.slots, done.owners, done.report)


def _slots(values: dict, is_metal: bool, losses: list[Loss]) -> Slots:
    color = values["base_weight"] * np.clip(values["base_color"], 0.0, 1.0)
    coat, above = _coat(values, losses)
    roughness, features = _smooth("specular", values)
    if values["specular_roughness_anisotropy"]:
        clear = values["specular_roughness_anisotropy"] <= _BLENDER_RATIO
        losses.append(
            Loss("specular_roughness_anisotropy", values["specular_roughness_anisotropy"], KEPT if clear else APPROXIMATED, f"at most {_BLENDER_RATIO}")
        )
    features |= _film(values, losses)
    if is_metal:
        edge = edge_of_f82(color, np.clip(values["specular_color"], 0.0, 1.0))
        losses.append(Loss("specular_color", values["specular_color"], APPROXIMATED, "as the edge color of the nearest metal"))
        return Slots(tuple(color * values["specular_weight"]), edge=tuple(edge), roughness=roughness, features=features, **coat)
    lost_if(losses, "specular_color", values["specular_color"], _WHITE, "a dielectric's highlight has no color")
    eta = effective_ior(values["specular_ior"] / above, 0.5 * values["specular_weight"])
    losses.append(
        Loss("specular_ior", values["specular_ior"], KEPT if values["specular_weight"] == 1.0 else APPROXIMATED, f"as an index of {eta:.4g} to what is above")
    )
    sigma = sigma_of_fujii(values["base_diffuse_roughness"])
    if sigma:
        losses.append(
            Loss(
                "base_diffuse_roughness",
                values["base_diffuse_roughness"],
                APPROXIMATED if sigma == 90.0 else KEPT,
                f"as a slope deviation of {sigma:.4g} degrees",
            )
        )
    gloss = None if abs(eta - 1.0) < 1e-9 else Surface(eta, roughness, features)
    return Slots(tuple(color), sigma_deg=sigma, gloss=gloss, **coat)


def _film(values: dict, losses: list[Loss]) -> dict:
    weight = values["thin_film_weight"]
    if not weight:
        return {}
    note = "in nanometres" if weight == 1.0 else "a film is on all of the surface"
    losses.append(Loss("thin_film_weight", weight, KEPT if weight == 1.0 else LOST, note))
    losses += [Loss(f"thin_film_{p}", values[f"thin_film_{p}"], KEPT, "as the film's") for p in ("thickness", "ior")]
    thickness = np.clip(_NM_PER_UM * values["thin_film_thickness"], 0.0, 2000.0)
    return {"film_thickness": float(thickness), "film_ior": float(np.clip(values["thin_film_ior"], 1.0, 4.0))}


def _coat(values: dict, losses: list[Loss]) -> tuple[dict, float]:
    """Slots' coat, and the index above the specular interface."""
    weight = values["coat_weight"]
    if not weight:
        return {}, 1.0
    losses.append(Loss("coat_weight", weight, KEPT, "a layer on the whole surface" if weight == 1.0 else "as the layer's coverage"))
    losses += [Loss("coat_roughness", values["coat_roughness"], KEPT, "as the layer's"), coat_ior_loss("coat_ior", values["coat_ior"])]
    losses.append(Loss("coat_color", values["coat_color"], KEPT, "a medium whose round trip leaves it"))
    roughness, features = _smooth("coat", values)
    ior = max(values["coat_ior"], 1.0)
    tint = tuple(float(c) for c in np.clip(values["coat_color"], 0.0, 1.0))
    return {"coat": Surface(ior, roughness, features), "coat_tint": tint, "coat_weight": weight}, 1.0 + weight * (ior - 1.0)
