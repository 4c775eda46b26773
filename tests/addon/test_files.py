# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamina's materials in files: golden files of every schema version, append, link, override, copies, fake users, and what is left without Lamina."""

import json
from pathlib import Path

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from lamina.addon import registration
from lamina.addon.blender.images import read_exr
from lamina.addon.check import check
from lamina.addon.material import layers, material, osl_setting
from lamina.addon.material.elements import node_of
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.material.schema import SCHEMA_VERSION
from lamina.reference_py.material.stack import Stack

pytestmark = pytest.mark.blender

DATA = Path(__file__).parent.parent / "data"
STACK = Stack.from_dict(
    {
        "layers": [{"kind": "dielectric", "name": "Coat", "roughness": 0.1}, {"kind": "dielectric", "name": "Paint", "roughness": 0.5}],
        "base": {"kind": "lambert"},
    }
)


def layered() -> list:
    return [m for m in bpy.data.materials if m.lamina.is_layered]


def picture(path: Path) -> np.ndarray:
    """The open file's scene, rendered."""
    scene = bpy.context.scene
    image = scene.render.image_settings
    image.file_format, image.color_depth = "OPEN_EXR", "32"
    scene.render.filepath, scene.render.use_file_extension = str(path), False
    bpy.ops.render.render(write_still=True)
    channels = read_exr(path).channels
    return np.stack([channels[c] for c in "RGB"], axis=-1)


def findings(each) -> list[str]:
    """What is wrong with a material in this scene."""
    return [f.code for f in check.find(each, bpy.context.scene, bpy.context.preferences) if f.level != check.NOTE]


def sound() -> None:
    """Nothing is wrong with any material of the open file."""
    for each in layered():
        assert findings(each) == []


def assert_of_facts(stack: Stack, facts: dict) -> None:
    """A stack is that of a file, with the mean of the checker in the place of the tint that it is linked to."""
    rows = stack.to_dict()["layers"]
    for row, former in zip(rows, facts["layers"]):
        if row.get("name") == "Glaze":
            assert row["tint"] == pytest.approx([0.5, 0.5, 0.5], abs=0.02)  # of .8 and .2
            row["tint"] = former["tint"]
    assert Stack.from_dict(stack.to_dict() | {"layers": rows}) == Stack.from_dict(facts)


@pytest.mark.parametrize("version", range(1, SCHEMA_VERSION + 1))
def test_a_golden_file_opens_migrates_and_renders_the_same(blender, tmp_path, version):
    facts = json.loads((DATA / f"schema_{version}.json").read_text(encoding="utf-8"))
    bpy.ops.wm.open_mainfile(filepath=str(DATA / f"schema_{version}.blend"))
    assert {m.name for m in layered()} == set(facts["stacks"])
    for each in layered():
        assert material.stack_of(each, hidden=True) == Stack.from_dict(facts["stacks"][each.name])
        assert each.lamina.schema_version == version
        assert findings(each) == (["one_branch"] if version < 3 else [])
    before = picture(tmp_path / "before.exr")
    assert before.max() > 0.2
    for each in layered():
        material.regenerate(each)
    for each in layered():
        assert each.lamina.schema_version == SCHEMA_VERSION
        assert_of_facts(material.stack_of(each, hidden=True), facts["stacks"][each.name])
    sound()
    after = picture(tmp_path / "after.exr")
    apart = np.abs(after - before).max(axis=-1) / before.max()
    # at the balls' rims older shaders read weights at another normal than the one that Cycles bends (osl/bent.h)
    rims = 0.005 if version < 3 else 0.0
    assert np.mean(apart > 1e-4) <= rims and apart.max() <= max(rims, 1e-4)

    coat = bpy.data.materials["coat"]
    assert [e.name for e in coat.lamina.layers if not e.visible] == ["Hidden"]
    clear, _, glaze = coat.lamina.layers
    assert node_of(glaze).inputs["Tint"].links[0].from_node.bl_idname == "ShaderNodeTexChecker"
    bpy.context.scene.frame_set(11)
    assert node_of(clear).inputs["Roughness"].default_value == 0.5
    clear.use_coverage = clear.use_thin_film = True  # what version 1 did not have
    layers.move_layer(coat, 0, 2)
    sound()
    moved = material.stack_of(coat).layers[1]
    assert (moved["coverage"], moved["film_ior"]) == (1.0, pytest.approx(1.33)) and coat.lamina.problem == ""


def test_there_is_a_golden_file_of_this_version():
    """Whoever raises the schema's version writes one, with tests/data/make_golden.py, before it is released."""
    assert (DATA / f"schema_{SCHEMA_VERSION}.blend").exists()


