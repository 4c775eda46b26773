# SPDX-License-Identifier: GPL-3.0-or-later
"""Conversions in Blender: textures stay linked, energy is the truth's in a render, and a bake leaves nothing but files."""

import json
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from lamina.addon.blender.images import read_png
from lamina.addon.blender.versions import node_tree
from lamina.addon.check import check
from lamina.addon.cli.main import run
from lamina.addon.exchange import conversion, materialx_import, textures
from lamina.addon.exchange.sources import PRINCIPLED, principled_of
from lamina.addon.material import material as materials
from lamina.addon.material.elements import node_of
from lamina.addon.material.hand_over import VALUES
from lamina.addon.material.roles import ROLE, give
from lamina.addon.operators import texture_operator
from lamina.addon.operators.exchange_operators import REPORT_TEXT
from lamina.addon.rendering.geometry import plane_mesh
from lamina.addon.rendering.measure import render_furnace
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.exchange import openpbr
from lamina.reference_py.exchange.materialx import load_mtlx, to_mtlx
from lamina.reference_py.exchange.openpbr import to_openpbr
from lamina.reference_py.exchange.principled import to_principled
from lamina.reference_py.material import presets
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.registry import make_model

pytestmark = pytest.mark.blender

COATED = Stack.from_dict(
    {
        "name": "Coated",
        "layers": [{"kind": "dielectric", "tint": [0.9, 0.8, 0.7]}],
        "base": {"kind": "lambert", "color": [0.7, 0.4, 0.2]},
    }
)
SIZE = 32


@pytest.fixture
def plane(blender):
    """The active object: a plane with UVs, without a material."""
    item = bpy.data.objects.new("plane", plane_mesh("plane", 1.0))
    bpy.context.collection.objects.link(item)
    bpy.context.view_layer.objects.active = item
    return item


def principled(item, **values) -> bpy.types.Material:
    """The object's new material with a Principled node; keys are socket names with _ for a space."""
    material = bpy.data.materials.new("Paint")
    tree = node_tree(material)
    tree.nodes.clear()
    node, output = tree.nodes.new(PRINCIPLED), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    for key, value in values.items():
        give(node.inputs[key.replace("_", " ")], value)
    item.data.materials.append(material)
    return material


def layered(item, stack=COATED) -> bpy.types.Material:
    material = bpy.data.materials.new("Coated")
    item.data.materials.append(material)
    materials.apply_stack(material, stack)
    return material


def ramp(material, color=False):
    """Output of nodes that give U in red, or as a value."""
    tree = material.node_tree
    uv, split = tree.nodes.new("ShaderNodeUVMap"), tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(uv.outputs[0], split.inputs[0])
    return uv.outputs[0] if color else split.outputs["X"]


def feeding(socket) -> set[str]:
    """Names of all nodes before a socket."""
    return {n for link in socket.links for n in {link.from_node.name}.union(*(feeding(s) for s in link.from_node.inputs))}


def saved_image(path: Path) -> None:
    image = bpy.data.images.new(path.stem, 4, 4)
    image.filepath_raw, image.file_format = str(path), "PNG"
    image.save()
    bpy.data.images.remove(image)


def counts() -> dict:
    names = ("scenes", "objects", "meshes", "materials", "images", "worlds", "node_groups")
    return {name: sorted(block.name for block in getattr(bpy.data, name)) for name in names}


def test_a_principled_material_becomes_a_stack_with_its_textures(plane):
    material = principled(plane, Coat_Weight=1.0, Coat_Roughness=0.1, Sheen_Weight=0.5)
    node = principled_of(material)
    color, value = ramp(material, color=True), ramp(material)
    bump = material.node_tree.nodes.new("ShaderNodeBump")
    names = [color.node.name, value.node.name, bump.name]
    for source, socket in ((color, "Base Color"), (value, "Roughness"), (value, "Coat Roughness"), (bump.outputs[0], "Normal"), (value, "Metallic")):
        material.node_tree.links.new(source, node.inputs[socket])
    assert bpy.ops.lamina.convert_principled("EXEC_DEFAULT") == {"FINISHED"}
    coat, gloss = (node_of(layer) for layer in material.lamina.layers)
    base = node_of(material.lamina.base)
    assert names[0] in feeding(base.inputs["Color"])
    assert names[1] in feeding(gloss.inputs["Roughness"]) and names[1] in feeding(coat.inputs["Roughness"])
    assert names[2] in feeding(base.inputs["Normal"]) and names[2] in feeding(gloss.inputs["Normal"])
    assert [n[ROLE] for n in material.node_tree.nodes if n.bl_idname == PRINCIPLED] == [VALUES]
    told = bpy.data.texts[REPORT_TEXT].as_string()
    assert "lost: Sheen Weight 0.5" in told and "lost: Metallic texture" in told and "worst albedo error" in told


