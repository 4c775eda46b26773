# SPDX-License-Identifier: GPL-3.0-or-later
"""What is wrong with a material, as data, and how each thing is mended with one click.

`find` looks and changes nothing; `mend` does what a finding offers. It is quick enough for a panel to draw.
"""

import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from math import isfinite

import bpy

from ...reference_py.errors import LaminaError
from ...reference_py.schema import FLOAT, NORMAL, SCHEMA, Parameter
from ..background import bakes
from ..network.inputs import BASE, layer_owner
from ..network.node_groups import is_untouched as group_is_untouched
from ..nodes import material as materials
from ..nodes.backend import NODES, OSL, backend_here
from ..nodes.elements import kind_of, node_of
from ..nodes.hand_over import usd_takes
from ..nodes.kind_groups import KIND_KEY, hands_on
from ..nodes.live_values import live_values
from ..nodes.script_node import device_problem, is_untouched, scene_problem
from ..nodes.shader_node import backend_of, has_shader
from ..rendering import environment
from .check_mends import MENDS

ERROR, WARNING = "ERROR", "INFO"

# code: how bad it is, what is wrong, and the button that mends it (empty: nothing here can)
CODES = {
    "not_editable": (WARNING, "{reason}", ""),
    "backend_missing": (ERROR, "{reason}", "Use Automatic"),
    "osl_missing": (ERROR, "The shader is an OSL script, and {reason}", "Make It of Stock Nodes"),
    "scene_without_osl": (ERROR, "{reason}", "Use Cycles with OSL"),
    "device_without_osl": (ERROR, "{reason}", "Use Stock Nodes"),
    "shader_gone": (ERROR, "The shader node was deleted", "Make It Anew"),
    "shader_unused": (ERROR, "The shader feeds no material output", "Link It"),
    "shader_muted": (ERROR, "The shader node is muted", "Unmute"),
    "shader_edited": (WARNING, "The shader was edited by hand; its next change will replace it", "Make It Anew"),
    "shader_unlinked": (ERROR, "{count} values do not reach the shader, the first is {first}", "Link Them"),
    "shader_stale": (WARNING, "The shader holds old values", "Update"),
    "not_baked": (WARNING, "Shown by tier analytic; bake {reason}", "Bake Again"),
    "node_gone": (ERROR, "The node of {layer} was deleted", "Make It Anew with Default Values"),
    "node_muted": (ERROR, "The node of {layer} is muted", "Unmute"),
    "node_shared": (ERROR, "{layer} has the same node as a layer above it", "Give It Its Own"),
    "node_spare": (WARNING, "No layer has the layer node {node}", "Remove It"),
    "group_broken": (ERROR, "The node group {group} of {layer} does not hand its values on; {count} nodes share it", "Replace the Group"),
    "link_broken": (ERROR, "{layer}: the link to {label} is broken", "Remove the Link"),
    "link_muted": (WARNING, "{layer}: the link to {label} is muted", "Unmute"),
    "image_missing": (ERROR, "{layer}: {label} has a texture without an image", "Remove the Link"),
    "normal_ignored": (WARNING, "{layer}: stock nodes leave its normal out", ""),
    "texture_ignored": (WARNING, "{layer}: {label} has a texture or animation, which stock nodes cannot follow", ""),
    "usd_misled": (WARNING, "USD export takes the node {node}, which was there before; delete it if it is of no use", ""),
    "out_of_range": (ERROR, "{layer}: {label} is {value}; allowed is {allowed}", "Bring into Range"),
}  # fmt: skip


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong: its code, the words of its sentence, and what it is about, for `mend`."""

    code: str
    words: dict = field(default_factory=dict)
    element: str = ""
    label: str = ""

    @property
    def key(self) -> str:
        """Names the finding among those of one material."""
        return f"{self.code}/{self.element}/{self.label}"

    @property
    def level(self) -> str:
        return CODES[self.code][0]

    @property
    def mending(self) -> str:
        """What the button says that mends it; empty where none does."""
        return "" if self.code == "osl_missing" and environment.osl_available()[0] else CODES[self.code][2]

    def text(self, translate=str) -> str:
        """The sentence; `translate` gets its template."""
        return translate(CODES[self.code][1]).format(**self.words)


def find(material: bpy.types.Material, scene: bpy.types.Scene, preferences: bpy.types.Preferences) -> list[Finding]:
    """Everything that is wrong with a layered material, the worst first. Raises LaminaError for one without layers."""
    materials.require_layered(material)
    try:
        materials.require_editable(material)
        found = []
    except LaminaError as error:
        found = [Finding("not_editable", {"reason": str(error)})]
    if material.node_tree is None:
        return found
    found += [*_machine(material, scene, preferences), *_elements(material), *_shader(material)]
    if before := usd_takes(material):
        found.append(Finding("usd_misled", {"node": before.name}, before.name))
    return sorted(found, key=lambda f: f.level != ERROR)


def mend(material: bpy.types.Material, scene: bpy.types.Scene, preferences: bpy.types.Preferences, key: str) -> None:
    """Mend the finding of this key. Raises LaminaError where there is none any more, or nothing can be done."""
    finding = next((f for f in find(material, scene, preferences) if f.key == key), None)
    if finding is None:
        raise LaminaError(f"there is no finding {key!r} any more")
    if not finding.mending:
        raise LaminaError(f"this cannot be mended here: {finding.text()}")
    materials.require_editable(material)
    MENDS[finding.code](material, scene, finding)


def _machine(material, scene, preferences) -> Iterator[Finding]:
    """What this Blender or its scene lacks."""
    try:
        backend_here(material.lamina.backend)
    except LaminaError as error:
        yield Finding("backend_missing", {"reason": str(error)})
        return
    if backend_of(material) != OSL:
        return
    available, reason = environment.osl_available()
    if not available:
        if has_shader(material):  # a new one would be of stock nodes
            yield Finding("osl_missing", {"reason": reason})
    elif problem := scene_problem(scene):
        yield Finding("scene_without_osl", {"reason": problem})
    elif problem := device_problem(scene, preferences):
        yield Finding("device_without_osl", {"reason": problem})


def _elements(material) -> Iterator[Finding]:
    lamina, tree = material.lamina, material.node_tree
    links, seen = _links_into(tree), set()
    sound = cache(lambda group, kind: hands_on(group, SCHEMA.layers.get(kind) or SCHEMA.bases[kind]))
    for element in (*lamina.layers, lamina.base):
        name = {"layer": element.name}
        node = tree.nodes.get(element.node)
        if node is None:
            yield Finding("node_gone", name, element.node)
            continue
        if element.node in seen:
            yield Finding("node_shared", name, element.node)
        seen.add(element.node)
        is_shown = element == lamina.base or lamina.shows(element)
        if node.mute and is_shown:
            yield Finding("node_muted", name, element.node)
        group = node.node_tree
        if group is None or not sound(group, element.kind):
            words = {"group": group.name if group else "?", "count": group.users if group else 1}
            yield Finding("group_broken", name | words, element.node)
            continue
        yield from _values(element, node, is_shown, links)
    for node in tree.nodes:
        if node.name.startswith("Lamina ") and node.bl_idname == "ShaderNodeGroup" and node.name not in seen and _is_value_node(node):
            yield Finding("node_spare", {"node": node.name}, node.name)


def _is_value_node(node) -> bool:
    return node.node_tree is not None and KIND_KEY in node.node_tree


def _links_into(tree) -> dict[int, list[bpy.types.NodeLink]]:
    """Links by the socket that they end in. Every `socket.links` would look through all links of the tree."""
    links: dict[int, list[bpy.types.NodeLink]] = {}
    for link in tree.links:
        links.setdefault(link.to_socket.as_pointer(), []).append(link)
    return links


def _values(element, node, is_shown: bool, links: dict[int, list[bpy.types.NodeLink]]) -> Iterator[Finding]:
    """Values, links and textures of one element's sockets."""
    for parameter in kind_of(element).sockets:
        socket = node.inputs.get(parameter.label)
        if socket is None:
            continue  # of a later version: there once the shader is made anew
        about = {"layer": element.name, "label": parameter.label}
        into = links.get(socket.as_pointer(), ())
        for link in into:
            if not link.is_valid or link.from_socket.type == "SHADER":
                yield Finding("link_broken", about, element.node, parameter.label)
            elif link.is_muted:
                yield Finding("link_muted", about, element.node, parameter.label)
            elif is_shown and _lacks_image(link.from_node):
                yield Finding("image_missing", about, element.node, parameter.label)
        if not into and (wrong := out_of_range(socket.default_value, parameter)):
            yield Finding("out_of_range", about | {"value": wrong, "allowed": parameter.allowed}, element.node, parameter.label)


