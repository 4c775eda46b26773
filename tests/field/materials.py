# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist builds around a surface: mixes, textures, attributes, displacement; and what a surface is to reflect."""

from contextlib import suppress

import bpy
import numpy as np
from mathutils import Color

from lamina.addon.blender.versions import node_tree
from lamina.addon.material import material as materials
from lamina.addon.rendering.geometry import plane_mesh
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.exchange.principled import to_principled
from lamina.reference_py.material import presets
from lamina.reference_py.material.stack import Stack

from .case import case
from .files import set_working_space
from .trial import BLUE, LIVE, METAL, PAINT, RED, WITHOUT_OSL, Surface, Trial, image_of

GLOW = (0.0, 0.5, 0.0)
NOISE = 0.03  # a mix picks its closures by chance


def with_glow(trial: Trial, material: bpy.types.Material, kind: str) -> None:
    """Put a Mix Shader of one half, or an Add Shader, with a green emission before the output."""
    tree, output = material.node_tree, trial.output(material)
    source = trial.shader_socket(material)
    both, glow = tree.nodes.new(kind), tree.nodes.new("ShaderNodeEmission")
    glow.inputs["Color"].default_value = (*GLOW, 1.0)
    shaders = [socket for socket in both.inputs if socket.type == "SHADER"]
    tree.links.new(source, shaders[0])
    tree.links.new(glow.outputs[0], shaders[1])
    tree.links.new(both.outputs[0], output.inputs["Surface"])


def glowing(plain: np.ndarray, kind: str) -> np.ndarray:
    """The color of a surface with the glow of `with_glow`."""
    return 0.5 * plain + 0.5 * np.array(GLOW) if "Mix" in kind else plain + np.array(GLOW)


MIXES = {"Mix Shader": "ShaderNodeMixShader", "Add Shader": "ShaderNodeAddShader"}


def _mix_cases(label: str, kind: str) -> None:
    @case(f"{label} over the surface, then edits", osl_off=True)
    def after(trial):
        """The surface mixed with an emission; then a new color and a preset or new values: the glow stays."""
        plain, edited, other = (trial.plain(s).mean for s in (PAINT, PAINT.with_color(BLUE), METAL))
        material = trial.material()
        with_glow(trial, material, kind)
        trial.show(material)
        within = max(NOISE, trial.within)
        trial.compare("mixed", trial.picture().mean, glowing(plain, kind), within)
        trial.set_color(material, BLUE)
        trial.compare("edited", trial.picture().mean, glowing(edited, kind), within)
        become(trial, material, METAL)
        trial.compare("another surface", trial.picture().mean, glowing(other, kind), within)
        trial.sound(material)

    @case(f"a preset over a {label}", osl_off=True)
    def over(trial):
        """A plain material mixed with an emission gets the surface: the glow stays, and the surface shows beside it."""
        plain = trial.plain().mean
        material = bpy.data.materials.new("subject")
        node_tree(material)
        with_glow(trial, material, kind)
        become(trial, material, PAINT)
        trial.show(material)
        trial.compare("mixed", trial.picture().mean, glowing(plain, kind), max(NOISE, trial.within))
        trial.sound(material)


def become(trial: Trial, material: bpy.types.Material, surface: Surface) -> None:
    """What a preset does: the material shows another surface."""
    if trial.is_lamina:
        materials.apply_stack(material, surface.stack)
        trial.settle(material)
    else:
        for name, value in surface.sockets.items():
            trial.principled(material).inputs[name].default_value = value


for _label, _kind in MIXES.items():
    _mix_cases(_label, _kind)


