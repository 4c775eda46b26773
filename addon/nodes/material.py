# SPDX-License-Identifier: GPL-3.0-or-later
"""A stack in a material: group nodes that hold its values, and the generated shader that reads them.

The layer nodes feed one Script node, which is generated again only when structure or tier changes; in the backend of
stock nodes the shader is a group that holds the values. Every function changes the material wholly or, when it
raises LaminaError, not at all.
"""

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import bpy

from ...reference_py.errors import LaminaError
from ...reference_py.network import DEFAULT_TIER, HOLD_VALUES, PROVISIONAL_TIER, TIERS, AutoNetwork, make_network, require_tier
from ...reference_py.network.choice import DEFAULT_TOLERANCE
from ...reference_py.network.memory import content
from ...reference_py.network.mixture import MAX_CLOSURES, estimated_cost, estimated_error, holds_values, tiers_of
from ...reference_py.schema import CONDUCTOR, SCHEMA, SCHEMA_VERSION
from ...reference_py.stack import Stack
from ..network.inputs import BASE, layer_owner
from ..network.osl import generate
from ..network.stock_nodes import closure_count, left_out, stock_tables
from ..rendering.settings import node_tree
from .backend import NODES, OSL, backend_here, notice
from .elements import bring_up_to_date, carry_metal, fill_element, kind_of, node_of, read_element, show_name, shown_parameters, structure_dict
from .live_values import live_values
from .properties import follow, quietly
from .script_node import enable_osl
from .shader_node import backend_of, group_with, script_with, tangent_owner
from .snapshot import restore, snapshot

_COLUMN, _ROW = 320, 240


def require_editable(material: bpy.types.Material) -> None:
    """Raise LaminaError for a material whose structure belongs to another file."""
    if material.library is not None:
        raise LaminaError(
            f"material {material.name} is linked from {material.library.filepath}; make it local to edit it, "
            "or a library override to edit its values"
        )
    if material.override_library is not None:
        raise LaminaError(
            f"material {material.name} is a library override: its values can be edited, its layers only after it is made local"
        )


def require_layered(material: bpy.types.Material) -> None:
    """Raise LaminaError for a material without a Lamina stack."""
    if not material.lamina.is_layered:
        raise LaminaError(f"material {material.name} has no Lamina stack; pick a preset first")


def apply_stack(material: bpy.types.Material, stack: Stack, tier: str = DEFAULT_TIER, backend: str | None = None) -> None:
    """Make `material` show `stack`, in place of what it showed. Without `backend` (a key of BACKENDS) its own one stays."""
    require_tier(tier)
    backend_here(backend or material.lamina.backend)
    with changing(material) as tree:
        lamina = material.lamina
        lamina.backend = backend or lamina.backend
        lamina.stack_name, lamina.source, lamina.unknown = stack.name, stack.source, json.dumps(dict(stack.unknown))
        lamina.tier, lamina.schema_version = tier, SCHEMA_VERSION
        lamina.layers.clear()
        lamina.active_layer, lamina.solo = 0, ""
        for layer in stack.layers:
            fill_element(tree, lamina.layers.add(), layer, SCHEMA.layers[layer.kind])
        fill_element(tree, lamina.base, stack.base, SCHEMA.bases[stack.base.kind])


def stack_of(material: bpy.types.Material, hidden: bool = False) -> Stack:
    """The stack that the sockets hold; layers that are not shown only if asked for. A linked socket counts with its own value.

    Raises LaminaError when a socket holds what the schema does not allow.
    """
    require_layered(material)
    lamina = material.lamina
    return Stack.from_dict(
        {
            **json.loads(lamina.unknown or "{}"),
            # older files' sockets mean what they mean now; a newer one's may not
            "schema_version": max(lamina.schema_version, SCHEMA_VERSION),
            "name": lamina.stack_name,
            "source": lamina.source,
            "layers": [read_element(e, kind_of(e)) for e in (lamina.layers if hidden else lamina.shown_layers)],
            "base": read_element(lamina.base, kind_of(lamina.base)),
        },
        f"material {material.name}",
    )