@pytest.mark.parametrize("tier, word", [("auto", "kept"), ("analytic", "lost")])
def test_stock_nodes_alone_lose_the_textures_that_they_do_not_follow(plane, tmp_path, tier, word):
    """As Check says: tables follow them, and the tier analytic does not; a normal is followed by both."""
    material = principled(plane, Coat_Weight=1.0, Coat_Roughness=0.1)
    for name in ("Base Color", "Coat Roughness", "Normal"):
        material.node_tree.links.new(ramp(material, color=name != "Coat Roughness"), principled_of(material).inputs[name])
    _, notes = conversion.to_lamina(material, tier, "nodes")
    words = {name: next(n for n in notes if f": {name} texture: " in n).split(":")[0] for name in ("Base Color", "Coat Roughness", "Normal")}
    assert words == {"Base Color": word, "Coat Roughness": word, "Normal": "kept"}
    ignored = [f for f in check.find(material, bpy.context.scene, bpy.context.preferences) if f.code == "texture_ignored"]
    assert len(ignored) == {"kept": 0, "lost": 2}[word]
    saved_image(tmp_path / "wood.png")
    file, new = tmp_path / "wood.mtlx", bpy.data.materials.new("new")
    file.write_text(
        '<materialx version="1.39" colorspace="lin_rec709"><image name="i" type="color3"><input name="file" type="filename" value="wood.png"/></image>'
        '<standard_surface name="s" type="surfaceshader"><input name="base_color" type="color3" nodename="i"/></standard_surface></materialx>'
    )
    imported = materialx_import.apply_material(new, load_mtlx(file)[0], tier, "nodes")
    assert [note.split(":")[0] for note in imported.notes] == [word]


def test_light_below_the_surface_becomes_a_medium_and_comes_back(plane):
    material = principled(plane, Base_Color=(0.8, 0.5, 0.2), Subsurface_Weight=1.0, Subsurface_Radius=(1.0, 1.0, 1.0), Subsurface_Scale=0.02)
    report, _ = conversion.to_lamina(material)
    body = materials.stack_of(material).layers[0]
    assert body["density"] == pytest.approx(50.0) and report.match.soft_light < 0.04
    copy, *_ = conversion.principled_copy(material)
    node = principled_of(copy)
    assert node.inputs["Subsurface Weight"].default_value == 1.0 and node.inputs["Subsurface Scale"].default_value == pytest.approx(0.02)
    assert tuple(node.inputs["Base Color"].default_value)[:3] == pytest.approx((0.8, 0.5, 0.2), abs=0.04)


@pytest.mark.parametrize("name", ["Subsurface Weight", "Subsurface Scale", "Subsurface Radius", "Subsurface Anisotropy", "Metallic"])
def test_a_texture_that_a_stack_cannot_have_is_said_once(plane, name):
    material = principled(plane, Subsurface_Weight=1.0)
    material.node_tree.links.new(ramp(material), principled_of(material).inputs[name])
    report, notes = conversion.to_lamina(material)
    lines = [line for line in [*report.lines(), *notes] if line.startswith(f"lost: {name} texture: ")]
    assert len(lines) == 1


def test_an_image_of_the_color_below_the_surface_stays_an_image(plane):
    material = principled(plane, Subsurface_Weight=1.0)
    source = ramp(material, color=True)
    name = source.node.name
    material.node_tree.links.new(source, principled_of(material).inputs["Base Color"])
    report, _ = conversion.to_lamina(material)
    assert "density" not in materials.stack_of(material).layers[0] and name in feeding(node_of(material.lamina.base).inputs["Color"])
    assert any("which follows a texture" in str(loss) for loss in report.losses)


def test_converting_is_one_undo_step(plane):
    principled(plane, Roughness=0.3)
    bpy.ops.ed.undo_push(message="before")
    assert bpy.ops.lamina.convert_principled("EXEC_DEFAULT", True) == {"FINISHED"}
    assert bpy.data.materials["Paint"].lamina.is_layered
    bpy.ops.ed.undo()
    material = bpy.data.materials["Paint"]
    assert not material.lamina.is_layered
    assert principled_of(material).inputs["Roughness"].default_value == pytest.approx(0.3)


def test_what_is_no_principled_material_is_refused_and_left_alone(plane):
    material = layered(plane)
    before = materials.stack_of(material)
    with pytest.raises(LaminaError, match="only a Principled BSDF"):
        conversion.to_lamina(material)
    assert materials.stack_of(material) == before
    assert not bpy.ops.lamina.convert_principled.poll()


