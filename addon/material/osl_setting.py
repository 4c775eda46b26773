# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a scene shows Script nodes, whether it should, and the switch.

Lamina's materials are right either way. With OSL their textures and animated values are followed and values show at once.
"""

import bpy

from ...reference_py.errors import Sentence
from ..blender import environment
from .backend import require_osl


def shows_osl(scene: bpy.types.Scene, preferences: bpy.types.Preferences | None = None) -> bool:
    """Whether Cycles shows Script nodes in a scene; without `preferences` whatever the device."""
    return environment.renders_osl() and not _setting_problem(scene) and not (preferences and device_problem(scene, preferences))


def why_stock_nodes(scene: bpy.types.Scene, preferences: bpy.types.Preferences) -> str:
    """Why a scene shows stock nodes and no scripts; empty where it shows scripts."""
    available, reason = environment.osl_available()
    if not available:
        return reason
    return reason_against(scene, preferences) or _setting_problem(scene)


def reason_against(scene: bpy.types.Scene, preferences: bpy.types.Preferences) -> str:
    """Why a scene should be left without OSL: it would lose something, or gain nothing; empty where it should have OSL."""
    if scene.render.engine != "CYCLES":
        return Sentence("the render engine is not Cycles")
    return device_problem(scene, preferences) or _would_break(scene)


def device_problem(scene: bpy.types.Scene, preferences: bpy.types.Preferences) -> str:
    """Why a scene's render device would ignore Script nodes; empty when it does not."""
    cycles = preferences.addons.get("cycles")
    device = cycles.preferences.compute_device_type if cycles else "NONE"
    if scene.cycles.device == "GPU" and device not in ("NONE", "OPTIX"):
        return Sentence("{device} devices cannot run Open Shading Language", device=device)
    return ""


def _setting_problem(scene) -> str:
    if scene.render.engine != "CYCLES":
        return Sentence("the render engine is not Cycles")
    return "" if scene.cycles.shading_system else Sentence("Open Shading Language is switched off")


def _would_break(scene) -> str:
    """What in a scene Cycles renders wrong with OSL, whoever's material it is (seen in 4.5, 5.2 and 5.3)."""
    for layer in scene.view_layers:
        if layer.aovs:
            return Sentence("the shader AOV {aov} would be black under Open Shading Language", aov=layer.aovs[0].name)
    for material in {slot.material for item in scene.objects for slot in item.material_slots if slot.material is not None}:
        if material.node_tree is not None and _has_mixed_multiscatter(material.node_tree, set()):
            return Sentence("{material} mixes a Multiscatter GGX node, which would be darker under Open Shading Language", material=material.name)
    return ""


def _has_mixed_multiscatter(tree, seen: set[str]) -> bool:
    """Whether a Glossy node with Multiscatter GGX is mixed with another closure by a factor that is neither 0 nor 1."""
    seen.add(tree.name_full)
    for node in tree.nodes:
        group = getattr(node, "node_tree", None)
        if group is not None and group.name_full not in seen and _has_mixed_multiscatter(group, seen):
            return True
        if node.bl_idname == "ShaderNodeMixShader" and (node.inputs[0].is_linked or 0.0 < node.inputs[0].default_value < 1.0):
            for link in (link for socket in node.inputs[1:] for link in socket.links):
                if getattr(link.from_node, "distribution", "") == "MULTI_GGX" and link.from_node.bl_idname == "ShaderNodeBsdfAnisotropic":
                    return True
    return False


def prefer_osl(scene: bpy.types.Scene, preferences: bpy.types.Preferences) -> list[Sentence]:
    """Switch OSL on where nothing speaks against it. Returns one sentence per thing that was changed, for the user to see."""
    if not environment.osl_available()[0] or reason_against(scene, preferences):
        return []
    return enable_osl(scene)


def enable_osl(scene: bpy.types.Scene) -> list[Sentence]:
    """Switch a scene to Cycles with OSL, whatever speaks against it. Returns one sentence per thing that was changed."""
    require_osl()
    notices = []
    if scene.render.engine != "CYCLES":
        notices.append(Sentence("render engine of {scene} set to Cycles (was {engine})", scene=scene.name, engine=scene.render.engine))
        scene.render.engine = "CYCLES"
    if not scene.cycles.shading_system:
        notices.append(Sentence("Open Shading Language switched on in {scene}", scene=scene.name))
        scene.cycles.shading_system = True
    return notices