def out_of_range(value, parameter: Parameter) -> str:
    """The component of a socket's value that the schema does not allow, as text; empty if there is none."""
    numbers = [value] if parameter.type == FLOAT else list(value)[:3]
    slack = 1e-6 * max(abs(parameter.minimum), abs(parameter.maximum))  # a socket holds float32
    wrong = [v for v in numbers if not isfinite(v) or not parameter.minimum - slack <= v <= parameter.maximum + slack]
    return f"{wrong[0]:.4g}" if wrong else ""


def _lacks_image(node, depth: int = 16) -> bool:
    """Whether a texture without an image, or one whose file is gone, is at or before a node."""
    if node.bl_idname == "ShaderNodeTexImage":
        image = node.image
        if image is None:
            return True
        if image.source == "FILE" and image.packed_file is None and not image.has_data:
            return not os.path.exists(bpy.path.abspath(image.filepath, library=image.library))
        return False
    return depth > 0 and any(_lacks_image(link.from_node, depth - 1) for socket in node.inputs for link in socket.links)


def _shader(material) -> Iterator[Finding]:
    tree = material.node_tree
    if not has_shader(material):
        yield Finding("shader_gone")
        return
    node = tree.nodes[material.lamina.shader_node]
    if not _reaches_output(node, set()):
        yield Finding("shader_unused")
    if node.mute:
        yield Finding("shader_muted")
    backend = backend_of(material)
    code = node.script if backend == OSL else node.node_tree
    if code is None:
        yield Finding("shader_gone")
        return
    if not (is_untouched(code.as_string()) if backend == OSL else group_is_untouched(code)):
        yield Finding("shader_edited")
    if lost := _unlinked(material, node):
        yield Finding("shader_unlinked", {"count": len(lost), "first": lost[0]})
    if reason := bakes.given_up(material):
        yield Finding("not_baked", {"reason": reason})
    try:
        if materials.is_stale(material):
            yield Finding("shader_stale")
        if backend == NODES:
            yield from _ignored(material)
    except LaminaError:
        pass  # what is wrong with the values is a finding of its own


