# SPDX-License-Identifier: GPL-3.0-or-later
"""Hand-over: exported and read again with Blender's own importers; and what Blender and other add-ons read off a material."""

from collections.abc import Callable

import addon_utils
import bpy
import numpy as np
from bpy_extras.node_shader_utils import PrincipledBSDFWrapper

from lamina.addon.blender.images import write_png
from lamina.addon.material import material as materials
from lamina.addon.rendering.geometry import plane_mesh
from lamina.reference_py.exchange.principled import to_principled

from .case import case
from .trial import METAL, PAINT, Surface, Trial

WITHIN = 0.02  # of the conversion's own figures


def expected_of(trial: Trial, material: bpy.types.Material, surface: Surface) -> dict[str, tuple | float]:
    """What an exchange format is to get: Principled's sockets; for a stack, those of its conversion."""
    values = to_principled(materials.stack_of(material)).values if trial.is_lamina else surface.sockets
    return {"Base Color": tuple(values["Base Color"])[:3], "Metallic": values.get("Metallic", 0.0), "Roughness": values["Roughness"]}


def read_back(material: bpy.types.Material | None) -> dict[str, tuple | float]:
    """The Principled node that an importer made."""
    node = next((n for n in material.node_tree.nodes if n.type == "BSDF_PRINCIPLED"), None) if material and material.node_tree else None
    if node is None:
        return {}
    return {"Base Color": tuple(node.inputs["Base Color"].default_value)[:3]} | {n: node.inputs[n].default_value for n in ("Metallic", "Roughness")}


def round_trip(
    trial: Trial, surface: Surface, write: Callable[[str], None], read: Callable[[str], None], suffix: str, names=("Base Color", "Metallic", "Roughness")
):
    """Export a plane of `surface`, read it into an empty file, and compare what came back."""
    material = trial.material(surface)
    expected = expected_of(trial, material, surface)
    trial.show(material, plane_mesh("plane", 1.0))
    path = str(trial.folder / f"item{suffix}")
    write(path)
    trial.stage()
    read(path)
    got = read_back(next(iter(bpy.data.materials), None))
    trial.require("a Principled node came back", bool(got))
    for name in names if got else ():
        trial.compare(name, got[name], expected[name], WITHIN, least=0.0 if name == "Base Color" else 0.5)


def write_gltf(path: str) -> None:
    addon_utils.enable("io_scene_gltf2")
    bpy.ops.export_scene.gltf(filepath=path)


def read_gltf(path: str) -> None:
    addon_utils.enable("io_scene_gltf2")
    bpy.ops.import_scene.gltf(filepath=path)


def write_fbx(path: str) -> None:
    addon_utils.enable("io_scene_fbx")
    bpy.ops.export_scene.fbx(filepath=path, object_types={"MESH"})  # lights of one stop the importer of 5.0.1


def read_fbx(path: str) -> None:
    addon_utils.enable("io_scene_fbx")
    bpy.ops.import_scene.fbx(filepath=path)


def write_usd(path: str) -> None:
    bpy.ops.wm.usd_export(filepath=path, generate_preview_surface=True, generate_materialx_network=False)


def write_usd_mtlx(path: str) -> None:
    bpy.ops.wm.usd_export(filepath=path, generate_preview_surface=True, generate_materialx_network=True)


def read_usd(path: str) -> None:
    bpy.ops.wm.usd_import(filepath=path)


def write_obj(path: str) -> None:
    bpy.ops.wm.obj_export(filepath=path, export_pbr_extensions=True)


def read_obj(path: str) -> None:
    bpy.ops.wm.obj_import(filepath=path)


@case("glTF, paint", quick=False)
def gltf_paint(trial):
    """Base color, metallic and roughness after a glTF and back."""
    round_trip(trial, PAINT, write_gltf, read_gltf, ".glb")


@case("glTF, metal", quick=False)
def gltf_metal(trial):
    """The same of a metal."""
    round_trip(trial, METAL, write_gltf, read_gltf, ".glb")


@case("USD preview surface, paint")
def usd_paint(trial):
    """Base color, metallic and roughness after a USD preview surface and back."""
    round_trip(trial, PAINT, write_usd, read_usd, ".usda")


@case("USD preview surface, metal")
def usd_metal(trial):
    """The same of a metal."""
    round_trip(trial, METAL, write_usd, read_usd, ".usda")


@case("USD with MaterialX")
def usd_materialx(trial):
    """Base color, metallic and roughness after a USD with a MaterialX lobe set and back."""
    round_trip(trial, PAINT, write_usd_mtlx, read_usd, ".usda")


@case("OBJ, paint")
def obj_paint(trial):
    """Base color and roughness after an OBJ with PBR values and back."""
    round_trip(trial, PAINT, write_obj, read_obj, ".obj")


@case("OBJ, metal")
def obj_metal(trial):
    """Base color, metallic and roughness of a metal after an OBJ with PBR values and back."""
    round_trip(trial, METAL, write_obj, read_obj, ".obj")


