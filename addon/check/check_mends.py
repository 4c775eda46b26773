# SPDX-License-Identifier: GPL-3.0-or-later
"""How each finding of `check` is mended: functions of the material, the scene and the finding."""

import bpy
import numpy as np

from ...reference_py.material.schema import COLOR, FLOAT
from ..blender.texture_limit import allow
from ..jobs import bakes
from ..material import material as materials
from ..material import state
from ..material.backend import AUTO
from ..material.elements import find_node, kind_of, new_node, node_of
from ..material.entry import entry_of, output_after
from ..material.kind_groups import fresh_group
from ..material.node_copy import animation_by_name, copy_inputs
from ..material.osl_setting import enable_osl
from ..material.record import give_recorded, recorded
from ..material.shader_node import surface_of

_BELOW = 160  # of an output, where another one has place


def _element(material, finding):
    """The last element of the finding's node: of two that share one, the upper keeps it."""
    lamina = material.lamina
    return [e for e in (*lamina.layers, lamina.base) if e.node == finding.element][-1]


def _socket(material, finding) -> bpy.types.NodeSocket:
    return node_of(_element(material, finding)).inputs[finding.label]


def _regenerate(material, _scene, _finding) -> None:
    materials.regenerate(material)


def _use_cycles(_material, scene, _finding) -> None:
    enable_osl(scene)


def _use_automatic(material, _scene, _finding) -> None:
    with materials.changing(material):
        material.lamina.backend = AUTO


def _bake(material, _scene, _finding) -> None:
    bakes.retry(material)


def _link_shader(material, _scene, _finding) -> None:
    materials.regenerate(material)
    surface = surface_of(material)
    if not surface.is_linked:
        for target in entry_of(material.node_tree):
            material.node_tree.links.new(surface, target)


def _unmute_shader(material, _scene, finding) -> None:
    material.node_tree.nodes[finding.element].mute = False


def _stock(material, _scene, _finding) -> None:
    (materials.refresh if state.lacks_branch(material) else materials.refresh_stock)(material)


def _let_lamina_show(material, _scene, finding) -> None:
    """Blender shows a muted output black, and from 5.0 on lets none be muted, so the output steps back: all renderers' and not active.

    Its volume and displacement go on to show where Lamina's output has none. Lamina's becomes the last one, which is what
    glTF export of 5.3 takes, active or not.
    """
    tree = material.node_tree
    own, other = output_after(surface_of(material).node), tree.nodes[finding.element]
    for name in ("Volume", "Displacement"):
        if not own.inputs[name].is_linked:
            for link in other.inputs[name].links:
                tree.links.new(link.from_socket, own.inputs[name])
    other.target = "ALL"
    if other in list(tree.nodes)[list(tree.nodes).index(own) :]:
        last = tree.nodes.new(own.bl_idname)
        last.location = own.location_absolute.x, own.location_absolute.y - _BELOW
        for socket, twin in zip(own.inputs, last.inputs):
            for link in socket.links:
                tree.links.new(link.from_socket, twin)
        own = last
    own.is_active_output = True


def _unmute(material, _scene, finding) -> None:
    node_of(_element(material, finding)).mute = False


def _new_node(material, _scene, finding) -> None:
    """All that are gone at once, as a shader needs every one; those of no known values only by the button that says so.

    With the recorded values and links; drivers and keyframes go with a node that Blender deletes.
    """
    lamina, takes_defaults = material.lamina, finding.code == "node_lost"
    gone = [e for e in (*lamina.layers, lamina.base) if find_node(e) is None and (takes_defaults or recorded(e))]
    with materials.changing(material) as tree:
        for element in gone:
            give_recorded(element, new_node(tree, kind_of(element), element.node))


def _own_node(material, _scene, finding) -> None:
    element = _element(material, finding)
    with materials.changing(material) as tree:
        former = node_of(element)
        node = new_node(tree, kind_of(element))
        copy_inputs(former, node)
        element.node = node.name


def _remove_node(material, _scene, finding) -> None:
    material.node_tree.nodes.remove(material.node_tree.nodes[finding.element])


def _replace_group(material, _scene, finding) -> None:
    """A fresh group for every node that has the broken one, in every material of this file; links, values and animation stay."""
    element = _element(material, finding)
    broken, group = node_of(element).node_tree, fresh_group(kind_of(element))
    nodes = [node_of(element)]
    if broken is not None:
        trees = [m.node_tree for m in bpy.data.materials if m.library is None and m.node_tree is not None]
        nodes = [n for tree in trees for n in tree.nodes if n.bl_idname == "ShaderNodeGroup" and n.node_tree == broken]
    for node in nodes:
        values = {s.name: _plain(s.default_value) for s in node.inputs if hasattr(s, "default_value")}
        sources = [(k.from_socket, s.name, k.is_muted) for s in node.inputs for k in s.links]
        targets = [(s.name, k.to_socket) for s in node.outputs for k in s.links]
        with animation_by_name(node):
            node.node_tree = group
        for name, value in values.items():
            if name in node.inputs:
                node.inputs[name].default_value = value
        tree = node.id_data
        for source, name, is_muted in sources:
            if name in node.inputs:
                tree.links.new(source, node.inputs[name]).is_muted = is_muted
        for name, target in targets:
            if name in node.outputs:
                tree.links.new(node.outputs[name], target)
    if broken is not None and broken.users == 0:
        bpy.data.node_groups.remove(broken)
    materials.regenerate(material)


def _plain(value):
    return value if isinstance(value, (int, float, bool, str)) else tuple(value)


def _remove_link(material, _scene, finding) -> None:
    for link in list(_socket(material, finding).links):
        material.node_tree.links.remove(link)


def _unmute_link(material, _scene, finding) -> None:
    for link in _socket(material, finding).links:
        link.is_muted = False


def _into_range(material, _scene, finding) -> None:
    element, socket = _element(material, finding), _socket(material, finding)
    parameter = next(p for p in kind_of(element).sockets if p.label == finding.label)
    default = np.asarray(parameter.default, float)
    value = np.asarray(socket.default_value if parameter.type == FLOAT else list(socket.default_value)[:3], float)
    value = np.clip(np.where(np.isfinite(value), value, default), parameter.minimum, parameter.maximum)
    socket.default_value = float(value) if parameter.type == FLOAT else (*value, 1.0) if parameter.type == COLOR else tuple(value)


def _raise_limit(_material, scene, finding) -> None:
    allow(scene, finding.words["size"])


MENDS = {
    "backend_missing": _use_automatic,
    "osl_missing": _regenerate,
    "script_alone": _use_automatic,
    "without_osl": _use_cycles,
    "one_branch": _stock,
    "stock_behind": _stock,
    "output_hides": _let_lamina_show,
    "output_rests": _let_lamina_show,
    "shader_gone": _regenerate,
    "shader_unused": _link_shader,
    "shader_muted": _unmute_shader,
    "shader_edited": _regenerate,
    "shader_unlinked": _regenerate,
    "exported_shows": _regenerate,
    "shader_stale": _regenerate,
    "not_baked": _bake,
    "node_gone": _new_node,
    "node_lost": _new_node,
    "node_muted": _unmute,
    "node_shared": _own_node,
    "node_spare": _remove_node,
    "group_broken": _replace_group,
    "link_broken": _remove_link,
    "link_muted": _unmute_link,
    "image_missing": _remove_link,
    "tables_shrunk": _raise_limit,
    "out_of_range": _into_range,
}
