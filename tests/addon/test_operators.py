# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators: one undo step each, errors in words, nothing half-made; and the panel draws in every state."""

import json
from functools import partial
from types import SimpleNamespace

import pytest

bpy = pytest.importorskip("bpy")

from lamina.addon import registration
from lamina.addon.blender import environment
from lamina.addon.blender.versions import node_tree
from lamina.addon.check import check
from lamina.addon.jobs import bakes
from lamina.addon.material import material as materials
from lamina.addon.material import osl_setting, properties
from lamina.addon.material.elements import node_of
from lamina.addon.material.roles import node_with
from lamina.addon.material.shader_node import backend_of
from lamina.addon.operators import material_operators
from lamina.addon.ui import panel
from lamina.reference_py.material import presets
from lamina.reference_py.material.schema import SCHEMA
from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

STACK = Stack.from_dict(
    {
        "name": "Two",
        "layers": [{"kind": "dielectric", "name": "Coat"}, {"kind": "dielectric", "name": "Paint", "tint": [0.9, 0.2, 0.1]}],
        "base": {"kind": "conductor", "metal": "gold", "roughness": 0.3},
    }
)
MISSING = (False, "this Blender was built without OSL")


@pytest.fixture
def bare(blender):
    """The active object, without a material."""
    item = blender.data.objects.new("object", blender.data.meshes.new("mesh"))
    blender.context.collection.objects.link(item)
    blender.context.view_layer.objects.active = item
    return item


@pytest.fixture
def layered(bare):
    """The active object, with two layers over gold; the first one is selected."""
    bare.data.materials.append(bpy.data.materials.new("layered"))
    materials.apply_stack(bare.active_material, STACK)
    return bare


def state() -> dict:
    """Everything that an operator may change, read from the file anew: references are dead after an undo."""
    scene = bpy.context.scene
    found = {"engine": scene.render.engine, "osl": scene.cycles.shading_system, "texts": sorted(t.name for t in bpy.data.texts)}
    for material in bpy.data.materials:
        tree, lamina = material.node_tree, material.lamina
        script = node_with(material, "osl")
        found[material.name] = {
            "stack": materials.stack_of(material, hidden=True).to_dict() if lamina.is_layered else None,
            "layers": [(e.name, e.node, e.visible) for e in lamina.layers],
            "solo": lamina.solo,
            "active": lamina.active_layer,
            "nodes": sorted((n.name, n.mute) for n in tree.nodes) if tree else [],
            "links": sorted((k.from_node.name, k.from_socket.name, k.to_node.name, k.to_socket.identifier) for k in tree.links) if tree else [],
            "shader": (script.script.name, script.bytecode_hash) if script else None,
        }
    return found


STRUCTURE_OPERATORS = {
    "apply_preset": lambda: bpy.ops.lamina.apply_preset("EXEC_DEFAULT", True, preset="wet_asphalt"),
    "layer_add": lambda: bpy.ops.lamina.layer_add("EXEC_DEFAULT", True, kind="dielectric"),
    "layer_add_ready": lambda: bpy.ops.lamina.layer_add_ready("EXEC_DEFAULT", True, ready="rust"),
    "layer_duplicate": lambda: bpy.ops.lamina.layer_duplicate("EXEC_DEFAULT", True),
    "layer_solo": lambda: bpy.ops.lamina.layer_solo("EXEC_DEFAULT", True, index=1),
    "layer_paste": lambda: bpy.ops.lamina.layer_copy("EXEC_DEFAULT") and bpy.ops.lamina.layer_paste("EXEC_DEFAULT", True),
    "layer_remove": lambda: bpy.ops.lamina.layer_remove("EXEC_DEFAULT", True),
    "layer_move": lambda: bpy.ops.lamina.layer_move("EXEC_DEFAULT", True, direction="DOWN"),
    "set_base": lambda: bpy.ops.lamina.set_base("EXEC_DEFAULT", True, kind="lambert"),
}