def test_a_principled_copy_renders_as_bright_as_the_truth(plane):
    """In a furnace at 40 degrees; what the stack itself would be as a plain mapping is a fifth too bright."""
    material = layered(plane)
    copy, report, _ = conversion.principled_copy(material)
    assert material.lamina.is_layered and not copy.lamina.is_layered
    assert [n.bl_idname for n in copy.node_tree.nodes].count(PRINCIPLED) == 1 and len(copy.node_tree.nodes) == 2
    measured, stderr = render_furnace(copy, [40.0], samples=64, size=16)
    wo = spherical(np.radians(40.0), 0.0)
    exact = make_model("adding", COATED).albedo(wo)
    plain = make_model("principled_coat", COATED).albedo(wo)
    print(f"Principled copy {measured[0]}, truth {exact}, plain mapping {plain}, stated worst error {report.match.worst:.3f}")
    assert np.all(np.abs(measured[0] - exact) <= report.match.worst + 4.0 * stderr[0])
    assert np.all(np.abs(measured[0] - exact) <= 0.03 * exact + 4.0 * stderr[0])
    assert np.max(plain / exact) > 1.2


def test_a_copys_textures_are_those_of_the_stack(plane):
    material = layered(plane)
    layer, base = node_of(material.lamina.layers[0]), node_of(material.lamina.base)
    color, value = ramp(material, color=True), ramp(material)
    for source, target in (
        (color, base.inputs["Color"]),
        (value, layer.inputs["Roughness"]),
        (color, layer.inputs["Tint"]),
        (value, layer.inputs["Thickness"]),
    ):
        material.node_tree.links.new(source, target)
    names, before = (color.node.name, value.node.name), sorted(n.name for n in material.node_tree.nodes)
    copy, _, told = conversion.principled_copy(material)
    node = principled_of(copy)
    assert names[0] in feeding(node.inputs["Base Color"]) and names[0] in feeding(node.inputs["Coat Tint"])
    assert names[1] in feeding(node.inputs["Coat Roughness"])
    assert "lost: 1 more links of layers: Principled has no place for them" in told
    assert sorted(n.name for n in material.node_tree.nodes) == before


def test_the_operators_go_by_way_of_files(plane, tmp_path):
    material = layered(plane)
    file = tmp_path / "coated.mtlx"
    assert bpy.ops.lamina.export_mtlx("EXEC_DEFAULT", filepath=str(file)) == {"FINISHED"}
    assert bpy.ops.lamina.principled_copy("EXEC_DEFAULT") == {"FINISHED"}
    assert "Coated Principled" in bpy.data.materials
    assert bpy.ops.lamina.import_mtlx("EXEC_DEFAULT", filepath=str(file)) == {"FINISHED"}
    stack = materials.stack_of(material)
    np.testing.assert_allclose(stack.base["color"], COATED.base["color"], atol=2e-3)
    file.write_text("<materialx>")
    with pytest.raises(RuntimeError, match="not valid XML"):
        bpy.ops.lamina.import_mtlx("EXEC_DEFAULT", filepath=str(file))
    assert materials.stack_of(material) == stack


WOOD = """<nodegraph name="g"><tiledimage name="i" type="color3"><input name="file" type="filename" value="wood.png" colorspace="srgb_texture"/>
<input name="uvtiling" type="vector2" value="2,3"/></tiledimage><image name="r" type="float"><input name="file" type="filename" value="wood.png"/></image>
<image name="n" type="vector3"><input name="file" type="filename" value="wood.png"/></image>
<normalmap name="nm" type="vector3"><input name="in" type="vector3" nodename="n"/></normalmap>
<image name="m" type="float"><input name="file" type="filename" value="gone.png"/></image>
<output name="c" type="color3" nodename="i"/><output name="r" type="float" nodename="r"/>
<output name="n" type="vector3" nodename="nm"/><output name="m" type="float" nodename="m"/></nodegraph>"""


