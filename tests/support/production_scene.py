# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene as productions have them, made by code: 202 objects, 64 materials of which 20 are Lamina's, five of those with textures.

folder/shots/Küche 厨房.blend     the scene
folder/lib/set.blend            objects, a mesh and a collection that the scene links to
folder/lib/parts.blend          what that library links to
folder/tex, folder/fonts        a picture, UDIM tiles, a sequence, a font; and a sound
"""

import shutil
import struct
import wave
from pathlib import Path

import bpy
import numpy as np

from lamina.addon.blender import oiio
from lamina.addon.blender.versions import node_tree, set_media_type
from lamina.addon.material.elements import kind_of, node_of
from lamina.addon.material.material import apply_stack
from lamina.addon.rendering.geometry import lathe, plane_mesh
from lamina.reference_py.material import presets
from lamina.reference_py.material.schema import SCATTERING

SCENE = "shots/Küche 厨房.blend"
LIBRARY, PARTS = "lib/set.blend", "lib/parts.blend"
PICTURE, TILES, SEQUENCE, FONT, SOUND = "tex/wood 漆.png", "tex/tiles.<UDIM>.png", "tex/dirt_0001.png", "fonts/Schrift.woff2", "tex/hum.wav"
OBJECTS, MATERIALS, LAMINA, TEXTURED = 202, 64, 20, 5
# An object alone on its mesh, two on one mesh, one of the library, and one whose mesh alone is the library's.
CUP, TWIN, LINKED, HALF = "Cup", "Twin A", "Linked Cup", "Half Cup"


def build(folder: Path, tier: str = "weidlich_wilkie", backend: str = "auto", osl: bool = True) -> Path:
    """Write the scene into an empty folder; returns the .blend file. Leaves it open. Without `osl` Cycles starts it in a twentieth of the time."""
    for name in ("shots", "lib", "tex", "fonts"):
        (folder / name).mkdir(parents=True)
    _files(folder)
    _library(folder)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    path = folder / SCENE
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=True)  # relative paths need a place
    _settings(scene, osl)
    materials = [*_lamina_materials(folder, tier, backend), *_stock_materials(folder)]
    _linked(scene, folder)
    mesh = _cup("Cup")
    for i, name in enumerate((CUP, TWIN, "Twin B")):
        item = _add(scene, name, mesh if i == 1 else bpy.data.objects[TWIN].data if i == 2 else _cup("Own"), (i - 1.0, -0.6, 0.3))
        if i < 2:
            item.data.materials.append(materials[i])
    text = bpy.data.curves.new("Sign", "FONT")
    text.body, text.font = "Küche", bpy.data.fonts.load(str(folder / FONT))
    _add(scene, "Sign", text, (-0.8, 0.8, 0.4)).scale = (0.6, 0.6, 0.6)
    bpy.data.sounds.load(str(folder / SOUND)).use_fake_user = True
    floor = _add(scene, "Floor", plane_mesh("Floor", 3.0), (0.0, 0.0, 0.0))
    floor.data.materials.append(materials[LAMINA])
    shared = [_cup(f"Cup {m.name}") for m in materials]
    for material, each in zip(materials, shared):
        each.materials.append(material)
    for i in range(OBJECTS - len(scene.objects)):
        _add(scene, f"Prop {i:03d}", shared[i % len(shared)], (0.35 * (i % 14) - 2.3, 0.35 * (i // 14) - 1.0, 0.0)).scale = (0.3, 0.3, 0.3)
    bpy.ops.file.make_paths_relative()
    bpy.ops.wm.save_mainfile(compress=True)
    return path


def write_sound(path: Path, pitch: int = 440) -> None:
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(8000)
        file.writeframes(b"".join(struct.pack("<h", int(9000 * np.sin(i * pitch / 1273.0))) for i in range(800)))


def write_picture(path: Path, seed: int) -> None:
    """A blurred pattern of 64 pixels that stands for a texture."""
    values = np.random.default_rng(seed).uniform(40, 250, (8, 8, 3)).astype(np.uint8)
    pixels = values.repeat(8, axis=0).repeat(8, axis=1)
    oiio.write(path, {c: pixels[..., i] for i, c in enumerate("RGB")}, {})


def _files(folder: Path) -> None:
    for i, name in enumerate((PICTURE, TILES.replace("<UDIM>", "1001"), TILES.replace("<UDIM>", "1002"), SEQUENCE, "tex/dirt_0002.png", "tex/lid.png")):
        write_picture(folder / name, i)
    write_sound(folder / SOUND)
    fonts = Path(bpy.utils.resource_path("LOCAL")) / "datafiles" / "fonts"
    shutil.copyfile(min((f for f in fonts.iterdir() if f.suffix == ".woff2"), key=lambda f: f.stat().st_size), folder / FONT)


def _library(folder: Path) -> None:
    """parts.blend has a lid, with a texture; set.blend links to it, and has a cup and a collection of both."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / PARTS), compress=True)
    lid = _add(bpy.context.scene, "Lid", _cup("Lid"), (0.0, 0.0, 1.0))
    lid.data.materials.append(_textured_stock("Lid", bpy.data.images.load(str(folder / "tex/lid.png"))))
    bpy.ops.file.make_paths_relative()
    bpy.ops.wm.save_mainfile(compress=True)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / LIBRARY), compress=True)
    with bpy.data.libraries.load(str(folder / PARTS), link=True, relative=True) as (_, chosen):
        chosen.objects = ["Lid"]
    cup = _add(bpy.context.scene, LINKED, _cup("Linked Cup"), (1.6, -0.6, 0.3))
    cup.data.materials.append(_plain("Linked", (0.1, 0.5, 0.2, 1.0)))
    together = bpy.data.collections.new("Set")
    together.objects.link(cup)
    together.objects.link(chosen.objects[0])
    bpy.context.scene.collection.children.link(together)
    bpy.ops.wm.save_mainfile(compress=True)