@case("FBX")
def fbx(trial):
    """Base color after an FBX and back; FBX holds no roughness in Blender's sense."""
    round_trip(trial, PAINT, write_fbx, read_fbx, ".fbx", ("Base Color",))


@case("Alembic", limit="Alembic holds no materials")
def alembic(trial):
    """Base color after an Alembic and back."""
    round_trip(
        trial, PAINT, lambda p: bpy.ops.wm.alembic_export(filepath=p), lambda p: bpy.ops.wm.alembic_import(filepath=p), ".abc", ("Base Color",)
    )  # fmt: skip


def textured(trial: Trial, write, read, suffix: str) -> None:
    material = trial.material()
    pixels = np.zeros((8, 8, 3), np.uint8)
    pixels[:, :4, 0] = pixels[:, 4:, 2] = 255
    write_png(trial.folder / "half.png", pixels)
    image = material.node_tree.nodes.new("ShaderNodeTexImage")
    image.image = bpy.data.images.load(str(trial.folder / "half.png"))
    material.node_tree.links.new(image.outputs["Color"], trial.socket(material, "color"))
    trial.settle(material)
    trial.show(material, plane_mesh("plane", 1.0))
    path = str(trial.folder / f"item{suffix}")
    write(path)
    trial.stage()
    read(path)
    nodes = [n for made in bpy.data.materials if made.node_tree for n in made.node_tree.nodes if n.type == "BSDF_PRINCIPLED"]
    trial.require("an image came back in Base Color", any(_has_image(n.inputs["Base Color"]) for n in nodes))


def _has_image(socket: bpy.types.NodeSocket) -> bool:
    """Whether an image is before a socket, at once or, with a factor, behind a Mix."""
    return any(link.from_node.type == "TEX_IMAGE" or any(map(_has_image, link.from_node.inputs)) for link in socket.links)


@case("glTF with a texture", quick=False)
def gltf_texture(trial):
    """An image in the color comes back in Base Color."""
    textured(trial, write_gltf, read_gltf, ".glb")


@case("USD with a texture")
def usd_texture(trial):
    """An image in the color comes back in Base Color."""
    textured(trial, write_usd, read_usd, ".usda")


@case("the render stays after an export", quick=False, osl_off=True)
def render_after_export(trial):
    """The picture after glTF and USD were written beside the one before."""
    trial.plain()
    material = trial.material()
    trial.show(material)
    before = trial.picture(osl=True)
    write_gltf(str(trial.folder / "a.glb"))
    write_usd(str(trial.folder / "a.usda"))
    trial.compare_pictures("after", trial.picture(), before, trial.within)
    trial.sound(material)


@case("viewport color (Solid view)")
def viewport_color(trial):
    """Material's viewport color, metallic and roughness, which Solid view, OBJ and FBX take; a Principled's stay grey in Blender."""
    material = trial.material(METAL)
    expected = expected_of(trial, material, METAL)
    trial.compare("color", tuple(material.diffuse_color)[:3], expected["Base Color"], WITHIN)
    trial.compare("metallic", material.metallic, expected["Metallic"], WITHIN)
    trial.compare("roughness", material.roughness, expected["Roughness"], WITHIN)


@case("what exporters read off the nodes")
def wrapper(trial):
    """Base color and roughness through Blender's PrincipledBSDFWrapper, which many exporters use."""
    material = trial.material()
    expected = expected_of(trial, material, PAINT)
    read = PrincipledBSDFWrapper(material)
    trial.compare("color", tuple(read.base_color)[:3], expected["Base Color"], WITHIN)
    trial.compare("roughness", read.roughness, expected["Roughness"], WITHIN)


@case("Principled copy, rendered", beside=False)
def principled_copy(trial):
    """Make a Principled Copy: the copy's diffuse-lit picture is as bright as the conversion says, to 15 %."""
    expected = trial.plain()
    material = trial.material()
    item = trial.show(material)
    bpy.ops.lamina.principled_copy()
    item.active_material = next(m for m in bpy.data.materials if m != material and not m.lamina.is_layered)
    trial.compare_pictures("copy", trial.picture(), expected, 0.15)


@case("Principled copies of all materials", beside=False)
def principled_copies(trial):
    """All of a file's materials in one click: a Principled node with the conversion's values for each; the layers stay in the file."""
    layered = [trial.material(surface, name) for name, surface in (("paint", PAINT), ("metal", METAL))]
    for material in layered:
        trial.show(material, name=material.name)
    bpy.ops.lamina.principled_copies()
    copies = {read_back(m)["Metallic"]: read_back(m) for m in bpy.data.materials if not m.lamina.is_layered and read_back(m)}
    for material in layered:
        expected = expected_of(trial, material, PAINT)
        got = copies.get(expected["Metallic"])
        trial.require(f"{material.name} has a copy", got is not None)
        for socket in expected if got else ():
            trial.compare(f"{material.name}: {socket}", got[socket], expected[socket], WITHIN, least=0.0 if socket == "Base Color" else 0.5)
    trial.require("the layers stay", all(m.lamina.is_layered for m in layered))
