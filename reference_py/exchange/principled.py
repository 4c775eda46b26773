# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Principled BSDF, by the names of its sockets (4.5 to 5.2), to a stack and back."""

from dataclasses import replace
from functools import partial

import numpy as np

from ..errors import Sentence
from ..material.stack import Stack
from ..models.baselines import PrincipledCoat
from ..models.baselines.parts import metal_colors
from ..models.baselines.principled_film import FilmedPrincipled
from ..optics.diffuse import fujii_roughness
from ..optics.optical_stack import OpticalStack
from ..optics.thin_film import Film
from .appearance import Appearance, Rules, appearance
from .conversion import Converted, lost_if, require_finite, slots_to_stack, stack_to_slots, told, with_body
from .matching import rendered_by
from .report import APPROXIMATED, KEPT, LOST, Loss, Report, metal_or_not
from .slots import BASE, COAT, COAT_COLOR, FILM, GLOSS, METAL_FILM, SUBSURFACE, Slots, Surface, edge_of_f82, effective_ior, sigma_of_fujii
from .surfaces import OPENPBR

NAME, COAT_TINT = "Principled", "Coat Tint"
DEFAULTS = {
    "Base Color": (0.8, 0.8, 0.8), "Metallic": 0.0, "Roughness": 0.5, "IOR": 1.5, "Alpha": 1.0, "Diffuse Roughness": 0.0,
    "Subsurface Weight": 0.0, "Subsurface Radius": (1.0, 0.2, 0.1), "Subsurface Scale": 0.05, "Subsurface Anisotropy": 0.0, "Specular IOR Level": 0.5, "Specular Tint": (1.0, 1.0, 1.0), "Anisotropic": 0.0,
    "Anisotropic Rotation": 0.0, "Transmission Weight": 0.0, "Coat Weight": 0.0, "Coat Roughness": 0.03, "Coat IOR": 1.5,
    "Coat Tint": (1.0, 1.0, 1.0), "Sheen Weight": 0.0, "Emission Strength": 0.0, "Thin Film Thickness": 0.0, "Thin Film IOR": 1.33,
}  # fmt: skip
_NO_PLACE = {
    "Transmission Weight": Sentence("light goes through it, and a stack is opaque: its base is black there"),
    "Sheen Weight": Sentence("a stack has no sheen"), "Emission Strength": Sentence("a stack does not emit; add an Emission node"),
    "Alpha": Sentence("a stack is opaque; mix with a Transparent node"),
}  # fmt: skip
_OPEN_NAMES = {
    "transmission_weight": "Transmission Weight", "fuzz_weight": "Sheen Weight", "emission_luminance": "Emission Strength", "geometry_opacity": "Alpha",
}  # fmt: skip
_TEXTURED = {"Subsurface Weight": Sentence("light spreads below the whole surface or not at all"), **_NO_PLACE}
# The value that a report has of a socket with one.
TEXTURE = Sentence("texture")
_BODY_NAMES = ("Subsurface Weight", "Subsurface Radius", "Subsurface Scale", "Subsurface Anisotropy")
# What the base color has where a value is left out.
OUT_OF_COLOR = (COAT_TINT, "Thin Film Thickness", "Thin Film IOR")
# What glTF and USD have room for of it.
EXPORTED = frozenset({SUBSURFACE})
# What a stack says something about; the rest of the node is its user's.
WRITTEN = {socket: default for socket, default in DEFAULTS.items() if socket not in _NO_PLACE}
# Where the inputs of the node are in a stack: socket, slots in order of preference, parameter. Base Color goes through a map.
PLACES = (
    ("Base Color", (BASE,), "color"), ("Roughness", (GLOSS, BASE), "roughness"), ("Normal", (BASE, GLOSS), "normal"),
    ("Anisotropic", (GLOSS, BASE), "anisotropy"), ("Anisotropic Rotation", (GLOSS, BASE), "rotation"),
    ("Thin Film Thickness", (GLOSS, BASE), "film_thickness"), ("Thin Film IOR", (GLOSS, BASE), "film_ior"),
    ("Coat Weight", (COAT,), "coverage"), ("Coat Roughness", (COAT,), "roughness"), ("Coat IOR", (COAT,), "ior"),
    (COAT_TINT, (COAT,), "tint"), ("Coat Normal", (COAT,), "normal"),
)  # fmt: skip