@case("mixed inside a node group", osl_off=True)
def mix_in_group(trial):
    """The surface goes through a group that mixes it with an emission; then a new color."""
    plain, edited = trial.plain().mean, trial.plain(PAINT.with_color(BLUE)).mean
    material = trial.material()
    group = bpy.data.node_groups.new("Glow", "ShaderNodeTree")
    group.interface.new_socket("In", in_out="INPUT", socket_type="NodeSocketShader")
    group.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketShader")
    enter, leave, mix, glow = (
        group.nodes.new(f"ShaderNode{n}" if "Group" not in n else n) for n in ("NodeGroupInput", "NodeGroupOutput", "MixShader", "Emission")
    )
    glow.inputs["Color"].default_value = (*GLOW, 1.0)
    for a, b in ((enter.outputs[0], mix.inputs[1]), (glow.outputs[0], mix.inputs[2]), (mix.outputs[0], leave.inputs[0])):
        group.links.new(a, b)
    node = material.node_tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    source = trial.shader_socket(material)
    material.node_tree.links.new(source, node.inputs[0])
    material.node_tree.links.new(node.outputs[0], trial.output(material).inputs["Surface"])
    trial.show(material)
    within = max(NOISE, trial.within)
    trial.compare("mixed", trial.picture().mean, glowing(plain, "Mix"), within)
    trial.set_color(material, BLUE)
    trial.compare("edited", trial.picture().mean, glowing(edited, "Mix"), within)
    trial.sound(material)


@case("cut-out by a Transparent BSDF", osl_off=True)
def cut_out(trial):
    """Half mixed with Transparent: alpha three quarters, as the ball has two sides, and light of the surface."""
    plain = trial.plain()
    trial.stage(samples=256)
    material = trial.material()
    tree, source = material.node_tree, trial.shader_socket(material)
    mix, clear = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeBsdfTransparent")
    tree.links.new(clear.outputs[0], mix.inputs[1])
    tree.links.new(source, mix.inputs[2])
    tree.links.new(mix.outputs[0], trial.output(material).inputs["Surface"])
    trial.show(material)
    got, inside = trial.picture(), plain.covered
    trial.compare("alpha", got.alpha[inside].mean(), 0.75, NOISE)
    # the front gives half of its light; the inside, seen through it, adds some, but less
    share = got.passed("Combined")[inside].mean(axis=0) / plain.mean
    trial.require("half to all of the surface's light", bool((share > 0.5).all() and (share < 1.0).all()))


@case("user's own EEVEE output")
def eevee_output(trial):
    """A material with an output for EEVEE of the artist's own gets the surface: the output and its link stay; Cycles shows the surface."""
    plain = trial.plain()
    material = bpy.data.materials.new("subject")
    tree = node_tree(material)
    own, glow = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new("ShaderNodeEmission")
    own.target, own.name = "EEVEE", "Mine"
    tree.links.new(glow.outputs[0], own.inputs["Surface"])
    become(trial, material, PAINT)
    kept = tree.nodes.get("Mine")
    trial.require("the output stays", kept is not None and kept.target == "EEVEE")
    trial.require("its link stays", kept is not None and [k.from_node.type for k in kept.inputs["Surface"].links] == ["EMISSION"])
    trial.show(material)
    trial.compare_pictures("Cycles", trial.picture(), plain)


@case("surface in EEVEE", beside=True)
def eevee_surface(trial):
    """EEVEE's output of the material is fed by closures that EEVEE knows (no window, so no picture)."""
    material = trial.material()
    output = material.node_tree.get_output_node("EEVEE")
    links = output.inputs["Surface"].links if output else ()
    trial.require("something feeds it", len(links) == 1)
    trial.require("not a script alone", bool(links) and links[0].from_node.type != "SCRIPT")


@case("volume and displacement stay", osl_off=True)
def volume_stays(trial):
    """A material with a volume and a displacement gets the surface: both stay linked."""
    material = bpy.data.materials.new("subject")
    tree = node_tree(material)
    volume = tree.nodes.new("ShaderNodeVolumeScatter")
    tree.links.new(volume.outputs[0], trial.output(material).inputs["Volume"])
    displaced(trial, material, "BUMP", 0.1)
    become(trial, material, PAINT)
    output = trial.output(material)
    trial.require("volume", output.inputs["Volume"].is_linked)
    trial.require("displacement", output.inputs["Displacement"].is_linked)
    trial.show(material)
    trial.require("a picture that is not black", trial.picture().mean.max() > 0.02)


