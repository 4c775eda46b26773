# SPDX-License-Identifier: GPL-3.0-or-later
"""Values that move: keyframes, drivers, persistent data, and what keeps them when layers change."""

import bpy

from lamina.addon.blender.images import read_exr

from .case import case
from .trial import BLUE, LIVE, METAL, PAINT, RED, Picture, Surface, Trial


def keyed(socket: bpy.types.NodeSocket, values: dict) -> None:
    """Keyframes: frame -> value."""
    for frame, value in values.items():
        socket.default_value = value
        socket.keyframe_insert("default_value", frame=frame)


def curves(material: bpy.types.Material) -> int:
    """How many valid curves and drivers move the values of a material's nodes."""
    animation = material.node_tree.animation_data
    if animation is None:
        return 0
    action = animation.action
    keys = [c for layer in action.layers for strip in layer.strips for bag in strip.channelbags for c in bag.fcurves] if action else []
    return sum(c.is_valid for c in keys) + sum(d.is_valid for d in animation.drivers)


def driven(socket: bpy.types.NodeSocket, item: bpy.types.Object) -> bpy.types.FCurve:
    """A driver that hands on the object's property "amount"."""
    curve = socket.driver_add("default_value")
    variable = curve.driver.variables.new()
    variable.targets[0].id, variable.targets[0].data_path = item, '["amount"]'
    curve.driver.expression = variable.name
    return curve


def movie(trial: Trial) -> list[Picture]:
    """Frames 1 and 2, rendered by one animation call that keeps its data."""
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 2
    scene.render.use_persistent_data, scene.render.use_file_extension = True, True
    scene.render.filepath = str(trial.folder / "movie_")
    bpy.ops.render.render(animation=True)
    return [Picture(read_exr(trial.folder / f"movie_{frame:04d}.exr"), scene.view_layers[0].name) for frame in (1, 2)]


def moving(trial: Trial, parameter: str, values: dict, surfaces: list[Surface]) -> None:
    expected = [trial.plain(surface) for surface in surfaces]
    material = trial.material(surfaces[0])
    keyed(trial.socket(material, parameter), values)
    bpy.context.scene.frame_set(1)
    trial.settle(material)
    trial.show(material)
    trial.excuse_textures(material)
    for got, wanted, frame in zip(movie(trial), expected, (1, 2)):
        trial.compare_pictures(f"frame {frame}", got, wanted, LIVE)


@case("keyframed color, one animation call, persistent data", quick=False, osl_off=True)
def keyed_color(trial):
    """Both frames beside materials made with those colors."""
    moving(trial, "color", {1: (*RED, 1.0), 2: (*BLUE, 1.0)}, [PAINT, PAINT.with_color(BLUE)])


@case("keyframed roughness, one animation call, persistent data", quick=False, osl_off=True)
def keyed_roughness(trial):
    """Both frames beside materials made with those roughnesses."""
    moving(trial, "roughness", {1: 0.3, 2: 0.7}, [PAINT, PAINT.with_roughness(0.7)])


@case("keyframes and nothing pressed, frames rendered one by one", quick=False)
def keyed_unsettled(trial):
    """Keyframed color, rendered headless without a save: each frame is that of its color, or Check says that it is old.

    Blender crashes when nodes change once a render has begun, so a shader that holds values cannot follow then.
    """
    expected = [trial.plain(PAINT), trial.plain(PAINT.with_color(BLUE))]
    material = trial.material()
    trial.show(material)
    keyed(trial.socket(material, "color"), {1: (*RED, 1.0), 2: (*BLUE, 1.0)})
    for frame, wanted in zip((1, 2), expected):
        bpy.context.scene.frame_set(frame)
        trial.excuse(material, "shader_stale")
        trial.compare_pictures(f"frame {frame}", trial.picture(), wanted, LIVE)


@case("keyframed coverage", quick=False, beside=False, osl_off=True)
def keyed_coverage(trial):
    """A layer that fades out: frame 1 covered, frame 2 bare, beside materials of constant coverage."""
    layer = dict(PAINT.stack.to_dict()["layers"][0])

    def covered(coverage: float) -> Surface:
        data = PAINT.stack.to_dict()
        data["layers"] = [layer | {"coverage": coverage}]
        return Surface(type(PAINT.stack).from_dict(data), {})

    moving(trial, "coverage", {1: 1.0, 2: 0.0}, [covered(1.0), covered(0.0)])


@case("driver on a roughness", quick=False, osl_off=True)
def driven_roughness(trial):
    """Roughness driven by a property of the object: the picture of that roughness."""
    expected = trial.plain(PAINT.with_roughness(0.7))
    material = trial.material()
    item = trial.show(material)
    item["amount"] = 0.7
    driven(trial.socket(material, "roughness"), item)
    item.update_tag()
    bpy.context.view_layer.update()
    trial.settle(material)
    trial.excuse_textures(material)
    trial.compare_pictures("driven", trial.picture(), expected, LIVE)