def test_a_file_becomes_materials_with_its_images(plane, tmp_path):
    saved_image(tmp_path / "wood.png")
    links = (("base_color", "color3", "c"), ("specular_roughness", "float", "r"), ("normal", "vector3", "n"), ("coat", "float", "m"))
    inputs = "".join(f'<input name="{name}" type="{kind}" nodegraph="g" output="{output}"/>' for name, kind, output in links)
    material = '<surfacematerial name="{0}" type="material"><input name="surfaceshader" type="surfaceshader" nodename="{1}"/></surfacematerial>'
    file = tmp_path / "wood.mtlx"
    file.write_text(
        f'<materialx version="1.39" colorspace="lin_rec709">{WOOD}<standard_surface name="s" type="surfaceshader">{inputs}</standard_surface>'
        f'<gltf_pbr name="t" type="surfaceshader"/>{material.format("Wood", "s")}{material.format("Gold", "t")}</materialx>'
    )
    assert bpy.ops.lamina.import_materials("EXEC_DEFAULT", filepath=str(file)) == {"FINISHED"}
    wood, gold = bpy.data.materials["Wood"], bpy.data.materials["Gold"]
    assert plane.active_material == wood and gold.use_fake_user and gold.lamina.base.kind == "conductor"
    gloss, base = node_of(wood.lamina.layers[0]), node_of(wood.lamina.base)
    before_color = [wood.node_tree.nodes[name] for name in feeding(base.inputs["Color"])]
    color = next(node for node in before_color if node.bl_idname == "ShaderNodeTexImage")
    mapping = next(node for node in before_color if node.bl_idname == "ShaderNodeMapping")
    assert color.image.colorspace_settings.name == "sRGB" and tuple(mapping.inputs["Scale"].default_value) == (2.0, 3.0, 1.0)
    rough = gloss.inputs["Roughness"].links[0].from_node
    assert rough.image.colorspace_settings.name == "Non-Color" and rough.image != color.image, "one file in two color spaces"
    assert base.inputs["Normal"].links[0].from_node.bl_idname == gloss.inputs["Normal"].links[0].from_node.bl_idname == "ShaderNodeNormalMap"
    told = bpy.data.texts[REPORT_TEXT].as_string()
    assert "lost: coat image" in told and "gone.png: there is no such file" in told and "kept: base_color image wood.png" in told
    before = counts()
    file.write_text("<materialx>")
    with pytest.raises(RuntimeError, match="not valid XML"):
        bpy.ops.lamina.import_materials("EXEC_DEFAULT", filepath=str(file))
    assert counts() == before


GRADED = """<texcoord name="t" type="vector2"/><place2d name="p" type="vector2"><input name="texcoord" type="vector2" nodename="t"/>
<input name="scale" type="vector2" value="0.5,0.25"/><input name="rotate" type="float" value="90"/></place2d>
<image name="i" type="color3"><input name="file" type="filename" value="wood.&lt;UDIM&gt;.png" colorspace="srgb_texture"/>
<input name="texcoord" type="vector2" nodename="p"/></image>
<multiply name="m" type="color3"><input name="in1" type="color3" nodename="i"/><input name="in2" type="color3" value="0.5,1,0.25"/></multiply>
<image name="r" type="float"><input name="file" type="filename" value="rough.png"/></image>
<remap name="rr" type="float"><input name="in" type="float" nodename="r"/><input name="outlow" type="float" value="0.2"/></remap>
<open_pbr_surface name="s" type="surfaceshader"><input name="base_color" type="color3" nodename="m"/>
<input name="specular_roughness" type="float" nodename="rr"/></open_pbr_surface>"""


MIXED = """<image name="a" type="float"><input name="file" type="filename" value="mask.png"/></image>
<mix name="m" type="color3"><input name="bg" type="color3" value="0.8,0.1,0.1"/><input name="fg" type="color3" value="0.1,0.1,0.8"/>
<input name="mix" type="float" nodename="a"/></mix>
<multiply name="h" type="color3"><input name="in1" type="color3" nodename="m"/><input name="in2" type="float" value="0.5"/></multiply>
<open_pbr_surface name="s" type="surfaceshader"><input name="base_color" type="color3" nodename="h"/></open_pbr_surface>
<surfacematerial name="M" type="material"><input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial>"""


def flat_image(path, color):
    image = bpy.data.images.new(path.stem, 4, 4)
    image.pixels[:] = [*color, 1.0] * 16
    image.filepath_raw, image.file_format = str(path), "PNG"
    image.save()
    bpy.data.images.remove(image)


def test_graded_tiled_images_come_as_nodes_and_as_their_mean(plane, tmp_path, capsys):
    """Tiles of .4 and 1 in sRGB: .1329 and 1, mean .5664, times .5, 1 and .25; a roughness .2 from .2 on is .36."""
    flat_image(tmp_path / "wood.1001.png", (0.4, 0.4, 0.4))
    flat_image(tmp_path / "wood.1002.png", (1.0, 1.0, 1.0))
    flat_image(tmp_path / "rough.png", (0.2, 0.2, 0.2))
    file, out = tmp_path / "graded.mtlx", tmp_path / "out.json"
    file.write_text(f'<materialx version="1.39" colorspace="lin_rec709">{GRADED}</materialx>')
    assert bpy.ops.lamina.import_materials("EXEC_DEFAULT", filepath=str(file)) == {"FINISHED"}
    lamina = plane.active_material.lamina
    before_color = [plane.active_material.node_tree.nodes[name] for name in feeding(node_of(lamina.base).inputs["Color"])]
    texture, mapping = (next(n for n in before_color if n.bl_idname == kind) for kind in ("ShaderNodeTexImage", "ShaderNodeMapping"))
    graded = texture.outputs["Color"].links[0].to_node
    assert texture.image.source == "TILED" and [tile.number for tile in texture.image.tiles] == [1001, 1002]
    np.testing.assert_allclose(mapping.inputs["Rotation"].default_value, (0.0, 0.0, -np.pi / 2), atol=1e-6)
    assert tuple(mapping.inputs["Scale"].default_value) == (2.0, 4.0, 1.0)
    assert tuple(graded.inputs[1].default_value) == (0.5, 1.0, 0.25) and tuple(graded.inputs[2].default_value) == (0.0, 0.0, 0.0)
    rough = node_of(lamina.layers[0]).inputs["Roughness"].links[0].from_node
    np.testing.assert_allclose([socket.default_value for socket in rough.inputs[1:3]], (0.8, 0.2), atol=1e-6)
    assert run(["convert", str(file), "-o", str(out)]) == 0
    told = capsys.readouterr().out
    assert "its mean, 0.2832 0.5664 0.1416, stands in" in told
    assert Stack.load(out).layers[0]["roughness"] == pytest.approx(0.36, abs=1e-3)


