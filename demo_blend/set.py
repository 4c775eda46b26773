# SPDX-License-Identifier: GPL-3.0-or-later
"""What all demo scenes share: the studio without its ball, and where things stand in it."""

import bpy
import numpy as np
from mathutils import Vector

from ..addon.material.elements import node_of
from ..addon.material.material import refresh
from ..addon.rendering.settings import add_object, remove_scene
from ..addon.rendering.studio import build_ball_scene

SIZE = (960, 600)


def stage(
    name: str,
    camera: tuple[float, float, float],
    target: tuple[float, float, float],
    lens: float = 85.0,
    samples: int = 96,
    paper: tuple[float, float, float] | None = None,
) -> bpy.types.Scene:
    """A new file with the studio's backdrop and lights, which are set for things of 2 m about the origin.

    `paper` is the backdrop's linear color, unless it stays the studio's dark grey.
    """
    bpy.ops.wm.read_factory_settings(use_empty=True)
    studio = build_ball_scene(name=name, tile_px=SIZE, samples=samples)
    for scene in [s for s in bpy.data.scenes if s != studio.scene]:
        remove_scene(scene)
    bpy.data.batch_remove([studio.ball, studio.scene.objects["Stand"]])
    bpy.data.orphans_purge(do_recursive=True)
    if paper is not None:
        backdrop = studio.scene.objects["Backdrop"].data.materials[0]
        backdrop.node_tree.nodes["Diffuse BSDF"].inputs["Color"].default_value = (*paper, 1.0)
    look(studio.scene, camera, target, lens)
    return studio.scene


def look(scene: bpy.types.Scene, camera: tuple[float, float, float], target: tuple[float, float, float], lens: float) -> None:
    """Point the scene's camera."""
    scene.camera.location = camera
    scene.camera.rotation_euler = (Vector(target) - Vector(camera)).to_track_quat("-Z", "Y").to_euler()
    scene.camera.data.lens, scene.camera.data.sensor_fit = lens, "AUTO"


def put(
    scene: bpy.types.Scene,
    name: str,
    mesh: bpy.types.Mesh,
    materials: bpy.types.Material | list[bpy.types.Material],
    location=(0.0, 0.0, 0.0),
    turn_deg=(0.0, 0.0, 0.0),
    scale: float = 1.0,
) -> bpy.types.Object:
    """New object of a mesh, which may be shared: it gets the materials of its first object, further ones hold other materials themselves."""
    item = add_object(scene, name, mesh)
    wanted = materials if isinstance(materials, list) else [materials]
    if not mesh.materials:
        for material in wanted:
            mesh.materials.append(material)
    for slot, material in zip(item.material_slots, wanted):
        if slot.material != material:
            slot.link, slot.material = "OBJECT", material
    item.location, item.rotation_euler, item.scale = location, np.radians(turn_deg), (scale,) * 3
    return item


def per_object(material: bpy.types.Material, element, label: str, attribute: str) -> None:
    """Let an object's own property `attribute` give a value of a layer or the base, so that one material serves many."""
    link_attribute(material.node_tree, node_of(element).inputs[label], attribute)
    refresh(material, settle=True)


def link_attribute(tree: bpy.types.NodeTree, socket: bpy.types.NodeSocket, attribute: str) -> None:
    """Let an object's own property `attribute`, a number or a color, feed a socket."""
    node = tree.nodes.new("ShaderNodeAttribute")
    node.attribute_type, node.attribute_name = "OBJECT", attribute
    color, _vector, factor, _alpha = node.outputs
    tree.links.new(color if socket.type == "RGBA" else factor, socket)
    node.location = (socket.node.location.x - 240, socket.node.location.y)