@pytest.mark.parametrize("call", STRUCTURE_OPERATORS.values(), ids=STRUCTURE_OPERATORS)
def test_undo_and_redo_restore_everything(layered, call):
    node_of(layered.active_material.lamina.layers[1]).inputs["Roughness"].default_value = 0.4
    bpy.ops.ed.undo_push(message="before")
    before = state()
    assert call() == {"FINISHED"}
    after = state()
    assert after != before
    bpy.ops.ed.undo()
    assert state() == before
    bpy.ops.ed.redo()
    assert state() == after


def test_a_choice_in_the_panel_is_one_undo_step(layered):
    bpy.ops.ed.undo_push(message="before")
    before = state()
    layered.active_material.lamina.layers[0].visible = False
    bpy.ops.ed.undo_push(message="hide")  # as the panel's button does
    after = state()
    bpy.ops.ed.undo()
    assert state() == before
    bpy.ops.ed.redo()
    assert state() == after


def test_undo_of_a_first_preset_leaves_no_material(bare):
    bpy.ops.ed.undo_push(message="before")
    before = state()
    assert bpy.ops.lamina.apply_preset("EXEC_DEFAULT", True, preset=presets.names()[0]) == {"FINISHED"}
    assert bpy.context.object.active_material.name == presets.load(presets.names()[0]).name
    bpy.ops.ed.undo()
    assert state() == before
    assert len(bpy.data.materials) == 0 and bpy.context.object.active_material is None


def _multiscatter(bare) -> None:
    """A half mixed Glossy node of Multiscatter GGX on another object."""
    material = bpy.data.materials.new("gold leaf")
    tree = node_tree(material)
    glossy, mix = tree.nodes.new("ShaderNodeBsdfAnisotropic"), tree.nodes.new("ShaderNodeMixShader")
    glossy.distribution = "MULTI_GGX"
    tree.links.new(glossy.outputs[0], mix.inputs[1])
    other = bpy.data.objects.new("other", bpy.data.meshes.new("other"))
    other.data.materials.append(material)
    bpy.context.collection.objects.link(other)


SPEAKS_AGAINST_OSL = {
    "the render engine is not Cycles": lambda _: setattr(bpy.context.scene.render, "engine", "BLENDER_WORKBENCH"),
    "the shader AOV hue would be black under Open Shading Language": lambda _: setattr(bpy.context.view_layer.aovs.add(), "name", "hue"),
    "gold leaf mixes a Multiscatter GGX node": _multiscatter,
}


def test_a_preset_switches_osl_on_and_says_so(bare):
    said = []
    bpy.context.scene.render.engine = "CYCLES"
    target = partial(material_operators.StackOperator.target, None)
    operator = SimpleNamespace(stack=lambda: STACK, target=target, apply=materials.apply_stack, report=lambda kind, text: said.append((kind, text)))
    material_operators.StackOperator.run(operator, bpy.context)
    assert bpy.context.scene.cycles.shading_system
    assert [kind for kind, _ in said] == [{"INFO"}] and "Open Shading Language switched on" in said[0][1]
    said.clear()
    material_operators.StackOperator.run(operator, bpy.context)
    assert said == []


@pytest.mark.parametrize("reason", SPEAKS_AGAINST_OSL)
def test_osl_is_left_off_where_something_speaks_against_it(bare, reason):
    bpy.context.scene.render.engine = "CYCLES"
    SPEAKS_AGAINST_OSL[reason](bare)
    engine = bpy.context.scene.render.engine
    STRUCTURE_OPERATORS["apply_preset"]()
    assert not bpy.context.scene.cycles.shading_system and bpy.context.scene.render.engine == engine
    words = " ".join(drawn("label"))
    assert reason in words and "OSL would add nothing to this picture" in words and "lamina.enable_osl" in drawn("operator")
    bpy.ops.lamina.mend_all()
    assert not bpy.context.scene.cycles.shading_system
    bpy.ops.lamina.enable_osl()
    assert bpy.context.scene.cycles.shading_system