def test_a_mask_that_mixes_colors_comes_as_nodes_and_as_their_mean(plane, tmp_path, capsys):
    """From .8 .1 .1 to .1 .1 .8 by .4, halved: .26 .05 .19."""
    flat_image(tmp_path / "mask.png", (0.4, 0.4, 0.4))
    file, out = tmp_path / "mixed.mtlx", tmp_path / "out.json"
    file.write_text(f'<materialx version="1.39" colorspace="lin_rec709">{MIXED}</materialx>')
    assert bpy.ops.lamina.import_materials("EXEC_DEFAULT", filepath=str(file)) == {"FINISHED"}
    nodes = plane.active_material.node_tree.nodes
    before_color = [nodes[name] for name in feeding(node_of(plane.active_material.lamina.base).inputs["Color"])]
    texture = next(n for n in before_color if n.bl_idname == "ShaderNodeTexImage")
    graded = texture.outputs["Color"].links[0].to_node
    assert graded.operation == "MULTIPLY_ADD"
    for socket, wanted in zip(graded.inputs[1:3], ((-0.35, 0.0, 0.35), (0.4, 0.05, 0.05))):
        np.testing.assert_allclose(socket.default_value, wanted, atol=1e-6)
    assert run(["convert", str(file), "-o", str(out)]) == 0
    assert "its mean, 0.26 0.05 0.19, stands in" in capsys.readouterr().out


def test_colors_are_solved_at_the_mean_of_a_roughness_that_an_image_gives(plane, tmp_path):
    """As they are for a constant of that roughness: at the default they would be another base's."""
    flat_image(tmp_path / "rough.png", (0.8, 0.8, 0.8))
    surface = """<image name="i" type="float"><input name="file" type="filename" value="rough.png"/></image>
<open_pbr_surface name="s" type="surfaceshader"><input name="base_color" type="color3" value="0.3, 0.5, 0.3"/>{rough}</open_pbr_surface>"""
    stacks = []
    for rough in ('nodename="i"', 'value="0.8"', 'value="0.3"'):
        file = tmp_path / "s.mtlx"
        file.write_text(
            f'<materialx version="1.39" colorspace="lin_rec709">{surface.format(rough=f"""<input name="specular_roughness" type="float" {rough}/>""")}</materialx>'
        )
        imported = materialx_import.apply_material(bpy.data.materials.new("new"), load_mtlx(file)[0], "auto", "nodes")
        stacks.append(materials.stack_of(imported.material))
    of_image, of_mean, of_default = (stack.base["color"] for stack in stacks)
    np.testing.assert_allclose(of_image, of_mean, rtol=2e-3)
    assert np.max(np.abs(np.divide(of_default, of_mean) - 1.0)) > 0.01


LAYERS = """<image name="i" type="color3"><input name="file" type="filename" value="wood.png" colorspace="srgb_texture"/></image>
<image name="r" type="float"><input name="file" type="filename" value="wood.png"/></image>
<roughness_anisotropy name="ra" type="vector2"><input name="roughness" type="float" nodename="r"/></roughness_anisotropy>
<oren_nayar_diffuse_bsdf name="paint" type="BSDF"><input name="color" type="color3" nodename="i"/></oren_nayar_diffuse_bsdf>
<dielectric_bsdf name="gloss" type="BSDF"><input name="roughness" type="vector2" nodename="ra"/></dielectric_bsdf>
<layer name="l" type="BSDF"><input name="top" type="BSDF" nodename="gloss"/><input name="base" type="BSDF" nodename="paint"/></layer>
<mix name="m" type="BSDF"><input name="bg" type="BSDF" nodename="paint"/><input name="fg" type="BSDF" nodename="l"/><input name="mix" type="float" nodename="r"/></mix>
<surface name="s" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="m"/></surface>"""