@pytest.fixture
def library(blender, tmp_path) -> str:
    """A file with a layered material "owner" on an object."""
    owner = bpy.data.materials.new("owner")
    item = bpy.data.objects.new("object", bpy.data.meshes.new("mesh"))
    item.data.materials.append(owner)
    material.apply_stack(owner, STACK, "weidlich_wilkie")
    path = str(tmp_path / "library.blend")
    bpy.data.libraries.write(path, {item}, fake_user=True)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    osl_setting.enable_osl(bpy.context.scene)
    return path


def brought(path: str, link: bool):
    with bpy.data.libraries.load(path, link=link) as (_, wanted):
        wanted.materials = ["owner"]
    if link:  # from Blender 5.3 on a linked material that nothing uses can be neither overridden nor made local
        user = bpy.data.objects.new("user", bpy.data.meshes.new("user"))
        user.data.materials.append(wanted.materials[0])
        bpy.context.scene.collection.objects.link(user)
    return wanted.materials[0]


def test_an_appended_material_is_as_if_made_here(library):
    here = bpy.data.materials.new("here")
    material.apply_stack(here, STACK, "weidlich_wilkie")
    first, second = brought(library, link=False), brought(library, link=False)
    assert material.stack_of(first) == material.stack_of(second) == STACK
    layers.move_layer(first, 0, 1)
    layers.add_layer(second, "dielectric", 0)
    node_of(first.lamina.layers[0]).inputs["Roughness"].default_value = 0.9
    sound()
    assert material.stack_of(here) == STACK and [e.name for e in second.lamina.layers] == ["Dielectric", "Coat", "Paint"]
    layers.paste_layers(here, layers.copied_text(first, [0]), 0)
    assert material.stack_of(here).layers[0]["roughness"] == 0.9


def test_a_linked_material_renders_and_becomes_editable_when_local(library):
    linked = brought(library, link=True)
    assert material.stack_of(linked) == STACK
    assert findings(linked) == ["not_editable"]
    with pytest.raises(LaminaError, match="make it local"):
        layers.duplicate_layer(linked, 0)
    local = linked.make_local()
    layers.duplicate_layer(local, 0)
    assert [e.name for e in local.lamina.layers] == ["Coat 2", "Coat", "Paint"]
    sound()


def test_an_override_keeps_its_stack_and_says_what_it_cannot(library):
    override = brought(library, link=True).override_create()
    assert material.stack_of(override) == STACK
    with pytest.raises(LaminaError, match="library override"):
        layers.add_layer(override, "dielectric", 0)
    assert findings(override) == ["not_editable"]


def test_a_copy_shares_nothing_that_can_change(library):
    first = brought(library, link=False)
    second = first.copy()
    layers.remove_layer(second, 0)
    node_of(second.lamina.layers[0]).inputs["Roughness"].default_value = 0.9
    second.lamina.base.name = "Ground"
    assert material.stack_of(first) == STACK
    sound()


def test_a_fake_user_keeps_a_material_and_nothing_else_is_kept(library, tmp_path):
    kept, lost = brought(library, link=False), brought(library, link=False)
    material.apply_stack(lost, Stack.from_dict({"base": {"kind": "oren_nayar"}}), "weidlich_wilkie")
    kept.use_fake_user, lost.use_fake_user = True, False
    name, gone = kept.name, lost.name
    for _ in range(2):  # what only the lost one used is written once more
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "fake.blend"))
        bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "fake.blend"))
    assert gone not in bpy.data.materials and material.stack_of(bpy.data.materials[name]) == STACK
    sound()
    assert len(bpy.data.texts) == 1


def test_disabling_leaves_nothing_behind(registered_lamina, blender):
    handlers = [getattr(bpy.app.handlers, name) for name in dir(bpy.app.handlers) if isinstance(getattr(bpy.app.handlers, name), list)]

    def ours() -> list[str]:
        found = [name for name in dir(bpy.types) if name.lower().startswith("lamina")]
        found += [f.__name__ for each in handlers for f in each if "lamina" in getattr(f, "__module__", "")]
        found += dir(bpy.ops.lamina)
        found += [name for name in ("Material", "Scene", "WindowManager", "Object") if hasattr(getattr(bpy.types, name), "lamina")]
        return found

    before = ours()
    registered_lamina.unregister()
    try:
        assert ours() == []
    finally:
        registered_lamina.register()
    assert sorted(ours()) == sorted(before)
    registered_lamina.unregister()
    registered_lamina.register()
    assert sorted(ours()) == sorted(before) and registration.CLASSES