def displaced(trial: Trial, material: bpy.types.Material, method: str, scale: float) -> None:
    """A noise in the displacement socket."""
    tree = material.node_tree
    move, noise = tree.nodes.new("ShaderNodeDisplacement"), tree.nodes.new("ShaderNodeTexNoise")
    move.inputs["Scale"].default_value, noise.inputs["Scale"].default_value = scale, 3.0
    tree.links.new(noise.outputs[0], move.inputs["Height"])
    tree.links.new(move.outputs[0], trial.output(material).inputs["Displacement"])
    material.displacement_method = method


def _shape(trial: Trial, material: bpy.types.Material, method: str) -> np.ndarray:
    """(2,) spread of the radius, and how far normals are from the radius, of a displaced ball."""
    layer = trial.stage(samples=4).view_layers[0]
    layer.use_pass_position = layer.use_pass_normal = True
    material = material()
    displaced(trial, material, method, 0.4)
    trial.show(material)
    picture = trial.picture()
    place, normal = (picture.passed(name, "XYZ")[picture.covered] for name in ("Position", "Normal"))
    radius = np.linalg.norm(place, axis=1)
    return np.array([radius.std(), (1.0 - (normal * place).sum(axis=1) / radius).mean()])


def _plain_diffuse() -> bpy.types.Material:
    material = bpy.data.materials.new("diffuse")
    tree = node_tree(material)
    shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
    tree.links.new(shader.outputs[0], tree.get_output_node("CYCLES").inputs["Surface"])
    return material


def _displacement_case(method: str) -> None:
    @case(f"displacement, method {method.title()}", osl_off=True)
    def displacement(trial):
        """Spread of the radius and tilt of the normals of a displaced ball, beside a stock Diffuse BSDF's."""
        expected = _shape(trial, _plain_diffuse, method)
        # the pass is the mean of the closures' normals, and Cycles bends that of a glossy one: Principled is off by 6 %
        trial.compare("radius and normals", _shape(trial, trial.material, method), expected, 0.1)


for _method in ("BUMP", "DISPLACEMENT", "BOTH"):
    _displacement_case(_method)


@case("normal map on every layer", osl_off=True)
def normal_map(trial):
    """A constant normal, 20 degrees from a plane's, on layer and base: the plane turned by 20 degrees."""
    angle = np.radians(20.0)

    def centre(normal: bool) -> np.ndarray:
        trial.stage(samples=64)
        material = trial.material()
        if normal:
            tilted = material.node_tree.nodes.new("ShaderNodeCombineXYZ")
            for socket, value in zip(tilted.inputs, (np.sin(angle), 0.0, np.cos(angle))):
                socket.default_value = value
            for socket in _normals(trial, material):
                material.node_tree.links.new(tilted.outputs[0], socket)
            trial.settle(material)
        item = trial.show(material, plane_mesh("plane", 0.5))
        item.rotation_euler.y = 0.0 if normal else angle
        return trial.picture(osl=None if normal else True).mean

    expected = centre(False)
    trial.compare("tilted", centre(True), expected, 0.05)


def _normals(trial: Trial, material: bpy.types.Material) -> list[bpy.types.NodeSocket]:
    if not trial.is_lamina:
        return [trial.principled(material).inputs["Normal"]]
    for element in (*material.lamina.layers, material.lamina.base):
        element.use_normal = True
    return [materials.node_of(element).inputs["Normal"] for element in (*material.lamina.layers, material.lamina.base)]


def follows(trial: Trial, make_source, expected: Surface, parameter: str = "color", prepare=None) -> None:
    """Link a node to a socket and compare with the surface that was made with its value. `prepare` gets the object."""
    picture = trial.plain(expected)
    material = trial.material()
    material.node_tree.links.new(make_source(material.node_tree), trial.socket(material, parameter))
    trial.settle(material)
    item = trial.show(material)
    if prepare:
        prepare(item)
    trial.excuse_textures(material)
    trial.compare_pictures("picture", trial.picture(), picture, LIVE)