def test_buttons_do_what_they_say(layered):
    lamina = layered.active_material.lamina
    bpy.ops.lamina.layer_move(direction="DOWN")
    assert ([e.name for e in lamina.layers], lamina.active_layer) == (["Paint", "Coat"], 1)
    with pytest.raises(RuntimeError, match="Coat is the lowest layer already"):
        bpy.ops.lamina.layer_move(direction="DOWN")
    bpy.ops.lamina.layer_add()
    assert ([e.name for e in lamina.layers], lamina.active_layer) == (["Paint", "Dielectric", "Coat"], 1)
    for _ in range(3):
        bpy.ops.lamina.layer_remove()
    assert len(lamina.layers) == 0 and not bpy.ops.lamina.layer_remove.poll()
    bpy.ops.lamina.layer_add()
    for kind in SCHEMA.bases:
        bpy.ops.lamina.set_base(kind=kind)
        assert materials.stack_of(layered.active_material).base.kind == kind


def test_poll_needs_a_stack_or_an_object(blender):
    assert not bpy.ops.lamina.apply_preset.poll()
    assert not bpy.ops.lamina.layer_add.poll()
    item = bpy.data.objects.new("plain", bpy.data.meshes.new("mesh"))
    bpy.context.collection.objects.link(item)
    bpy.context.view_layer.objects.active = item
    assert bpy.ops.lamina.apply_preset.poll()
    assert not bpy.ops.lamina.export_stack.poll()
    light = bpy.data.objects.new("light", bpy.data.lights.new("light", "POINT"))
    bpy.context.collection.objects.link(light)
    bpy.context.view_layer.objects.active = light
    assert not bpy.ops.lamina.apply_preset.poll()


@pytest.mark.parametrize("call", STRUCTURE_OPERATORS.values(), ids=STRUCTURE_OPERATORS)
def test_backend_osl_without_osl_a_message_and_nothing_changed(layered, monkeypatch, call):
    layered.active_material.lamina.backend = "osl"
    before = state()
    monkeypatch.setattr(environment, "osl_available", lambda: MISSING)
    with pytest.raises(RuntimeError, match="backend osl needs Cycles with OSL, and this Blender was built without OSL"):
        call()
    assert state() == before


def test_without_osl_a_preset_is_made_of_stock_nodes_and_says_so(bare, monkeypatch, capfd):
    monkeypatch.setattr(environment, "osl_available", lambda: MISSING)
    before = state()
    with pytest.raises(RuntimeError, match="built without OSL"):
        bpy.ops.lamina.enable_osl()
    assert state() == before
    STRUCTURE_OPERATORS["apply_preset"]()
    assert backend_of(bare.active_material) == "nodes"
    assert bpy.context.scene.render.engine == before["engine"]
    assert "stock nodes, because this Blender was built without OSL" in capfd.readouterr().out
    assert "Made of stock nodes, because this Blender was built without OSL" in " ".join(drawn("label"))
    assert "lamina.enable_osl" not in drawn("operator")


def test_linked_material_has_a_message(layered, tmp_path):
    path = str(tmp_path / "library.blend")
    bpy.data.libraries.write(path, {layered}, fake_user=True)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(path, link=True) as (_, wanted):
        wanted.objects = ["object"]
    item = bpy.data.objects["object"]
    bpy.context.collection.objects.link(item)
    bpy.context.view_layer.objects.active = item
    before = state()
    for call in STRUCTURE_OPERATORS.values():
        with pytest.raises(RuntimeError, match="is linked from .*; make it local"):
            call()
    assert state() == before
    assert any("is linked from" in text for text in drawn("label"))


def test_export_and_import(layered, tmp_path):
    path = tmp_path / "two.json"
    layered.active_material.lamina.layers[0].visible = False
    bpy.ops.lamina.export_stack(filepath=str(path))
    written = Stack.load(path)
    assert [layer.unknown["name"] for layer in written.layers] == ["Paint"]
    layered.active_material.lamina.layers[0].visible = True
    bpy.ops.lamina.import_stack("EXEC_DEFAULT", True, filepath=str(path))
    assert materials.stack_of(layered.active_material) == written


