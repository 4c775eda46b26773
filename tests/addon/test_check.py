# SPDX-License-Identifier: GPL-3.0-or-later
"""Check finds each thing that can be wrong with a material, and one click mends it."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from lamina.addon.blender import environment
from lamina.addon.blender.images import write_png
from lamina.addon.check import check, check_mends
from lamina.addon.jobs import bakes
from lamina.addon.material import layers, material, osl_setting, properties, record
from lamina.addon.material.elements import node_of
from lamina.addon.material.roles import node_with
from lamina.addon.material.shader_node import shader_of, surface_of
from lamina.addon.shader.inputs import TANGENT
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.material.place import Place
from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

STACK = Stack.from_dict(
    {
        "layers": [{"kind": "dielectric", "name": "Coat", "roughness": 0.1}, {"kind": "dielectric", "name": "Paint", "roughness": 0.5}],
        "base": {"kind": "conductor", "metal": "gold", "roughness": 0.3},
    }
)


@pytest.fixture
def owner(blender):
    """A material that nothing is wrong with, of OSL."""
    new = bpy.data.materials.new("owner")
    material.apply_stack(new, STACK, "weidlich_wilkie")
    osl_setting.enable_osl(bpy.context.scene)
    assert found(new) == []
    return new


def found(owner) -> list[check.Finding]:
    return check.find(owner, bpy.context.scene, bpy.context.preferences)


def codes(owner) -> list[str]:
    return [finding.code for finding in found(owner)]


def tree_of(owner):
    return owner.node_tree


def coat(owner):
    return node_of(owner.lamina.layers[0])


def shader(owner):
    return shader_of(owner)


def link_closure(owner):
    glossy = owner.node_tree.nodes.new("ShaderNodeBsdfGlossy")
    owner.node_tree.links.new(glossy.outputs[0], coat(owner).inputs["Tint"])


def link_image(owner):
    texture = owner.node_tree.nodes.new("ShaderNodeTexImage")
    gamma = owner.node_tree.nodes.new("ShaderNodeGamma")
    owner.node_tree.links.new(texture.outputs[0], gamma.inputs[0])
    owner.node_tree.links.new(gamma.outputs[0], coat(owner).inputs["Tint"])


def mute_link(owner):
    noise = owner.node_tree.nodes.new("ShaderNodeTexNoise")
    owner.node_tree.links.new(noise.outputs[0], coat(owner).inputs["Roughness"]).is_muted = True


def unlink_value(owner):
    links = owner.node_tree.links
    links.remove(shader(owner).inputs["Layer2Roughness"].links[0])


def cross_values(owner):
    links = owner.node_tree.links
    links.new(coat(owner).outputs["Roughness"], shader(owner).inputs["Layer2Roughness"])


def break_group(owner):
    tree = coat(owner).node_tree
    tree.links.remove(next(link for link in tree.links if link.to_socket.name == "Tint"))


def share_node(owner):
    owner.lamina.layers[1].node = owner.lamina.layers[0].node
    spare = [n for n in owner.node_tree.nodes if n.label == "Paint"]
    owner.node_tree.nodes.remove(spare[0])


def spare_node(owner):
    node = owner.node_tree.nodes.new("ShaderNodeGroup")
    node.node_tree, node.name = coat(owner).node_tree, "Lamina 0123456789ab"


def without_osl(owner):
    """A texture, which stock nodes do not follow."""
    noise = owner.node_tree.nodes.new("ShaderNodeTexNoise")
    owner.node_tree.links.new(noise.outputs[0], coat(owner).inputs["Roughness"])
    bpy.context.scene.cycles.shading_system = False


def script_alone(owner):
    owner.lamina.backend = "osl"
    bpy.context.scene.cycles.shading_system = False


def hide(owner):
    """An output of the user's own, which Cycles prefers."""
    output, glow = owner.node_tree.nodes.new("ShaderNodeOutputMaterial"), owner.node_tree.nodes.new("ShaderNodeEmission")
    output.target = "CYCLES"
    owner.node_tree.links.new(glow.outputs[0], output.inputs["Surface"])