def to_principled(stack: Stack, textured: bool = False, exported: bool = False, metal_films: bool = True) -> Converted:
    """Socket values as bright as the stack. `textured`: with a map for textures of the base color, which takes seconds.

    `exported`: as glTF, USD and pictures can say it, which have no tint of a coat and no film; the base color has them.
    `metal_films`: whether Principled has films on metals, as from Blender 5.0 on; without, the base color has theirs.
    """
    shaped = _untinted if exported else lambda slots: slots
    room = EXPORTED if exported else EXPORTED | {COAT_COLOR, FILM} | ({METAL_FILM} if metal_films else set())
    slots, owners, report, colors = stack_to_slots(
        stack,
        NAME,
        lambda slots: rendered_by(PrincipledCoat, shaped(slots)),
        room,
        textured,
        lambda slots: rendered_by(partial(FilmedPrincipled, film=_film(slots)), slots),
    )
    if slots.body and slots.body.g < 0.0:
        backward = Loss("scatter_g", slots.body.g, LOST, Sentence("light below the surface of Principled is not scattered backward; its anisotropy is 0"))
        report = replace(report, losses=(*report.losses, backward))
    return Converted(stack, exported_values(slots) if exported else values_of(slots), shaped(slots), owners, report, colors)


def _film(slots: Slots) -> Film:
    features = slots.gloss.features if slots.gloss else slots.features
    return Film(features["film_thickness"], features["film_ior"])


def _untinted(slots: Slots) -> Slots:
    return replace(slots, coat_tint=(1.0, 1.0, 1.0))


def exported_values(slots: Slots) -> dict:
    """As `values_of`, without a coat's tint, and with the index of a surface that is none: USD knows no Specular IOR Level."""
    values = {socket: value for socket, value in values_of(slots).items() if socket != COAT_TINT}
    return values | ({"IOR": 1.0} if values.get("Specular IOR Level") == 0.0 else {})


def values_of(slots: Slots) -> dict:
    """Values by socket name; what is not named is at its default."""
    values = {"Base Color": tuple(slots.color)}
    coat, gloss = slots.coat, slots.gloss
    if coat:
        values |= {"Coat Weight": slots.coat_weight, "Coat Roughness": coat.roughness, "Coat IOR": coat.eta, COAT_TINT: tuple(slots.coat_tint)}
    features = gloss.features if gloss else slots.features
    if slots.is_metal:
        tint = metal_colors(OpticalStack.of(slots.image(False)))[1]
        values |= {"Metallic": 1.0, "Specular Tint": tuple(tint), "Roughness": slots.roughness}
    elif gloss:
        values |= {"IOR": gloss.eta, "Roughness": gloss.roughness}
    else:
        values |= {"Specular IOR Level": 0.0}
    if slots.body:
        values |= {"Subsurface Weight": 1.0, "Subsurface Radius": (1.0, 1.0, 1.0), "Subsurface Scale": 1.0 / slots.body.density}
        values["Subsurface Anisotropy"] = max(slots.body.g, 0.0)
    if slots.sigma_deg:
        values["Diffuse Roughness"] = float(fujii_roughness(slots.sigma_deg))
    names = {parameter: socket for socket, _, parameter in PLACES if parameter in features}
    return values | {names[parameter]: value for parameter, value in features.items()}