def test_files_that_cannot_be_read_or_written(layered, tmp_path):
    before = state()
    broken = tmp_path / "broken.json"
    broken.write_text(json.dumps({"base": {"kind": "conductor", "metal": "gld"}}))
    with pytest.raises(RuntimeError, match=r"broken\.json: base: unknown metal 'gld'; choose aluminium"):
        bpy.ops.lamina.import_stack(filepath=str(broken))
    with pytest.raises(RuntimeError, match=r"none\.json: cannot read stack file"):
        bpy.ops.lamina.import_stack(filepath=str(tmp_path / "none.json"))
    with pytest.raises(RuntimeError, match="cannot write into folder"):
        bpy.ops.lamina.export_stack(filepath=str(tmp_path / "no" / "folder.json"))
    node_of(layered.active_material.lamina.base).inputs["Roughness"].default_value = 1.5
    with pytest.raises(RuntimeError, match="roughness is 1.5; choose 0 to 1"):
        bpy.ops.lamina.export_stack(filepath=str(tmp_path / "wrong.json"))
    assert not (tmp_path / "wrong.json").exists()
    node_of(layered.active_material.lamina.base).inputs["Roughness"].default_value = 0.3
    assert state() == before


def test_every_button_has_a_description():
    for cls in [cls for cls in registration.CLASSES if issubclass(cls, bpy.types.Operator)]:
        assert cls.bl_description and cls.bl_label
    description = material_operators.LAMINA_OT_apply_preset.description(None, SimpleNamespace(preset="patina_copper"))
    assert description == presets.load("patina_copper").source


class Layout:
    """Stands in for Blender's layout, which exists in a window only: notes what is drawn, and that it exists."""

    def __init__(self, noted):
        self.noted = noted

    def panel(self, _name, default_closed=False):
        return self, self

    def label(self, text="", **_options):
        self.noted.append(("label", text))

    def prop(self, owner, name, **_options):
        assert name in owner.bl_rna.properties
        self.noted.append(("prop", name))

    def operator(self, name, **_options):
        group, function = name.split(".")
        assert function in dir(getattr(bpy.ops, group))
        self.noted.append(("operator", name))
        return SimpleNamespace()

    def operator_enum(self, name, prop):
        self.operator(name)

    def operator_menu_enum(self, name, prop, text="", **_options):
        self.operator(name)

    def menu(self, name, **_options):
        assert hasattr(bpy.types, name)
        getattr(bpy.types, name).draw(SimpleNamespace(layout=Layout([])), bpy.context)
        self.noted.append(("menu", name))

    def template_list(self, name, _identity, owner, prop, active_owner, active, **_options):
        for element in getattr(owner, prop):
            row = Layout([])
            getattr(bpy.types, name).draw_item(None, WINDOW, row, owner, element, 0, active_owner, active, 0)
            self.noted.append(("row", [text for sort, text in row.noted if sort == "label"]))

    def template_node_view(self, tree, node, socket):
        assert tree.nodes[node.name] == node and socket.node == node
        self.noted.append(("socket", socket.name))

    def popover(self, name, **_options):
        getattr(bpy.types, name).draw(SimpleNamespace(layout=self), shown_window())

    def separator(self):
        pass

    def row(self, align=False):
        return self

    column = split = box = lambda self, **_options: self


WINDOW = SimpleNamespace(region=SimpleNamespace(width=2000), preferences=SimpleNamespace(system=SimpleNamespace(ui_scale=1.0)))


def shown_window():
    """A context as a window's Properties editor has it."""
    preferences = SimpleNamespace(system=WINDOW.preferences.system, addons=bpy.context.preferences.addons)
    return SimpleNamespace(
        scene=bpy.context.scene, object=bpy.context.object, region=WINDOW.region, preferences=preferences, window_manager=bpy.context.window_manager
    )


