# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces of MaterialX to a stack: OpenPBR 1.1, and by its names the others of `surfaces`; and a stack to `WRITERS`.

The specular index is absolute in OpenPBR: relative to it is the mean of 1 and the coat's by the coat's weight. The coat
color is what two perpendicular crossings leave. Films are in micrometres.
"""

import numpy as np

from ..errors import LaminaError, Sentence
from ..material.schema import THIN_FILM
from ..material.stack import Stack
from ..models.baselines.parts import metal_colors
from ..optics.diffuse import fujii_roughness
from ..optics.optical_stack import OpticalStack
from .appearance import Appearance, appearance, body_color, specular_index
from .conversion import Converted, is_default, require_finite, slots_to_stack, stack_to_slots, told, with_body
from .matching import mean
from .report import APPROXIMATED, KEPT, LOST, Loss, Report, film_limited, metal_or_not
from .slots import BASE, COAT, COAT_COLOR, FILM, GLOSS, METAL_FILM, SUBSURFACE, Slots, edge_of_f82, sigma_of_fujii
from .slots import Surface as Interface
from .surfaces import OPENPBR, SURFACES, Surface, geometric_roughness, open_roughness

NAME = "OpenPBR"
DEFAULTS = OPENPBR
_OPEN = SURFACES["open_pbr_surface"]
_NO_PLACE = {
    "transmission_weight": Sentence("light goes through it, and a stack is opaque: what is below the surface is black there"),
    "fuzz_weight": Sentence("a stack has no sheen"), "emission_luminance": Sentence("a stack does not emit"),
    "geometry_opacity": Sentence("a stack is opaque"),
}  # fmt: skip
# Beginnings of inputs that have no place in a stack, and the one that each says more about: nothing is to say where that is 0.
_OF = {
    "transmission_": "transmission_weight", "attenuation_": "transmission_weight", "thickness": "transmission_weight", "dispersion": "transmission_weight",
    "subsurface_": "subsurface_weight", "subsurfaceD": "subsurface_weight", "occlusion": "", "displacement": "",
}  # fmt: skip
_READ = ("transmission_weight", "transmission_color", "subsurface_weight", "subsurface_color")
_NM_PER_UM = 1000.0
_CLEARCOAT_IOR = 1.5
# Blender's anisotropy makes the alphas' ratio 1 - .9 anisotropy.
_BLENDER_RATIO = 0.9
# Where the inputs are in a stack, by OpenPBR's names: slots in order of preference, parameter.
PLACES = {
    "base_color": ((BASE,), "color"), "specular_roughness": ((GLOSS, BASE), "roughness"), "coat_weight": ((COAT,), "coverage"),
    "coat_roughness": ((COAT,), "roughness"), "coat_color": ((COAT,), "tint"), "coat_ior": ((COAT,), "ior"),
    "geometry_normal": ((BASE, GLOSS), "normal"), "geometry_coat_normal": ((COAT,), "normal"),
}  # fmt: skip


def to_openpbr(stack: Stack) -> Converted:
    """Parameters as bright as the stack; what is not named is at its default."""
    return to_surface(_OPEN, stack)


def to_surface(surface: Surface, stack: Stack, textured: bool = False) -> Converted:
    """Values by the surface's own names, as bright as the stack. `textured`: with a map for textures of the base color, which takes seconds.

    Raises LaminaError for a surface that is not written.
    """
    if surface.node not in WRITERS:
        raise LaminaError("{node} is read, not written; choose {choices}", node=surface.node, choices=", ".join(WRITERS))
    write = WRITERS[surface.node]

    def rendered(slots: Slots):
        def albedos(color):
            values = write(slots.with_color(np.clip(color, 0.0, 1.0)), [])
            return appearance(DEFAULTS | surface.to_open(surface.defaults | values), surface.rules).solid

        return albedos

    room = {"anisotropy", COAT_COLOR, FILM, METAL_FILM} | ({SUBSURFACE} if surface.own("subsurface_weight") in surface.defaults else set())
    slots, owners, report, colors = stack_to_slots(stack, surface.title, rendered, frozenset(room), textured)
    losses: list[Loss] = []
    values = write(slots, losses)
    amended = {loss.parameter for loss in losses}
    return Converted(stack, values, slots, owners, Report((*(o for o in report.losses if o.parameter not in amended), *losses), report.match), colors)


def _to_openpbr(slots: Slots, losses: list[Loss]) -> dict:
    values = {"base_color": tuple(slots.color)}
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
    if slots.body:
        values |= {"subsurface_weight": 1.0, "subsurface_color": tuple(slots.color), "subsurface_radius": 1.0 / slots.body.density}
        values |= {"subsurface_radius_scale": (1.0, 1.0, 1.0), "subsurface_scatter_anisotropy": slots.body.g}
    if slots.sigma_deg:
        values["base_diffuse_roughness"] = float(fujii_roughness(slots.sigma_deg))
    if features.get("film_thickness"):
        values |= {"thin_film_weight": 1.0, "thin_film_thickness": features["film_thickness"] / _NM_PER_UM, "thin_film_ior": features["film_ior"]}
    return values


def _above(slots: Slots) -> float:
    return 1.0 + slots.coat_weight * (slots.coat.eta - 1.0) if slots.coat else 1.0


def _rough(part: str, roughness: float, features: dict, losses: list[Loss]) -> dict:
    """Roughness and anisotropy of the coat or the specular lobe."""
    if not features.get("anisotropy"):
        return {f"{part}_roughness": roughness}
    if features["rotation"]:
        losses.append(Loss(f"{part} rotation", features["rotation"], LOST, Sentence("{name} turns the tangent of the geometry instead", name=NAME)))
    ratio = 1.0 - _BLENDER_RATIO * features["anisotropy"]
    return {f"{part}_roughness": min(open_roughness(roughness, ratio), 1.0), f"{part}_roughness_anisotropy": 1.0 - ratio}


def _to_standard(slots: Slots, losses: list[Loss]) -> dict:
    values = {"base": 1.0, "base_color": tuple(slots.color)}
    if slots.coat:
        values |= {"coat": slots.coat_weight, "coat_color": tuple(slots.coat_tint), "coat_IOR": slots.coat.eta, "coat_roughness": slots.coat.roughness}
        values |= _brushed("coat", slots.coat.features)
    features = slots.gloss.features if slots.gloss else slots.features
    if slots.is_metal:
        values |= {"metalness": 1.0, "specular_color": tuple(slots.edge), "specular_roughness": slots.roughness} | _brushed("specular", features)
    elif slots.gloss:
        values |= {"specular_IOR": slots.gloss.eta, "specular_roughness": slots.gloss.roughness} | _brushed("specular", features)
    else:
        values |= {"specular": 0.0}
    if slots.body:
        values |= {"subsurface": 1.0, "subsurface_color": tuple(slots.color), "subsurface_radius": (1.0, 1.0, 1.0)}
        values |= {"subsurface_scale": 1.0 / slots.body.density, "subsurface_anisotropy": slots.body.g}
    if slots.sigma_deg:
        values["diffuse_roughness"] = float(np.radians(slots.sigma_deg))
    if features.get("film_thickness"):
        values |= {"thin_film_thickness": features["film_thickness"], "thin_film_IOR": features["film_ior"]}
    return values


def _brushed(part: str, features: dict) -> dict:
    if not features.get("anisotropy"):
        return {}
    return {f"{part}_anisotropy": _BLENDER_RATIO * features["anisotropy"], f"{part}_rotation": features["rotation"]}


def _to_gltf(slots: Slots, losses: list[Loss]) -> dict:
    values = {"base_color": tuple(slots.color), "metallic": float(slots.is_metal)}
    if slots.coat:
        values |= {"clearcoat": slots.coat_weight, "clearcoat_roughness": slots.coat.roughness}
        if min(slots.coat_tint) < 1.0:
            losses.append(Loss("coat tint", slots.coat_tint, APPROXIMATED, Sentence("a clearcoat has none: it is in the base color, the same at all angles")))
        if slots.coat.eta != _CLEARCOAT_IOR:
            losses.append(
                Loss("coat IOR", slots.coat.eta, APPROXIMATED, Sentence("a clearcoat has {ior:g}; the base color makes up for it", ior=_CLEARCOAT_IOR))
            )
        if slots.coat.features.get("anisotropy"):
            losses.append(Loss("coat anisotropy", slots.coat.features["anisotropy"], LOST, Sentence("a clearcoat has none")))
    features = slots.gloss.features if slots.gloss else slots.features
    roughness = slots.roughness if slots.is_metal else slots.gloss.roughness if slots.gloss else 1.0
    if slots.is_metal:
        losses.append(Loss("edge color", slots.edge, LOST, Sentence("a metal's reflectance rises as Schlick has it")))
    elif slots.gloss:
        values["ior"] = slots.gloss.eta
    else:
        values["specular"] = 0.0
    if slots.sigma_deg:
        losses.append(Loss("base sigma_deg", slots.sigma_deg, LOST, Sentence("a diffuse base is Lambert's")))
    if features.get("anisotropy"):
        ratio = 1.0 - _BLENDER_RATIO * features["anisotropy"]
        across = min(roughness**2 * ratio**0.5, 0.999)
        along = min(across / ratio, 1.0)
        roughness = across**0.5
        values |= {"anisotropy_strength": float(((along - across) / (1.0 - across)) ** 0.5), "anisotropy_rotation": 2.0 * np.pi * features["rotation"]}
    if features.get("film_thickness"):
        values |= {"iridescence": 1.0, "iridescence_thickness": features["film_thickness"], "iridescence_ior": features["film_ior"]}
    return values | {"roughness": roughness}


WRITERS = {"open_pbr_surface": _to_openpbr, "standard_surface": _to_standard, "gltf_pbr": _to_gltf}
"""By surface: values by its own names, of slots."""


def from_openpbr(values: dict, name: str = "") -> Converted:
    """The stack that is as bright as OpenPBR. Parameters that are left out are at their defaults."""
    return from_surface(_OPEN, values, name)


def from_surface(surface: Surface, values: dict, name: str = "", textured: bool = False, used: frozenset[str] = frozenset()) -> Converted:
    """The stack that is as bright as a surface of these values, by its own names; those left out are at their defaults.

    `textured`: with a map for textures of the base color. `used`: OpenPBR's names of what textures feed, whose slots the
    stack gets though the value is the default. Raises LaminaError where nothing that is seen would be left.
    """
    own = surface.defaults | {k: v for k, v in values.items() if k in surface.defaults}
    require_finite(own, surface.title)
    v = DEFAULTS | {"specular_rotation": 0.0, "coat_rotation": 0.0} | surface.to_open(own)
    if "coat_weight" in used:  # where a texture says where the coat is, the input's own value says nothing
        v["coat_weight"] = 1.0
    reader = _Reader(surface, own, v, textured)
    reader.limit_index()
    look = appearance(v, surface.rules)
    reader.say_lost(look)
    slots = reader.slots()

    def original(color):
        return appearance(v | {"base_color": tuple(np.broadcast_to(color, 3))}, surface.rules).solid

    done = slots_to_stack(slots, original, look, name, f"Converted from {surface.title}", reader.losses, textured)
    is_lighter = COAT in done.owners and not np.allclose(done.stack.layers[done.owners[COAT]]["tint"], slots.coat_tint)
    said = [loss for loss in done.report.losses if not (is_lighter and loss.parameter == surface.own("coat_color") and loss.fate == KEPT)]
    losses = told(said, own, surface.defaults)
    return Converted(done.stack, own, done.slots, done.owners, Report(tuple(losses), done.report.match), done.colors)


class _Reader:
    """Puts values by OpenPBR's names `v` into slots; what it says of them is in `losses`, by the surface's own names."""

    def __init__(self, surface: Surface, own: dict, v: dict, textured: bool):
        self._surface, self._own, self.v, self._textured = surface, own, v, textured
        self._is_metal = v["base_metalness"] >= 0.5
        self._has_body = bool(v["subsurface_weight"]) and not v["geometry_thin_walled"] and not self._is_metal
        self.losses: list[Loss] = []

    def _say(self, name: str, fate: str, how: Sentence) -> None:
        own = self._surface.own(name)
        if own in self._own:
            self.losses.append(Loss(own, self._own[own], fate, how))

    def limit_index(self) -> None:
        """An index below 1 is no medium's: it counts as 1 from the start, for the file's albedo too."""
        if self.v["specular_ior"] < 1.0:
            if self.v["specular_weight"] > 0.0 and not self._is_metal:
                self._say("specular_ior", APPROXIMATED, Sentence("no medium has it; choose 1 to 4; it counts as 1"))
            self.v["specular_ior"] = 1.0

    def say_lost(self, look: Appearance) -> None:
        """What no stack has, with its share of the light, and inputs that mean nothing to a stack."""
        whole = float(np.sum(mean(look.seen + look.all_lost)))
        for name, light in look.lost.items():
            how = _NO_PLACE.get(name, Sentence("light goes through the thin wall"))
            share = 100.0 * float(np.sum(mean(light))) / max(whole, 1e-9)
            self._say(name, LOST, Sentence("{how}; that is {share:.1f} % of its light", how=how, share=share))
        for name, value in self._own.items():
            if self._has_body and name.startswith("subsurface"):
                continue
            main = next((self.v.get(m, 1.0) for part, m in _OF.items() if name.startswith(part)), 0.0)
            if main and name not in (*_READ, *self._surface.names.values()) and not is_default(name, self._own, self._surface.defaults):
                self.losses.append(Loss(name, value, LOST, Sentence("a stack has no place for it")))

    def slots(self) -> Slots:
        """The slots, with the color of an opaque base that is all that is seen of the body."""
        v, rules = self.v, self._surface.rules
        if 0.0 < v["base_metalness"] < 1.0:
            self._say("base_metalness", LOST, metal_or_not(self._is_metal))
        coat = self._coat()
        roughness, features = self._rough("specular")
        features |= self._film()
        self._say("base_color", APPROXIMATED, Sentence("solved such that the mean albedo stays"))
        self._say("specular_roughness", KEPT, Sentence("as roughness"))
        if self._is_metal:
            return self._metal(roughness, features, coat)
        if np.ptp(v["specular_color"]) > 1e-6 or v["specular_color"][0] != 1.0:
            self._say("specular_color", LOST, Sentence("a dielectric's highlight has no color"))
        eta = specular_index(v, rules)
        if rules.scales_lobe and v["specular_weight"] < 1.0:
            root = (v["specular_weight"] ** 0.5) * abs(eta - 1.0) / (eta + 1.0)
            eta = (1.0 + root) / (1.0 - root)
        if not any(loss.parameter == self._surface.own("specular_ior") for loss in self.losses):
            self._say("specular_ior", KEPT if v["specular_weight"] == 1.0 else APPROXIMATED, Sentence("as an index of {eta:.4g} to what is above", eta=eta))
        self._say("specular_weight", APPROXIMATED, Sentence("as an index of {eta:.4g} to what is above", eta=eta))
        sigma = sigma_of_fujii(v["base_diffuse_roughness"])
        self._say("base_diffuse_roughness", APPROXIMATED if sigma == 90.0 else KEPT, Sentence("as a slope deviation of {sigma:.4g} degrees", sigma=sigma))
        color = np.clip((1.0 - v["transmission_weight"]) * body_color(v), 0.0, 1.0)
        gloss = None if abs(eta - 1.0) < 1e-9 and not features.get("film_thickness") else Interface(eta, roughness, features)
        slots = Slots(tuple(color), sigma_deg=sigma, gloss=gloss, **coat)
        if not self._has_body:
            return slots
        names = [name for name in self._own if name.startswith("subsurface")]
        free_path = float(np.mean(v["subsurface_radius"] * np.asarray(v["subsurface_radius_scale"])))
        return with_body(slots, free_path, v["subsurface_scatter_anisotropy"], self._textured, names, self._own, self.losses)

    def _metal(self, roughness: float, features: dict, coat: dict) -> Slots:
        v = self.v
        color = np.clip(v["base_weight"] * np.asarray(v["base_color"]), 0.0, 1.0)
        tint = np.clip(v["specular_color"], 0.0, 1.0)
        if self._surface.rules.gives_edge:
            self._say("specular_color", KEPT, Sentence("as the edge color"))
            return Slots(tuple(color), edge=tuple(tint * v["specular_weight"]), roughness=roughness, features=features, **coat)
        self._say("specular_color", APPROXIMATED, Sentence("as the edge color of the nearest metal"))
        return Slots(tuple(color * min(v["specular_weight"], 1.0)), edge=tuple(edge_of_f82(color, tint)), roughness=roughness, features=features, **coat)

    def _rough(self, part: str) -> tuple[float, dict]:
        """Roughness and features in a stack's terms; the inverse of the module's `_rough`."""
        roughness, given = self.v[f"{part}_roughness"], self.v[f"{part}_roughness_anisotropy"]
        if not given:
            return roughness, {}
        kept = min(given, _BLENDER_RATIO)
        self._say(
            f"{part}_roughness_anisotropy", KEPT if kept == given else APPROXIMATED, Sentence("as an anisotropy of {value:.4g}", value=kept / _BLENDER_RATIO)
        )
        return geometric_roughness(roughness, 1.0 - kept), {"anisotropy": kept / _BLENDER_RATIO, "rotation": self.v[f"{part}_rotation"] % 1.0}

    def _film(self) -> dict:
        weight, thickness, ior = (self.v[f"thin_film_{p}"] for p in ("weight", "thickness", "ior"))
        if not weight:
            return {}
        if weight < 1.0:
            self._say("thin_film_weight", LOST, Sentence("a film is on all of the surface"))
        limits = {p.name: p for p in THIN_FILM.parameters}
        kept = {}
        for name, value in (("thickness", _NM_PER_UM * thickness), ("ior", ior)):
            limit = limits[f"film_{name}"]
            kept[limit.name] = float(np.clip(value, limit.minimum, limit.maximum))
            whole = abs(kept[limit.name] - value) < 1e-9
            how = Sentence("as the film's") if whole else film_limited(limit, kept[limit.name])
            self._say(f"thin_film_{name}", KEPT if whole else APPROXIMATED, how)
        return kept

    def _coat(self) -> dict:
        v = self.v
        weight = v["coat_weight"]
        if not weight:
            return {}
        self._say("coat_weight", KEPT, Sentence("a layer on the whole surface") if weight == 1.0 else Sentence("as the layer's coverage"))
        self._say("coat_roughness", KEPT, Sentence("as the layer's"))
        self._say("coat_color", KEPT, Sentence("a medium whose round trip leaves it"))
        self._say(
            "coat_ior",
            KEPT if v["coat_ior"] >= 1.0 else APPROXIMATED,
            Sentence("as the layer's") if v["coat_ior"] >= 1.0 else Sentence("below 1 it counts as 1"),
        )
        if self._surface.rules.physical_coat and v["coat_darkening"] != 1.0:
            self._say("coat_darkening", APPROXIMATED, Sentence("a stack always has the light that the coat holds back; the base color makes up for it"))
        roughness, features = self._rough("coat")
        tint = tuple(float(c) for c in np.clip(v["coat_color"], 0.0, 1.0))
        return {"coat": Interface(max(v["coat_ior"], 1.0), roughness, features), "coat_tint": tint, "coat_weight": weight}
