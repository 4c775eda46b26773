# SPDX-License-Identifier: GPL-3.0-or-later
"""What is wrong with a material, as data, and how each thing is mended with one click.

`find` looks and changes nothing; `mend` does what a finding offers. It is quick enough for a panel to draw.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from math import isfinite

import bpy

from ...reference_py.errors import LaminaError, Sentence
from ...reference_py.material.schema import COLOR, FLOAT, Parameter
from ..blender import environment
from ..blender.texture_limit import texture_limit
from ..jobs import bakes
from ..material import state
from ..material.backend import AUTO, NODES, OSL, branches_here
from ..material.elements import find_node, kind_of, node_of, outside_rec709
from ..material.entry import feeds, output_after
from ..material.hand_over import MIX, usd_takes
from ..material.kind_groups import KIND_KEY, hands_on
from ..material.live_values import live_in_nodes, live_values, resting_values, what_moves
from ..material.means import mean_name
from ..material.osl_setting import device_problem, why_stock_nodes
from ..material.reading import require_editable, require_layered, stack_of
from ..material.record import changed_values, recorded
from ..material.roles import EEVEE_OUTPUT, ROLE, SWITCH, TEST, node_with
from ..material.script_node import is_untouched
from ..material.shader_node import shader_of, surface_of
from ..shader.inputs import BASE, layer_owner
from ..shader.nodes.node_groups import is_untouched as group_is_untouched
from ..shader.nodes.node_groups import tables_size
from .check_mends import MENDS
from .lost_images import lost_images
from .tangents import without_uv_map

# A note is of what does not show in this scene.
ERROR, WARNING, NOTE = "ERROR", "INFO", "NOTE"

# code: how bad it is, what is wrong, and the button that mends it (empty: nothing here can)
CODES = {
    "not_editable": (WARNING, "{reason}", ""),
    "backend_missing": (ERROR, "{reason}", "Use Automatic"),
    "osl_missing": (ERROR, "Black: the shader is an OSL script alone, and {reason}", "Make It of Stock Nodes"),
    "script_alone": (ERROR, "Black: the shader is an OSL script alone, and {reason}", "Make Stock Nodes Too"),
    "one_branch": (WARNING, "{missing}", "Make Both"),
    "without_osl": (WARNING, "Shown by stock nodes, as {reason}; OSL would add {gain}", "Use Cycles with OSL"),
    "stock_behind": (WARNING, "The stock nodes are behind: {behind}", "Update"),
    "output_hides": (WARNING, "The output {output}, which is for {renderer} alone, shows something else than Lamina", "Let Lamina Show"),
    "output_rests": (WARNING, "The active output {output} shows something else than Lamina", "Let Lamina Show"),
    "shader_gone": (ERROR, "The shader node was deleted", "Make It Anew"),
    "shader_unused": (ERROR, "The shader feeds no material output", "Link It"),
    "shader_muted": (ERROR, "The shader node is muted", "Unmute"),
    "shader_edited": (WARNING, "The shader was edited by hand; its next change will replace it", "Make It Anew"),
    "shader_unlinked": (ERROR, "{count} values do not reach the shader, the first is {first}", "Link Them"),
    "exported_shows": (ERROR, "What exporters find is mixed into the picture: the factor of its Mix Shader is not 0", "Set It to 0"),
    "not_followed": (ERROR, "{reason}", ""),
    "shader_stale": (WARNING, "The shader holds old values", "Update"),
    "not_baked": (WARNING, "Shown as a preview; its final look is not computed: {reason}", "Compute Again"),
    "node_gone": (ERROR, "The node of {layer} was deleted; its values are known", "Make It Anew"),
    "node_lost": (ERROR, "The node of {layer} was deleted", "Make It Anew with Default Values"),
    "node_muted": (ERROR, "The node of {layer} is muted", "Unmute"),
    "node_shared": (ERROR, "{layer} has the same node as a layer above it", "Give It Its Own"),
    "node_spare": (WARNING, "No layer has the layer node {node}", "Remove It"),
    "group_broken": (ERROR, "The node group {group} of {layer} does not hand its values on; {count} nodes share it", "Replace the Group"),
    "link_broken": (ERROR, "{layer}: the link to {label} is broken", "Remove the Link"),
    "link_muted": (WARNING, "{layer}: the link to {label} is muted", "Unmute"),
    "image_missing": (ERROR, "{layer}: {label} has a texture without an image", "Remove the Link"),
    "image_gone": (ERROR, "{layer}: {label} reads the image {image}, whose file is gone: {path} (File > External Data > Find Missing Files)", ""),
    "tables_shrunk": (WARNING, "Simplify's texture limit of {limit} px shrinks the tables of the stock nodes, which are {size} px: their values are wrong", "Raise the Limit"),
    "texture_ignored": (WARNING, "{layer}: {label} has a texture or animation, which stock nodes cannot follow: they show {shown}", ""),
    "value_rests": (WARNING, "{layer}: the texture or animation of {label} has no effect, as it is given by {given}", ""),
    "usd_misled": (WARNING, "USD export takes the node {node}, which was there before; delete it if it is of no use", ""),
    "uv_map_missing": (WARNING, "{object} has no UV map for the direction of brushing: give it one, or set the node Lamina Tangent to Radial", ""),
    "out_of_gamut": (WARNING, "{layer}: {label} lies outside linear Rec.709, in which the model computes, and is limited to it", ""),
    "out_of_range": (ERROR, "{layer}: {label} is {value}; allowed is {allowed}", "Bring into Range"),
}  # fmt: skip


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong: its code, the words of its sentence, and what it is about, for `mend`."""

    code: str
    words: dict = field(default_factory=dict)
    element: str = ""
    label: str = ""
    is_note: bool = False

    @property
    def key(self) -> str:
        """Names the finding among those of one material."""
        return f"{self.code}/{self.element}/{self.label}"

    @property
    def level(self) -> str:
        return NOTE if self.is_note else CODES[self.code][0]

    @property
    def mending(self) -> str:
        """What the button says that mends it; empty where none does."""
        return "" if self.words.get("is_final") else CODES[self.code][2]

    def text(self, translate=str) -> str:
        """The sentence; `translate` gets its template."""
        return self.sentence().told(translate)

    def sentence(self) -> Sentence:
        return Sentence(CODES[self.code][1], **self.words)