def second_output(owner):
    """Another output for all renderers, which the user made the active one."""
    output, glow = owner.node_tree.nodes.new("ShaderNodeOutputMaterial"), owner.node_tree.nodes.new("ShaderNodeEmission")
    output.is_active_output = True
    owner.node_tree.links.new(glow.outputs[0], output.inputs["Surface"])


# What one click mends, and what is not for "Mend All", as it is the scene's.
FAULTS = {
    "without_osl": without_osl,
    "script_alone": script_alone,
    "one_branch": lambda owner: owner.node_tree.nodes.remove(node_with(owner, "nodes")),
    "output_hides": hide,
    "output_rests": second_output,
    "shader_gone": lambda owner: [owner.node_tree.nodes.remove(node_with(owner, role)) for role in ("osl", "nodes")],
    "shader_unused": lambda owner: owner.node_tree.links.remove(surface_of(owner).links[0]),
    "shader_muted": lambda owner: setattr(shader(owner), "mute", True),
    "shader_edited": lambda owner: shader(owner).script.write("// mine\n"),
    "shader_unlinked": unlink_value,
    "exported_shows": lambda owner: setattr(node_with(owner, "hand-over").inputs[0], "default_value", 0.5),
    "node_gone": lambda owner: owner.node_tree.nodes.remove(coat(owner)),
    "node_muted": lambda owner: setattr(coat(owner), "mute", True),
    "node_shared": share_node,
    "node_spare": spare_node,
    "group_broken": break_group,
    "link_broken": link_closure,
    "link_muted": mute_link,
    "image_missing": link_image,
    "out_of_range": lambda owner: setattr(coat(owner).inputs["Roughness"], "default_value", 1.5),
}


@pytest.mark.parametrize("code", FAULTS)
def test_a_fault_is_found_and_mended_with_one_click(owner, code):
    stack = material.stack_of(owner)
    FAULTS[code](owner)
    assert code in codes(owner)
    finding = next(f for f in found(owner) if f.code == code)
    assert finding.mending and "{" not in finding.text()
    bpy.context.window.scene = bpy.context.scene
    with bpy.context.temp_override(material=owner):
        bpy.ops.lamina.mend("EXEC_DEFAULT", finding=finding.key)
    assert code not in codes(owner)
    with bpy.context.temp_override(material=owner):
        bpy.ops.lamina.mend_all("EXEC_DEFAULT")
    assert [f.code for f in found(owner) if f.level != check.NOTE] == []
    if code not in ("node_shared", "out_of_range"):
        assert material.stack_of(owner) == stack


def test_a_driven_value_out_of_range_has_no_button(owner):
    """One that sets the value would say that all is well until the next frame."""
    coat(owner).inputs["Roughness"].default_value = 1.5
    coat(owner).inputs["Roughness"].driver_add("default_value").driver.expression = "1.5"
    (wrong,) = [f for f in found(owner) if f.code == "out_of_range"]
    assert (wrong.text(), wrong.mending) == ("Coat: Roughness is 1.5, by its driver or keyframes; allowed is 0 to 1", "")


def test_a_brushed_metal_on_a_mesh_without_a_uv_map_is_named(owner):
    """Cycles takes a ring around a pole for the tangent there."""
    mesh = bpy.data.meshes.new("bare")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    mesh.materials.append(owner)
    item = bpy.data.objects.new("bare", mesh)
    bpy.context.scene.collection.objects.link(item)
    assert codes(owner) == []
    owner.lamina.base.use_anisotropy = True
    assert codes(owner) == [], "an anisotropy of 0 has no direction"
    node_of(owner.lamina.base).inputs["Anisotropy"].default_value = 0.7
    (finding,) = [f for f in found(owner) if f.code == "uv_map_missing"]
    assert finding.text().startswith("bare has no UV map") and not finding.mending
    tangent = node_with(owner, TANGENT)
    tangent.direction_type = "RADIAL"
    assert "uv_map_missing" not in codes(owner)
    tangent.direction_type = "UV_MAP"
    mesh.uv_layers.new(name="UVMap")
    assert "uv_map_missing" not in codes(owner)
    tangent.uv_map = "Other"
    assert "uv_map_missing" in codes(owner)


