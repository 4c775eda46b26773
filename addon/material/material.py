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

from ...reference_py.errors import LaminaError, Sentence
from ...reference_py.lobes.cache import stack_key
from ...reference_py.lobes.made import Made
from ...reference_py.lobes.methods import DEFAULT_METHOD, MAX_CLOSURES, holds_values, make_lobe_set, method_of, provisional
from ...reference_py.lobes.methods.not_bakeable import scatters
from ...reference_py.lobes.methods.summary import estimated_cost, estimated_error, has_tables, live_methods
from ...reference_py.material.schema import CONDUCTOR, SCHEMA, SCHEMA_VERSION
from ...reference_py.material.stack import Stack
from ..blender.versions import node_tree
from ..shader.inputs import BASE, layer_owner
from ..shader.nodes.node_groups import needs_eevee_output
from ..shader.nodes.stock_nodes import closure_count, eevee_stock_tables, stock_tables
from ..shader.osl.generate import generate
from .backend import AUTO, NODES, OSL, branches_here, notice
from .base_kind import change_kind, lost_by_change
from .eevee_output import follow_eevee_output
from .elements import bring_up_to_date, carry_metal, fill_element, find_node, kind_of, node_of, show_name, structure_dict
from .hand_over import follow_hand_over
from .layout import arrange
from .live_values import live_in_nodes, live_values
from .masks import give_masks, remove_with_masks
from .osl_setting import prefer_osl
from .properties import quietly
from .reading import measure_means, require_editable, require_layered, stack_of
from .record import keep_record, keep_structure, take_structure
from .roles import EEVEE, node_with
from .shader_node import Surface, backend_of, replacing_branches, shading_of, surface_of
from .snapshot import restore, snapshot
from .state import HELD_VALUES, SETTLED, note_of, wanted_lobes, wanted_stock


def apply_stack(
    material: bpy.types.Material,
    stack: Stack,
    tier: str = DEFAULT_METHOD,
    backend: str | None = None,
    finish: Callable[[bpy.types.Material], None] | None = None,
    settle: bool = False,
    progress: Callable[[float], None] | None = None,
) -> None:
    """Make `material` show `stack`, in place of what it showed. Without `backend` (a key of BACKENDS) its own one stays.

    `finish` may link textures to the new nodes before the shader is made; `settle` and `progress` are those of `refresh`.
    """
    method_of(tier)
    branches_here(backend or material.lamina.backend)
    with changing(material, settle, progress) as tree:
        lamina = material.lamina
        lamina.backend = backend or lamina.backend
        lamina.stack_name, lamina.source, lamina.unknown = stack.name, stack.source, json.dumps(dict(stack.unknown))
        lamina.tier, lamina.schema_version = tier, SCHEMA_VERSION
        lamina.layers.clear()
        lamina.solo = ""
        for layer in stack.layers:
            fill_element(tree, lamina.layers.add(), layer, SCHEMA.layers[layer.kind])
        fill_element(tree, lamina.base, stack.base, SCHEMA.bases[stack.base.kind])
        if finish is not None:
            finish(material)
        give_masks(tree, [*lamina.layers, lamina.base], [*stack.layers, stack.base])


def set_base(material: bpy.types.Material, kind: str) -> list[tuple[str, str]]:
    """Replace the base by one of another kind, see `change_kind`. Returns what is lost, see `lost_by_change`."""
    require_layered(material)
    base, new_kind = material.lamina.base, SCHEMA.base(kind, Sentence("material {material}", material=material.name))
    is_there = find_node(base) is not None  # gone if somebody deleted it; then this is the way back
    if is_there and base.kind == kind:
        return []
    lost = lost_by_change(base, new_kind) if is_there else []
    with changing(material) as tree:
        change_kind(tree, base, new_kind)
    return lost


def regenerate(material: bpy.types.Material) -> None:
    """Make the shader anew, for instance after somebody deleted its node."""
    require_layered(material)
    with changing(material):
        pass


def make_renderable(material: bpy.types.Material, scene: bpy.types.Scene) -> list[Sentence]:
    """Switch OSL on in a scene where nothing speaks against it. Returns one sentence for each thing that the user should see."""
    if backend_of(material) == OSL:
        return prefer_osl(scene, bpy.context.preferences)
    sentence = notice(material.lamina.backend)
    return [Sentence("{material} is {sentence}", material=material.name, sentence=sentence)] if sentence else []