def find(material: bpy.types.Material, scene: bpy.types.Scene, preferences: bpy.types.Preferences) -> list[Finding]:
    """Everything that is wrong with a layered material, the worst first. Raises LaminaError for one without layers."""
    require_layered(material)
    try:
        require_editable(material)
        found = []
    except LaminaError as error:
        found = [Finding("not_editable", {"reason": error.sentence})]
    if material.node_tree is None:
        return found
    found += [
        *_machine(material, scene, preferences),
        *_elements(material),
        *_shader(material),
        *_stock(material, scene, not why_stock_nodes(scene, preferences)),
    ]
    problem = material.lamina.problem_sentence
    if problem:  # the reason why the shader is stale, and what an update fails by
        found = [f for f in found if f.code != "shader_stale"]
    if problem and problem not in [f.text() for f in found]:
        found.append(Finding("not_followed", {"reason": problem}))
    if item := without_uv_map(material, scene):
        found.append(Finding("uv_map_missing", {"object": item.name}))
    if before := usd_takes(material):
        found.append(Finding("usd_misled", {"node": before.name}, before.name, is_note=True))
    return sorted(found, key=lambda f: (ERROR, WARNING, NOTE).index(f.level))


def mend(material: bpy.types.Material, scene: bpy.types.Scene, preferences: bpy.types.Preferences, key: str) -> None:
    """Mend the finding of this key. Raises LaminaError where there is none any more, or nothing can be done."""
    finding = next((f for f in find(material, scene, preferences) if f.key == key), None)
    if finding is None:
        raise LaminaError("there is no finding {key!r} any more", key=key)
    if not finding.mending:
        raise LaminaError("this cannot be mended here: {finding}", finding=finding.sentence())
    require_editable(material)
    MENDS[finding.code](material, scene, finding)


def _machine(material, scene, preferences) -> Iterator[Finding]:
    """What this Blender or its scene lacks, and what that costs."""
    try:
        branches_here(material.lamina.backend)
    except LaminaError as error:
        yield Finding("backend_missing", {"reason": error.sentence})
        return
    script, stock = node_with(material, OSL), node_with(material, NODES)
    reason = why_stock_nodes(scene, preferences)
    if reason and script is not None and stock is None:
        yield Finding("script_alone" if environment.osl_available()[0] else "osl_missing", {"reason": reason})
    elif script is not None and stock is not None and reason:
        gain = _ignored_names(material)
        words = {"reason": reason, "gain": _gain(gain)}
        cannot = not environment.osl_available()[0] or (scene.render.engine == "CYCLES" and device_problem(scene, preferences))
        yield Finding("without_osl", words | {"is_final": bool(cannot)}, is_note=not gain)
    if (script is None) != (stock is None) and material.lamina.backend == AUTO and not (reason and stock is None):
        if stock is None:
            yield Finding("one_branch", {"missing": Sentence("Made by an older Lamina: where OSL does not run, it renders black")})
        elif environment.osl_available()[0]:
            yield Finding("one_branch", {"missing": Sentence("Made in a Blender without OSL: the OSL script is still missing")})