@case("set base kind, color keyframed", beside=False)
def set_base_keyed(trial):
    """Lambert to Oren-Nayar: the color's curves and its value at frame 10."""
    material = trial.material()
    trial.show(material)
    keyed(trial.socket(material, "color"), {1: (*RED, 1.0), 10: (*BLUE, 1.0)})
    before = curves(material)
    bpy.ops.lamina.set_base(kind="oren_nayar")
    trial.compare("curves", curves(material), before, 0.0)
    bpy.context.scene.frame_set(10)
    trial.compare("color at frame 10", tuple(trial.socket(material, "color").default_value)[:3], BLUE, 1e-4)
    trial.sound(material)


@case("set base kind to the same kind, roughness driven", beside=False)
def set_base_driven(trial):
    """Conductor to conductor: the driver and its value."""
    material = trial.material(METAL)
    item = trial.show(material)
    item["amount"] = 0.25
    driven(trial.socket(material, "roughness"), item)
    bpy.ops.lamina.set_base(kind="conductor")
    trial.compare("drivers", curves(material), 1, 0.0)
    item["amount"] = 0.55
    item.update_tag()
    bpy.context.view_layer.update()
    trial.compare("roughness", trial.socket(material, "roughness").default_value, 0.55, 1e-4)


@case("move a layer that is keyframed", quick=False, beside=False)
def move_keyed(trial):
    """After Move Layer the curve moves the same layer, not the one that took its place."""
    data = PAINT.stack.to_dict()
    data["layers"] = [{"kind": "dielectric", "name": "Top", "roughness": 0.2}, {"kind": "dielectric", "name": "Under", "roughness": 0.5}]
    material = trial.material(Surface(type(PAINT.stack).from_dict(data), {}))
    trial.show(material)
    keyed(trial.socket(material, "roughness"), {1: 0.1, 10: 0.9})
    material.lamina.active_layer = 0
    bpy.ops.lamina.layer_move(direction="DOWN")
    bpy.context.scene.frame_set(10)
    trial.require("the order has changed", [layer.name for layer in material.lamina.layers] == ["Under", "Top"])
    trial.compare("roughness of what is on top", trial.socket(material, "roughness").default_value, 0.5, 1e-4)
    trial.compare("curves", curves(material), 1, 0.0)
    trial.sound(material)


@case("copy a material that is keyframed")
def copy_keyed(trial):
    """A copy's keyframes move the copy and not the original."""
    material = trial.material()
    keyed(trial.socket(material, "color"), {1: (*RED, 1.0), 10: (*BLUE, 1.0)})
    copy = material.copy()
    before = curves(material)
    trial.compare("curves of the copy", curves(copy), before, 0.0)
    bpy.context.scene.frame_set(10)
    trial.show(copy)
    trial.compare("color of the copy", tuple(trial.socket(copy, "color").default_value)[:3], BLUE, 1e-4)
    trial.settle(copy)
    got = trial.picture()
    trial.compare_pictures("picture", got, trial.plain(PAINT.with_color(BLUE)), LIVE)


@case("a value that drives something else")
def drives_another(trial):
    """A driver that reads the roughness's socket still reads it after a save, an open and an edit."""
    material = trial.material()
    item = trial.show(material)
    curve = item.driver_add("location", 2)
    variable = curve.driver.variables.new()
    variable.targets[0].id_type, variable.targets[0].id = "MATERIAL", material
    variable.targets[0].data_path = f"node_tree.{trial.socket(material, 'roughness').path_from_id('default_value')}"
    curve.driver.expression = variable.name
    path = str(trial.folder / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    material = bpy.data.materials["subject"]
    trial.socket(material, "roughness").default_value = 0.77
    trial.settle(material)
    material.node_tree.update_tag()
    bpy.context.view_layer.update()
    trial.compare("driven height", bpy.data.objects["item"].location.z, 0.77, 1e-4)


@case("moving object, motion blur", osl_off=True)
def motion_blur(trial):
    """A ball that spins about its axis under motion blur is the ball at rest."""
    expected = trial.plain()
    item = trial.show(trial.material())
    scene = bpy.context.scene
    for frame, turn in ((0, 0.0), (2, 0.6)):
        item.rotation_euler = (0.0, turn, 0.0)  # the ball is round about y
        item.keyframe_insert("rotation_euler", frame=frame)
    scene.frame_set(1)
    scene.render.use_motion_blur = True
    trial.compare_pictures("blurred", trial.picture(), expected, 0.03 if trial.osl or not trial.is_lamina else 0.05)


@case("keyframed node before a color", quick=False, osl_off=True)
def animated_texture(trial):
    """A Mix of two colors, linked to the color, whose factor is keyframed from red to blue: frame 2 is blue."""
    expected = trial.plain(PAINT.with_color(BLUE))
    material = trial.material()
    mix = material.node_tree.nodes.new("ShaderNodeMix")
    mix.data_type = "RGBA"
    inputs = {s.identifier: s for s in mix.inputs}
    inputs["A_Color"].default_value, inputs["B_Color"].default_value = (*RED, 1.0), (*BLUE, 1.0)
    keyed(inputs["Factor_Float"], {1: 0.0, 2: 1.0})
    output = next(s for s in mix.outputs if s.identifier == "Result_Color")
    material.node_tree.links.new(output, trial.socket(material, "color"))
    trial.settle(material)
    trial.show(material)
    bpy.context.scene.frame_set(2)
    trial.excuse_textures(material)
    trial.compare_pictures("frame 2", trial.picture(), expected, LIVE)