def _linked(scene, folder: Path) -> None:
    with bpy.data.libraries.load(str(folder / LIBRARY), link=True, relative=True) as (_, chosen):
        chosen.objects, chosen.collections, chosen.meshes = [LINKED], ["Set"], ["Linked Cup"]
    scene.collection.objects.link(chosen.objects[0])
    _add(scene, HALF, chosen.meshes[0], (-1.6, -0.6, 0.3))
    for i in range(40):
        empty = _add(scene, f"Set {i:02d}", None, (0.4 * (i % 10) - 1.8, 1.0 + 0.4 * (i // 10), 0.0))
        empty.instance_type, empty.instance_collection, empty.scale = "COLLECTION", chosen.collections[0], (0.15, 0.15, 0.15)


def _settings(scene, osl: bool) -> None:
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 64, 40, 100
    scene.cycles.samples, scene.cycles.device, scene.cycles.shading_system = 4, "CPU", osl
    set_media_type(scene.render.image_settings, "IMAGE")
    camera = _add(scene, "Camera", bpy.data.cameras.new("Camera"), (0.0, -5.0, 3.0))
    camera.rotation_euler = (1.05, 0.0, 0.0)
    scene.camera = camera
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy = 3.0
    _add(scene, "Sun", sun, (0.0, 0.0, 4.0)).rotation_euler = (0.6, 0.2, 0.0)


def _lamina_materials(folder: Path, tier: str, backend: str) -> list[bpy.types.Material]:
    # every quality knows these
    names = [name for name in presets.names() if (layers := presets.load(name).layers) and not any(layer.has(SCATTERING) for layer in layers)][:LAMINA]
    picture, made = bpy.data.images.load(str(folder / PICTURE)), []
    for i, name in enumerate(names):
        material = bpy.data.materials.new(name)
        apply_stack(material, presets.load(name), tier, backend)
        if i < TEXTURED:
            link_texture(material, picture)
        made.append(material)
    return made


def link_texture(material: bpy.types.Material, picture: bpy.types.Image) -> None:
    """Let a picture give the roughness of a material's top layer."""
    tree, layer = material.node_tree, material.lamina.shown_layers[0]
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = picture
    label = next(p.label for p in kind_of(layer).sockets if p.name == "roughness")
    tree.links.new(texture.outputs["Color"], node_of(layer).inputs[label])


def _stock_materials(folder: Path) -> list[bpy.types.Material]:
    tiles = bpy.data.images.load(str(folder / TILES.replace("<UDIM>", "1001")))
    tiles.source = "TILED"
    sequence = bpy.data.images.load(str(folder / SEQUENCE))
    sequence.source = "SEQUENCE"
    made = [_textured_stock("Tiles", tiles), _textured_stock("Dirt", sequence)]
    user = made[1].node_tree.nodes["Image Texture"].image_user
    user.frame_duration, user.use_auto_refresh = 2, True
    rest = MATERIALS - LAMINA - len(made) - 2  # two are the libraries'
    return made + [_plain(f"Plain {i:02d}", (i % 5 / 5.0, i % 7 / 7.0, i % 3 / 3.0, 1.0)) for i in range(rest)]


def _plain(name: str, color) -> bpy.types.Material:
    material = bpy.data.materials.new(name)
    node_tree(material).nodes["Principled BSDF"].inputs["Base Color"].default_value = color
    return material


def _textured_stock(name: str, image: bpy.types.Image) -> bpy.types.Material:
    material = _plain(name, (1.0, 1.0, 1.0, 1.0))
    tree = material.node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    tree.links.new(texture.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Base Color"])
    return material


def _cup(name: str) -> bpy.types.Mesh:
    return lathe(name, np.array([[0.0, 0.5], [0.3, 0.45], [0.4, 0.0], [0.3, -0.3], [0.0, -0.3]]), 12)


def _add(scene, name: str, data, place) -> bpy.types.Object:
    item = bpy.data.objects.new(name, data)
    scene.collection.objects.link(item)
    item.location = place
    return item