def from_principled(values: dict, name: str = "", textured: bool = False, used: frozenset[str] = frozenset()) -> Converted:
    """The stack that is as bright as a Principled node. `values` by socket name; those left out are at Blender's default.

    `used`: sockets with a texture, whose features the stack gets though the value is the default.
    """
    values = DEFAULTS | {k: v for k, v in values.items() if k in DEFAULTS}
    require_finite(values, NAME)
    losses: list[Loss] = []
    losses += [Loss(socket, TEXTURE, LOST, why) for socket, why in _TEXTURED.items() if socket in used]
    is_metal = values["Metallic"] >= 0.5
    if 0.0 < values["Metallic"] < 1.0:
        losses.append(Loss("Metallic", values["Metallic"], LOST, metal_or_not(is_metal)))
    elif values["Metallic"]:
        losses.append(Loss("Metallic", values["Metallic"], KEPT, Sentence("a conductor")))
    if "Metallic" in used:
        losses.append(Loss("Metallic", TEXTURE, LOST, Sentence("a base is metal or not; the socket's own value decides")))
    slots = _slots(values, is_metal, used, losses)
    if values["Subsurface Weight"] and not is_metal:
        slots = with_body(slots, _free_path(values), values["Subsurface Anisotropy"], "Base Color" in used, _BODY_NAMES, values, losses)
    rendered, opaque = rendered_by(PrincipledCoat, slots), 1.0 if is_metal else 1.0 - values["Transmission Weight"]

    def original(color):
        return rendered(opaque * np.asarray(color))

    solid = original(np.clip(values["Base Color"], 0.0, 1.0))
    look = Appearance(solid, values["Alpha"] * solid, appearance(_by_openpbr(values), Rules()).lost)
    losses += [Loss(_OPEN_NAMES[key], values[_OPEN_NAMES[key]], LOST, _NO_PLACE[_OPEN_NAMES[key]]) for key in look.lost if key in _OPEN_NAMES]
    done = slots_to_stack(slots.with_color(opaque * np.asarray(slots.color)), original, look, name, "Converted from a Principled BSDF", losses, textured)
    report = Report(tuple(told([*done.report.losses], values, DEFAULTS)), done.report.match)
    return Converted(done.stack, values, done.slots, done.owners, report, done.colors)


def _free_path(values: dict) -> float:
    """Mean free path of light below the surface, in Blender's units."""
    return float(np.mean(values["Subsurface Radius"]) * values["Subsurface Scale"])


def _by_openpbr(values: dict) -> dict:
    """By OpenPBR's names, for what no stack has of it. Light below the surface has the base's color."""
    return OPENPBR | {
        "base_color": values["Base Color"], "base_metalness": values["Metallic"], "specular_roughness": values["Roughness"],
        "specular_ior": values["IOR"], "specular_weight": 2.0 * values["Specular IOR Level"], "transmission_weight": values["Transmission Weight"],
        "transmission_color": values["Base Color"], "fuzz_weight": values["Sheen Weight"], "coat_weight": values["Coat Weight"],
        "coat_color": values["Coat Tint"], "coat_roughness": values["Coat Roughness"], "coat_ior": values["Coat IOR"],
        "emission_luminance": values["Emission Strength"], "geometry_opacity": values["Alpha"],
    }  # fmt: skip