def test_an_image_whose_file_moved_keeps_its_link(owner, tmp_path):
    """Its link is work: Check names the image and its file, and nothing that mends all of a material takes it away."""
    path, moved = tmp_path / "scratches.png", tmp_path / "moved.png"
    made = bpy.data.images.new("made", 8, 8)
    made.filepath_raw, made.file_format = str(path), "PNG"
    made.save()
    bpy.data.images.remove(made)
    texture = owner.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = bpy.data.images.load(str(path))
    owner.node_tree.links.new(texture.outputs[0], coat(owner).inputs["Tint"])
    material.refresh(owner)
    texture.image.buffers_free()
    path.rename(moved)
    (gone,) = [f for f in found(owner) if f.level != check.NOTE]
    assert (gone.code, gone.mending) == ("image_gone", "")
    assert gone.text().startswith(f"Coat: Tint reads the image scratches.png, whose file is gone: {path} ")
    with bpy.context.temp_override(material=owner):
        bpy.ops.lamina.mend_all("EXEC_DEFAULT")
    assert coat(owner).inputs["Tint"].is_linked
    texture.image.filepath = str(moved)
    texture.image.reload()
    assert [f.code for f in found(owner) if f.level != check.NOTE] == []


@pytest.mark.parametrize(
    ("source", "pattern", "files"),
    [("TILED", "t.<UDIM>.png", ["t.1001.png", "t.1002.png"]), ("SEQUENCE", "f001.png", ["f001.png", "f002.png"]), ("MOVIE", "m.png", ["m.png"])],
)
def test_a_tile_a_frame_or_a_movie_that_is_gone_is_named(owner, tmp_path, source, pattern, files):
    for name in files:
        write_png(tmp_path / name, np.full((4, 4, 3), 200, np.uint8))
    texture = owner.node_tree.nodes.new("ShaderNodeTexImage")
    image = texture.image = bpy.data.images.load(str(tmp_path / files[0]))
    image.source, image.filepath = source, str(tmp_path / pattern)
    if source == "TILED" and len(image.tiles) < 2:
        image.tiles.new(1002)
    texture.image_user.frame_duration = 2
    owner.node_tree.links.new(texture.outputs[0], coat(owner).inputs["Tint"])
    material.refresh(owner)
    lost = lambda: [f.words["path"] for f in found(owner) if f.code == "image_gone"]
    bpy.context.scene.frame_set(2)
    assert lost() == []
    (tmp_path / files[-1]).rename(tmp_path / "elsewhere")
    assert lost() == [str(tmp_path / files[-1])]
    if source == "SEQUENCE":  # the other picture is there
        bpy.context.scene.frame_set(1)
        assert lost() == []


def test_values_that_reach_the_wrong_input_are_found(owner):
    cross_values(owner)
    (finding,) = found(owner)
    assert finding.code == "shader_unlinked" and "Layer2Roughness" in finding.text()
    check.mend(owner, bpy.context.scene, bpy.context.preferences, finding.key)
    assert codes(owner) == [] and shader(owner).inputs["Layer2Roughness"].links[0].from_node.label == "Paint"


def test_faults_without_osl(owner, monkeypatch):
    coat(owner).inputs["Roughness"].driver_add("default_value").driver.expression = ".2"
    for module in (check, osl_setting):
        monkeypatch.setattr(module, "device_problem", lambda *_: "HIP devices cannot")
    assert sorted(codes(owner)) == ["texture_ignored", "without_osl"]
    shown = next(f for f in found(owner) if f.code == "without_osl")
    assert not shown.mending and shown.text() == "Shown by stock nodes, as HIP devices cannot; OSL would add Roughness of Coat"
    owner.lamina.backend = "osl"
    assert codes(owner) == ["script_alone"]
    without(monkeypatch)
    with properties.quietly():
        owner.lamina.backend = "auto"
    assert codes(owner) == ["osl_missing"]
    check.mend(owner, bpy.context.scene, bpy.context.preferences, "osl_missing//")
    ignored = next(f for f in found(owner) if f.code == "texture_ignored")
    assert not ignored.mending
    with pytest.raises(LaminaError, match="cannot be mended here: Coat: Roughness has a texture"):
        check.mend(owner, bpy.context.scene, bpy.context.preferences, ignored.key)
    with pytest.raises(LaminaError, match="no finding 'shader_gone//' any more"):
        check.mend(owner, bpy.context.scene, bpy.context.preferences, "shader_gone//")
    for role in ("osl", "nodes"):
        owner.node_tree.nodes.remove(node_with(owner, role))
    assert codes(owner) == ["shader_gone"]