def test_images_of_layers_are_linked_and_outside_blender_their_means_stand_in(plane, tmp_path, capsys):
    image = bpy.data.images.new("wood", 4, 4)
    image.pixels[:] = [0.5, 0.25, 0.75, 1.0] * 16
    image.filepath_raw, image.file_format = str(tmp_path / "wood.png"), "PNG"
    image.save()
    bpy.data.images.remove(image)
    file, out = tmp_path / "layers.mtlx", tmp_path / "out.json"
    file.write_text(f'<materialx version="1.39" colorspace="lin_rec709">{LAYERS}</materialx>')
    assert bpy.ops.lamina.import_materials("EXEC_DEFAULT", filepath=str(file)) == {"FINISHED"}
    lamina = plane.active_material.lamina
    gloss, base = node_of(lamina.layers[0]), node_of(lamina.base)
    assert all(socket.is_linked for socket in (gloss.inputs["Coverage"], gloss.inputs["Roughness"], base.inputs["Color"]))
    assert gloss.inputs["Roughness"].links[0].from_node.image.colorspace_settings.name == "Non-Color"
    before = counts()
    assert run(["convert", str(file), "-o", str(out)]) == 0
    assert counts() == before
    told = capsys.readouterr().out
    assert "approximated: paint color image" in told and "wood.png: its mean, 0.2159 0.05127 0.521, stands in" in told
    stack = Stack.load(out)
    assert stack.layers[0]["coverage"] == pytest.approx(0.5, abs=0.01) and stack.layers[0]["roughness"] == pytest.approx(0.5, abs=0.01)
    file.write_text(file.read_text().replace("wood.png", "gone.png"))
    assert run(["convert", str(file), "-o", str(out)]) == 0
    assert "gone.png: there is no such file" in capsys.readouterr().out
    (tmp_path / "gone.png").write_text("no image")
    assert run(["convert", str(file), "-o", str(out)]) == 0
    assert "no image that Blender can read" in capsys.readouterr().out


def test_an_objects_material_is_written_outside_a_window(plane, tmp_path, capsys):
    material = layered(plane)
    material.node_tree.links.new(ramp(material), node_of(material.lamina.layers[0]).inputs["Roughness"])
    blend, out = tmp_path / "in.blend", tmp_path / "out.mtlx"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    assert run(["convert", str(blend), "--object", "plane", "--to", "standard_surface", "-o", str(out)]) == 0
    assert "lost: Roughness texture" in capsys.readouterr().out
    (written,) = load_mtlx(out)
    assert written.surface.node == "standard_surface" and written.values["coat"] + written.values["specular"] > 0.0
    for arguments, words in ((["--object", "ball"], "has plane"), ([], "go together")):
        assert run(["convert", str(blend), *arguments, "--to", "gltf_pbr"]) == 2
        assert words in capsys.readouterr().err


def test_a_selection_is_exported_as_the_command_line_converts_it(plane, tmp_path, capsys):
    """Two materials of one name but for a dot are two files; an object without any is passed over."""
    layered(plane)
    folder = tmp_path / "out"
    other, bare = (bpy.data.objects.new(name, plane.data.copy()) for name in ("other", "bare"))
    for item in (other, bare):
        bpy.context.scene.collection.objects.link(item)
        item.data.materials.clear()
    layered(other)
    for item in (plane, other, bare):
        item.select_set(True)
    blend, own = tmp_path / "in.blend", tmp_path / "own.mtlx"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    before = counts()
    assert bpy.ops.lamina.export_materials("EXEC_DEFAULT", directory=str(folder), target="gltf_pbr") == {"FINISHED"}
    assert counts() == before
    assert sorted(p.name for p in folder.iterdir()) == ["Coated.mtlx", "Coated_001.mtlx", "Coated_001_report.txt", "Coated_report.txt"]
    assert run(["convert", str(blend), "--object", "plane", "--to", "gltf_pbr", "-o", str(own)]) == 0
    assert own.read_text() == (folder / "Coated.mtlx").read_text()
    report = (folder / "Coated_report.txt").read_text()
    assert report.strip() and report.strip() in capsys.readouterr().out