def _reaches_output(node, seen: set[str]) -> bool:
    seen.add(node.name)
    followers = [link.to_node for socket in node.outputs for link in socket.links]
    return any(
        n.bl_idname in ("ShaderNodeOutputMaterial", "NodeGroupOutput") or (n.name not in seen and _reaches_output(n, seen))
        for n in followers
    )


def _unlinked(material, shader) -> list[str]:
    """Inputs of the shader that do not come from the layer that they are named for."""
    lamina = material.lamina
    owners = {layer_owner(i): layer for i, layer in enumerate(lamina.shown_layers)} | {BASE: lamina.base}
    expected = {owner + p.osl_name: (e.node, p.label) for owner, e in owners.items() for p in kind_of(e).sockets}
    links, lost = _links_into(material.node_tree), []
    for socket in shader.inputs:
        wanted = expected.get(socket.identifier) or expected.get(socket.name)
        into = [(k.from_node.name, k.from_socket.name) for k in links.get(socket.as_pointer(), ()) if not k.is_muted]
        if wanted is not None and into != [wanted]:
            lost.append(socket.name)
    return lost


def _ignored(material) -> Iterator[Finding]:
    lamina = material.lamina
    shown = lamina.shown_layers
    for index, name in live_values(material):
        element = lamina.base if index < 0 else shown[index]
        label = kind_of(element).parameter(name).label
        yield Finding("texture_ignored", {"layer": element.name, "label": label}, node_of(element).name, label)
    stack = materials.stack_of(material)
    for element, told in zip((*shown, lamina.base), (*stack.layers, stack.base)):
        if told.has(NORMAL):
            yield Finding("normal_ignored", {"layer": element.name}, node_of(element).name)