def without(monkeypatch) -> None:
    """This Blender as one that was built without OSL."""
    monkeypatch.setattr(environment, "osl_available", lambda: (False, "this Blender was built without OSL"))
    monkeypatch.setattr(environment, "renders_osl", lambda: False)


def test_osl_that_was_asked_for_and_is_missing_has_a_button(owner, monkeypatch):
    without(monkeypatch)
    owner.lamina.backend = "osl"
    (missing,) = found(owner)
    assert missing.code == "backend_missing" and "built without OSL" in missing.text()
    check.mend(owner, bpy.context.scene, bpy.context.preferences, missing.key)
    assert owner.lamina.backend == "auto" and codes(owner) == ["without_osl"]


def test_a_note_is_of_what_does_not_show(owner):
    """Stock nodes beside a script that shows: what they leave out is said and not drawn in the panel."""
    without_osl(owner)
    assert [f.level for f in found(owner)] == [check.WARNING, check.WARNING]
    bpy.context.scene.cycles.shading_system = True
    assert [(f.code, f.level) for f in found(owner)] == [("texture_ignored", check.NOTE)]


def test_stock_nodes_that_are_behind_say_by_how_much(owner):
    coat(owner).inputs["Roughness"].default_value = 0.7
    (behind,) = found(owner)
    assert (behind.code, behind.level) == ("stock_behind", check.NOTE)
    assert behind.text() == "The stock nodes are behind: 1 values changed since, the first is Coat: Roughness"
    bpy.context.scene.cycles.shading_system = False
    assert next(f for f in found(owner) if f.code == "stock_behind").level == check.WARNING
    check.mend(owner, bpy.context.scene, bpy.context.preferences, behind.key)
    assert "stock_behind" not in codes(owner)


def test_a_deleted_node_comes_back_with_its_values_and_its_texture(owner):
    noise = owner.node_tree.nodes.new("ShaderNodeTexNoise")
    owner.node_tree.links.new(noise.outputs[0], coat(owner).inputs["Tint"])
    coat(owner).inputs["Roughness"].default_value = 0.37
    material.regenerate(owner)
    owner.node_tree.nodes.remove(coat(owner))
    (finding,) = [f for f in found(owner) if f.code == "node_gone"]
    check.mend(owner, bpy.context.scene, bpy.context.preferences, finding.key)
    assert coat(owner).inputs["Roughness"].default_value == pytest.approx(0.37)
    assert coat(owner).inputs["Tint"].links[0].from_node == noise
    assert material.live_values(owner) == (Place(0, "tint"),)


def test_several_deleted_nodes_come_back_at_once(owner):
    """As after grouping all nodes of a material by Ctrl G: a shader cannot be made before the last of them is there."""
    coat(owner).inputs["Roughness"].default_value = 0.37
    material.regenerate(owner)
    stack = material.stack_of(owner)
    for node in [node for node in owner.node_tree.nodes if node.bl_idname != "ShaderNodeOutputMaterial"]:
        owner.node_tree.nodes.remove(node)
    assert codes(owner).count("node_gone") == len(owner.lamina.layers) + 1
    (finding, *_) = [f for f in found(owner) if f.code == "node_gone"]
    check.mend(owner, bpy.context.scene, bpy.context.preferences, finding.key)
    assert material.stack_of(owner) == stack
    material.regenerate(owner)
    assert codes(owner) == []