def _gain(names: list[Sentence]) -> Sentence:
    if len(names) > 1:
        return Sentence("{first} and {count} more", first=names[0], count=len(names) - 1)
    return names[0] if names else Sentence("nothing to this picture")


def _elements(material) -> Iterator[Finding]:
    lamina, tree = material.lamina, material.node_tree
    links, seen = _links_into(tree), set()
    sound = cache(hands_on)
    for element in (*lamina.layers, lamina.base):
        name = {"layer": element.name}
        node = find_node(element)
        if node is None:
            yield Finding("node_gone" if recorded(element) else "node_lost", name, element.node)
            continue
        if node.name in seen:
            yield Finding("node_shared", name, element.node)
        seen.add(node.name)
        is_shown = element == lamina.base or lamina.shows(element)
        if node.mute and is_shown:
            yield Finding("node_muted", name, element.node)
        group = node.node_tree
        if group is None or not sound(group, kind_of(element)):
            words = {"group": group.name if group else "?", "count": group.users if group else 1}
            yield Finding("group_broken", name | words, element.node)
            continue
        yield from _values(element, node, is_shown, links)
        for parameter in resting_values(element):
            about = {"label": Sentence(parameter.label), "given": Sentence(kind_of(element).given_label(element.given))}
            yield Finding("value_rests", name | about, element.node, parameter.label)
    for node in tree.nodes:
        if node.bl_idname == "ShaderNodeGroup" and node.name not in seen and _is_value_node(node):
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
        about = {"layer": element.name, "label": Sentence(parameter.label)}
        into = links.get(socket.as_pointer(), ())
        for link in into:
            if not link.is_valid or link.from_socket.type == "SHADER":
                yield Finding("link_broken", about, element.node, parameter.label)
            elif link.is_muted:
                yield Finding("link_muted", about, element.node, parameter.label)
            elif is_shown and (lost := list(lost_images(link.from_node))):
                known = next((each for each in lost if each.image), None)  # its link is work that a removal would lose, whatever else is fed by it
                code, words = ("image_gone", {"image": known.image.name, "path": known.path}) if known else ("image_missing", {})
                yield Finding(code, about | words, element.node, parameter.label)
        if not into and parameter.type == COLOR and outside_rec709(socket):
            yield Finding("out_of_gamut", about, element.node, parameter.label)
        if not into and (wrong := out_of_range(socket.default_value, parameter)):
            yield Finding("out_of_range", about | _wrong(element, parameter, wrong), element.node, parameter.label)


def _wrong(element, parameter: Parameter, value: str) -> dict:
    """Words of a value out of range. Of one that is animated nothing here can be mended: the next frame has it again."""
    if parameter.name in what_moves(element):
        return {"value": Sentence("{value}, by its driver or keyframes", value=value), "allowed": parameter.allowed, "is_final": True}
    return {"value": value, "allowed": parameter.allowed}


def out_of_range(value, parameter: Parameter) -> str:
    """The component of a socket's value that the schema does not allow, as text; empty if there is none."""
    numbers = [value] if parameter.type == FLOAT else list(value)[:3]
    slack = 1e-6 * max(abs(parameter.minimum), abs(parameter.maximum))  # a socket holds float32
    wrong = [v for v in numbers if not isfinite(v) or not parameter.minimum - slack <= v <= parameter.maximum + slack]
    return f"{wrong[0]:.4g}" if wrong else ""


def _shader(material) -> Iterator[Finding]:
    script, stock, switch = (node_with(material, role) for role in (OSL, NODES, SWITCH))
    branches = [node for node in (script, stock) if node is not None]
    if not branches or any(_code(node) is None for node in branches):
        yield Finding("shader_gone")
        return
    if not _reaches_output(surface_of(material).node, set()):
        yield Finding("shader_unused")
    else:
        yield from _hiding(material.node_tree, surface_of(material).node)
    for node in (*branches, switch):
        if node is not None and node.mute:
            yield Finding("shader_muted", {}, node.name)
    if not (script is None or is_untouched(script.script.as_string())) or not (stock is None or group_is_untouched(stock.node_tree)):
        yield Finding("shader_edited")
    lost = [name for node in branches for name in _unlinked(material, node)]
    if switch is not None:
        test = node_with(material, TEST)
        sources = zip((*switch.inputs, *(test.inputs[:1] if test is not None else ())), (test, stock, script, script))
        lost += [socket.name for socket, source in sources if not socket.is_linked or socket.links[0].from_node != source]
    if lost:
        yield Finding("shader_unlinked", {"count": len(lost), "first": lost[0]})
    mix = node_with(material, MIX)
    if mix is not None and not mix.mute and (mix.inputs[0].is_linked or mix.inputs[0].default_value != 0.0):
        yield Finding("exported_shows")
    if reason := bakes.failed(material):
        yield Finding("not_baked", {"reason": reason})
    try:
        if state.is_stale(material):
            yield Finding("shader_stale")
    except LaminaError:
        pass  # what is wrong with the values is a finding of its own


