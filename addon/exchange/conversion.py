# SPDX-License-Identifier: GPL-3.0-or-later
"""A material with a Principled node becomes a stack; a stack gets a Principled copy. Textures stay linked."""

from collections.abc import Iterator

import bpy

from ...reference_py.errors import LaminaError, Sentence
from ...reference_py.exchange.principled import PLACES, TEXTURE, from_principled, to_principled
from ...reference_py.exchange.report import KEPT, LOST, Report, noted
from ...reference_py.material.place import Place
from ...reference_py.material.qualities import DEFAULT_METHOD
from ...reference_py.material.stack import Stack
from ..blender.versions import HAS_METAL_FILMS
from ..material import material as materials
from ..material.backend import NODES, OSL
from ..material.elements import find_node, kind_of, node_of
from ..material.hand_over import MIX, VALUES
from ..material.node_copy import own_actions
from ..material.principled_node import COLOR, PRINCIPLED, has_linked_color, is_layer, link_through, linked_places, parameter_of, show_stack
from ..material.reading import measured_stack, require_editable
from ..material.record import drop_record
from ..material.roles import EEVEE, EEVEE_OUTPUT, LAYERS_FRAME, ROLE, SHADER_FRAME, SWITCH, TEST, Roles
from ..material.shader_node import surface_of
from ..material.state import is_followed
from .sources import animated_parts, principled_of, read_principled

# What a Principled copy has no use for.
_GOES = (OSL, NODES, SWITCH, TEST, MIX, EEVEE, EEVEE_OUTPUT, LAYERS_FRAME, SHADER_FRAME)


def to_lamina(material: bpy.types.Material, tier: str = DEFAULT_METHOD, backend: str | None = None) -> tuple[Report, list[Sentence]]:
    """Put the stack of its Principled node in its place. Returns the report and what the links became.

    Raises LaminaError, and leaves the material as it was, where there is no such node.
    """
    require_editable(material)
    principled = principled_of(material)
    values, sources = read_principled(principled)
    converted = from_principled(values, material.name, "Base Color" in sources, frozenset(sources))
    notes = [noted(LOST, Sentence("keyframes and drivers of the Principled node stay behind"))] if animated_parts(principled) else []
    stack = _with_linked_features(converted.stack, converted.owners, sources)
    name = principled.name
    materials.apply_stack(material, stack, tier, backend)  # which removes the node where nothing is linked to it
    said = {loss.parameter for loss in converted.report.of(LOST) if loss.value == TEXTURE}
    with materials.changing(material):
        linked = {socket: _link(socket, source, material, converted) for socket, source in sources.items()}
    notes += [_told(socket, places, material) for socket, places in linked.items() if socket not in said]
    principled = material.node_tree.nodes.get(name)
    if principled is not None and not any(output.is_linked for output in principled.outputs):
        material.node_tree.nodes.remove(principled)
    return converted.report, notes


def _roles(roles, owners: dict, name: str) -> list[str]:
    """The slots that a socket goes to: a normal to all that there are, all else to the first."""
    here = [role for role in roles if role in owners]
    return here if name == "normal" else here[:1]


def _with_linked_features(stack: Stack, owners: dict[str, int], sources) -> Stack:
    """A stack whose elements have the features that textures feed."""
    data = stack.to_dict()
    rows = [*data["layers"], data["base"]]
    for socket, roles, name in PLACES:
        if socket in sources and name in ("normal", "coverage"):
            for role in _roles(roles, owners, name):
                rows[owners[role]].setdefault(name, [0.0, 0.0, 0.0] if name == "normal" else 1.0)
    return Stack.from_dict(data, stack.name or "conversion")


def _link(socket: str, source, material, converted) -> list[Place]:
    """Link a texture to what its socket became; returns these places."""
    elements = [*material.lamina.shown_layers, material.lamina.base]
    roles, name = next(((r, n) for s, r, n in PLACES if s == socket), ((), ""))
    places = []
    for role in _roles(roles, converted.owners, name):
        index = converted.owners[role]
        element = elements[index]
        kind = kind_of(element)
        parameter = parameter_of(element, name)
        if parameter not in {p.name for p in kind.given_by(element.given)} | {p.name for f in kind.features for p in f.parameters}:
            continue
        target = node_of(element).inputs[kind.parameter(parameter).label]
        if socket == COLOR:
            link_through(source, target, converted.colors)
        else:
            source.id_data.links.new(source, target)
        places.append(Place(None if element == material.lamina.base else index, parameter))
    return places