def attribute(name: str, kind: str):
    def made(tree):
        node = tree.nodes.new("ShaderNodeAttribute")
        node.attribute_name, node.attribute_type = name, kind
        return node.outputs["Color"]

    return made


def _paint_points(item: bpy.types.Object) -> None:
    layer = item.data.color_attributes.new("Col", "FLOAT_COLOR", "POINT")
    layer.data.foreach_set("color", np.tile(np.array((*BLUE, 1.0), np.float32), len(item.data.vertices)))


@case("color attribute", osl_off=True)
def color_attribute(trial):
    """A painted color attribute in the color: the surface of that color."""

    def source(tree):
        node = tree.nodes.new("ShaderNodeVertexColor")
        node.layer_name = "Col"
        return node.outputs[0]

    follows(trial, source, PAINT.with_color(BLUE), prepare=_paint_points)


@case("named attribute", osl_off=True)
def named_attribute(trial):
    """The same through an Attribute node."""
    follows(trial, attribute("Col", "GEOMETRY"), PAINT.with_color(BLUE), prepare=_paint_points)


@case("object color", osl_off=True)
def object_color(trial):
    """Object Info's color in the color."""

    def prepare(item):
        item.color = (*BLUE, 1.0)

    follows(trial, lambda tree: tree.nodes.new("ShaderNodeObjectInfo").outputs["Color"], PAINT.with_color(BLUE), prepare=prepare)


@case("object property", osl_off=True)
def object_property(trial):
    """An object's custom property in the color."""

    def prepare(item):
        item["hue"] = list(BLUE)

    follows(trial, attribute("hue", "OBJECT"), PAINT.with_color(BLUE), prepare=prepare)


@case("scene property", osl_off=True)
def scene_property(trial):
    """A scene's custom property, by an Attribute node of type View Layer, in the color."""

    def prepare(_item):
        bpy.context.scene["hue"] = list(BLUE)

    follows(trial, attribute("hue", "VIEW_LAYER"), PAINT.with_color(BLUE), prepare=prepare)


@case("Object Info random", quick=False, osl_off=True)
def random_color(trial):
    """Object Info's Random in the color, beside the surface with the grey that an emission shows of it."""
    emission = bpy.data.materials.new("emission")
    tree = node_tree(emission)
    glow = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(tree.nodes.new("ShaderNodeObjectInfo").outputs["Random"], glow.inputs["Color"])
    tree.links.new(glow.outputs[0], tree.get_output_node("CYCLES").inputs["Surface"])
    trial.show(emission)
    grey = float(trial.picture().mean[0])
    follows(trial, lambda tree: tree.nodes.new("ShaderNodeObjectInfo").outputs["Random"], PAINT.with_color((grey,) * 3))


def _image(trial: Trial):
    def made(tree):
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image = image_of(trial.folder / "blue.exr", BLUE)
        return node.outputs["Color"]

    return made


@case("image in the color", osl_off=True)
def image_color(trial):
    """A blue image: the blue surface."""
    follows(trial, _image(trial), PAINT.with_color(BLUE))


@case("node in the roughness", quick=False, osl_off=True)
def node_roughness(trial):
    """A Value node in the roughness of the top."""

    def source(tree):
        node = tree.nodes.new("ShaderNodeValue")
        node.outputs[0].default_value = 0.7
        return node.outputs[0]

    follows(trial, source, PAINT.with_roughness(0.7), "roughness")


