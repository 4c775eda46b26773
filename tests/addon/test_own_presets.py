# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets that users save: textures come along, what cannot is said before, and nothing of the user's file changes."""

import re
import sys
from pathlib import Path

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from support.animation import driven, keyed

from lamina.addon.blender import user_folders
from lamina.addon.blender.images import read_png, write_png
from lamina.addon.library import asset_library, preset_assets, preset_catalogues, thumbnails, user_presets
from lamina.addon.material import layers, material
from lamina.addon.material.elements import node_of
from lamina.addon.material.state import is_stale
from lamina.addon.operators import preset_operators
from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

STACK = Stack.from_dict(
    {
        "name": "Mine",
        "layers": [{"kind": "dielectric", "roughness": 0.1}, {"kind": "dielectric", "name": "Hidden", "roughness": 0.5}],
        "base": {"kind": "lambert", "color": [0.5, 0.2, 0.1]},
    }
)
CHECKER = (np.indices((8, 8)).sum(axis=0) % 2 * 255).astype(np.uint8)[..., None].repeat(3, axis=-1)
RENDER = thumbnails.render_thumbnail  # without the quick one of the tests


@pytest.fixture(autouse=True)
def folder(blender, tmp_path, monkeypatch):
    """The folder of own presets, of this test alone; the picture is none of the material, as that takes seconds."""
    monkeypatch.setenv(user_folders.PRESETS_VARIABLE, str(tmp_path / "own"))
    monkeypatch.setattr(preset_assets, "render_thumbnail", lambda _, path: write_png(path, CHECKER.repeat(2, 0).repeat(2, 1)))
    yield tmp_path / "own"
    for library in [l for l in bpy.context.preferences.filepaths.asset_libraries if Path(library_path(l)) == tmp_path / "own"]:
        bpy.context.preferences.filepaths.asset_libraries.remove(library)


def library_path(library) -> str:
    return library.path.rstrip("/\\")


def shown():
    """A new active object with a material of two layers, the lower one hidden."""
    item = bpy.data.objects.new("object", bpy.data.meshes.new("mesh"))
    bpy.context.collection.objects.link(item)
    bpy.context.view_layer.objects.active = item
    owner = bpy.data.materials.new("Mine")
    item.data.materials.append(owner)
    material.apply_stack(owner, STACK, "analytic")
    owner.lamina.layers[1].visible = False
    return owner


def textured(tmp_path):
    """The same with an image in the roughness of its layer, by a mapping and a ramp, and noise in its base."""
    owner = shown()
    write_png(tmp_path / "checker.png", CHECKER)
    tree = owner.node_tree
    texture, ramp, noise = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexImage", "ValToRGB", "TexNoise"))
    texture.image = bpy.data.images.load(str(tmp_path / "checker.png"))
    texture.image.colorspace_settings.name = "Non-Color"
    tree.links.new(texture.outputs["Color"], ramp.inputs[0])
    tree.links.new(ramp.outputs["Color"], node_of(owner.lamina.layers[0]).inputs["Roughness"])
    tree.links.new(noise.outputs["Color"], node_of(owner.lamina.base).inputs["Color"])
    return owner


def contents() -> dict:
    """Everything in the file that saving a preset could leave or change."""
    kinds = ("materials", "node_groups", "images", "texts", "actions", "objects", "scenes", "meshes")
    found = {kind: sorted(item.name for item in getattr(bpy.data, kind) if item.name != "Render Result") for kind in kinds}
    return found | {
        "packed": [image.name for image in bpy.data.images if image.packed_file is not None],
        "nodes": [
            (m.name, sorted(n.name for n in m.node_tree.nodes), sorted(k.to_socket.path_from_id() for k in m.node_tree.links)) for m in bpy.data.materials
        ],
    }


def kinds_of_groups() -> list[str]:
    """The names of all node groups, without the hashes of lobe sets."""
    return sorted(re.sub(r"(Lobe set) \w+", r"\1", group.name) for group in bpy.data.node_groups)