def test_an_export_names_pictures_of_what_textures_feed(plane, tmp_path):
    material = layered(plane)
    layer, base = node_of(material.lamina.layers[0]), node_of(material.lamina.base)
    material.node_tree.links.new(ramp(material, color=True), base.inputs["Color"])
    material.node_tree.links.new(ramp(material), layer.inputs["Roughness"])
    plane.select_set(True)
    before = counts(), sorted(n.name for n in material.node_tree.nodes)
    given = {"directory": str(tmp_path), "target": "openpbr", "pictures": True, "size": "64"}
    assert bpy.ops.lamina.export_materials("EXEC_DEFAULT", **given, reports=False) == {"FINISHED"}
    assert (counts(), sorted(n.name for n in material.node_tree.nodes)) == before
    files = sorted(p.name for p in tmp_path.iterdir())
    assert files[0] == "Coated.mtlx" and "Coated_base_color.png" in files and len(files) == 3
    (written,) = load_mtlx(tmp_path / "Coated.mtlx")
    assert {Path(image.file).name for image in written.images.values()} == set(files[1:])
    color = written.images["base_color"]
    assert color.space == "srgb_texture" and np.ptp(read_png(tmp_path / "Coated_base_color.png")[0][..., 0].astype(int)) > 50
    with pytest.raises(RuntimeError, match="choose a folder"):
        bpy.ops.lamina.export_materials("EXEC_DEFAULT", directory="")
    plane.select_set(False)
    assert not bpy.ops.lamina.export_materials.poll()


def test_textures_are_baked_and_the_file_is_as_before(plane, tmp_path):
    material = layered(plane)
    layer, base = node_of(material.lamina.layers[0]), node_of(material.lamina.base)
    color, value = ramp(material, color=True), ramp(material)
    material.node_tree.links.new(color, base.inputs["Color"])
    material.node_tree.links.new(value, layer.inputs["Roughness"])
    before = counts(), sorted(n.name for n in material.node_tree.nodes)
    assert bpy.ops.lamina.bake_textures("EXEC_DEFAULT", directory=str(tmp_path), size="64") == {"FINISHED"}
    after = counts()
    assert (after, sorted(n.name for n in material.node_tree.nodes)) == before
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        "Coated_base_color.png", "Coated_coat.png", "Coated_coat_roughness.png", "Coated_metallic.png", "Coated_principled.json", "Coated_roughness.png",
    ]  # fmt: skip
    u = (np.arange(64) + 0.5) / 64
    rough = read_png(tmp_path / "Coated_coat_roughness.png")[0][32, :, 0]
    np.testing.assert_allclose(rough / 255.0, u, atol=0.01)
    colors = to_principled(materials.stack_of(material), textured=True, exported=True).colors
    red = colors(np.stack([u, u, 0 * u], axis=-1))[:, 0]
    shown = read_png(tmp_path / "Coated_base_color.png")[0][32, :, 0] / 255.0
    linear = np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)
    np.testing.assert_allclose(linear, red, atol=0.012)
    assert np.all(red <= u) and np.max(u - red) > 0.1, "the correction does something"
    assert np.all(read_png(tmp_path / "Coated_metallic.png")[0] == 0)
    assert "worst albedo error" in json.loads((tmp_path / "Coated_principled.json").read_text())["report"][-1]


GREEN_COAT = {"layers": [{"kind": "dielectric", "roughness": 0.2, "tint": [0.5, 0.9, 0.5]}], "base": {"kind": "lambert", "color": [0.5] * 3}}


@pytest.mark.parametrize("stack, off", ((Stack.from_dict(GREEN_COAT), 0.05), (presets.load("anodised_titanium"), 0.35)), ids=("tint", "film"))
def test_a_baked_color_has_the_tint_of_a_coat_and_the_color_of_a_film(plane, tmp_path, stack, off):
    """No picture holds either: without the tint a green coat over grey was 171 % too red. `off`: a film's color is the same at all angles there."""
    layered(plane, stack).name = "Coated"
    assert bpy.ops.lamina.bake_textures("EXEC_DEFAULT", directory=str(tmp_path), size="64") == {"FINISHED"}
    shown = read_png(tmp_path / "Coated_base_color.png")[0][32, 32] / 255.0
    linear = np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)
    told = json.loads((tmp_path / "Coated_principled.json").read_text())
    assert not {"Coat Tint", "Thin Film Thickness"} & set(told["values"]) and "in the base color, the same at all angles" in " ".join(told["report"])
    plain = principled(plane, **{socket.replace(" ", "_"): value for socket, value in told["values"].items() if np.ndim(value) == 0})
    node = principled_of(plain)
    node.inputs["Base Color"].default_value = (*linear, 1.0)
    measured, stderr = render_furnace(plain, (0.0, 40.0), samples=64, size=16)
    exact = make_model("adding", stack).albedo(spherical(np.radians([0.0, 40.0]), 0.0))
    print(linear, measured, exact)
    assert np.all(np.abs(measured - exact) <= off * exact + 4.0 * stderr)


def test_a_flat_normal_is_flat(plane, tmp_path):
    material = layered(plane, Stack.from_dict({**COATED.to_dict(), "base": {"kind": "lambert", "normal": [0, 0, 0]}}))
    geometry = material.node_tree.nodes.new("ShaderNodeNewGeometry")
    material.node_tree.links.new(geometry.outputs["Normal"], node_of(material.lamina.base).inputs["Normal"])
    assert bpy.ops.lamina.bake_textures("EXEC_DEFAULT", directory=str(tmp_path), size="64") == {"FINISHED"}
    normal = read_png(tmp_path / "Coated_normal.png")[0].astype(int)
    assert np.max(np.abs(normal - np.array([128, 128, 255]))) <= 1