def drawn(what: str) -> list[str]:
    """What the panel and what its buttons open draw for the active object, of one sort."""
    window = shown_window()
    assert panel.LAMINA_PT_material.poll(window)
    noted = []
    panel.LAMINA_PT_material.draw(SimpleNamespace(layout=Layout(noted), bl_label="Lamina"), window)
    return [value for sort, value in noted if sort == what]


def test_panel_offers_presets_before_there_is_a_stack(bare):
    assert drawn("menu") == ["LAMINA_MT_presets"] * 2
    bare.data.materials.append(bpy.data.materials.new("plain"))
    assert drawn("menu") == ["LAMINA_MT_presets"] * 2


def test_panel_draws_every_value_of_the_schema(layered):
    sockets = drawn("socket")
    kind = SCHEMA.layers["dielectric"]
    own = [p.label for p in kind.parameters if not p.is_structural]
    assert set(own) <= set(sockets)
    for feature in kind.features:
        labels = [p.label for p in feature.parameters]
        assert f"use_{feature.name}" in drawn("prop") and not set(labels) & set(sockets)
        layer = layered.active_material.lamina.layers[0]
        setattr(layer, f"use_{feature.name}", True)
        for choice in feature.given_choices or ("",):
            if choice:
                setattr(layer, f"given_{feature.name}", choice)
            shown = set(drawn("socket"))
            assert {p.label for p in feature.given_by(choice)} <= shown and not {p.label for p in feature.not_given_by(choice)} & shown
        setattr(layer, f"use_{feature.name}", False)
    assert "Extinction" not in sockets and "metal" in drawn("prop")
    layered.active_material.lamina.base.given = "eta+k"
    assert {"IOR", "Extinction"} <= set(drawn("socket")[4:]) and "metal" not in drawn("prop")
    assert "OSL and Stock Nodes" in drawn("label")


def test_a_device_without_osl_is_named():
    def problem(device, kind):
        scene = SimpleNamespace(cycles=SimpleNamespace(device=device))
        cycles = SimpleNamespace(preferences=SimpleNamespace(compute_device_type=kind))
        return osl_setting.device_problem(scene, SimpleNamespace(addons={"cycles": cycles}))

    assert problem("GPU", "HIP").startswith("HIP devices cannot run Open Shading Language")
    assert problem("GPU", "OPTIX") == problem("CPU", "HIP") == problem("GPU", "NONE") == ""


def test_panel_says_what_keeps_it_from_working(layered, monkeypatch):
    assert "lamina.mend" not in drawn("operator")
    layered.active_material.lamina.backend = "osl"
    assert "Black: the shader is an OSL script alone, and the render engine is not Cycles" in " ".join(drawn("label"))
    assert "lamina.mend" in drawn("operator")
    bpy.ops.lamina.enable_osl()
    assert "lamina.mend" not in drawn("operator")
    monkeypatch.setattr(osl_setting, "device_problem", lambda *_: "HIP devices cannot")
    assert "HIP devices cannot" in " ".join(drawn("label")) and "lamina.mend" in drawn("operator")
    with properties.quietly():
        layered.active_material.lamina.backend = "auto"
    layered.active_material.lamina.problem = "something went wrong"
    assert "Something went wrong" in drawn("label")
    monkeypatch.setattr(environment, "osl_available", lambda: MISSING)
    monkeypatch.setattr(environment, "renders_osl", lambda: False)
    layered.active_material.lamina.problem = ""
    assert "the shader is an OSL script alone, and this Blender was built without OSL" in " ".join(drawn("label"))
    assert "lamina.mend" in drawn("operator")
    bpy.ops.lamina.mend(finding="osl_missing//")
    assert "Shown by stock nodes, as this Blender was built without OSL" in " ".join(drawn("label"))
    assert "OSL and Stock Nodes" in drawn("label")
    with properties.quietly():
        layered.active_material.lamina.backend = "osl"
    assert "Backend osl needs Cycles with OSL" in " ".join(drawn("label"))
    assert "Tint" in drawn("socket")
    layered.active_material.node_tree.nodes.remove(node_of(layered.active_material.lamina.base))
    assert any("was deleted" in text for text in drawn("label"))


