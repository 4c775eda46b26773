# SPDX-License-Identifier: GPL-3.0-or-later
"""How Lamina's nodes lie in the Shader editor: in two frames, apart, without the sockets that mean nothing. No node of the user's is moved.

The column of layers stands on the base, and that of the shader hangs from its first branch: wherever these, or the frames,
were moved to, the rest follows at the next change. What is in a frame of the user's stays there.
"""

from collections.abc import Callable, Iterable, Sequence

import bpy

from ..blender.translation import data_
from .backend import NODES, OSL
from .elements import element_parameters, kind_of, node_of, show_name
from .hand_over import MIX, VALUES
from .masks import place_masks
from .roles import EEVEE, LAYERS_FRAME, ROLE, SHADER_FRAME, SWITCH, TEST, Roles

_IN_SHADER = (OSL, NODES, EEVEE, TEST, SWITCH, MIX, VALUES)
# In the editor's pixels at scale 1, as a node has no size before it is drawn.
_WIDTH, _APART, _GAP = 200.0, 140.0, 30.0
_AROUND, _ROW = 70.0, 22.0
# A vector that is not linked has a row for its name and one for each number.
_ROWS_OF_VECTOR = 4


def arrange(material: bpy.types.Material) -> None:
    """Put what the panel makes in its places. Blender looks through the whole tree after most changes, so only what differs is set."""
    lamina, roles = material.lamina, Roles(material.node_tree)
    branches = [node for role in (OSL, NODES, EEVEE) if (node := roles.get(role)) is not None]
    made = [node for role in _IN_SHADER if (node := roles.get(role)) is not None]
    for node in made:
        _hide(node.inputs, lambda socket: not socket.is_linked)
    _enframe(roles, SHADER_FRAME, made)
    elements = [*lamina.layers, lamina.base]
    nodes = [node_of(element) for element in elements]
    for element, node in zip(elements, nodes):
        _show_element(element, node)
    shader = branches[0].location_absolute
    _stack(branches, shader, 0)
    settled = _settled(nodes, roles.get(LAYERS_FRAME))
    place = nodes[settled].location_absolute if settled is not None else (shader.x - _WIDTH - _APART, shader.y)
    _stack(nodes, place, settled or 0)
    masks = [mask for node in nodes for mask in place_masks(node)]
    _enframe(roles, LAYERS_FRAME, [*nodes, *masks])


def _settled(nodes: Sequence[bpy.types.Node], frame: bpy.types.Node | None) -> int | None:
    """The lowest node that has its place already, from which the others take theirs."""
    return next((i for i in reversed(range(len(nodes))) if frame is not None and nodes[i].parent == frame), None)


def _stack(nodes: Sequence[bpy.types.Node], place: Iterable[float], fixed: int) -> None:
    """Nodes below each other, of which the one at index `fixed` is at `place`."""
    x, y = place
    y += sum(_height(node) for node in nodes[:fixed])
    for node in nodes:
        _move(node, (x, y))
        y -= _height(node)


def _move(node, place) -> None:
    in_own = node.parent is None or node.parent.get(ROLE) in (LAYERS_FRAME, SHADER_FRAME)
    if in_own and any(abs(now - then) > 0.5 for now, then in zip(node.location_absolute, place)):
        node.location_absolute = place


def _height(node) -> float:
    shown = [socket for socket in (*node.inputs, *node.outputs) if not socket.hide]
    tall = [s for s in node.inputs if not s.hide and s.type == "VECTOR" and not s.is_linked and not s.hide_value]
    return _AROUND + _GAP + _ROW * (len(shown) + (_ROWS_OF_VECTOR - 1) * len(tall))


def _show_element(element, node) -> None:
    """The name of a layer or base, whether it is there to be seen, and the values that describe it, no others."""
    lamina = element.id_data.lamina
    mute = element != lamina.base and not lamina.shows(element)
    if node.mute != mute:
        node.mute = mute
    if node.width != _WIDTH:
        node.width = _WIDTH
    used = {p.label for p in element_parameters(element, kind_of(element), element.given) if not p.is_structural}
    _hide(node.inputs, lambda socket: socket.name not in used and not socket.is_linked)
    _hide(node.outputs, lambda socket: not socket.is_linked)
    show_name(element)


def _hide(sockets: Iterable[bpy.types.NodeSocket], is_unused: Callable[[bpy.types.NodeSocket], bool]) -> None:
    for socket in sockets:
        if socket.hide != is_unused(socket):
            socket.hide = not socket.hide


def _enframe(roles: Roles, role: str, nodes: Iterable[bpy.types.Node]) -> None:
    """Put nodes that are in no frame into that of a role, which is made if there is none."""
    loose = [node for node in nodes if node.parent is None]
    if not loose:
        return
    frame = roles.get(role)
    if frame is None:
        label = data_("Layers: Edit in the Panel") if role == LAYERS_FRAME else data_("Shader: Made by the Panel")
        frame = roles.make(role, "NodeFrame", label, (0.0, 0.0))
        frame.hide = False
    for node in loose:
        node.parent = frame