@pytest.mark.parametrize("after", (1, 3, 4))
def test_a_cancelled_bake_leaves_nothing(plane, tmp_path, after):
    material = layered(plane)
    material.node_tree.links.new(ramp(material), node_of(material.lamina.layers[0]).inputs["Roughness"])
    before = counts()
    steps = textures.TextureBake(material, plane, tmp_path, SIZE).steps()
    for _ in range(after):
        next(steps)
    steps.close()
    assert counts() == before and not list(tmp_path.iterdir())


def test_blenders_materialx_takes_the_file_and_has_the_same_defaults(blender):
    library = pytest.importorskip("MaterialX", reason="this Blender bundles no MaterialX")
    standard, document = library.createDocument(), library.createDocument()
    folder = Path(bpy.utils.resource_path("LOCAL")).parent / "lib" / "materialx"
    if not folder.is_dir():
        pytest.skip(f"this Blender has no MaterialX library in {folder}")
    library.loadLibraries(["libraries"], library.FileSearchPath(str(folder)), standard)
    stack = Stack.from_dict({**COATED.to_dict(), "base": {"kind": "conductor", "metal": "gold", "anisotropy": 0.5, "film_thickness": 300.0}})
    library.readFromXmlString(document, to_mtlx(to_openpbr(stack).values, "coated"))
    document.setDataLibrary(standard)
    valid, message = document.validate()
    assert valid, message
    definition = document.getNodes("open_pbr_surface")[0].getNodeDef()
    assert definition is not None
    for name, default in openpbr.DEFAULTS.items():
        given = definition.getActiveInput(name)
        assert given is not None, name
        if given.getType() == "boolean":
            assert given.getValueString() == "false" and default == 0.0
            continue
        np.testing.assert_allclose([float(v) for v in given.getValueString().split(",")], np.ravel(default), err_msg=name)
    for given in document.getNodes("open_pbr_surface")[0].getInputs():
        assert given.getType() == definition.getActiveInput(given.getName()).getType()


class Window:
    """What the bake's operator touches of a window, and of itself."""

    def __init__(self, bake):
        self.left, self.said, self.shares, self.texts = False, [], [], []
        self._bake, self._steps, self._timer = bake, bake.steps(), None
        self.window_manager = SimpleNamespace(progress_update=self.shares.append, event_timer_remove=lambda _: setattr(self, "left", True), progress_end=list)
        self.workspace = SimpleNamespace(status_text_set=self.texts.append)

    def report(self, level, text):
        self.said.append(text)

    def __getattr__(self, name):
        return partial(getattr(texture_operator.LAMINA_OT_bake_textures, name), self)

    def send(self, kind: str) -> set[str]:
        return texture_operator.LAMINA_OT_bake_textures.modal(self, self, SimpleNamespace(type=kind))


def test_escape_cancels_between_steps_and_a_timer_goes_on(plane, tmp_path):
    material = layered(plane)
    before = counts()
    window = Window(textures.TextureBake(material, plane, tmp_path, SIZE))
    assert [window.send(kind) for kind in ("TIMER", "TIMER", "A", "TIMER")] == [{"RUNNING_MODAL"}] * 4
    assert window.send("ESC") == {"CANCELLED"} and window.left
    assert counts() == before and not list(tmp_path.iterdir())
    window = Window(textures.TextureBake(material, plane, tmp_path, SIZE))
    while (done := window.send("TIMER")) == {"RUNNING_MODAL"}:
        pass
    assert done == {"FINISHED"} and window.left and counts() == before and len(list(tmp_path.iterdir())) == 6


def test_a_bake_that_cannot_be_is_refused_in_words(plane, tmp_path, monkeypatch):
    material = layered(plane)
    material.node_tree.links.new(ramp(material), node_of(material.lamina.layers[0]).inputs["Roughness"])
    before = counts()
    with pytest.raises(RuntimeError, match="choose a folder"):
        bpy.ops.lamina.bake_textures("EXEC_DEFAULT")

    def fail(*_):
        raise LaminaError("the disk is full")

    monkeypatch.setattr(textures, "write_png", fail)
    with pytest.raises(RuntimeError, match="the disk is full"):
        bpy.ops.lamina.bake_textures("EXEC_DEFAULT", directory=str(tmp_path), size="64")
    assert counts() == before and not list(tmp_path.iterdir())
    plane.data.uv_layers.remove(plane.data.uv_layers[0])
    with pytest.raises(RuntimeError, match="has no UV map"):
        bpy.ops.lamina.bake_textures("EXEC_DEFAULT", directory=str(tmp_path), size="64")