@case("image in the color, packed and opened", osl_off=True)
def image_packed(trial):
    """A blue image, packed, its file deleted, saved and opened."""
    expected = trial.plain(PAINT.with_color(BLUE))
    material = trial.material()
    material.node_tree.links.new(_image(trial)(material.node_tree), trial.socket(material, "color"))
    trial.settle(material)
    trial.show(material)
    bpy.ops.file.pack_all()
    (trial.folder / "blue.exr").unlink()
    path = str(trial.folder / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    trial.excuse_textures(bpy.data.materials["subject"])
    trial.compare_pictures("opened", trial.picture(), expected, LIVE)


@case("UDIM", osl_off=True)
def udim(trial):
    """An image of two tiles on a ball whose UVs lie in the second: its blue."""
    for tile, color in ((1001, RED), (1002, BLUE)):
        image_of(trial.folder / f"tile.{tile}.exr", color)

    def source(tree):
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image = bpy.data.images.load(str(trial.folder / "tile.1001.exr"))
        node.image.source = "TILED"
        node.image.filepath = str(trial.folder / "tile.<UDIM>.exr")
        if 1002 not in [t.number for t in node.image.tiles]:
            node.image.tiles.new(1002)
        return node.outputs["Color"]

    def prepare(item):
        uv = item.data.uv_layers[0].data
        uv.foreach_set("uv", np.tile(np.array((1.5, 0.5), np.float32), len(uv)))

    follows(trial, source, PAINT.with_color(BLUE), prepare=prepare)


@case("Light Path in the color", osl_off=True)
def light_path(trial):
    """Blue where a camera sees it, by Is Camera Ray: the blue surface."""

    def source(tree):
        mix, path = tree.nodes.new("ShaderNodeMix"), tree.nodes.new("ShaderNodeLightPath")
        mix.data_type = "RGBA"
        sockets = {s.identifier: s for s in mix.inputs}
        sockets["A_Color"].default_value, sockets["B_Color"].default_value = (1.0, 0.0, 0.0, 1.0), (*BLUE, 1.0)
        tree.links.new(path.outputs["Is Camera Ray"], sockets["Factor_Float"])
        return next(s for s in mix.outputs if s.identifier == "Result_Color")

    follows(trial, source, PAINT.with_color(BLUE))


@case("all nodes renamed")
def renamed(trial):
    """Every node gets another name: nothing is lost, an edit shows, a save changes nothing."""
    expected = trial.plain(PAINT.with_color(BLUE))
    material = trial.material()
    for node in list(material.node_tree.nodes):
        node.name = f"My {node.name}"
    trial.sound(material)
    trial.is_same("the renamed one", material, PAINT)
    trial.set_color(material, BLUE)
    trial.show(material)
    trial.compare_pictures("edited", trial.picture(), expected)


@case("a layer's node deleted, mended", quick=False, beside=False)
def deleted(trial):
    """The node of a tinted layer is deleted and mended with one click: the values that it had."""
    data = PAINT.stack.to_dict()
    data["layers"][0] |= {"tint": [0.2, 0.6, 0.9], "thickness": 1.0} if "tint" in str(presets.load("tinted_glaze").to_dict()) else {}
    surface = Surface(Stack.from_dict(data), {})
    material = trial.material(surface)
    trial.show(material)
    before = trial.picture()
    material.node_tree.nodes.remove(trial.socket(material, "roughness").node)
    bpy.ops.lamina.mend_all()
    trial.is_same("the mended one", material, surface)
    trial.settle(material)
    trial.compare_pictures("mended", trial.picture(), before)


@case("fifty layers", quick=False, beside=False)
def fifty(trial):
    """Refused in one line, in under five seconds of CPU, and the material stays as it was."""
    import time

    material = trial.material()
    many = Stack.from_dict({"layers": [{"kind": "dielectric", "ior": 1.5 + 0.001 * i, "roughness": 0.1} for i in range(50)], "base": {"kind": "lambert"}})
    begin = time.process_time()
    with suppress(LaminaError):
        materials.apply_stack(material, many)
        trial.settle(material)
        trial.require("it works, or is refused", len(material.lamina.layers) == 50)
    trial.require("in under five seconds", time.process_time() - begin < 5.0)
    if len(material.lamina.layers) != 50:
        trial.is_same("the refused one", material, PAINT)


@case("Principled to Lamina", quick=False, beside=False)
def convert(trial):
    """Convert to Lamina: the picture of the Principled node, to 15 %."""
    material = bpy.data.materials.new("subject")
    node_tree(material)
    for name, value in PAINT.sockets.items():
        Trial.principled(material).inputs[name].default_value = value
    trial.show(material)
    before = trial.picture()
    bpy.ops.lamina.convert_principled()
    trial.settle(material)
    trial.compare_pictures("converted", trial.picture(), before, 0.15)
    trial.sound(material)


def white_plane(trial: Trial, surface: Surface, theta_deg: float, samples: int = 64) -> np.ndarray:
    """What a plane reflects of a white world at an angle of view, (3,)."""
    trial.stage(16, samples, furnace=True).camera.data.ortho_scale = 0.05
    item = trial.show(trial.material(surface), plane_mesh("plane", 10.0))
    item.rotation_euler.y = np.radians(theta_deg)
    return trial.picture().mean


def _white_metal(rotation: float) -> Surface:
    base = {"kind": "conductor", "reflectance": [0.999] * 3, "edge_color": [1.0] * 3, "roughness": 0.5, "anisotropy": 1.0, "rotation": rotation}
    sockets = {"Base Color": (0.999, 0.999, 0.999, 1.0), "Metallic": 1.0, "Roughness": 0.5, "Anisotropic": 1.0, "Anisotropic Rotation": rotation}
    return Surface(Stack.from_dict({"base": base}), sockets)


def _brushed_case(label: str, rotation: float) -> None:
    @case(f"energy of brushed rough metal, {label}", quick=False, osl_off=True)
    def brushed(trial):
        """A white brushed metal in a white world at 0, 40 and 80 degrees reflects what it receives, to 1 %."""
        got = [white_plane(trial, _white_metal(rotation), theta).mean() for theta in (0.0, 40.0, 80.0)]
        trial.compare("reflected", got, [0.9987] * 3, 0.01)


for _label, _rotation in (("along", 0.0), ("across", 0.25)):
    _brushed_case(_label, _rotation)


@case("Oren-Nayar of 90 degrees", quick=False, osl_off=True)
def oren_nayar(trial):
    """Grey .5 in a white world along the normal: .4510, the formula with the square of the color between facets."""
    stack = Stack.from_dict({"base": {"kind": "oren_nayar", "color": [0.5] * 3, "sigma_deg": 90}})
    values = to_principled(stack).values
    sockets = {name: (*value, 1.0) if isinstance(value, tuple) and len(value) == 3 else value for name, value in values.items()}
    trial.compare("reflected", white_plane(trial, Surface(stack, sockets), 0.0, 256), [0.4510] * 3, 0.01)


def as_rec709(rgb: np.ndarray) -> np.ndarray:
    """A color of the file's working space in linear Rec.709."""
    return np.array(Color(rgb).from_scene_linear_to_rec709_linear())


CAR_PAINT = Surface(presets.load("clear_coat_car_paint"), {"Base Color": (0.3, 0.01, 0.02, 1.0), "Coat Weight": 1.0})


def _space_case(space: str) -> None:
    @case(f"made in a file of {space}", quick=False, least=(5, 0), osl_off=True)
    def made(trial):
        """The car paint, made in a file of this working space: the light of a Rec.709 file, to 1 %."""
        _in_space(trial, space, CAR_PAINT, before=False)

    @case(f"converted to {space}", quick=False, least=(5, 0), osl_off=True)
    def converted(trial):
        """The car paint's file is converted to this working space and saved: the same light, to 1 %."""
        _in_space(trial, space, CAR_PAINT, before=True)


def _in_space(trial: Trial, space: str, surface: Surface, before: bool) -> None:
    expected = trial.plain(surface).mean
    if not before:
        set_working_space(space)
        if not trial.is_lamina:  # sockets are in the working space
            color = Color(surface.sockets["Base Color"][:3]).from_rec709_linear_to_scene_linear()
            surface = Surface(surface.stack, surface.sockets | {"Base Color": (*color, 1.0)})
    trial.show(trial.material(surface))
    if before:
        set_working_space(space)
        path = str(trial.folder / "saved.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path)
    trial.compare("light, in Rec.709", as_rec709(trial.picture().mean), expected, 0.01 if trial.osl else WITHOUT_OSL)


for _space in ("ACEScg", "Linear Rec.2020"):
    _space_case(_space)