def _told(socket: str, places: list[Place], material) -> Sentence:
    """What became of a texture that is linked to these places."""
    if not places:
        return noted(LOST, Sentence("{socket} texture: a stack has no place for it", socket=socket))
    if not all(is_followed(material, place) for place in places):
        return noted(LOST, Sentence("{socket} texture: it stays linked, but stock nodes cannot follow it and show its mean", socket=socket))
    if socket == COLOR:
        return noted(KEPT, Sentence("{socket} texture: through nodes that keep the mean color", socket=socket))
    return noted(KEPT, Sentence("{socket} texture: linked to the layer", socket=socket))


def principled_copy(material: bpy.types.Material) -> tuple[bpy.types.Material, Report, list[Sentence]]:
    """A new material with a Principled node as bright as the stack, fed by the same textures. The old one stays as it is."""
    stack = measured_stack(material)
    converted = to_principled(stack, textured=has_linked_color(material), metal_films=HAS_METAL_FILMS)
    copy = material.copy()
    copy.name = f"{material.name} Principled"
    own_actions(copy.node_tree)
    try:
        notes = _rebuild(copy, converted)
    except Exception:
        bpy.data.materials.remove(copy)
        raise
    return copy, converted.report, notes


def _rebuild(copy: bpy.types.Material, converted) -> list[Sentence]:
    """Leave the Principled node of a copy, which is the hand-over's where there is one, in the place of its shading."""
    tree, lamina = copy.node_tree, copy.lamina
    roles = Roles(tree)
    output = tree.get_output_node("CYCLES") or tree.nodes.new("ShaderNodeOutputMaterial")
    former = surface_of(copy)
    targets = [link.to_socket for link in former.links] if former is not None else []
    principled = roles.make(VALUES, PRINCIPLED, "", (output.location_absolute.x - 320, output.location_absolute.y))
    principled.hide, principled.label = False, ""
    for socket in principled.inputs:
        socket.hide = False
    linked = sum(s.is_linked for e in (*lamina.shown_layers, lamina.base) for s in node_of(e).inputs)
    notes = show_stack(principled, copy, converted.values, converted.owners, converted.colors)
    if linked > len(notes):
        notes.append(noted(LOST, Sentence("{count} more links of layers: Principled has no place for them", count=linked - len(notes))))
    for name, element, parameter, source in linked_places(copy, converted.owners):
        if is_layer(source.node):
            notes = [sentence for sentence in notes if not sentence.startswith(f"kept: {name} ")]
            told = Sentence("{element} {parameter}: it was linked to another layer", element=element.name, parameter=Sentence(parameter.label))
            notes.append(noted(LOST, told))
    for target in targets or [output.inputs["Surface"]]:
        tree.links.new(principled.outputs["BSDF"], target)
    values = [find_node(element) for element in (*lamina.layers, lamina.base)]
    for node in [node for node in tree.nodes if node in values or node.get(ROLE) in _GOES]:
        tree.nodes.remove(node)
    for node in tree.nodes:
        if ROLE in node:  # a stack that is put here later makes its own
            del node[ROLE]
    drop_record(copy)
    return notes


def principled_copies(replacing: bool) -> Iterator[tuple[bpy.types.Material, Sentence]]:
    """A Principled copy of every Lamina material of the file; yields each copy, or the material that has none, and what became of it.

    With `replacing` the copies take the place and the names of the originals, which go.
    """
    for material in [m for m in bpy.data.materials if m.lamina.is_layered]:
        try:
            require_editable(material)
            copy, report, _ = principled_copy(material)
        except LaminaError as error:
            yield material, Sentence("left as it is: {error}", error=error)
            continue
        name = material.name
        if replacing:
            copy.use_fake_user = material.use_fake_user
            material.user_remap(copy)
            bpy.data.materials.remove(material)
            copy.name = name
        else:
            copy.use_fake_user = True  # no object has it yet
        lost = ", ".join(dict.fromkeys(loss.parameter for loss in report.of(LOST)))
        error = Sentence("error {share:.1f} %", share=100.0 * report.match.soft_light)
        yield copy, Sentence("{error}; lost: {parameters}", error=error, parameters=lost) if lost else error