def test_a_texture_is_there_in_another_file(folder, tmp_path):
    owner = textured(tmp_path)
    before = contents()
    assert bpy.ops.lamina.save_preset(name="Mine") == {"FINISHED"}
    assert contents() == before
    assert sorted(path.name for path in folder.iterdir()) == ["blender_assets.cats.txt", "mine.blend", "mine.json", "mine.png"]
    stack = material.stack_of(owner)
    (tmp_path / "checker.png").unlink()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    other = shown()
    groups = kinds_of_groups()
    assert bpy.ops.lamina.apply_user_preset(name="mine") == {"FINISHED"}
    assert material.stack_of(other, hidden=True).layers == stack.layers and other.lamina.stack_name == "Mine"
    ramp = node_of(other.lamina.layers[0]).inputs["Roughness"].links[0].from_node
    image = ramp.inputs[0].links[0].from_node.image
    assert image.packed_file is not None and tuple(image.size) == (8, 8) and image.colorspace_settings.name == "Non-Color"
    pixels = np.array(image.pixels).reshape(8, 8, 4)[::-1, :, :3]
    assert np.array_equal(np.rint(255 * pixels), CHECKER)
    assert node_of(other.lamina.base).inputs["Color"].links[0].from_node.bl_idname == "ShaderNodeTexNoise"
    assert [m.name for m in bpy.data.materials] == ["Mine"] and kinds_of_groups() == groups
    assert not is_stale(other)


def test_a_file_of_ones_own_keeps_what_is_edited_in_json_later(folder, tmp_path):
    textured(tmp_path)
    bpy.ops.lamina.save_preset(name="Mine")
    path = folder / "mine.json"
    path.write_text(path.read_text().replace('"ior": 1.5', '"ior": 1.7'))
    owner = shown()
    bpy.ops.lamina.apply_user_preset(name="mine")
    assert material.stack_of(owner).layers[0]["ior"] == 1.7 and node_of(owner.lamina.layers[0]).inputs["Roughness"].is_linked
    path.write_text('{"base": {"kind": "conductor"}}')
    before = contents()
    with pytest.raises(RuntimeError, match="the layers of .* are others"):
        bpy.ops.lamina.apply_user_preset(name="mine")
    assert contents() == before


def test_an_own_preset_stands_in_the_asset_browser(folder, tmp_path):
    textured(tmp_path)
    bpy.ops.lamina.save_preset(name="My Own")
    libraries = [l for l in bpy.context.preferences.filepaths.asset_libraries if Path(library_path(l)) == folder]
    assert [(l.name, l.import_method) for l in libraries] == [(asset_library.OWN_NAME, "APPEND")]
    with bpy.data.libraries.load(str(user_presets.asset_of("my_own")), link=False, assets_only=True) as (there, here):
        assert there.materials == ["My Own"]
        here.materials = there.materials
    dropped = here.materials[0]
    assert dropped.asset_data.catalog_id == preset_catalogues.catalogue_id("Own Presets")
    assert dropped.asset_data.catalog_id in (folder / "blender_assets.cats.txt").read_text()
    assert dropped.lamina.is_layered and [e.name for e in dropped.lamina.layers] == ["Dielectric"] and tuple(dropped.preview.image_size) == (16, 16)
    (folder / "blender_assets.cats.txt").write_text("VERSION 1\nmine of the user\n")
    bpy.ops.lamina.save_preset(name="Second")
    text = (folder / "blender_assets.cats.txt").read_text()
    assert text.startswith("VERSION 1\nmine of the user\n") and text.count("Lamina/Own Presets") == 1
    bpy.ops.lamina.save_preset(name="Third")
    assert (folder / "blender_assets.cats.txt").read_text() == text
    asset_library.unregister()
    assert not [l for l in bpy.context.preferences.filepaths.asset_libraries if Path(library_path(l)) == folder]
    asset_library.register()
    bpy.ops.lamina.remove_preset(name="third")
    assert not [path for path in folder.iterdir() if path.stem == "third"]


def test_a_material_of_the_presets_name_keeps_it(folder, tmp_path):
    owner, other = textured(tmp_path), bpy.data.materials.new("Lovely")
    bpy.ops.lamina.save_preset(name="Lovely")
    assert (owner.name, other.name) == ("Mine", "Lovely")
    with bpy.data.libraries.load(str(user_presets.asset_of("lovely")), assets_only=True) as (there, _):
        assert there.materials == ["Lovely"]