def test_exchanged_branches_are_found_and_mended(owner):
    """Wherever OSL does not run the script would show, black."""
    switch, links = node_with(owner, "switch"), owner.node_tree.links
    first, second = (switch.inputs[i].links[0].from_socket for i in (1, 2))
    links.new(second, switch.inputs[1])
    links.new(first, switch.inputs[2])
    (finding,) = [f for f in found(owner) if f.code == "shader_unlinked"]
    check.mend(owner, bpy.context.scene, bpy.context.preferences, finding.key)
    assert codes(owner) == [] and [switch.inputs[i].links[0].from_node for i in (1, 2)] == [first.node, second.node]


def test_a_node_whose_values_nobody_knows_gets_defaults_and_says_so(owner):
    del owner.node_tree[record.KEY]
    owner.node_tree.nodes.remove(coat(owner))
    (finding,) = [f for f in found(owner) if f.code == "node_lost"]
    assert finding.mending == "Make It Anew with Default Values"
    check.mend(owner, bpy.context.scene, bpy.context.preferences, finding.key)
    assert coat(owner).inputs["Roughness"].default_value == 0.0


def test_a_renamed_node_is_still_the_layers(owner):
    stack = material.stack_of(owner)
    coat(owner).name = "Clear"
    shader_of(owner).name = "Mine"
    assert codes(owner) == [] and coat(owner).name == "Clear"
    layers.move_layer(owner, 0, 1)
    layers.move_layer(owner, 1, 0)
    assert codes(owner) == [] and material.stack_of(owner) == stack
    layers.remove_layer(owner, 0)
    assert codes(owner) == [] and "Clear" not in owner.node_tree.nodes


def test_a_renamed_node_of_an_older_file_is_found_by_its_links(owner):
    stack, node = material.stack_of(owner), coat(owner)
    del owner.node_tree[record.KEY], node["lamina_id"]
    node.name = "Clear"
    assert coat(owner) == node and codes(owner) == [] and material.stack_of(owner) == stack


def test_a_stale_shader_and_a_bake_that_failed(owner, monkeypatch):
    material.apply_stack(owner, STACK, "analytic", "nodes")
    coat(owner).inputs["Roughness"].default_value = 0.7
    assert codes(owner) == ["shader_stale"]
    check.mend(owner, bpy.context.scene, bpy.context.preferences, "shader_stale//")
    assert codes(owner) == []
    monkeypatch.setattr(bakes, "failed", lambda _: "cancelled")
    assert codes(owner) == ["not_baked"]
    called = []
    monkeypatch.setattr(bakes, "retry", called.append)
    check.mend(owner, bpy.context.scene, bpy.context.preferences, "not_baked//")
    assert called == [owner]


def test_a_linked_material_is_looked_at_and_not_touched(owner, tmp_path):
    path = str(tmp_path / "library.blend")
    coat(owner).inputs["Roughness"].default_value = 1.5
    bpy.data.libraries.write(path, {owner}, fake_user=True)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(path, link=True) as (_, wanted):
        wanted.materials = ["owner"]
    linked = bpy.data.materials["owner"]
    osl_setting.enable_osl(bpy.context.scene)
    assert sorted(codes(linked)) == ["not_editable", "out_of_range"]
    with pytest.raises(LaminaError, match="is linked from"):
        check.mend(linked, bpy.context.scene, bpy.context.preferences, next(f.key for f in found(linked) if f.code == "out_of_range"))


def test_every_code_is_tested_and_every_button_works():
    tested = {
        *FAULTS,
        "backend_missing",
        "node_lost",
        "osl_missing",
        "stock_behind",
        "tables_shrunk",
        "texture_ignored",
        "shader_stale",
        "not_baked",
        "not_editable",
        "not_followed",
        "image_gone",
        "out_of_gamut",
        "usd_misled",
        "uv_map_missing",
        "value_rests",
    }
    assert set(check.CODES) == tested
    assert set(check_mends.MENDS) == {code for code, (_, _, mending) in check.CODES.items() if mending}


def test_a_hidden_layer_is_muted_and_that_is_right(owner):
    owner.lamina.layers[0].visible = False
    assert codes(owner) == []
    layers.solo_layer(owner, 0)
    assert codes(owner) == []