def _code(node):
    return node.script if node.bl_idname == "ShaderNodeScript" else node.node_tree


def _hiding(tree, surface) -> Iterator[Finding]:
    """Outputs that show something else in place of Lamina's: those for one renderer alone, or another active one."""
    if output_after(surface) is None:
        return
    shown = {renderer: tree.get_output_node(renderer) for renderer in ("CYCLES", "EEVEE")}
    others = {renderer: output for renderer, output in shown.items() if output is not None and output.get(ROLE) != EEVEE_OUTPUT and not feeds(surface, output)}
    for renderer, output in others.items():
        if output.target == renderer:
            yield Finding("output_hides", {"output": output.name, "renderer": renderer.title()}, output.name)
    if active := next((output for output in others.values() if output.target == "ALL"), None):
        yield Finding("output_rests", {"output": active.name}, active.name)


def _stock(material, scene, osl_shows: bool) -> Iterator[Finding]:
    """What the stock nodes do not show, a note where a script is what shows."""
    stock = node_with(material, NODES)
    if stock is None:
        return
    beside = node_with(material, OSL) is not None
    if stock.node_tree is not None and (size := tables_size(stock.node_tree)) > (limit := texture_limit(scene)):
        yield Finding("tables_shrunk", {"limit": int(limit), "size": size}, is_note=beside and osl_shows)
    try:
        # of a bake that is on its way, both branches stand in
        if beside and shader_of(material) == node_with(material, OSL) and state.is_settled(material) and state.lags(material):
            changed = changed_values(material)
            behind = Sentence("they stand in for what the script shows")
            if changed:
                behind = Sentence("{count} values changed since, the first is {first}", count=len(changed), first=changed[0])
            yield Finding("stock_behind", {"behind": behind}, is_note=osl_shows)
        yield from _ignored(material, beside and osl_shows)
    except LaminaError:
        pass  # what is wrong with the values is a finding of its own


def _reaches_output(node, seen: set[str]) -> bool:
    seen.add(node.name)
    followers = [link.to_node for socket in node.outputs for link in socket.links]
    return any(n.bl_idname in ("ShaderNodeOutputMaterial", "NodeGroupOutput") or (n.name not in seen and _reaches_output(n, seen)) for n in followers)


def _unlinked(material, shader) -> list[str]:
    """Inputs of a branch that do not come from the layer that they are named for."""
    lamina = material.lamina
    owners = {layer_owner(i): layer for i, layer in enumerate(lamina.shown_layers)} | {BASE: lamina.base}
    found = {owner: (e, node) for owner, e in owners.items() if (node := find_node(e)) is not None}
    expected = {owner + p.osl_name: (node.name, p.label) for owner, (e, node) in found.items() for p in kind_of(e).sockets}
    links, lost = _links_into(material.node_tree), []
    for socket in shader.inputs:
        wanted = expected.get(socket.identifier) or expected.get(socket.name)
        into = [(k.from_node.name, k.from_socket.name) for k in links.get(socket.as_pointer(), ()) if not k.is_muted]
        if wanted is not None and into != [wanted]:
            lost.append(socket.name)
    return lost


def _ignored(material, is_note: bool) -> Iterator[Finding]:
    lamina = material.lamina
    shown = lamina.shown_layers
    followed = live_in_nodes(material, stack_of(material))
    for place in live_values(material):
        if place in followed:
            continue
        element = lamina.base if place.layer is None else shown[place.layer]
        label = kind_of(element).parameter(place.name).label
        mean = mean_name(node_of(element).inputs[label])
        taken = Sentence("the mean of {mean}", mean=mean) if mean else Sentence("its value at this frame")
        yield Finding("texture_ignored", {"layer": element.name, "label": Sentence(label), "shown": taken}, node_of(element).name, label, is_note)


def _ignored_names(material) -> list[Sentence]:
    """What stock nodes leave out, in words."""
    try:
        return [Sentence("{label} of {layer}", label=f.words["label"], layer=f.words["layer"]) for f in _ignored(material, True)]
    except LaminaError:
        return []
