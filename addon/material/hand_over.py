# SPDX-License-Identifier: GPL-3.0-or-later
"""What exporters find of a material: a Principled node beside its shading, and the material's viewport color.

The node is on the second input of a Mix Shader whose factor is 0, which Cycles drops. glTF takes a Principled node there, USD
the first one of a tree; OBJ, FBX and Solid view take the viewport color, which stays the user's once they changed it. The
base color takes up to a second to solve: until values rest it is the stack's own, and the error is not known.
"""

import hashlib
import json
from dataclasses import dataclass

import bpy
import numpy as np

from ...reference_py.errors import LaminaError
from ...reference_py.exchange import conversion_process
from ...reference_py.exchange.hand_over import HandOver, cached_hand_over, key_of, provisional, put, solved
from ...reference_py.exchange.principled import WRITTEN
from ...reference_py.material.stack import Stack
from ..shader.working_space import into_working, out_of_working
from .principled_node import COLOR, PRINCIPLED, has_linked_color, linked_places, picture_of, show_stack
from .reading import stack_of
from .roles import ROLE, Roles, give

MIX, VALUES = "hand-over", "principled"
_USD_TAKES = (PRINCIPLED, "ShaderNodeBsdfDiffuse")
_APART, _BELOW = 160, 120
# What there and back between working spaces changes a color by.
_CONVERTED = 1e-4


@dataclass(frozen=True)
class WantedHandOver:
    """What exporters are to find of a stack, before it is solved; `textured` as in `solved`."""

    stack: Stack
    textured: bool

    @classmethod
    def of(cls, material: bpy.types.Material) -> "WantedHandOver":
        """That of a material. Raises LaminaError for bad values."""
        return cls(stack_of(material), has_linked_color(material))

    @property
    def key(self) -> str:
        return key_of(self.stack, self.textured)

    def is_cached(self) -> bool:
        return cached_hand_over(self.stack, self.textured) is not None

    def request(self) -> str:
        """What a process is asked for it."""
        return conversion_process.request(self.stack, self.textured)

    def put(self, packed: dict) -> None:
        """Keep what another process solved."""
        put(self.stack, self.textured, packed)


def follow_hand_over(material: bpy.types.Material, closure: bpy.types.NodeSocket, stack: Stack, settle: bool = False) -> bpy.types.NodeSocket:
    """Make what exporters find follow the stack, and set only what differs. Returns the Mix Shader's output.

    `closure` is the output of the material's shading; what it fed, the Mix Shader feeds. `settle` solves the base color
    now; without it that is done only where it was solved before.
    """
    textured = has_linked_color(material)
    hand = _hand_over(stack, textured, settle)
    roles, lamina = Roles(material.node_tree), material.lamina
    is_new = roles.get(MIX) is None
    place = closure.node.location_absolute
    mix = roles.make(MIX, "ShaderNodeMixShader", "Lamina Hand-over", (place.x + _APART, place.y))
    principled = roles.make(VALUES, PRINCIPLED, "Lamina Hand-over", (place.x, place.y + _BELOW))
    roles.link(None, mix.inputs[0])
    give(mix.inputs[0], 0.0)
    fed = [link.to_socket for link in closure.links if link.to_node != mix]
    roles.link(closure, mix.inputs[1])
    roles.link(principled.outputs["BSDF"], mix.inputs[2])
    for socket in fed:
        roles.link(mix.outputs[0], socket)
    show_stack(principled, material, hand.values, hand.owners, hand.colors)
    _show_in_viewport(material, WRITTEN | hand.values, is_new)
    error = -1.0 if hand.error is None else 100.0 * hand.error
    _set(lamina, "hand_over_error", error)
    _set(lamina, "handed", _key(material, stack, hand.owners) if hand.error is not None else "")
    return mix.outputs[0]


def is_handed_over(material: bpy.types.Material, stack: Stack) -> bool:
    """Whether exporters find the present values and links, with a base color that is solved."""
    if not material.lamina.handed or not has_hand_over(material):
        return False
    return material.lamina.handed == _key(material, stack, provisional(stack).owners)


def has_hand_over(material: bpy.types.Material) -> bool:
    """Whether exporters find anything; a material of an older version, or with a deleted node, gets it at its next change or save."""
    roles = Roles(material.node_tree)
    mix, principled = roles.get(MIX), roles.get(VALUES)
    return mix is not None and principled is not None and roles.source(mix.inputs[2]) == principled.outputs["BSDF"]


def usd_takes(material: bpy.types.Material) -> bpy.types.Node | None:
    """The user's node that USD export takes in place of the hand-over: the first of these in the order of making, linked or not."""
    first = next((node for node in material.node_tree.nodes if node.bl_idname in _USD_TAKES), None)
    return first if first is not None and first.get(ROLE) != VALUES else None


def tail(closure: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
    """What a material output is to be linked to: the hand-over's Mix Shader if `closure` feeds it, else itself."""
    mix = Roles(closure.id_data).get(MIX)
    return mix.outputs[0] if mix is not None and any(link.to_node == mix for link in closure.links) else closure


def _hand_over(stack: Stack, textured: bool, settle: bool) -> HandOver:
    try:
        found = solved(stack, textured) if settle else cached_hand_over(stack, textured)
    except LaminaError:  # the truth knows no such stack; everything but the base color holds
        found = None
    return found or provisional(stack)


def _key(material: bpy.types.Material, stack: Stack, owners: dict[str, int]) -> str:
    """Names the values and the links that are handed over."""
    links = [
        (place, source.node.name, source.identifier, *(picture_of(element, parameter).tolist() if place == COLOR else ()))
        for place, element, parameter, source in linked_places(material, owners)
    ]
    return hashlib.sha256(json.dumps([key_of(stack, has_linked_color(material)), links]).encode()).hexdigest()


def _show_in_viewport(material: bpy.types.Material, values: dict, is_new: bool) -> None:
    """The viewport color, unless the user changed it since it was set last."""
    coated = values["Coat Weight"] >= 0.5 and values["Metallic"] == 0.0 and values["Specular IOR Level"] == 0.0
    wanted = (*values["Base Color"], values["Metallic"], values["Coat Roughness" if coated else "Roughness"])
    now = (*out_of_working(material.diffuse_color[:3]), material.metallic, material.roughness)
    if not is_new and not np.allclose(now, material.lamina.viewport, atol=_CONVERTED):
        return
    if not np.allclose(now, wanted, atol=_CONVERTED):
        material.diffuse_color = (*into_working(wanted[:3]), material.diffuse_color[3])
        material.metallic, material.roughness = wanted[3:]
    if not _same(material.lamina.viewport, wanted):
        material.lamina.viewport = wanted


def _same(first, second) -> bool:
    return np.array_equal(np.asarray(first, np.float32), np.asarray(second, np.float32))


def _set(lamina, name: str, value) -> None:
    """A property set restarts a viewport's render, so only another value is."""
    former = getattr(lamina, name)
    if former != value and not (isinstance(value, float) and _same(former, value)):
        setattr(lamina, name, value)
