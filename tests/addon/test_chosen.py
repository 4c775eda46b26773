# SPDX-License-Identifier: GPL-3.0-or-later
"""Quality and backend of the preferences: every button that makes a material takes them, and nothing else does."""

from types import SimpleNamespace

import pytest

bpy = pytest.importorskip("bpy")

from lamina.addon.exchange import conversion
from lamina.addon.jobs import fitting
from lamina.addon.library import user_presets
from lamina.addon.material import backend, chosen, material
from lamina.addon.material.properties import LaminaMaterial
from lamina.addon.ui.preferences import LaminaPreferences
from lamina.reference_py.material.qualities import DEFAULT_METHOD
from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

STACK = Stack.from_dict({"name": "Coat", "layers": [{"kind": "dielectric"}], "base": {"kind": "lambert"}})
MTLX = """<materialx version="1.39"><open_pbr_surface name="s" type="surfaceshader"><input name="base_color" type="color3" value="0.5, 0.2, 0.1"/>
</open_pbr_surface><surfacematerial name="m" type="material"><input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial></materialx>"""


@pytest.fixture
def item(blender, tmp_path, monkeypatch):
    """An object without a material, and preferences that want stock nodes as a preview."""
    monkeypatch.setenv("LAMINA_PRESETS", str(tmp_path / "own"))
    monkeypatch.setattr(chosen, "own_preferences", lambda: SimpleNamespace(tier="analytic", backend=backend.NODES))
    new = bpy.data.objects.new("thing", bpy.data.meshes.new("mesh"))
    bpy.context.collection.objects.link(new)
    bpy.context.view_layer.objects.active = new
    return new


def _apply_user_preset(_):
    user_presets.save("Mine", STACK, lambda _: None, lambda _: None)
    bpy.ops.lamina.apply_user_preset(name="mine")


def _import_stack(folder):
    STACK.save(folder / "coat.json")
    bpy.ops.lamina.import_stack(filepath=str(folder / "coat.json"))


def _convert(_):
    bpy.context.object.active_material = bpy.data.materials.new("m")
    bpy.context.object.active_material.use_nodes = True
    bpy.ops.lamina.convert_principled()


def _mtlx(folder):
    (folder / "m.mtlx").write_text(MTLX)
    return str(folder / "m.mtlx")


def _fit(_):
    fit = object.__new__(fitting.Fit)
    found = {"stack": STACK.to_dict(), "error": 0.01, "explains": True, "warnings": [], "not_determined": [], "parameters": [], "found": [], "lines": []}
    fit.target, fit.file, fit.is_object, fit.error, fit.result = bpy.context.object.session_uid, "m.binary", True, "", found
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fitting, "_noted", lambda *_: "text")
        fit.apply(bpy.context.scene)


WAYS = {
    "preset": lambda _: bpy.ops.lamina.apply_preset(preset="glossy_plastic"),
    "own preset": _apply_user_preset,
    "new": lambda _: bpy.ops.lamina.new_material(),
    "stack": _import_stack,
    "convert": _convert,
    "MaterialX": lambda folder: bpy.ops.lamina.import_mtlx(filepath=_mtlx(folder)),
    "MaterialX materials": lambda folder: bpy.ops.lamina.import_materials(filepath=_mtlx(folder)),
    "fit": _fit,
}


@pytest.mark.parametrize("way", WAYS)
def test_a_new_material_is_as_the_preferences_say(item, tmp_path, way):
    WAYS[way](tmp_path)
    lamina = item.active_material.lamina
    assert (lamina.tier, lamina.backend) == ("analytic", backend.NODES)


def test_a_layered_material_keeps_its_backend(item, monkeypatch):
    bpy.ops.lamina.new_material()
    monkeypatch.setattr(chosen, "own_preferences", lambda: SimpleNamespace(tier="analytic", backend=backend.AUTO))
    bpy.ops.lamina.apply_preset(preset="glossy_plastic")
    assert item.active_material.lamina.backend == backend.NODES


def test_commands_do_not_ask(item):
    owner = bpy.data.materials.new("m")
    material.apply_stack(owner, STACK)
    other = bpy.data.materials.new("m")
    other.use_nodes = True
    conversion.to_lamina(other)
    assert {(m.lamina.tier, m.lamina.backend) for m in (owner, other)} == {(DEFAULT_METHOD, backend.DEFAULT_BACKEND)}


def test_a_backend_that_is_not_here_is_said_and_nothing_is_made(item, monkeypatch):
    monkeypatch.setattr(chosen, "own_preferences", lambda: SimpleNamespace(tier="analytic", backend=backend.OSL))
    monkeypatch.setattr(backend.environment, "osl_available", lambda: (False, "there is none"))
    count = len(bpy.data.materials)
    with pytest.raises(RuntimeError, match="Lamina's preferences: backend osl needs Cycles with OSL, and there is none"):
        bpy.ops.lamina.apply_preset(preset="glossy_plastic")
    assert len(bpy.data.materials) == count and item.active_material is None


def test_choices_and_defaults_are_one(blender):
    for name in ("tier", "backend"):
        own, of_material = LaminaPreferences.__annotations__[name].keywords, LaminaMaterial.__annotations__[name].keywords
        assert own == {key: value for key, value in of_material.items() if key not in ("options", "update")}