def test_without_openimageio_there_is_a_picture_all_the_same(folder, tmp_path, monkeypatch):
    textured(tmp_path)
    monkeypatch.setattr(preset_assets, "render_thumbnail", lambda owner, path: RENDER(owner, path, 16, 1))
    with monkeypatch.context() as lacking:
        lacking.setitem(sys.modules, "OpenImageIO", None)
        assert bpy.ops.lamina.save_preset(name="Mine") == {"FINISHED"}
    pixels, texts = read_png(user_presets.picture_of("mine"))
    assert pixels.shape == (16, 16, 3) and pixels.std() > 10.0 and texts == {}
    assert np.array_equal(thumbnails.pixels_of(user_presets.picture_of("mine")), pixels)


def test_a_picture_that_fails_is_said_and_the_preset_is_there(folder, tmp_path, monkeypatch, capfd):
    from lamina.reference_py.errors import LaminaError

    def fail(*_):
        raise LaminaError("no engine")

    textured(tmp_path)
    monkeypatch.setattr(preset_assets, "render_thumbnail", fail)
    assert bpy.ops.lamina.save_preset(name="Mine") == {"FINISHED"}
    assert "the preset has no picture: no engine" in capfd.readouterr().out
    assert user_presets.asset_of("mine").is_file() and not user_presets.picture_of("mine").exists()


@pytest.mark.parametrize(
    "fault, told",
    [
        ("taken", "taken by a preset of yours"),
        ("painted", "image checker.png has changes that are not saved"),
        ("gone", "there is no file"),
        ("blocked", "cannot make this folder"),
    ],
)
def test_what_cannot_be_saved_is_refused_before_a_picture_is_rendered(folder, tmp_path, monkeypatch, fault, told):
    owner = textured(tmp_path)
    image = bpy.data.images["checker.png"]
    if fault == "taken":
        bpy.ops.lamina.save_preset(name="Mine")
    elif fault == "painted":
        image.pixels[0] = 0.5
        image.update()
    elif fault == "gone":
        (tmp_path / "checker.png").unlink()
    else:
        folder.write_text("a file where the folder should be")
    before = contents(), sorted(tmp_path.rglob("*"))
    monkeypatch.setattr(preset_assets, "render_thumbnail", lambda *_: pytest.fail("it rendered"))
    with pytest.raises(RuntimeError, match=told) as error:
        bpy.ops.lamina.save_preset(name="Mine")
    assert len(str(error.value).strip().splitlines()) == 1
    assert (contents(), sorted(tmp_path.rglob("*"))) == before and owner.name == "Mine"


def test_the_dialog_names_what_stays_behind(folder, tmp_path):
    owner = textured(tmp_path)
    assert preset_assets.left_out(owner) == ["Hidden layers stay behind: 1"]
    layers.remove_layer(owner, 1)
    assert preset_assets.left_out(owner) == []
    node = node_of(owner.lamina.layers[0])
    keyed(node.inputs["IOR"], {1: 1.2, 11: 1.6})
    driven(node.inputs["Thickness"], "frame")
    place = owner.node_tree.nodes.new("ShaderNodeTexCoord")
    place.object = bpy.context.object
    texture = next(n for n in owner.node_tree.nodes if n.bl_idname == "ShaderNodeTexImage")
    owner.node_tree.links.new(place.outputs["Object"], texture.inputs["Vector"])
    texture.image.source = "SEQUENCE"
    drawn = []

    class Layout:
        def prop(self, *_):
            pass

        def label(self, text, **_):
            drawn.append(text)

    preset_operators.LAMINA_OT_save_preset.draw(type("Operator", (), {"layout": Layout()})(), bpy.context)
    assert drawn == [
        "Drivers and keyframes stay behind; values are those of now",
        "The object of Texture Coordinate stays behind",
        "checker.png stays a file of its own, which the preset points to",
    ]
    before = contents()
    assert bpy.ops.lamina.save_preset(name="Mine") == {"FINISHED"}
    assert contents() == before and place.object is not None and len(owner.node_tree.animation_data.drivers) == 1
    with bpy.data.libraries.load(str(user_presets.asset_of("mine"))) as (there, _):
        assert not (there.objects or there.scenes or there.actions) and there.materials == ["Mine"]


def test_export_says_that_textures_stay_behind(tmp_path, capfd):
    textured(tmp_path)
    bpy.ops.lamina.export_stack(filepath=str(tmp_path / "stack.json"))
    assert "hidden layers left out: 1; values whose texture or animation is left out: 2" in capfd.readouterr().out