def test_panel_offers_to_update_a_shader_of_old_values(layered):
    with properties.quietly():
        layered.active_material.lamina.backend = "nodes"
    bpy.ops.lamina.regenerate()
    assert "old values" not in " ".join(drawn("label"))
    node_of(layered.active_material.lamina.layers[0]).inputs["Roughness"].default_value = 0.77
    assert "The shader holds old values" in " ".join(drawn("label"))
    bpy.ops.lamina.regenerate()
    assert "old values" not in " ".join(drawn("label"))


def test_two_features_that_exclude_each_other_are_told_where_the_status_stands(bare):
    """By the name of the layer, and without a button that would try the same in vain."""
    bpy.ops.lamina.apply_preset(preset="satin_varnish")
    varnish = bare.active_material.lamina.layers[0]
    node_of(varnish).inputs["Anisotropy"].default_value = 0.5
    varnish.use_scattering = True
    varnish.use_anisotropy = True
    node_of(varnish).inputs["Roughness"].default_value = 0.77
    told = "medium that scatters cannot be had together with the anisotropy of Varnish; choose one of the two"
    assert f"A {told}" in drawn("label") and "lamina.mend" not in drawn("operator")
    (found,) = [f for f in check.find(bare.active_material, bpy.context.scene, bpy.context.preferences) if f.level == check.ERROR]
    assert (found.code, found.text()) == ("not_followed", f"a {told}")
    varnish.use_anisotropy = False
    assert told not in " ".join(drawn("label"))


@pytest.mark.parametrize("is_former", [False, True])
def test_a_value_that_is_mended_takes_what_it_hindered_along(layered, is_former):
    """What the timer noted as the reason goes once the shader follows, or need not."""
    material = layered.active_material
    with properties.quietly():
        material.lamina.backend, material.lamina.tier = "nodes", "analytic"
    bpy.ops.lamina.regenerate()
    roughness = node_of(material.lamina.layers[0]).inputs["Roughness"]
    former = roughness.default_value
    roughness.default_value = 1.5
    bakes.tick()
    assert material.lamina.problem
    roughness.default_value = former if is_former else 0.5
    bakes.tick()
    assert not material.lamina.problem


def test_a_preset_renames_only_what_a_preset_named(blender):
    """A name that a user gave stays, also one that a conversion made the stack's."""
    blender.ops.mesh.primitive_plane_add()
    own = blender.data.materials.new("Hero Car")
    blender.context.object.active_material = own
    blender.ops.lamina.apply_preset(preset="glazed_mug")
    own.lamina.stack_name = own.name
    blender.ops.lamina.apply_preset(preset="clean_copper")
    assert own.name == "Hero Car"
    own.name = own.lamina.stack_name
    blender.ops.lamina.apply_preset(preset="glazed_mug")
    assert own.name == presets.load("glazed_mug").name


def test_a_linked_object_is_told_to_be_made_local(blender, tmp_path):
    data = blender.data
    far = data.objects.new("far", data.meshes.new("far"))
    data.libraries.write(str(tmp_path / "far.blend"), {far})
    data.objects.remove(far)
    with data.libraries.load(str(tmp_path / "far.blend"), link=True) as (there, here):
        here.objects = there.objects
    blender.context.collection.objects.link(here.objects[0])
    blender.context.view_layer.objects.active = here.objects[0]
    for give in (lambda: blender.ops.lamina.apply_preset(preset="frosted_paint"), lambda: blender.ops.lamina.fit_measurement(filepath="x.csv")):
        with pytest.raises(RuntimeError, match="make it local"):
            give()
    assert not data.materials