def structure_changed(group: bpy.types.PropertyGroup, name: str) -> None:
    """What setting the property `name` of a material's or an element's group calls: a metal's sockets, if it concerns them, and the shader follow.

    In a material of another file all properties become again what they were. Update functions cannot report to the user, so an error is kept for the panel to show.
    """
    material = group.id_data
    lamina = material.lamina
    if not lamina.is_layered:
        return
    try:
        require_editable(material)
    except LaminaError as error:
        lamina.keep_problem(None if take_structure(material) else error)  # older files have nothing to put it back from
        print(f"Lamina: {error}")
        return
    if name in ("name", "stack_name"):
        for element in (*lamina.layers, lamina.base):
            show_name(element)
        keep_structure(material)
        return
    try:
        if name in ("given", "metal") and group.kind == CONDUCTOR.name:
            carry_metal(group, CONDUCTOR)
        regenerate(material)
    except LaminaError as error:
        lamina.keep_problem(error)
        print(f"Lamina: {error}")


@contextmanager
def changing(material: bpy.types.Material, settle: bool = False, progress: Callable[[float], None] | None = None) -> Iterator[bpy.types.NodeTree]:
    """Change the structure in the block; then the shader follows as `refresh` makes it, or, on an error, all is as before."""
    require_editable(material)
    lamina, tree = material.lamina, node_tree(material)
    before, nodes_before, former = snapshot(lamina), _value_nodes(lamina), backend_of(material)
    try:
        with quietly():
            yield tree
            refresh(material, settle, progress)
    except Exception:
        remove_with_masks(tree, _value_nodes(lamina) - nodes_before)
        with quietly():
            restore(lamina, before)
        raise
    remove_with_masks(tree, nodes_before - _value_nodes(lamina))
    if backend_of(material) != former and (sentence := notice(lamina.backend)):
        print(f"Lamina: {material.name} is {sentence}")


def _value_nodes(lamina) -> set[str]:
    """Present names of the nodes of all elements."""
    return {node.name for element in (*lamina.layers, lamina.base) if (node := find_node(element)) is not None}


@dataclass(frozen=True)
class _Shown:
    """What a material's branches are made of now: a lobe set, its stack, and the key of what was computed.

    The key is empty where nothing is computed, or not yet: then a method that takes no time stands in.
    """

    made: Made
    stack: Stack
    key: str = ""
    follows: bool = False
    """Whether its shader follows live values that stock nodes do not."""


def refresh(material: bpy.types.Material, settle: bool = False, progress: Callable[[float], None] | None = None) -> None:
    """Make both branches follow the structure, and, where they hold values (tables), the present values.

    Wires the visible layers to a shader that reads them. Tiers that compute the truth first take seconds: until that is
    done, here with `settle` or by `bakes` in the background, the shader is that of the tier analytic. `progress` gets the
    share done and may raise to cancel. Raises LaminaError; then the material is as before.
    """
    require_editable(material)
    owners = _owners(material)
    measure_means(material)
    shown = _shown(material, settle, progress)
    with replacing_branches(material) as surface:
        _write_branches(surface, material, shown, owners, settle)
    _keep_facts(material.lamina, shown)
    hand_over(material, settle)
    _follow_eevee(material)
    arrange(material)
    if material.lamina.problem:
        material.lamina.keep_problem(None)
    keep_record(material)


def _shown(material: bpy.types.Material, settle: bool, progress: Callable[[float], None] | None) -> _Shown:
    lamina = material.lamina
    if not holds_values(lamina.tier):
        stack = _structure(material) if OSL in branches_here(lamina.backend) else stack_of(material)
        return _Shown(make_lobe_set(stack, lamina.tier), stack, follows=True)
    wanted = wanted_lobes(material)
    follows = wanted.live != live_in_nodes(material, wanted.stack)
    # where nobody waits, what would stand in takes half as long as what it stands in for
    if settle or wanted.is_cached() or (bpy.app.background and scatters(wanted.stack) and not wanted.live):
        return _Shown(wanted.make(progress), wanted.stack, wanted.key, follows)
    return _Shown(provisional(wanted.stack), wanted.stack, follows=follows)


def _write_branches(surface: Surface, material: bpy.types.Material, shown: _Shown, owners: dict[str, bpy.types.Node], settle: bool) -> None:
    lamina, branches = material.lamina, branches_here(material.lamina.backend)
    if OSL in branches:
        shader = generate(shown.made)
        _note(surface.script(shader, owners), stack_key(shown.stack, live_values(material)) if has_tables(shown.made) else "", shown.key)
        lamina.lobe_count = shader.lobe_count
    elif lamina.backend == AUTO and _script_serves(material, shown.made):
        surface.keep(OSL)
    if NODES in branches:
        same = OSL not in branches or not shown.follows
        tables = _make_stock(surface, material, owners, *((shown.made, shown.key) if same else _stock_lobes(material, settle)))
        lamina.lobe_count = lamina.lobe_count if OSL in branches else closure_count(tables)