def set_base(material: bpy.types.Material, kind: str) -> None:
    """Replace the base by one of another kind. Parameters that both have keep value and link; others take defaults."""
    require_layered(material)
    lamina = material.lamina
    new_kind, old_kind = SCHEMA.base(kind, f"material {material.name}"), kind_of(lamina.base)
    old = material.node_tree.nodes.get(lamina.base.node)  # gone if somebody deleted it; then this is the way back
    old_values = read_element(lamina.base, old_kind) if old else {}
    kept = [p for p in shown_parameters(new_kind, "") if p.name in old_values]
    base = Stack.from_dict({"base": {"kind": kind, **{p.name: old_values[p.name] for p in kept}}}).base
    with changing(material) as tree:
        fill_element(tree, lamina.base, base, new_kind)
        for parameter in kept:
            if not parameter.is_structural and old.inputs[parameter.label].is_linked:
                source = old.inputs[parameter.label].links[0].from_socket
                tree.links.new(source, node_of(lamina.base).inputs[parameter.label])


def regenerate(material: bpy.types.Material) -> None:
    """Make the shader anew, for instance after somebody deleted its node."""
    require_layered(material)
    with changing(material):
        material.lamina.problem = ""


def make_renderable(material: bpy.types.Material, scene: bpy.types.Scene) -> list[str]:
    """Set up a scene for a layered material's backend. Returns one sentence for each thing that the user should see."""
    if backend_of(material) == OSL:
        return enable_osl(scene)
    told = notice(material.lamina.backend)
    return [f"{material.name} is {told}"] if told else []


@follow
def structure_changed(material: bpy.types.Material, name: str) -> None:
    """What setting the property `name` calls: a metal's sockets, if it concerns them, and the shader follow.

    Update functions cannot report to the user, so an error is kept for the panel to show.
    """
    lamina = material.lamina
    if not lamina.is_layered:
        return
    if name == "name":
        for element in (*lamina.layers, lamina.base):
            show_name(element)
        return
    try:
        if name in ("given", "metal") and lamina.base.kind == CONDUCTOR.name:
            carry_metal(lamina.base, CONDUCTOR)
        regenerate(material)
    except LaminaError as error:
        lamina.problem = str(error)
        print(f"Lamina: {error}")


@contextmanager
def changing(material: bpy.types.Material) -> Iterator[bpy.types.NodeTree]:
    """Change the structure in the block; then the shader follows, or, on an error, all is as before."""
    require_editable(material)
    lamina, tree = material.lamina, node_tree(material)
    before, nodes_before, former = snapshot(lamina), _value_nodes(lamina), backend_of(material)
    try:
        with quietly():
            yield tree
            lamina.problem = ""
            refresh(material)
    except Exception:
        _remove_nodes(tree, _value_nodes(lamina) - nodes_before)
        with quietly():
            restore(lamina, before)
        raise
    _remove_nodes(tree, nodes_before - _value_nodes(lamina))
    if backend_of(material) != former and (told := notice(lamina.backend)):
        print(f"Lamina: {material.name} is {told}")


def _value_nodes(lamina) -> set[str]:
    return {element.node for element in (*lamina.layers, lamina.base)}


def _remove_nodes(tree, names: set[str]) -> None:
    for node in [tree.nodes[name] for name in names if name in tree.nodes]:
        tree.nodes.remove(node)


