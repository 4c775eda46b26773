# SPDX-License-Identifier: GPL-3.0-or-later
"""Selecting a layer touches nothing that is rendered, and undo gives the selection back."""

from types import SimpleNamespace

import pytest

bpy = pytest.importorskip("bpy")

from lamina.addon.material import layers, material
from lamina.addon.ui import panel_layers
from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

STACK = Stack.from_dict({"layers": [{"kind": "dielectric", "name": name} for name in "ABC"], "base": {"kind": "lambert"}})


def made(name: str = "owner"):
    """A material of three layers on the active object."""
    new = bpy.data.materials.new(name)
    material.apply_stack(new, STACK, "analytic", "nodes")
    item = bpy.data.objects.new(name, bpy.data.meshes.new(name))
    item.data.materials.append(new)
    bpy.context.collection.objects.link(item)
    bpy.context.view_layer.objects.active = item
    return new


def rows():
    """What the list's active row is a property of."""
    return bpy.context.window_manager.lamina


def click(owner, name: str, value) -> None:
    """Set a property as a click in a window does: Blender then tags its owner, which a plain assignment leaves out."""
    setattr(owner, name, value)
    owner.path_resolve(name, False).update()
    bpy.context.view_layer.update()


@pytest.fixture
def updates(blender):
    """Names of all that Blender evaluated anew since."""
    seen = []

    def note(_scene, depsgraph):
        seen.extend(update.id.name for update in depsgraph.updates)

    bpy.app.handlers.depsgraph_update_post.append(note)
    yield seen
    bpy.app.handlers.depsgraph_update_post.remove(note)


def test_selecting_a_row_evaluates_nothing_anew(updates):
    owner = made()
    bpy.context.view_layer.update()
    updates.clear()
    for row in (1, 2, 0, 1, 1):
        click(rows(), "active_layer", row)
        assert owner.lamina.active_layer == rows().active_layer == row
    assert updates == []
    click(owner.lamina, "stack_name", "another")  # what the handler does see
    assert "owner" in updates


def test_the_list_draws_the_row_of_the_material_that_is_shown(blender):
    first, second = made("first"), made("second")
    second.lamina.active_layer = 2
    assert rows().active_layer == 2
    with bpy.context.temp_override(material=first):
        assert rows().active_layer == 0
        rows().active_layer = 1
    assert (first.lamina.active_layer, second.lamina.active_layer) == (1, 2)
    copy = second.copy()  # its nodes are called the same
    copy.lamina.active_layer = 1
    assert (copy.lamina.active_layer, second.lamina.active_layer) == (1, 2)


def test_the_panels_list_is_of_that_property(blender):
    owner, drawn = made(), []

    class Layout:
        def __getattr__(self, name):
            def note(*arguments, **_):
                drawn.append((name, arguments))
                return Layout()

            return note

    preferences = SimpleNamespace(system=SimpleNamespace(ui_scale=1.0))
    context = SimpleNamespace(window_manager=bpy.context.window_manager, region=SimpleNamespace(width=400), preferences=preferences)
    panel_layers.draw_layers(Layout(), context, owner.lamina)
    ((_, _, data, name, owner_of_row, row),) = [arguments for called, arguments in drawn if called == "template_list"]
    assert (data, name) == (owner.lamina, "layers") and owner_of_row.id_data == bpy.context.window_manager
    assert type(owner_of_row).bl_rna.properties[row].type == "INT"


CHANGES = {
    "add": (lambda: bpy.ops.lamina.layer_add("EXEC_DEFAULT", True, kind="dielectric"), "Dielectric"),
    "remove": (lambda: bpy.ops.lamina.layer_remove("EXEC_DEFAULT", True), "C"),
    "move": (lambda: bpy.ops.lamina.layer_move("EXEC_DEFAULT", True, direction="UP"), "B"),
    "duplicate": (lambda: bpy.ops.lamina.layer_duplicate("EXEC_DEFAULT", True), "B 2"),
    "preset": (lambda: bpy.ops.lamina.apply_preset("EXEC_DEFAULT", True, preset="glossy_plastic"), "Plastic"),
}


@pytest.mark.parametrize("change, then", CHANGES.values(), ids=CHANGES)
def test_undo_and_redo_select_what_was_selected(blender, change, then):
    made()
    rows().active_layer = 1  # no undo step, and not in the file
    bpy.ops.ed.undo_push(message="before")

    def selected() -> str:
        lamina = bpy.data.materials["owner"].lamina
        return lamina.layers[lamina.active_layer].name

    assert selected() == "B" and change() == {"FINISHED"} and selected() == then
    bpy.ops.ed.undo()
    assert selected() == "B"
    bpy.ops.ed.redo()
    assert selected() == then


def test_the_ends_and_a_change_that_fails(blender, monkeypatch):
    owner = made()
    owner.lamina.active_layer = 99
    assert owner.lamina.active_layer == 2
    layers.remove_layer(owner, 2)
    assert owner.lamina.active_layer == 1
    monkeypatch.setattr(material, "refresh", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        layers.add_layer(owner, "dielectric", 0)
    assert owner.lamina.active_layer == 1
    monkeypatch.undo()
    for _ in range(2):
        layers.remove_layer(owner, 0)
    assert len(owner.lamina.layers) == 0 and owner.lamina.active_layer == 0
    owner.lamina.active_layer = 3
    assert owner.lamina.active_layer == 0