def _keep_facts(lamina, shown: _Shown) -> None:
    """Keep what the panel says of a shader: why it is what it is, its error and cost."""
    made, notes = shown.made, []
    if shown.key:
        notes.append(made.reason)
    elif not holds_values(lamina.tier) and (others := ", ".join(sorted(live_methods(made) - {lamina.tier}))):
        notes.append(f"{others}, as the tier {lamina.tier} knows no thin films")
    if lamina.lobe_count > MAX_CLOSURES:
        notes.append(f"{lamina.lobe_count} closures, more than the {MAX_CLOSURES} that OptiX takes")
    lamina.note = "; ".join(filter(None, notes))
    lamina.schema_version = max(lamina.schema_version, SCHEMA_VERSION)
    osl = OSL in branches_here(lamina.backend)
    error = estimated_error(made, osl)
    lamina.error, lamina.cost = -1.0 if error is None else 100.0 * error, estimated_cost(made, osl)


def hand_over(material: bpy.types.Material, settle: bool = False) -> None:
    """Make what exporters find follow, where there is a shader. Values that the schema does not allow leave it as it is, and Check tells them."""
    closure = shading_of(material)
    try:
        stack = stack_of(material)
    except LaminaError:
        return
    if closure is not None:
        follow_hand_over(material, closure, stack, settle)


def refresh_stock(material: bpy.types.Material, settle: bool = False) -> None:
    """Make the stock nodes beside a script follow the present values. Raises LaminaError; then the material is as before.

    Of tiers that compute first they are those of the tier analytic where nothing is computed yet, but for `settle`.
    """
    require_editable(material)
    measure_means(material)
    owners, lobes = _owners(material), _stock_lobes(material, settle)
    with replacing_branches(material) as surface:
        surface.keep(OSL)
        _make_stock(surface, material, owners, *lobes)
    _follow_eevee(material)
    keep_record(material)


def _follow_eevee(material: bpy.types.Material) -> None:
    """Bring EEVEE's output up to date; where it cannot have one, make the stock nodes anew as it needs them."""
    follow_eevee_output(material, surface_of(material))
    stock = node_with(material, NODES)
    if stock is not None and node_with(material, EEVEE) is None and needs_eevee_output(stock.node_tree):
        refresh_stock(material)


def _stock_lobes(material: bpy.types.Material, settle: bool) -> tuple[Made | None, str]:
    """What the stock nodes beside a script are to hold, and its key; nothing where that is not computed, or not yet."""
    wanted = wanted_stock(material)
    return (wanted.make(), wanted.key) if wanted is not None and (settle or wanted.is_cached()) else (None, "")


def _owners(material) -> dict[str, bpy.types.Node]:
    """The nodes of the values, which get what a later version than theirs has."""
    lamina = material.lamina
    layers = lamina.shown_layers
    for element in (*layers, lamina.base):
        bring_up_to_date(element)
    return {layer_owner(i): node_of(e) for i, e in enumerate(layers)} | {BASE: node_of(lamina.base)}


def _structure(material) -> Stack:
    """The stack without its values."""
    lamina = material.lamina
    *layers, base = [structure_dict(e, kind_of(e)) for e in (*lamina.shown_layers, lamina.base)]
    return Stack.from_dict({"layers": layers, "base": base}, Sentence("material {material}", material=material.name))


def _make_stock(surface: Surface, material, owners, lobe_set, key: str):
    """The branch of stock nodes, of a lobe set for the present values; without one, of a live tier's. Returns its tables."""
    stack = stack_of(material)
    if lobe_set is None:
        tier = material.lamina.tier
        lobe_set = provisional(stack) if holds_values(tier) else make_lobe_set(stack, tier)
    tables = stock_tables(lobe_set)
    surface.stock(eevee_stock_tables(lobe_set, tables), owners, EEVEE)
    _note(surface.stock(tables, owners), stack_key(stack, live_in_nodes(material, stack)), key)
    return tables


def _note(node: bpy.types.Node, held_values: str, settled: str) -> None:
    """Write on a branch's node what it was made for."""
    node[HELD_VALUES], node[SETTLED] = held_values, settled


def _script_serves(material, lobe_set) -> bool:
    """Whether the script of a material is right for its present values, in a Blender that cannot make another."""
    script = node_with(material, OSL)
    if script is None or script.script is None:
        return False
    if held_values := note_of(script, HELD_VALUES, material):
        return held_values == stack_key(stack_of(material), live_values(material))
    return script.script.as_string() == generate(lobe_set).text