def refresh(material: bpy.types.Material, settle: bool = False, progress: Callable[[float], None] | None = None) -> None:
    """Make the shader follow the structure, and, where it holds values (tables), the present values.

    Wires the visible layers to a shader that reads them. Tiers that compute the truth first take seconds: until that is
    done, here with `settle` or by `bakes` in the background, the shader is that of the tier analytic. `progress` gets the
    share done and may raise to cancel. Raises LaminaError; then the shader is as before.
    """
    lamina = material.lamina
    backend = backend_here(lamina.backend)
    layers = lamina.shown_layers
    for element in (*layers, lamina.base):
        bring_up_to_date(element)
    owners = {layer_owner(i): node_of(e) for i, e in enumerate(layers)} | {BASE: node_of(lamina.base)}
    waits = lamina.tier in HOLD_VALUES
    wanted = wanted_network(material) if waits else None
    if wanted:
        told = wanted.stack
    elif backend == NODES:
        told = stack_of(material)
    else:
        elements = [structure_dict(e, kind_of(e)) for e in (*layers, lamina.base)]
        told = Stack.from_dict({"layers": elements[:-1], "base": elements[-1]}, f"material {material.name}")
    settled = wanted is None or settle or wanted.is_known()
    network = make_network(told, PROVISIONAL_TIER) if not settled else wanted.make(progress) if waits else make_network(told, lamina.tier)
    if backend == NODES:
        tables = stock_tables(network)
        shader, lamina.lobe_count = group_with(material, tables, owners), closure_count(tables)
    else:
        text = generate(network)
        shader, lamina.lobe_count = script_with(material, text, owners | tangent_owner(material, text.inputs)), text.lobe_count
    holds = backend == NODES or holds_values(network)
    lamina.told = content(told, live_values(material) if backend == OSL else ()) if holds else ""
    lamina.settled = wanted.key if wanted and settled else ""
    others = ", ".join(sorted(tiers_of(network) - {lamina.tier}))
    stand_in = f"{others}, as the tier {lamina.tier} knows no thin films" if others and not waits else ""
    many = f"{lamina.lobe_count} closures, more than the {MAX_CLOSURES} that OptiX takes" if lamina.lobe_count > MAX_CLOSURES else ""
    notes = [network.reason if wanted and settled else stand_in, left_out(told) if backend == NODES else "", many]
    lamina.note = "; ".join(filter(None, notes))
    lamina.schema_version = max(lamina.schema_version, SCHEMA_VERSION)
    error = estimated_error(network)
    lamina.error, lamina.cost = -1.0 if error is None else 100.0 * error, estimated_cost(network)
    _arrange(lamina, shader)


@dataclass(frozen=True)
class Wanted:
    """The network that a material's tier stands for, before it is made."""

    stack: Stack
    tier: str
    live: tuple[tuple[int, str], ...] = ()
    tolerance: float = DEFAULT_TOLERANCE

    @property
    def _options(self) -> dict:
        return {"live": self.live} | ({"tolerance": self.tolerance} if self.tier == AutoNetwork.tier else {})

    @property
    def key(self) -> str:
        return TIERS[self.tier].key(self.stack, **self._options)

    def is_known(self) -> bool:
        return TIERS[self.tier].is_known(self.stack, **self._options)

    def make(self, progress: Callable[[float], None] | None = None):
        return TIERS[self.tier](self.stack, progress=progress, **self._options)


def wanted_network(material: bpy.types.Material) -> Wanted:
    """What a material's tier, one of HOLD_VALUES, wants for its present values. Raises LaminaError for bad values."""
    lamina = material.lamina
    live = live_values(material) if backend_here(lamina.backend) == OSL else ()
    return Wanted(stack_of(material), lamina.tier, live, 0.01 * lamina.tolerance)


def is_stale(material: bpy.types.Material) -> bool:
    """Whether the shader holds values that are no longer those of the sockets."""
    if not material.lamina.told:
        return False
    live = live_values(material) if backend_here(material.lamina.backend) == OSL else ()
    return material.lamina.told != content(stack_of(material), live)


def is_settled(material: bpy.types.Material) -> bool:
    """Whether the shader is what its tier stands for, and not what stands in for it."""
    return material.lamina.tier not in HOLD_VALUES or material.lamina.settled == wanted_network(material).key


def _arrange(lamina, shader) -> None:
    """Layers in a column from the top, to the left of the shader."""
    for row, element in enumerate([*lamina.layers, lamina.base]):
        node = node_of(element)
        place = (shader.location.x - _COLUMN, shader.location.y - row * _ROW)
        mute = row < len(lamina.layers) and not lamina.shows(element)
        # Blender looks through the whole tree after each of these, so only what differs is set
        if tuple(node.location) != place:
            node.location = place
        if node.mute != mute:
            node.mute = mute
        show_name(element)
