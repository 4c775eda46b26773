# SPDX-License-Identifier: GPL-3.0-or-later
"""A photographer's studio for one material: a ball on a stand, softboxes that show in its reflections, a backdrop."""

from typing import NamedTuple

import bpy
from mathutils import Vector

from ..blender.versions import node_tree
from .geometry import STAND_FLOOR, backdrop_mesh, ball_mesh, stand_mesh
from .settings import add_object, remove_scene, studio_settings

BALL_CENTRE = Vector((0.0, 0.0, -STAND_FLOOR))


class Studio(NamedTuple):
    """A built studio. `owned` are the materials it made; the shown material belongs to the caller."""

    scene: bpy.types.Scene
    ball: bpy.types.Object
    owned: tuple[bpy.types.Material, ...]

    def show(self, material: bpy.types.Material) -> None:
        """Put `material` on the ball."""
        self.ball.data.materials[0] = material

    def remove(self) -> None:
        """Remove the scene and all that was built for it."""
        remove_scene(self.scene)
        bpy.data.batch_remove(self.owned)


def build_ball_scene(
    material: bpy.types.Material | None = None, tile_px: int | tuple[int, int] = 320, samples: int = 24, *, name: str = "Lamina Studio"
) -> Studio:
    """New scene with one ball (radius 1 m) of `material`, camera, lights and render settings, ready to render.

    `tile_px` is the width and height in pixels, or both; the ball is whole in a picture of any shape. The window's scene is left
    alone. The scene stays until `Studio.remove`, or is saved with the file.
    Raises LaminaError for samples or sizes below 1.
    """
    scene = bpy.data.scenes.new(name)
    studio_settings(scene, samples, tile_px)
    dark, paper = _dark_rubber(), _backdrop_material()
    ball = add_object(scene, "Ball", ball_mesh("Ball"))
    ball.location = BALL_CENTRE
    ball.data.materials.append(material)
    ball.data.materials.append(dark)
    stand = add_object(scene, "Stand", stand_mesh("Stand"))
    stand.location = BALL_CENTRE
    stand.data.materials.append(dark)
    backdrop = add_object(scene, "Backdrop", backdrop_mesh("Backdrop"))
    backdrop.data.materials.append(paper)
    _camera(scene)
    _lights(scene)
    _world(scene)
    return Studio(scene, ball, (dark, paper))


def _aim(item: bpy.types.Object, location: tuple[float, float, float], target: Vector) -> None:
    item.location = location
    item.rotation_euler = (target - Vector(location)).to_track_quat("-Z", "Y").to_euler()


def _camera(scene: bpy.types.Scene) -> None:
    data = bpy.data.cameras.new("Camera")
    data.lens, data.sensor_width, data.sensor_height = 100.0, 36.0, 36.0
    # the smaller side frames the ball
    data.sensor_fit = "HORIZONTAL" if scene.render.resolution_x <= scene.render.resolution_y else "VERTICAL"
    scene.camera = add_object(scene, "Camera", data)
    _aim(scene.camera, (0.0, -7.9, 2.55), Vector((0.0, 0.0, 0.93)))


def _lights(scene: bpy.types.Scene) -> None:
    _softbox(scene, "Key", (-3.6, -3.1, 4.3), (4.8, 4.8), 600.0, edge=0.2, warmth=0.03)
    _softbox(scene, "Rim strip", (3.6, 0.7, 2.4), (0.8, 4.4), 170.0, edge=0.4, warmth=-0.05)
    _softbox(scene, "Fill", (4.4, -4.4, 1.6), (2.4, 5.0), 75.0, edge=0.5, warmth=0.0)
    _softbox(scene, "Top", (0.4, 1.6, 5.4), (5.0, 2.4), 120.0, edge=0.5, warmth=0.0)
    halo = bpy.data.lights.new("Halo", "SPOT")
    halo.energy, halo.spot_size, halo.spot_blend, halo.shadow_soft_size = 1300.0, 1.0, 1.0, 0.3
    _aim(add_object(scene, "Halo", halo), (0.0, -0.6, 5.2), Vector((0.0, 4.5, 1.9)))


def _softbox(
    scene: bpy.types.Scene, name: str, location: tuple[float, float, float], size: tuple[float, float], power: float, *, edge: float, warmth: float
) -> None:
    """Area light of `power` W aimed at the ball, fading out over the outer `edge` of its width, as a diffuser does."""
    light = bpy.data.lights.new(name, "AREA")
    light.shape, light.energy = "RECTANGLE", power
    light.size, light.size_y = size
    light.color = (1.0 + warmth, 1.0, 1.0 - warmth)
    tree = node_tree(light)
    tree.nodes.clear()
    place, split = tree.nodes.new("ShaderNodeNewGeometry"), tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(place.outputs["Parametric"], split.inputs[0])

    def math(operation: str, a: bpy.types.NodeSocket | float, b: bpy.types.NodeSocket | float):
        node = tree.nodes.new("ShaderNodeMath")
        node.operation = operation
        for socket, value in zip(node.inputs, (a, b)):
            if isinstance(value, float):
                socket.default_value = value
            else:
                tree.links.new(value, socket)
        return node.outputs[0]

    fades = []
    for axis in (0, 1):
        coordinate = split.outputs[axis]
        fade = tree.nodes.new("ShaderNodeMapRange")
        fade.interpolation_type = "SMOOTHERSTEP"
        fade.inputs["From Max"].default_value = edge
        tree.links.new(math("MINIMUM", coordinate, math("SUBTRACT", 1.0, coordinate)), fade.inputs["Value"])
        fades.append(fade.outputs["Result"])
    emission, output = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputLight")
    tree.links.new(math("MULTIPLY", *fades), emission.inputs["Strength"])
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    _aim(add_object(scene, name, light), location, BALL_CENTRE)


def _world(scene: bpy.types.Scene) -> None:
    """Dim room: darker below, a little light above, so that metals do not reflect black."""
    scene.world = bpy.data.worlds.new("Studio")
    tree = node_tree(scene.world)
    tree.nodes.clear()
    place, split = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeSeparateXYZ")
    ramp = tree.nodes.new("ShaderNodeMapRange")
    ramp.inputs["From Min"].default_value, ramp.inputs["To Min"].default_value = -0.5, 0.03
    ramp.inputs["To Max"].default_value = 0.36
    background, output = tree.nodes.new("ShaderNodeBackground"), tree.nodes.new("ShaderNodeOutputWorld")
    background.inputs["Color"].default_value = (0.93, 0.97, 1.0, 1.0)
    tree.links.new(place.outputs["Generated"], split.inputs[0])
    tree.links.new(split.outputs["Z"], ramp.inputs["Value"])
    tree.links.new(ramp.outputs["Result"], background.inputs["Strength"])
    tree.links.new(background.outputs[0], output.inputs["Surface"])


def _dark_rubber() -> bpy.types.Material:
    material = bpy.data.materials.new("Studio stand")
    shader = next(node for node in node_tree(material).nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = (0.022, 0.023, 0.025, 1.0)
    shader.inputs["Roughness"].default_value = 0.42
    return material


def _backdrop_material() -> bpy.types.Material:
    material = bpy.data.materials.new("Studio backdrop")
    tree = node_tree(material)
    tree.nodes.clear()
    shader, output = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeOutputMaterial")
    shader.inputs["Color"].default_value = (0.048, 0.05, 0.055, 1.0)
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material