def _slots(values: dict, is_metal: bool, used: frozenset[str], losses: list[Loss]) -> Slots:
    color = tuple(float(c) for c in np.clip(values["Base Color"], 0.0, 1.0))
    losses.append(Loss("Base Color", color, APPROXIMATED, Sentence("solved such that the mean albedo stays")))
    losses.append(Loss("Roughness", values["Roughness"], KEPT, Sentence("as roughness")))
    features = _features(values, used)
    losses += [
        Loss(socket, values[socket], KEPT, Sentence("as it is"))
        for socket, _, p in PLACES
        if p in features and socket in values and not socket.startswith("Coat")
    ]
    if values["Thin Film Thickness"] > features.get("film_thickness", 0.0):
        losses.append(Loss("Thin Film Thickness", values["Thin Film Thickness"], APPROXIMATED, Sentence("a film is at most 2000 nm")))
    coat = _coat(values, used, losses)
    if is_metal:
        edge = edge_of_f82(np.array(color), np.clip(values["Specular Tint"], 0.0, 1.0))
        losses.append(Loss("Specular Tint", values["Specular Tint"], APPROXIMATED, Sentence("as the edge color of the nearest metal")))
        return Slots(color, edge=tuple(edge), roughness=values["Roughness"], features=features, **coat)
    eta = effective_ior(values["IOR"], values["Specular IOR Level"])
    losses.append(
        Loss("IOR", values["IOR"], KEPT if values["IOR"] == eta else APPROXIMATED, Sentence("with the Specular IOR Level an index of {eta:.4g}", eta=eta))
    )
    lost_if(losses, "Specular Tint", values["Specular Tint"], (1.0, 1.0, 1.0), Sentence("a dielectric's highlight has no color"))
    if coat.get("coat_weight", 1.0) < 1.0 and eta != 1.0:
        losses.append(Loss("IOR", values["IOR"], APPROXIMATED, Sentence("below the coat as Principled has it; beside it the gloss is stronger")))
    sigma = sigma_of_fujii(values["Diffuse Roughness"])
    if sigma == 90.0:
        losses.append(Loss("Diffuse Roughness", values["Diffuse Roughness"], APPROXIMATED, Sentence("as the roughest Oren-Nayar base, 90 degrees")))
    elif sigma:
        losses.append(Loss("Diffuse Roughness", values["Diffuse Roughness"], KEPT, Sentence("as a slope deviation of {sigma:.4g} degrees", sigma=sigma)))
    gloss = None if eta == 1.0 else Surface(eta, values["Roughness"], features)
    if gloss is None:
        losses += [Loss(s, values[s], LOST, Sentence("there is no specular reflection")) for s in ("Anisotropic", "Thin Film Thickness") if values[s]]
    return Slots(color, sigma_deg=sigma, gloss=gloss, **coat)


def _features(values: dict, used: frozenset[str]) -> dict:
    features = {}
    if values["Anisotropic"] or "Anisotropic" in used:
        features |= {"anisotropy": values["Anisotropic"], "rotation": values["Anisotropic Rotation"] % 1.0}
    if values["Thin Film Thickness"] > 0.0 or "Thin Film Thickness" in used:
        thickness, ior = np.clip(values["Thin Film Thickness"], 0.0, 2000.0), np.clip(values["Thin Film IOR"], 1.0, 4.0)
        features |= {"film_thickness": float(thickness), "film_ior": float(ior)}
    return features


def coat_ior_loss(parameter: str, ior: float) -> Loss:
    """What becomes of a coat's index."""
    return Loss(parameter, ior, KEPT, Sentence("as the layer's")) if ior >= 1.0 else Loss(parameter, ior, APPROXIMATED, Sentence("below 1 it counts as 1"))


def _coat(values: dict, used: frozenset[str], losses: list[Loss]) -> dict:
    weight = values["Coat Weight"]
    if not weight and "Coat Weight" not in used:
        return {}
    losses.append(Loss("Coat Weight", weight, KEPT, Sentence("a layer on the whole surface") if weight == 1.0 else Sentence("as the layer's coverage")))
    losses += [Loss("Coat Roughness", values["Coat Roughness"], KEPT, Sentence("as the layer's")), coat_ior_loss("Coat IOR", values["Coat IOR"])]
    losses.append(Loss("Coat Tint", values["Coat Tint"], KEPT, Sentence("a medium whose round trip leaves it: half a crossing of this tint each way")))
    tint = tuple(float(c) for c in np.clip(values["Coat Tint"], 0.0, 1.0))
    # where a texture says where the coat is, the socket's own value says nothing
    weight = weight if "Coat Weight" not in used else 1.0
    return {"coat": Surface(max(values["Coat IOR"], 1.0), values["Coat Roughness"]), "coat_tint": tint, "coat_weight": weight}
